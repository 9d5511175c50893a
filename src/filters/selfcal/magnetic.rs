//! The magnetometer's reference: its unit, the field at the start, and how much the field of a block counts.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::Params;
use super::state::{HORIZONTAL, State, TURN, VERTICAL, initial_variance, within};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3};
use crate::trig::one_minus_exp;

/// The time constant in s of the mean deviation of the field.
const DEVIATION_TIME: f64 = 0.25;
/// How much the deviation of the heading counts.
pub const HEADING_SHARE: f64 = 0.1;
/// The deviation in norms of the field where it stops counting.
pub const LARGEST_DEVIATION: f64 = 16.0;
/// The time constant in s of the mean field at the start.
const START_TIME: f64 = 1.0;
/// The start is over where the inclination is known to this many rad, and after so many s.
pub const SETTLED: f64 = 0.05;
const LONGEST_START: f64 = 10.0;
/// A weight below this counts as rejection.
pub const REJECTING_WEIGHT: f64 = 0.25;
/// A field of a weight below this is not used.
pub const SMALLEST_WEIGHT: f64 = 1e-4;
/// The time constant in s of a candidate for a new reference, how many tolerances it may change by, and the angular rate in
/// rad/s from which on it is tried.
const CANDIDATE_TIME: f64 = 5.0;
const CANDIDATE_TOLERANCE: f64 = 2.0;
const TURNING_RATE: f64 = 0.35;
/// A field of one place is the new reference after this share of the time that it takes at most.
const SHORTEST_NEW_TIME: f64 = 0.25;

/// The weight of a field that deviates by r, (1 + (r/s)²/ν)⁻².
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn weight<S: Scalar>(deviation: S, tolerance: S, tail: S) -> S {
    let r = deviation / tolerance;
    let growth = S::one() + r * r / tail;
    S::one() / (growth * growth)
}

/// What is known of the magnetometer beside the states.
#[derive(Clone, Debug)]
pub struct Reference<S> {
    /// One over the field's norm in the magnetometer's unit; zero before the first sample.
    pub scale: S,
    /// The time since the last block with a field.
    pub interval: S,
    /// Zero while the start goes on, and its time.
    settled: S,
    age: S,
    /// The mean field of the start, and the weight that it is of.
    sum: Vec3<S>,
    count: S,
    /// The deviation of the field, low-pass filtered.
    deviation: S,
    /// The weight of the last block.
    pub weight: S,
    /// A field (earth frame) that may be a new reference, and how long it has been the same while the sensor turned.
    candidate: Vec3<S>,
    turned: S,
    /// How long the reference has been seen while the sensor turned.
    confirmed: S,
}

impl<S: Scalar> Default for Reference<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Reference<S> {
    /// Before the first sample.
    pub fn new() -> Self {
        let o = S::zero();
        Reference {
            scale: o,
            interval: o,
            settled: o,
            age: o,
            sum: Vec3::zero(),
            count: o,
            deviation: o,
            weight: S::one(),
            candidate: Vec3::zero(),
            turned: o,
            confirmed: o,
        }
    }

