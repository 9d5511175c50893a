//! What the Kalman filters share: covariances, and the correction by one scalar measurement at a time.
//!
//! The measurement covariances are diagonal, so a vector is taken component after component: no inverse is needed,
//! and the result is that of the whole vector. Products are written out over [`Scalar`]: lanes are no field for
//! nalgebra, and its own products take other orders of summation with other features.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use core::f64::consts::PI;

use nalgebra::{SMatrix, SVector};

use crate::filter::OutputSpec;
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Matrix3, Quat, Vec3};

/// A covariance, or another square matrix.
pub type Square<S, const N: usize> = SMatrix<S, N, N>;
/// A state's error, or a column of a matrix.
pub type Column<S, const N: usize> = SVector<S, N>;

/// The variance of an angle of which nothing is known, uniform on [−π, π], in rad².
pub const UNKNOWN_ANGLE: f64 = PI * PI / 3.0;

/// How much the diagonal of a covariance grows in every prediction, in epsilons of the scalar: more than the rounding of
/// a step takes away, so that it stays positive definite in long runs at rest.
const INFLATION: f64 = 8.0;

/// The same for every correction.
const ROUNDING: f64 = 4.0;

/// Where a normalised innovation squared stops counting, so that sums of some are finite in `f32`.
const LARGEST_NIS: f64 = 1e30;

/// The largest specific force that is used, in g, and the largest field, in norms of its reference.
pub const SATURATION: f64 = 16.0;

/// The largest bias, in its standard deviations at the start.
pub const LARGEST_BIAS: f64 = 20.0;

/// An attitude whose vertical is off by less than this many rad only turns about the vertical.
const SAME_VERTICAL: f64 = 1e-4;

/// The covariance that a filter without a magnetometer gives.
pub const LEVEL_COVARIANCE: OutputSpec = OutputSpec {
    name: "covariance",
    doc: "covariance of the attitude error in the sensor frame, rad²; π²/3 about the vertical",
    shape: &[3, 3],
};

/// Nothing in every entry.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn zeros<S: Scalar, const R: usize, const C: usize>() -> SMatrix<S, R, C> {
    SMatrix::from_fn(|_, _| S::zero())
}

/// A diagonal matrix.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn diagonal<S: Scalar, const N: usize>(entry: impl Fn(usize) -> S) -> Square<S, N> {
    SMatrix::from_fn(|i, j| if i == j { entry(i) } else { S::zero() })
}

/// A symmetric matrix from its upper triangle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn symmetric<S: Scalar>(upper: impl Fn(usize, usize) -> S) -> Square<S, 3> {
    let (xy, xz, yz) = (upper(0, 1), upper(0, 2), upper(1, 2));
    SMatrix::from([[upper(0, 0), xy, xz], [xy, upper(1, 1), yz], [xz, yz, upper(2, 2)]])
}

/// The sum of three terms.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn sum3<S: Scalar>(term: impl Fn(usize) -> S) -> S {
    (term(0) + term(1)) + term(2)
}

/// A B.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn product<S: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<S, R, K>,
    b: &SMatrix<S, K, C>,
) -> SMatrix<S, R, C> {
    SMatrix::from_fn(|i, j| {
        let mut sum = a[(i, 0)] * b[(0, j)];
        for k in 1..K {
            sum = sum + a[(i, k)] * b[(k, j)];
        }
        sum
    })
}

/// A + B.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn plus<S: Scalar, const R: usize, const C: usize>(a: &SMatrix<S, R, C>, b: &SMatrix<S, R, C>) -> SMatrix<S, R, C> {
    a.zip_map(b, |a, b| a + b)
}

/// A P Aᵀ, symmetric as P is.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn congruent<S: Scalar>(a: &Square<S, 3>, p: &Square<S, 3>) -> Square<S, 3> {
    let ap = product(a, p);
    symmetric(|i, j| sum3(|k| ap[(i, k)] * a[(j, k)]))
}

/// The block of a matrix at a place.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn block<S: Scalar, const I: usize, const J: usize, const R: usize, const C: usize, const N: usize>(
    p: &Square<S, N>,
) -> SMatrix<S, R, C> {
    SMatrix::from_fn(|i, j| p[(I + i, J + j)])
}

