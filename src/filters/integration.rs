//! How a filter integrates the angular rate.

use crate::scalar::Scalar;
use crate::so3::{Quat, Vec3, first_order_step, rotate_by};

choice! {
    /// Integration of the angular rate over a step: by the exponential map, exact for a rate that is constant over
    /// the step, or by the first-order step of the papers followed by normalisation.
    pub enum Integration { Exponential = "exponential", FirstOrder = "first-order" }
}

impl Integration {
    /// The attitude after turning for `dt` at the angular rate (sensor frame, rad/s).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step<S: Scalar>(self, q: Quat<S>, rate: Vec3<S>, dt: S) -> Quat<S> {
        match self {
            Integration::Exponential => rotate_by(q, rate, dt),
            Integration::FirstOrder => first_order_step(q, half_product(q, rate), dt),
        }
    }
}

/// The derivative of the attitude, ½ q ⊗ (0, ω).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn half_product<S: Scalar>(q: Quat<S>, rate: Vec3<S>) -> Quat<S> {
    q * Quat::from_parts(S::zero(), rate * S::of(0.5))
}
