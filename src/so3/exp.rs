//! The exponential map and the step that integrates an angular rate.

use core::f64::consts::FRAC_PI_4;

use super::{Quat, Vec3};
use crate::scalar::{Mask, Real, Scalar};
use crate::trig::{sin_cos, sinc_cos_kernel};

/// The unit quaternion exp(v) = (cos |v|, v·sin |v|/|v|): the rotation by 2|v| about v.
///
/// Within (5 + |v|) ε for every v with |v| up to [`Real::ANGLE_RANGE`]; beyond it, and for NaN, the identity.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn exp_half<S: Scalar>(v: Vec3<S>) -> Quat<S> {
    let angle2 = v.norm2();
    // Up to a quarter turn a step (|v| ≤ π/4) two polynomials in |v|² need neither a root nor a division.
    let small = angle2.le(S::of(FRAC_PI_4 * FRAC_PI_4));
    let (sinc, cos) = sinc_cos_kernel(angle2);
    if small.all() {
        return Quat::from_parts(cos, v * sinc);
    }
    let range = S::of(S::Real::ANGLE_RANGE);
    let in_range = angle2.le(range * range);
    let angle = angle2.sqrt();
    let (wide_sin, wide_cos) = sin_cos(angle);
    let sinc = S::select(small, sinc, wide_sin / angle);
    let cos = S::select(small, cos, wide_cos);
    Quat::select(in_range, Quat::from_parts(cos, v * sinc), Quat::identity())
}

/// The attitude after turning for `dt` at a constant angular rate (sensor frame, rad/s): q ⊗ exp(½ω dt), the exact
/// solution of q̇ = ½ q ⊗ ω.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn rotate_by<S: Scalar>(q: Quat<S>, rate: Vec3<S>, dt: S) -> Quat<S> {
    exponential_step(q, rate * (S::of(0.5) * dt))
}

/// The attitude after a turn in the sensor frame that is given by its half, ½ω dt: q ⊗ exp(½ω dt).
///
/// The norm is mended before the product, where the processor can do it while it waits for the exponential; the
/// product's own rounding, some units in the last place, stays until the next step.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn exponential_step<S: Scalar>(q: Quat<S>, half_turn: Vec3<S>) -> Quat<S> {
    q.renormalized() * exp_half(half_turn)
}

/// The attitude after a first-order step by the `change` q̇ dt, normalised.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn first_order_step<S: Scalar>(q: Quat<S>, change: Quat<S>) -> Quat<S> {
    q.plus(change).unit_or(q)
}
