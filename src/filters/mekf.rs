//! An error-state (multiplicative) Kalman filter of attitude and gyroscope bias.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::delay::{LONGEST_DELAY, caught_up};
use super::error_state::ErrorState;
use super::field::{Field, VERTICAL_FIELD};
use super::kalman::{
    LARGEST_BIAS, SATURATION, Square, UNKNOWN_ANGLE, angle_variance, block, cap_group, congruent, diagonal, filled,
    inflate, new_vertical, none, none3, product, put_rows, reported, rows, saturated, select, set_block, sum3,
    symmetric, transposed, vec3,
};
use super::rest::{LONGEST_TIME, LONGEST_WAIT, Rest, Thresholds};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Matrix3, Quat, Vec3, exp_half, rotate_by};
use crate::status::Flags;
use crate::trig::{atan2, wrap};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "MEKF",
    doc: "An error-state Kalman filter of attitude and gyroscope bias. Its noises are densities, so that they do not \
          depend on the sampling rate. The specific force counts less where its mean is not vertical (external \
          acceleration); the magnetometer corrects only the heading, and is left out where its field is strange or \
          its innovation too large; at rest the gyroscope shows its bias.",
    source: "Markley, J. Guidance 26(2), 2003, with the error as a tilt and a turn in the earth frame",
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
            name: "innovation",
            doc: "tilt that the specific force shows about east and north, and heading of the field, rad; NaN where \
                  there is no measurement",
            shape: &[3],
        },
        OutputSpec {
            name: "nis",
            doc: "normalised innovation squared of accelerometer (2 degrees of freedom) and magnetometer (1; 3 with \
                  magnetometer=\"vector\")",
            shape: &[2],
        },
    ],
};

choice! {
    /// What of the field is used: its heading, or all of it (the inclination too).
    pub enum Use { Heading = "heading", Vector = "vector" }
}

params! {
    /// Noise density of the gyroscope (angle random walk).
    real gyr_noise: "rad/s/√Hz" = 2e-3 in [1e-9, 1e3];
    /// Noise density of the bias' rate (rate random walk).
    real bias_noise: "rad/s²/√Hz" = 1e-4 in [1e-9, 1e3];
    /// Noise density of the accelerometer.
    real acc_noise: "m/s²/√Hz" = 0.3 in [1e-6, 1e3];
    /// Noise density of the magnetometer's heading.
    real heading_noise: "rad/√Hz" = 0.1 in [1e-6, 1e3];
    /// How much the mean horizontal specific force adds to the density of the accelerometer (0: nothing).
    real acc_adaptation: "√s" = 0.3 in [0.0, 1e3];
    /// Time constant of that mean.
    real acc_window: "s" = 10.0 in [1e-6, 1e6];
    /// Relative deviation of the field from its reference at which the heading's variance is four times as large.
    real mag_tolerance: "1" = 0.12 in [1e-6, 1e6];
    /// Time constant of the reference field.
    real mag_window: "s" = 3.0 in [1e-6, 1e6];
    /// Innovations of the heading beyond this many standard deviations are not used.
    real mag_gate: "1" = 3.0 in [1e-3, 1e6];
    /// Time after which a field that was left out is used all the same.
    real mag_recovery: "s" = 10.0 in [0.0, 1e6];
    /// Deviation of the angular rate from its mean below which the sensor may be at rest.
    real rest_gyr: "rad/s" = 0.03490658503988659 in [0.0, 1e3];
    /// Deviation of the specific force from its mean below which the sensor may be at rest.
    real rest_acc: "m/s²" = 0.5 in [0.0, 1e3];
    /// Time that both have to be small for.
    real rest_time: "s" = 1.5 in [0.0, 1e9];
    /// Noise density of the angular rate at rest, as a measurement of the bias.
    real rest_noise: "rad/s/√Hz" = 0.01 in [1e-9, 1e3];
    /// Standard deviation of the inclination at the start.
    real initial_inclination: "rad" = 0.1 in [1e-6, 1e3];
    /// Standard deviation of the heading at the start.
    real initial_heading: "rad" = 0.5 in [1e-6, 1e3];
    /// Standard deviation of the bias at the start; it never becomes larger.
    real initial_bias: "rad/s" = 0.05 in [1e-9, 1e3];
    /// Gravity g where the sensor is.
    real gravity: "m/s²" = 9.80665 in [1e-3, 1e3];
    choice magnetometer: Use;
    /// How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the field is turned into the
    /// present sensor frame by the angular rate.
    real mag_delay: "s" = 0.0 in [0.0, LONGEST_DELAY];
}

