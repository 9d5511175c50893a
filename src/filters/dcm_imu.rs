//! Hyyti and Visala's adaptive extended Kalman filter on the bottom row of the rotation matrix.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::error_state::ErrorState;
use super::kalman::{
    LARGEST_BIAS, LEVEL_COVARIANCE, SATURATION, Square, block, cap, column, congruent, diagonal, filled, inflate,
    new_vertical, none, none3, plus, product, put_rows, reported, rows, saturated, select, set_block, skew, sum3,
    symmetric, transposed, vec3,
};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Preset, Sample};
use crate::scalar::{Mask, Real, Scalar};
use crate::so3::{Euler, Matrix3, Quat, Vec3, exp_half, half_angle};
use crate::trig::sin_cos;

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "DcmImu",
    doc: "An extended Kalman filter whose state is the vertical seen from the sensor (the bottom row C3 of the rotation \
          matrix) and the gyroscope's bias, with an accelerometer covariance that grows with the external \
          acceleration. The heading is integrated outside of it, with the estimated bias.",
    source: "Hyyti & Visala 2015, eqs 1-15 and A.1-A.8",
    magnetometer: Magnetometer::InitialHeading,
    feedback: true,
    gyr_bias: true,
    equivariance: Equivariance::No("the heading is that of the sensor's x axis"),
    params: PARAMS,
    presets: &[Preset {
        name: "hyyti2015",
        values: &[
            ("dcm_process", 0.1),
            ("bias_process", 1e-4),
            ("acc_std", 0.5),
            ("acc_motion", 10.0),
            ("initial_dcm", 1.0),
            ("initial_bias", 0.1),
            ("gravity", 9.8189),
        ],
    }],
    outputs: &[
        LEVEL_COVARIANCE,
        OutputSpec {
            name: "innovation",
            doc: "measured less predicted specific force, m/s²; NaN where there is no measurement",
            shape: &[3],
        },
        OutputSpec {
            name: "nis",
            doc: "normalised innovation squared of the accelerometer, 3 degrees of freedom",
            shape: &[],
        },
    ],
};

choice! {
    /// How C3 is predicted: by the exact solution over the step, or by the first-order step as published, which fails
    /// at high angular rates (39° on a recording of up to 1454 °/s).
    pub enum Prediction { Exponential = "exponential", Euler = "euler" }
}

params! {
    /// Process noise σ_C of C3: its variance grows by (σ_C dt)² in a step, eq. 10.
    real dcm_process: "1/s" = 0.1 in [0.0, 1e6];
    /// Process noise σ_b of the bias: its variance grows by (σ_b dt)² in a step, eq. 10.
    real bias_process: "rad/s²" = 1e-4 in [0.0, 1e6];
    /// Standard deviation σ_f of the accelerometer at rest, eq. 11.
    real acc_std: "m/s²" = 0.5 in [1e-6, 1e6];
    /// How much the external acceleration a counts: σ_a² |a| is added to the variance, eq. 11.
    real acc_motion: "(m/s²)^½" = 10.0 in [0.0, 1e6];
    /// Standard deviation of C3 at the start.
    real initial_dcm: "1" = 1.0 in [1e-6, 1e3];
    /// Standard deviation of the bias at the start.
    real initial_bias: "rad/s" = 0.1 in [1e-9, 1e3];
    /// Gravity g where the sensor is.
    real gravity: "m/s²" = 9.80665 in [1e-3, 1e3];
    choice prediction: Prediction;
}

/// The largest turn in rad of a first-order step.
const LARGEST_TURN: f64 = 10.0;
/// Where the bias stands in the state.
const BIAS: usize = 3;

/// Hyyti and Visala's adaptive extended Kalman filter on the bottom row of the rotation matrix.
#[derive(Clone, Debug)]
pub struct DcmImu<S: Scalar> {
    params: Params<S>,
    c3: Vec3<S>,
    bias: Vec3<S>,
    error: ErrorState<S, 6>,
    /// Cosine and sine of half of roll and yaw, which are held where the sensor's x axis is vertical.
    roll: [S; 2],
    yaw: [S; 2],
    q: Quat<S>,
    innovation: Vec3<S>,
    nis: S,
}

