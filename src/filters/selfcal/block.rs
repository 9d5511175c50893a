//! What the samples of a block leave behind: sums from which its prediction and its measurements are made.

use super::state::State;
use crate::filters::delay::caught_up;
use crate::filters::kalman::{SATURATION, saturated};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Matrix3, Vec3};

/// The longest time in s that one measurement stands for.
pub const LONGEST_INTERVAL: f64 = 0.1;
/// The largest angular rate in rad/s that noise and delay are computed with.
const LARGEST_RATE: f64 = 1e4;

/// How much of a rate is unknown over the part of a step that is beyond the usual one, beside half its change.
const CURVATURE: f64 = 0.1;
/// How fast the usual step follows, for each step, and what it can start from, in s.
const STEP_GAIN: f64 = 0.02;
const SHORTEST_STEP: f64 = 1e-4;
/// The largest angle in rad that a step is unsure of.
const LARGEST_SLIP: f64 = 3.0;

/// Sums over the samples of a block. All vectors and the rows of all matrices are in the earth frame.
#[derive(Clone, Debug)]
pub struct Block<S> {
    /// The time in s.
    pub time: S,
    /// Σ R dt.
    pub turn: Matrix3<S>,
    /// Σ R_i ⊗ (ω − b̂)ᵀ dt for each row R_i of R: how the gyroscope's matrix turns the attitude.
    pub matrix: [Matrix3<S>; 3],
    /// Σ |(I + M)(ω − b)|² dt.
    pub rate2: S,
    /// The variance in rad² that irregular steps add to the attitude.
    pub slip: S,
    /// That of clipped rates, Σ R diag(variances) Rᵀ.
    pub clipped: Matrix3<S>,
    /// Σ ω dt as measured.
    pub gyr: Vec3<S>,
    /// The time at rest.
    pub rest: S,
    /// The specific force, Σ R (a − b̂_a) dt.
    pub force: Vec3<S>,
    /// Σ R dt over its samples.
    pub force_turn: Matrix3<S>,
    /// The time that they stand for.
    pub force_time: S,
    /// The field, Σ R m, each as it was a delay before.
    pub field: Vec3<S>,
    /// Its change with the delay.
    pub field_change: Vec3<S>,
    /// Σ R over its samples.
    pub field_turn: Matrix3<S>,
    /// Their number.
    pub fields: S,
}

impl<S: Scalar> Default for Block<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Block<S> {
    /// Before the first sample.
    pub fn new() -> Self {
        let (o, v, m) = (S::zero(), Vec3::zero(), nothing());
        Block {
            time: o,
            turn: m,
            matrix: [m; 3],
            rate2: o,
            slip: o,
            clipped: m,
            gyr: v,
            rest: o,
            force: v,
            force_turn: m,
            force_time: o,
            field: v,
            field_change: v,
            field_turn: m,
            fields: o,
        }
    }

