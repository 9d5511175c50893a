//! A magnetometer that is late behind the gyroscope.

use crate::scalar::{Mask, Scalar};
use crate::so3::{Vec3, exp_half};

/// The longest delay in s: over more than that no rate is constant.
pub const LONGEST_DELAY: f64 = 1.0;

/// The field in the present sensor frame, from a reading that shows the field of `delay` s ago.
///
/// With the angular rate ω, R(t) = R(t − τ) exp(ωτ), so that R(t)ᵀ B = exp(−ωτ) R(t − τ)ᵀ B: exp(−ωτ) takes the reading
/// there. The rate counts as constant over the delay; where it changes by α τ the field is ½ α τ² rad off instead of ω τ. A
/// delay of zero gives the reading's own bits; a negative one is a reading that is ahead.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn caught_up<S: Scalar>(field: Vec3<S>, rate: Vec3<S>, delay: S) -> Vec3<S> {
    let late = S::zero().lt(delay.abs());
    if !late.any() {
        return field;
    }
    let turn = exp_half(rate * (S::of(-0.5) * delay));
    Vec3::select(late, turn.rotate(field), field)
}
