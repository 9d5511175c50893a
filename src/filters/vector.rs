//! What Mahony's and Madgwick's filters share: the attitude error that the measured directions show.

use crate::filter::Sample;
use crate::scalar::{Mask, Scalar};
use crate::so3::{Matrix3, Vec3};

/// The error a × v̂ + m × m̂ between measured and predicted directions, sensor frame; zero where nothing is measured.
///
/// v̂ is up, m̂ the earth's field with the inclination that is measured now and the heading of the estimate: its
/// horizontal part is put on north, here the y axis.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn direction_error<S: Scalar>(r: Matrix3<S>, sample: &Sample<S>) -> Vec3<S> {
    // A choice is made only where lanes differ: for one recording it is a branch that is nearly always the same.
    let chosen = |valid: S::Mask, e: Vec3<S>| if valid.all() { e } else { Vec3::select(valid, e, Vec3::zero()) };
    let mut error = chosen(sample.acc_valid, sample.acc.unit().cross(r.z));
    if sample.mag_valid.any() {
        let m = sample.mag.unit();
        let h = r.apply(m);
        let north = (h.x * h.x + h.y * h.y).sqrt();
        let predicted = r.transpose_apply_north_up(north, h.z);
        error = error + chosen(sample.mag_valid, m.cross(predicted));
    }
    error
}
