//! Inclination from the accelerometer, heading from the magnetometer.

use super::tilt::tilted;
use crate::estimator::headed_by;
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::Quat;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Ecompass",
    doc: "Inclination from the specific force and heading from the horizontal magnetic field of this sample alone. \
          Without a magnetometer the last heading is kept; the gyroscope is used only where the accelerometer has no \
          sample.",
    source: "the two directions of Wahba's problem solved in turn, the vertical exactly (TRIAD, Black 1964)",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: false,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[],
};

params! {}

/// Inclination from the accelerometer, heading from the magnetometer.
#[derive(Clone, Debug)]
pub struct Ecompass<S> {
    q: Quat<S>,
}

impl<S: Scalar> Filter<S> for Ecompass<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(_params: &Params<S>) -> Self {
        Ecompass { q: Quat::identity() }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.q = Quat::select(lanes, q, self.q);
    }
    fn is_realigned(&self) -> bool {
        false
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        self.q = tilted(self.q, sample, dt);
        if sample.mag.valid.any() {
            let (q, known) = headed_by(self.q, sample.mag.unit);
            self.q = Quat::select(sample.mag.valid & known, q, self.q);
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
    }
}
