//! Matrices of quaternions: products, and derivatives by the quaternion.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]
#![allow(clippy::needless_range_loop, reason = "a counter with known bounds: see `filled`")]

use nalgebra::SMatrix;

use super::kalman::Square;
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3, exp_half};
use crate::trig::sin_cos;

/// The sum of four terms.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn dot4<S: Scalar>(term: impl Fn(usize) -> S) -> S {
    let mut terms = [S::zero(); 4];
    for k in 0..4 {
        terms[k] = term(k);
    }
    let [a, b, c, d] = terms;
    (a + b) + (c + d)
}

/// A symmetric matrix from its upper triangle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn symmetric4<S: Scalar>(upper: impl Fn(usize, usize) -> S) -> Square<S, 4> {
    const PLACES: [(usize, usize); 10] =
        [(0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)];
    let mut entries = [S::zero(); 10];
    for (entry, (i, j)) in entries.iter_mut().zip(PLACES) {
        // As it is; said where the table is not unrolled.
        *entry = upper(i.min(3), j.min(3));
    }
    let [ww, wx, wy, wz, xx, xy, xz, yy, yz, zz] = entries;
    SMatrix::from([[ww, wx, wy, wz], [wx, xx, xy, xz], [wy, xy, yy, yz], [wz, xz, yz, zz]])
}

/// The derivative by q of up (0, 0, 1) seen from the sensor.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn up_derivative<S: Scalar>(q: Quat<S>) -> SMatrix<S, 3, 4> {
    let Quat { w, x, y, z } = q.scale(S::of(2.0));
    SMatrix::from([[-y, x, w], [z, w, -x], [-w, z, -y], [x, y, z]])
}

/// The derivative by q of north (0, 1, 0) seen from the sensor.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn north_derivative<S: Scalar>(q: Quat<S>) -> SMatrix<S, 3, 4> {
    let Quat { w, x, y, z } = q.scale(S::of(2.0));
    SMatrix::from([[z, w, -x], [y, -x, -w], [x, y, z], [w, -z, y]])
}

/// The matrix of p → q ⊗ p.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn left<S: Scalar>(q: Quat<S>) -> Square<S, 4> {
    let Quat { w, x, y, z } = q;
    SMatrix::from([[w, x, y, z], [-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
}

/// The matrix of p → p ⊗ q, E of the paper.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn right<S: Scalar>(q: Quat<S>) -> Square<S, 4> {
    let Quat { w, x, y, z } = q;
    SMatrix::from([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])
}

/// Ξ(q): q ⊗ (0, v) = Ξ v.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn xi<S: Scalar>(q: Quat<S>) -> SMatrix<S, 4, 3> {
    let Quat { w, x, y, z } = q;
    SMatrix::from([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
}

/// The derivative of (1, h) by h, column after column.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn first_order<S: Scalar>() -> [[S; 4]; 3] {
    let (o, i) = (S::zero(), S::one());
    [[o, i, o, o], [o, o, i, o], [o, o, o, i]]
}

/// exp(h) = (cos n, h sin n/n), n = |h|, and the columns of its derivative by h: (−s h, s I + c h hᵀ) with s = sin n/n and
/// c = (cos n − s)/n².
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn exponential<S: Scalar>(h: Vec3<S>) -> (Quat<S>, [[S; 4]; 3]) {
    let n2 = h.norm2();
    // Series where the difference would cancel; the terms left out are below 3e-14.
    let mut s = series(n2, [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0]);
    let mut c = series(n2, [-1.0 / 3.0, 1.0 / 30.0, -1.0 / 840.0, 1.0 / 45360.0]);
    let small = n2.lt(S::of(1e-2));
    if !small.all() {
        let n = n2.sqrt();
        let (sin, cos) = sin_cos(n);
        let (wide_s, wide_c) = (sin / n, (cos - sin / n) / n2);
        (s, c) = (S::select(small, s, wide_s), S::select(small, c, wide_c));
    }
    let o = S::zero();
    let [x, y, z] = [[s, o, o], [o, s, o], [o, o, s]];
    (exp_half(h), [derivative(h, h.x, s, c, x), derivative(h, h.y, s, c, y), derivative(h, h.z, s, c, z)])
}

/// A polynomial in n², lowest power first.
#[cfg_attr(not(debug_assertions), inline(always))]
fn series<S: Scalar>(n2: S, terms: [f64; 4]) -> S {
    let [a, b, c, d] = terms;
    ((S::of(d) * n2 + S::of(c)) * n2 + S::of(b)) * n2 + S::of(a)
}

/// A column of the derivative of the exponential: by the component `h_j` of h, with the column `unit` of s I.
#[cfg_attr(not(debug_assertions), inline(always))]
fn derivative<S: Scalar>(h: Vec3<S>, h_j: S, s: S, c: S, unit: [S; 3]) -> [S; 4] {
    let [x, y, z] = unit;
    let along = h * (c * h_j);
    [-(s * h_j), x + along.x, y + along.y, z + along.z]
}
