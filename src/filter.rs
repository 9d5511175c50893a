//! What a filter is: its description, its input, its state and its step.

use crate::estimator::reading::Measured;
use crate::params::{ParamSet, ParamSpec};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3};
use crate::status::Flags;

/// The description of a filter, from which classes, command line, tests and docs are made.
#[derive(Clone, Copy, Debug)]
pub struct FilterSpec {
    /// The name of the class.
    pub name: &'static str,
    /// What it does, in a few sentences.
    pub doc: &'static str,
    /// Paper and equations.
    pub source: &'static str,
    /// What a magnetometer is used for.
    pub magnetometer: Magnetometer,
    /// True where an attitude error decays while the measurements are good.
    pub feedback: bool,
    /// True where it estimates the gyroscope's bias.
    pub gyr_bias: bool,
    /// What a rotation of the sensor frame does to the estimate.
    pub equivariance: Equivariance,
    /// Its parameters.
    pub params: &'static [ParamSpec],
    /// Parameter sets with a name.
    pub presets: &'static [Preset],
    /// What it can give beside the attitude.
    pub outputs: &'static [OutputSpec],
}

/// What a filter uses a magnetometer for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Magnetometer {
    /// For the heading at the start only: a 6D filter.
    InitialHeading,
    /// All the time where one is given: 9D, or 6D without.
    Feedback,
}

/// What a rotation r of the sensor frame (measurements r v) does to the estimate of a filter at its defaults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equivariance {
    /// It becomes q ⊗ r*; in 6D up to a constant heading.
    Exact,
    /// It becomes q ⊗ r* up to a constant heading.
    Heading,
    /// No law, and why.
    No(&'static str),
}

/// A parameter set of a paper.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The name, as `ludwig2018`.
    pub name: &'static str,
    /// Parameters that differ from the defaults.
    pub values: &'static [(&'static str, f64)],
}

/// Something that a filter can give beside the attitude, one row a sample.
#[derive(Clone, Copy, Debug)]
pub struct OutputSpec {
    /// The name.
    pub name: &'static str,
    /// Meaning and unit.
    pub doc: &'static str,
    /// The shape of one row.
    pub shape: &'static [usize],
}

impl OutputSpec {
    /// The number of values in one row.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }
    /// True where a row holds nothing.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The measurements of one time, in one right-handed sensor frame.
#[derive(Clone, Copy, Debug)]
pub struct Sample<S: Scalar> {
    /// Angular rate in rad/s; always usable.
    pub gyr: Vec3<S>,
    /// Specific force in m/s².
    pub acc: Measured<S>,
    /// Magnetic field in µT.
    pub mag: Measured<S>,
    /// Where the angular rate is not that of the whole step (held, clipped, over a gap): what it turns says nothing of the
    /// gyroscope.
    pub lost: S::Mask,
    /// Where the attitude has not been found again since a loss: its error says nothing of the gyroscope.
    pub recovering: S::Mask,
    /// True where no measurement of any lane stands for more than the step.
    pub prompt: bool,
    /// The usual step in s, at least this one: that of a regular clock is the step.
    pub usual: S,
}

/// How sure of the inclination in motion a filter is at best whose covariance is not one to be watched by, in rad.
const UNSURE: f64 = 0.05;
/// The longest time in s for which one reading of a step that is lost shows rest.
const LONGEST_REST: f64 = 0.1;

/// How much the measurements of a sample count beside each other, and the time that they stand for.
#[derive(Clone, Copy, Debug)]
pub struct Weights<S> {
    /// Of the accelerometer and the magnetometer; one for both where they are as fast as the gyroscope.
    pub acc: S,
    /// As `acc`.
    pub mag: S,
    /// In s, that of the longest; the step where they are as fast as the gyroscope.
    pub time: S,
    /// True where both weights are one in all lanes.
    pub equal: bool,
}

impl<S: Scalar> Sample<S> {
    /// The time of the step `dt` for which it shows rest: one reading is no mean over a gap.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rest_time(&self, dt: S) -> S {
        S::select(self.lost, dt.min(S::of(LONGEST_REST)), dt)
    }
    /// Where a measurement stands for more than the step: its sensor is slower than the gyroscope, or missed some samples.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn late(&self, dt: S) -> S::Mask {
        (self.acc.valid & dt.lt(self.acc.interval)) | (self.mag.valid & dt.lt(self.mag.interval))
    }

    /// The weights by which errors are added up so that each measurement counts for the time since the last one of its sensor.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn weights(&self, dt: S) -> Weights<S> {
        let one = S::one();
        if self.prompt {
            return Weights { acc: one, mag: one, time: dt, equal: true };
        }
        let late = self.late(dt);
        let time_of = |measured: &Measured<S>| S::select(measured.valid, measured.interval, dt);
        let (acc, mag) = (time_of(&self.acc), time_of(&self.mag));
        let time = acc.max(mag);
        let weight = |interval: S| S::select(late, interval / time, one);
        Weights { acc: weight(acc), mag: weight(mag), time: S::select(late, time, dt), equal: false }
    }
}