/// Where the error's turn about the vertical and where the bias stand in the state: (tilt about east, about north,
/// turn, bias).
const TURN: usize = 2;
const BIAS: usize = 3;
/// The longest time in s that one measurement stands for.
const LONGEST_INTERVAL: f64 = LONGEST_WAIT;
/// The largest deviation of the field, in tolerances, that is still used.
const FIELD_GATE: f64 = 3.0;
/// The largest factor by which external acceleration inflates the accelerometer's variance.
const LARGEST_INFLATION: f64 = 100.0;
/// The factor from which on a sample counts as rejected.
const REJECTING_INFLATION: f64 = 4.0;

/// An error-state Kalman filter of attitude and gyroscope bias.
///
/// The error stands in the earth frame: R = Rz(δz) exp([(δx, δy, 0)×]) R̂, first a tilt, then a turn about the vertical. To
/// first order it is R̂ δθ, with δθ the error in the sensor frame. So a level measurement knows nothing of δz to every
/// order, and an unknown heading stays apart.
#[derive(Clone, Debug)]
pub struct MEKF<S: Scalar> {
    params: Params<S>,
    q: Quat<S>,
    bias: Vec3<S>,
    error: ErrorState<S, 6>,
    /// The time since the last measurement.
    acc_interval: S,
    mag_interval: S,
    /// The horizontal specific force, low-pass filtered.
    mean_acc: [S; 2],
    field: Field<S>,
    rest: Rest<S>,
    /// One where a magnetometer sample has been used.
    headed: S,
    flags: Flags<S::Mask>,
    innovation: Vec3<S>,
    nis: [S; 2],
}

