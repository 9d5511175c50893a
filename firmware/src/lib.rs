//! What runs on the microcontroller and, the same source, on the host: a recording made of whole-number arithmetic and the
//! core's own functions, the way of a sample from the sensor to the attitude, and the hash over all that comes out.

#![no_std]

pub mod pipeline;
pub mod recording;
pub mod replay;
pub mod stack;
#[cfg(target_os = "none")]
pub mod target;
