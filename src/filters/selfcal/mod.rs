//! A Kalman filter that calibrates its sensors while it runs: gyroscope (bias and matrix), magnetometer (delay and hard
//! iron), accelerometer (bias), and a field that wanders.
//!
//! Samples turn the attitude; what they say of the rest is summed over blocks of 0.1 s ([`block`]), by which the covariance
//! is carried on ([`prediction`]) and corrected ([`measurement`]). [`state`] has the order of the states, [`magnetic`] the
//! reference field and how much a field counts.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

pub mod block;
pub mod clipping;
pub mod level;
pub mod magnetic;
pub mod measurement;
pub mod prediction;
pub mod state;

use self::block::{Block, LONGEST_INTERVAL, Steps, bounded_rate};
use self::clipping::Clipping;
use self::level::Level;
use self::magnetic::{HEADING_SHARE, Reference};
use self::measurement::{Row, Seen, correct};
use self::prediction::Transition;
use self::state::{DELAY, HORIZONTAL, MATRIX, State, THETA, TURN, VELOCITY, VERTICAL, initial_variance, within};
use super::kalman::{Square, block as part, congruent, new_vertical, put_rows, reported, rows, transposed};
use super::rest::{Rest, Thresholds};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3, exp_half};
use crate::status::Flags;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "SelfCalKF",
    doc: "An error-state Kalman filter that calibrates the sensors while it runs: bias and 3×3 matrix of the gyroscope, \
          bias of the accelerometer, hard iron and delay of the magnetometer. The local field may wander in a \
          correlated way; the velocity, which is never far from zero for long, shows the inclination; the magnetometer \
          never moves it.",
    source: "this project, docs/selfcal.md",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[
        OutputSpec {
            name: "covariance",
            doc: "covariance of the attitude error in the sensor frame, rad²; π²/3 about the vertical until a \
                  magnetometer sample has been used",
            shape: &[3, 3],
        },
        OutputSpec {
            name: "gyr_matrix",
            doc: "matrix M of the gyroscope: the angular rate is (I + M)(ω − b)",
            shape: &[3, 3],
        },
        OutputSpec { name: "mag_delay", doc: "delay of the magnetometer behind the gyroscope, s", shape: &[] },
        OutputSpec { name: "mag_delay_sigma", doc: "standard deviation of that delay, s", shape: &[] },
        OutputSpec {
            name: "hard_iron",
            doc: "field of the sensor's own, sensor frame, unit of the magnetometer",
            shape: &[3],
        },
        OutputSpec {
            name: "disturbance",
            doc: "disturbance of the field where the sensor is, east, north and up, unit of the magnetometer",
            shape: &[3],
        },
        OutputSpec { name: "mag_weight", doc: "weight of the last field, 0 to 1", shape: &[] },
        OutputSpec {
            name: "mag_reference",
            doc: "horizontal and upward part of the reference field, unit of the magnetometer; zeros until it is known",
            shape: &[2],
        },
    ],
};

