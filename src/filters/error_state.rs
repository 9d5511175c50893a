//! The error of a state and its covariance, corrected by one scalar measurement at a time.
//!
//! The measurement covariances are diagonal, so a vector is taken component after component: no inverse is needed, and
//! the result is that of the whole vector.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]
#![allow(clippy::needless_range_loop, reason = "a counter with known bounds: see `filled`")]

use super::kalman::{Column, Square, filled, select, zeros};
use crate::scalar::{Mask, Real, Scalar};

/// How much of the old diagonal is added in every correction, in epsilons of the scalar: more than the typical rounding.
const ROUNDING: f64 = 4.0;

/// Where a normalised innovation squared stops counting, so that sums of some are finite in `f32`.
const LARGEST_NIS: f64 = 1e30;

/// The error of a state while measurements come in one after the other, and its covariance.
#[derive(Clone, Debug)]
pub struct ErrorState<S: Scalar, const N: usize> {
    /// The correction of the state so far.
    pub x: Column<S, N>,
    /// The covariance of what is left.
    pub p: Square<S, N>,
}

/// A scalar measurement seen from an error state.
#[derive(Clone, Copy, Debug)]
pub struct Innovation<S: Scalar, const N: usize> {
    /// P hᵀ.
    pub ph: Column<S, N>,
    /// The innovation, less what is corrected already.
    pub nu: S,
    /// Its variance h P hᵀ + r.
    pub s: S,
}

impl<S: Scalar, const N: usize> Innovation<S, N> {
    /// The innovation squared over its variance.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn nis(&self) -> S {
        (self.nu * (self.nu / self.s)).min(S::of(LARGEST_NIS))
    }
    /// P hᵀ/s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn gain(&self) -> Column<S, N> {
        let over_s = S::one() / self.s;
        filled(|i, _| self.ph[i] * over_s)
    }
}

