//! OfflineVQF (Laidig & Seel 2023, the acausal variant of VQF).
//!
//! VQF goes over the recording forward and backward and learns the gyroscope's bias, rest and magnetic disturbances from
//! both sides. Then the attitude is computed anew with filters that have no phase: strapdown integration without the bias,
//! the low-pass filtered specific force, and the heading offset.

use ahrs_rs::estimator::LONGEST_STEP;
use ahrs_rs::filter::{Equivariance, Magnetometer, OutputSpec, Sample};
use ahrs_rs::filters::VQF;
use ahrs_rs::filters::vqf::bias::Estimate;
use ahrs_rs::filters::vqf::heading::{Heading, angle, has_heading, turned};
use ahrs_rs::filters::vqf::inclination::{corrected, seen_from};
use ahrs_rs::filters::vqf::interval::Interval;
use ahrs_rs::filters::vqf::{BIAS_SIGMA, DELTA, PARAMS, Params, QUAT6D, QUAT9D, REST, limited_field};
use ahrs_rs::params::{ParamError, ParamSet};
use ahrs_rs::signal::{Coefficients, Gain, LowPass};
use ahrs_rs::so3::rotate_by;
use ahrs_rs::{Estimator, Filter, FilterSpec, Flags, Measured, Quat, Reading, Settings, Vec3};

use super::{Offline, Series, Solution};
use crate::threads::Watch;

/// Samples between two looks at whether it was told to stop.
const TILE: usize = 4096;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "OfflineVQF",
    doc: "VQF over a whole recording: the gyroscope's bias, rest and magnetic disturbances are learnt forward and \
          backward in time, and the filters of the specific force and of the heading have no delay, so that every \
          attitude knows the future too. Offline: no update and no state. Computed in float64 whatever the dtype.",
    source: "Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024), the offline variant; defaults and order of \
             steps as published with its package vqf",
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
            doc: "1 where forward and backward the magnetic field is disturbed or no undisturbed one is known, else 0",
            shape: &[],
        },
    ],
};

/// The filter with the values of its parameters.
pub fn make(values: &[f64], settings: Settings) -> Result<Box<dyn Offline>, ParamError> {
    Ok(Box::new(OfflineVQF { params: Params::from_values(values)?, settings }))
}

struct OfflineVQF {
    params: Params<f64>,
    settings: Settings,
}

/// VQF in one direction, and the angular rate that it was given last: where rows are missing, the held one.
#[derive(Clone)]
struct Pass {
    vqf: VQF<f64>,
    rate: Vec3<f64>,
}

impl Filter<f64> for Pass {
    type Params = Params<f64>;
    const SPEC: &'static FilterSpec = &SPEC;
    const STARTS_ITSELF: bool = true;

    fn new(params: &Params<f64>) -> Self {
        Pass { vqf: VQF::new(params), rate: Vec3::zero() }
    }
    fn attitude(&self) -> Quat<f64> {
        self.vqf.attitude()
    }
    fn set_attitude(&mut self, lanes: bool, q: Quat<f64>) {
        self.vqf.set_attitude(lanes, q);
    }
    fn step(&mut self, sample: &Sample<f64>, dt: f64) {
        self.rate = sample.gyr;
        self.vqf.step(sample, dt);
    }
    fn flag(&self, flags: &mut Flags<bool>) {
        self.vqf.flag(flags);
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut f64)) {
        self.vqf.each_variable(visit);
        self.rate.each(visit);
    }
}

/// What a pass says of a sample.
#[derive(Clone, Copy)]
struct Learnt {
    bias: Estimate<f64>,
    rest: bool,
    disturbed: bool,
}

impl Learnt {
    fn of(pass: &Pass) -> Self {
        Learnt {
            bias: pass.vqf.bias().estimate(),
            rest: pass.vqf.rests(),
            disturbed: pass.vqf.magnetic().disturbed() > 0.5,
        }
    }

    /// The same of a recording that was played backward, with every turn the other way round.
    fn played_backward(pass: &Pass) -> Self {
        let mut learnt = Learnt::of(pass);
        learnt.bias.value = -learnt.bias.value;
        learnt
    }

    /// At rest where one direction sees it (rest is seen at its end), disturbed where both do.
    fn joined(&self, other: &Self) -> Self {
        Learnt {
            bias: self.bias.joined(&other.bias),
            rest: self.rest | other.rest,
            disturbed: self.disturbed & other.disturbed,
        }
    }
}

/// What both passes say of a recording: by sample, what is learnt, the angular rate to integrate, and the rows' flags.
struct Passes {
    learnt: Vec<Learnt>,
    rates: Vec<Vec3<f64>>,
    flags: Vec<Flags<bool>>,
}

/// How the field of a sample was taken.
#[derive(Clone, Copy, Default)]
struct Taken {
    used: bool,
    lessened: bool,
}

/// A measurement where it can be used.
type Row = Option<Vec3<f64>>;

