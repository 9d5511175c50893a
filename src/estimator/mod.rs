//! The rules that hold for every filter: start, missing data, losses, frames, sign and snapshots.
//!
//! - [`settings`]: what the user chooses; [`reading`]: what the rows say before any state is known;
//! - [`alignment`]: the attitude that one sample shows;
//! - [`intervals`], [`repeats`]: the time that a measurement stands for, and rows that are none;
//! - [`losses`], [`recovery`]: rotations that nobody saw, and how the attitude is found again.

pub mod alignment;
pub mod intervals;
pub mod losses;
mod monitor;
pub mod reading;
mod recovery;
mod repeats;
pub mod settings;

use crate::filter::Magnetometer;
use crate::filter::{Filter, Sample};
use crate::filters::kalman::UNKNOWN_ANGLE;
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Frame, Quat, Vec3};
use crate::status::Flags;

use alignment::turn_about_up;
pub use alignment::{headed_by, inclined_by};
use intervals::Interval;
use losses::{Losses, within_range};
use monitor::Monitor;
use reading::{Measured, Reading};
use recovery::Recovery;
use repeats::{Last, same};
pub use settings::{GyrHold, Repeated, Settings};

/// The longest step in s that a filter is given; a longer gap counts as this long, so that no product of a gain and
/// a gap is beyond the range of `f32`.
pub const LONGEST_STEP: f64 = 1.0e6;

/// The cosine of half the angle (20°) from which on a filter with a covariance has not found the attitude again by itself.
const NEAR_BY_ITSELF: f64 = 0.984807753012208;
/// The same (8.8°) from which on another filter has not: twice the deviation of the mean in motion.
const NEAR: f64 = 0.997075181;

impl Settings {
    /// The rotation from east-north-up to the chosen frame; `from_magnetic` where north is the magnetic one there.
    pub fn output_rotation<S: Scalar>(&self, from_magnetic: bool) -> Quat<S> {
        let frame = self.frame.from_enu();
        if from_magnetic && self.declination != 0.0 { frame * self.declination_turn() } else { frame }
    }

    /// Rz(−D): from magnetic to true north in a frame whose z points up.
    fn declination_turn<S: Scalar>(&self) -> Quat<S> {
        turn_about_up(S::of(-0.5 * self.declination))
    }
}

/// The attitude and the status bits after one sample.
#[derive(Clone, Copy, Debug)]
pub struct Output<S: Scalar> {
    /// From the sensor frame to the chosen earth frame.
    pub quat: Quat<S>,
    /// What was missing, held or rejected.
    pub flags: Flags<S::Mask>,
}

/// A filter under the rules that hold for all of them.
#[derive(Clone, Debug)]
pub struct Estimator<S: Scalar, F> {
    filter: F,
    frame: Frame,
    gyr_hold: GyrHold,
    /// False where the output is in the filter's own frame.
    turns_output: bool,
    /// The rotations from the filter's frame to the chosen one: where its north is that of the chosen frame, and where it
    /// is the magnetic one. Made once: their sine and cosine have no place in a step.
    rotations: [Quat<S>; 2],
    /// True where these differ.
    declined: bool,
    /// Half the angle from magnetic to true north in rad, in the scalar: a step computes in nothing else.
    half_turn_north: S,
    /// The last angular rate that was measured.
    rate: Vec3<S>,
    /// The last output, whose sign the next one continues.
    quat: Quat<S>,
    /// Set where a sample has come.
    started: S::Mask,
    /// Set where the inclination is known.
    inclined: S::Mask,
    /// Set where the heading is known.
    headed: S::Mask,
    /// Set where the filter's north is the magnetic one.
    magnetic: S::Mask,
    /// Set where an accelerometer has been given.
    acc_seen: S::Mask,
    /// Set where a magnetometer has been given.
    mag_seen: S::Mask,
    /// The times that measurements stand for.
    acc_interval: Interval<S>,
    mag_interval: Interval<S>,
    /// What a repeated row is, and the last rows of the sensors where that matters.
    repeated: Repeated,
    last_acc: Last<S>,
    last_mag: Last<S>,
    /// The largest rate of the gyroscope's axes; zero where it is not known.
    gyr_range: S,
    losses: Losses<S>,
    recovery: Recovery<S>,
    monitor: Monitor<S>,
}