impl<S: Scalar> Filter<S> for MEKF<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const HAS_COVARIANCE: bool = true;
    const WATCHED: bool = true;

    fn new(params: &Params<S>) -> Self {
        let zero = S::zero();
        MEKF {
            params: params.clone(),
            q: Quat::identity(),
            bias: Vec3::zero(),
            error: ErrorState::new(diagonal(|i| initial_variance(params, i))),
            acc_interval: zero,
            mag_interval: zero,
            mean_acc: [zero; 2],
            field: Field::new(),
            rest: Rest::new(),
            headed: zero,
            flags: Flags::none(),
            innovation: none3(),
            nis: [none(); 2],
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    /// The heading's variance starts afresh, the inclination's where the vertical is new; what starts afresh has no
    /// correlations. The bias keeps its own.
    #[cold]
    #[inline(never)]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        let mut turned = self.error.p;
        reset(&mut turned, &product(&rows(q.matrix()), &transposed(&rows(self.q.matrix()))));
        // Entry after entry: whole matrices for each choice would be half of the stack that a step takes.
        let (new_vertical, params, old) = (new_vertical(self.q, q), &self.params, &self.error.p);
        let p = filled(|i, j| {
            let [everything, turn] = [0, TURN].map(|first| afresh(params, &turned, first, (i, j)));
            S::select(lanes, S::select(new_vertical, everything, turn), old[(i, j)])
        });
        self.error.p = p;
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lose_rotation(&mut self, lanes: S::Mask, variance: S) {
        for i in 0..BIAS {
            self.error.p[(i, i)] = self.error.p[(i, i)] + S::select(lanes, variance, S::zero());
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn claimed(&self) -> [S; 2] {
        let p = &self.error.p;
        [p[(0, 0)].max(p[(1, 1)]), p[(TURN, TURN)]]
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn known_mag_delay(&self) -> S {
        self.params.mag_delay
    }
    #[cold]
    #[inline(never)]
    fn reopen(&mut self, lanes: S::Mask, bias: Vec3<S>) {
        let start = diagonal(|i| initial_variance(&self.params, i));
        self.error.p = select(lanes, &start, &self.error.p);
        self.bias = Vec3::select(lanes, bias, self.bias);
        for mean in &mut self.mean_acc {
            *mean = S::select(lanes, S::zero(), *mean);
        }
        self.field.rejected = S::select(lanes, S::zero(), self.field.rejected);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        self.innovation = none3();
        self.nis = [none(); 2];
        self.flags = Flags::none();
        let r = self.predict(sample, dt);
        let longest = S::of(LONGEST_INTERVAL);
        self.acc_interval = (self.acc_interval + dt).min(longest);
        self.mag_interval = (self.mag_interval + dt).min(longest);
        let params = &self.params;
        let limits = Thresholds { gyr: params.rest_gyr, acc: params.rest_acc, time: params.rest_time };
        let acc = (sample.acc.value, sample.acc.valid, self.acc_interval);
        let shown = sample.rest_time(dt);
        self.flags.rest = self.rest.step((sample.gyr, shown), acc, &limits);

        if sample.acc.valid.any() {
            self.use_acc(sample.acc.valid, r.apply(sample.acc.value));
        }
        if sample.mag.valid.any() {
            let field = caught_up(sample.mag.value, sample.gyr - self.bias, self.params.mag_delay);
            self.use_mag(sample.mag.valid, r.apply(field));
        }
        if self.flags.rest.any() {
            self.use_rest(sample.gyr, shown);
        }
        self.inject();
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.bias
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.acc_rejected = self.flags.acc_rejected;
        flags.mag_rejected = self.flags.mag_rejected;
        flags.rest = self.flags.rest;
        flags.recovering = self.flags.recovering;
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        match index {
            0 => put_rows(&self.covariance(), put),
            1 => self.innovation.clone().each(&mut |value| put(*value)),
            _ => self.nis.iter().for_each(|nis| put(*nis)),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        self.bias.each(visit);
        self.error.each(visit);
        self.mean_acc.iter_mut().for_each(&mut *visit);
        self.rest.each(visit);
        self.field.each(visit);
        for variable in [&mut self.acc_interval, &mut self.mag_interval, &mut self.headed] {
            visit(variable);
        }
    }
}

impl<S: Scalar> MEKF<S> {
    /// Covariance of the attitude error in the sensor frame in rad².
    pub fn covariance(&self) -> Square<S, 3> {
        let r = self.q.matrix();
        let p = block::<_, 0, 0, 3, 3, 6>(&self.error.p);
        reported(&congruent(&transposed(&rows(r)), &p), r.z, S::zero().lt(self.headed))
    }

    /// Attitude and covariance after dt; gives the new rotation matrix. dδ/dt = −R (b − b̂), by the trapezoidal rule.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn predict(&mut self, sample: &Sample<S>, dt: S) -> Matrix3<S> {
        let before = rows(self.q.matrix());
        self.q = rotate_by(self.q, sample.gyr - self.bias, dt);
        let r = self.q.matrix();
        // A rotation that was lost shows nothing of the bias.
        let half_dt = S::of(0.5) * S::select(sample.lost, S::zero(), dt);
        let after = rows(r);
        let turn: Square<S, 3> = filled(|i, j| (after[(i, j)] + before[(i, j)]) * half_dt);

        let moves = S::zero().lt(dt);
        if moves.any() {
            let p = predicted(&self.params, &self.error.p, &turn, dt);
            self.error.set_covariance(moves, &p);
        }
        r
    }

    /// The horizontal part of the specific force over g is (−δy, δx) to first order.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn use_acc(&mut self, lanes: S::Mask, force: Vec3<S>) {
        let params = &self.params;
        let interval = self.acc_interval;
        self.acc_interval = S::select(lanes, S::zero(), interval);
        let level = saturated(Vec3::new(force.x, force.y, S::zero()), S::of(SATURATION) * params.gravity);
        // External acceleration that lasts: the horizontal force, low-pass filtered.
        let weight = interval / (params.acc_window + interval);
        let [x, y] = self.mean_acc;
        let mean = [x + weight * (level.x - x), y + weight * (level.y - y)];
        self.mean_acc = [S::select(lanes, mean[0], x), S::select(lanes, mean[1], y)];
        let external2 = params.acc_adaptation * params.acc_adaptation * (mean[0] * mean[0] + mean[1] * mean[1]);
        let noise2 = params.acc_noise * params.acc_noise;
        let density2 = noise2 + external2.min(S::of(LARGEST_INFLATION - 1.0) * noise2);
        self.flags.acc_rejected = lanes & (S::of(REJECTING_INFLATION) * noise2).lt(density2);

        let over_g = S::one() / params.gravity;
        let (east, north) = (level.y * over_g, -(level.x * over_g));
        self.innovation.x = S::select(lanes, east, self.innovation.x);
        self.innovation.y = S::select(lanes, north, self.innovation.y);
        // White noise has no information in no time.
        let lanes = lanes & S::zero().lt(interval);
        if lanes.any() {
            let variance = density2 * (over_g * over_g / interval);
            let nis = self.error.measure::<0, 1>(lanes, [S::one()], east, variance);
            let nis = nis + self.error.measure::<1, 1>(lanes, [S::one()], north, variance);
            self.nis[0] = S::select(lanes, nis, self.nis[0]);
        }
    }

    /// The field's heading, or all of it, where it is not strange.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn use_mag(&mut self, lanes: S::Mask, field: Vec3<S>) {
        let params = &self.params;
        let interval = self.mag_interval;
        self.mag_interval = S::select(lanes, S::zero(), interval);
        let (horizontal, vertical) = ((field.x * field.x + field.y * field.y).sqrt(), field.z);
        let deviation2 = self.field.see(lanes, horizontal, vertical, interval);
        let heading = atan2(field.x, field.y);
        self.innovation.z = S::select(lanes, heading, self.innovation.z);
        let horizontal2 = horizontal * horizontal;
        let level = (S::of(VERTICAL_FIELD * VERTICAL_FIELD) * (horizontal2 + vertical * vertical)).le(horizontal2);
        let lanes = lanes & level & S::zero().lt(interval);
        if !lanes.any() {
            return;
        }

        // The derivative of the heading by the error at the reference field: the turn itself, and a tilt about north.
        let tolerance2 = params.mag_tolerance * params.mag_tolerance;
        let growth = S::one() + deviation2 * (S::one() / tolerance2);
        let variance = growth * growth * (params.heading_noise * params.heading_noise / interval);
        let [north, up] = self.field.direction();
        let mut seen = self.error.innovation::<1, 2>([-(up / north), S::one()], heading, variance);
        seen.nu = wrap(seen.nu);
        let nis = seen.nis();
        self.nis[1] = S::select(lanes, nis, self.nis[1]);

        let strange = (S::of(FIELD_GATE * FIELD_GATE) * tolerance2).lt(deviation2);
        let rejected = lanes & (strange | (params.mag_gate * params.mag_gate * seen.s).lt(seen.nu * seen.nu));
        let time = S::select(rejected, (self.field.rejected + interval).min(S::of(LONGEST_TIME)), S::zero());
        self.field.rejected = S::select(lanes, time, self.field.rejected);
        let recovering = rejected & params.mag_recovery.lt(time);
        self.flags.mag_rejected = rejected & !recovering;
        self.flags.recovering = recovering;
        let lanes = lanes & !self.flags.mag_rejected;
        if !lanes.any() {
            return;
        }
        self.headed = S::select(lanes, S::one(), self.headed);
        let whole = params.magnetometer == Use::Vector;
        let window = if whole { self.field.age } else { params.mag_window };
        self.field.learn(lanes, recovering & strange, [horizontal, vertical], interval, window);
        if whole {
            let nis = self.field.measure(&mut self.error, lanes, field, heading, variance);
            self.nis[1] = S::select(lanes, nis, self.nis[1]);
        } else {
            // The gain of the inclination is zero (Schmidt): the magnetometer turns only heading and bias.
            let mut gain = seen.gain();
            (gain[0], gain[1]) = (S::zero(), S::zero());
            self.error.correct_by(lanes, &seen, &gain);
        }
    }

    /// At rest the gyroscope shows its bias, unless it is too far from the estimate: a slow turn.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn use_rest(&mut self, gyr: Vec3<S>, dt: S) {
        let params = &self.params;
        let off2 = (self.rest.rate() - self.bias - vec3(&self.error.x, BIAS)).norm2();
        let lanes = self.flags.rest & S::zero().lt(dt) & off2.lt(params.rest_gyr * params.rest_gyr);
        if lanes.any() {
            let variance = params.rest_noise * params.rest_noise / dt;
            let z = gyr - self.bias;
            self.error.measure::<3, 1>(lanes, [S::one()], z.x, variance);
            self.error.measure::<4, 1>(lanes, [S::one()], z.y, variance);
            self.error.measure::<5, 1>(lanes, [S::one()], z.z, variance);
        }
    }

    /// R̂ := Rz(x_z) exp([(x_x, x_y, 0)×]) R̂, b̂ := b̂ + x_b, and the covariance of the error that is left.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inject(&mut self) {
        let params = &self.params;
        let x = self.error.take(|| diagonal(|i| initial_variance(params, i)));
        let (half, o) = (S::of(0.5), S::zero());
        let tilt = exp_half(Vec3::new(x[0] * half, x[1] * half, o));
        let turn = exp_half(Vec3::new(o, o, x[TURN] * half));
        self.q = turn * (tilt * self.q);
        let largest = S::of(LARGEST_BIAS) * self.params.initial_bias;
        self.bias = saturated(self.bias + vec3(&x, BIAS), largest);
        let (sin, cos) = (S::of(2.0) * turn.w * turn.z, turn.w * turn.w - turn.z * turn.z);
        let g = Square::<S, 3>::from([[cos, sin, -(x[1] * half)], [-sin, cos, x[0] * half], [o, o, S::one()]]);
        reset(&mut self.error.p, &g);
    }
}

