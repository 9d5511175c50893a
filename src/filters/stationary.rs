//! The gyroscope's bias of a sensor at rest, and a sum of time steps that equal steps can be counted by.

use crate::scalar::{Mask, Scalar};
use crate::so3::Vec3;

/// The cut-off frequency in rad/s of the low-pass filter of the bias: 0.02 Hz.
const CUTOFF: f64 = core::f64::consts::TAU * 0.02;
/// The part of a step by which a time may be wrong: at 100 Hz ten times what [`Clock`] rounds in ten minutes of `f32`.
const TOLERANCE: f64 = 1.0 / 16.0;

/// True where no component is larger than the limit.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn within<S: Scalar>(v: Vec3<S>, limit: S) -> S::Mask {
    v.x.abs().le(limit) & v.y.abs().le(limit) & v.z.abs().le(limit)
}

/// A sum of time steps whose rounding does not add up (Kahan), so that n equal steps last n times one of them.
#[derive(Clone, Copy, Debug)]
pub struct Clock<S> {
    time: S,
    /// What rounding has added to it.
    surplus: S,
}

impl<S: Scalar> Clock<S> {
    /// At zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new() -> Self {
        Clock { time: S::zero(), surplus: S::zero() }
    }
    /// The time in s.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn elapsed(&self) -> S {
        self.time
    }
    /// True where it is exactly zero.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_zero(&self) -> S::Mask {
        self.time.abs().le(S::zero()) & self.surplus.abs().le(S::zero())
    }
    /// A step later, or earlier.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn plus(self, step: S) -> Self {
        let step = step - self.surplus;
        let time = self.time + step;
        Clock { time, surplus: (time - self.time) - step }
    }
    /// True where the time is after another one; steps of `dt` are counted exactly.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_after(self, other: S, dt: S) -> S::Mask {
        (other + dt * S::of(TOLERANCE)).lt(self.time)
    }
    /// True where the time is before another one; steps of `dt` are counted exactly.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_before(self, other: S, dt: S) -> S::Mask {
        (self.time + dt * S::of(TOLERANCE)).lt(other)
    }
    /// The time, not before zero and not after `last`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn clamped(self, last: S) -> Self {
        let start = Self::select(self.time.lt(S::zero()), Self::new(), self);
        Self::select(last.lt(self.time), Clock { time: last, surplus: S::zero() }, start)
    }
    /// `yes` where the mask is true, else `no`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Clock { time: S::select(mask, yes.time, no.time), surplus: S::select(mask, yes.surplus, no.surplus) }
    }
    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.time);
        visit(&mut self.surplus);
    }
}

/// The gyroscope's bias, followed slowly while the rate has been small on every axis for a while (x-io, `FusionBias`).
#[derive(Clone, Debug)]
pub struct Offset<S> {
    /// The bias in rad/s.
    pub rate: Vec3<S>,
    threshold: S,
    period: S,
    time: Clock<S>,
}

impl<S: Scalar> Offset<S> {
    /// No bias; at rest is what is below the threshold (rad/s) for a period (s).
    pub fn new(threshold: S, period: S) -> Self {
        Offset { rate: Vec3::zero(), threshold, period, time: Clock::new() }
    }

    /// The rate less the bias so far, and where the sensor is at rest and the bias is followed.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(&mut self, gyr: Vec3<S>, dt: S) -> (Vec3<S>, S::Mask) {
        let rate = gyr - self.rate;
        let still = within(rate, self.threshold);
        let elapsed = !self.time.is_before(self.period, dt);
        let rest = still & elapsed;
        let time = Clock::select(elapsed, self.time, self.time.plus(dt));
        self.time = Clock::select(still, time, Clock::new());
        if rest.any() {
            let followed = self.rate + rate * (S::of(CUTOFF) * dt).min(S::one());
            self.rate = Vec3::select(rest, followed, self.rate);
        }
        (rate, rest)
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.rate.each(visit);
        self.time.each(visit);
    }
}