impl<S: Scalar> Filter<S> for DcmImu<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    const HAS_COVARIANCE: bool = true;
    const WATCHED: bool = true;

    fn new(params: &Params<S>) -> Self {
        DcmImu {
            params: params.clone(),
            c3: Vec3::of([0.0, 0.0, 1.0]),
            bias: Vec3::zero(),
            error: ErrorState::new(initial_covariance(params)),
            roll: [S::one(), S::zero()],
            yaw: [S::one(), S::zero()],
            q: Quat::identity(),
            innovation: none3(),
            nis: none(),
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cold]
    #[inline(never)]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        // The covariance of C3 starts afresh where the vertical is a new one; the bias keeps its own.
        let mut fresh = initial_covariance(&self.params);
        set_block::<_, BIAS, BIAS, 3, 3, 6>(&mut fresh, &block::<_, BIAS, BIAS, 3, 3, 6>(&self.error.p));
        self.error.p = select(lanes & new_vertical(self.q, q), &fresh, &self.error.p);
        self.c3 = Vec3::select(lanes, q.matrix().z, self.c3);
        let angles = Euler::from_quat(q);
        self.roll = chosen(lanes, half_of(angles.roll), self.roll);
        self.yaw = chosen(lanes, half_of(angles.yaw), self.yaw);
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cold]
    #[inline(never)]
    fn reopen(&mut self, lanes: S::Mask, bias: Vec3<S>) {
        self.error.p = select(lanes, &initial_covariance(&self.params), &self.error.p);
        self.bias = Vec3::select(lanes, bias, self.bias);
    }
    /// δC3 = [C3×] δθ: the variance across C3.
    fn lose_rotation(&mut self, lanes: S::Mask, variance: S) {
        let c3 = [self.c3.x, self.c3.y, self.c3.z];
        let variance = S::select(lanes, variance, S::zero());
        for j in 0..3 {
            for i in 0..3 {
                let across = if i == j { S::one() - c3[i] * c3[j] } else { -(c3[i] * c3[j]) };
                self.error.p[(i, j)] = self.error.p[(i, j)] + variance * across;
            }
        }
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let before = self.q;
        self.predict(sample.gyr - self.bias, dt);

        self.innovation = none3();
        self.nis = none();
        let valid = sample.acc.valid;
        if valid.any() {
            // Innovation (A.5), which is the external acceleration of (12) too; R of (11)
            let g = self.params.gravity;
            let a = saturated(sample.acc.value, S::of(SATURATION) * g) - self.c3 * g;
            let std = self.params.acc_std;
            // R is that of a sample at the gyroscope's rate.
            let variance = a.norm2().sqrt() * (self.params.acc_motion * self.params.acc_motion) + std * std;
            let variance = variance / sample.acc.steps(sample.usual);
            let nis_x = self.error.measure::<0, 1>(valid, [g], a.x, variance); // (9), (A.6)
            let nis_y = self.error.measure::<1, 1>(valid, [g], a.y, variance);
            let nis = nis_x + nis_y + self.error.measure::<2, 1>(valid, [g], a.z, variance);
            let params = &self.params;
            let x = self.error.take(|| initial_covariance(params));
            self.c3 = self.c3 + vec3(&x, 0);
            // A bias at its limit may be shortened once more, by rounding: not where there is no measurement.
            let bias = saturated(self.bias + vec3(&x, BIAS), S::of(LARGEST_BIAS) * params.initial_bias);
            self.bias = Vec3::select(valid, bias, self.bias);
            self.innovation = Vec3::select(valid, a, self.innovation);
            self.nis = S::select(valid, nis, none());
        }
        self.project();
        self.turn(before, sample.gyr - self.bias, dt);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gyr_bias(&self) -> Vec3<S> {
        self.bias
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        match index {
            0 => put_rows(&self.covariance(), put),
            1 => self.innovation.clone().each(&mut |value| put(*value)),
            _ => put(self.nis),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.c3.each(visit);
        self.bias.each(visit);
        self.q.each(visit);
        self.roll.iter_mut().for_each(&mut *visit);
        self.yaw.iter_mut().for_each(&mut *visit);
        self.error.each(visit);
    }
}

impl<S: Scalar> DcmImu<S> {
    /// Covariance of the attitude error in the sensor frame in rad², from δC3 = [C3×] δθ.
    pub fn covariance(&self) -> Square<S, 3> {
        let p = block::<_, 0, 0, 3, 3, 6>(&self.error.p);
        reported(&congruent(&transposed(&skew(self.c3)), &p), self.c3, S::Mask::splat(false))
    }

    /// (A.3) and (A.4): the state turns by −u dt, u the rate without its bias.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn predict(&mut self, u: Vec3<S>, dt: S) {
        // F = [turn, −dt [C3×]; 0, I]
        let turn = match self.params.prediction {
            Prediction::Exponential => rows(exp_half(u * (S::of(-0.5) * dt)).matrix()),
            Prediction::Euler => {
                let turn = skew(saturated(u * dt, S::of(LARGEST_TURN)));
                filled(|i, j| if i == j { S::one() } else { -turn[(i, j)] })
            }
        };
        let c3 = skew(self.c3);
        let by_bias: Square<S, 3> = filled(|i, j| -(c3[(i, j)] * dt));
        self.c3 = vec3(&product(&turn, &column(self.c3)), 0);

        let moves = S::zero().lt(dt);
        if moves.any() {
            let p = predicted(&self.params, &self.error.p, &turn, &by_bias, dt);
            self.error.set_covariance(moves, &p);
        }
    }

    /// (A.7)-(A.8): C3 of unit length again, and P ← J P Jᵀ with J = (I − n nᵀ)/d at the state of length d.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn project(&mut self) {
        let d2 = self.c3.norm2();
        let usable = d2.is_normal_norm2();
        let over_d = S::select(usable, S::one() / d2.sqrt(), S::one());
        // A state of no length has no direction: the one before the step stays.
        let n = column(Vec3::select(usable, self.c3 * over_d, self.q.matrix().z));
        let p = &mut self.error.p;
        let (a, b) = (block::<_, 0, 0, 3, 3, 6>(p), block::<_, 0, BIAS, 3, 3, 6>(p));
        let across = transposed(&n);
        let (na, nb) = (product(&across, &a), product(&across, &b));
        let twice = sum3(|k| n[k] * na[k]);
        let over_d2 = over_d * over_d;
        // Along n nothing is left: room there for the rounding of what is taken away.
        let room = S::of(8.0) * S::splat(S::Real::EPSILON) * sum3(|k| a[(k, k)]);
        let twice = twice + room;
        let across = symmetric(|i, j| (a[(i, j)] - (n[i] * na[j] + na[i] * n[j]) + n[i] * n[j] * twice) * over_d2);
        set_block::<_, 0, 0, 3, 3, 6>(p, &across);
        set_block::<_, 0, BIAS, 3, 3, 6>(p, &filled::<_, 3, 3>(|i, j| (b[(i, j)] - n[i] * nb[j]) * over_d));
        self.c3 = vec3(&n, 0);
    }

    /// (15): the yaw of the first column of the whole matrix, from the previous posterior with the updated bias; and the
    /// roll.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turn(&mut self, before: Quat<S>, rate: Vec3<S>, dt: S) {
        let (c1, c2) = match self.params.prediction {
            Prediction::Exponential => {
                let r = (before * exp_half(rate * (S::of(0.5) * dt))).matrix();
                (r.x.x, r.y.x)
            }
            Prediction::Euler => {
                let Matrix3 { x, y, .. } = before.matrix();
                (x.x + dt * (x.y * rate.z - x.z * rate.y), y.x + dt * (y.y * rate.z - y.z * rate.y))
            }
        };
        // Attitude of C3 (14) and the yaw, each angle by its half
        let Vec3 { x, y, z } = self.c3;
        let across2 = y * y + z * z;
        let across = across2.sqrt();
        let floor = S::of(S::Real::COS_PITCH_FLOOR);
        let defined = (floor * floor).le(across2);
        self.roll = chosen(defined, half_angle(z, y, across), self.roll);
        let norm2 = c1 * c1 + c2 * c2;
        self.yaw = chosen(defined & norm2.is_normal_norm2(), half_angle(c1, c2, norm2.sqrt()), self.yaw);
        let ([roll_cos, roll_sin], [yaw_cos, yaw_sin]) = (self.roll, self.yaw);
        let [pitch_cos, pitch_sin] = half_angle(across, -x, S::one());
        let o = S::zero();
        let tilt = Quat::new(pitch_cos, o, pitch_sin, o) * Quat::new(roll_cos, roll_sin, o, o);
        self.q = (Quat::new(yaw_cos, o, o, yaw_sin) * tilt).renormalized();
    }
}

