//! Whether a filter that knows how sure it is has lost the attitude without having been told.
//!
//! A clipped turn, a flipped sign or an inverted first sample leaves a filter of the Kalman kind sure of a wrong attitude: its gain is
//! small, and where the error is large its linear model is wrong. Ten times a second the specific force and the field are
//! turned to the earth by the estimate and low-pass filtered there. They tell of a lost attitude where they agree with each other
//! and not with it, and no acceleration or magnet would look like that:
//!
//! - the force is far from the vertical, and has the norm of gravity (a level acceleration that turns it as far makes it longer);
//! - the force is steady, and off by more than the filter thinks possible; the field, where there is one, is off too;
//! - the field is off in heading alone, while its norm and dip are what they have been for long.

use crate::STANDARD_GRAVITY;
use crate::filter::Sample;
use crate::scalar::Scalar;
use crate::so3::{Quat, Vec3};

/// The time between two looks, in s, and the time constant of the low-pass filters.
const LOOK: f64 = 0.1;
const TIME_CONSTANT: f64 = 0.5;
/// The time constant in s of what is known of the field, and of the bias that is kept.
const SLOW: f64 = 10.0;
/// The norm of a force that is gravity alone: to this part, in motion and where it is steady.
const GRAVITY_PART: f64 = 0.1;
const STEADY_PART: f64 = 0.03;
/// A force is steady where its deviation from the mean is below this part of gravity.
const STEADY: f64 = 0.04;
/// The tangent of the inclination (35°) from which on a force of gravity's norm cannot be a level acceleration.
const GROSS: f64 = 0.7;
/// The same for a steady one (14°): its norm is known more closely.
const LARGE: f64 = 0.25;
/// The least inclination in rad that tells of a lost attitude, and how many standard deviations.
const LEAST_TILT: f64 = 0.035;
const LEAST_HEADING: f64 = 0.17;
const SIGMAS: f64 = 5.0;
/// How long in s it takes: a gross or large error, a small one, one of the heading.
const GROSS_TIME: f64 = 0.6;
const SMALL_TIME: f64 = 2.5;
const HEADING_TIME: f64 = 2.5;
/// A force whose norm is farther from that of gravity, by this part of it, is an acceleration and no noise.
const SHAKEN_PART: f64 = 0.5;
/// The time of a gross error, in s, that says that a start has seen such a force and none of gravity's norm so far.
const SHAKEN: f64 = 1.2;
/// The field is that of the place where its norm and its upward part are what they have been, to this part of the norm.
const SAME_FIELD: f64 = 0.05;
/// Where a force or field stops counting, in its norms.
const LARGEST: f64 = 16.0;

/// What was seen in the earth frame of the estimate.
#[derive(Clone, Copy, Debug)]
pub struct Monitor<S> {
    /// The time since the last look at force and field.
    since_acc: S,
    since_mag: S,
    /// The force in gravities, low-pass filtered; zero before the first one. Its squared deviation.
    force: Vec3<S>,
    spread: S,
    /// The field in its unit at the start, low-pass filtered.
    field: Vec3<S>,
    /// Its norm and its upward part in the long run.
    norm: S,
    up: S,
    /// How long a gross, small or heading's error has lasted. Where a start has no credit, one look is enough until a force of
    /// gravity's norm agrees with it.
    gross: S,
    small: S,
    heading: S,
    /// The bias of the gyroscope as it was before.
    bias: Vec3<S>,
}

impl<S: Scalar> Monitor<S> {
    /// Before the first look. A start has no credit, unless the filter expects to be switched on in motion.
    pub fn new(starts_in_motion: bool) -> Self {
        let (o, v) = (S::zero(), Vec3::zero());
        Monitor {
            since_acc: o,
            since_mag: o,
            force: v,
            spread: o,
            field: v,
            norm: o,
            up: o,
            gross: S::of(if starts_in_motion { 0.0 } else { GROSS_TIME }),
            small: o,
            heading: o,
            bias: v,
        }
    }

    /// The bias of the gyroscope before what went wrong.
    pub fn bias(&self) -> Vec3<S> {
        self.bias
    }