impl<S: Scalar, F: Filter<S>> Estimator<S, F> {
    /// A filter that takes its attitude from the first samples.
    pub fn new(params: &F::Params, settings: Settings) -> Self {
        let (no, yes) = (S::Mask::splat(false), S::Mask::splat(true));
        let frame: Quat<S> = settings.frame.from_enu();
        let mut filter = F::new(params);
        if settings.frame != Frame::Enu {
            // Level in the chosen frame, with the heading 0 there.
            filter.set_attitude(yes, frame.conj());
        }
        let new = Estimator {
            filter,
            frame: settings.frame,
            gyr_hold: settings.gyr_hold,
            turns_output: settings.frame != Frame::Enu,
            rotations: [frame, frame],
            declined: false,
            half_turn_north: S::zero(),
            rate: Vec3::zero(),
            quat: Quat::identity(),
            started: no,
            inclined: no,
            headed: no,
            magnetic: no,
            acc_seen: no,
            mag_seen: no,
            acc_interval: Interval::new(),
            mag_interval: Interval::new(),
            repeated: settings.repeated,
            last_acc: Last::new(),
            last_mag: Last::new(),
            gyr_range: S::of(settings.gyr_range),
            losses: Losses::new(),
            recovery: Recovery::new(),
            monitor: Monitor::new(),
        };
        new.with_declination(S::of(settings.declination))
    }

    /// The same with a declination in rad, positive east: of a new estimator. That of the settings is in `f64`, which a
    /// microcontroller may have to emulate.
    #[must_use]
    pub fn with_declination(mut self, declination: S) -> Self {
        self.declined = (declination.lt(S::zero()) | S::zero().lt(declination)).any();
        self.turns_output |= self.declined;
        let [frame, turned] = &mut self.rotations;
        *turned = *frame;
        self.half_turn_north = S::of(-0.5) * declination;
        if self.declined {
            *turned = *frame * turn_about_up(self.half_turn_north);
        }
        self
    }

    /// The same with the largest rate in rad/s that an axis of the gyroscope shows, in the scalar: of a new estimator.
    #[must_use]
    pub fn with_gyr_range(mut self, gyr_range: S) -> Self {
        self.gyr_range = gyr_range;
        self
    }

    /// Sets the attitude one step before the first sample (chosen frame); a quaternion that has no direction is
    /// taken for the identity.
    pub fn start_from(&mut self, q0: Quat<S>) {
        let yes = S::Mask::splat(true);
        let q0 = q0.unit_or(Quat::identity());
        self.filter.start_from(self.frame.from_enu::<S>().conj() * q0);
        self.quat = Quat::select(q0.w.lt(S::zero()), -q0, q0);
        (self.inclined, self.headed) = (yes, yes);
    }

