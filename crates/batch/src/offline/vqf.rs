//! OfflineVQF (Laidig & Seel 2023, the acausal variant of VQF).
//!
//! VQF goes over the recording forward and backward and learns the gyroscope's bias, rest and magnetic disturbances from
//! both sides. Then the attitude is computed anew with filters that have no phase: strapdown integration without the bias,
//! the low-pass filtered specific force, and the heading offset.

use ahrs_rs::estimator::LONGEST_STEP;
use ahrs_rs::estimator::intervals::Interval;
use ahrs_rs::filter::{Equivariance, Magnetometer, OutputSpec, Sample};
use ahrs_rs::filters::VQF;
use ahrs_rs::filters::delay::caught_up;
use ahrs_rs::filters::vqf::bias::Estimate;
use ahrs_rs::filters::vqf::heading::{Heading, angle, has_heading, turned};
use ahrs_rs::filters::vqf::inclination::{corrected, seen_from};
use ahrs_rs::filters::vqf::{BIAS_SIGMA, DELTA, PARAMS, Params, QUAT6D, QUAT9D, REST, limited_field};
use ahrs_rs::params::{ParamError, ParamSet};
use ahrs_rs::signal::{Coefficients, Gain, LowPass};
use ahrs_rs::so3::rotate_by;
use ahrs_rs::status;
use ahrs_rs::{Estimator, Filter, FilterSpec, Flags, Mask, Quat, Scalar, Settings, Vec3};

use super::pieces::pieces;
use super::{KEPT, Offline, Row, Series, Solution, causal_settings, continuous, leave_out, output_rotation, usable};
use crate::threads::Watch;
use ahrs_rs_lanes::simd::{Instructions, Kernel, PortableIsa, Vector};
#[cfg(target_arch = "x86_64")]
use {
    crate::isa,
    ahrs_rs_lanes::simd::{Avx2, Isa},
};

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
    Ok(Box::new(OfflineVQF { params: Params::from_values(values)?, values: values.to_vec(), settings }))
}

struct OfflineVQF {
    params: Params<f64>,
    values: Vec<f64>,
    settings: Settings,
}

/// VQF, and the angular rate that it was given last: where rows are missing, the held one.
#[derive(Clone)]
struct Pass<S: Scalar> {
    vqf: VQF<S>,
    rate: Vec3<S>,
    /// The variance of the rotation that was lost with it, and what is lost before the next one.
    lost: S,
    losing: S,
}

impl<S: Scalar> Filter<S> for Pass<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const STARTS_ITSELF: bool = true;

    fn new(params: &Params<S>) -> Self {
        Pass { vqf: VQF::new(params), rate: Vec3::zero(), lost: S::zero(), losing: S::zero() }
    }
    /// Without the heading offset, for which nobody asks here.
    #[inline(always)]
    fn attitude(&self) -> Quat<S> {
        self.vqf.inclination().attitude()
    }
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.vqf.set_attitude(lanes, q);
    }
    #[inline(always)]
    fn realign(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.vqf.realign(lanes, q);
    }
    #[inline(always)]
    fn lose_rotation(&mut self, lanes: S::Mask, variance: S) {
        self.losing = S::select(lanes, variance, self.losing);
    }
    #[inline(always)]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        self.rate = sample.gyr;
        (self.lost, self.losing) = (self.losing, S::zero());
        self.vqf.step(sample, dt);
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.vqf.each_variable(visit);
        self.rate.each(visit);
        visit(&mut self.losing);
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
    #[inline(always)]
    fn of<S: Scalar<Real = f64>>(pass: &Pass<S>, lane: usize) -> Self {
        Learnt {
            bias: pass.vqf.bias().estimate().lane(lane),
            rest: pass.vqf.rests().lane(lane),
            disturbed: pass.vqf.magnetic().disturbed().lane(lane) > 0.5,
        }
    }

    /// From what this says and what `later` says of the same sample in the recording played backward, where every turn is the
    /// other way round: at rest where one direction sees it (rest is seen at its end), disturbed where both do.
    fn joined(&self, later: &Self) -> Self {
        let mut bias = later.bias;
        bias.value = -bias.value;
        Learnt {
            bias: self.bias.joined(&bias),
            rest: self.rest | later.rest,
            disturbed: self.disturbed & later.disturbed,
        }
    }
}

/// What both passes say of a recording: by sample, what is learnt, the angular rate to integrate, and what is missing.
#[derive(Default)]
struct Passes {
    learnt: Vec<Learnt>,
    rates: Vec<Vec3<f64>>,
    missing: Vec<u16>,
    /// The variance in rad² of the rotation that was lost.
    lost: Vec<f64>,
}

/// VQF forward in the first lane, and over the recording played backward in the second: a step takes little longer than one
/// of a filter alone. Other lanes do the same as the second.
struct BothWays<'a, S: Scalar> {
    estimator: Estimator<S, Pass<S>>,
    series: &'a Series,
    steps: &'a [f64],
    back: &'a [f64],
    watch: &'a Watch,
    found: &'a mut Passes,
    later: &'a mut Vec<Learnt>,
}

