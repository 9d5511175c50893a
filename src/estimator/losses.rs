//! How much of a step's rotation is not known.
//!
//! A gyroscope's row may be missing or at the end of its range, or the step longer than usual because rows are lost or the clock
//! leapt. The rate was anything that the sensor may do then: its deviation from the rate that is held instead is some part of the
//! largest rate seen so far, and it takes a while to change. So over a loss of τ s the rotation has a standard deviation of
//! σ_ω τ min(1, τ/2T).

use crate::scalar::{Mask, Scalar};
use crate::so3::Vec3;

/// A step is a gap where it is longer than this many of the longest steps that are usual.
const GAP: f64 = 4.0;
/// How fast the longest usual step becomes shorter, for each step.
const SHORTENING: f64 = 1.0 - 1.0 / 64.0;
/// The deviation σ_ω of an unknown rate: this part of the largest one seen so far, and at least that of a hand that turns the
/// sensor, in rad/s.
const PART_OF_RANGE: f64 = 0.5;
const LEAST_RATE: f64 = 2.0;
/// The largest rate in rad/s that a gyroscope shows: what is beyond counts as this much.
const LARGEST_RATE: f64 = 100.0;
/// The time T in s that a rate lasts.
const RATE_TIME: f64 = 0.2;
/// A loss counts where the standard deviation of its rotation is above this many rad (1°).
const COUNTING: f64 = 0.017453292519943295;
/// A reading counts as at the end of the range from this part of it on.
const AT_RANGE: f64 = 0.995;

/// What the recording has shown of steps and rates, and the loss that is going on.
#[derive(Clone, Debug)]
pub struct Losses<S> {
    /// The longest usual step in s; zero before the first one.
    longest: S,
    /// The largest rate that the gyroscope's axes show; zero where it is not known.
    gyr_range: S,
    /// True where it is known in any lane.
    has_range: bool,
    /// The largest angular rate squared.
    range2: S,
    /// How long the loss goes on, in s, and the variance in rad² that it has left so far.
    time: S,
    variance: S,
    /// True where no loss goes on in any lane.
    idle: bool,
}

/// What a step loses.
#[derive(Clone, Copy, Debug)]
pub struct Loss<S: Scalar> {
    /// Where the step was much longer than usual.
    pub gap: S::Mask,
    /// Where something is lost.
    pub lost: S::Mask,
    /// The variance in rad², about each axis, of the rotation that this step adds.
    pub added: S,
    /// That of the whole loss so far.
    pub total: S,
}

impl<S: Scalar> Loss<S> {
    /// Where it is so large by now that the attitude has to be found again.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn counts(&self) -> S::Mask {
        self.lost & S::of(COUNTING * COUNTING).le(self.total)
    }
}

impl<S: Scalar> Default for Losses<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Losses<S> {
    /// Before the first step.
    pub fn new() -> Self {
        let o = S::zero();
        Losses { longest: o, gyr_range: o, has_range: false, range2: o, time: o, variance: o, idle: true }
    }

    /// The same with the largest rate in rad/s that an axis of the gyroscope shows.
    #[must_use]
    pub fn with_gyr_range(self, gyr_range: S) -> Self {
        Losses { gyr_range, has_range: S::zero().lt(gyr_range).any(), ..self }
    }

    /// Where a rate is within the gyroscope's range.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_within_range(&self, rate: Vec3<S>) -> S::Mask {
        if self.has_range { within_range(rate, self.gyr_range) } else { S::Mask::splat(true) }
    }

    /// The longest usual step in s; zero before the first one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn longest(&self) -> S {
        self.longest
    }

    /// Where a step is much longer than usual.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_gap(&self, dt: S) -> S::Mask {
        S::zero().lt(self.longest) & (S::of(GAP) * self.longest).lt(dt)
    }

    /// True where no loss goes on in any lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_idle(&self) -> bool {
        self.idle
    }

    /// Goes on by a step that loses nothing, and is none after a loss, in any lane; its rate has the squared norm `rate2`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn pass(&mut self, rate2: S, dt: S) {
        // In this order a NaN leaves the largest rate as it is.
        self.range2 = rate2.max(self.range2);
        if (self.longest.le(dt) & dt.le(self.longest)).all() {
            return;
        }
        let moves = S::zero().lt(dt);
        self.longest = S::select(moves, dt.max(self.longest * S::of(SHORTENING)), self.longest);
    }

    /// Goes on by a step whose rate of squared norm `rate2` is `known` or not.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn lose(&mut self, known: S::Mask, rate2: S, dt: S) -> Loss<S> {
        let range2 = rate2.max(self.range2);
        let gap = self.is_gap(dt);
        let moves = S::zero().lt(dt);
        let longer = dt.max(self.longest * S::of(SHORTENING));
        self.range2 = S::select(known, range2, self.range2);
        let zero = S::zero();
        let beyond = S::select(gap & known, dt - self.longest, zero);
        let lost_time = S::select(known, beyond, dt);
        let lost = zero.lt(lost_time);
        // A rate that became slower is the usual one after a few steps.
        let longer = S::select(gap, self.longest + self.longest, longer);
        self.longest = S::select(moves, longer, self.longest);

        self.time = S::select(lost, self.time + lost_time, zero);
        let limit2 = S::of(LARGEST_RATE * LARGEST_RATE);
        let sigma2 =
            (S::of(PART_OF_RANGE * PART_OF_RANGE) * self.range2.min(limit2)).max(S::of(LEAST_RATE * LEAST_RATE));
        let angle = self.time * (self.time * S::of(0.5 / RATE_TIME)).min(S::one());
        let total = S::select(lost, sigma2 * (angle * angle), zero);
        let added = S::select(lost, (total - self.variance).max(zero), zero);
        self.variance = total;
        self.idle = !zero.lt(self.time).any();
        Loss { gap, lost, added, total }
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        // No more of it counts; a state holds no number whose square is beyond the range of the scalar.
        self.range2 = self.range2.min(S::of(LARGEST_RATE * LARGEST_RATE));
        for variable in [&mut self.longest, &mut self.range2, &mut self.time, &mut self.variance] {
            visit(variable);
        }
        self.idle = false;
    }
}

/// Where no component of an angular rate is at the end of the range; everywhere where the range is zero, that is, not known.
#[cfg_attr(not(debug_assertions), inline(always))]
fn within_range<S: Scalar>(rate: Vec3<S>, range: S) -> S::Mask {
    let limit = S::of(AT_RANGE) * range;
    range.le(S::zero()) | (rate.x.abs().lt(limit) & rate.y.abs().lt(limit) & rate.z.abs().lt(limit))
}