    /// The field in norms of the first one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn scaled(&mut self, lanes: S::Mask, field: Vec3<S>) -> Vec3<S> {
        let first = lanes & self.scale.le(S::zero());
        if first.any() {
            self.scale = S::select(first, S::one() / field.norm2().sqrt(), self.scale);
        }
        field * self.scale
    }

    /// Where the last block's field counted little.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rejects(&self) -> S::Mask {
        self.weight.lt(S::of(REJECTING_WEIGHT))
    }

    /// After how long a field of one place is the new reference: after as long as the present one was seen.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn new_time(&self, longest: S) -> S {
        self.confirmed.max(S::of(SHORTEST_NEW_TIME) * longest)
    }

    /// Where the field that counts little has been that of one place for half the time after which it is the new reference.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn recovers(&self, longest: S) -> S::Mask {
        (S::of(0.5) * self.new_time(longest)).lt(self.turned)
    }

    /// Turns what is known of the start's field.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turn(&mut self, lanes: S::Mask, turn: Quat<S>) {
        self.sum = Vec3::select(lanes, turn.rotate(self.sum), self.sum);
    }

    /// While the inclination is not known yet, the reference and the heading are those of the mean field. Gives where that
    /// is over.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn settle(
        &mut self,
        lanes: S::Mask,
        state: &mut State<S>,
        field: Vec3<S>,
        dt: S,
        params: &Params<S>,
    ) -> S::Mask {
        let done = S::of(0.5).lt(self.settled);
        let going = lanes & !done;
        if going.any() {
            let kept = S::one() - one_minus_exp(dt * S::of(1.0 / START_TIME));
            let sum = self.sum * kept + field;
            let count = self.count * kept + S::one();
            let mean = sum * (S::one() / count);
            let across = (mean.x * mean.x + mean.y * mean.y).sqrt();
            let turns = going & S::of(1e-6).lt(across);
            let turn = Quat::turn_to_north(mean.x, mean.y, across);
            state.turn(turns, turn);
            let sum = Vec3::select(turns, turn.rotate(sum), sum);
            for (i, value) in [(HORIZONTAL, across), (VERTICAL, mean.z)] {
                let i = within(i);
                state.mean[i] = S::select(going, value, state.mean[i]);
                state.forget(going, i, initial_variance(params, i));
            }
            state.forget(turns, TURN, initial_variance(params, TURN));
            self.sum = Vec3::select(going, sum, self.sum);
            self.count = S::select(going, count, self.count);
            self.age = S::select(going, self.age + dt, self.age);
            let over = state.tilt_variance().lt(S::of(SETTLED * SETTLED)) | S::of(LONGEST_START).lt(self.age);
            self.settled = S::select(going & over, S::one(), self.settled);
        }
        lanes & done
    }

    /// The weight of a field with a deviation, and where it is used.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn weigh(&mut self, lanes: S::Mask, deviation2: S, dt: S, params: &Params<S>) -> (S, S::Mask) {
        let now = deviation2.sqrt().min(S::of(LARGEST_DEVIATION));
        let mean = self.deviation + one_minus_exp(dt * S::of(1.0 / DEVIATION_TIME)) * (now - self.deviation);
        self.deviation = S::select(lanes, mean, self.deviation);
        let weight = weight(now.max(mean), params.mag_tolerance, params.mag_tail);
        self.weight = S::select(lanes, weight, self.weight);
        (weight, lanes & S::of(SMALLEST_WEIGHT).lt(weight))
    }

    /// A field that is not the reference's, but that of one place (the same while the sensor turns for long), is the new one.
    /// Gives where it has been taken over: what was known of the heading is void there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn renew(
        &mut self,
        lanes: S::Mask,
        state: &mut State<S>,
        measured: Vec3<S>,
        (dt, rate2): (S, S),
        params: &Params<S>,
    ) -> S::Mask {
        let rejects = self.rejects();
        let strange = lanes & rejects;
        let near = S::of(CANDIDATE_TOLERANCE) * params.mag_tolerance;
        let same = (measured - self.candidate).norm2().lt(near * near * self.candidate.norm2());
        let turning = S::of(TURNING_RATE * TURNING_RATE).lt(rate2);
        let longest = params.mag_new_time;
        let longer = |time: S| S::select(turning, (time + dt).min(longest), time);
        let turned = S::select(strange & same, longer(self.turned), S::zero());
        let needed = self.new_time(longest);
        self.confirmed = S::select(lanes & !rejects, longer(self.confirmed), self.confirmed);
        self.turned = S::select(lanes, turned, self.turned);
        let gain = one_minus_exp(dt * S::of(1.0 / CANDIDATE_TIME));
        let moved = self.candidate + (measured - self.candidate) * gain;
        self.candidate = Vec3::select(lanes, Vec3::select(same, moved, measured), self.candidate);
        let renewed = strange & needed.le(turned);
        if renewed.any() {
            let Vec3 { x, y, z } = self.candidate;
            let across = (x * x + y * y).sqrt();
            state.turn(renewed & S::of(1e-6).lt(across), Quat::turn_to_north(x, y, across));
            for (i, value) in [(HORIZONTAL, across), (VERTICAL, z)] {
                let i = within(i);
                state.mean[i] = S::select(renewed, value, state.mean[i]);
                state.forget(renewed, i, initial_variance(params, i));
            }
            state.forget(renewed, TURN, initial_variance(params, TURN));
            self.confirmed = S::select(renewed, turned, self.confirmed);
            self.turned = S::select(renewed, S::zero(), self.turned);
            self.deviation = S::select(renewed, S::zero(), self.deviation);
            self.weight = S::select(renewed, S::one(), self.weight);
        }
        renewed
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.sum.each(visit);
        self.candidate.each(visit);
        let Reference { scale, interval, settled, age, count, deviation, weight, turned, confirmed, .. } = self;
        for variable in [scale, interval, settled, age, count, deviation, weight, turned, confirmed] {
            visit(variable);
        }
    }
}
