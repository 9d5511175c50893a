//! How a filter integrates the angular rate.

use crate::scalar::Scalar;
use crate::so3::{Quat, Vec3, exponential_step, first_order_step};

choice! {
    /// Integration of the angular rate over a step: by the exponential map, exact for a rate that is constant over
    /// the step, or by the first-order step of the papers followed by normalisation.
    pub enum Integration { Exponential = "exponential", FirstOrder = "first-order" }
}

impl Integration {
    /// The attitude after a turn in the sensor frame that is given by its half, ½ω dt.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step<S: Scalar>(self, q: Quat<S>, half_turn: Vec3<S>) -> Quat<S> {
        match self {
            Integration::Exponential => exponential_step(q, half_turn),
            Integration::FirstOrder => first_order_step(q, q * Quat::from_parts(S::zero(), half_turn)),
        }
    }
}
