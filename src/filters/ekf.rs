//! Cirillo's extended Kalman filter of quaternion and angular rate.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use nalgebra::SMatrix;

use super::Integration;
use super::error_state::ErrorState;
use super::kalman::{
    SATURATION, Square, UNKNOWN_ANGLE, across, angle_variance, block, cap, column, congruent, diagonal, filled,
    inflate, new_vertical, none, none3, plus, product, put_rows, reported, saturated, select, set_block, sum3,
    symmetric, transposed, vec3, zeros,
};
use super::quaternions::{
    dot4, exponential, first_order, left, north_derivative, right, symmetric4, up_derivative, xi,
};
use crate::filter::{Equivariance, Filter, FilterSpec, Magnetometer, OutputSpec, Preset, Sample};
use crate::scalar::{Mask, Scalar};
use crate::so3::{Quat, Vec3};

/// The description.
pub const SPEC: FilterSpec = FilterSpec {
    name: "EKF",
    doc: "An extended Kalman filter whose state is the quaternion and the angular rate, held by process noise alone; \
          gyroscope, specific force over g and field over its reference's norm are measurements. It estimates no \
          bias. The field's inclination and norm come from the first magnetometer samples.",
    source: "Cirillo et al. 2014, eqs 7-26, in east-north-up, from the library's alignment; with gyroscope=\"input\" \
             the form of Ludwig & Burnham 2018, eqs 17-22",
    magnetometer: Magnetometer::Feedback,
    feedback: true,
    gyr_bias: false,
    equivariance: Equivariance::No("the variances of the axes are not equal"),
    params: PARAMS,
    presets: &[Preset {
        name: "cirillo2014",
        values: &[
            ("gyr_variance_x", 2.9e-5),
            ("gyr_variance_y", 2.3e-5),
            ("gyr_variance_z", 3.2e-5),
            ("acc_variance_x", 3.1e-5),
            ("acc_variance_y", 4.5e-5),
            ("acc_variance_z", 5.5e-5),
            ("mag_variance_x", 2.0e-3),
            ("mag_variance_y", 2.1e-3),
            ("mag_variance_z", 2.0e-3),
            ("quat_process", 1e-10 / 0.002),
            ("rate_process", 1e-3 / 0.002),
        ],
    }],
    outputs: &[
        OutputSpec {
            name: "covariance",
            doc: "covariance of the attitude error in the sensor frame, 4 Ξᵀ P Ξ, rad²; π²/3 about the vertical until a \
                  magnetometer sample has come",
            shape: &[3, 3],
        },
        OutputSpec {
            name: "innovation",
            doc: "measured less predicted angular rate (rad/s), specific force (g) and field (reference norms); NaN \
                  where there is no measurement",
            shape: &[9],
        },
        OutputSpec {
            name: "nis",
            doc: "normalised innovation squared of gyroscope, accelerometer and magnetometer, 3 degrees of freedom each",
            shape: &[3],
        },
    ],
};

choice! {
    /// What the gyroscope is: a measurement of the rate in the state (Cirillo), or the input that turns the attitude,
    /// with the gyroscope's variances as the rate's covariance in every step.
    pub enum Gyroscope { Measurement = "measurement", Input = "input" }
}

