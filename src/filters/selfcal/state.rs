//! What the filter estimates: the order of its states, what is known of them at the start, and where they end.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::Params;
use crate::filters::kalman::{Column, LARGEST_BIAS, Square, UNKNOWN_ANGLE, angle_variance, saturated, vec3, zeros};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Quat, Vec3, exp_half, rotate_by};

/// The number of states.
pub const N: usize = 31;
/// The attitude's error, a rotation in the earth frame: R = exp(θ) R̂.
pub const THETA: usize = 0;
/// Its part about the vertical.
pub const TURN: usize = 2;
/// The gyroscope's bias in rad/s.
pub const BIAS: usize = 3;
/// The gyroscope's matrix M row by row: the rate is (I + M)(ω − b).
pub const MATRIX: usize = 6;
/// The velocity in m/s, earth frame.
pub const VELOCITY: usize = 15;
/// The accelerometer's bias in m/s².
pub const ACC_BIAS: usize = 18;
/// Gravity in m/s².
pub const GRAVITY: usize = 21;
/// The hard iron, sensor frame; as all that follows in norms of the field.
pub const IRON: usize = 22;
/// The disturbance of the field, earth frame.
pub const DISTURBANCE: usize = 25;
/// The horizontal part of the reference field.
pub const HORIZONTAL: usize = 28;
/// Its vertical part.
pub const VERTICAL: usize = 29;
/// The magnetometer's delay in s.
pub const DELAY: usize = 30;

/// Groups of states of one kind with their first index and their number: what a limit holds for.
const GROUPS: [(usize, usize); 11] = [
    (THETA, 2),
    (TURN, 1),
    (BIAS, 3),
    (MATRIX, 9),
    (VELOCITY, 3),
    (ACC_BIAS, 3),
    (GRAVITY, 1),
    (IRON, 3),
    (DISTURBANCE, 3),
    (HORIZONTAL, 2),
    (DELAY, 1),
];

/// How much the variances grow in every prediction, in epsilons of the scalar.
const INFLATION: f64 = 8.0;
/// The largest part of the field that a state may be, in its norms.
const LARGEST_FIELD: f64 = 16.0;
/// The largest velocity in m/s.
const LARGEST_VELOCITY: f64 = 1e4;

/// The estimate of the states and the covariance of its error.
#[derive(Clone, Debug)]
pub struct State<S: Scalar> {
    /// The attitude.
    pub q: Quat<S>,
    /// The other states; zero in the place of the attitude's error.
    pub mean: Column<S, N>,
    /// The covariance.
    pub p: Square<S, N>,
}

impl<S: Scalar> State<S> {
    /// At the identity, with what the parameters say of the rest.
    pub fn new(params: &Params<S>) -> Self {
        let mut mean = zeros();
        mean[GRAVITY] = params.gravity;
        let mut p = zeros();
        for i in 0..N {
            p[(i, i)] = initial_variance(params, i);
        }
        State { q: Quat::identity(), mean, p }
    }

