//! The rules that hold for every filter: start, missing data, frames, sign and snapshots.

use crate::filter::{Filter, Flags, Sample};
use crate::reading::{Measured, Reading};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Frame, Quat, Vec3};
use crate::trig::sin_cos;

/// The longest step in s that a filter is given; a longer gap counts as this long, so that no product of a gain and
/// a gap is beyond the range of `f32`.
pub const LONGEST_STEP: f64 = 1.0e6;

/// The sine of the angle from the vertical below which a magnetic field gives no heading.
const VERTICAL_FIELD: f64 = 1e-6;

/// How the angular rate runs between two samples of the gyroscope.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GyrHold {
    /// The rate of a sample held over the whole step that ends with it.
    #[default]
    ZeroOrder,
    /// The mean of the rates at both ends of the step.
    Linear,
}

impl GyrHold {
    /// Every rule with its name.
    pub const ALL: [(&'static str, GyrHold); 2] = [("zero-order", GyrHold::ZeroOrder), ("linear", GyrHold::Linear)];

    /// The rule of a name, or `None`.
    pub fn from_name(name: &str) -> Option<GyrHold> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, hold)| hold)
    }
}

/// What the user chooses beside a filter's own parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// The earth frame of the output.
    pub frame: Frame,
    /// Magnetic declination in rad, positive east.
    pub declination: f64,
    /// How the angular rate runs between samples.
    pub gyr_hold: GyrHold,
}

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

/// The rotation about the vertical that is given by its half angle.
fn turn_about_up<S: Scalar>(half_angle: S) -> Quat<S> {
    let (sin, cos) = sin_cos(half_angle);
    Quat::new(cos, S::zero(), S::zero(), sin)
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
}

impl<S: Scalar, F: Filter<S>> Estimator<S, F> {
    /// A filter that takes its attitude from the first samples.
    pub fn new(params: &F::Params, settings: Settings) -> Self {
        let no = S::Mask::splat(false);
        let frame = settings.frame.from_enu();
        let new = Estimator {
            filter: F::new(params),
            frame: settings.frame,
            gyr_hold: settings.gyr_hold,
            turns_output: settings.frame != Frame::Enu,
            rotations: [frame, frame],
            declined: false,
            half_turn_north: S::zero(),
            rate: Vec3::zero(),
            quat: frame,
            started: no,
            inclined: no,
            headed: no,
            magnetic: no,
            acc_seen: no,
            mag_seen: no,
        };
        new.declined_by(S::of(settings.declination))
    }

    /// The same with a declination in rad, positive east: of a new estimator. That of the settings is in `f64`, which a
    /// microcontroller may have to emulate.
    #[must_use]
    pub fn declined_by(mut self, declination: S) -> Self {
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

        let gyr = self.angular_rate(reading, dt, &mut flags);
        let acc = given(reading.acc, &mut self.acc_seen, &mut flags.acc_missing);
        let mag = given(reading.mag, &mut self.mag_seen, &mut flags.mag_missing);

        self.turn_to_magnetic_north(mag.valid & self.inclined & self.headed);
        // What aligns is no measurement for the filter, unless it starts by itself.
        let (use_acc, use_mag) =
            if F::STARTS_ITSELF { (acc.valid, self.inclined | acc.valid) } else { (self.inclined, self.headed) };
        let sample = Sample {
            gyr,
            acc: Measured { valid: acc.valid & use_acc, ..acc },
            mag: Measured { valid: mag.valid & use_mag, ..mag },
        };
        self.filter.step(&sample, dt);
        self.filter.flag(&mut flags);
        self.align(&acc, &mag);
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

/// The measurement of a sensor that may not be there, whether it was ever given, and whether it is missing now.
#[cfg_attr(not(debug_assertions), inline(always))]
fn given<S: Scalar>(measured: Option<Measured<S>>, seen: &mut S::Mask, missing: &mut S::Mask) -> Measured<S> {
    let (zero, no, yes) = (Vec3::zero(), S::Mask::splat(false), S::Mask::splat(true));
    if measured.is_some() {
        *seen = yes;
    }
    let measured = measured.unwrap_or(Measured { value: zero, unit: zero, valid: no });
    *missing = *seen & !measured.valid;
    measured
}

/// The attitude turned by the shortest way so that the unit specific force points up; the heading is kept.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn inclined_by<S: Scalar>(q: Quat<S>, acc: Vec3<S>) -> Quat<S> {
    (Quat::shortest_to_up(q.rotate(acc)) * q).renormalized()
}

/// The attitude turned about the vertical so that the horizontal part of the unit field points north, and where that
/// is possible: the field must not be vertical.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn headed_by<S: Scalar>(q: Quat<S>, mag: Vec3<S>) -> (Quat<S>, S::Mask) {
    let h = q.rotate(mag);
    let horizontal = (h.x * h.x + h.y * h.y).sqrt();
    let known = S::of(VERTICAL_FIELD).le(horizontal);
    ((Quat::turn_to_north(h.x, h.y, horizontal) * q).renormalized(), known)
}
