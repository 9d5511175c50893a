//! What the rows of the sensors say before any state is known.
//!
//! A filter's step waits for the step before it; what is here does not, and can be computed ahead of it.

use crate::scalar::Scalar;
use crate::so3::Vec3;

/// A measured vector.
///
/// Where `valid` is false the other fields of that lane may hold anything, NaN included, and must not be used.
#[derive(Clone, Copy, Debug)]
pub struct Measured<S: Scalar> {
    /// As measured.
    pub value: Vec3<S>,
    /// Its direction, of unit length.
    pub unit: Vec3<S>,
    /// Where it can be used.
    pub valid: S::Mask,
    /// The time in s that it stands for: that since the last measurement of its sensor. The estimator fills it in.
    pub interval: S,
}

impl<S: Scalar> Measured<S> {
    /// A vector with a NaN, or whose squared norm is zero, subnormal or not finite, is no measurement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(value: Vec3<S>) -> Self {
        Measured { value, unit: value.unit(), valid: value.norm2().is_normal_norm2(), interval: S::zero() }
    }
}

/// The rows of all sensors at one time, in one right-handed sensor frame.
#[derive(Clone, Copy, Debug)]
pub struct Reading<S: Scalar> {
    /// Angular rate in rad/s.
    pub gyr: Vec3<S>,
    /// Its squared norm.
    pub gyr_norm2: S,
    /// Specific force in m/s²; `None` where there is no accelerometer.
    pub acc: Option<Measured<S>>,
    /// Magnetic field in µT; `None` where there is no magnetometer.
    pub mag: Option<Measured<S>>,
}

impl<S: Scalar> Reading<S> {
    /// The rows as measured.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(gyr: Vec3<S>, acc: Option<Vec3<S>>, mag: Option<Vec3<S>>) -> Self {
        Reading { gyr, gyr_norm2: gyr.norm2(), acc: acc.map(Measured::new), mag: mag.map(Measured::new) }
    }
}
