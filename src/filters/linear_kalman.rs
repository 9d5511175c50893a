//! Two linear Kalman filters, one for roll and one for pitch.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::Integration;
use super::error_state::ErrorState;
use super::kalman::{
    LEVEL_COVARIANCE, Square, UNKNOWN_ANGLE, cap, column, diagonal, inflate, new_vertical, none, put_rows, reported,
    select, symmetric,
};
use super::trigonometric::{accelerometer_angles, integrated};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Preset, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Euler, Quat, Vec3, rotate_by};
use crate::trig::{sin_cos, wrap};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "LinearKalman",
    doc: "Roll and pitch, each with the bias of its gyroscope axis, are estimated by a linear Kalman filter of its own \
          from the angles of the specific force. The heading is integrated.",
    source: "Parikh et al. 2021, eqs 1-2; Çoçoli & Badia 2023, Table I",
    magnetometer: Magnetometer::InitialHeading,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::No("Euler angles depend on the choice of the sensor's axes"),
    params: PARAMS,
    presets: &[Preset {
        name: "parikh2021",
        values: &[
            ("angle_process", 0.01181 * DEGREE2 / 0.005),
            ("bias_process", 4.28e-6 * DEGREE2 / 0.005),
            ("angle_variance", 2650.0 * DEGREE2),
        ],
    }],
    outputs: &[
        LEVEL_COVARIANCE,
        OutputSpec {
            name: "innovation",
            doc: "measured less predicted roll and pitch, rad; NaN where there is no measurement",
            shape: &[2],
        },
        OutputSpec { name: "nis", doc: "squares of the innovations over their variances", shape: &[2] },
    ],
};

/// One square degree in rad².
const DEGREE2: f64 = (core::f64::consts::PI / 180.0) * (core::f64::consts::PI / 180.0);

/// Where the variance of a bias stops growing, in rad²/s².
const LARGEST_BIAS_VARIANCE: f64 = 1e6;

params! {
    /// Process noise of the angle: the first entry of Q is this times dt. Parikh: 0.01181 deg² in 5 ms.
    real angle_process: "rad²/s" = 7.195063455362055e-4 in [0.0, 1e6];
    /// Process noise of the bias: the second entry of Q is this times dt. Parikh: 4.28e-6 deg² in 5 ms.
    real bias_process: "rad²/s³" = 2.607525113374225e-7 in [0.0, 1e6];
    /// Variance R of the specific force's angle. Parikh: 2650 deg².
    real angle_variance: "rad²" = 0.8072361624347777 in [1e-12, 1e6];
    /// Standard deviation of roll and pitch at the start (0: that of one measurement).
    real initial_angle: "rad" = 0.0 in [0.0, 1e3];
    /// Standard deviation of the biases at the start.
    real initial_bias: "rad/s" = 0.01 in [1e-9, 1e3];
    choice integration: Integration;
}

/// Two linear Kalman filters, one for roll and one for pitch.
#[derive(Clone, Debug)]
pub struct LinearKalman<S: Scalar> {
    params: Params<S>,
    q: Quat<S>,
    roll: Axis<S>,
    pitch: Axis<S>,
}

