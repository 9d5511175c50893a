//! x-io's revision of Madgwick's filter: feedback of directions, with rejection of disturbed measurements.

use super::Integration;
use super::field::VERTICAL_FIELD;
use super::kalman::none;
use super::stationary::{Clock, Offset, within};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Sample};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Matrix3, Quat, Vec3};
use crate::status::Flags;
use crate::trig::{atan2, sin_cos};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Fusion",
    doc: "The angular rate is corrected by the error between measured and predicted vertical, and between measured and \
          predicted heading, which leaves the inclination alone. The gain falls from 10 to its value in the first three \
          seconds, and again after the gyroscope has left its range. A measurement whose error is beyond the rejection's \
          angle is left out, until that has lasted too long. Equal to the imufusion package at a constant rate, with \
          time instead of its counts of samples: in a gap of more than 1/gain the feedback counts for that long only, \
          and without a magnetometer the heading of the start is kept, not zeroed.",
    source: "Madgwick, PhD thesis, University of Bristol 2014, chapter 7; x-io Technologies, Fusion 1.3",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: true,
    // `bias` and `gyroscope_range`, both off by default, look at each axis by itself.
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[
        OutputSpec {
            name: "acceleration_error",
            doc: "angle between measured and predicted vertical, °, 90 where it is more; NaN where nothing is measured, \
                  and in the sample that aligns",
            shape: &[],
        },
        OutputSpec { name: "accelerometer_ignored", doc: "1 where the accelerometer was not used, else 0", shape: &[] },
        OutputSpec {
            name: "acceleration_recovery_trigger",
            doc: "how much of the time is over after which a rejected accelerometer is used all the same, 0 to 1",
            shape: &[],
        },
        OutputSpec {
            name: "magnetic_error",
            doc: "angle between measured and predicted heading, °, 90 where it is more; NaN where nothing is measured",
            shape: &[],
        },
        OutputSpec { name: "magnetometer_ignored", doc: "1 where the magnetometer was not used, else 0", shape: &[] },
        OutputSpec {
            name: "magnetic_recovery_trigger",
            doc: "how much of the time is over after which a rejected magnetometer is used all the same, 0 to 1",
            shape: &[],
        },
        OutputSpec { name: "startup", doc: "1 while the gain falls to its value, else 0", shape: &[] },
        OutputSpec {
            name: "overrange_recovery",
            doc: "1 while it does so because the gyroscope had left its range, else 0",
            shape: &[],
        },
        OutputSpec {
            name: "acceleration_recovery",
            doc: "1 while an accelerometer that has been rejected for long is used, else 0",
            shape: &[],
        },
        OutputSpec {
            name: "magnetic_recovery",
            doc: "1 while a magnetometer that has been rejected for long is used, else 0",
            shape: &[],
        },
    ],
};

choice! {
    /// Integration of the angular rate over a step: by the first-order step of the original followed by
    /// normalisation, or by the exponential map, exact for a rate that is constant over the step.
    pub enum Step { FirstOrder = "first-order", Exponential = "exponential" }
}

params! {
    /// Gain of the feedback: an error decays at this rate. 0 is the gyroscope alone, after the start.
    real gain: "rad/s" = 0.5 in [0.0, 1e6];
    /// Range of the gyroscope; beyond 98 % of it on an axis the filter starts anew from its attitude. 0: no limit.
    real gyroscope_range: "°/s" = 0.0 in [0.0, 1e6];
    /// Error of the vertical beyond which the accelerometer is left out. 0: never.
    real acceleration_rejection: "°" = 0.0 in [0.0, 90.0];
    /// Error of the heading beyond which the magnetometer is left out. 0: never.
    real magnetic_rejection: "°" = 0.0 in [0.0, 90.0];
    /// Time of rejection after which a sensor is used all the same; a sample that is not rejected takes off nine
    /// times its length. 0: nothing is ever left out.
    real rejection_timeout: "s" = 0.0 in [0.0, 1e6];
    /// Whether the gyroscope's bias is estimated at rest, axis by axis, with a cut-off of 0.02 Hz.
    switch bias: bool = false;
    /// Angular rate on an axis, less the bias, beyond which the sensor is not at rest.
    real stationary_threshold: "°/s" = 3.0 in [1e-6, 1e6];
    /// Time for which the rate must have been below it.
    real stationary_period: "s" = 3.0 in [0.0, 1e6];
    choice integration: Step;
}

/// The gain at the start.
const STARTUP_GAIN: f64 = 10.0;
/// The time in s in which it falls to its value.
const STARTUP_PERIOD: f64 = 3.0;
/// What is left of that counts as nothing: above the rounding of `f64`, below that of `f32`, which ends the start at the
/// same sample as the original's.
const STARTUP_REST: f64 = 1e-9;
/// The part of the gyroscope's range that counts as within it.
const WITHIN_RANGE: f64 = 0.98;
/// What a sample that is not rejected takes off the time of rejection, in lengths of the sample.
const RELIEF: f64 = 9.0;
const DEGREE: f64 = core::f64::consts::PI / 180.0;

