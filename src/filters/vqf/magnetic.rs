//! Detection and rejection of magnetic disturbances (Laidig & Seel 2023): norm and dip of the field against
//! those of the undisturbed one, which is learnt.

use super::rest::LONGEST_EVIDENCE;
use crate::scalar::Scalar;
use crate::signal::{Coefficients, LowPass};
use crate::so3::Vec3;
use crate::trig::atan2;

/// What counts as a disturbance, and for how long.
#[derive(Clone, Copy, Debug)]
pub struct Limits<S> {
    /// Largest deviation of the norm, relative to that of the reference.
    pub norm: S,
    /// Largest deviation of the dip in rad.
    pub dip: S,
    /// The time in s after which a new field is taken over.
    pub new_time: S,
    /// The same where none is known.
    pub new_first_time: S,
    /// The angular rate in rad/s from which on the time counts.
    pub new_min_gyr: S,
    /// The time in s after which a known field is believed again.
    pub min_undisturbed_time: S,
    /// The time in s for which a disturbed field is left out.
    pub max_rejection_time: S,
    /// How much less a disturbed field counts after that, and how fast that time is won back.
    pub rejection_factor: S,
}

/// Norm and dip (rad) of a field.
#[derive(Clone, Copy, Debug)]
pub struct Shape<S> {
    /// The norm, in the magnetometer's unit.
    pub norm: S,
    /// The angle below the horizon.
    pub dip: S,
}

/// The earth's field as it has been seen.
#[derive(Clone, Debug)]
pub struct Magnetic<S> {
    low_pass: LowPass<S, 2>,
    reference: Shape<S>,
    candidate: Shape<S>,
    /// How long the field has been like the reference, in s; it stops counting where that is long enough.
    undisturbed: S,
    /// How long the field has been left out, in s.
    rejected: S,
    /// How long the field has been like the candidate while the sensor turned, in s.
    turned: S,
    /// One where the field is disturbed or no reference is known, else zero.
    disturbed: S,
    /// One where a reference is known and the last sample was left out, or counted less, else zero.
    leaves_out: S,
    lessens: S,
}

impl<S: Scalar> Magnetic<S> {
    /// Before the first sample: no field is known.
    pub fn new(limits: &Limits<S>) -> Self {
        let zero = S::zero();
        Magnetic {
            low_pass: LowPass::default(),
            reference: Shape { norm: zero, dip: zero },
            candidate: Shape { norm: -S::one(), dip: zero },
            undisturbed: zero,
            rejected: limits.max_rejection_time,
            turned: zero,
            disturbed: S::one(),
            leaves_out: zero,
            lessens: zero,
        }
    }

