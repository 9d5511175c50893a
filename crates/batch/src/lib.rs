//! Whole recordings through the filters of [`ahrs_rs`]: every registered filter behind one type, on all cores.
//!
//! - [`registry`]: the filters by name, each as a [`Stream`] of `f32` or `f64`, and in lanes;
//! - [`isa`]: the vector instructions that are used;
//! - [`offline`]: filters that take a whole recording, and their registry;
//! - [`recording`]: arrays in, arrays out, cut into tiles;
//! - [`lanes`]: several recordings or parameter sets side by side in vector registers;
//! - [`threads`]: many recordings at once;
//! - [`sweep`]: the errors of many parameter sets against a reference.

pub mod isa;
pub mod lanes;
pub mod offline;
pub mod recording;
pub mod registry;
mod stage;
pub mod sweep;
#[cfg(test)]
mod tests;
pub mod threads;

pub use ahrs_rs_lanes::simd::Isa;
pub use ahrs_rs_lanes::stream::{Stream, Tile};
pub use ahrs_rs_lanes::{metric, simd};
pub use offline::{OFFLINE, Offline, OfflineEntry, offline_entry};
pub use recording::{Outputs, Recording, Time};
pub use registry::{ENTRIES, Entry, Number, entry};