    /// The gyroscope's bias in rad/s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn bias(&self) -> Vec3<S> {
        vec3(&self.mean, BIAS)
    }
    /// M v.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn misaligned(&self, v: Vec3<S>) -> Vec3<S> {
        let row = |i: usize| vec3(&self.mean, MATRIX + 3 * i).dot(v);
        Vec3::new(row(0), row(1), row(2))
    }
    /// Turns the attitude by a sample of the gyroscope; gives ω − b and the angular rate (I + M)(ω − b).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn advance(&mut self, gyr: Vec3<S>, dt: S) -> (Vec3<S>, Vec3<S>) {
        let rate = gyr - self.bias();
        let turning = rate + self.misaligned(rate);
        self.q = rotate_by(self.q, turning, dt);
        (rate, turning)
    }
    /// The velocity in m/s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn velocity(&self) -> Vec3<S> {
        vec3(&self.mean, VELOCITY)
    }
    /// The accelerometer's bias in m/s².
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn acc_bias(&self) -> Vec3<S> {
        vec3(&self.mean, ACC_BIAS)
    }
    /// Gravity in m/s².
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn gravity(&self) -> S {
        self.mean[GRAVITY]
    }
    /// The hard iron in norms of the field, sensor frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn hard_iron(&self) -> Vec3<S> {
        vec3(&self.mean, IRON)
    }
    /// The disturbance in norms of the field, earth frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn disturbance(&self) -> Vec3<S> {
        vec3(&self.mean, DISTURBANCE)
    }
    /// The mean variance of the two angles of the inclination.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn tilt_variance(&self) -> S {
        S::of(0.5) * (self.p[(0, 0)] + self.p[(1, 1)])
    }

    /// Writes three states where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn put(&mut self, lanes: S::Mask, start: usize, v: Vec3<S>) {
        for (i, value) in [v.x, v.y, v.z].into_iter().enumerate() {
            let i = within(start + i);
            self.mean[i] = S::select(lanes, value, self.mean[i]);
        }
    }

    /// Forgets where the mask is true what is known of a state beside its value: it has a variance and no correlations.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn forget(&mut self, lanes: S::Mask, state: usize, variance: S) {
        let state = within(state);
        for i in 0..N {
            let entry = S::select(lanes, S::zero(), self.p[(i, state)]);
            self.p[(i, state)] = entry;
            self.p[(state, i)] = entry;
        }
        self.p[(state, state)] = S::select(lanes, variance, self.p[(state, state)]);
    }

    /// Starts anew where the mask is true, but for the attitude, the bias of the gyroscope, which is given, the delay of the
    /// magnetometer and the field.
    pub fn restart(&mut self, lanes: S::Mask, bias: Vec3<S>, params: &Params<S>) {
        for i in 0..N {
            self.forget(lanes, i, initial_variance(params, i));
        }
        self.put(lanes, BIAS, bias);
        for i in (MATRIX..GRAVITY).chain(IRON..HORIZONTAL) {
            self.mean[i] = S::select(lanes, S::zero(), self.mean[i]);
        }
        self.mean[GRAVITY] = S::select(lanes, params.gravity, self.mean[GRAVITY]);
    }

    /// Turns the attitude, and what stands in the earth frame, where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turn(&mut self, lanes: S::Mask, turn: Quat<S>) {
        let r = turn.matrix();
        for start in [VELOCITY, DISTURBANCE] {
            self.put(lanes, start, r.apply(vec3(&self.mean, start.min(N - 3))));
        }
        self.q = Quat::select(lanes, (turn * self.q).renormalized(), self.q);
    }

    /// Takes over a correction x of all states: R̂ := exp(x_θ) R̂, the others by addition. There is none, and the covariance
    /// starts afresh, where the numbers have left the range of the scalar or a variance is negative.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn inject(&mut self, lanes: S::Mask, x: &Column<S, N>, params: &Params<S>) {
        let mut total = S::zero();
        let mut sound = S::Mask::splat(true);
        for j in 0..N {
            total = total + (x[j].abs() + self.p[(j, j)]);
            sound = sound & S::zero().le(self.p[(j, j)]);
        }
        let sound = sound & total.le(S::splat(S::Real::MAX));
        if !sound.all() {
            for i in 0..N {
                self.forget(!sound, i, initial_variance(params, i));
            }
        }
        let lanes = lanes & sound;
        let turn = Vec3::select(lanes, vec3(x, THETA) * S::of(0.5), Vec3::zero());
        self.q = exp_half(turn) * self.q;
        for i in BIAS..N {
            self.mean[i] = self.mean[i] + S::select(lanes, x[i], S::zero());
        }
        self.limit(lanes, params);
    }

    /// Brings values that no sensor has back to the largest ones. What is at its limit may be shortened once more, by rounding:
    /// not in a lane whose values have not changed.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn limit(&mut self, lanes: S::Mask, params: &Params<S>) {
        let many = S::of(LARGEST_BIAS);
        let field = S::of(LARGEST_FIELD);
        for (start, limit) in [
            (BIAS, many * params.initial_bias),
            (VELOCITY, S::of(LARGEST_VELOCITY)),
            (ACC_BIAS, many * params.initial_acc_bias),
            (IRON, field),
            (DISTURBANCE, field),
        ] {
            self.put(lanes, start, saturated(vec3(&self.mean, start.min(N - 3)), limit));
        }
        let mut norm2 = S::zero();
        for i in MATRIX..MATRIX + 9 {
            norm2 = norm2 + self.mean[i] * self.mean[i];
        }
        let largest = many * params.initial_matrix;
        let over = lanes & (largest * largest).lt(norm2);
        if over.any() {
            let factor = S::select(over, largest / norm2.sqrt(), S::one());
            for i in MATRIX..MATRIX + 9 {
                self.mean[i] = self.mean[i] * factor;
            }
        }
        let around = |value: S, centre: S, range: S| value.max(centre - range).min(centre + range);
        self.mean[GRAVITY] = around(self.mean[GRAVITY], params.gravity, many * params.initial_gravity);
        self.mean[DELAY] = around(self.mean[DELAY], S::zero(), many * params.initial_delay);
        for i in [HORIZONTAL, VERTICAL].into_iter().map(within) {
            self.mean[i] = around(self.mean[i], S::zero(), field);
        }
    }

    /// Keeps the covariance positive definite and bounded after a prediction, where the mask is true: the diagonal grows by more
    /// than the rounding takes, and no group of states is less known than its limit.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn bounded(lanes: S::Mask, p: &mut Square<S, N>, params: &Params<S>) {
        let mut factors: Column<S, N> = zeros();
        let growth = S::of(INFLATION) * S::splat(S::Real::EPSILON);
        for (start, len) in GROUPS {
            let mut sum = S::zero();
            for i in (start..start + len).map(within) {
                p[(i, i)] = p[(i, i)] + S::select(lanes, p[(i, i)] * growth, S::zero());
                sum = sum + p[(i, i)];
            }
            let largest = largest_variance(params, start) * S::of(len as f64);
            let over = lanes & largest.lt(sum);
            let factor = S::select(over, (largest / sum).sqrt(), S::one());
            for i in (start..start + len).map(within) {
                factors[i] = factor;
            }
        }
        for j in 0..N {
            for i in 0..N {
                p[(i, j)] = p[(i, j)] * (factors[i] * factors[j]);
            }
        }
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        for i in BIAS..N {
            visit(&mut self.mean[i]);
        }
        for j in 0..N {
            for i in 0..=j {
                visit(&mut self.p[(i, j)]);
                self.p[(j, i)] = self.p[(i, j)];
            }
        }
    }
}

