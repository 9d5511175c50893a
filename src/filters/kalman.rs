//! What the Kalman filters share: matrices and covariances. Products are written out over [`Scalar`]: lanes are no field for
//! nalgebra, and its own products take other orders of summation with other features.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]
#![allow(clippy::needless_range_loop, reason = "a counter with known bounds: see `filled`")]

use core::f64::consts::PI;
use core::ops::Range;

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

/// What stands in an output for a measurement that there is not.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn none<S: Scalar>() -> S {
    S::splat(S::Real::NAN)
}

/// Three of them.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn none3<S: Scalar>() -> Vec3<S> {
    Vec3::new(none(), none(), none())
}

/// A matrix from its entries. Written out, as all that follows, with one place where the entry is computed: what is not
/// inlined there is not compiled for the vector registers of the lanes, and is slower by an order of magnitude.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn filled<S: Scalar, const R: usize, const C: usize>(entry: impl Fn(usize, usize) -> S) -> SMatrix<S, R, C> {
    let mut columns = [[S::zero(); R]; C];
    // By counters: their bounds are known where the compiler does not unroll the loops, and so the entry does not panic.
    for j in 0..C {
        for i in 0..R {
            columns[j][i] = entry(i, j);
        }
    }
    SMatrix::from(columns)
}

/// The transpose.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn transposed<S: Scalar, const R: usize, const C: usize>(a: &SMatrix<S, R, C>) -> SMatrix<S, C, R> {
    filled(|i, j| a[(j, i)])
}

/// Nothing in every entry.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn zeros<S: Scalar, const R: usize, const C: usize>() -> SMatrix<S, R, C> {
    SMatrix::from([[S::zero(); R]; C])
}

/// A diagonal matrix.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn diagonal<S: Scalar, const N: usize>(entry: impl Fn(usize) -> S) -> Square<S, N> {
    filled(|i, j| if i == j { entry(i) } else { S::zero() })
}

/// A symmetric matrix from its upper triangle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn symmetric<S: Scalar>(upper: impl Fn(usize, usize) -> S) -> Square<S, 3> {
    const PLACES: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let mut entries = [S::zero(); 6];
    for (entry, (i, j)) in entries.iter_mut().zip(PLACES) {
        // As it is; said where the table is not unrolled.
        *entry = upper(i.min(2), j.min(2));
    }
    let [xx, xy, xz, yy, yz, zz] = entries;
    SMatrix::from([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
}

/// The sum of three terms.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn sum3<S: Scalar>(term: impl Fn(usize) -> S) -> S {
    let mut terms = [S::zero(); 3];
    for k in 0..3 {
        terms[k] = term(k);
    }
    let [a, b, c] = terms;
    (a + b) + c
}

/// A B.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn product<S: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<S, R, K>,
    b: &SMatrix<S, K, C>,
) -> SMatrix<S, R, C> {
    filled(|i, j| {
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
    filled(|i, j| a[(i, j)] + b[(i, j)])
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
    filled(|i, j| p[(I + i, J + j)])
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
    filled(|i, j| S::select(mask, yes[(i, j)], no[(i, j)]))
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
    SMatrix::from([[r.x.x, r.y.x, r.z.x], [r.x.y, r.y.y, r.z.y], [r.x.z, r.y.z, r.z.z]])
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

/// The covariance with its diagonal grown by more than the rounding of a step.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn inflate<S: Scalar, const N: usize>(p: &mut Square<S, N>) {
    let factor = S::one() + S::of(INFLATION) * S::splat(S::Real::EPSILON);
    for i in 0..N {
        p[(i, i)] = p[(i, i)] * factor;
    }
}

/// The variance of an angle with this standard deviation in rad: at most that of an angle of which nothing is known. A larger
/// one says no more, and beside it `f32` has no room for the other angles.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn angle_variance<S: Scalar>(deviation: S) -> S {
    (deviation * deviation).min(S::of(UNKNOWN_ANGLE))
}

/// Brings each variance down to its cap.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn cap<S: Scalar, const N: usize>(p: &mut Square<S, N>, caps: impl Fn(usize) -> S) {
    for i in 0..N {
        cap_group(p, i..i + 1, caps(i));
    }
}

/// Brings the mean variance of a group of indices down to a cap: their rows and columns are scaled, so that correlations
/// stay. Unlike each variance the mean does not depend on the choice of axes.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn cap_group<S: Scalar, const N: usize>(p: &mut Square<S, N>, group: Range<usize>, cap: S) {
    let mut sum = p[(group.start, group.start)];
    for i in group.start + 1..group.end {
        sum = sum + p[(i, i)];
    }
    let mean = sum * S::of(1.0 / group.len() as f64);
    let over = cap.lt(mean);
    if over.any() {
        let factor = S::select(over, (cap / mean).sqrt(), S::one());
        for i in group {
            for j in 0..N {
                p[(i, j)] = p[(i, j)] * factor;
                p[(j, i)] = p[(j, i)] * factor;
            }
        }
    }
}

/// Where the vertical of a new attitude is not that of the old one, so that what was known of the inclination is void.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn new_vertical<S: Scalar>(old: Quat<S>, new: Quat<S>) -> S::Mask {
    S::of(SAME_VERTICAL * SAME_VERTICAL).lt((new.matrix().z - old.matrix().z).norm2())
}

/// I − u uᵀ: what is across the unit vector u.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn across<S: Scalar>(u: &Column<S, 3>) -> Square<S, 3> {
    symmetric(|i, j| if i == j { S::one() - u[i] * u[j] } else { -(u[i] * u[j]) })
}

/// The attitude's covariance (sensor frame, rad²) as it is reported: where the heading is not known, or its variance is
/// beyond that of an unknown angle, the error about the vertical `up` counts as uniform and as independent of the
/// inclination's.
pub fn reported<S: Scalar>(p: &Square<S, 3>, up: Vec3<S>, heading_known: S::Mask) -> Square<S, 3> {
    let u = column(up);
    let about_up = sum3(|i| u[i] * sum3(|j| p[(i, j)] * u[j]));
    let known = heading_known & about_up.le(S::of(UNKNOWN_ANGLE));
    let inclination = congruent(&across(&u), p);
    let unknown = symmetric(|i, j| inclination[(i, j)] + S::of(UNKNOWN_ANGLE) * u[i] * u[j]);
    select(known, p, &unknown)
}

/// Calls `put` with the entries, row by row.
pub fn put_rows<S: Scalar>(p: &Square<S, 3>, put: &mut impl FnMut(S)) {
    p.transpose().iter().for_each(|entry| put(*entry));
}
