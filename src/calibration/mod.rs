//! What firmware applies to the readings of a sensor before a filter sees them. One model everywhere: y = S (x − b).

mod temperature;

pub use temperature::{Linear, TemperatureCalibration};

use crate::scalar::Scalar;
use crate::so3::Vec3;

/// The calibration of a three-axis sensor: y = S (x − b).
///
/// Its fields are public and plain, so that a constant is written down as it was fitted, without a computation at run
/// time; the Python package writes such constants from a fit.
///
/// ```
/// use ahrs_rs::{Calibration, Vec3};
///
/// /// Hard iron of 12 µT on x, an axis y that reads 5 % too little.
/// const MAG: Calibration<f32> = Calibration {
///     matrix: [[1.0, 0.0, 0.0], [0.0, 1.05, 0.0], [0.0, 0.0, 1.0]],
///     offset: Vec3 { x: 12.0, y: 0.0, z: 0.0 },
/// };
/// assert_eq!(MAG.apply(Vec3::new(32.0, 0.0, -43.0)), Vec3::new(20.0, 0.0, -43.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration<S> {
    /// S, row after row: scale factors, soft iron, cross-axis sensitivity.
    pub matrix: [[S; 3]; 3],
    /// b, in the unit of the readings: what the sensor shows where there is nothing to measure.
    pub offset: Vec3<S>,
}

impl<S: Scalar> Calibration<S> {
    /// The calibration that changes nothing.
    pub fn identity() -> Self {
        let (zero, one) = (S::zero(), S::one());
        Calibration { matrix: [[one, zero, zero], [zero, one, zero], [zero, zero, one]], offset: Vec3::zero() }
    }

    /// The same calibration in every lane, rounded to the lane's type.
    pub fn of(matrix: [[f64; 3]; 3], offset: [f64; 3]) -> Self {
        Calibration { matrix: matrix.map(|row| row.map(S::of)), offset: Vec3::of(offset) }
    }

    /// The calibrated reading y = S (x − b). What is missing (NaN) in one axis is missing in all.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(&self, raw: Vec3<S>) -> Vec3<S> {
        let centred = raw - self.offset;
        let [x, y, z] = self.matrix.map(|[x, y, z]| Vec3 { x, y, z }.dot(centred));
        Vec3::new(x, y, z)
    }
}
