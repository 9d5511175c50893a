//! The time between two measurements of a sensor that may miss some.

use crate::estimator::LONGEST_STEP;
use crate::scalar::{Mask, Scalar};

/// The time since a sensor's last measurement.
#[derive(Clone, Debug)]
pub struct Interval<S> {
    /// In s, without the step that is going on.
    waited: S,
    /// One where a measurement has come, else zero.
    known: S,
}

impl<S: Scalar> Default for Interval<S> {
    /// Before the first measurement.
    fn default() -> Self {
        Interval { waited: S::zero(), known: S::zero() }
    }
}

impl<S: Scalar> Interval<S> {
    /// Goes on by the step `dt` to a measurement where the mask is true, and gives the time that it stands for: that since
    /// the last one; for the first one the step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(&mut self, lanes: S::Mask, dt: S) -> S {
        let interval = (self.waited + dt).min(S::of(LONGEST_STEP));
        if lanes.all() {
            (self.waited, self.known) = (S::zero(), S::one());
        } else {
            self.known = S::select(lanes, S::one(), self.known);
            let waits = !lanes & S::zero().lt(self.known);
            self.waited = S::select(waits, interval, S::zero());
        }
        interval
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.waited);
        visit(&mut self.known);
    }
}
