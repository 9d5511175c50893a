//! Rotations in space: vectors, unit quaternions, the exponential map, Euler angles and earth frames.

mod euler;
mod exp;
mod frame;
#[cfg(feature = "glam")]
mod glam;
mod quat;
mod vec3;

pub use euler::{Euler, euler_rates};
pub use exp::{exp_half, exponential_step, first_order_step, rotate_by};
pub use frame::Frame;
pub use quat::{Matrix3, Quat, half_angle};
pub use vec3::Vec3;
