//! SelfCalSmoother: what [`SelfCalKF`] estimates, from the whole recording.
//!
//! SelfCalKF goes over the recording once and gives a trajectory to start from. Then, twice or more: the samples are summed over
//! blocks along the trajectory, fields that are not the reference's are given less weight, and a linear filter with its
//! smoother corrects the trajectory and all that calibrates the sensors. At the end the corrected angular rate is
//! integrated through each block from its smoothed attitude, and ends at that of the next.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

pub mod blocks;
mod causal;
mod found;
pub mod smoother;

use ahrs_rs::estimator::LONGEST_STEP;
use ahrs_rs::filter::{Equivariance, Magnetometer, OutputSpec, Sample};
use ahrs_rs::filters::SelfCalKF;
use ahrs_rs::filters::kalman::vec3;
use ahrs_rs::filters::rest::Thresholds;
use ahrs_rs::filters::selfcal::magnetic::REJECTING_WEIGHT;
use ahrs_rs::filters::selfcal::state::{BIAS, DISTURBANCE, HORIZONTAL, IRON, State};
use ahrs_rs::filters::selfcal::{PARAMS as CAUSAL, Params as CausalParams};
use ahrs_rs::params::{ParamError, ParamSet, ParamSpec};
use ahrs_rs::status;
use ahrs_rs::{Estimator, Filter, FilterSpec, Flags, Quat, Settings, Vec3};

use self::blocks::{Samples, Summed};
use self::causal::{Causal, Finding};
use self::found::Found;
use super::{KEPT, Offline, Series, Solution, causal_settings, continuous, leave_out, output_rotation, usable};
use crate::threads::Watch;

/// Samples between two looks at whether it was told to stop.
const TILE: usize = 4096;
/// How often the trajectory is smoothed: at least and at most, and the correction in rad that is small enough to end.
const PASSES: usize = 2;
const MOST_PASSES: usize = 8;
const CONVERGED: f64 = 0.01;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "SelfCalSmoother",
    doc: "SelfCalKF over a whole recording: its linear filter and smoother go twice over the trajectory that SelfCalKF has \
          found, so that every attitude knows the future too, and the start knows the calibration. Offline: no update and \
          no state. Computed in float64 whatever the dtype.",
    source: "this project",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[
        OutputSpec {
            name: "covariance",
            doc: "covariance of the attitude error in the sensor frame, rad²; π²/3 about the vertical without a magnetometer",
            shape: &[3, 3],
        },
        OutputSpec {
            name: "bias_sigma",
            doc: "standard deviation of the gyroscope's bias, rad/s: the largest of the three axes",
            shape: &[],
        },
        OutputSpec {
            name: "gyr_matrix",
            doc: "matrix M of the gyroscope: the angular rate is (I + M)(ω − b)",
            shape: &[3, 3],
        },
        OutputSpec { name: "gyr_matrix_sigma", doc: "standard deviations of its entries", shape: &[3, 3] },
        OutputSpec { name: "acc_bias", doc: "bias of the accelerometer, m/s²", shape: &[3] },
        OutputSpec { name: "mag_delay", doc: "delay of the magnetometer behind the gyroscope, s", shape: &[] },
        OutputSpec { name: "mag_delay_sigma", doc: "standard deviation of that delay, s", shape: &[] },
        OutputSpec {
            name: "hard_iron",
            doc: "field of the sensor's own, sensor frame, unit of the magnetometer",
            shape: &[3],
        },
        OutputSpec {
            name: "disturbance",
            doc: "disturbance of the field where the sensor is, east, north and up, unit of the magnetometer",
            shape: &[3],
        },
        OutputSpec { name: "mag_weight", doc: "weight of the field, 0 to 1", shape: &[] },
        OutputSpec {
            name: "mag_reference",
            doc: "horizontal and upward part of the reference field, unit of the magnetometer",
            shape: &[2],
        },
    ],
};

