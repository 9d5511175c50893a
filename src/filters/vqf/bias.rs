//! Estimation of the gyroscope's bias (Laidig & Seel 2023): a Kalman filter of three constant states.
//!
//! In motion the rate by which the inclination has to be corrected shows the horizontal part of the bias, seen through the
//! low-pass filter of the accelerometer; the vertical part is forgotten slowly. At rest the angular rate is the bias.
//! Variances are in (0.01 °/s)², the bias in rad/s.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::super::error_state::ErrorState;
use super::super::kalman::{Square, column, diagonal, plus, product, sum3, symmetric, vec3};
use crate::scalar::{Mask, Scalar};
use crate::signal::{Coefficients, LowPass, Sum};
use crate::so3::{Matrix3, Vec3};

/// Variances are in the square of this part of a °/s.
const UNIT: f64 = 0.01;
/// 0.01 °/s in rad/s.
const UNIT_RATE: f64 = UNIT * core::f64::consts::PI / 180.0;
/// The standard deviation in °/s to which the bias walks within the forgetting time.
const FORGOTTEN: f64 = 0.1;
/// The least vertical forgetting factor.
const LEAST_FORGETTING: f64 = 1e-10;

/// The parameters of the estimation: standard deviations in °/s, as published.
#[derive(Clone, Debug)]
pub struct Uncertainty<S> {
    /// At the start.
    pub initial: S,
    /// Time in s in which a standard deviation of 0.1 °/s is forgotten.
    pub forgetting_time: S,
    /// In motion, in the steady state.
    pub motion: S,
    /// At rest, in the steady state.
    pub rest: S,
    /// How much of the horizontal information the vertical direction gets.
    pub vertical_forgetting: S,
}

/// Variances for a time between measurements.
#[derive(Clone, Copy, Debug)]
struct Noise<S> {
    /// The time; negative before the first.
    interval: S,
    /// What the bias walks in it.
    walk: S,
    /// Of a measurement in motion, horizontal and vertical, and at rest.
    motion: S,
    vertical: S,
    rest: S,
}

/// The estimate of the gyroscope's bias.
#[derive(Clone, Debug)]
pub struct Bias<S: Scalar> {
    uncertainty: Uncertainty<S>,
    noise: Noise<S>,
    value: [Sum<S>; 3],
    error: ErrorState<S, 3>,
    /// The rows of the rotation matrix, and the horizontal bias in the earth frame, low-pass filtered as the specific force.
    seen: LowPass<S, 11>,
}

impl<S: Scalar> Bias<S> {
    /// Before the first sample.
    pub fn new(uncertainty: Uncertainty<S>) -> Self {
        let zero = S::zero();
        Bias {
            noise: Noise { interval: -S::one(), walk: zero, motion: zero, vertical: zero, rest: zero },
            value: [Sum::new(zero); 3],
            error: ErrorState::new(diagonal(|_| variance(uncertainty.initial))),
            seen: LowPass::default(),
            uncertainty,
        }
    }

    /// The bias in rad/s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn value(&self) -> Vec3<S> {
        let [x, y, z] = self.value;
        Vec3::new(x.value, y.value, z.value)
    }

    /// Its standard deviation in rad/s: of the largest eigenvalue an upper bound, and never more than at the start.
    pub fn sigma(&self) -> S {
        largest(&self.error.p).min(variance(self.uncertainty.initial)).sqrt() * S::of(UNIT_RATE)
    }

    /// The attitude `r` is new where the mask is true: it counts as that of a long time.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn restart(&mut self, lanes: S::Mask, r: Matrix3<S>, coefficients: &Coefficients<S>) {
        self.seen.set(lanes, self.shown_by(r), coefficients);
    }

    /// The rows of the rotation matrix, and the horizontal bias in the earth frame.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn shown_by(&self, r: Matrix3<S>) -> [S; 11] {
        let bias = self.value();
        [r.x.x, r.x.y, r.x.z, r.y.x, r.y.y, r.y.z, r.z.x, r.z.y, r.z.z, r.x.dot(bias), r.y.dot(bias)]
    }

    /// Takes what a sample of the accelerometer shows where the mask is true.
    ///
    /// `r` is the attitude after the inclination's correction and `up` the direction of the low-pass filtered force before
    /// it, both in the earth frame; the sample comes `interval` after the one before. At `rest` the angular rate `rate` is
    /// the bias; where that is not so the sample counts if `in_motion`. No error counts more than `clip` (rad/s).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(
        &mut self,
        lanes: S::Mask,
        (r, up): (Matrix3<S>, Vec3<S>),
        (interval, coefficients): (S, &Coefficients<S>),
        (rest, rate): (S::Mask, Vec3<S>),
        in_motion: bool,
        clip: S,
    ) {
        let bias = self.value();
        let shown = self.shown_by(r);
        let [xx, xy, xz, yx, yy, yz, zx, zy, zz, east, north] = self.seen.step(lanes, shown, coefficients);
        let (seen_x, seen_y, seen_z) = (Vec3::new(xx, xy, xz), Vec3::new(yx, yy, yz), Vec3::new(zx, zy, zz));

        // Nothing is known of no time.
        let lanes = lanes & S::zero().lt(interval);
        if !lanes.any() {
            return;
        }
        self.set_interval(lanes, interval);
        let (noise, initial) = (self.noise, variance(self.uncertainty.initial));
        let mut p = self.error.p;
        for i in 0..3 {
            p[(i, i)] = S::select(p[(i, i)].lt(initial), p[(i, i)] + noise.walk, p[(i, i)]);
        }
        self.error.set_covariance(lanes, &p);

        let lanes = if in_motion { lanes } else { lanes & rest };
        if !lanes.any() {
            return;
        }
        let (one, zero) = (S::one(), S::zero());
        let known = rate - bias;
        let measurements = [
            (Vec3::new(one, zero, zero), known.x, seen_x, east - up.y / interval, noise.motion),
            (Vec3::new(zero, one, zero), known.y, seen_y, north + up.x / interval, noise.motion),
            (Vec3::new(zero, zero, one), known.z, seen_z, zero, noise.vertical),
        ];
        for (axis, error_at_rest, seen, shown, in_motion) in measurements {
            let h = Vec3::select(rest, axis, seen);
            let z = S::select(rest, error_at_rest, shown - seen.dot(bias)).min(clip).max(-clip);
            self.error.measure_plainly::<0, 3>(lanes, [h.x, h.y, h.z], z, S::select(rest, noise.rest, in_motion));
        }
        let correction = self.error.take(|| diagonal(|_| initial));
        for (sum, term) in self.value.iter_mut().zip(correction.iter()) {
            let corrected = sum.plus(*term);
            let corrected = corrected.with_value(corrected.value.min(clip).max(-clip));
            *sum = Sum::select(lanes, corrected, *sum);
        }
    }

    /// The variances for the time between two measurements.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_interval(&mut self, lanes: S::Mask, interval: S) {
        let interval = S::select(lanes, interval, self.noise.interval);
        if (interval.lt(self.noise.interval) | self.noise.interval.lt(interval)).any() {
            let of = &self.uncertainty;
            // A bias that is forgotten altogether has the variance of the start.
            let walk = (variance(S::of(FORGOTTEN)) * interval / of.forgetting_time).min(variance(of.initial));
            let motion = measured(variance(of.motion), walk);
            let vertical = motion / of.vertical_forgetting.max(S::of(LEAST_FORGETTING));
            self.noise = Noise { interval, walk, motion, vertical, rest: measured(variance(of.rest), walk) };
        }
    }

    /// The covariance in (0.01 °/s)².
    pub fn covariance(&self) -> Square<S, 3> {
        self.error.p
    }

    /// The estimate as it is now.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn estimate(&self) -> Estimate<S> {
        Estimate { value: self.value(), covariance: self.error.p }
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        for sum in &mut self.value {
            sum.each(visit);
        }
        self.error.each(visit);
        self.seen.each(visit);
    }
}

