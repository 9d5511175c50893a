//! Integration of the angular rate alone.

use super::Integration;
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, Sample};
use crate::scalar::Scalar;
use crate::so3::Quat;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "GyroIntegration",
    doc: "The angular rate integrated from the initial alignment; accelerometer and magnetometer are used for that \
          alignment only.",
    source: "q⁺ = q ⊗ exp(½ω dt), the exact solution of q̇ = ½ q ⊗ ω for a rate that is constant over the step",
    magnetometer: Magnetometer::InitialHeading,
    feedback: false,
    gyr_bias: false,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[],
};

params! {
    choice integration: Integration;
}

/// Integration of the angular rate alone.
#[derive(Clone, Debug)]
pub struct GyroIntegration<S> {
    params: Params<S>,
    q: Quat<S>,
}

impl<S: Scalar> Filter<S> for GyroIntegration<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(params: &Params<S>) -> Self {
        GyroIntegration { params: params.clone(), q: Quat::identity() }
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
        self.q = self.params.integration.step(self.q, sample.gyr * (S::of(0.5) * dt));
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
    }
}