/// x-io's revision of Madgwick's filter.
#[derive(Clone, Debug)]
pub struct Fusion<S: Scalar> {
    params: Params<S>,
    /// How fast the gain falls at the start.
    ramp: S,
    /// The largest rate of an axis in rad/s.
    range: S,
    q: Quat<S>,
    /// The gain of this step, above that of the parameters during the start.
    gain: S,
    /// One during a start that the gyroscope's range caused, else zero.
    overrange: S,
    acc: Rejection<S>,
    mag: Rejection<S>,
    offset: Offset<S>,
    at_rest: S::Mask,
}

impl<S: Scalar> Filter<S> for Fusion<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(params: &Params<S>) -> Self {
        let (zero, unlimited) = (S::zero(), S::splat(S::Real::MAX));
        let ranged = zero.lt(params.gyroscope_range);
        let rejects = zero.lt(params.gain) & zero.lt(params.rejection_timeout);
        let limit = |angle: S| {
            let (sin, _) = sin_cos(angle * S::of(DEGREE));
            S::select(rejects & zero.lt(angle), sin * sin, unlimited)
        };
        Fusion {
            params: params.clone(),
            ramp: ((S::of(STARTUP_GAIN) - params.gain) / S::of(STARTUP_PERIOD)).max(zero),
            range: S::select(ranged, params.gyroscope_range * S::of(WITHIN_RANGE * DEGREE), unlimited),
            q: Quat::identity(),
            gain: params.gain.max(S::of(STARTUP_GAIN)),
            overrange: zero,
            acc: Rejection::new(limit(params.acceleration_rejection), params.rejection_timeout),
            mag: Rejection::new(limit(params.magnetic_rejection), params.rejection_timeout),
            offset: Offset::new(params.stationary_threshold * S::of(DEGREE), params.stationary_period),
            at_rest: S::Mask::splat(false),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let mut gyr = sample.gyr;
        if self.params.bias {
            (gyr, self.at_rest) = self.offset.step(gyr, dt);
        }
        let startup = self.start(gyr, dt);
        let r = self.q.matrix();
        let weights = sample.weights(dt);
        let mut error = self.inclination_error(r, sample, startup, weights.time * weights.acc);
        error.z = self.heading_error(r, sample, startup, weights.time * weights.mag);
        // ω = ω_gyr + gain e. After a gap one sample's error stands for the whole of it: it may be corrected, not overshot.
        let half = S::of(0.5);
        let mut feedback = (self.gain * weights.time).min(S::one());
        let late = sample.late(dt);
        if late.any() {
            // Each error by its own time.
            let [acc, mag] = [weights.acc, weights.mag].map(|weight| (self.gain * weights.time * weight).min(S::one()));
            error = Vec3::select(late, Vec3::new(error.x * acc, error.y * acc, error.z * mag), error);
            feedback = S::select(late, S::one(), feedback);
        }
        let half_turn = gyr * (half * dt) + r.transpose_apply(error) * (half * feedback);
        let integration = match self.params.integration {
            Step::FirstOrder => Integration::FirstOrder,
            Step::Exponential => Integration::Exponential,
        };
        self.q = integration.step(self.q, half_turn);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.offset.rate
    }
    fn bias_stays_zero(&self) -> bool {
        !self.params.bias
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.acc_rejected = self.acc.rejected;
        flags.mag_rejected = self.mag.rejected;
        flags.rest = self.at_rest;
        let half = S::of(0.5);
        flags.recovering = half.lt(self.acc.recovering) | half.lt(self.mag.recovering) | half.lt(self.overrange);
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        let one_where = |mask| S::select(mask, S::one(), S::zero());
        put(match index {
            0 => self.acc.angle(),
            1 => one_where(!self.acc.used),
            2 => self.acc.trigger(),
            3 => self.mag.angle(),
            4 => one_where(!self.mag.used),
            5 => self.mag.trigger(),
            6 => one_where(self.params.gain.lt(self.gain)),
            7 => self.overrange,
            8 => self.acc.recovering,
            _ => self.mag.recovering,
        });
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        visit(&mut self.gain);
        visit(&mut self.overrange);
        self.acc.each(visit);
        self.mag.each(visit);
        self.offset.each(visit);
    }
}