params! {
    /// Variance of the gyroscope's x axis (V of the paper).
    real gyr_variance_x: "rad²/s²" = 2.9e-5 in [1e-12, 1e6];
    /// Variance of the gyroscope's y axis.
    real gyr_variance_y: "rad²/s²" = 2.3e-5 in [1e-12, 1e6];
    /// Variance of the gyroscope's z axis.
    real gyr_variance_z: "rad²/s²" = 3.2e-5 in [1e-12, 1e6];
    /// Variance of the accelerometer's x axis over g².
    real acc_variance_x: "1" = 3.1e-5 in [1e-12, 1e6];
    /// Variance of the accelerometer's y axis over g².
    real acc_variance_y: "1" = 4.5e-5 in [1e-12, 1e6];
    /// Variance of the accelerometer's z axis over g².
    real acc_variance_z: "1" = 5.5e-5 in [1e-12, 1e6];
    /// Variance of the magnetometer's x axis over the square of the reference field's norm.
    real mag_variance_x: "1" = 2.0e-3 in [1e-12, 1e6];
    /// Variance of the magnetometer's y axis over the square of the reference field's norm.
    real mag_variance_y: "1" = 2.1e-3 in [1e-12, 1e6];
    /// Variance of the magnetometer's z axis over the square of the reference field's norm.
    real mag_variance_z: "1" = 2.0e-3 in [1e-12, 1e6];
    /// Process noise of the quaternion's components: W is this times dt. Cirillo: 1e-10 in 2 ms.
    real quat_process: "1/s" = 5e-8 in [0.0, 1e6];
    /// Process noise of the angular rate: W is this times dt. Cirillo: 1e-3 in 2 ms.
    real rate_process: "rad²/s³" = 0.5 in [0.0, 1e6];
    /// How long the reference field is averaged over magnetometer samples (0: the first one).
    real reference_time: "s" = 0.0 in [0.0, 1e6];
    /// Standard deviation of the inclination at the start (0: that of one accelerometer sample).
    real initial_inclination: "rad" = 0.0 in [0.0, 1e3];
    /// Standard deviation of the heading at the start (0: that of one magnetometer sample at a dip of 60°).
    real initial_heading: "rad" = 0.0 in [0.0, 1e3];
    /// Standard deviation of the angular rate at the start.
    real initial_rate: "rad/s" = 1.0 in [1e-6, 1e3];
    /// Gravity g, by which the specific force is divided.
    real gravity: "m/s²" = 9.80665 in [1e-3, 1e3];
    choice gyroscope: Gyroscope;
    choice integration: Integration;
}

/// The largest angular rate that the state takes, in rad/s.
const LARGEST_RATE: f64 = 1e4;
/// The largest variance of a quaternion's component, and of the angular rate in rad²/s².
const LARGEST_VARIANCES: [f64; 2] = [1.0, 1e4];

/// The largest half turn in rad of a first-order step.
const LARGEST_TURN: f64 = 10.0;

/// Where the quaternion and where the rate stand in the state.
const QUAT: usize = 0;
const RATE: usize = 4;

/// Cirillo's extended Kalman filter of quaternion and angular rate.
#[derive(Clone, Debug)]
pub struct EKF<S: Scalar> {
    params: Params<S>,
    q: Quat<S>,
    rate: Vec3<S>,
    error: ErrorState<S, 7>,
    /// Horizontal and vertical part of h̄, the number of samples in them, and the time since the first.
    horizontal: S,
    vertical: S,
    count: S,
    age: S,
    innovation: [Vec3<S>; 3],
    nis: [S; 3],
}

impl<S: Scalar> Filter<S> for EKF<S> {
    type Params = Params<S>;
    const SPEC: &'static FilterSpec = &SPEC;
    // Not HAS_COVARIANCE: where the attitude is unknown its small variances take the first specific force for the vertical.
    const WATCHED: bool = true;