    /// Where a step leads to the time to look at the force.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_due(&self, dt: S) -> S::Mask {
        S::of(LOOK).le(self.since_acc + dt)
    }

    /// Counts the time of a step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn wait(&mut self, dt: S) {
        self.since_acc = self.since_acc + dt;
    }

    /// Starts anew where the mask is true, but for what is known of the field.
    #[cold]
    #[inline(never)]
    #[must_use]
    pub fn restart(mut self, lanes: S::Mask) -> Self {
        let o = S::zero();
        self.force = Vec3::select(lanes, Vec3::zero(), self.force);
        self.field = Vec3::select(lanes, Vec3::zero(), self.field);
        for variable in [&mut self.spread, &mut self.gross, &mut self.small, &mut self.heading] {
            *variable = S::select(lanes, o, *variable);
        }
        self
    }

    /// Looks at a sample where the mask is true. `q` is the attitude, `claimed` the variances of inclination and heading that the
    /// filter claims (rad²), `bias` what it takes for the gyroscope's bias. Gives where the attitude is lost.
    ///
    /// Inlined, as it is not rare: what is not inlined is slow in lanes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn look(&mut self, lanes: S::Mask, sample: &Sample<S>, q: Quat<S>, claimed: [S; 2], bias: Vec3<S>) -> S::Mask {
        let (zero, one) = (S::zero(), S::one());
        let r = q.matrix();
        let weight = |time: S, constant: f64| time / (S::of(constant) + time);
        // By norms, not their squares, which may be beyond the range of the scalar.
        let limit = |v: Vec3<S>, norm: S| v * (S::of(LARGEST) * norm / v.norm2().sqrt()).min(one);

        // The force, and how steady it is.
        let force = r.apply(limit(sample.acc.value * S::of(1.0 / STANDARD_GRAVITY), one));
        let doubted = S::of(GROSS_TIME).le(self.gross);
        let first = self.force.norm2().le(zero) | doubted;
        let w = S::select(first, one, weight(self.since_acc, TIME_CONSTANT));
        let off = force - self.force;
        let mean = self.force + off * w;
        let spread = S::select(first, one, self.spread + w * ((force - mean).norm2() - self.spread));
        self.force = Vec3::select(lanes, mean, self.force);
        self.spread = S::select(lanes, spread, self.spread);

        // The field, where there is one; slower sensors when they come.
        self.since_mag = S::select(lanes, self.since_mag + self.since_acc, self.since_mag);
        let shown = lanes & sample.mag.valid & S::of(LOOK).le(self.since_mag);
        let norm = sample.mag.value.norm2().sqrt();
        let unknown = self.norm.le(zero);
        let unit = S::select(unknown, norm, self.norm);
        let field = r.apply(limit(sample.mag.value, unit)) * (one / unit);
        let first = self.field.norm2().le(zero);
        let w = S::select(first, one, weight(self.since_mag, TIME_CONSTANT));
        self.field = Vec3::select(shown, self.field + (field - self.field) * w, self.field);
        let interval = self.since_mag;
        self.since_mag = S::select(shown, zero, self.since_mag);

        // How far the force is from the vertical.
        let Vec3 { x, y, z } = self.force;
        let (level2, norm2) = (x * x + y * y, self.force.norm2());
        let within = |norm2: S, part: f64| {
            S::of((1.0 - part) * (1.0 - part)).le(norm2) & norm2.le(S::of((1.0 + part) * (1.0 + part)))
        };
        let down = z.le(zero);
        let beyond = |tangent2: S| down | (tangent2 * (z * z)).lt(level2);
        let gravity = within(norm2, GRAVITY_PART);
        let steady = within(norm2, STEADY_PART) & self.spread.lt(S::of(STEADY * STEADY));
        let sure2 = S::of(SIGMAS * SIGMAS) * claimed[0];
        let tilted = beyond(sure2.max(S::of(LEAST_TILT * LEAST_TILT)));

        // How far the field is from north and from its dip: of an attitude that is lost it is off by about as much.
        let fields = zero.lt(self.field.norm2()) & zero.lt(self.norm);
        let Vec3 { x: east, y: north, z: up } = self.field;
        let across = (east * east + north * north).sqrt();
        let (dip_off, turned) = (up - self.up, east);
        let field_off2 = dip_off * dip_off + turned * turned;
        let agrees = !fields | (S::of(0.25) * level2).lt(field_off2);
        let gross = gravity & beyond(S::of(GROSS * GROSS));
        let large = steady & beyond(sure2.max(S::of(LARGE * LARGE)));
        let small = steady & tilted & agrees;
        let same = fields
            & dip_off.abs().lt(S::of(SAME_FIELD))
            & (self.field.norm2().sqrt() - one).abs().lt(S::of(SAME_FIELD));
        // The sine of the heading's error, or more than a right angle.
        let sure_heading2 = (S::of(SIGMAS * SIGMAS) * claimed[1]).max(S::of(LEAST_HEADING * LEAST_HEADING));
        let headed = gravity & !tilted & same & (north.le(zero) | (sure_heading2 * (across * across)).lt(east * east));

        let dt = self.since_acc;
        self.since_acc = S::select(lanes, zero, self.since_acc);
        let lasting =
            |time: S, is: S::Mask| S::select(lanes, S::select(is, time + dt.min(S::of(2.0 * LOOK)), zero), time);
        // A start amid accelerations has taught the filter what is not so, even where its attitude has come right meanwhile.
        let shaken = gravity & S::of(SHAKEN).le(self.gross);
        let gross_time = lasting(self.gross, gross | large | shaken);
        let in_doubt = S::select(within(norm2, SHAKEN_PART), self.gross, S::of(SHAKEN));
        self.gross = S::select(lanes & doubted & !gravity, in_doubt, gross_time);
        self.small = lasting(self.small, small);
        self.heading = lasting(self.heading, headed);
        let lost = lanes
            & ((gravity & S::of(GROSS_TIME).lt(self.gross))
                | S::of(SMALL_TIME).lt(self.small)
                | S::of(HEADING_TIME).lt(self.heading));

        // What is known in the long run, while nothing looks wrong.
        let sound = lanes & !(gross | large | small | headed | shaken);
        let slow = S::select(unknown, one, weight(interval, SLOW));
        let learns = shown & sound;
        self.norm = S::select(learns, unit + slow * (norm.min(S::of(LARGEST) * unit) - unit), self.norm);
        self.up = S::select(learns, self.up + slow * (up - self.up), self.up);
        let kept = self.bias + (bias - self.bias) * weight(dt, SLOW);
        self.bias = Vec3::select(sound, kept, self.bias);
        lost
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.force.each(visit);
        self.field.each(visit);
        self.bias.each(visit);
        let Monitor { since_acc, since_mag, spread, norm, up, gross, small, heading, .. } = self;
        for variable in [since_acc, since_mag, spread, norm, up, gross, small, heading] {
            visit(variable);
        }
    }
}
