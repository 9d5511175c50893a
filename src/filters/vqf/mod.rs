//! VQF, the filter of Laidig & Seel with bias estimation, rest detection and magnetic disturbance rejection.
//!
//! The sections of the paper are files: [`inclination`] (gyroscope and accelerometer), [`heading`] (magnetometer), [`rest`],
//! [`bias`] and [`magnetic`]. Here stand the parameters and the order of a step.

pub mod bias;
pub mod heading;
pub mod inclination;
pub mod magnetic;
pub mod rest;

use core::f64::consts::PI;

use self::bias::{Bias, Uncertainty};
use self::heading::{Heading, has_heading};
use self::inclination::Inclination;
use self::magnetic::Magnetic;
use self::rest::Rest;
use super::delay::{LONGEST_DELAY, caught_up};
use super::kalman::saturated;
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Sample};
use crate::scalar::{Mask, Scalar};
use crate::signal::{Coefficients, Gain};
use crate::so3::{Matrix3, Quat, Vec3};
use crate::status::Flags;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "VQF",
    doc: "Strapdown integration; the inclination is corrected by the specific force, low-pass filtered in an almost \
          inertial frame; the heading by a scalar offset. The gyroscope's bias is estimated at rest and in motion, \
          and a magnetic field that is strange in norm or dip is left out. A missing row is bridged: the next \
          measurement stands for all the time since the last one.",
    source: "Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024); defaults and order of steps as published \
             with its package vqf",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::No(
        "biases and their errors are clipped axis by axis, and the first sample turns before it is aligned",
    ),
    params: PARAMS,
    presets: &[],
    outputs: &[
        QUAT6D,
        QUAT9D,
        DELTA,
        BIAS_SIGMA,
        REST,
        OutputSpec {
            name: "mag_disturbed",
            doc: "1 where the magnetic field is disturbed or no undisturbed one is known yet, else 0",
            shape: &[],
        },
        OutputSpec { name: "mag_ref_norm", doc: "norm of the undisturbed field, 0 until it is known, µT", shape: &[] },
        OutputSpec { name: "mag_ref_dip", doc: "dip of the undisturbed field below the horizon, rad", shape: &[] },
    ],
};

/// The attitude without the magnetometer.
pub const QUAT6D: OutputSpec = OutputSpec {
    name: "quat6d",
    doc: "attitude by gyroscope and accelerometer, in east-north-up with a heading that drifts",
    shape: &[4],
};
/// The attitude with it.
pub const QUAT9D: OutputSpec = OutputSpec {
    name: "quat9d",
    doc: "attitude with the magnetometer's heading, in east-north-up from magnetic north",
    shape: &[4],
};
/// The difference between them.
pub const DELTA: OutputSpec =
    OutputSpec { name: "delta", doc: "heading offset δ from quat6d to quat9d about the vertical, rad", shape: &[] };
/// How well the bias is known.
pub const BIAS_SIGMA: OutputSpec =
    OutputSpec { name: "bias_sigma", doc: "standard deviation of the gyroscope's bias, rad/s", shape: &[] };
/// Whether the sensor rests.
pub const REST: OutputSpec = OutputSpec { name: "rest", doc: "1 where the sensor rests, else 0", shape: &[] };

params! {
    /// Time constant τ_acc of the low-pass filter of the specific force: how long acceleration has to cancel out.
    real tau_acc: "s" = 3.0 in [0.0, 1e6];
    /// Time constant τ_mag of the heading's correction.
    real tau_mag: "s" = 9.0 in [0.0, 1e6];
    /// Whether the gyroscope's bias is estimated in motion.
    switch motion_bias_est_enabled: bool = true;
    /// Whether rest is detected and the bias estimated then.
    switch rest_bias_est_enabled: bool = true;
    /// Whether magnetic disturbances are detected and left out.
    switch mag_dist_rejection_enabled: bool = true;
    /// Standard deviation of the bias at the start.
    real bias_sigma_init: "°/s" = 0.5 in [1e-6, 1e3];
    /// Time in which the standard deviation of the bias grows from zero to 0.1 °/s.
    real bias_forgetting_time: "s" = 100.0 in [1e-3, 1e9];
    /// Largest bias per axis, and largest error that one sample can show.
    real bias_clip: "°/s" = 2.0 in [1e-6, 1e6];
    /// Standard deviation of the bias in motion, in the steady state.
    real bias_sigma_motion: "°/s" = 0.1 in [1e-6, 1e3];
    /// How fast the bias about the vertical, which motion does not show, goes to zero: a factor on its information.
    real bias_vertical_forgetting_factor: "1" = 0.0001 in [0.0, 1e3];
    /// Standard deviation of the bias at rest, in the steady state.
    real bias_sigma_rest: "°/s" = 0.03 in [1e-6, 1e3];
    /// Time that the sensor has to be still for to count as resting.
    real rest_min_t: "s" = 1.5 in [0.0, 1e6];
    /// Time constant of the low-pass filters of the rest detection.
    real rest_filter_tau: "s" = 0.5 in [0.0, 1e6];
    /// Largest deviation of the angular rate from its low-pass filtered value at rest.
    real rest_th_gyr: "°/s" = 2.0 in [1e-9, 1e6];
    /// Largest deviation of the specific force from its low-pass filtered value at rest.
    real rest_th_acc: "m/s²" = 0.5 in [1e-9, 1e6];
    /// Time constant of the low-pass filter of norm and dip of the field (0: none).
    real mag_current_tau: "s" = 0.05 in [0.0, 1e6];
    /// Time constant with which the reference of the field follows.
    real mag_ref_tau: "s" = 20.0 in [0.0, 1e6];
    /// Largest deviation of the field's norm, relative to the reference.
    real mag_norm_th: "1" = 0.1 in [1e-9, 1e6];
    /// Largest deviation of the field's dip.
    real mag_dip_th: "°" = 10.0 in [1e-9, 180.0];
    /// Time of movement after which a new undisturbed field is accepted.
    real mag_new_time: "s" = 20.0 in [0.0, 1e6];
    /// The same for the first one.
    real mag_new_first_time: "s" = 5.0 in [0.0, 1e6];
    /// Angular rate from which on it counts as movement.
    real mag_new_min_gyr: "°/s" = 20.0 in [0.0, 1e6];
    /// Time after which a field that fits the reference is believed again.
    real mag_min_undisturbed_time: "s" = 0.5 in [0.0, 1e6];
    /// Time for which a disturbed field is left out; after it, it counts less.
    real mag_max_rejection_time: "s" = 60.0 in [0.0, 1e6];
    /// How much less, and how fast the time of rejection is won back in an undisturbed field.
    real mag_rejection_factor: "1" = 2.0 in [1.0, 1e6];
    /// How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the field is turned into the
    /// present sensor frame by the angular rate.
    real mag_delay: "s" = 0.0 in [0.0, LONGEST_DELAY];
}

