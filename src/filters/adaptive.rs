//! A gain that falls where the specific force is not gravity alone.

use crate::filter::Sample;
use crate::scalar::{Mask, Scalar};

/// Standard gravity in m/s².
const GRAVITY: f64 = 9.80665;

/// The share that is left of the accelerometer's gain: one where the norm of the specific force differs from gravity by at
/// most the threshold (m/s²), none from twice as much on, linear between: the gain of Valenti et al., Sensors 15(8), 2015,
/// with their thresholds of 0.1 g and 0.2 g as one number. A threshold of zero leaves the gain alone.
///
/// Where no force was measured the share is one.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn trust<S: Scalar>(sample: &Sample<S>, threshold: S) -> S {
    let adapts = S::zero().lt(threshold) & sample.acc.valid;
    if !adapts.any() {
        return S::one();
    }
    let off = (sample.acc.value.norm2().sqrt() - S::of(GRAVITY)).abs();
    let share = (S::of(2.0) - off / threshold).min(S::one()).max(S::zero());
    S::select(adapts, share, S::one())
}
