//! The rules that hold for every filter: start, missing data, losses, frames, sign and snapshots.
//!
//! - [`settings`]: what the user chooses; [`reading`]: what the rows say before any state is known;
//! - [`intake`]: what is missing, held or repeated, with [`intervals`], [`repeats`]: the time that a measurement stands for, and
//!   rows that are none;
//! - [`alignment`]: the attitude that one sample shows;
//! - [`attention`]: what a step does before it where something was lost, with [`losses`], [`recovery`], [`monitor`]: rotations that
//!   nobody saw, how the attitude is found again, and whether it is lost without having been told.

pub mod alignment;
mod attention;
mod intake;
pub mod intervals;
pub mod losses;
mod monitor;
pub mod reading;
mod recovery;
mod repeats;
pub mod settings;

use crate::filter::{Filter, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Frame, Quat, Vec3};
use crate::status::Flags;

use alignment::turn_about_up;
pub use alignment::{headed_by, inclined_by};
use attention::Attended;
use intake::{Intake, Taken, visit_flag};
use losses::Losses;
use monitor::Monitor;
use reading::{Measured, Reading};
use recovery::Recovery;
pub use settings::{GyrHold, Repeated, Settings};

/// The longest step in s that a filter is given; a longer gap counts as this long, so that no product of a gain and
/// a gap is beyond the range of `f32`.
pub const LONGEST_STEP: f64 = 1.0e6;

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
    /// False where the output is in the filter's own frame.
    turns_output: bool,
    /// The rotations from the filter's frame to the chosen one: where its north is that of the chosen frame, and where it
    /// is the magnetic one. Made once: their sine and cosine have no place in a step.
    rotations: [Quat<S>; 2],
    /// True where these differ.
    declined: bool,
    /// Half the angle from magnetic to true north in rad, in the scalar: a step computes in nothing else.
    half_turn_north: S,
    intake: Intake<S>,
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
    losses: Losses<S>,
    recovery: Recovery<S>,
    /// True where a recovery goes on in any lane.
    recovers: bool,
    monitor: Monitor<S>,
    /// What was done for the step to come.
    attended: Option<Attended<S>>,
}

impl<S: Scalar, F: Filter<S>> Estimator<S, F> {
    /// A filter that takes its attitude from the first samples.
    pub fn new(params: &F::Params, settings: Settings) -> Self {
        Self::without_numbers(params, settings)
            .with_declination(S::of(settings.declination))
            .with_gyr_range(S::of(settings.gyr_range))
    }

    /// The same with the choices of the settings alone. Their numbers are in `f64`, which a microcontroller may have to emulate.
    pub fn without_numbers(params: &F::Params, settings: Settings) -> Self {
        let (no, yes) = (S::Mask::splat(false), S::Mask::splat(true));
        let frame: Quat<S> = settings.frame.from_enu();
        let mut filter = F::new(params);
        if settings.frame != Frame::Enu {
            // Level in the chosen frame, with the heading 0 there.
            filter.set_attitude(yes, frame.conj());
        }
        Estimator {
            filter,
            frame: settings.frame,
            intake: Intake::new(&settings),
            turns_output: settings.frame != Frame::Enu,
            rotations: [frame, frame],
            declined: false,
            half_turn_north: S::zero(),
            quat: Quat::identity(),
            started: no,
            inclined: no,
            headed: no,
            magnetic: no,
            losses: Losses::new(),
            recovery: Recovery::new(),
            recovers: false,
            monitor: Monitor::new(F::STARTS_IN_MOTION),
            attended: None,
        }
    }

    /// The same with a declination in rad, positive east, in the scalar: of a new estimator.
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
        self.losses = self.losses.with_gyr_range(gyr_range);
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
        if self.needs_attention(reading, dt) {
            self.attend_apart(reading, dt);
        }
        self.go_on_apart(reading, dt)
    }

    /// [`Estimator::go_on`] in a stack frame of its own, which is not there together with that of [`Estimator::attend_apart`].
    #[inline(never)]
    fn go_on_apart(&mut self, reading: &Reading<S>, dt: S) -> Output<S> {
        self.go_on(reading, dt)
    }

    /// Goes on to a reading that needs no attention, or has had it: [`Estimator::take`] in two parts, for loops that take what is
    /// rare out of what is done for every sample.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn go_on(&mut self, reading: &Reading<S>, dt: S) -> Output<S> {
        let mut flags = Flags::none();
        let dt = self.usable_step(dt);
        let attended = self.attended.take();
        let longest = attended.map_or(self.losses.longest(), |attended| attended.longest);
        let Taken { gyr, acc, mag, prompt } = self.intake.take(reading, self.started, longest, dt, &mut flags);
        self.turn_frame(&acc, &mag);
        // What aligns is no measurement for the filter, unless it starts by itself.
        let [use_acc, use_mag] = self.used(&acc);
        let mut sample = Sample {
            gyr,
            acc: Measured { valid: acc.valid & use_acc, ..acc },
            mag: Measured { valid: mag.valid & use_mag, ..mag },
            lost: S::Mask::splat(false),
            recovering: S::Mask::splat(false),
            prompt,
            usual: longest.max(dt),
        };
        if let Some(attended) = attended {
            (flags.gap, sample.lost, sample.recovering) = (attended.gap, attended.lost, attended.recovering);
        } else {
            self.losses.pass(reading.gyr_norm2, dt);
            if F::WATCHED {
                self.monitor.wait(dt);
            }
        }
        if !prompt {
            sample.prompt = !sample.late(dt).any();
        }
        self.filter.step(&sample, dt);
        self.filter.flag(&mut flags);
        self.align(&acc, &mag);
        if self.recovers {
            flags.recovering = flags.recovering | self.recovery.active();
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

    /// The step that a filter is given. Without a given attitude the first sample aligns, and nothing turns.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn usable_step(&self, dt: S) -> S {
        let dt = dt.max(S::zero()).min(S::of(LONGEST_STEP));
        let fresh = self.is_fresh();
        if !F::STARTS_ITSELF && fresh.any() { S::select(fresh, S::zero(), dt) } else { dt }
    }

    /// Where the filter is to use accelerometer and magnetometer, if they are valid.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn used(&self, acc: &Measured<S>) -> [S::Mask; 2] {
        if F::STARTS_ITSELF { [acc.valid, self.inclined | acc.valid] } else { [self.inclined, self.headed] }
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

    /// What the first measurements change of the frame that the attitude is in.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turn_frame(&mut self, acc: &Measured<S>, mag: &Measured<S>) {
        self.turn_to_magnetic_north(mag.valid & self.inclined & self.headed);
        if self.frame == Frame::Ned {
            self.turn_upside_down(acc);
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
        self.intake.each(visit);
        self.quat.each(visit);
        self.losses.each(visit);
        self.recovery.each(visit);
        self.recovers = self.recovery.active().any();
        if F::WATCHED {
            self.monitor.each(visit);
        }
        for flag in [&mut self.started, &mut self.inclined, &mut self.headed, &mut self.magnetic] {
            visit_flag::<S>(flag, visit);
        }
    }
}
