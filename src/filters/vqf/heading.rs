//! Heading correction (Laidig & Seel 2023): the angle δ about the vertical from the attitude by gyroscope and
//! accelerometer to that with the magnetometer.

use super::super::field::VERTICAL_FIELD;
use crate::scalar::{Mask, Scalar};
use crate::signal::Sum;
use crate::so3::{Quat, Vec3};
use crate::trig::{atan2, sinc_cos_kernel, wrap};

/// A little more than π, to which an angle is wrapped with rounding.
const LARGEST: f64 = 3.2;

/// The heading offset δ, corrected by a first-order filter whose weight falls from one at the start.
#[derive(Clone, Debug)]
pub struct Heading<S> {
    /// δ in rad, in [−π, π].
    delta: Sum<S>,
    /// The least weight of the next sample: 1/n for the n-th, zero after the start.
    least: S,
}

impl<S: Scalar> Default for Heading<S> {
    /// Before the first sample.
    fn default() -> Self {
        Heading { delta: Sum::new(S::zero()), least: S::one() }
    }
}

impl<S: Scalar> Heading<S> {
    /// δ in rad.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn delta(&self) -> S {
        self.delta.value
    }

    /// Takes the heading as it is for that of the start: a sample weighs no more than later ones.
    pub fn start(&mut self) {
        self.least = S::zero();
    }

    /// Where the next sample has the weight of the start.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn starts(&self) -> S::Mask {
        S::zero().lt(self.least)
    }

    /// The attitude turned by δ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn applied_to(&self, q: Quat<S>) -> Quat<S> {
        turned(q, self.delta.value)
    }

    /// The attitude that δ turns to a given one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn removed_from(&self, q: Quat<S>) -> Quat<S> {
        turned(q, -self.delta.value)
    }

    /// Corrects by the magnetic field in the earth frame of the attitude by gyroscope and accelerometer, with a sample's
    /// `weight` and the `time` that `tau` counts for (the interval since the last sample, the time constant).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn correct(&mut self, lanes: S::Mask, field: Vec3<S>, weight: S, [time, tau]: [S; 2]) {
        self.correct_to(lanes, angle(field), weight, [time, tau]);
    }

    /// Corrects by the angle that a sample shows of δ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn correct_to(&mut self, lanes: S::Mask, angle: S, weight: S, [time, tau]: [S; 2]) {
        let off = wrap(angle - self.delta.value);
        let turned = self.delta.plus(weight.max(self.least) * off);
        let turned = turned.with_value(wrap(turned.value));
        self.delta = if lanes.all() { turned } else { Sum::select(lanes, turned, self.delta) };
        let starting = lanes & S::zero().lt(self.least);
        if starting.any() {
            let next = self.least / (self.least + S::one());
            let next = S::select((next * tau).lt(time), S::zero(), next);
            self.least = S::select(starting, next, self.least);
        }
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.delta.each(visit);
        visit(&mut self.least);
        // A state from outside may hold anything: an angle that is none, a weight beyond one.
        self.least = self.least.max(S::zero()).min(S::one());
        self.delta = self.delta.or_zero_beyond(S::of(LARGEST));
    }
}

/// The angle by which a field in the earth frame has to be turned to point north.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn angle<S: Scalar>(field: Vec3<S>) -> S {
    atan2(field.x, field.y)
}

/// An attitude turned about the vertical by an angle in [−π, π].
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn turned<S: Scalar>(q: Quat<S>, angle: S) -> Quat<S> {
    let off = S::zero().lt(angle.abs());
    if !off.any() {
        return q;
    }
    // Half the angle, from a quarter of it: |angle|/4 ≤ π/4 needs no reduction.
    let quarter = S::of(0.25) * angle;
    let (sinc, cos) = sinc_cos_kernel(quarter * quarter);
    let double_sin = S::of(2.0) * (quarter * sinc);
    let (sin, cos) = (double_sin * cos, S::one() - S::of(0.5) * (double_sin * double_sin));
    let turned = Quat::new(cos * q.w - sin * q.z, cos * q.x - sin * q.y, cos * q.y + sin * q.x, cos * q.z + sin * q.w);
    if off.all() { turned } else { Quat::select(off, turned, q) }
}

/// Where a field in the earth frame has a heading: where it is not vertical.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn has_heading<S: Scalar>(field: Vec3<S>) -> S::Mask {
    let horizontal2 = field.x * field.x + field.y * field.y;
    (S::of(VERTICAL_FIELD * VERTICAL_FIELD) * (horizontal2 + field.z * field.z)).le(horizontal2)
}
