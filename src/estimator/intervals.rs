//! The time that a measurement of a sensor stands for.

use super::LONGEST_STEP;
use crate::scalar::{Mask, Scalar};

/// An interval that is longer than this many usual ones is an outage, for which one measurement does not stand.
const OUTAGE: f64 = 4.0;
/// How fast the usual interval becomes shorter, for each measurement.
const SHORTENING: f64 = 1.0 - 1.0 / 64.0;
/// The longest time in s that one measurement stands for.
const LONGEST: f64 = 1.0;

/// A sensor that may be slower than the gyroscope, or miss some samples.
#[derive(Clone, Debug)]
pub struct Interval<S> {
    /// The time since the last measurement, without the step that is going on; negative before the first one.
    waited: S,
    /// The usual interval: zero for a sensor that is as fast as the gyroscope; negative before it is known.
    usual: S,
    /// True where every lane has been as fast as the gyroscope in the last two samples: nothing has to be counted then.
    prompt: bool,
}

impl<S: Scalar> Default for Interval<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Interval<S> {
    /// Before the first measurement.
    pub fn new() -> Self {
        Interval { waited: -S::one(), usual: -S::one(), prompt: false }
    }

    /// Goes on by the step `dt` to a measurement where the mask is true; `longest` is the longest usual step. Gives the time that
    /// the measurement stands for: that since the last one; for the first one the step, after an outage a usual interval.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(&mut self, lanes: S::Mask, dt: S, longest: S) -> S {
        if self.prompt && lanes.all() {
            return dt;
        }
        let zero = S::zero();
        let known = zero.le(self.waited);
        let prompt = lanes & !self.has_waited();
        let interval = (self.waited.max(zero) + dt).min(S::of(LONGEST_STEP));
        let usual = self.usual.max(longest).max(dt);
        let first = self.usual.lt(zero);
        let outage = !first & (S::of(OUTAGE) * usual).lt(interval);
        let shown = S::select(outage, usual, S::select(known, interval, dt));
        // A sensor that became slower is the usual one after a few measurements.
        let longer = S::select(outage, usual + usual, interval.max(self.usual * S::of(SHORTENING)));
        let late = S::select(first, interval, longer);
        let now = S::select(lanes & known, late, self.usual);
        self.usual = S::select(prompt, self.usual.max(zero), now);
        self.waited = S::select(lanes, zero, S::select(known, interval, self.waited));
        self.prompt = !self.has_waited().any() && zero.le(self.usual).all();
        shown.min(S::of(LONGEST).max(dt))
    }

    /// Where the last sample was not measured, or none was.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn has_waited(&self) -> S::Mask {
        S::zero().lt(self.waited.abs())
    }

    /// True where the next measurement, if no lane misses it, stands for the step in every lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_prompt(&self) -> bool {
        self.prompt
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.waited);
        visit(&mut self.usual);
        self.prompt = false;
    }
}