impl<S: Scalar> Filter<S> for LinearKalman<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const HAS_COVARIANCE: bool = true;

    fn new(params: &Params<S>) -> Self {
        let axis = Axis::new(params);
        LinearKalman { params: params.clone(), q: Quat::identity(), roll: axis.clone(), pitch: axis }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        let new = lanes & new_vertical(self.q, q);
        for axis in [&mut self.roll, &mut self.pitch] {
            let start = diagonal(|i| if i == 0 { initial_variance(&self.params) } else { axis.error.p[(1, 1)] });
            axis.error.p = select(new, &start, &axis.error.p);
        }
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lose_rotation(&mut self, lanes: S::Mask, variance: S) {
        for axis in [&mut self.roll, &mut self.pitch] {
            axis.error.p[(0, 0)] = axis.error.p[(0, 0)] + S::select(lanes, variance, S::zero());
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let before = Euler::from_quat(self.q);
        // Parikh eq. 1 in three dimensions
        let rate = sample.gyr - self.gyr_bias();
        let predicted = match self.params.integration {
            Integration::Exponential => Euler::from_quat(rotate_by(self.q, rate, dt)),
            Integration::FirstOrder => integrated(before, rate, dt),
        };
        // A bias about the sensor's y turns the pitch by −cos roll dt, Parikh's −dt where the sensor is level.
        self.roll.predict(&self.params, S::one(), dt);
        self.pitch.predict(&self.params, sin_cos(before.roll).1, dt);

        let (measured, roll_defined) = accelerometer_angles(sample.acc.unit, predicted);
        let valid = sample.acc.valid;
        // R is that of a sample at the gyroscope's rate.
        let variance = self.params.angle_variance / sample.acc.steps(sample.usual);
        let mut angles = predicted;
        angles.roll = angles.roll
            + self.roll.correct(&self.params, valid & roll_defined, wrap(measured.roll - predicted.roll), variance);
        angles.pitch =
            angles.pitch + self.pitch.correct(&self.params, valid, wrap(measured.pitch - predicted.pitch), variance);
        self.q = angles.to_quat();
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        Vec3::new(self.roll.bias, self.pitch.bias, S::zero())
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        match index {
            0 => put_rows(&self.covariance(), put),
            1 => [&self.roll, &self.pitch].iter().for_each(|axis| put(axis.innovation)),
            _ => [&self.roll, &self.pitch].iter().for_each(|axis| put(axis.nis)),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        for axis in [&mut self.roll, &mut self.pitch] {
            visit(&mut axis.bias);
            axis.error.each(visit);
        }
    }
}

impl<S: Scalar> LinearKalman<S> {
    /// Covariance of the attitude error in the sensor frame in rad²: of roll about x, of pitch about (0, cos φ, −sin φ).
    pub fn covariance(&self) -> Square<S, 3> {
        let (sin, cos) = sin_cos(Euler::from_quat(self.q).roll);
        let (x, y) = (column(Vec3::of([1.0, 0.0, 0.0])), column(Vec3::new(S::zero(), cos, -sin)));
        let (roll, pitch) = (self.roll.error.p[(0, 0)], self.pitch.error.p[(0, 0)]);
        let p = symmetric(|i, j| roll * x[i] * x[j] + pitch * y[i] * y[j]);
        reported(&p, self.q.matrix().z, S::Mask::splat(false))
    }
}

/// The variance of an angle at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn initial_variance<S: Scalar>(params: &Params<S>) -> S {
    let given = params.initial_angle * params.initial_angle;
    S::select(S::zero().lt(params.initial_angle), given, params.angle_variance)
}

/// The covariance of an angle and its bias at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn initial_covariance<S: Scalar>(params: &Params<S>) -> Square<S, 2> {
    let bias = params.initial_bias * params.initial_bias;
    diagonal(|i| if i == 0 { initial_variance(params) } else { bias })
}

/// The filter of one angle: the state is [angle, bias], of which the angle is kept in the attitude.
#[derive(Clone, Debug)]
struct Axis<S: Scalar> {
    bias: S,
    error: ErrorState<S, 2>,
    innovation: S,
    nis: S,
}

impl<S: Scalar> Axis<S> {
    fn new(params: &Params<S>) -> Self {
        Axis { bias: S::zero(), error: ErrorState::new(initial_covariance(params)), innovation: none(), nis: none() }
    }

    /// P = Φ P Φᵀ + Q with Φ = [1, −slope dt; 0, 1] (Parikh eq. 1; Table I, "project into k+1").
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn predict(&mut self, params: &Params<S>, slope: S, dt: S) {
        let turn = -(slope * dt);
        let p = &self.error.p;
        let (angle, cross, bias) = (p[(0, 0)], p[(0, 1)], p[(1, 1)]);
        let turned = cross + turn * bias;
        let mut p = Square::<S, 2>::from([
            [angle + turn * (cross + turned) + params.angle_process * dt, turned],
            [turned, bias + params.bias_process * dt],
        ]);
        inflate(&mut p);
        cap(&mut p, |i| S::of(if i == 0 { UNKNOWN_ANGLE } else { LARGEST_BIAS_VARIANCE }));
        self.error.set_covariance(S::zero().lt(dt), &p);
    }

    /// Table I with H = [1, 0] (Parikh eq. 2); corrects the bias and gives the correction of the angle.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn correct(&mut self, params: &Params<S>, lanes: S::Mask, innovation: S, variance: S) -> S {
        self.innovation = S::select(lanes, innovation, none());
        self.nis = none();
        if !lanes.any() {
            return S::zero();
        }
        let nis = self.error.measure::<0, 1>(lanes, [S::one()], innovation, variance);
        self.nis = S::select(lanes, nis, none());
        let x = self.error.take(|| initial_covariance(params));
        self.bias = self.bias + x[1];
        x[0]
    }
}