ahrs_rs::params! {
    /// Noise density of the gyroscope (angle random walk).
    real gyr_noise: "rad/s/√Hz" = 3e-4 in [1e-9, 1e3];
    /// Noise density of the gyroscope for each rad/s that it turns.
    real rate_noise: "1/√Hz" = 1.4e-3 in [0.0, 1e3];
    /// Noise density of the bias' rate (rate random walk).
    real bias_noise: "rad/s²/√Hz" = 2e-4 in [0.0, 1e3];
    /// Standard deviation of the velocity.
    real velocity: "m/s" = 0.6 in [1e-6, 1e3];
    /// The time for which a velocity lasts.
    real velocity_time: "s" = 0.5 in [1e-3, 1e3];
    /// Noise density of the accelerometer.
    real velocity_noise: "m/s²/√Hz" = 0.03 in [1e-6, 1e3];
    /// Noise density of a component of the magnetometer, in norms of the field.
    real mag_noise: "1/√Hz" = 0.035 in [1e-6, 1e3];
    /// How much it grows for each rad/s that the sensor turns.
    real mag_rate_noise: "s/rad/√Hz" = 7e-4 in [0.0, 1e3];
    /// Deviation of the field from its reference, in its norms, at which it begins to count less.
    real mag_tolerance: "1" = 0.09 in [1e-6, 1e3];
    /// How slowly it does: the weight is (1 + (deviation/tolerance)²/tail)⁻².
    real mag_tail: "1" = 2.5 in [1e-3, 1e6];
    /// Standard deviation of the field's disturbance, in norms of the field.
    real disturbance: "1" = 0.018 in [0.0, 1e3];
    /// The time for which a disturbance lasts.
    real disturbance_time: "s" = 12.0 in [1e-3, 1e6];
    /// How fast the hard iron wanders, in norms of the field; zero: not at all.
    real hard_iron_noise: "1/√s" = 0.0 in [0.0, 1e3];
    /// Deviation of the angular rate from its mean below which the sensor may be at rest.
    real rest_gyr: "rad/s" = 0.03490658503988659 in [0.0, 1e3];
    /// Deviation of the specific force from its mean below which the sensor may be at rest.
    real rest_acc: "m/s²" = 0.5 in [0.0, 1e3];
    /// Time that both have to be small for.
    real rest_time: "s" = 1.5 in [0.0, 1e9];
    /// Noise density of the angular rate at rest, as a measurement of the bias.
    real rest_noise: "rad/s/√Hz" = 2e-3 in [1e-9, 1e3];
    /// Standard deviation of the velocity at rest.
    real rest_velocity: "m/s" = 0.02 in [1e-6, 1e3];
    /// Standard deviation of the inclination at the start.
    real initial_inclination: "rad" = 0.5 in [1e-6, 1e3];
    /// Standard deviation of the heading at the start.
    real initial_heading: "rad" = 1.0 in [1e-6, 1e3];
    /// Standard deviation of the gyroscope's bias at the start.
    real initial_bias: "rad/s" = 0.0087 in [1e-9, 1e3];
    /// The same of each entry of the gyroscope's matrix.
    real initial_matrix: "1" = 0.003 in [0.0, 1e3];
    /// The same of the velocity.
    real initial_velocity: "m/s" = 3.0 in [1e-6, 1e3];
    /// The same of the accelerometer's bias.
    real initial_acc_bias: "m/s²" = 0.04 in [0.0, 1e3];
    /// The same of gravity.
    real initial_gravity: "m/s²" = 0.015 in [0.0, 1e3];
    /// The same of the hard iron, in norms of the field; zero: there is none.
    real initial_hard_iron: "1" = 0.0 in [0.0, 1e3];
    /// The same of the reference field, in its norms.
    real initial_field: "1" = 0.1 in [1e-9, 1e3];
    /// The same of the magnetometer's delay.
    real initial_delay: "s" = 0.01 in [0.0, 1.0];
    /// Delay of all sensors behind the attitude that is wanted, by which the output is turned ahead.
    real latency: "s" = 0.0 in [-1.0, 1.0];
    /// Gravity g where the sensor is.
    real gravity: "m/s²" = 9.80665 in [1e-3, 1e3];
    /// The largest rate that an axis of the gyroscope can measure; what is beyond is lost and counts as unknown. Zero: where an
    /// axis stays at the recording's largest rate, it is taken for that.
    real gyr_range: "rad/s" = 0.0 in [0.0, 1e3];
}

/// The filter with the values of its parameters.
pub fn make(values: &[f64], settings: Settings) -> Result<Box<dyn Offline>, ParamError> {
    let params = Params::from_values(values)?;
    // Those of the causal filter by name; its output is not to be turned ahead.
    let value = |name: &str| PARAMS.iter().position(|spec| spec.name == name);
    let causal = CAUSAL.iter().map(|spec| match value(spec.name) {
        Some(_) if spec.name == "latency" => 0.0,
        Some(index) => values.get(index).copied().or(PARAMS.get(index).map(ParamSpec::default)).unwrap_or(0.0),
        None => spec.default(),
    });
    let causal = CausalParams::from_values(&causal.collect::<Vec<_>>())?;
    Ok(Box::new(SelfCalSmoother { params, causal, settings }))
}