/// The variances at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn initial_variance<S: Scalar>(params: &Params<S>, i: usize) -> S {
    match i {
        0 | 1 => angle_variance(params.initial_inclination),
        TURN => angle_variance(params.initial_heading),
        _ => params.initial_bias * params.initial_bias,
    }
}

/// An entry of the covariance `p` with the attitude's errors from `first` on as at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn afresh<S: Scalar>(params: &Params<S>, p: &Square<S, 6>, first: usize, (i, j): (usize, usize)) -> S {
    if (i < first || i > TURN) && (j < first || j > TURN) {
        p[(i, j)]
    } else if i == j {
        initial_variance(params, i)
    } else {
        S::zero()
    }
}

/// The covariance after dt: F P Fᵀ and the noise of the step, with F = [I, −turn; 0, I].
#[cfg_attr(not(debug_assertions), inline(always))]
fn predicted<S: Scalar>(params: &Params<S>, p: &Square<S, 6>, turn: &Square<S, 3>, dt: S) -> Square<S, 6> {
    let gyr_noise = params.gyr_noise * params.gyr_noise * dt;
    let bias_noise = params.bias_noise * params.bias_noise * dt;
    let bias = params.initial_bias * params.initial_bias;
    let (a, b) = (block::<_, 0, 0, 3, 3, 6>(p), block::<_, 0, BIAS, 3, 3, 6>(p));
    let lost = product(turn, &block::<_, BIAS, BIAS, 3, 3, 6>(p));
    let cross: Square<S, 3> = filled(|i, j| b[(i, j)] - lost[(i, j)]);
    let attitude =
        symmetric(|i, j| a[(i, j)] - sum3(|k| turn[(i, k)] * b[(j, k)]) - sum3(|k| cross[(i, k)] * turn[(j, k)]));
    let mut p = *p;
    set_block::<_, 0, 0, 3, 3, 6>(&mut p, &attitude);
    set_block::<_, 0, BIAS, 3, 3, 6>(&mut p, &cross);
    for i in 0..6 {
        p[(i, i)] = p[(i, i)] + if i < BIAS { gyr_noise } else { bias_noise };
    }
    inflate(&mut p);
    cap_group(&mut p, 0..2, S::of(UNKNOWN_ANGLE));
    cap_group(&mut p, TURN..TURN + 1, S::of(UNKNOWN_ANGLE));
    cap_group(&mut p, BIAS..BIAS + 3, bias);
    p
}

/// The covariance after the attitude's error has become g times it.
#[cfg_attr(not(debug_assertions), inline(always))]
fn reset<S: Scalar>(p: &mut Square<S, 6>, g: &Square<S, 3>) {
    let attitude = congruent(g, &block::<_, 0, 0, 3, 3, 6>(p));
    let cross = product(g, &block::<_, 0, BIAS, 3, 3, 6>(p));
    set_block::<_, 0, 0, 3, 3, 6>(p, &attitude);
    set_block::<_, 0, BIAS, 3, 3, 6>(p, &cross);
}