/// Cosine and sine of half an angle.
#[cfg_attr(not(debug_assertions), inline(always))]
fn half_of<S: Scalar>(angle: S) -> [S; 2] {
    let (sin, cos) = sin_cos(S::of(0.5) * angle);
    [cos, sin]
}

/// `yes` where the mask is true, else `no`.
#[cfg_attr(not(debug_assertions), inline(always))]
fn chosen<S: Scalar>(lanes: S::Mask, [yes_cos, yes_sin]: [S; 2], [no_cos, no_sin]: [S; 2]) -> [S; 2] {
    [S::select(lanes, yes_cos, no_cos), S::select(lanes, yes_sin, no_sin)]
}

/// P⁻ = F P Fᵀ + Q with F = [turn, by_bias; 0, I].
#[cfg_attr(not(debug_assertions), inline(always))]
fn predicted<S: Scalar>(
    params: &Params<S>,
    p: &Square<S, 6>,
    turn: &Square<S, 3>,
    by_bias: &Square<S, 3>,
    dt: S,
) -> Square<S, 6> {
    let (q_c, q_b) = (params.dcm_process * dt, params.bias_process * dt); // (10)
    let bias = params.initial_bias * params.initial_bias * S::of(4.0);
    let a = block::<_, 0, 0, 3, 3, 6>(p);
    let b = block::<_, 0, BIAS, 3, 3, 6>(p);
    let d = block::<_, BIAS, BIAS, 3, 3, 6>(p);
    let left = plus(&product(turn, &a), &product(by_bias, &transposed(&b)));
    let right = plus(&product(turn, &b), &product(by_bias, &d));
    let turned = symmetric(|i, j| sum3(|k| left[(i, k)] * turn[(j, k)]) + sum3(|k| right[(i, k)] * by_bias[(j, k)]));
    let mut p = *p;
    set_block::<_, 0, 0, 3, 3, 6>(&mut p, &turned);
    set_block::<_, 0, BIAS, 3, 3, 6>(&mut p, &right);
    for i in 0..6 {
        // No more than the cap: a long gap is beyond the range of `f32`.
        p[(i, i)] = p[(i, i)] + if i < BIAS { (q_c * q_c).min(S::one()) } else { (q_b * q_b).min(bias) };
    }
    inflate(&mut p);
    cap(&mut p, |i| if i < BIAS { S::one() } else { bias });
    p
}

/// The covariance at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn initial_covariance<S: Scalar>(params: &Params<S>) -> Square<S, 6> {
    let (dcm, bias) = (params.initial_dcm * params.initial_dcm, params.initial_bias * params.initial_bias);
    diagonal(|i| if i < BIAS { dcm } else { bias })
}
