//! Strapdown integration and inclination correction (Laidig & Seel 2023).
//!
//! Three frames: that of the sensor, the *almost inertial* one in which the gyroscope alone holds the sensor's attitude and
//! which only its bias turns, and the earth frame with z up.

use super::super::kalman::saturated;
use crate::scalar::{Mask, Scalar};
use crate::signal::{Coefficients, LowPass};
use crate::so3::{Quat, Vec3, rotate_by};

/// Standard gravity in m/s²: of a given attitude, the specific force that goes with it.
const GRAVITY: f64 = 9.80665;
/// The largest specific force that is used, in m/s².
const LARGEST_FORCE: f64 = 1e6;
/// The smallest low-pass filtered specific force that has a direction, in m/s².
const SMALLEST_FORCE: f64 = 1e-12;

/// The attitude by gyroscope and accelerometer.
#[derive(Clone, Debug)]
pub struct Inclination<S> {
    /// From the sensor to the almost inertial frame.
    gyr: Quat<S>,
    /// From the almost inertial frame to the earth.
    acc: Quat<S>,
    /// The specific force in the almost inertial frame.
    force: LowPass<S, 3>,
}

impl<S: Scalar> Default for Inclination<S> {
    /// At the identity, before the first sample.
    fn default() -> Self {
        Inclination { gyr: Quat::identity(), acc: Quat::identity(), force: LowPass::default() }
    }
}

impl<S: Scalar> Inclination<S> {
    /// The attitude, whose heading drifts.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn attitude(&self) -> Quat<S> {
        self.acc * self.gyr
    }

    /// Starts from an attitude: the specific force has pointed along its vertical for a long time.
    pub fn start_from(&mut self, q: Quat<S>, coefficients: &Coefficients<S>) {
        (self.gyr, self.acc) = (Quat::identity(), q);
        let force = q.matrix().z * S::of(GRAVITY);
        self.force = LowPass::at([force.x, force.y, force.z], coefficients);
    }

    /// The same after a rotation that was lost, where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn restart(&mut self, lanes: S::Mask, q: Quat<S>, coefficients: &Coefficients<S>) {
        self.set_attitude(lanes, q);
        let force = seen_from(self.gyr, q.matrix().z * S::of(GRAVITY));
        self.force.set(lanes, [force.x, force.y, force.z], coefficients);
    }

    /// Sets the attitude and keeps what the almost inertial frame has seen.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.acc = Quat::select(lanes, (q * self.gyr.conj()).renormalized(), self.acc);
    }

    /// Turns by the angular rate over the step.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turn(&mut self, rate: Vec3<S>, dt: S) {
        self.gyr = rotate_by(self.gyr, rate, dt);
    }

    /// Corrects the inclination by the shortest rotation that takes the low-pass filtered specific force to up.
    /// Gives its direction in the earth frame before the correction, and where there is one.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn correct(&mut self, lanes: S::Mask, force: Vec3<S>, coefficients: &Coefficients<S>) -> (Vec3<S>, S::Mask) {
        let slow = self.force.step_vector(lanes, seen_from(self.gyr, force), coefficients);
        let (corrected, up, known) = corrected(self.acc, slow);
        let lanes = lanes & known;
        self.acc = if lanes.all() { corrected } else { Quat::select(lanes, corrected, self.acc) };
        (up, lanes)
    }

    /// Calls `visit` for each variable.
    pub fn each(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.gyr.each(visit);
        self.acc.each(visit);
        self.force.each(visit);
    }
}

/// A specific force in the almost inertial frame, into which `gyr` turns; one beyond all sensors is shortened.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn seen_from<S: Scalar>(gyr: Quat<S>, force: Vec3<S>) -> Vec3<S> {
    gyr.rotate(saturated(force, S::of(LARGEST_FORCE)))
}

/// The rotation `acc` from the almost inertial frame to the earth, corrected so that the low-pass filtered specific force
/// `slow` points up; the direction of that force in the earth frame before, and where it has one.
#[cfg_attr(not(debug_assertions), inline(always))]
pub fn corrected<S: Scalar>(acc: Quat<S>, slow: Vec3<S>) -> (Quat<S>, Vec3<S>, S::Mask) {
    let up = acc.rotate(slow);
    let norm2 = up.norm2();
    let norm = norm2.sqrt();
    let known = S::of(SMALLEST_FORCE * SMALLEST_FORCE).le(norm2);
    // Proportional to (|up| + up·z, up × z), whose squared norm is 2 |up| (|up| + up·z), without cancellation near −z.
    let mut w = norm + up.z;
    let lower = up.z.lt(S::zero());
    if lower.any() {
        w = S::select(lower, (up.x * up.x + up.y * up.y) / (norm - up.z), w);
    }
    let size2 = S::of(2.0) * norm * w;
    // The product is formed while the root is waited for.
    let turned = Quat::new(w, up.y, -up.x, S::zero()) * acc.renormalized();
    let mut corrected = turned.scale(S::one() / size2.sqrt());
    let upright = size2.is_normal_norm2();
    if !upright.all() {
        let half_turn = Quat::of([0.0, 1.0, 0.0, 0.0]) * acc.renormalized();
        corrected = Quat::select(upright, corrected, half_turn);
    }
    (corrected, up * (S::one() / norm), known)
}
