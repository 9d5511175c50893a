//! What Mahony's and Madgwick's filters share: the attitude error that the measured directions show.

use crate::filter::{Sample, Weights};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Matrix3, Vec3};

/// The error a × v̂ + m × m̂ between measured and predicted directions; zero where nothing is measured.
#[derive(Clone, Copy, Debug)]
pub struct DirectionError<S> {
    /// Seen from the sensor.
    pub sensor: Vec3<S>,
    /// Its squared norm, or that of the error with the whole of the accelerometer's part, if that is larger.
    pub norm2: S,
}

/// The error between the measured directions and those that the attitude `r` predicts, each with its weight: up for the specific
/// force, of which a `share` counts, and the earth's field with the inclination that is measured now and the heading of the estimate, its
/// horizontal part on north, here the y axis.
///
/// It is computed in the earth frame, where the predicted directions (0, 0, 1) and (0, n, h_z) make most products
/// vanish, and where its norm is known while it is still on its way to the sensor frame.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn direction_error<S: Scalar>(
    r: Matrix3<S>,
    sample: &Sample<S>,
    share: S,
    weights: &Weights<S>,
) -> DirectionError<S> {
    // A choice is made only where lanes differ: for one recording it is a branch that is nearly always the same.
    let a = sample.acc.unit;
    let mut whole = Vec3::new(r.y.dot(a), -r.x.dot(a), S::zero());
    if !sample.acc.valid.all() {
        whole = Vec3::select(sample.acc.valid, whole, Vec3::zero());
    }
    let weighs = (weights.acc.lt(S::one()) | weights.mag.lt(S::one())).any();
    if weighs {
        whole = whole * weights.acc;
    }
    let counts_whole = S::one().le(share).all();
    let mut earth = if counts_whole { whole } else { whole * share };
    if sample.mag.valid.any() {
        let h = r.apply(sample.mag.unit);
        let north = (h.x * h.x + h.y * h.y).sqrt();
        let field = Vec3::new(h.z * (h.y - north), -(h.x * h.z), h.x * north);
        let field = if sample.mag.valid.all() { field } else { Vec3::select(sample.mag.valid, field, Vec3::zero()) };
        let field = if weighs { field * weights.mag } else { field };
        whole = whole + field;
        earth = earth + field;
    }
    let norm2 = earth.norm2();
    DirectionError {
        sensor: r.transpose_apply(earth),
        norm2: if counts_whole { norm2 } else { norm2.max(whole.norm2()) },
    }
}