impl<S: Scalar, const N: usize> ErrorState<S, N> {
    /// Before any measurement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(p: Square<S, N>) -> Self {
        ErrorState { x: zeros(), p }
    }

    /// The measurement `z` = h x with variance `r`, h given by its entries from `START` on.
    #[cfg_attr(all(not(debug_assertions), not(target_os = "none")), inline(always))]
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn innovation<const START: usize, const K: usize>(&self, h: [S; K], z: S, r: S) -> Innovation<S, N> {
        let mut ph: Column<S, N> = filled(|i, _| self.p[(i, START)] * h[0]);
        let mut predicted = h[0] * self.x[START];
        for k in 1..K {
            ph = filled(|i, _| ph[i] + self.p[(i, START + k)] * h[k]);
            predicted = predicted + h[k] * self.x[START + k];
        }
        let mut s = h[0] * ph[START];
        for k in 1..K {
            s = s + h[k] * ph[START + k];
        }
        Innovation { ph, nu: z - predicted, s: s + r }
    }

    /// Corrects by the measurement `z` = h x of variance `r` where the mask is true, and gives its normalised innovation
    /// squared.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn measure<const START: usize, const K: usize>(&mut self, lanes: S::Mask, h: [S; K], z: S, r: S) -> S {
        let innovation = self.innovation::<START, K>(h, z, r);
        self.correct(lanes, &innovation)
    }

    /// Corrects by an innovation where the mask is true, and gives its normalised square: x + v ν/s, P − v vᵀ/s with v = P hᵀ.
    ///
    /// With the optimal gain that is Joseph's form; every product is formed so that it is the same for (i, j) and (j, i),
    /// and the diagonal grows by more than the typical rounding, so that P stays symmetric to the last bit and positive
    /// definite. Nothing is corrected where the variance of the innovation is not a positive number.
    #[cfg_attr(all(not(debug_assertions), not(target_os = "none")), inline(always))]
    #[cfg_attr(target_os = "none", inline(never))]
    fn correct(&mut self, lanes: S::Mask, innovation: &Innovation<S, N>) -> S {
        let Innovation { ph: v, nu, s } = innovation;
        let over_s = S::one() / *s;
        let nu_over_s = *nu * over_s;
        self.update(lanes, *s, |i, j| (v[i] * v[j]) * over_s, |i| v[i] * nu_over_s);
        (*nu * nu_over_s).min(S::of(LARGEST_NIS))
    }

    /// [`ErrorState::measure`] without the growth of the diagonal, for small states whose process noise is far above the
    /// rounding but would not be above that growth: at high rates in `f32`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn measure_plainly<const START: usize, const K: usize>(&mut self, lanes: S::Mask, h: [S; K], z: S, r: S) {
        let Innovation { ph: v, nu, s } = self.innovation::<START, K>(h, z, r);
        let lanes = lanes & s.is_normal_norm2();
        let over_s = S::select(lanes, S::one() / s, S::zero());
        let nu = S::select(lanes, nu, S::zero());
        for j in 0..N {
            let gain = v[j] * over_s;
            self.x[j] = self.x[j] + gain * nu;
            for i in 0..=j {
                let left = self.p[(i, j)] - v[i] * gain;
                self.p[(i, j)] = left;
                self.p[(j, i)] = left;
            }
        }
    }

    /// Corrects with any gain k, P − k vᵀ − v kᵀ + s k kᵀ (Joseph's form), as k aᵀ + a kᵀ with a = v − ½ s k.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn correct_by(&mut self, lanes: S::Mask, innovation: &Innovation<S, N>, k: &Column<S, N>) {
        let Innovation { ph, nu, s } = innovation;
        let half_s = S::of(0.5) * *s;
        let a: Column<S, N> = filled(|i, _| ph[i] - half_s * k[i]);
        self.update(lanes, *s, |i, j| k[i] * a[j] + a[i] * k[j], |i| k[i] * *nu);
    }

    /// Takes `loss` from the covariance and adds `step` to the correction where the mask is true and `s` a positive number.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn update(&mut self, lanes: S::Mask, s: S, loss: impl Fn(usize, usize) -> S, step: impl Fn(usize) -> S) {
        let lanes = lanes & s.is_normal_norm2();
        if !lanes.any() {
            return;
        }
        let old = if lanes.all() { None } else { Some(self.clone()) };
        let rounding = S::of(ROUNDING) * S::splat(S::Real::EPSILON);
        for j in 0..N {
            let spare = self.p[(j, j)] * rounding;
            for i in 0..N {
                self.p[(i, j)] = self.p[(i, j)] - loss(i, j);
            }
            self.p[(j, j)] = self.p[(j, j)] + spare;
            self.x[j] = self.x[j] + step(j);
        }
        if let Some(old) = old {
            self.p = select(lanes, &self.p, &old.p);
            self.x = select(lanes, &self.x, &old.x);
        }
    }

    /// The correction of the step, which is over with it. There is none, and the covariance starts afresh, where the numbers
    /// have left the range of the scalar or a variance is negative: a last resort for variances that differ by more than
    /// the scalar's precision.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn take(&mut self, start: impl FnOnce() -> Square<S, N>) -> Column<S, N> {
        // What is not a number beside the diagonal reaches it in the next prediction.
        let mut total = S::zero();
        let mut sound = S::Mask::splat(true);
        for j in 0..N {
            total = total + (self.x[j].abs() + self.p[(j, j)]);
            sound = sound & S::zero().le(self.p[(j, j)]);
        }
        let sound = sound & total.le(S::splat(S::Real::MAX));
        let x = core::mem::replace(&mut self.x, zeros());
        if sound.all() {
            return x;
        }
        self.p = select(sound, &self.p, &start());
        select(sound, &x, &zeros())
    }

    /// Takes over a covariance where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn set_covariance(&mut self, lanes: S::Mask, p: &Square<S, N>) {
        self.p = select(lanes, p, &self.p);
    }

    /// Calls `visit` for each variable: the covariance, as the correction is taken over at the end of every step.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.p.iter_mut().for_each(visit);
    }
}
