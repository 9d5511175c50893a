//! From a reading to a sample: what is missing, held or repeated, and the time that each measurement stands for.

use super::intervals::Interval;
use super::reading::{Measured, Reading};
use super::repeats::{Last, same};
use super::settings::{GyrHold, Repeated, Settings};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::Vec3;
use crate::status::Flags;

/// What the sensors have shown so far.
#[derive(Clone, Debug)]
pub struct Intake<S: Scalar> {
    gyr_hold: GyrHold,
    /// What a repeated row is, and the last rows of the sensors where that matters.
    repeated: Repeated,
    last_acc: Last<S>,
    last_mag: Last<S>,
    /// The last angular rate that was measured.
    rate: Vec3<S>,
    /// Set where an accelerometer has been given.
    acc_seen: S::Mask,
    /// Set where a magnetometer has been given.
    mag_seen: S::Mask,
    /// The times that measurements stand for.
    acc_interval: Interval<S>,
    mag_interval: Interval<S>,
}

/// A reading after that.
pub struct Taken<S: Scalar> {
    /// The angular rate to turn by.
    pub gyr: Vec3<S>,
    /// Specific force and field, or none.
    pub acc: Measured<S>,
    pub mag: Measured<S>,
    /// True where no measurement of any lane may stand for more than the step.
    pub prompt: bool,
}

impl<S: Scalar> Intake<S> {
    /// Before the first reading.
    pub fn new(settings: &Settings) -> Self {
        let no = S::Mask::splat(false);
        Intake {
            gyr_hold: settings.gyr_hold,
            repeated: settings.repeated,
            last_acc: Last::new(),
            last_mag: Last::new(),
            rate: Vec3::zero(),
            acc_seen: no,
            mag_seen: no,
            acc_interval: Interval::new(),
            mag_interval: Interval::new(),
        }
    }

    /// Goes on by `dt` to a reading; `longest` is the longest usual step, `started` set where there was one before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn take(
        &mut self,
        reading: &Reading<S>,
        started: S::Mask,
        longest: S,
        dt: S,
        flags: &mut Flags<S::Mask>,
    ) -> Taken<S> {
        let (mut acc, mut mag) = (given(reading.acc, &mut self.acc_seen), given(reading.mag, &mut self.mag_seen));
        if self.repeated == Repeated::Missing {
            self.leave_out_repeated(reading, started, [&mut acc, &mut mag], dt, flags);
        }
        flags.acc_missing = self.acc_seen & !acc.valid;
        flags.mag_missing = self.mag_seen & !mag.valid;
        let (gyr, held) = self.angular_rate(reading, started, dt);
        flags.gyr_held = held;
        let usable = can_turn(reading.gyr_norm2, S::of(0.5) * dt);
        self.rate = if usable.all() { reading.gyr } else { Vec3::select(usable, reading.gyr, self.rate) };
        // A sensor that was never given has no intervals.
        let mut prompt = true;
        if self.acc_seen.any() {
            prompt = self.acc_interval.is_prompt();
            acc.interval = self.acc_interval.step(acc.valid, dt, longest);
        }
        if self.mag_seen.any() {
            prompt &= self.mag_interval.is_prompt();
            mag.interval = self.mag_interval.step(mag.valid, dt, longest);
        }
        // Where both sensors have always been as fast as the gyroscope there is nothing to compare.
        let [acc_whole, mag_whole] =
            [(reading.acc, acc.valid), (reading.mag, mag.valid)].map(|(given, valid)| given.is_none() || valid.all());
        Taken { gyr, acc, mag, prompt: prompt && acc_whole && mag_whole }
    }

    /// The angular rate to integrate: the measured one, or the last one where it is missing or too large to turn by; and where it
    /// is not the measured one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn angular_rate(&self, reading: &Reading<S>, started: S::Mask, dt: S) -> (Vec3<S>, S::Mask) {
        let half_dt = S::of(0.5) * dt;
        let valid = can_turn(reading.gyr_norm2, half_dt);
        let linear = self.gyr_hold == GyrHold::Linear;
        if valid.all() && !linear {
            return (reading.gyr, !valid);
        }
        let mut rate = Vec3::select(valid, reading.gyr, self.rate);
        if linear {
            rate = Vec3::select(started, (self.rate + rate) * S::of(0.5), rate);
        }
        // What is too large for this step is left out of it, and kept for the next one.
        let turned = can_turn(rate.norm2(), half_dt);
        (Vec3::select(turned, rate, Vec3::zero()), !(valid & turned))
    }

    /// Takes rows for missing that repeat the last one of their sensor, while the gyroscope's do not.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn leave_out_repeated(
        &mut self,
        reading: &Reading<S>,
        started: S::Mask,
        [acc, mag]: [&mut Measured<S>; 2],
        dt: S,
        flags: &mut Flags<S::Mask>,
    ) {
        let moves = started & !same(reading.gyr, self.rate);
        let repeats = self.last_acc.repeats(acc, dt) & moves;
        acc.valid = acc.valid & !repeats;
        flags.repeated = repeats;
        let repeats = self.last_mag.repeats(mag, dt) & moves;
        mag.valid = mag.valid & !repeats;
        flags.repeated = flags.repeated | repeats;
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.rate.each(visit);
        self.acc_interval.each(visit);
        self.mag_interval.each(visit);
        if self.repeated == Repeated::Missing {
            self.last_acc.each(visit);
            self.last_mag.each(visit);
        }
        for flag in [&mut self.acc_seen, &mut self.mag_seen] {
            visit_flag::<S>(flag, visit);
        }
    }
}

/// Calls `visit` for a flag as a number, and takes it back.
pub fn visit_flag<S: Scalar>(flag: &mut S::Mask, visit: &mut impl FnMut(&mut S)) {
    let mut number = S::select(*flag, S::one(), S::zero());
    visit(&mut number);
    *flag = S::of(0.5).lt(number);
}

/// Where an angular rate of this squared norm is a number, and half its turn an angle that has a sine.
#[cfg_attr(not(debug_assertions), inline(always))]
fn can_turn<S: Scalar>(norm2: S, half_dt: S) -> S::Mask {
    let range = S::of(S::Real::ANGLE_RANGE);
    norm2.le(S::splat(S::Real::MAX)) & (norm2 * half_dt * half_dt).le(range * range)
}

/// The measurement of a sensor that may not be there, and whether it was ever given.
#[cfg_attr(not(debug_assertions), inline(always))]
fn given<S: Scalar>(measured: Option<Measured<S>>, seen: &mut S::Mask) -> Measured<S> {
    let (zero, no, yes) = (Vec3::zero(), S::Mask::splat(false), S::Mask::splat(true));
    if measured.is_some() {
        *seen = yes;
    }
    measured.unwrap_or(Measured { value: zero, unit: zero, valid: no, interval: S::zero() })
}
