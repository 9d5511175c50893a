//! Inclination from the accelerometer alone.

use crate::estimator::inclined_by;
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, rotate_by};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Tilt",
    doc: "The attitude turned by the shortest way so that the specific force of this sample points up. The gyroscope \
          is used only where the accelerometer has no sample, so the heading is carried along, not measured.",
    source: "the shortest rotation between two directions",
    magnetometer: Magnetometer::InitialHeading,
    feedback: true,
    gyr_bias: false,
    equivariance: Equivariance::Exact,
    params: PARAMS,
    presets: &[],
    outputs: &[],
};

params! {}

/// Inclination from the accelerometer alone.
#[derive(Clone, Debug)]
pub struct Tilt<S> {
    q: Quat<S>,
}

impl<S: Scalar> Filter<S> for Tilt<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(_params: &Params<S>) -> Self {
        Tilt { q: Quat::identity() }
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
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
    }
}

/// The attitude with the inclination of the accelerometer, or turned on by the gyroscope where that has no sample.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn tilted<S: Scalar>(q: Quat<S>, sample: &Sample<S>, dt: S) -> Quat<S> {
    let inclined = inclined_by(q, sample.acc.unit);
    if sample.acc.valid.all() {
        return inclined;
    }
    Quat::select(sample.acc.valid, inclined, rotate_by(q, sample.gyr, dt))
}
