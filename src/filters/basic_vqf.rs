//! BasicVQF, the orientation part of VQF alone.

use super::delay::{LONGEST_DELAY, caught_up};
use super::vqf::heading::{Heading, has_heading};
use super::vqf::inclination::Inclination;
use super::vqf::{DELTA, QUAT6D, QUAT9D, limited_field};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, Sample};
use crate::scalar::{Mask, Scalar};
use crate::signal::{Coefficients, Gain};
use crate::so3::Quat;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "BasicVQF",
    doc: "VQF without estimation of the gyroscope's bias, rest detection and magnetic disturbance rejection: strapdown \
          integration, the inclination by the specific force, low-pass filtered in an almost inertial frame, the \
          heading by a scalar offset.",
    source: "Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024): strapdown integration, inclination and heading correction",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: false,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[QUAT6D, QUAT9D, DELTA],
};

params! {
    /// Time constant τ_acc of the low-pass filter of the specific force: how long acceleration has to cancel out.
    real tau_acc: "s" = 3.0 in [0.0, 1e6];
    /// Time constant τ_mag of the heading's correction.
    real tau_mag: "s" = 9.0 in [0.0, 1e6];
    /// How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the field is turned into the
    /// present sensor frame by the angular rate.
    real mag_delay: "s" = 0.0 in [0.0, LONGEST_DELAY];
}

/// VQF without bias estimation, rest detection and magnetic disturbance rejection.
#[derive(Clone, Debug)]
pub struct BasicVQF<S: Scalar> {
    tau_mag: S,
    mag_delay: S,
    // Variables.
    inclination: Inclination<S>,
    heading: Heading<S>,
    // What follows from the variables: the attitude by gyroscope and accelerometer.
    level: Quat<S>,
    // What depends on nothing but the steps.
    force_coefficients: Coefficients<S>,
    heading_gain: Gain<S>,
}

impl<S: Scalar> Filter<S> for BasicVQF<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const STARTS_ITSELF: bool = true;

    fn new(params: &Params<S>) -> Self {
        BasicVQF {
            tau_mag: params.tau_mag,
            mag_delay: params.mag_delay,
            inclination: Inclination::default(),
            heading: Heading::default(),
            level: Quat::identity(),
            force_coefficients: Coefficients::new(params.tau_acc),
            heading_gain: Gain::new(params.tau_mag),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.heading.applied_to(self.level).renormalized()
    }
    /// As of [`VQF`](super::VQF).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.inclination.set_attitude(lanes, self.heading.removed_from(q));
        self.level = self.inclination.attitude();
    }
    /// As of [`VQF`](super::VQF).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn realign(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.inclination.restart(lanes, self.heading.removed_from(q), &self.force_coefficients);
        self.level = self.inclination.attitude();
    }
    /// As of [`VQF`](super::VQF).
    fn start_from(&mut self, q: Quat<S>) {
        self.inclination.start_from(q, &self.force_coefficients);
        self.heading.start();
        self.level = self.inclination.attitude();
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let (acc, mag) = (&sample.acc, &sample.mag);
        self.inclination.turn(sample.gyr, dt);
        if acc.valid.any() {
            self.force_coefficients.set_step(acc.valid, acc.interval);
            self.inclination.correct(acc.valid, acc.value, &self.force_coefficients);
        }
        self.level = self.inclination.attitude();
        if mag.valid.any() {
            let field = caught_up(limited_field(mag.value), sample.gyr, self.mag_delay);
            let field = self.level.rotate(field);
            let lanes = mag.valid & has_heading(field);
            let weight = self.heading_gain.weight(lanes, mag.interval);
            self.heading.correct(lanes, field, weight, [mag.interval, self.tau_mag]);
        }
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        match index {
            0 => self.level.renormalized().each(&mut |value| put(*value)),
            1 => self.attitude().each(&mut |value| put(*value)),
            _ => put(self.heading.delta()),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.inclination.each(visit);
        self.heading.each(visit);
        self.level = self.inclination.attitude();
    }
}
