//! The attitude after a rotation that was lost: that of the present measurements, by the rule of the start.
//!
//! The readings since the loss are turned back by the gyroscope to its end, where their mean is taken. Once the sensor is quiet the
//! mean of a moment is the direction of gravity; else the mean of two seconds is, as no velocity is large for long.
//!
//! Nothing of this is inlined into a step: it does not depend on the filter, and is compiled once for each scalar. What is not
//! inlined is slow in lanes, for the two seconds that a recovery takes at most. Such functions take everything by value: what a reference
//! points to cannot live in registers in the step around the call either.

use super::alignment::{headed_by, inclined_by};
use crate::STANDARD_GRAVITY;
use crate::filter::Sample;
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3, rotate_by};

/// The sensor is quiet where it turns more slowly than this, in rad/s, and the norm of its specific force is that of gravity to
/// this part.
const QUIET_RATE: f64 = 0.2;
const QUIET_FORCE: f64 = 0.1;
/// So long in s it has to be quiet, and so long the mean is taken where it is not.
const QUIET_TIME: f64 = 0.25;
const LONGEST_TIME: f64 = 2.0;
/// The standard deviation in rad of the direction that the mean shows in motion: a velocity that changes by 1.5 m/s.
const MOTION_ERROR: f64 = 0.0765;
/// The same at rest: noise and offset of the sensors.
const QUIET_ERROR: f64 = 0.01;
/// How much a reading of a quiet sensor counts beside one of motion.
const QUIET_WEIGHT: f64 = 50.0;
/// The longest time in s that a reading counts for.
const LONGEST_INTERVAL: f64 = 0.1;

/// A recovery that is going on, or not.
#[derive(Clone, Copy, Debug)]
pub struct Recovery<S> {
    /// The variance in rad² of the rotation that was lost; zero where none was.
    unknown: S,
    /// The time in s for which there have been readings since, and for which the sensor has been quiet.
    since: S,
    quiet: S,
    /// The rotation since the loss, from the present sensor frame to that at its end.
    turn: Quat<S>,
    /// Sums of specific force and field there.
    force: Vec3<S>,
    field: Vec3<S>,
}

impl<S: Scalar> Recovery<S> {
    /// Nothing was lost.
    pub fn new() -> Self {
        let o = S::zero();
        Recovery { unknown: o, since: o, quiet: o, turn: Quat::identity(), force: Vec3::zero(), field: Vec3::zero() }
    }

    /// Where it is going on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn active(&self) -> S::Mask {
        S::zero().lt(self.unknown)
    }

    /// A rotation of this variance that counts has been lost where the mask is true: what was measured before says nothing any more.
    #[cold]
    #[inline(never)]
    #[must_use]
    pub fn lose(mut self, lanes: S::Mask, variance: S) -> Self {
        self.unknown = S::select(lanes, variance.max(self.unknown), self.unknown);
        self.restart(lanes);
        self
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn restart(&mut self, lanes: S::Mask) {
        self.since = S::select(lanes, S::zero(), self.since);
        self.quiet = S::select(lanes, S::zero(), self.quiet);
        self.turn = Quat::select(lanes, Quat::identity(), self.turn);
        self.force = Vec3::select(lanes, Vec3::zero(), self.force);
        self.field = Vec3::select(lanes, Vec3::zero(), self.field);
    }

    /// Takes a sample where the mask is true, `rate` being the angular rate without its bias.
    #[cold]
    #[inline(never)]
    #[must_use]
    pub fn step(mut self, lanes: S::Mask, sample: Sample<S>, rate: Vec3<S>, dt: S) -> Self {
        let (zero, lanes) = (S::zero(), lanes & self.active());
        self.turn = Quat::select(lanes, rotate_by(self.turn, rate, dt), self.turn);
        let (acc, mag) = (&sample.acc, &sample.mag);
        let g2 = STANDARD_GRAVITY * STANDARD_GRAVITY;
        let norm2 = acc.value.norm2();
        let (least, most) = (1.0 - QUIET_FORCE, 1.0 + QUIET_FORCE);
        let level = S::of(least * least * g2).le(norm2) & norm2.le(S::of(most * most * g2));
        let quiet = rate.norm2().lt(S::of(QUIET_RATE * QUIET_RATE)) & (level | !acc.valid);
        let weight = S::select(quiet, S::of(QUIET_WEIGHT), S::one());
        let interval = S::of(LONGEST_INTERVAL);
        let force = acc.value * (weight * acc.interval.min(interval));
        self.force = Vec3::select(lanes & acc.valid, self.force + self.turn.rotate(force), self.force);
        let field = mag.unit * (weight * mag.interval.min(interval));
        self.field = Vec3::select(lanes & mag.valid, self.field + self.turn.rotate(field), self.field);

        // Only while there are readings.
        let shown = lanes & self.force.norm2().is_normal_norm2();
        self.since = S::select(shown, self.since + dt, self.since);
        self.quiet = S::select(shown, S::select(quiet, self.quiet + dt, zero), self.quiet);
        self
    }

    /// Where the attitude is to be aligned now, and where the recovery ends without, as what motion shows is less sure than what is
    /// known already.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn ready(&self) -> [S::Mask; 2] {
        let active = self.active();
        let over = active & S::of(LONGEST_TIME).le(self.since);
        let quiet = active & self.is_quiet();
        [quiet | (over & self.is_surer()), over & !self.is_surer() & !quiet]
    }

    /// Where the readings are those of a quiet sensor.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_quiet(&self) -> S::Mask {
        S::of(QUIET_TIME).le(self.quiet)
    }

    /// Where more was lost than what the mean in motion may be wrong by.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_surer(&self) -> S::Mask {
        S::of(MOTION_ERROR * MOTION_ERROR).lt(self.unknown)
    }

    /// The variance in rad² of the attitude that the readings show.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn variance(&self) -> S {
        S::select(self.is_quiet(), S::of(QUIET_ERROR * QUIET_ERROR), S::of(MOTION_ERROR * MOTION_ERROR))
    }

    /// An attitude aligned with what the readings show: the inclination, and the heading where there was a field and it is `used`;
    /// and where that was.
    #[cold]
    #[inline(never)]
    pub fn aligned(self, q: Quat<S>, used: bool) -> (Quat<S>, S::Mask) {
        let up = self.turn.conj().rotate(self.force).unit();
        let inclined = inclined_by(q, up);
        if !used {
            return (inclined, S::Mask::splat(false));
        }
        let field = self.turn.conj().rotate(self.field);
        let seen = field.norm2().is_normal_norm2();
        let (headed, known) = headed_by(inclined, field.unit());
        let known = seen & known;
        (Quat::select(known, headed, inclined), known)
    }

    /// The attitude is known again where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn end(&mut self, lanes: S::Mask) {
        self.unknown = S::select(lanes, S::zero(), self.unknown);
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.turn.each(visit);
        self.force.each(visit);
        self.field.each(visit);
        for variable in [&mut self.unknown, &mut self.since, &mut self.quiet] {
            visit(variable);
        }
    }
}
