//! Roll, pitch and yaw of the intrinsic Z-Y'-X'' sequence.

use super::{Quat, Vec3};
use crate::scalar::{Real, Scalar};
use crate::trig::{atan2, sin_cos, wrap};

/// Euler angles in rad: the rotation is first by yaw about z, then by pitch about the new y, then by roll about the
/// newest x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Euler<S> {
    /// About the sensor's x axis, in [−π, π].
    pub roll: S,
    /// In [−π/2, π/2] where it comes from a quaternion.
    pub pitch: S,
    /// About the vertical, in [−π, π].
    pub yaw: S,
}

impl<S: Scalar> Euler<S> {
    /// The angles of a unit quaternion, accurate everywhere: they give the quaternion back to rounding, also where
    /// pitch is ±π/2 and only yaw ∓ roll is defined (there roll is zero).
    ///
    /// By the half sum and half difference of the outer angles (Bernardes & Viollet, PLoS ONE 17(11), 2022).
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn from_quat(q: Quat<S>) -> Self {
        let (a, b) = (q.w - q.y, q.x + q.z);
        let (c, d) = (q.w + q.y, q.z - q.x);
        let (plus2, minus2) = (a * a + b * b, c * c + d * d);
        // cos pitch = √(plus2·minus2), sin pitch = (minus2 − plus2)/2: no square of a small difference.
        let pitch = atan2(S::of(0.5) * (minus2 - plus2), (plus2 * minus2).sqrt());
        let half_sum = atan2(b, a);
        let half_difference = atan2(d, c);
        // At a pole one of the two is the angle of rounding noise: there roll is zero.
        let noise = S::of(4.0) * S::splat(S::Real::EPSILON);
        let up_pole = plus2.le(noise * noise);
        let down_pole = minus2.le(noise * noise);
        let sum = S::select(up_pole, half_difference, half_sum);
        let difference = S::select(down_pole, half_sum, half_difference);
        Euler { roll: wrap(sum - difference), pitch, yaw: wrap(sum + difference) }
    }

    /// `yes` where the mask is true, else `no`.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn select(mask: S::Mask, yes: Self, no: Self) -> Self {
        Euler {
            roll: S::select(mask, yes.roll, no.roll),
            pitch: S::select(mask, yes.pitch, no.pitch),
            yaw: S::select(mask, yes.yaw, no.yaw),
        }
    }

    /// Calls `visit` for each angle.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        visit(&mut self.roll);
        visit(&mut self.pitch);
        visit(&mut self.yaw);
    }

    /// The unit quaternion of the angles.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn to_quat(self) -> Quat<S> {
        let half = S::of(0.5);
        let (sr, cr) = sin_cos(self.roll * half);
        let (sp, cp) = sin_cos(self.pitch * half);
        let (sy, cy) = sin_cos(self.yaw * half);
        Quat::new(
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        )
        .renormalized()
    }
}

/// The rates of the Euler angles at the angular rate (p, q, r) of the sensor, rad/s.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn euler_rates<S: Scalar>(e: Euler<S>, rate: Vec3<S>) -> Euler<S> {
    let (sr, cr) = sin_cos(e.roll);
    let (sp, cp) = sin_cos(e.pitch);
    let floor = S::of(S::Real::COS_PITCH_FLOOR);
    let floored = S::select(cp.lt(S::zero()), cp.min(-floor), cp.max(floor));
    let turning = (rate.y * sr + rate.z * cr) / floored;
    Euler { roll: rate.x + turning * sp, pitch: rate.y * cr - rate.z * sr, yaw: turning }
}