    /// The gyroscope: `rate` is ω − b̂ and `turning` (I + M)(ω − b̂), by which the attitude has come to
    /// `r` over `dt`, of which `turned` is not lost.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turns(&mut self, r: Matrix3<S>, gyr: Vec3<S>, rate: Vec3<S>, turning: Vec3<S>, [turned, dt]: [S; 2]) {
        self.time = self.time + dt;
        let angle = rate * turned;
        let [x, y, z] = &mut self.matrix;
        for (sum, row) in [(x, r.x), (y, r.y), (z, r.z)] {
            // Rows of M: the entry of row j and column k stands in row j.
            sum.x = sum.x + angle * row.x;
            sum.y = sum.y + angle * row.y;
            sum.z = sum.z + angle * row.z;
        }
        self.turn = plus(self.turn, r, turned);
        self.rate2 = self.rate2 + turning.norm2() * turned;
        self.gyr = self.gyr + gyr * dt;
    }

    /// The variances that clipped rates add to the angles of the sensor's axes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn clips(&mut self, r: Matrix3<S>, variances: Vec3<S>) {
        let scaled = |row: Vec3<S>| Vec3::new(row.x * variances.x, row.y * variances.y, row.z * variances.z);
        let Matrix3 { x, y, z } = &mut self.clipped;
        for (sum, row) in [(x, r.x), (y, r.y), (z, r.z)] {
            *sum = *sum + r.apply(scaled(row));
        }
    }

    /// The specific force where the mask is true, standing for the time `dt`. Gives where it is beyond what counts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn pushes(&mut self, lanes: S::Mask, r: Matrix3<S>, force: Vec3<S>, state: &State<S>, dt: S) -> S::Mask {
        let largest = S::of(SATURATION) * state.gravity();
        let beyond = lanes & (largest * largest).lt(force.norm2());
        let lanes = lanes & !beyond;
        let dt = S::select(lanes, dt, S::zero());
        let force = Vec3::select(lanes, force, Vec3::zero());
        self.force = self.force + r.apply(force - state.acc_bias()) * dt;
        self.force_turn = plus(self.force_turn, r, dt);
        self.force_time = self.force_time + dt;
        beyond
    }

    /// The field (in norms of the reference) where the mask is true: it is that of the attitude a delay before, R exp(−[ω τ̂]×) m,
    /// and changes by its product with the rate for each second of delay.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn points(&mut self, lanes: S::Mask, r: Matrix3<S>, field: Vec3<S>, turning: Vec3<S>, delay: S) {
        let field = saturated(Vec3::select(lanes, field, Vec3::zero()), S::of(SATURATION));
        let seen = caught_up(field, turning, delay);
        let count = S::select(lanes, S::one(), S::zero());
        self.field = self.field + r.apply(seen);
        self.field_change = self.field_change + r.apply(turning.cross(seen));
        self.field_turn = plus(self.field_turn, r, count);
        self.fields = self.fields + count;
    }

    /// Starts a new block where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn restart(&mut self, lanes: S::Mask) {
        if lanes.all() {
            *self = Self::new();
        } else {
            self.each(&mut |value| *value = S::select(lanes, S::zero(), *value));
        }
    }

    /// Calls `visit` for each variable.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        let Block { turn, clipped, force_turn, field_turn, matrix: [x, y, z], .. } = self;
        for rows in [turn, clipped, force_turn, field_turn, x, y, z] {
            for row in [&mut rows.x, &mut rows.y, &mut rows.z] {
                for value in [&mut row.x, &mut row.y, &mut row.z] {
                    visit(value);
                }
            }
        }
        for vector in [&mut self.gyr, &mut self.force, &mut self.field, &mut self.field_change] {
            for value in [&mut vector.x, &mut vector.y, &mut vector.z] {
                visit(value);
            }
        }
        for value in
            [&mut self.time, &mut self.rate2, &mut self.slip, &mut self.rest, &mut self.force_time, &mut self.fields]
        {
            visit(value);
        }
    }
}

/// What irregular steps do: an angular rate that changes is wrong by half its change over a step, which makes up for itself
/// from step to step where the steps are equal, and not otherwise.
#[derive(Clone, Debug)]
pub struct Steps<S> {
    /// The last rate.
    rate: Vec3<S>,
    /// The usual step in s; zero until there has been one, which the first sample is not.
    usual: S,
}

impl<S: Scalar> Default for Steps<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Steps<S> {
    /// Before the first step.
    pub fn new() -> Self {
        Steps { rate: Vec3::zero(), usual: S::zero() }
    }

    /// Goes on by `dt` to the angular rate; gives the variance of the angle that is not known, in rad².
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn slip(&mut self, rate: Vec3<S>, dt: S) -> S {
        // The first step is the usual one: nothing is odd, whatever the change.
        let usual = S::select(self.usual.le(S::zero()), dt, self.usual);
        let odd = (dt - usual).abs();
        let across = S::of(0.5) * (rate - self.rate).norm2().sqrt() + S::of(CURVATURE) * rate.norm2().sqrt();
        let longest = S::of(2.0) * usual + S::of(SHORTEST_STEP);
        self.usual = usual + S::of(STEP_GAIN) * (dt.min(longest) - usual);
        self.rate = rate;
        let angle = (across * odd).min(S::of(LARGEST_SLIP));
        angle * angle
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.rate.each(visit);
        visit(&mut self.usual);
    }
}

/// The rate as it is used for noise and delay: not beyond what turns.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn bounded_rate<S: Scalar>(rate: Vec3<S>) -> Vec3<S> {
    saturated(rate, S::of(LARGEST_RATE))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn nothing<S: Scalar>() -> Matrix3<S> {
    Matrix3 { x: Vec3::zero(), y: Vec3::zero(), z: Vec3::zero() }
}

/// A + f B.
#[cfg_attr(not(debug_assertions), inline(always))]
fn plus<S: Scalar>(a: Matrix3<S>, b: Matrix3<S>, f: S) -> Matrix3<S> {
    Matrix3 { x: a.x + b.x * f, y: a.y + b.y * f, z: a.z + b.z * f }
}
