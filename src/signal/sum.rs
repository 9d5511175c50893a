//! A sum of many small terms.

use crate::scalar::{Real, Scalar};

/// A sum that keeps what rounding takes from it (Kahan): many small terms neither stall nor drift, in `f32` either.
#[derive(Clone, Copy, Debug)]
pub struct Sum<S> {
    /// The sum, rounded.
    pub value: S,
    /// What the rounding has taken away.
    lost: S,
}

impl<S: Scalar> Sum<S> {
    /// The sum of one term.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(value: S) -> Self {
        Sum { value, lost: S::zero() }
    }
    /// The sum with another term.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn plus(self, term: S) -> Self {
        let term = term + self.lost;
        let value = self.value + term;
        Sum { value, lost: term - (value - self.value) }
    }
    /// The sum with its rounded value replaced by one that is close to it, as by a limit.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn with_value(self, value: S) -> Self {
        Sum { value, ..self }
    }
    /// The sum, or zero where it is larger than `limit` or has lost more than rounding takes there: in a state that came from
    /// outside anything may stand.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn or_zero_beyond(self, limit: S) -> Self {
        let rounding = limit * S::of(4.0) * S::splat(S::Real::EPSILON);
        let right = self.value.abs().le(limit) & self.lost.abs().le(rounding);
        Sum::select(right, self, Sum::new(S::zero()))
    }
    /// `yes` where the mask is true, else `no`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Sum { value: S::select(mask, yes.value, no.value), lost: S::select(mask, yes.lost, no.lost) }
    }
    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.value);
        visit(&mut self.lost);
    }
}