    /// Goes on by `dt` seconds to a new sample. `None` is a sensor that is not there; a vector with a NaN, or whose
    /// squared norm is zero, subnormal or not finite, is a measurement that is missing.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(&mut self, gyr: Vec3<S>, acc: Option<Vec3<S>>, mag: Option<Vec3<S>>, dt: S) -> Output<S> {
        self.take(&Reading::new(gyr, acc, mag), dt)
    }

    /// [`Estimator::step`] with a reading that was computed before.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn take(&mut self, reading: &Reading<S>, dt: S) -> Output<S> {
        let mut flags = Flags::none();
        // Without a given attitude the first sample aligns, and nothing turns.
        let fresh = self.is_fresh();
        let mut dt = dt.max(S::zero()).min(S::of(LONGEST_STEP));
        if !F::STARTS_ITSELF && fresh.any() {
            dt = S::select(fresh, S::zero(), dt);
        }

        let (mut acc, mut mag) = (given(reading.acc, &mut self.acc_seen), given(reading.mag, &mut self.mag_seen));
        if self.repeated == Repeated::Missing {
            self.leave_out_repeated(reading, [&mut acc, &mut mag], dt, &mut flags);
        }
        flags.acc_missing = self.acc_seen & !acc.valid;
        flags.mag_missing = self.mag_seen & !mag.valid;
        let gyr = self.angular_rate(reading, dt, &mut flags);
        let longest = self.losses.longest();
        acc.interval = self.acc_interval.step(acc.valid, dt, longest);
        mag.interval = self.mag_interval.step(mag.valid, dt, longest);

        self.turn_to_magnetic_north(mag.valid & self.inclined & self.headed);
        if self.frame == Frame::Ned {
            self.turn_upside_down(&acc);
        }
        // What aligns is no measurement for the filter, unless it starts by itself.
        let (use_acc, use_mag) =
            if F::STARTS_ITSELF { (acc.valid, self.inclined | acc.valid) } else { (self.inclined, self.headed) };
        let known = !flags.gyr_held & within_range(gyr, self.gyr_range);
        let loss = self.losses.see(known, reading.gyr_norm2, dt);
        let mut lost = S::Mask::splat(false);
        if let Some(loss) = &loss {
            (flags.gap, lost) = (loss.gap, loss.lost);
            self.filter.lose_rotation(lost, loss.added);
            self.recovery.lose(lost & self.inclined, loss.total);
        }
        let recovering = self.recovery.active();
        let sample = Sample {
            gyr,
            acc: Measured { valid: acc.valid & use_acc, ..acc },
            mag: Measured { valid: mag.valid & use_mag, ..mag },
            lost,
            recovering,
        };
        self.filter.step(&sample, dt);
        self.filter.flag(&mut flags);
        self.align(&acc, &mag);
        if self.filter.is_realigned() && recovering.any() {
            flags.recovering = flags.recovering | recovering;
            self.recover(!lost, &sample, dt);
        }
        if F::WATCHED {
            let due = self.monitor.is_due(&sample, dt) & self.inclined;
            if due.any() {
                self.watch(due, &sample, &mut flags);
            }
        }
        flags.not_aligned = !self.inclined;

        let mut quat = self.filter.attitude();
        if self.turns_output {
            quat = self.output_rotation() * quat;
        }
        self.quat = self.continued(quat);
        self.started = S::Mask::splat(true);
        Output { quat: self.quat, flags }
    }

    /// The attitude with the sign that continues the last output's; at the start with w ≥ 0.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn continued(&self, quat: Quat<S>) -> Quat<S> {
        let mut reference = quat.dot(self.quat);
        if !self.started.all() {
            reference = S::select(self.started, reference, quat.w);
        }
        let turned = reference.lt(S::zero());
        if turned.any() { Quat::select(turned, -quat, quat) } else { quat }
    }

    /// The angular rate to integrate: the measured one, or the last one where it is missing or too large to turn by.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn angular_rate(&mut self, reading: &Reading<S>, dt: S, flags: &mut Flags<S::Mask>) -> Vec3<S> {
        let half_dt = S::of(0.5) * dt;
        let gyr = reading.gyr;
        let valid = can_turn(reading.gyr_norm2, half_dt);
        flags.gyr_held = !valid;
        let last = self.rate;
        let linear = self.gyr_hold == GyrHold::Linear;
        if valid.all() && !linear {
            self.rate = gyr;
            return gyr;
        }
        self.rate = Vec3::select(valid, gyr, last);
        let mut rate = self.rate;
        if linear {
            rate = Vec3::select(self.started, (last + rate) * S::of(0.5), rate);
        }
        // What is too large for this step is left out of it, and kept for the next one.
        let turned = can_turn(rate.norm2(), half_dt);
        flags.gyr_held = flags.gyr_held | !turned;
        Vec3::select(turned, rate, Vec3::zero())
    }

    /// Sets what is not known yet of inclination and heading; a filter that starts by itself has done so.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn align(&mut self, acc: &Measured<S>, mag: &Measured<S>) {
        let incline = acc.valid & !self.inclined;
        if incline.any() {
            if !F::STARTS_ITSELF {
                self.filter.set_attitude(incline, inclined_by(self.filter.attitude(), acc.unit));
            }
            self.inclined = self.inclined | incline;
        }
        let head = mag.valid & self.inclined & !self.headed;
        if head.any() {
            let (q, known) = headed_by(self.filter.attitude(), mag.unit);
            let head = head & known;
            if !F::STARTS_ITSELF {
                self.filter.set_attitude(head, q);
            }
            self.headed = self.headed | head;
            self.magnetic = self.magnetic | head;
        }
    }

    /// From the first magnetometer sample on, the filter's north is the magnetic one: a heading that was given from
    /// true north is turned by the declination, and the output back.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turn_to_magnetic_north(&mut self, lanes: S::Mask) {
        let turn = lanes & !self.magnetic;
        if turn.any() {
            let q = turn_about_up(self.half_turn_north).conj() * self.filter.attitude();
            self.filter.set_attitude(turn, q);
            self.magnetic = self.magnetic | turn;
        }
    }

    /// The first specific force of a sensor that points more up than down, in a frame whose z points down: its heading is 0 where
    /// it is rolled over from level by 180°.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turn_upside_down(&mut self, acc: &Measured<S>) {
        let first = acc.valid & !self.inclined;
        if first.any() {
            let q = self.filter.attitude();
            let over = first & q.rotate(acc.unit).z.lt(S::zero());
            if over.any() {
                // A roll by 180° in NED is one about north.
                self.filter.set_attitude(over, Quat::of([0.0, 0.0, 1.0, 0.0]) * q);
            }
        }
    }

    /// Goes on with a recovery by a sample where the mask is true, and aligns the attitude where there have been enough.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn recover(&mut self, lanes: S::Mask, sample: &Sample<S>, dt: S) {
        let ready = self.recovery.step(lanes, sample, sample.gyr - self.filter.gyr_bias(), dt);
        if ready.any() {
            let q = self.filter.attitude();
            let uses_field = F::SPEC.magnetometer == Magnetometer::Feedback;
            let (aligned, headed) = self.recovery.aligned(q, uses_field);
            // In motion an attitude that is as close to the mean as that may be wrong is left alone; and that of a filter that
            // knows how sure it is, unless it was too far away for a linear model, or what is seen at rest is better.
            let quiet = self.recovery.is_quiet();
            let near = S::of(if F::HAS_COVARIANCE { NEAR_BY_ITSELF } else { NEAR });
            let sure = if F::HAS_COVARIANCE { quiet & self.recovery.is_surer() } else { quiet };
            let set = ready & (sure | q.dot(aligned).abs().lt(near));
            if uses_field {
                // Without a field so far, the next sample gives the heading.
                self.headed = self.headed & (!set | headed | !self.magnetic);
            }
            self.filter.realign(set, aligned);
            if F::HAS_COVARIANCE {
                // As sure as that is, and no more.
                self.filter.lose_rotation(set, self.recovery.variance());
            }
            self.recovery.end(ready);
        }
    }

    /// Looks whether the attitude is lost without having been told.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn watch(&mut self, due: S::Mask, sample: &Sample<S>, flags: &mut Flags<S::Mask>) {
        let recovering = self.recovery.active();
        let (q, bias) = (self.filter.attitude(), self.filter.gyr_bias());
        let mut sample = *sample;
        if F::SPEC.magnetometer != Magnetometer::Feedback {
            sample.mag.valid = S::Mask::splat(false);
        }
        let lost = self.monitor.look(due & !recovering, &sample, q, self.filter.claimed(), bias);
        if (lost | recovering).any() {
            self.monitor.restart(lost | recovering);
        }
        if lost.any() {
            self.filter.reopen(lost, self.monitor.bias());
            self.recovery.lose(lost, S::of(UNKNOWN_ANGLE));
            flags.recovering = flags.recovering | lost;
        }
    }

    /// Takes rows for missing that repeat the last one of their sensor, while the gyroscope's do not.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn leave_out_repeated(
        &mut self,
        reading: &Reading<S>,
        [acc, mag]: [&mut Measured<S>; 2],
        dt: S,
        flags: &mut Flags<S::Mask>,
    ) {
        let moves = self.started & !same(reading.gyr, self.rate);
        let repeats = self.last_acc.repeats(acc, dt) & moves;
        acc.valid = acc.valid & !repeats;
        flags.repeated = repeats;
        let repeats = self.last_mag.repeats(mag, dt) & moves;
        mag.valid = mag.valid & !repeats;
        flags.repeated = flags.repeated | repeats;
    }

    /// The rotation from the filter's frame to the chosen one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn output_rotation(&self) -> Quat<S> {
        let [frame, turned] = self.rotations;
        if !self.declined {
            return frame;
        }
        Quat::select(self.magnetic, turned, frame)
    }

    /// Set where no sample has come and no attitude was given: the first sample aligns, and its step does not matter.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn is_fresh(&self) -> S::Mask {
        !(self.started | self.inclined)
    }

    /// The last attitude in the chosen frame; before the first sample the given one, or the frame's identity.
    pub fn quat(&self) -> Quat<S> {
        self.quat
    }

    /// The filter itself.
    pub fn filter(&self) -> &F {
        &self.filter
    }

    /// Calls `visit` for every variable that the next step depends on: what a snapshot holds.
    pub fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.filter.each_variable(visit);
        self.rate.each(visit);
        self.quat.each(visit);
        self.acc_interval.each(visit);
        self.mag_interval.each(visit);
        if self.repeated == Repeated::Missing {
            self.last_acc.each(visit);
            self.last_mag.each(visit);
        }
        self.losses.each(visit);
        self.recovery.each(visit);
        if F::WATCHED {
            self.monitor.each(visit);
        }
        for flag in [
            &mut self.started,
            &mut self.inclined,
            &mut self.headed,
            &mut self.magnetic,
            &mut self.acc_seen,
            &mut self.mag_seen,
        ] {
            let mut number = S::select(*flag, S::one(), S::zero());
            visit(&mut number);
            *flag = S::of(0.5).lt(number);
        }
    }
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
