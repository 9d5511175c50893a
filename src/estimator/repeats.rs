//! Rows that repeat the last one of their sensor.

use super::reading::Measured;
use crate::scalar::Scalar;
use crate::so3::Vec3;

/// A sensor that says the same for longer than this, in s, is taken at its word.
const LONGEST: f64 = 1.0;
/// Where a time stops counting, in s.
const LONGEST_TIME: f64 = 1e6;

/// The last row of a sensor.
#[derive(Clone, Debug)]
pub struct Last<S> {
    value: Vec3<S>,
    /// For how long it has been repeated, in s.
    time: S,
}

impl<S: Scalar> Last<S> {
    /// Before the first row.
    pub fn new() -> Self {
        Last { value: Vec3::zero(), time: S::zero() }
    }

    /// Goes on by `dt` to a row; gives where it is the same as the last one, and has been for no longer than a second. Rows
    /// without a measurement stand between two rows without a meaning. No row is the same as none: a norm of zero is none.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn repeats(&mut self, row: &Measured<S>, dt: S) -> S::Mask {
        let same = row.valid & same(self.value, row.value);
        self.time = S::select(same | !row.valid, (self.time + dt).min(S::of(LONGEST_TIME)), S::zero());
        self.value = Vec3::select(row.valid, row.value, self.value);
        same & self.time.le(S::of(LONGEST))
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.value.each(visit);
        visit(&mut self.time);
    }
}

/// Where two vectors are the same.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn same<S: Scalar>(a: Vec3<S>, b: Vec3<S>) -> S::Mask {
    let equal = |a: S, b: S| a.le(b) & b.le(a);
    equal(a.x, b.x) & equal(a.y, b.y) & equal(a.z, b.z)
}