    /// The field that counts as undisturbed; zeros where none is known.
    pub fn reference(&self) -> Shape<S> {
        self.reference
    }
    /// One where the field is disturbed or no reference is known, else zero.
    pub fn disturbed(&self) -> S {
        self.disturbed
    }
    /// Where the last sample was left out although a reference is known.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn rejects(&self) -> S::Mask {
        S::zero().lt(self.leaves_out)
    }
    /// Where the last sample counted less, the field having been left out for long.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn recovers(&self) -> S::Mask {
        S::zero().lt(self.lessens)
    }

    /// Takes a field (earth frame) where the mask is true, `interval` after the one before, while the sensor turns at `rate`
    /// (low-pass filtered, squared); gives what the heading's correction is to weigh instead of `weight`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn step(
        &mut self,
        lanes: S::Mask,
        field: Vec3<S>,
        (interval, rate2): (S, S),
        (coefficients, learning): (&Coefficients<S>, S),
        limits: &Limits<S>,
        weight: S,
    ) -> S {
        let (zero, one) = (S::zero(), S::one());
        let horizontal2 = field.x * field.x + field.y * field.y;
        let norm = (horizontal2 + field.z * field.z).sqrt();
        let dip = atan2(-field.z, horizontal2.sqrt());
        let [norm, dip] = self.low_pass.step(lanes, [norm, dip], coefficients);
        let measured = Shape { norm, dip };
        let evidence = interval.min(S::of(LONGEST_EVIDENCE));
        let was_disturbed = S::of(0.5).lt(self.disturbed);

        // Like the reference: believed after a while, and the reference follows.
        let known = self.reference.is_like(&measured, limits);
        let undisturbed = S::select(known, (self.undisturbed + evidence).min(limits.min_undisturbed_time), zero);
        let believed = known & limits.min_undisturbed_time.le(undisturbed);
        let disturbed = !believed & (was_disturbed | !known);
        let reference = Shape::select(believed, self.reference.moved(&measured, learning), self.reference);

        // Like a candidate for a new reference: taken over after a longer while with movement.
        let same = self.candidate.is_like(&measured, limits);
        let turning = (limits.new_min_gyr * limits.new_min_gyr).le(rate2);
        let longest = limits.new_time.max(limits.new_first_time);
        let turned = S::select(turning, (self.turned + evidence).min(longest), self.turned);
        let turned = S::select(same, turned, zero);
        let candidate = Shape::select(same, self.candidate.moved(&measured, learning), measured);
        let first = reference.norm.le(zero) & limits.new_first_time.le(turned);
        let replaced = same & disturbed & (first | limits.new_time.le(turned));
        let reference = Shape::select(replaced, candidate, reference);
        let undisturbed = S::select(replaced, limits.min_undisturbed_time, undisturbed);
        let disturbed = disturbed & !replaced;

        // Left out while it is disturbed, but not for ever.
        let rejecting = disturbed & self.rejected.le(limits.max_rejection_time);
        let won_back = (self.rejected - limits.rejection_factor * interval).max(zero);
        let longer = S::select(rejecting, self.rejected + interval, self.rejected);
        let rejected = S::select(disturbed, longer, won_back);
        let lessened = S::select(rejecting, zero, weight / limits.rejection_factor);
        let weight = S::select(disturbed, lessened, weight);

        let is_known = lanes & zero.lt(reference.norm);
        self.leaves_out = S::select(is_known & rejecting, one, zero);
        self.lessens = S::select(is_known & disturbed & !rejecting, one, zero);
        self.disturbed = S::select(lanes, S::select(disturbed, one, zero), self.disturbed);
        self.undisturbed = S::select(lanes, undisturbed, self.undisturbed);
        self.turned = S::select(lanes, turned, self.turned);
        self.rejected = S::select(lanes, rejected, self.rejected);
        self.reference = Shape::select(lanes, reference, self.reference);
        self.candidate = Shape::select(lanes, candidate, self.candidate);
        weight
    }

    /// No sample has come: none is left out.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn nothing_came(&mut self) {
        (self.leaves_out, self.lessens) = (S::zero(), S::zero());
    }

    /// Calls `visit` for each variable that the next step depends on.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.low_pass.each(visit);
        for shape in [&mut self.reference, &mut self.candidate] {
            visit(&mut shape.norm);
            visit(&mut shape.dip);
        }
        for variable in [&mut self.undisturbed, &mut self.rejected, &mut self.turned, &mut self.disturbed] {
            visit(variable);
        }
    }
}

impl<S: Scalar> Shape<S> {
    /// Where another field is within the limits about this one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn is_like(&self, other: &Shape<S>, limits: &Limits<S>) -> S::Mask {
        (other.norm - self.norm).abs().lt(limits.norm * self.norm) & (other.dip - self.dip).abs().lt(limits.dip)
    }
    /// Moved towards another field.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn moved(&self, to: &Shape<S>, weight: S) -> Self {
        Shape { norm: self.norm + weight * (to.norm - self.norm), dip: self.dip + weight * (to.dip - self.dip) }
    }
    /// `yes` where the mask is true, else `no`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Shape { norm: S::select(mask, yes.norm, no.norm), dip: S::select(mask, yes.dip, no.dip) }
    }
}