impl<'a, S: Vector<Real = f64>> BothWays<'a, S> {
    fn new(
        of: &OfflineVQF,
        series: &'a Series,
        (steps, back): (&'a [f64], &'a [f64]),
        watch: &'a Watch,
        (found, later): (&'a mut Passes, &'a mut Vec<Learnt>),
    ) -> Result<Self, ParamError> {
        let settings = causal_settings(&of.settings);
        // Seen from the end, a late reading is one that is ahead.
        let mut params: Params<S> = Params::from_lanes(&[&of.values])?;
        params.mag_delay = both(of.params.mag_delay, -of.params.mag_delay);
        let estimator = Estimator::new(&params, settings);
        Ok(BothWays { estimator, series, steps, back, watch, found, later })
    }

    /// The rows of a sensor that may not be there.
    #[allow(clippy::manual_map, reason = "a closure is not sure to be compiled for the vector instructions")]
    #[inline(always)]
    fn given(rows: Option<&[Vec3<f64>]>, index: usize) -> Option<Vec3<S>> {
        match rows {
            Some(rows) => Some(Self::rows(rows, index, 1.0)),
            None => None,
        }
    }

    /// The rows at a sample and as many before the end.
    #[inline(always)]
    fn rows(rows: &[Vec3<f64>], index: usize, sign: f64) -> Vec3<S> {
        let none = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
        let first = rows.get(index).copied().unwrap_or(none);
        let second = rows.get(rows.len().wrapping_sub(index + 1)).copied().unwrap_or(none) * sign;
        Vec3::new(both(first.x, second.x), both(first.y, second.y), both(first.z, second.z))
    }
}

#[inline(always)]
fn both<S: Vector<Real = f64>>(first: f64, second: f64) -> S {
    S::load(&[first, second, second, second])
}

impl<S: Vector<Real = f64>> Kernel for BothWays<'_, S> {
    #[inline(always)]
    fn run(self) {
        let mut estimator = self.estimator;
        for (index, (&dt, &back_dt)) in self.steps.iter().zip(self.back).enumerate() {
            if index % TILE == 0 && !self.watch.go_on() {
                return;
            }
            let acc = Self::given(self.series.acc.as_deref(), index);
            let mag = Self::given(self.series.mag.as_deref(), index);
            let output = estimator.step(Self::rows(&self.series.gyr, index, -1.0), acc, mag, both(dt, back_dt));
            let pass = estimator.filter();
            self.found.missing.push(output.flags.bits(0) & KEPT);
            self.found.lost.push(pass.lost.lane(0));
            self.found.rates.push(Vec3::new(pass.rate.x.lane(0), pass.rate.y.lane(0), pass.rate.z.lane(0)));
            self.found.learnt.push(Learnt::of(pass, 0));
            self.later.push(Learnt::of(pass, 1));
        }
    }
}

/// How the field of a sample was taken.
#[derive(Clone, Copy, Default)]
struct Taken {
    used: bool,
    lessened: bool,
}