    fn new(params: &Params<S>) -> Self {
        let mut new = EKF {
            params: params.clone(),
            q: Quat::identity(),
            rate: Vec3::zero(),
            error: ErrorState::new(zeros()),
            horizontal: S::zero(),
            vertical: S::zero(),
            count: S::zero(),
            age: S::zero(),
            innovation: [none3(); 3],
            nis: [none(); 3],
        };
        new.error.p = start(params, new.q);
        new
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude(&self) -> Quat<S> {
        self.q
    }
    #[cold]
    #[inline(never)]
    fn set_attitude(&mut self, lanes: S::Mask, q: Quat<S>) {
        let start = diagonal(|_| inclination_variance(&self.params));
        let inclination = select(new_vertical(self.q, q), &start, &self.attitude_covariance());
        self.error.p = select(
            lanes,
            &started(&self.params, q, &inclination, &block::<_, RATE, RATE, 3, 3, 7>(&self.error.p)),
            &self.error.p,
        );
        self.q = Quat::select(lanes, q, self.q);
    }
    #[cold]
    #[inline(never)]
    fn reopen(&mut self, lanes: S::Mask, _bias: Vec3<S>) {
        self.error.p = select(lanes, &start(&self.params, self.q), &self.error.p);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn step(&mut self, sample: &Sample<S>, dt: S) {
        let params = &self.params;
        let moves = S::zero().lt(dt);
        let measured_rate = saturated(sample.gyr, S::of(LARGEST_RATE));
        let v_gyr = [params.gyr_variance_x, params.gyr_variance_y, params.gyr_variance_z];
        let v_acc = [params.acc_variance_x, params.acc_variance_y, params.acc_variance_z];
        let v_mag = [params.mag_variance_x, params.mag_variance_y, params.mag_variance_z];
        let input = params.gyroscope == Gyroscope::Input;
        if input {
            let v = column(Vec3::new(v_gyr[0], v_gyr[1], v_gyr[2]));
            let certain = filled(|i, j| match (i < RATE, j < RATE) {
                (true, true) => self.error.p[(i, j)],
                (false, false) if i == j => v[i - RATE],
                _ => S::zero(),
            });
            self.error.p = select(moves, &certain, &self.error.p);
            self.rate = Vec3::select(moves, measured_rate, self.rate);
        }
        self.predict(moves, dt);

        // h and the innovations of all sensors at the predicted state, then (25)-(26) component after component
        self.innovation = [none3(); 3];
        self.nis = [none(); 3];
        let shown = moves & !sample.lost;
        if !input && shown.any() {
            let innovation = measured_rate - self.rate;
            let nis = self.error.measure::<4, 1>(shown, [S::one()], innovation.x, v_gyr[0]);
            let nis = nis + self.error.measure::<5, 1>(shown, [S::one()], innovation.y, v_gyr[1]);
            let nis = nis + self.error.measure::<6, 1>(shown, [S::one()], innovation.z, v_gyr[2]);
            self.report(0, shown, innovation, nis);
        }
        // V is that of a sample at the gyroscope's rate.
        let (acc_steps, mag_steps) = (sample.acc.steps(sample.usual), sample.mag.steps(sample.usual));
        let (v_acc, v_mag) = (v_acc.map(|v| v / acc_steps), v_mag.map(|v| v / mag_steps));
        let valid = sample.acc.valid;
        if valid.any() {
            let z = saturated(sample.acc.value * (S::one() / self.params.gravity), S::of(SATURATION));
            let h = up_derivative(self.q); // (10)
            let innovation = z - seen_by(&h, self.q);
            let nis = correct_direction(&mut self.error, valid, &h, innovation, v_acc);
            self.report(1, valid, innovation, nis);
        }
        let valid = sample.mag.valid;
        if valid.any() {
            self.refer(valid, sample, sample.mag.interval);
            let norm = (self.horizontal * self.horizontal + self.vertical * self.vertical).sqrt();
            let (north, up) = (self.horizontal / norm, self.vertical / norm);
            let z = saturated(sample.mag.value * (S::one() / norm), S::of(SATURATION));
            let (up_seen, north_seen) = (up_derivative(self.q), north_derivative(self.q));
            let h = filled(|i, j| up_seen[(i, j)] * up + north_seen[(i, j)] * north); // (16)
            let innovation = z - seen_by(&h, self.q);
            let nis = correct_direction(&mut self.error, valid, &h, innovation, v_mag);
            self.report(2, valid, innovation, nis);
        }
        let (params, q) = (&self.params, self.q);
        let x = self.error.take(|| start(params, q.unit_or(Quat::identity())));
        let q = Quat::new(self.q.w + x[0], self.q.x + x[1], self.q.y + x[2], self.q.z + x[3]);
        self.q = q.unit_or(self.q);
        self.rate = saturated(self.rate + vec3(&x, RATE), S::of(LARGEST_RATE));
    }
    fn output(&self, index: usize, put: &mut impl FnMut(S)) {
        match index {
            0 => put_rows(&self.covariance(), put),
            1 => self.innovation.iter().for_each(|v| v.clone().each(&mut |value| put(*value))),
            _ => self.nis.iter().for_each(|nis| put(*nis)),
        }
    }
    fn each_variable(&mut self, visit: &mut impl FnMut(&mut S)) {
        self.q.each(visit);
        self.rate.each(visit);
        self.error.each(visit);
        for variable in [&mut self.horizontal, &mut self.vertical, &mut self.count, &mut self.age] {
            visit(variable);
        }
    }
}

impl<S: Scalar> EKF<S> {
    /// Covariance of the attitude error in the sensor frame in rad².
    pub fn covariance(&self) -> Square<S, 3> {
        reported(&self.attitude_covariance(), self.q.matrix().z, S::zero().lt(self.count))
    }

    /// 4 Ξᵀ P Ξ: q̂ + δq = q̂ ⊗ (1, ½δθ).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn attitude_covariance(&self) -> Square<S, 3> {
        let xi = xi(self.q);
        let p_xi = product(&block::<_, QUAT, QUAT, 4, 4, 7>(&self.error.p), &xi);
        symmetric(|i, j| S::of(4.0) * dot4(|k| xi[(k, i)] * p_xi[(k, j)]))
    }

    /// x⁻ = f(x), P⁻ = F P Fᵀ + W (20), (23), (24).
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn predict(&mut self, moves: S::Mask, dt: S) {
        let half_dt = S::of(0.5) * dt;
        let half_turn = self.rate * half_dt;
        // F = [E, G; 0, I]: q ⊗ e, and the derivative of that by the rate
        let (turn, by_rate) = match self.params.integration {
            Integration::Exponential => exponential(half_turn),
            Integration::FirstOrder => {
                let turn = saturated(half_turn, S::of(LARGEST_TURN));
                (Quat::from_parts(S::one(), turn), first_order())
            }
        };
        let e = right(turn);
        let turned = product(&left(self.q), &SMatrix::<S, 4, 3>::from(by_rate));
        let g: SMatrix<S, 4, 3> = filled(|i, j| turned[(i, j)] * half_dt);
        if moves.any() {
            let p = predicted(&self.params, &self.error.p, &e, &g, dt);
            self.error.set_covariance(moves, &p);
        }
        self.q = Quat::select(moves, self.q * turn, self.q);
    }

    /// The reference field h̄ of (16) in east-north-up: the mean of the field over its first `reference_time`, turned to
    /// north. What is up is said by the accelerometer (11)-(14), and by the attitude where there is none().
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn refer(&mut self, lanes: S::Mask, sample: &Sample<S>, dt: S) {
        let known = S::zero().lt(self.count);
        self.age = S::select(lanes & known, self.age + dt, self.age);
        let taken = lanes & (!known | self.age.le(self.params.reference_time));
        if taken.any() {
            let mag = sample.mag.value;
            let up = Vec3::select(sample.acc.valid, sample.acc.unit, self.q.unit_or(Quat::identity()).matrix().z);
            let count = self.count + S::one();
            let measured = [mag.cross(up).norm2().sqrt(), mag.dot(up)];
            for (mean, new) in [&mut self.horizontal, &mut self.vertical].into_iter().zip(measured) {
                *mean = S::select(taken, *mean + (new - *mean) / count, *mean);
            }
            self.count = S::select(taken, count, self.count);
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn report(&mut self, sensor: usize, lanes: S::Mask, innovation: Vec3<S>, nis: S) {
        if let (Some(v), Some(n)) = (self.innovation.get_mut(sensor), self.nis.get_mut(sensor)) {
            *v = Vec3::select(lanes, innovation, none3());
            *n = S::select(lanes, nis, none());
        }
    }
}

/// P⁻ = F P Fᵀ + W (24) with F = [E, G; 0, I].
#[cfg_attr(not(debug_assertions), inline(always))]
fn predicted<S: Scalar>(
    params: &Params<S>,
    p: &Square<S, 7>,
    e: &Square<S, 4>,
    g: &SMatrix<S, 4, 3>,
    dt: S,
) -> Square<S, 7> {
    let (w_quat, w_rate) = (params.quat_process * dt, params.rate_process * dt);
    let a = block::<_, QUAT, QUAT, 4, 4, 7>(p);
    let b = block::<_, QUAT, RATE, 4, 3, 7>(p);
    let d = block::<_, RATE, RATE, 3, 3, 7>(p);
    let left = plus(&product(e, &a), &product(g, &transposed(&b)));
    let right = plus(&product(e, &b), &product(g, &d));
    let by_turn = symmetric4(|i, j| dot4(|k| left[(i, k)] * e[(j, k)]));
    let by_rate = symmetric4(|i, j| sum3(|k| right[(i, k)] * g[(j, k)]));
    let turned = plus(&by_turn, &by_rate);
    let mut p = *p;
    set_block::<_, QUAT, QUAT, 4, 4, 7>(&mut p, &turned);
    set_block::<_, QUAT, RATE, 4, 3, 7>(&mut p, &right);
    for i in 0..7 {
        p[(i, i)] = p[(i, i)] + if i < RATE { w_quat } else { w_rate };
    }
    inflate(&mut p);
    let [quat, rate] = LARGEST_VARIANCES;
    cap(&mut p, |i| S::of(if i < RATE { quat } else { rate }));
    p
}

/// The covariance at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn start<S: Scalar>(params: &Params<S>, q: Quat<S>) -> Square<S, 7> {
    let rate = params.initial_rate * params.initial_rate;
    started(params, q, &diagonal(|_| inclination_variance(params)), &diagonal(|_| rate))
}

/// The covariance with the attitude at q, uncorrelated with that of the rate: the heading's variance is that of the start, the
/// inclination's is given.
#[cfg_attr(not(debug_assertions), inline(always))]
fn started<S: Scalar>(params: &Params<S>, q: Quat<S>, inclination: &Square<S, 3>, rate: &Square<S, 3>) -> Square<S, 7> {
    let up = column(q.matrix().z);
    let given = angle_variance(params.initial_heading);
    let mean = (params.mag_variance_x + params.mag_variance_y + params.mag_variance_z) * S::of(4.0 / 3.0);
    let heading = S::select(S::zero().lt(params.initial_heading), given, mean.min(S::of(UNKNOWN_ANGLE)));
    let tilt = congruent(&across(&up), inclination);
    let p = symmetric(|i, j| S::of(0.25) * (tilt[(i, j)] + heading * up[i] * up[j]));
    let xi = xi(q);
    let xi_p = product(&xi, &p);
    let p = symmetric4(|i, j| sum3(|k| xi_p[(i, k)] * xi[(j, k)]));
    filled(|i, j| match (i < RATE, j < RATE) {
        (true, true) => p[(i, j)],
        (false, false) => rate[(i - RATE, j - RATE)],
        _ => S::zero(),
    })
}

/// The inclination's variance at the start.
#[cfg_attr(not(debug_assertions), inline(always))]
fn inclination_variance<S: Scalar>(params: &Params<S>) -> S {
    let given = angle_variance(params.initial_inclination);
    let mean = (params.acc_variance_x + params.acc_variance_y + params.acc_variance_z) * S::of(1.0 / 3.0);
    S::select(S::zero().lt(params.initial_inclination), given, mean.min(S::of(UNKNOWN_ANGLE)))
}

/// Corrects by the three components of a direction.
#[cfg_attr(not(debug_assertions), inline(always))]
fn correct_direction<S: Scalar>(
    error: &mut ErrorState<S, 7>,
    lanes: S::Mask,
    h: &SMatrix<S, 3, 4>,
    innovation: Vec3<S>,
    variances: [S; 3],
) -> S {
    let row = |i: usize| [h[(i, 0)], h[(i, 1)], h[(i, 2)], h[(i, 3)]];
    let nis = error.measure::<QUAT, 4>(lanes, row(0), innovation.x, variances[0]);
    let nis = nis + error.measure::<QUAT, 4>(lanes, row(1), innovation.y, variances[1]);
    nis + error.measure::<QUAT, 4>(lanes, row(2), innovation.z, variances[2])
}

/// A direction v of the earth seen from the sensor, q* ⊗ v ⊗ q, is homogeneous of second degree in q: half of its derivative
/// `h` times q.
#[cfg_attr(not(debug_assertions), inline(always))]
fn seen_by<S: Scalar>(h: &SMatrix<S, 3, 4>, q: Quat<S>) -> Vec3<S> {
    let Quat { w, x, y, z } = q.scale(S::of(0.5));
    let seen = product(h, &SMatrix::<S, 4, 1>::from([w, x, y, z]));
    vec3(&seen, 0)
}