/// The index, which is that of a state: so the compiler knows it too, and needs no panic for another one.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn within(state: usize) -> usize {
    state.min(N - 1)
}

/// The variance of a state at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn initial_variance<S: Scalar>(params: &Params<S>, state: usize) -> S {
    let deviation = match state {
        0 | 1 => return angle_variance(params.initial_inclination),
        TURN => return angle_variance(params.initial_heading),
        BIAS..MATRIX => params.initial_bias,
        MATRIX..VELOCITY => params.initial_matrix,
        VELOCITY..ACC_BIAS => params.initial_velocity,
        ACC_BIAS..GRAVITY => params.initial_acc_bias,
        GRAVITY => params.initial_gravity,
        IRON..DISTURBANCE => params.initial_hard_iron,
        DISTURBANCE..HORIZONTAL => params.disturbance,
        HORIZONTAL | VERTICAL => params.initial_field,
        _ => params.initial_delay,
    };
    deviation * deviation
}

/// The largest mean variance of the group that begins with a state.
#[cfg_attr(not(debug_assertions), inline(always))]
fn largest_variance<S: Scalar>(params: &Params<S>, state: usize) -> S {
    let initial = initial_variance(params, state);
    match state {
        THETA | TURN => S::of(UNKNOWN_ANGLE),
        VELOCITY => initial + params.velocity * params.velocity,
        IRON => initial.max(params.largest_hard_iron * params.largest_hard_iron),
        _ => initial,
    }
}
