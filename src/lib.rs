//! Attitude and heading from gyroscope, accelerometer and magnetometer.
//!
//! # Conventions
//!
//! Quaternions are scalar first, `[w, x, y, z]`, multiply by Hamilton's rules and rotate vectors from the *sensor
//! frame* to the *earth frame*: `v_earth = q ⊗ v_sensor ⊗ q*`. Filters compute in east-north-up; [`Frame`] turns what
//! goes in and out. The gyroscope gives the angular rate in rad/s, the accelerometer the *specific force* in m/s² (a
//! sensor that lies still, z up, reads +9.80665 on z), the magnetometer the field in any unit.
//!
//! # One source
//!
//! Every filter is written once over [`Scalar`] and runs on `f32`, `f64` and [`Pair`]s of independent recordings, with
//! the same bits in each. Nothing allocates, nothing panics, and apart from the (exact) square root no function of the
//! platform is used: see [`trig`].
//!
//! # One sample after the other
//!
//! ```
//! use ahrs_rs::filters::madgwick::{Madgwick, Params};
//! use ahrs_rs::{Estimator, Settings, Vec3};
//!
//! let params = Params { beta: 0.1, ..Params::default() };
//! let mut ahrs = Estimator::<f32, Madgwick<f32>>::new(&params, Settings::default());
//! let gyr = Vec3::new(0.0, 0.0, 0.1); // rad/s
//! let acc = Vec3::new(0.0, 0.0, 9.81); // m/s²
//! let mag = Vec3::new(0.0, 20.0, -43.0); // µT
//! let output = ahrs.step(gyr, Some(acc), Some(mag), 0.01);
//! assert!((output.quat.w - 1.0).abs() < 1e-6);
//! ```
//!
//! # On a microcontroller
//!
//! [`embedded`] has what firmware needs: features, the profile, an update loop, the interface for C.
//!
//! # Speed of the compiler
//!
//! Functions are marked `cfg_attr(not(debug_assertions), inline(always))`: in release builds every operation must be
//! inlined into the step, or lanes do not become vector code; in debug builds, tests included, that would take the
//! compiler minutes for the same bits.
//!
//! # Features
//!
//! `std` (default) and `libm` choose where the square root comes from; one of them is needed. `glam` converts to and
//! from `glam`'s types. No feature changes a result.

#![no_std]

#[cfg(feature = "std")]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("enable the feature `std` or, without a standard library, `libm`: the square root comes from there");

pub mod calibration;
#[doc = include_str!("embedded.md")]
pub mod embedded {}
pub mod estimator;
pub mod filter;
#[macro_use]
pub mod params;
pub mod filters;
mod lanes;
mod scalar;
pub mod signal;
pub mod so3;
pub mod status;
pub mod trig;

pub use calibration::{Calibration, TemperatureCalibration};
pub use estimator::reading::{Measured, Reading};
pub use estimator::{Estimator, GyrHold, Output, Repeated, Settings};
pub use filter::{Filter, FilterSpec, Sample};
pub use lanes::{Pair, PairMask};
pub use scalar::{Mask, Real, Scalar};
pub use so3::{Euler, Frame, Quat, Vec3};
pub use status::Flags;

/// Standard gravity in m/s².
pub const STANDARD_GRAVITY: f64 = 9.80665;