/// Writes a block above the diagonal, and its transpose below.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn set_block<S: Scalar, const I: usize, const J: usize, const R: usize, const C: usize, const N: usize>(
    p: &mut Square<S, N>,
    entries: &SMatrix<S, R, C>,
) {
    for i in 0..R {
        for j in 0..C {
            p[(I + i, J + j)] = entries[(i, j)];
            p[(J + j, I + i)] = entries[(i, j)];
        }
    }
}

/// `yes` where the mask is true, else `no`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn select<S: Scalar, const R: usize, const C: usize>(
    mask: S::Mask,
    yes: &SMatrix<S, R, C>,
    no: &SMatrix<S, R, C>,
) -> SMatrix<S, R, C> {
    if mask.all() {
        return *yes;
    }
    SMatrix::from_fn(|i, j| S::select(mask, yes[(i, j)], no[(i, j)]))
}

/// The three components as a column.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn column<S: Scalar>(v: Vec3<S>) -> Column<S, 3> {
    SVector::from([v.x, v.y, v.z])
}

/// Three entries of a column, from `start` on, as a vector.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn vec3<S: Scalar, const N: usize>(c: &Column<S, N>, start: usize) -> Vec3<S> {
    Vec3::new(c[start], c[start + 1], c[start + 2])
}

/// A rotation matrix of the mathematics of rotations as one of nalgebra.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn rows<S: Scalar>(r: Matrix3<S>) -> Square<S, 3> {
    let (x, y, z) = (column(r.x), column(r.y), column(r.z));
    SMatrix::from_fn(|i, j| [x, y, z].get(i).map_or(S::zero(), |row| row[j]))
}

/// [v×], the matrix with [v×] w = v × w.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn skew<S: Scalar>(v: Vec3<S>) -> Square<S, 3> {
    let o = S::zero();
    SMatrix::from([[o, v.z, -v.y], [-v.z, o, v.x], [v.y, -v.x, o]])
}

/// The vector, shortened to `limit` where it is longer.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn saturated<S: Scalar>(v: Vec3<S>, limit: S) -> Vec3<S> {
    let norm2 = v.norm2();
    let long = (limit * limit).lt(norm2);
    if long.any() { Vec3::select(long, v * (limit / norm2.sqrt()), v) } else { v }
}

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
        self.ph.map(|entry| entry * over_s)
    }
}

impl<S: Scalar, const N: usize> ErrorState<S, N> {
    /// Before any measurement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(p: Square<S, N>) -> Self {
        ErrorState { x: zeros(), p }
    }

    /// The measurement `z` = h x with variance `r`, h given by its entries from `START` on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn innovation<const START: usize, const K: usize>(&self, h: [S; K], z: S, r: S) -> Innovation<S, N> {
        let h = SVector::<S, K>::from(h);
        let mut ph: Column<S, N> = SVector::from_fn(|i, _| self.p[(i, START)] * h[0]);
        let mut predicted = h[0] * self.x[START];
        for k in 1..K {
            ph = SVector::from_fn(|i, _| ph[i] + self.p[(i, START + k)] * h[k]);
            predicted = predicted + h[k] * self.x[START + k];
        }
        let mut s = h[0] * ph[START];
        for k in 1..K {
            s = s + h[k] * ph[START + k];
        }
        Innovation { ph, nu: z - predicted, s: s + r }
    }

    /// Corrects by an innovation where the mask is true, and gives its normalised square: x + v ν/s, P − v vᵀ/s with v = P hᵀ.
    ///
    /// With the optimal gain that is Joseph's form; every product is formed so that it is the same for (i, j) and (j, i),
    /// and the diagonal grows by more than the typical rounding, so that P stays symmetric to the last bit and positive
    /// definite. Nothing is corrected where the variance of the innovation is not a positive number.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn correct(&mut self, lanes: S::Mask, innovation: &Innovation<S, N>) -> S {
        let Innovation { ph: v, nu, s } = innovation;
        let over_s = S::one() / *s;
        let nu_over_s = *nu * over_s;
        self.update(lanes, *s, |i, j| (v[i] * v[j]) * over_s, |i| v[i] * nu_over_s);
        (*nu * nu_over_s).min(S::of(LARGEST_NIS))
    }

    /// Corrects with any gain k, P − k vᵀ − v kᵀ + s k kᵀ (Joseph's form), as k aᵀ + a kᵀ with a = v − ½ s k.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn correct_by(&mut self, lanes: S::Mask, innovation: &Innovation<S, N>, k: &Column<S, N>) {
        let Innovation { ph, nu, s } = innovation;
        let half_s = S::of(0.5) * *s;
        let a: Column<S, N> = ph.zip_map(k, |v, k| v - half_s * k);
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

    /// Starts afresh, without a correction, where the numbers have left the range of the scalar or a variance is negative: a
    /// last resort for variances that differ by more than the scalar's precision.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn mend(&mut self, start: impl FnOnce() -> Square<S, N>) {
        // What is not a number beside the diagonal reaches it in the next prediction.
        let mut total = S::zero();
        let mut sound = S::Mask::splat(true);
        for j in 0..N {
            total = total + (self.x[j].abs() + self.p[(j, j)]);
            sound = sound & S::zero().le(self.p[(j, j)]);
        }
        let sound = sound & total.le(S::splat(S::Real::MAX));
        if !sound.all() {
            self.p = select(sound, &self.p, &start());
            self.x = select(sound, &self.x, &zeros());
        }
    }

    /// Changes the covariance where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn predict(&mut self, lanes: S::Mask, change: impl FnOnce(&mut Square<S, N>)) {
        if lanes.all() {
            change(&mut self.p);
        } else if lanes.any() {
            let old = self.p;
            change(&mut self.p);
            self.p = select(lanes, &self.p, &old);
        }
    }

    /// Calls `visit` for each variable: the covariance, as the correction is taken over at the end of every step.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.p.iter_mut().for_each(visit);
    }
}