impl Offline for OfflineVQF {
    fn solve(&self, series: &Series, outputs: &[usize], watch: &Watch) -> Option<Solution> {
        let steps: Vec<f64> = series.dt.iter().map(|dt| dt.clamp(0.0, LONGEST_STEP)).collect();
        let back = backward(&steps, steps.first().copied());
        let Passes { learnt, rates, missing, lost } = self.passes(series, &steps, &back, watch)?;
        let pieces = pieces(&lost);

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
        let mut acc = usable(series.acc.as_deref(), series.gyr.len());
        leave_out(&mut acc, &missing, status::ACC_MISSING);
        let inclined = acc.iter().any(Option::is_some);
        let mut forces: Vec<Row> = attitudes
            .iter()
            .zip(acc.into_iter().zip(&pieces.amid))
            .map(|(&gyr, (force, &amid))| Some(seen_from(gyr, force.filter(|_| !amid)?)))
            .collect();
        // The frame of the integration is another one behind a loss.
        let mut level = Vec::with_capacity(attitudes.len());
        for piece in &pieces.ranges {
            let forces = forces.get_mut(piece.clone()).unwrap_or_default();
            let steps = steps.get(piece.clone()).unwrap_or_default();
            self.low_pass(forces, steps, &backward(steps, back.first().copied()));
            level.extend(leveled(attitudes.get(piece.clone()).unwrap_or_default(), forces));
        }
        if !watch.go_on() {
            return None;
        }

        // The heading of a field is that in the horizontal plane, which has to be known.
        let mut mag =
            if inclined { usable(series.mag.as_deref(), series.gyr.len()) } else { vec![None; series.gyr.len()] };
        leave_out(&mut mag, &missing, status::MAG_MISSING);
        let delay = self.params.mag_delay;
        let present = |field, (&rate, learnt): (&Vec3<f64>, &Learnt)| {
            caught_up(limited_field(field), rate - learnt.bias.value, delay)
        };
        let mut angles: Vec<_> = level
            .iter()
            .zip(
                mag.into_iter()
                    .zip(&pieces.amid)
                    .map(|(field, &amid)| field.filter(|_| !amid))
                    .zip(rates.iter().zip(&learnt)),
            )
            .map(|(level, (field, turning))| {
                Some(level.rotate(present(field?, turning))).filter(|&field| has_heading(field)).map(angle)
            })
            .collect();
        let mut taken = vec![Taken::default(); angles.len()];
        let headed = angles.iter().any(Option::is_some);
        let mut delta = Vec::with_capacity(angles.len());
        for piece in &pieces.ranges {
            let angles = angles.get_mut(piece.clone()).unwrap_or_default();
            let taken = taken.get_mut(piece.clone()).unwrap_or_default();
            let learnt = learnt.get(piece.clone()).unwrap_or_default();
            let steps = steps.get(piece.clone()).unwrap_or_default();
            self.filter_headings(angles, taken, learnt, steps, false);
            self.filter_headings(angles, taken, learnt, &backward(steps, back.first().copied()), true);
            // Where nothing was measured, the heading of the piece before it.
            let before = delta.last().copied().unwrap_or(0.0);
            delta.extend(filled(angles, before));
        }

        let judged = learnt.iter().zip(taken.iter().zip(&angles)).map(|(learnt, (taken, angle))| Flags {
            rest: learnt.rest,
            mag_rejected: angle.is_some() && !taken.used,
            recovering: taken.lessened,
            not_aligned: !inclined,
            ..Flags::none()
        });
        let status = missing.iter().zip(judged).map(|(missing, judged)| missing | judged.bits(0)).collect();
        let headings = level.iter().zip(&delta).map(|(&level, &delta)| turned(level, delta).renormalized());
        let headings: Vec<_> = headings.collect();
        let extra = |&index: &usize| output(index, &learnt, &level, &headings, &delta);
        Some(Solution {
            extra: outputs.iter().map(extra).collect(),
            quat: continuous(&headings, output_rotation(series, &self.settings, headed)),
            gyr_bias: learnt.iter().map(|learnt| learnt.bias.value).collect(),
            status,
        })
    }
}

impl OfflineVQF {
    /// What VQF learns forward and backward; none where it was told to stop.
    fn passes(&self, series: &Series, steps: &[f64], back: &[f64], watch: &Watch) -> Option<Passes> {
        #[cfg(target_arch = "x86_64")]
        if let (Ok(Some(Isa::Avx2 | Isa::Avx512)), Some(instructions)) = (isa::chosen(), Avx2::detect()) {
            return self.passes_with(instructions, series, (steps, back), watch);
        }
        self.passes_with(PortableIsa, series, (steps, back), watch)
    }

    fn passes_with<I: Instructions<f64>>(
        &self,
        instructions: I,
        series: &Series,
        steps: (&[f64], &[f64]),
        watch: &Watch,
    ) -> Option<Passes> {
        let (mut found, mut later) = (Passes::default(), Vec::new());
        let to = (&mut found, &mut later);
        instructions.run(BothWays::<I::Vector>::new(self, series, steps, watch, to).ok()?);
        for (learnt, later) in found.learnt.iter_mut().zip(later.iter().rev()) {
            *learnt = learnt.joined(later);
        }
        watch.go_on().then_some(found)
    }

    /// Low-pass filters the forces forward and backward; the way back starts at rest at what it sees first.
    fn low_pass(&self, forces: &mut [Row], steps: &[f64], back: &[f64]) {
        let mut coefficients = Coefficients::new(self.params.tau_acc);
        let mut forward = (Interval::new(), LowPass::default());
        let mut step = |(interval, low_pass): &mut (Interval<f64>, LowPass<f64, 3>), force: &mut Row, dt: f64| {
            let interval = interval.step(force.is_some(), dt, dt);
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
        let mut backward = (Interval::new(), at_rest);
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
        let mut interval = Interval::new();
        let mut rejected: f64 = 0.0;
        let mut step = |((angle, taken), learnt): ((&mut Option<f64>, &mut Taken), &Learnt), dt: f64| {
            let interval = interval.step(angle.is_some(), dt, dt);
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

/// The steps seen from the end: a sample comes after the step that the next one ends; the first one after a given one.
fn backward(steps: &[f64], first: Option<f64>) -> Vec<f64> {
    first.into_iter().chain(steps.iter().skip(1).rev().copied()).collect()
}

/// The heading offsets of all samples: a missing one is that of the next sample that has one, at the end of the last, as the
/// filter that came from the end has left it; the given one where none has one.
fn filled(angles: &[Option<f64>], otherwise: f64) -> Vec<f64> {
    let mut next = angles.iter().rev().find_map(|angle| *angle).unwrap_or(otherwise);
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
