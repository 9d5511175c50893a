//! Attitudes that agree with what one sample of accelerometer and magnetometer shows.

use crate::scalar::Scalar;
use crate::so3::{Quat, Vec3};
use crate::trig::sin_cos;

/// The sine of the angle from the vertical below which a magnetic field gives no heading.
const VERTICAL_FIELD: f64 = 1e-6;

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

/// The rotation about the vertical that is given by its half angle.
pub fn turn_about_up<S: Scalar>(half_angle: S) -> Quat<S> {
    let (sin, cos) = sin_cos(half_angle);
    Quat::new(cos, S::zero(), S::zero(), sin)
}