/// An estimate of the bias that is looked at after its time.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<S: Scalar> {
    /// The bias in rad/s.
    pub value: Vec3<S>,
    /// Its covariance in (0.01 °/s)².
    covariance: Square<S, 3>,
}

impl<S: Scalar> Estimate<S> {
    /// The best estimate from two that do not know of each other: weighed by their information P₁⁻¹ and P₂⁻¹, here with
    /// K = P₁ (P₁ + P₂)⁻¹ as b₁ + K (b₂ − b₁) and K P₂, which needs neither of them to have an inverse.
    pub fn joined(&self, other: &Self) -> Self {
        let (p1, p2) = (&self.covariance, &other.covariance);
        let k = product(p1, &inverse(&plus(p1, p2)));
        let correction = product(&k, &column(other.value - self.value));
        Estimate {
            value: self.value + vec3(&correction, 0),
            covariance: symmetric(|i, j| sum3(|n| k[(i, n)] * p2[(n, j)])),
        }
    }

    /// The estimate in one lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn lane(&self, index: usize) -> Estimate<S::Real> {
        let Vec3 { x, y, z } = self.value;
        Estimate {
            value: Vec3::new(x.lane(index), y.lane(index), z.lane(index)),
            covariance: symmetric(|i, j| self.covariance[(i, j)].lane(index)),
        }
    }

    /// An upper bound on its standard deviation in rad/s.
    pub fn sigma(&self) -> S {
        largest(&self.covariance).sqrt() * S::of(UNIT_RATE)
    }
}

/// The inverse of a covariance by its cofactors; zeros where it has none.
fn inverse<S: Scalar>(p: &Square<S, 3>) -> Square<S, 3> {
    let minor = |i: usize, j: usize| {
        let ([a, b], [c, d]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
        p[(a, c)] * p[(b, d)] - p[(a, d)] * p[(b, c)]
    };
    let determinant = sum3(|j| p[(0, j)] * minor(0, j));
    let over = S::select(determinant.is_normal_norm2(), S::one() / determinant, S::zero());
    symmetric(|i, j| minor(i, j) * over)
}

/// The bound on the largest eigenvalue of a covariance: the largest sum of absolute values of a row.
#[cfg_attr(not(debug_assertions), inline(always))]
fn largest<S: Scalar>(p: &Square<S, 3>) -> S {
    let sum = |row: [S; 3]| row.iter().fold(S::zero(), |sum, entry| sum + entry.abs());
    (0..3).fold(S::zero(), |largest, i| largest.max(sum([p[(i, 0)], p[(i, 1)], p[(i, 2)]])))
}

/// The variance in (0.01 °/s)² of a standard deviation in °/s.
#[cfg_attr(not(debug_assertions), inline(always))]
fn variance<S: Scalar>(sigma: S) -> S {
    let units = sigma * S::of(1.0 / UNIT);
    units * units
}

/// The variance w of a measurement with which the variance comes to p where the walk v is added in every step, from
/// p = (p + v) w/(p + v + w).
#[cfg_attr(not(debug_assertions), inline(always))]
fn measured<S: Scalar>(p: S, walk: S) -> S {
    p * p / walk + p
}
