//! What a filter is: its description, its input, its state and its step.

use crate::params::{ParamSet, ParamSpec};
use crate::reading::Measured;
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3};

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
}

/// What a filter says of one sample beside the attitude: the bits of `ahrs_rs.Status`.
#[derive(Clone, Copy, Debug)]
pub struct Flags<M> {
    /// The accelerometer's row was unusable.
    pub acc_missing: M,
    /// The magnetometer's row was unusable.
    pub mag_missing: M,
    /// The gyroscope's row was unusable; the last angular rate was held.
    pub gyr_held: M,
    /// The filter did not trust the accelerometer.
    pub acc_rejected: M,
    /// The filter did not trust the magnetometer.
    pub mag_rejected: M,
    /// The sensor rests.
    pub rest: M,
    /// No accelerometer sample has come yet.
    pub not_aligned: M,
    /// The filter recovers from a long rejection.
    pub recovering: M,
}

impl<M: Mask> Flags<M> {
    /// No bit set.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn none() -> Self {
        let no = M::splat(false);
        Flags {
            acc_missing: no,
            mag_missing: no,
            gyr_held: no,
            acc_rejected: no,
            mag_rejected: no,
            rest: no,
            not_aligned: no,
            recovering: no,
        }
    }

    /// The bits of one lane.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn bits(&self, lane: usize) -> u8 {
        let low = u8::from(self.acc_missing.lane(lane))
            | u8::from(self.mag_missing.lane(lane)) << 1
            | u8::from(self.gyr_held.lane(lane)) << 2
            | u8::from(self.acc_rejected.lane(lane)) << 3;
        let high = u8::from(self.mag_rejected.lane(lane))
            | u8::from(self.rest.lane(lane)) << 1
            | u8::from(self.not_aligned.lane(lane)) << 2
            | u8::from(self.recovering.lane(lane)) << 3;
        low | high << 4
    }

    /// Where any bit is set.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn any(&self) -> M {
        let missing = self.acc_missing | self.mag_missing | self.gyr_held | self.not_aligned;
        missing | self.acc_rejected | self.mag_rejected | self.rest | self.recovering
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

    /// The filter at the identity, with no memory of any sample.
    fn new(params: &Self::Params) -> Self;
    /// The attitude: a unit quaternion from the sensor frame to east-north-up.
    fn attitude(&self) -> Quat<S>;
    /// Sets the attitude of the lanes of the mask, and the part of its covariance that is new with it; nothing else.
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>);
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
