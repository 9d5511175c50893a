//! The complementary filter on roll and pitch.

use super::Integration;
use super::adaptive::trust;
use super::trigonometric::{accelerometer_angles, integrated};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, Preset, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Euler, Quat, rotate_by};
use crate::status::Flags;
use crate::trig::{one_minus_exp, wrap};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Complementary",
    doc: "Roll and pitch are integrated from the gyroscope and drawn towards those of the specific force with a time \
          constant: high-pass and low-pass of the same corner. The heading is integrated.",
    source: "Parikh et al. 2021, section II.A; their α = 0.997 at 200 Hz is τ = 1.6617 s",
    magnetometer: Magnetometer::InitialHeading,
    feedback: true,
    gyr_bias: false,
    equivariance: Equivariance::No("Euler angles depend on the choice of the sensor's axes"),
    params: PARAMS,
    presets: &[Preset { name: "parikh2021", values: &[("tau", 0.997 / 0.003 / 200.0)] }],
    outputs: &[],
};

params! {
    /// Time constant τ of the correction: the gyroscope's weight in a step is α = τ/(τ + dt).
    real tau: "s" = 1.6616666666666666 in [1e-9, 1e6];
    /// Deviation of the specific force's norm from gravity above which the accelerometer's weight falls, linearly to none at
    /// twice as much (Valenti et al. 2015; the adaptive gain that Parikh et al. 2021 propose); 0: never.
    real acc_threshold: "m/s²" = 0.0 in [0.0, 1e6];
    choice integration: Integration;
}

/// The complementary filter on roll and pitch.
#[derive(Clone, Debug)]
pub struct Complementary<S: Scalar> {
    params: Params<S>,
    q: Quat<S>,
    acc_rejected: S::Mask,
}

impl<S: Scalar> Filter<S> for Complementary<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(params: &Params<S>) -> Self {
        Complementary { params: params.clone(), q: Quat::identity(), acc_rejected: S::Mask::splat(false) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let predicted = match self.params.integration {
            Integration::Exponential => Euler::from_quat(rotate_by(self.q, sample.gyr, dt)),
            Integration::FirstOrder => integrated(Euler::from_quat(self.q), sample.gyr, dt),
        };
        // θ = α (θ + ω dt) + (1 − α) θ_acc, with the difference of the angles wrapped
        let share = trust(sample, self.params.acc_threshold);
        self.acc_rejected = share.le(S::zero());
        let mut weight = dt / (self.params.tau + dt); // 1 − α
        let late = sample.acc.valid & dt.lt(sample.acc.interval);
        if late.any() {
            // The decay over all the steps for which the measurement stands.
            weight = S::select(late, one_minus_exp(sample.acc.interval / self.params.tau), weight);
        }
        let weight = weight * share;
        let (measured, _) = accelerometer_angles(sample.acc.unit, predicted);
        let corrected = Euler {
            roll: predicted.roll + weight * wrap(measured.roll - predicted.roll),
            pitch: predicted.pitch + weight * wrap(measured.pitch - predicted.pitch),
            yaw: predicted.yaw,
        };
        self.q = Euler::select(sample.acc.valid, corrected, predicted).to_quat();
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn flag(&self, flags: &mut Flags<S::Mask>) {
        flags.acc_rejected = self.acc_rejected;
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
    }
}