impl Offline for OfflineVQF {
    fn solve(&self, series: &Series, outputs: &[usize], watch: &Watch) -> Option<Solution> {
        let steps: Vec<f64> = series.dt.iter().map(|dt| dt.clamp(0.0, LONGEST_STEP)).collect();
        // Seen from the end, a sample comes after the step that the next one ends; the first one after that of the start.
        let back: Vec<f64> = steps.iter().take(1).chain(steps.iter().skip(1).rev()).copied().collect();
        let Passes { learnt, rates, mut flags } = self.passes(series, &steps, &back, watch)?;

        // Strapdown integration, and the specific force in the almost inertial frame that comes of it.
        let mut gyr = Quat::identity();
        let attitudes: Vec<_> = learnt
            .iter()
            .zip(rates.iter().zip(&steps))
            .map(|(learnt, (&rate, &dt))| {
                gyr = rotate_by(gyr, rate - learnt.bias.value, dt);
                gyr
            })
            .collect();
        let acc = usable(series.acc.as_deref(), series.gyr.len());
        let inclined = acc.iter().any(Option::is_some);
        let mut forces: Vec<Row> =
            attitudes.iter().zip(acc).map(|(&gyr, force)| Some(seen_from(gyr, force?))).collect();
        self.low_pass(&mut forces, &steps, &back);
        let level = leveled(&attitudes, &forces);
        if !watch.go_on() {
            return None;
        }

        // The heading of a field is that in the horizontal plane, which has to be known.
        let mag = if inclined { usable(series.mag.as_deref(), series.gyr.len()) } else { vec![None; series.gyr.len()] };
        let mut angles: Vec<_> = level
            .iter()
            .zip(mag)
            .map(|(level, field)| {
                Some(level.rotate(limited_field(field?))).filter(|&field| has_heading(field)).map(angle)
            })
            .collect();
        let mut taken = vec![Taken::default(); angles.len()];
        let headed = angles.iter().any(Option::is_some);
        self.filter_headings(&mut angles, &mut taken, &learnt, &steps, false);
        self.filter_headings(&mut angles, &mut taken, &learnt, &back, true);
        let delta = filled(&angles);

        for (((flags, learnt), taken), angle) in flags.iter_mut().zip(&learnt).zip(&taken).zip(&angles) {
            flags.rest = learnt.rest;
            flags.mag_rejected = angle.is_some() && !taken.used;
            flags.recovering = taken.lessened;
            flags.not_aligned = !inclined;
        }
        let headings = level.iter().zip(&delta).map(|(&level, &delta)| turned(level, delta).renormalized());
        let headings: Vec<_> = headings.collect();
        let extra = |&index: &usize| output(index, &learnt, &level, &headings, &delta);
        Some(Solution {
            extra: outputs.iter().map(extra).collect(),
            quat: continuous(&headings, self.settings.output_rotation(headed)),
            gyr_bias: learnt.iter().map(|learnt| learnt.bias.value).collect(),
            status: flags.iter().map(|flags| flags.bits(0)).collect(),
        })
    }
}

impl OfflineVQF {
    /// VQF forward, and over the same recording played backward. Side by side: a step of one does not wait for the other.
    fn passes(&self, series: &Series, steps: &[f64], back: &[f64], watch: &Watch) -> Option<Passes> {
        let samples = series.gyr.len();
        let settings = Settings { gyr_hold: self.settings.gyr_hold, ..Settings::default() };
        let mut forward = Estimator::<f64, Pass>::new(&self.params, settings);
        let mut backward = forward.clone();
        let mut found = Passes {
            learnt: Vec::with_capacity(samples),
            rates: Vec::with_capacity(samples),
            flags: Vec::with_capacity(samples),
        };
        let mut later = Vec::with_capacity(samples);
        let reading = |index: usize, sign: f64| {
            let row = |rows: &Option<Vec<Vec3<f64>>>| rows.as_ref().and_then(|rows| rows.get(index)).copied();
            Some(Reading::new(*series.gyr.get(index)? * sign, row(&series.acc), row(&series.mag)))
        };
        for (index, (&dt, &back_dt)) in steps.iter().zip(back).enumerate() {
            if index % TILE == 0 && !watch.go_on() {
                return None;
            }
            found.flags.push(forward.take(&reading(index, 1.0)?, dt).flags);
            backward.take(&reading(samples - 1 - index, -1.0)?, back_dt);
            found.learnt.push(Learnt::of(forward.filter()));
            found.rates.push(forward.filter().rate);
            later.push(Learnt::played_backward(backward.filter()));
        }
        for (learnt, later) in found.learnt.iter_mut().zip(later.iter().rev()) {
            *learnt = learnt.joined(later);
        }
        Some(found)
    }

    /// Low-pass filters the forces forward and backward; the way back starts at rest at what it sees first.
    fn low_pass(&self, forces: &mut [Row], steps: &[f64], back: &[f64]) {
        let mut coefficients = Coefficients::new(self.params.tau_acc);
        let mut forward = (Interval::default(), LowPass::default());
        let mut step = |(interval, low_pass): &mut (Interval<f64>, LowPass<f64, 3>), force: &mut Row, dt: f64| {
            let interval = interval.step(force.is_some(), dt);
            if let Some(force) = force {
                coefficients.set_step(true, interval);
                *force = low_pass.step_vector(true, *force, &coefficients);
            }
        };
        for (force, &dt) in forces.iter_mut().zip(steps) {
            step(&mut forward, force, dt);
        }
        let last = forces.iter().rev().find_map(|force| *force).unwrap_or(Vec3::zero());
        let at_rest = LowPass::at([last.x, last.y, last.z], &Coefficients::new(self.params.tau_acc));
        let mut backward = (Interval::default(), at_rest);
        for (force, &dt) in forces.iter_mut().rev().zip(back) {
            step(&mut backward, force, dt);
        }
    }

