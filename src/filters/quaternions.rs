//! Matrices of quaternions: products, and derivatives by the quaternion.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use nalgebra::SMatrix;

use super::kalman::Square;
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3, exp_half};
use crate::trig::sin_cos;

/// The sum of four terms.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn dot4<S: Scalar>(term: impl Fn(usize) -> S) -> S {
    (term(0) + term(1)) + (term(2) + term(3))
}

/// A symmetric matrix from its upper triangle.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn symmetric4<S: Scalar>(upper: impl Fn(usize, usize) -> S) -> Square<S, 4> {
    let (a, b, c, d, e, f) = (upper(0, 1), upper(0, 2), upper(0, 3), upper(1, 2), upper(1, 3), upper(2, 3));
    SMatrix::from([[upper(0, 0), a, b, c], [a, upper(1, 1), d, e], [b, d, upper(2, 2), f], [c, e, f, upper(3, 3)]])
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
    left(q).fixed_view::<4, 3>(0, 1).into_owned()
}

/// The derivative of (1, h) by h, column after column.
pub const FIRST_ORDER: [[f64; 4]; 3] = [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// exp(h) = (cos n, h sin n/n), n = |h|, and the columns of its derivative by h: (−s h, s I + c h hᵀ) with s = sin n/n and
/// c = (cos n − s)/n².
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn exponential<S: Scalar>(h: Vec3<S>) -> (Quat<S>, [[S; 4]; 3]) {
    let n2 = h.norm2();
    // Series where the difference would cancel; the terms left out are below 3e-14.
    let series = |terms: [f64; 4]| terms.iter().rev().fold(S::zero(), |sum, term| sum * n2 + S::of(*term));
    let mut s = series([1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0]);
    let mut c = series([-1.0 / 3.0, 1.0 / 30.0, -1.0 / 840.0, 1.0 / 45360.0]);
    let small = n2.lt(S::of(1e-2));
    if !small.all() {
        let n = n2.sqrt();
        let (sin, cos) = sin_cos(n);
        let (wide_s, wide_c) = (sin / n, (cos - sin / n) / n2);
        (s, c) = (S::select(small, s, wide_s), S::select(small, c, wide_c));
    }
    let by = |h_j: S, unit: [f64; 3]| {
        let [x, y, z] = unit.map(|one| S::of(one) * s);
        let along = h * (c * h_j);
        [-(s * h_j), x + along.x, y + along.y, z + along.z]
    };
    (exp_half(h), [by(h.x, [1.0, 0.0, 0.0]), by(h.y, [0.0, 1.0, 0.0]), by(h.z, [0.0, 0.0, 1.0])])
}