params! {
    /// Noise density of the gyroscope (angle random walk).
    real gyr_noise: "rad/s/√Hz" = 3e-4 in [1e-9, 1e3];
    /// Noise density of the gyroscope for each rad/s that it turns.
    real rate_noise: "1/√Hz" = 7e-4 in [0.0, 1e3];
    /// The largest rate that an axis of the gyroscope shows; 0 where it is not known, and found where readings stand still.
    real gyr_range: "rad/s" = 0.0 in [0.0, 1e3];
    /// Noise density of the bias' rate (rate random walk).
    real bias_noise: "rad/s²/√Hz" = 5e-5 in [0.0, 1e3];
    /// Standard deviation of the velocity.
    real velocity: "m/s" = 0.3 in [1e-6, 1e3];
    /// The time for which a velocity lasts.
    real velocity_time: "s" = 0.5 in [1e-3, 1e3];
    /// Noise density of the accelerometer.
    real velocity_noise: "m/s²/√Hz" = 0.01 in [1e-6, 1e3];
    /// Noise density of a component of the magnetometer, in norms of the field.
    real mag_noise: "1/√Hz" = 0.04 in [1e-6, 1e3];
    /// How much it grows for each rad/s that the sensor turns.
    real mag_rate_noise: "s/rad/√Hz" = 7e-4 in [0.0, 1e3];
    /// Deviation of the field from its reference, in its norms, at which it begins to count less (1e9: every
    /// field counts alike).
    real mag_tolerance: "1" = 0.09 in [1e-6, 1e9];
    /// How slowly it does: the weight is (1 + (deviation/tolerance)²/tail)⁻².
    real mag_tail: "1" = 1.7 in [1e-3, 1e6];
    /// Time of movement after which a field that is not the reference's, but the same all the time, is the new reference. A
    /// reference that has been seen for less time itself is given up after that time, and after a quarter of this at the
    /// earliest.
    real mag_new_time: "s" = 20.0 in [0.0, 1e6];
    /// Standard deviation of the field's disturbance, in norms of the field. Here and in all that follows, 0 takes the state
    /// out of the estimate.
    real disturbance: "1" = 0.018 in [0.0, 1e3];
    /// The time for which a disturbance lasts.
    real disturbance_time: "s" = 8.0 in [1e-3, 1e6];
    /// How fast the hard iron wanders, in norms of the field.
    real hard_iron_noise: "1/√s" = 1e-3 in [0.0, 1e3];
    /// The largest standard deviation of the hard iron.
    real largest_hard_iron: "1" = 0.1 in [0.0, 1e3];
    /// Deviation of the angular rate from its mean below which the sensor may be at rest.
    real rest_gyr: "rad/s" = 0.03490658503988659 in [0.0, 1e3];
    /// Deviation of the specific force from its mean below which the sensor may be at rest.
    real rest_acc: "m/s²" = 0.5 in [0.0, 1e3];
    /// Time that both have to be small for.
    real rest_time: "s" = 1.5 in [0.0, 1e9];
    /// Noise density of the angular rate at rest, as a measurement of the bias.
    real rest_noise: "rad/s/√Hz" = 5e-4 in [1e-9, 1e3];
    /// Standard deviation of the velocity at rest.
    real rest_velocity: "m/s" = 0.02 in [1e-6, 1e3];
    /// Standard deviation of the inclination at the start.
    real initial_inclination: "rad" = 0.5 in [1e-6, 1e3];
    /// Standard deviation of the heading at the start.
    real initial_heading: "rad" = 1.0 in [1e-6, 1e3];
    /// Standard deviation of the gyroscope's bias at the start; it never becomes larger.
    real initial_bias: "rad/s" = 0.0087 in [0.0, 1e3];
    /// The same of each entry of the gyroscope's matrix.
    real initial_matrix: "1" = 0.003 in [0.0, 1e3];
    /// The same of the velocity.
    real initial_velocity: "m/s" = 1.0 in [1e-6, 1e3];
    /// The same of the accelerometer's bias.
    real initial_acc_bias: "m/s²" = 0.04 in [0.0, 1e3];
    /// The same of gravity.
    real initial_gravity: "m/s²" = 0.05 in [0.0, 1e3];
    /// The same of the hard iron, in norms of the field.
    real initial_hard_iron: "1" = 1e-3 in [0.0, 1e3];
    /// The same of the reference field, in its norms.
    real initial_field: "1" = 0.05 in [0.0, 1e3];
    /// The same of the magnetometer's delay.
    real initial_delay: "s" = 0.015 in [0.0, 1.0];
    /// Delay of all sensors behind the attitude that is wanted, by which the output is turned ahead.
    real latency: "s" = 0.0 in [-1.0, 1.0];
    /// Gravity g where the sensor is.
    real gravity: "m/s²" = 9.80665 in [1e-3, 1e3];
}

/// The time of a block in s.
pub const BLOCK: f64 = 0.1;
/// The longest time in s that the field of a block stands for.
pub const LONGEST_FIELD: f64 = 0.2;

/// A Kalman filter that calibrates its sensors while it runs.
#[derive(Clone, Debug)]
pub struct SelfCalKF<S: Scalar> {
    params: Params<S>,
    state: State<S>,
    block: Block<S>,
    steps: Steps<S>,
    clipping: Clipping<S>,
    level: Level<S>,
    reference: Reference<S>,
    rest: Rest<S>,
    /// The time since the last specific force.
    acc_interval: S,
    /// One where a field has been used.
    headed: S,
    /// The turn from the attitude to that which is wanted.
    ahead: Quat<S>,
    flags: Flags<S::Mask>,
}