/// The largest field that is used, in µT.
pub const LARGEST_FIELD: f64 = 1e9;

/// VQF: the filter of Laidig & Seel with all of its parts.
#[derive(Clone, Debug)]
pub struct VQF<S: Scalar> {
    params: Params<S>,
    rest_limits: rest::Limits<S>,
    magnetic_limits: magnetic::Limits<S>,
    // Variables.
    inclination: Inclination<S>,
    heading: Heading<S>,
    rest: Rest<S>,
    bias: Bias<S>,
    magnetic: Magnetic<S>,
    // What follows from the variables: the attitude by gyroscope and accelerometer, and whether the sensor rests.
    level: Quat<S>,
    resting: S::Mask,
    // What depends on nothing but the steps.
    force_coefficients: Coefficients<S>,
    rest_gyr_coefficients: Coefficients<S>,
    rest_acc_coefficients: Coefficients<S>,
    magnetic_coefficients: Coefficients<S>,
    heading_gain: Gain<S>,
    reference_gain: Gain<S>,
}

impl<S: Scalar> Filter<S> for VQF<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const STARTS_ITSELF: bool = true;

    fn new(params: &Params<S>) -> Self {
        let of = params.clone();
        let magnetic_limits = magnetic::Limits {
            norm: of.mag_norm_th,
            dip: radians(of.mag_dip_th),
            new_time: of.mag_new_time,
            new_first_time: of.mag_new_first_time,
            new_min_gyr: radians(of.mag_new_min_gyr),
            min_undisturbed_time: of.mag_min_undisturbed_time,
            max_rejection_time: of.mag_max_rejection_time,
            rejection_factor: of.mag_rejection_factor,
        };
        VQF {
            rest_limits: rest::Limits {
                gyr: radians(of.rest_th_gyr),
                bias: radians(of.bias_clip),
                acc: of.rest_th_acc,
                time: of.rest_min_t,
            },
            inclination: Inclination::default(),
            heading: Heading::default(),
            rest: Rest::default(),
            bias: Bias::new(Uncertainty {
                initial: of.bias_sigma_init,
                forgetting_time: of.bias_forgetting_time,
                motion: of.bias_sigma_motion,
                rest: of.bias_sigma_rest,
                vertical_forgetting: of.bias_vertical_forgetting_factor,
            }),
            magnetic: Magnetic::new(&magnetic_limits),
            level: Quat::identity(),
            resting: S::Mask::splat(false),
            force_coefficients: Coefficients::new(of.tau_acc),
            rest_gyr_coefficients: Coefficients::new(of.rest_filter_tau),
            rest_acc_coefficients: Coefficients::new(of.rest_filter_tau),
            magnetic_coefficients: Coefficients::new(of.mag_current_tau),
            heading_gain: Gain::new(of.tau_mag),
            reference_gain: Gain::new(of.mag_ref_tau),
            magnetic_limits,
            params: of,
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.heading.applied_to(self.level).renormalized()
    }
    /// The attitude by gyroscope and accelerometer is turned; the heading offset and what was learnt stay.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.inclination.set_attitude(lanes, self.heading.removed_from(q));
        self.level = self.inclination.attitude();
    }
    /// The specific force counts as that of the attitude for long; the heading offset stays, and what was learnt.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn realign(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.inclination.restart(lanes, self.heading.removed_from(q), &self.force_coefficients);
        self.level = self.inclination.attitude();
        self.bias.restart(lanes, self.level.matrix(), &self.force_coefficients);
    }
    /// The heading offset of a given attitude is zero, and the magnetometer's first sample weighs as any other.
    fn start_from(&mut self, q: Quat<S>) {
        self.inclination.start_from(q, &self.force_coefficients);
        self.heading.start();
        self.level = self.inclination.attitude();
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let all = S::Mask::splat(true);
        let (acc, mag) = (&sample.acc, &sample.mag);
        let (rests, rejects) = (self.params.rest_bias_est_enabled, self.params.mag_dist_rejection_enabled);
        let mut turning = all;
        if rests || rejects {
            self.rest_gyr_coefficients.set_step(all, dt);
            turning = self.rest.turns(sample.gyr, &self.rest_gyr_coefficients, &self.rest_limits);
        }
        self.inclination.turn(sample.gyr - self.bias.value(), dt);

        if rests {
            self.rest_acc_coefficients.set_step(acc.valid, acc.interval);
            let force = (acc.valid, acc.value);
            self.resting = self.rest.step(turning, force, &self.rest_acc_coefficients, &self.rest_limits, dt);
        }
        let mut seen_up = (Vec3::zero(), acc.valid);
        if acc.valid.any() {
            self.force_coefficients.set_step(acc.valid, acc.interval);
            seen_up = self.inclination.correct(acc.valid, acc.value, &self.force_coefficients);
        }
        self.level = self.inclination.attitude();
        let r = self.level.matrix();
        if acc.valid.any() {
            // An attitude that was lost is no error of the gyroscope.
            seen_up.1 = seen_up.1 & !sample.recovering;
            self.learn_bias(seen_up, r, acc.interval);
        }

        if mag.valid.any() {
            let rate = sample.gyr - self.bias.value();
            let field = caught_up(limited_field(mag.value), rate, self.params.mag_delay);
            self.correct_heading(mag.valid, r.apply(field), mag.interval);
        } else {
            self.magnetic.nothing_came();
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.bias.value()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.rest = self.resting;
        flags.mag_rejected = self.magnetic.rejects();
        flags.recovering = self.magnetic.recovers();
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        let one_where = |mask| S::select(mask, S::one(), S::zero());
        match index {
            0 => self.level.renormalized().each(&mut |value| put(*value)),
            1 => self.attitude().each(&mut |value| put(*value)),
            2 => put(self.heading.delta()),
            3 => put(self.bias.sigma()),
            4 => put(one_where(self.resting)),
            5 => put(self.magnetic.disturbed()),
            6 => put(self.magnetic.reference().norm),
            _ => put(self.magnetic.reference().dip),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.inclination.each(visit);
        self.heading.each(visit);
        self.rest.each(visit);
        self.bias.each(visit);
        self.magnetic.each(visit);
        self.level = self.inclination.attitude();
    }
}

impl<S: Scalar> VQF<S> {
    /// Goes on to what an accelerometer's sample shows of the bias.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn learn_bias(&mut self, (up, lanes): (Vec3<S>, S::Mask), r: Matrix3<S>, interval: S) {
        let in_motion = self.params.motion_bias_est_enabled;
        if in_motion || self.params.rest_bias_est_enabled {
            let clip = self.rest_limits.bias;
            let rest = (self.resting, self.rest.rate());
            self.bias.step(lanes, (r, up), (interval, &self.force_coefficients), rest, in_motion, clip);
        }
    }

    /// Goes on to a magnetometer's sample, the field being given in the earth frame of the attitude without it.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn correct_heading(&mut self, lanes: S::Mask, field: Vec3<S>, interval: S) {
        let lanes = lanes & has_heading(field);
        let mut weight = self.heading_gain.weight(lanes, interval);
        if self.params.mag_dist_rejection_enabled {
            self.magnetic_coefficients.set_step(lanes, interval);
            let learning = self.reference_gain.weight(lanes, interval);
            let time = (interval, self.rest.rate().norm2());
            let how = (&self.magnetic_coefficients, learning);
            weight = self.magnetic.step(lanes, field, time, how, &self.magnetic_limits, weight);
        }
        self.heading.correct(lanes, field, weight, [interval, self.params.tau_mag]);
    }

    /// The estimate of the gyroscope's bias.
    pub fn bias(&self) -> &Bias<S> {
        &self.bias
    }
    /// What is known of the magnetic field.
    pub fn magnetic(&self) -> &Magnetic<S> {
        &self.magnetic
    }
    /// The attitude by gyroscope alone and by gyroscope and accelerometer.
    pub fn inclination(&self) -> &Inclination<S> {
        &self.inclination
    }
    /// Where the sensor rests.
    pub fn rests(&self) -> S::Mask {
        self.resting
    }
}

/// A field; one beyond all sensors is shortened.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn limited_field<S: Scalar>(field: Vec3<S>) -> Vec3<S> {
    saturated(field, S::of(LARGEST_FIELD))
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn radians<S: Scalar>(degrees: S) -> S {
    degrees * S::of(PI / 180.0)
}