impl<S: Scalar> Fusion<S> {
    /// Lets the gain fall, from its first value again where the gyroscope leaves its range; true during the start.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn start(&mut self, gyr: Vec3<S>, dt: S) -> S::Mask {
        let over = !within(gyr, self.range);
        if over.any() {
            let first = self.params.gain.max(S::of(STARTUP_GAIN));
            self.gain = S::select(over, first, self.gain);
            self.overrange = S::select(over, S::one(), self.overrange);
            self.acc.forget(over);
            self.mag.forget(over);
        }
        let gain = self.gain - self.ramp * dt;
        let startup = (self.params.gain + S::of(STARTUP_REST)).lt(gain);
        self.gain = S::select(startup, gain, self.params.gain);
        self.overrange = S::select(startup, self.overrange, S::zero());
        startup
    }

    /// a × up in the earth frame, where the measured vertical is used: of length sin θ, and 2 from 90° on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn inclination_error(&mut self, r: Matrix3<S>, sample: &Sample<S>, startup: S::Mask, dt: S) -> Vec3<S> {
        let valid = sample.acc.valid;
        if !valid.any() {
            self.acc.see_nothing();
            return Vec3::zero();
        }
        let a = r.apply(sample.acc.unit);
        let mut error = Vec3::new(a.y, -a.x, S::zero());
        let mut error2 = a.x * a.x + a.y * a.y;
        let beyond = a.z.le(S::zero()) & error2.is_normal_norm2();
        if beyond.any() {
            let two = S::of(2.0);
            error = Vec3::select(beyond, error * (two / error2.sqrt()), error);
            error2 = S::select(beyond, two * two, error2);
        }
        let used = self.acc.judge(valid, error2, startup, dt);
        Vec3::select(used, error, Vec3::zero())
    }

    /// (up × m) × west in the earth frame, its vertical part, which is the only one, where the field is used: sin θ, and
    /// ±2 from 90° on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn heading_error(&mut self, r: Matrix3<S>, sample: &Sample<S>, startup: S::Mask, dt: S) -> S {
        let mut valid = sample.mag.valid;
        if !valid.any() {
            self.mag.see_nothing();
            return S::zero();
        }
        let (zero, two) = (S::zero(), S::of(2.0));
        let m = r.apply(sample.mag.unit);
        let horizontal2 = m.x * m.x + m.y * m.y;
        valid = valid & S::of(VERTICAL_FIELD * VERTICAL_FIELD).le(horizontal2);
        let mut error = m.x / horizontal2.sqrt();
        let beyond = m.y.le(zero);
        if beyond.any() {
            let most = S::select(error.lt(zero), -two, S::select(zero.lt(error), two, zero));
            error = S::select(beyond, most, error);
        }
        let used = self.mag.judge(valid, error * error, startup, dt);
        S::select(used, error, zero)
    }
}

/// Whether a sensor is believed: not where its error is too large, but again after a while.
#[derive(Clone, Debug)]
struct Rejection<S: Scalar> {
    /// The largest squared error that is believed.
    limit: S,
    /// How long a sensor may be left out, in s.
    timeout: S,
    /// How long it has been, less what spoke for it.
    time: Clock<S>,
    /// One while it is used for having been left out for long, else zero.
    recovering: S,
    /// The squared error of the last step.
    error2: S,
    /// Where there was a measurement in the last step, where it was used and where not.
    measured: S::Mask,
    used: S::Mask,
    rejected: S::Mask,
}

impl<S: Scalar> Rejection<S> {
    fn new(limit: S, timeout: S) -> Self {
        let no = S::Mask::splat(false);
        let (time, recovering, error2) = (Clock::new(), S::zero(), S::zero());
        Rejection { limit, timeout, time, recovering, error2, measured: no, used: no, rejected: no }
    }

    /// A step without a measurement.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn see_nothing(&mut self) {
        let no = S::Mask::splat(false);
        (self.measured, self.used, self.rejected) = (no, no, no);
    }

    /// Where a measurement is used that shows a squared error.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn judge(&mut self, valid: S::Mask, error2: S, startup: S::Mask, dt: S) -> S::Mask {
        let (zero, one) = (S::zero(), S::one());
        let mut used = startup | error2.le(self.limit);
        // Where all is well and has been, there is nothing to count.
        let idle = used & self.time.is_zero() & self.recovering.le(zero);
        if !(idle | !valid).all() {
            let time = self.time.plus(S::select(used, dt * S::of(-RELIEF), dt));
            // Rounding must not decide a count of equal steps.
            let recovering = time.is_after(S::select(zero.lt(self.recovering), zero, self.timeout), dt);
            used = used | recovering;
            self.time = Clock::select(valid, time.clamped(self.timeout), self.time);
            self.recovering = S::select(valid, S::select(recovering, one, zero), self.recovering);
        }
        self.measured = valid;
        self.error2 = error2;
        self.rejected = valid & !used;
        self.used = valid & used;
        self.used
    }

    /// As before any sample, where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn forget(&mut self, lanes: S::Mask) {
        self.time = Clock::select(lanes, Clock::new(), self.time);
        self.recovering = S::select(lanes, S::zero(), self.recovering);
    }

    /// The error as an angle in degrees, at most 90; NaN where there was no measurement.
    fn angle(&self) -> S {
        let sin2 = self.error2.min(S::one());
        let angle = atan2(sin2.sqrt(), (S::one() - sin2).sqrt()) * S::of(1.0 / DEGREE);
        S::select(self.measured, angle, none())
    }

    /// The time of rejection as a part of the largest; 0 where nothing is rejected.
    fn trigger(&self) -> S {
        let zero = S::zero();
        S::select(zero.lt(self.timeout), self.time.elapsed() / self.timeout, zero)
    }

    fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.time.each(visit);
        visit(&mut self.recovering);
    }
}