impl<S: Scalar> Filter<S> for SelfCalKF<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const HAS_COVARIANCE: bool = true;
    const WATCHED: bool = true;
    const STARTS_IN_MOTION: bool = true;

    fn new(params: &Params<S>) -> Self {
        SelfCalKF {
            params: params.clone(),
            state: State::new(params),
            block: Block::new(),
            steps: Steps::new(),
            clipping: Clipping::new(),
            level: Level::new(),
            reference: Reference::new(),
            rest: Rest::new(),
            acc_interval: S::zero(),
            headed: S::zero(),
            ahead: Quat::identity(),
            flags: Flags::none(),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        if self.is_late() { (self.state.q * self.ahead).renormalized() } else { self.state.q }
    }
    /// What is known of heading and velocity starts afresh, and of the inclination where the vertical is new. The block that
    /// is going on loses what it knows.
    #[cold]
    #[inline(never)]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        let q = if self.is_late() { (q * self.ahead.conj()).renormalized() } else { q };
        let tilted = lanes & new_vertical(self.state.q, q);
        self.state.put(lanes, VELOCITY, Vec3::zero());
        for i in THETA..TURN {
            self.state.forget(tilted, i, initial_variance(&self.params, i));
        }
        for i in [TURN, VELOCITY, VELOCITY + 1, VELOCITY + 2] {
            self.state.forget(lanes, i, initial_variance(&self.params, i));
        }
        self.block.restart(lanes);
        self.level.restart(tilted);
        self.state.q = Quat::select(lanes, q, self.state.q);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lose_rotation(&mut self, lanes: S::Mask, variance: S) {
        self.block.slip = self.block.slip + S::select(lanes, variance, S::zero());
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn claimed(&self) -> [S; 2] {
        let p = &self.state.p;
        [p[(THETA, THETA)].max(p[(THETA + 1, THETA + 1)]), p[(TURN, TURN)]]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn known_mag_delay(&self) -> S {
        self.state.mean[DELAY]
    }
    #[cold]
    #[inline(never)]
    fn reopen(&mut self, lanes: S::Mask, bias: Vec3<S>) {
        self.state.restart(lanes, bias, &self.params);
        self.block.restart(lanes);
        self.level.restart(lanes);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let (rate, turning) = self.state.advance(sample.gyr, dt);
        let r = self.state.q.matrix();
        let turning = bounded_rate(turning);
        // A clipped axis says nothing of its column of the matrix, and leaves its angle unknown.
        let clipped = self.clipping.see(sample.gyr, self.params.gyr_range, dt);
        let (o, Vec3 { x, y, z }) = (S::zero(), clipped);
        let whole = |clipped: S, rate: S| S::select(o.lt(clipped), o, rate);
        let shown = Vec3::new(whole(x, rate.x), whole(y, rate.y), whole(z, rate.z));
        // A rotation that was lost shows nothing of the gyroscope.
        let turned = S::select(sample.lost, S::zero(), dt);
        self.block.turns(r, sample.gyr, shown, turning, [turned, dt]);
        if (o.lt(x) | o.lt(y) | o.lt(z)).any() {
            self.block.clips(r, clipped);
        }
        self.block.slip = self.block.slip + self.steps.slip(turning, dt);
        if self.is_late() {
            self.ahead = exp_half(turning * (S::of(0.5) * self.params.latency));
        }

        let longest = S::of(LONGEST_INTERVAL);
        self.acc_interval = (self.acc_interval + dt).min(longest);
        let acc = &sample.acc;
        self.flags.acc_rejected = S::Mask::splat(false);
        if acc.valid.any() {
            self.flags.acc_rejected = self.block.pushes(acc.valid, r, acc.value, &self.state, self.acc_interval);
        }
        let limits = Thresholds { gyr: self.params.rest_gyr, acc: self.params.rest_acc, time: self.params.rest_time };
        let shown = sample.rest_time(dt);
        let rests = self.rest.step((sample.gyr, shown), (acc.value, acc.valid, self.acc_interval), &limits);
        self.acc_interval = S::select(acc.valid, S::zero(), self.acc_interval);
        let slow = (self.rest.rate() - self.state.bias()).norm2().lt(limits.gyr * limits.gyr);
        self.flags.rest = rests & slow;
        self.block.rest = self.block.rest + S::select(self.flags.rest, shown, S::zero());

        let mag = &sample.mag;
        if mag.valid.any() {
            let field = self.reference.scaled(mag.valid, mag.value);
            self.block.points(mag.valid, r, field, turning, self.state.mean[DELAY]);
        }
        self.reference.interval = (self.reference.interval + dt).min(S::of(LONGEST_FIELD));

        let ends = S::of(BLOCK).le(self.block.time + S::of(0.5) * dt) & S::zero().lt(dt);
        if ends.any() {
            self.end_block(ends);
        }
        self.flags.mag_rejected = self.reference.rejects();
        self.flags.recovering = self.flags.mag_rejected & self.reference.recovers(self.params.mag_new_time);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.state.bias()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.acc_rejected = self.flags.acc_rejected;
        flags.mag_rejected = self.flags.mag_rejected;
        flags.recovering = self.flags.recovering;
        flags.rest = self.flags.rest;
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        let state = &self.state;
        let known = S::zero().lt(self.reference.scale);
        let norm = S::select(known, S::one() / self.reference.scale, S::zero());
        match index {
            0 => put_rows(&self.covariance(), put),
            1 => (MATRIX..MATRIX + 9).for_each(|i| put(state.mean[i])),
            2 => put(state.mean[DELAY]),
            3 => put(state.p[(DELAY, DELAY)].max(S::zero()).sqrt()),
            4 => (state.hard_iron() * norm).each(&mut |value| put(*value)),
            5 => (state.disturbance() * norm).each(&mut |value| put(*value)),
            6 => put(self.reference.weight),
            _ => [HORIZONTAL, VERTICAL].into_iter().for_each(|i| put(state.mean[within(i)] * norm)),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.state.each(visit);
        self.block.each(visit);
        self.steps.each(visit);
        self.clipping.each(visit);
        self.level.each(visit);
        self.reference.each(visit);
        self.rest.each(visit);
        self.ahead.each(visit);
        visit(&mut self.acc_interval);
        visit(&mut self.headed);
    }
}

impl<S: Scalar> SelfCalKF<S> {
    /// Covariance of the attitude error in the sensor frame in rad².
    pub fn covariance(&self) -> Square<S, 3> {
        let r = self.state.q.matrix();
        let p = part::<_, THETA, THETA, 3, 3, { state::N }>(&self.state.p);
        reported(&congruent(&transposed(&rows(r)), &p), r.z, S::zero().lt(self.headed))
    }

    /// The estimate of all states.
    pub fn state(&self) -> &State<S> {
        &self.state
    }

    /// One over the norm of the first field: what the states of the field are multiples of it by; zero before there was one.
    pub fn field_scale(&self) -> S {
        self.reference.scale
    }

    /// True where the output is turned ahead.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_late(&self) -> bool {
        S::zero().lt(self.params.latency.abs()).any()
    }

    /// Takes over what a block has shown.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn end_block(&mut self, lanes: S::Mask) {
        let params = &self.params;
        let (block, state) = (&mut self.block, &mut self.state);
        let time = S::select(lanes, block.time, S::one());
        let transition = Transition::new(lanes, block, state, params);
        transition.predict(lanes, &mut state.p, block, params);
        transition.move_mean(lanes, state, block);

        let (starting, turn) = self.level.take(lanes, state, block, params);
        self.reference.turn(starting, turn);
        let rest = lanes & time.lt(S::of(2.0) * block.rest);
        let [vx, vy, vz] = measurement::velocity(lanes & !starting, rest, state, time, params);
        let mut measurements =
            [vx, vy, vz, Row::none(), Row::none(), Row::none(), Row::none(), Row::none(), Row::none()];
        if rest.any() {
            let [bx, by, bz] = measurement::rest(rest, block.gyr * (S::one() / time), state, time, params);
            (measurements[3], measurements[4], measurements[5]) = (bx, by, bz);
        }
        let fields = lanes & S::zero().lt(block.fields);
        if fields.any() {
            let seen = Seen::new(block, state);
            let interval = self.reference.interval;
            let settled = self.reference.settle(fields, state, seen.field, interval, params);
            self.headed = S::select(fields, S::one(), self.headed);
            let (weight, used) = self.reference.weigh(settled, seen.deviation2(HEADING_SHARE), interval, params);
            let square = |x: S| x * x;
            let turning2 = block.rate2 / time;
            let renewed = self.reference.renew(settled, state, seen.clean, (interval, turning2), params);
            let used = used & !renewed;
            let noise2 = square(params.mag_noise) + square(params.mag_rate_noise) * turning2;
            let [mx, my, mz] = seen.rows(used, state, noise2 / (interval * weight));
            (measurements[6], measurements[7], measurements[8]) = (mx, my, mz);
            self.reference.interval = S::select(fields, S::zero(), interval);
        }
        let x = correct(state, &measurements);
        state.inject(lanes, &x, params);
        self.block.restart(lanes);
    }
}