/// The covariance with its diagonal grown by more than the rounding of a step.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn inflate<S: Scalar, const N: usize>(p: &mut Square<S, N>) {
    let factor = S::one() + S::of(INFLATION) * S::splat(S::Real::EPSILON);
    for i in 0..N {
        p[(i, i)] = p[(i, i)] * factor;
    }
}

/// Brings variances down to a cap, those of one index after the other: rows and columns are scaled, so that
/// correlations stay.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn cap<S: Scalar, const N: usize>(p: &mut Square<S, N>, caps: impl Fn(usize) -> S) {
    for i in 0..N {
        let variance = p[(i, i)];
        let over = caps(i).lt(variance);
        if over.any() {
            scale(p, i, S::select(over, (caps(i) / variance).sqrt(), S::one()));
        }
    }
}

/// Scales row and column `i`.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn scale<S: Scalar, const N: usize>(p: &mut Square<S, N>, i: usize, factor: S) {
    for j in 0..N {
        p[(i, j)] = p[(i, j)] * factor;
        p[(j, i)] = p[(j, i)] * factor;
    }
}

/// Where the vertical of a new attitude is not that of the old one, so that what was known of the inclination is void.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn new_vertical<S: Scalar>(old: Quat<S>, new: Quat<S>) -> S::Mask {
    S::of(SAME_VERTICAL * SAME_VERTICAL).lt((new.matrix().z - old.matrix().z).norm2())
}

/// The attitude's covariance (sensor frame, rad²) as it is reported: where the heading is not known, or its variance is
/// beyond that of an unknown angle, the error about the vertical `up` counts as uniform and as independent of the
/// inclination's.
pub fn reported<S: Scalar>(p: &Square<S, 3>, up: Vec3<S>, heading_known: S::Mask) -> Square<S, 3> {
    let u = column(up);
    let about_up = sum3(|i| u[i] * sum3(|j| p[(i, j)] * u[j]));
    let known = heading_known & about_up.le(S::of(UNKNOWN_ANGLE));
    let level = symmetric(|i, j| if i == j { S::one() - u[i] * u[j] } else { -(u[i] * u[j]) });
    let inclination = congruent(&level, p);
    let unknown = symmetric(|i, j| inclination[(i, j)] + S::of(UNKNOWN_ANGLE) * u[i] * u[j]);
    select(known, p, &unknown)
}

/// Calls `put` with the entries, row by row.
pub fn put_rows<S: Scalar>(p: &Square<S, 3>, put: &mut impl FnMut(S)) {
    p.transpose().iter().for_each(|entry| put(*entry));
}