struct SelfCalSmoother {
    params: Params<f64>,
    causal: CausalParams<f64>,
    settings: Settings,
}

/// SelfCalKF, and what the last step was given: the angular rate (where rows are missing, the held one), and what was done
/// before it.
#[derive(Clone)]
struct Pass {
    filter: SelfCalKF<f64>,
    rate: Vec3<f64>,
    done: Done,
    doing: Done,
}

/// What the estimator does to a filter before a step.
#[derive(Clone, Copy, Default)]
struct Done {
    /// The variance in rad² of the rotation that was lost.
    lost: f64,
    /// Whether the attitude was found again.
    realigned: bool,
    /// Whether it was seen to be lost, as nothing had told.
    reopened: bool,
}

impl Filter<f64> for Pass {
    type Params = CausalParams<f64>;
    const SPEC: &'static FilterSpec = SelfCalKF::<f64>::SPEC;
    const STARTS_ITSELF: bool = SelfCalKF::<f64>::STARTS_ITSELF;
    const HAS_COVARIANCE: bool = SelfCalKF::<f64>::HAS_COVARIANCE;
    const WATCHED: bool = SelfCalKF::<f64>::WATCHED;
    const STARTS_IN_MOTION: bool = SelfCalKF::<f64>::STARTS_IN_MOTION;

    fn new(params: &CausalParams<f64>) -> Self {
        Pass { filter: SelfCalKF::new(params), rate: Vec3::zero(), done: Done::default(), doing: Done::default() }
    }
    fn attitude(&self) -> Quat<f64> {
        self.filter.attitude()
    }
    fn set_attitude(&mut self, lanes: bool, q: Quat<f64>) {
        self.filter.set_attitude(lanes, q);
    }
    fn realign(&mut self, lanes: bool, q: Quat<f64>) {
        self.doing.realigned |= lanes;
        self.filter.realign(lanes, q);
    }
    fn lose_rotation(&mut self, lanes: bool, variance: f64) {
        // What is unknown after it was found again is no loss.
        if lanes && !self.doing.realigned {
            self.doing.lost = variance;
        }
        self.filter.lose_rotation(lanes, variance);
    }
    fn claimed(&self) -> [f64; 2] {
        self.filter.claimed()
    }
    fn known_mag_delay(&self) -> f64 {
        self.filter.known_mag_delay()
    }
    fn reopen(&mut self, lanes: bool, bias: Vec3<f64>) {
        self.doing.reopened |= lanes;
        self.filter.reopen(lanes, bias);
    }
    fn gyr_bias(&self) -> Vec3<f64> {
        self.filter.gyr_bias()
    }
    fn step(&mut self, sample: &Sample<f64>, dt: f64) {
        self.done = std::mem::take(&mut self.doing);
        self.rate = sample.gyr;
        self.filter.step(sample, dt);
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut f64)) {
        self.filter.each_variable(visit);
        self.rate.each(visit);
    }
}

