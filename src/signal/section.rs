//! The sections that low-pass filters are made of.

use crate::scalar::Scalar;

/// What one step does in a second-order low-pass section: two integrators in a loop, by the trapezoidal rule.
///
/// The states are written as increments: in `f32` they neither lose the signal beside their own size nor stall, where the
/// direct form is unusable at high rates.
#[derive(Clone, Copy, Debug)]
pub struct Section<S> {
    /// 2 a2, 2 (1 − a1) and 2 a3, with a1 = 1/(1 + g (g + k)), a2 = g a1, a3 = g a2.
    forward: S,
    back: S,
    direct: S,
}

impl<S: Scalar> Section<S> {
    /// A section in which nothing moves.
    pub fn still() -> Self {
        Section { forward: S::zero(), back: S::zero(), direct: S::zero() }
    }
    /// With g = tan(π f dt) of the cut-off frequency f, and the damping k (2 cos θ of a pair of poles at the angle θ from
    /// the negative axis; √2 for the Butterworth filter of second order).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(g: S, damping: S) -> Self {
        let h = g * (g + damping);
        let a1 = S::one() / (S::one() + h);
        let double = S::of(2.0);
        let forward = double * (g * a1);
        Section { forward, back: double * (h * a1), direct: g * forward }
    }
    /// By how much the slope and the value change in a step with the input x.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn changes(&self, slope: S, value: S, x: S) -> (S, S) {
        let ahead = x - value;
        (self.forward * ahead - self.back * slope, self.forward * slope + self.direct * ahead)
    }
}
