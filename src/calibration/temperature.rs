//! A calibration that changes with the temperature (Hyyti & Visala 2015, section 3.4).

use super::Calibration;
use crate::scalar::Scalar;
use crate::so3::Vec3;

/// A parameter of each axis as a line over the temperature T in °C: a T + b (eq 17).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<S> {
    /// a, per °C.
    pub slope: Vec3<S>,
    /// b, the value at 0 °C.
    pub at_zero: Vec3<S>,
}

impl<S: Scalar> Linear<S> {
    /// The same line in every lane, rounded to the lane's type.
    pub fn of(slope: [f64; 3], at_zero: [f64; 3]) -> Self {
        Linear { slope: Vec3::of(slope), at_zero: Vec3::of(at_zero) }
    }

    /// a T + b.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn at(&self, temperature: S) -> Vec3<S> {
        self.slope * temperature + self.at_zero
    }
}

/// Gain and bias of each axis as lines over the temperature: 12 numbers a sensor.
///
/// The measurement model of eq 16, x = gain(T) y + bias(T) for each axis, is y = S (x − b) with
/// S = diag(1/gain(T)) and b = bias(T).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemperatureCalibration<S> {
    /// What the sensor shows for one unit of what it measures.
    pub gain: Linear<S>,
    /// What it shows for nothing, in its own unit.
    pub bias: Linear<S>,
}

impl<S: Scalar> TemperatureCalibration<S> {
    /// The calibration at the temperature in °C. Not finite where a gain is zero or the temperature is not known (NaN).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn at(&self, temperature: S) -> Calibration<S> {
        let (zero, one, gain) = (S::zero(), S::one(), self.gain.at(temperature));
        let (x, y, z) = (one / gain.x, one / gain.y, one / gain.z);
        Calibration { matrix: [[x, zero, zero], [zero, y, zero], [zero, zero, z]], offset: self.bias.at(temperature) }
    }

    /// The calibrated reading at the temperature in °C.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(&self, raw: Vec3<S>, temperature: S) -> Vec3<S> {
        self.at(temperature).apply(raw)
    }
}