impl Offline for SelfCalSmoother {
    fn solve(&self, series: &Series, outputs: &[usize], watch: &Watch) -> Option<Solution> {
        let count = series.gyr.len();
        let acc = usable(series.acc.as_deref(), count);
        let inclined = acc.iter().any(Option::is_some);
        // The heading of a field is that in the horizontal plane, which has to be known.
        let fields = usable(series.mag.as_deref(), count);
        let mag = if inclined { fields.clone() } else { vec![None; count] };
        let headed = mag.iter().any(Option::is_some);
        let norm = median(mag.iter().flatten().map(|field| field.norm2().sqrt()).collect());
        let mag = mag.into_iter().map(|field| Some(field? * (1.0 / norm))).collect();
        let mut steps: Vec<f64> = series.dt.iter().map(|dt| dt.clamp(0.0, LONGEST_STEP)).collect();
        if let Some(first) = steps.first_mut() {
            *first = 0.0;
        }
        let mut samples = Samples { steps, acc, mag, ..Samples::default() };
        let mut causal = self.causal(series, &mut samples, watch)?;
        let limits = Thresholds { gyr: self.params.rest_gyr, acc: self.params.rest_acc, time: self.params.rest_time };
        samples.find_clipped(self.params.gyr_range);
        causal.turn_back(&mut samples);
        leave_out(&mut samples.acc, &causal.missing, status::ACC_MISSING);
        leave_out(&mut samples.mag, &causal.missing, status::MAG_MISSING);
        samples.find_rest(&limits, vec3(&causal.mean, BIAS));

        let ends = samples.block_ends();
        let mut state = State::new(&self.causal);
        let mut found = Found::new(&samples, &ends, &causal, &mut state, &self.causal);
        for pass in 1..=MOST_PASSES {
            if !watch.go_on() {
                return None;
            }
            if pass > 1 {
                found.blocks = samples.sums(&ends, &found.trajectory, &mut state);
            }
            let correction = found.smooth(&mut state, &self.causal, pass >= PASSES, watch);
            if pass >= PASSES && correction < CONVERGED {
                break;
            }
        }

        if !watch.go_on() {
            return None;
        }
        let quats = samples.attitudes(&ends, &found.trajectory, &mut state, self.params.latency);
        let rejected = |block: &Summed| block.sums.fields > 0.0 && block.weight < REJECTING_WEIGHT;
        let mut status = Vec::with_capacity(count);
        let mut gyr_bias = Vec::with_capacity(count);
        let mut each = causal.missing.iter().zip(&samples.rest).zip(samples.mag.iter().zip(&fields));
        let mut start = 0;
        for ((block, mean), &end) in found.blocks.iter().zip(found.trajectory.mean.iter().skip(1)).zip(&ends) {
            for ((missing, &rest), (mag, field)) in each.by_ref().take(end - start) {
                let flags = Flags {
                    rest,
                    // Of what was measured, not of what can be used.
                    mag_missing: series.mag.is_some() && field.is_none(),
                    mag_rejected: mag.is_some() && rejected(block),
                    not_aligned: !inclined,
                    ..Flags::none()
                };
                status.push(missing | flags.bits(0));
                gyr_bias.push(vec3(mean, BIAS));
            }
            start = end;
        }
        let extra = |&index: &usize| found.output(index, &ends, (&quats, headed), norm);
        Some(Solution {
            extra: outputs.iter().map(extra).collect(),
            quat: continuous(&quats, output_rotation(series, &self.settings, headed)),
            gyr_bias,
            status,
        })
    }
}

impl SelfCalSmoother {
    /// The causal filter over the recording; leaves the angular rates with the samples.
    fn causal(&self, series: &Series, samples: &mut Samples, watch: &Watch) -> Option<Causal> {
        let settings = causal_settings(&self.settings);
        let mut estimator = Estimator::<f64, Pass>::new(&self.causal, settings);
        let none = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
        let count = series.gyr.len();
        let (mut quat, mut missing) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut findings = Vec::new();
        let mut unnoticed = None;
        samples.rates.reserve_exact(count);
        samples.lost.reserve_exact(count);
        let inclined = samples.acc.iter().any(Option::is_some);
        let rows = series.gyr.iter().zip(&series.dt).zip(samples.acc.iter().zip(&samples.mag));
        for (index, ((&gyr, &dt), (acc, mag))) in rows.enumerate() {
            if index % TILE == 0 && !watch.go_on() {
                return None;
            }
            let acc = series.acc.as_ref().map(|_| acc.unwrap_or(none));
            let mag = series.mag.as_ref().filter(|_| inclined).map(|_| mag.unwrap_or(none));
            let output = estimator.step(gyr, acc, mag, dt);
            quat.push(output.quat);
            missing.push(output.flags.bits(0) & KEPT);
            let pass = estimator.filter();
            samples.rates.push(pass.rate);
            samples.lost.push(pass.done.lost);
            if pass.done.reopened {
                unnoticed = Some(index);
            }
            if pass.done.realigned {
                findings.push(Finding { index, bias: pass.gyr_bias(), unnoticed: unnoticed.take() });
            }
        }
        let filter = &estimator.filter().filter;
        let mut mean = filter.state().mean;
        // In norms of the median field, as all here.
        for (index, at) in [(4, IRON), (5, DISTURBANCE), (7, HORIZONTAL)] {
            let mut states = at..;
            filter.output(index, &mut |value| {
                if let Some(entry) = states.next().and_then(|i| mean.get_mut(i)) {
                    *entry = value;
                }
            });
        }
        Some(Causal { quat, missing, findings, mean })
    }
}

/// The median, the upper one of two; one where there is none.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 1.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
