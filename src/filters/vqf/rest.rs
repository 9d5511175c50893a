//! Rest detection (Laidig & Seel 2023): angular rate and specific force close to their low-pass filtered
//! values for some time.

use crate::scalar::Scalar;
use crate::signal::{Coefficients, LowPass};
use crate::so3::Vec3;

/// The longest time in s that one sample stands for: what happened in a gap is not known.
pub const LONGEST_EVIDENCE: f64 = 1.0;

/// What counts as rest.
#[derive(Clone, Copy, Debug)]
pub struct Limits<S> {
    /// Largest deviation of the angular rate in rad/s.
    pub gyr: S,
    /// Largest component of the low-pass filtered angular rate in rad/s: a bias is not larger.
    pub bias: S,
    /// Largest deviation of the specific force in m/s².
    pub acc: S,
    /// The time in s for which all three have to be kept.
    pub time: S,
}

/// A detector of rest.
#[derive(Clone, Debug)]
pub struct Rest<S> {
    gyr: LowPass<S, 3>,
    acc: LowPass<S, 3>,
    /// The angular rate, low-pass filtered, in rad/s.
    rate: Vec3<S>,
    /// How long the limits have been kept, in s; it stops counting where that is long enough.
    time: S,
}

impl<S: Scalar> Default for Rest<S> {
    /// Before the first sample.
    fn default() -> Self {
        Rest { gyr: LowPass::default(), acc: LowPass::default(), rate: Vec3::zero(), time: S::zero() }
    }
}

impl<S: Scalar> Rest<S> {
    /// The angular rate, low-pass filtered, in rad/s: at rest, the gyroscope's bias.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rate(&self) -> Vec3<S> {
        self.rate
    }

    /// Takes an angular rate; gives where it is beyond its limits.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turns(&mut self, gyr: Vec3<S>, coefficients: &Coefficients<S>, limits: &Limits<S>) -> S::Mask {
        self.rate = self.gyr.step_vector(<S::Mask as crate::Mask>::splat(true), gyr, coefficients);
        let largest = self.rate.x.abs().max(self.rate.y.abs()).max(self.rate.z.abs());
        (limits.gyr * limits.gyr).le((gyr - self.rate).norm2()) | limits.bias.lt(largest)
    }

    /// Takes the specific force where the mask is true, after an angular rate that was `turning` or not, at the end of a
    /// step `dt`. True at rest. A missing row says nothing against rest.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(
        &mut self,
        turning: S::Mask,
        (lanes, force): (S::Mask, Vec3<S>),
        coefficients: &Coefficients<S>,
        limits: &Limits<S>,
        dt: S,
    ) -> S::Mask {
        let slow = self.acc.step_vector(lanes, force, coefficients);
        let moving = lanes & (limits.acc * limits.acc).le((force - slow).norm2());
        let before = S::select(turning, S::zero(), self.time);
        let time = (before + dt.min(S::of(LONGEST_EVIDENCE))).min(limits.time);
        self.time = S::select(moving, S::zero(), time);
        limits.time.le(self.time) & !moving
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.gyr.each(visit);
        self.acc.each(visit);
        self.rate.each(visit);
        visit(&mut self.time);
    }
}
