//! The earth's magnetic field as it is seen: a slow reference, and how far the field is from it.

use super::error_state::ErrorState;
use super::kalman::{SATURATION, saturated};
use crate::scalar::Scalar;
use crate::so3::Vec3;

/// The time constant in s of the field's deviation.
const FIELD_TIME: f64 = 0.25;
/// Where the deviation stops counting.
const LARGEST_DEVIATION: f64 = 1e3;
/// A field closer to the vertical than this many rad has no heading.
pub const VERTICAL_FIELD: f64 = 1e-6;

/// The earth's field as it has been seen.
#[derive(Clone, Debug)]
pub struct Field<S> {
    /// Horizontal and vertical part of the reference, both zero before the first sample.
    horizontal: S,
    vertical: S,
    /// The time that went into it.
    pub age: S,
    /// The squared relative deviation from it, low-pass filtered.
    deviation2: S,
    /// How long it has been left out.
    pub rejected: S,
}

impl<S: Scalar> Field<S> {
    /// Before the first sample.
    pub fn new() -> Self {
        let zero = S::zero();
        Field { horizontal: zero, vertical: zero, age: zero, deviation2: zero, rejected: zero }
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        let Field { horizontal, vertical, age, deviation2, rejected } = self;
        for variable in [horizontal, vertical, age, deviation2, rejected] {
            visit(variable);
        }
    }

    /// Takes the first sample for the reference; gives the squared relative deviation, the larger of that of now and of a
    /// while.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn see(&mut self, lanes: S::Mask, horizontal: S, vertical: S, interval: S) -> S {
        let unknown = lanes & (self.horizontal.abs() + self.vertical.abs()).le(S::zero());
        self.horizontal = S::select(unknown, horizontal, self.horizontal);
        self.vertical = S::select(unknown, vertical, self.vertical);
        let (dh, dv) = (horizontal - self.horizontal, vertical - self.vertical);
        let norm2 = self.horizontal * self.horizontal + self.vertical * self.vertical;
        let largest = S::of(LARGEST_DEVIATION * LARGEST_DEVIATION);
        let now = ((dh * dh + dv * dv) * (S::one() / norm2)).min(largest);
        let mean = self.deviation2 + interval / (S::of(FIELD_TIME) + interval) * (now - self.deviation2);
        self.deviation2 = S::select(lanes, mean, self.deviation2);
        now.max(self.deviation2)
    }

    /// Moves the reference towards what was measured; where a strange field stays it is the new one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn learn(&mut self, lanes: S::Mask, replaced: S::Mask, measured: [S; 2], interval: S, window: S) {
        self.age = S::select(lanes, self.age + interval, self.age);
        self.deviation2 = S::select(lanes & replaced, S::zero(), self.deviation2);
        let weight = interval / (window + interval);
        let [horizontal, vertical] = measured;
        // As a weighted sum: a reference that is larger by many powers of ten leaves the new field, not zero.
        let rest = S::one() - weight;
        for (old, new) in [(&mut self.horizontal, horizontal), (&mut self.vertical, vertical)] {
            *old = S::select(lanes, S::select(replaced, new, rest * *old + weight * new), *old);
        }
    }

    /// North and up of the reference's direction; north at least as much as gives a heading.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn direction(&self) -> [S; 2] {
        let over_norm = S::one() / self.norm();
        [(self.horizontal * over_norm).max(S::of(VERTICAL_FIELD)), self.vertical * over_norm]
    }

    /// Corrects by all three components of the field against the reference m = (0, north, up): −δ × m = [m×] δ, the error δ in
    /// the earth frame being the first of the state. Gives the normalised innovation squared.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn measure<const N: usize>(
        &self,
        error: &mut ErrorState<S, N>,
        lanes: S::Mask,
        field: Vec3<S>,
        heading: S,
        variance: S,
    ) -> S {
        let [north, up] = self.direction();
        let norm = self.norm();
        let field = saturated(field, S::of(SATURATION) * norm) * (S::one() / norm);
        let variance = variance * north * north;
        let nis = error.measure::<1, 2>(lanes, [-up, north], north * heading, variance);
        let nis = nis + error.measure::<0, 1>(lanes, [up], field.y - north, variance);
        nis + error.measure::<0, 1>(lanes, [-north], field.z - up, variance)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn norm(&self) -> S {
        (self.horizontal * self.horizontal + self.vertical * self.vertical).sqrt()
    }
}