impl<S: Scalar> Measured<S> {
    /// How many usual steps of the gyroscope the measurement stands for: one where it comes with each of them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn steps(&self, usual: S) -> S {
        let late = self.valid & usual.lt(self.interval) & S::zero().lt(usual);
        if late.any() { S::select(late, self.interval / usual, S::one()) } else { S::one() }
    }
}

/// An attitude filter: what it keeps between samples and what it does with one.
///
/// [`Estimator`](crate::Estimator) gives every filter the common rules (alignment, missing data, frames, sign), so an
/// implementation holds its paper's equations and nothing else. Everything is computed in east-north-up.
pub trait Filter<S: Scalar>: Clone {
    /// Its parameters.
    type Params: ParamSet<S>;
    /// The description, the same for every scalar.
    const SPEC: &'static FilterSpec;
    /// True where the filter takes its start from the first measurements by itself: it gets the first sample with its time
    /// step, the accelerometer from the first valid row on and the magnetometer from the first that comes with a known
    /// inclination, and is never aligned.
    const STARTS_ITSELF: bool = false;
    /// True where the filter knows how sure it is of the attitude: it is told how much of a rotation was lost.
    const HAS_COVARIANCE: bool = false;
    /// True where the estimator watches whether that is so (`claimed`, `reopen`).
    const WATCHED: bool = false;
    /// True where the filter expects to be switched on in motion: accelerations at the start are no reason to begin again.
    const STARTS_IN_MOTION: bool = false;

    /// The filter at the identity, with no memory of any sample.
    fn new(params: &Self::Params) -> Self;
    /// The attitude: a unit quaternion from the sensor frame to east-north-up.
    fn attitude(&self) -> Quat<S>;
    /// Sets the attitude of the lanes of the mask, and the part of its covariance that is new with it; nothing else.
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>);
    /// True where the attitude is to be aligned again after a rotation that was lost: not where each sample gives it by itself, nor
    /// where nothing but the gyroscope does.
    fn is_realigned(&self) -> bool {
        Self::SPEC.feedback
    }
    /// Sets the attitude of the lanes of the mask after a rotation that was lost. What was learnt of the sensors stays; what was
    /// measured before the loss says nothing of the attitude any more.
    fn realign(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.set_attitude(lanes, q);
    }
    /// Takes it that a rotation was lost where the mask is true: its angle about each axis has the variance (rad²). For filters
    /// that know how sure they are; the others are aligned again.
    fn lose_rotation(&mut self, _lanes: S::Mask, _variance: S) {}
    /// The variances of inclination and heading that the filter claims, in rad², where it is to be watched; the larger one of the
    /// inclination's two. Not those of a filter whose covariance is far too sure in motion or says tens of degrees: that is sure
    /// of the inclination to 0.05 rad, and of the heading to 1 rad.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn claimed(&self) -> [S; 2] {
        [S::of(UNSURE * UNSURE), S::one()]
    }
    /// The delay in s of the magnetometer behind the gyroscope, as far as the filter knows it.
    fn known_mag_delay(&self) -> S {
        S::zero()
    }
    /// Starts anew where the mask is true, as the attitude is lost without having been told: what was learnt since may be wrong.
    /// The gyroscope's bias is the one from before.
    fn reopen(&mut self, _lanes: S::Mask, _bias: Vec3<S>) {}
    /// Starts from an attitude that is given one step before the first sample.
    fn start_from(&mut self, q: Quat<S>) {
        self.set_attitude(S::Mask::splat(true), q);
    }
    /// Goes on by `dt` seconds to a new sample. Where dt is zero and no measurement valid, nothing changes but the
    /// last bits of the norm.
    fn step(&mut self, sample: &Sample<S>, dt: S);
    /// The estimated gyroscope bias in rad/s.
    fn gyr_bias(&self) -> Vec3<S> {
        Vec3::zero()
    }
    /// True where the parameters are such that the bias is never anything but zero, and need not be written down.
    fn bias_stays_zero(&self) -> bool {
        false
    }
    /// Sets the bits of rejection, rest and recovery of the last step.
    fn flag(&self, _flags: &mut Flags<S::Mask>) {}
    /// Calls `put` with each value of output `index` of the description, row by row.
    fn output(&self, _index: usize, _put: &mut impl FnMut(S)) {}
    /// Calls `visit` for every variable that the next step depends on.
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S));
}
