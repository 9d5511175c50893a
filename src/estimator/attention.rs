//! What is done before a step where something was lost, is being found again, or may be lost without having been told.
//!
//! All of that is rare. Code that is rare costs time even where it does not run: what a call may change cannot live in registers
//! around it. So it is apart from what is done for every sample, and a loop over samples can leave for it.

use super::Estimator;
use super::intake::Taken;
use super::reading::{Measured, Reading};
use crate::filter::{Filter, Magnetometer, Sample};
use crate::filters::delay::caught_up;
use crate::filters::kalman::UNKNOWN_ANGLE;
use crate::scalar::{Mask, Scalar};
use crate::so3::rotate_by;
use crate::status::Flags;

/// The cosine of half the angle (20°) from which on a filter with a covariance has not found the attitude again by itself.
const NEAR_BY_ITSELF: f64 = 0.984807753012208;
/// The same (8.8°) from which on another filter has not: twice the deviation of the mean in motion.
const NEAR: f64 = 0.997075181;

/// What the step is to know of it.
#[derive(Clone, Copy, Debug)]
pub struct Attended<S: Scalar> {
    /// Where the step was much longer than usual.
    pub gap: S::Mask,
    /// Where some of its rotation is lost.
    pub lost: S::Mask,
    /// Where the attitude has not been found again since a loss.
    pub recovering: S::Mask,
    /// The longest usual step before this one.
    pub longest: S,
}

impl<S: Scalar, F: Filter<S>> Estimator<S, F> {
    /// Whether [`Estimator::attend`] is to be called before the step to this reading.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn needs_attention(&self, reading: &Reading<S>, dt: S) -> bool {
        if self.attended.is_some() {
            return false;
        }
        let dt = self.usable_step(dt);
        let (gyr, held) = self.intake.angular_rate(reading, self.started, dt);
        let mut rare = held | self.losses.is_gap(dt) | !self.losses.is_within_range(gyr);
        if F::WATCHED
            && let Some(acc) = &reading.acc
        {
            rare = rare | (acc.valid & self.monitor.is_due(dt) & self.inclined);
        }
        rare.any() || self.recovers || !self.losses.is_idle()
    }

    /// [`Estimator::attend`] where it is not inlined: for scalars, whose instructions are the same everywhere.
    #[cold]
    #[inline(never)]
    pub fn attend_apart(&mut self, reading: &Reading<S>, dt: S) {
        self.attend(reading, dt);
    }

    /// What comes before the step to a reading that needs attention.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn attend(&mut self, reading: &Reading<S>, dt: S) {
        let dt = self.usable_step(dt);
        let mut flags = Flags::none();
        // The step itself takes it once more.
        let longest = self.losses.longest();
        let Taken { gyr, acc, mag, .. } = self.intake.clone().take(reading, self.started, longest, dt, &mut flags);
        self.turn_frame(&acc, &mag);
        let known = !flags.gyr_held & self.losses.is_within_range(gyr);
        let loss = self.losses.lose(known, reading.gyr_norm2, dt);
        let counts = loss.counts();
        if loss.lost.any() {
            self.filter.lose_rotation(loss.lost, loss.added);
            if self.filter.is_realigned() {
                self.recovery = self.recovery.lose(counts & self.inclined, loss.total);
                self.recovers = self.recovery.active().any();
            }
        }
        let [use_acc, use_mag] = self.used(&acc);
        let sample = Sample {
            gyr,
            acc: Measured { valid: acc.valid & use_acc, ..acc },
            mag: Measured { valid: mag.valid & use_mag, ..mag },
            lost: loss.lost,
            recovering: self.recovery.active(),
            prompt: false,
            usual: longest.max(dt),
        };
        if F::WATCHED {
            self.watch(&sample, dt);
        }
        let recovering = self.recovery.active();
        if self.recovers {
            // What hides little turns by the rate that is held.
            self.recover(!counts, &sample, dt);
        }
        self.attended = Some(Attended { gap: loss.gap, lost: loss.lost, recovering, longest });
    }

    /// Aligns the attitude where there have been enough samples since the loss, and takes this one where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn recover(&mut self, lanes: S::Mask, sample: &Sample<S>, dt: S) {
        let [ready, over] = self.recovery.ready();
        if (ready | over).any() {
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
            self.recovery.end(ready | over);
        }
        let rate = sample.gyr - self.filter.gyr_bias();
        self.recovery = self.recovery.step(lanes, *sample, rate, dt);
        self.recovers = self.recovery.active().any();
    }

    /// Looks whether the attitude is lost without having been told.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn watch(&mut self, sample: &Sample<S>, dt: S) {
        let due = self.monitor.is_due(dt) & sample.acc.valid & self.inclined;
        self.monitor.wait(dt);
        if !due.any() {
            return;
        }
        let recovering = self.recovery.active();
        let bias = self.filter.gyr_bias();
        let rate = sample.gyr - bias;
        let q = rotate_by(self.filter.attitude(), rate, dt);
        let mut sample = *sample;
        // A field of before is off by as much as the sensor has turned since.
        sample.mag.value = caught_up(sample.mag.value, rate, self.filter.known_mag_delay());
        if F::SPEC.magnetometer != Magnetometer::Feedback {
            sample.mag.valid = S::Mask::splat(false);
        }
        let lost = self.monitor.look(due & !recovering, &sample, q, self.filter.claimed(), bias);
        let restarts = lost | (due & recovering);
        if restarts.any() {
            self.monitor = self.monitor.restart(restarts);
        }
        if lost.any() {
            self.filter.reopen(lost, self.monitor.bias());
            self.recovery = self.recovery.lose(lost, S::of(UNKNOWN_ANGLE));
            self.recovers = true;
        }
    }
}