    /// Filters the heading offsets in one direction of time. A disturbed field is left out, but not for ever.
    fn filter_headings(
        &self,
        angles: &mut [Option<f64>],
        taken: &mut [Taken],
        learnt: &[Learnt],
        steps: &[f64],
        from_the_end: bool,
    ) {
        let params = &self.params;
        let mut heading = Heading::default();
        let mut gain = Gain::new(params.tau_mag);
        let mut interval = Interval::default();
        let mut rejected: f64 = 0.0;
        let mut step = |((angle, taken), learnt): ((&mut Option<f64>, &mut Taken), &Learnt), dt: f64| {
            let interval = interval.step(angle.is_some(), dt);
            let Some(angle) = angle else { return };
            let mut weight = gain.weight(true, interval);
            if params.mag_dist_rejection_enabled {
                if !learnt.disturbed {
                    rejected = (rejected - params.mag_rejection_factor * interval).max(0.0);
                } else if rejected <= params.mag_max_rejection_time {
                    rejected += interval;
                    weight = 0.0;
                } else {
                    weight /= params.mag_rejection_factor;
                    taken.lessened = true;
                }
            }
            taken.used |= weight > 0.0 || heading.starts();
            heading.correct_to(true, *angle, weight, [interval, params.tau_mag]);
            *angle = heading.delta();
        };
        let rows = angles.iter_mut().zip(taken).zip(learnt);
        if from_the_end {
            rows.rev().zip(steps).for_each(|(row, &dt)| step(row, dt));
        } else {
            rows.zip(steps).for_each(|(row, &dt)| step(row, dt));
        }
    }
}

/// The rows of a sensor that hold a measurement.
fn usable(rows: Option<&[Vec3<f64>]>, samples: usize) -> Vec<Row> {
    let row = |&row: &Vec3<f64>| Some(Measured::new(row)).filter(|measured| measured.valid).map(|_| row);
    rows.map_or_else(|| vec![None; samples], |rows| rows.iter().map(row).collect())
}

/// The attitudes with the inclination that the low-pass filtered forces show. A missing one leaves the correction as it is;
/// before the first one that is the one of the first.
fn leveled(attitudes: &[Quat<f64>], forces: &[Row]) -> Vec<Quat<f64>> {
    let mut acc = Quat::identity();
    let mut before =
        forces.first().copied().flatten().is_none().then(|| forces.iter().find_map(|force| *force)).flatten();
    let level = |(&gyr, &force): (&Quat<f64>, &Row)| {
        if let Some((better, _, true)) = force.or(before.take()).map(|slow| corrected(acc, slow)) {
            acc = better;
        }
        acc * gyr
    };
    attitudes.iter().zip(forces).map(level).collect()
}

/// The heading offsets of all samples: a missing one is that of the next sample that has one, at the end of the last, as the
/// filter that came from the end has left it; zero where none has one.
fn filled(angles: &[Option<f64>]) -> Vec<f64> {
    let mut next = angles.iter().rev().find_map(|angle| *angle).unwrap_or(0.0);
    let mut delta: Vec<_> = angles
        .iter()
        .rev()
        .map(|angle| {
            next = angle.unwrap_or(next);
            next
        })
        .collect();
    delta.reverse();
    delta
}

/// The attitudes in the frame into which `to` turns, with signs that go on from each other; the first with w ≥ 0.
fn continuous(attitudes: &[Quat<f64>], to: Quat<f64>) -> Vec<Quat<f64>> {
    let mut before = Quat::identity();
    let turns = to.vector().norm2() > 0.0;
    let continued = |&q: &Quat<f64>| {
        let q = if turns { to * q } else { q };
        before = if q.dot(before) < 0.0 { -q } else { q };
        before
    };
    attitudes.iter().map(continued).collect()
}

/// The values of an output of the description, one row after the other.
fn output(index: usize, learnt: &[Learnt], level: &[Quat<f64>], headings: &[Quat<f64>], delta: &[f64]) -> Vec<f64> {
    let quats = |quats: &[Quat<f64>]| quats.iter().flat_map(|q| [q.w, q.x, q.y, q.z]).collect();
    let each = |value: fn(&Learnt) -> f64| learnt.iter().map(value).collect();
    match index {
        0 => quats(level),
        1 => quats(headings),
        2 => delta.to_vec(),
        3 => each(|learnt| learnt.bias.sigma()),
        4 => each(|learnt| f64::from(u8::from(learnt.rest))),
        _ => each(|learnt| f64::from(u8::from(learnt.disturbed))),
    }
}
