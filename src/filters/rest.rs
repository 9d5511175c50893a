//! Detection of rest: angular rate and specific force that do not change.

use crate::scalar::{Mask, Scalar};
use crate::so3::Vec3;

/// The time constant in s of the low-pass filters.
const TIME_CONSTANT: f64 = 0.5;
/// The longest time in s that a detector waits for the accelerometer.
pub const LONGEST_WAIT: f64 = 0.1;
/// Where a time that something lasts stops counting, in s.
pub const LONGEST_TIME: f64 = 1e6;

/// How far measurements may be from their low-pass filtered values, and for how long, to count as rest.
#[derive(Clone, Copy, Debug)]
pub struct Thresholds<S> {
    /// Angular rate in rad/s.
    pub gyr: S,
    /// Specific force in m/s².
    pub acc: S,
    /// Time in s.
    pub time: S,
}

/// A detector of rest.
#[derive(Clone, Debug)]
pub struct Rest<S> {
    gyr: Slow<S>,
    acc: Slow<S>,
    time: S,
}

impl<S: Scalar> Default for Rest<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Rest<S> {
    /// Before the first sample.
    pub fn new() -> Self {
        Rest { gyr: Slow::new(), acc: Slow::new(), time: S::zero() }
    }

    /// The angular rate, low-pass filtered.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rate(&self) -> Vec3<S> {
        self.gyr.value
    }

    /// Goes on by `dt`; the accelerometer's last measurement came `interval` ago, or is valid now. True at rest.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(
        &mut self,
        (gyr, dt): (Vec3<S>, S),
        (acc, acc_valid, interval): (Vec3<S>, S::Mask, S),
        limits: &Thresholds<S>,
    ) -> S::Mask {
        let all = S::Mask::splat(true);
        let gyr_off = self.gyr.step(all, gyr, dt);
        let acc_off = self.acc.step(acc_valid, acc, interval);
        let acc_still =
            (acc_valid & acc_off.lt(limits.acc * limits.acc)) | (!acc_valid & interval.lt(S::of(LONGEST_WAIT)));
        let still = gyr_off.lt(limits.gyr * limits.gyr) & acc_still;
        self.time = S::select(still, (self.time + dt).min(S::of(LONGEST_TIME)), S::zero());
        limits.time.lt(self.time)
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        for slow in [&mut self.gyr, &mut self.acc] {
            slow.value.each(visit);
            visit(&mut slow.known);
        }
        visit(&mut self.time);
    }
}

/// A low-pass filter that starts at its first value.
#[derive(Clone, Debug)]
struct Slow<S> {
    value: Vec3<S>,
    /// One where a value has come, else zero.
    known: S,
}

impl<S: Scalar> Slow<S> {
    fn new() -> Self {
        Slow { value: Vec3::zero(), known: S::zero() }
    }

    /// Takes a value where the mask is true; gives the squared distance from it that is left.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, lanes: S::Mask, value: Vec3<S>, dt: S) -> S {
        let old = Vec3::select(S::zero().lt(self.known), self.value, value);
        let new = old + (value - old) * (dt / (S::of(TIME_CONSTANT) + dt));
        self.value = Vec3::select(lanes, new, self.value);
        self.known = S::select(lanes, S::one(), self.known);
        (value - new).norm2()
    }
}
