//! Roll and pitch by trigonometry, without a filter.

use core::f64::consts::PI;

use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, Sample};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Euler, Quat, Vec3, euler_rates};
use crate::trig::{atan2, wrap};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "Trigonometric",
    doc: "Roll and pitch without fusion: from the specific force of this sample (the papers' \"matrix\" method), or \
          from the Euler rates of the gyroscope. The heading of the start is held, or integrated with the rates.",
    source: "Çoçoli & Badia 2023, eqs 3-5, with signs for a specific force of +g at rest",
    magnetometer: Magnetometer::InitialHeading,
    feedback: true,
    gyr_bias: false,
    equivariance: Equivariance::No("Euler angles depend on the choice of the sensor's axes"),
    params: PARAMS,
    presets: &[],
    outputs: &[],
};

choice! {
    /// Where roll and pitch come from: the accelerometer (eqs 3-4), or the gyroscope by Euler rates (eq. 5), which
    /// the accelerometer then only starts.
    pub enum Source { Acc = "acc", Gyr = "gyr" }
}

params! {
    choice source: Source;
}

/// Roll and pitch by trigonometry.
#[derive(Clone, Debug)]
pub struct Trigonometric<S> {
    params: Params<S>,
    euler: Euler<S>,
}

impl<S: Scalar> Filter<S> for Trigonometric<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;

    fn new(params: &Params<S>) -> Self {
        Trigonometric { params: params.clone(), euler: Euler::from_quat(Quat::identity()) }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.euler.to_quat()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        self.euler = Euler::select(lanes, Euler::from_quat(q), self.euler);
    }
    fn is_realigned(&self) -> bool {
        self.params.source == Source::Gyr
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let measured = match self.params.source {
            Source::Acc => sample.acc.valid,
            Source::Gyr => S::Mask::splat(false),
        };
        let from_acc = accelerometer_angles(sample.acc.unit, self.euler).0;
        self.euler = if measured.all() {
            from_acc
        } else {
            Euler::select(measured, from_acc, integrated(self.euler, sample.gyr, dt))
        };
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.euler.each(visit);
    }
}

/// Roll and pitch of the unit specific force (eqs 3-4), with the yaw of `last`, and where roll is defined: where the
/// force is along the sensor's x axis it is not, and that of `last` is kept.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn accelerometer_angles<S: Scalar>(a: Vec3<S>, last: Euler<S>) -> (Euler<S>, S::Mask) {
    let across = (a.y * a.y + a.z * a.z).sqrt();
    let defined = S::of(S::Real::COS_PITCH_FLOOR).le(across);
    let angles = Euler {
        pitch: atan2(-a.x, across),                           // eq. 4, θ
        roll: S::select(defined, atan2(a.y, a.z), last.roll), // eq. 4, φ
        yaw: last.yaw,
    };
    (angles, defined)
}

/// The Euler angles after a first-order step of their rates (eq. 5, and the row of the yaw that it leaves out).
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn integrated<S: Scalar>(e: Euler<S>, rate: Vec3<S>, dt: S) -> Euler<S> {
    let rates = euler_rates(e, rate);
    Euler {
        roll: gone_on(e.roll, rates.roll * dt),
        pitch: gone_on(e.pitch, rates.pitch * dt),
        yaw: gone_on(e.yaw, rates.yaw * dt),
    }
}

/// An angle after a change, which counts for no more than an angle's range.
#[cfg_attr(not(debug_assertions), inline(always))]
fn gone_on<S: Scalar>(angle: S, change: S) -> S {
    let limit = S::of(PI) * S::of(S::Real::ANGLE_RANGE);
    wrap(angle + change.max(-limit).min(limit))
}
