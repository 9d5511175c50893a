//! The filter knows how wrong it is: on data of its own model its errors have the covariance that it says.

use ahrs_rs::filters::SelfCalKF;
use ahrs_rs::filters::selfcal::SPEC;
use ahrs_rs::filters::selfcal::state::{
    ACC_BIAS, BIAS, DELAY, DISTURBANCE, GRAVITY, HORIZONTAL, IRON, MATRIX, N, State, THETA, TURN, VELOCITY,
};
use ahrs_rs::so3::{exp_half, rotate_by};
use ahrs_rs::{Estimator, Quat, Settings, Vec3};

use crate::random::Random;
use crate::{Params, with};

/// The model's own parameters: without what makes the filter judge its measurements (weights, rest), and mild enough to be
/// linear.
const MODEL: &[(&str, f64)] = &[
    ("gyr_noise", 2e-3),
    ("rate_noise", 2e-3),
    ("bias_noise", 1e-4),
    ("velocity", 0.05),
    ("velocity_noise", 0.02),
    ("mag_noise", 0.01),
    ("mag_tolerance", 1e9),
    ("disturbance", 0.01),
    ("disturbance_time", 4.0),
    ("rest_gyr", 0.0),
    ("initial_inclination", 0.03),
    ("initial_bias", 0.01),
    ("initial_matrix", 0.003),
    ("initial_velocity", 0.2),
];

/// Groups of states whose errors are compared with their covariance.
const GROUPS: [(&str, usize, usize); 10] = [
    ("attitude", THETA, 3),
    ("bias", BIAS, 3),
    ("matrix", MATRIX, 9),
    ("velocity", VELOCITY, 3),
    ("acc bias", ACC_BIAS, 3),
    ("gravity", GRAVITY, 1),
    ("iron", IRON, 3),
    ("disturbance", DISTURBANCE, 3),
    ("field", HORIZONTAL, 2),
    ("delay", DELAY, 1),
];

/// eᵀ P⁻¹ e, by Cholesky's L: |L⁻¹ e|².
fn squared(e: impl Fn(usize) -> f64, p: impl Fn(usize, usize) -> f64, len: usize) -> f64 {
    let mut l = [[0.0; N]; N];
    let mut solved = [0.0; N];
    for i in 0..len {
        for j in 0..=i {
            let rest = p(i, j) - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
        }
        solved[i] = (e(i) - (0..i).map(|k| l[i][k] * solved[k]).sum::<f64>()) / l[i][i];
    }
    solved.iter().map(|x| x * x).sum()
}

/// One run over data of the filter's own model; the squared error over its covariance for each group, every second from the
/// fifth on.
fn consistency(seed: u64, told: &Params, found: &mut [f64; GROUPS.len()]) -> usize {
    let value = |name: &str| {
        let default = SPEC.params.iter().find(|spec| spec.name == name).unwrap().default();
        MODEL.iter().find(|(model, _)| *model == name).map_or(default, |(_, value)| *value)
    };
    let mut random = Random(seed);
    let dt = 0.01;
    let draw = |random: &mut Random, size: f64| Vec3::<f64>::of(random.normal3().map(|x| size * x));
    let mut truth = State::new(told);
    truth.q = Quat::of(random.rotation());
    let initial = |random: &mut Random, state: usize, name: &str| {
        value(name) * random.normal() + f64::from(u8::from(state == GRAVITY)) * value("gravity")
    };
    for i in BIAS..N {
        truth.mean[i] = match i {
            BIAS..MATRIX => initial(&mut random, i, "initial_bias"),
            MATRIX..VELOCITY => initial(&mut random, i, "initial_matrix"),
            VELOCITY..ACC_BIAS => initial(&mut random, i, "initial_velocity"),
            ACC_BIAS..GRAVITY => initial(&mut random, i, "initial_acc_bias"),
            GRAVITY => initial(&mut random, i, "initial_gravity"),
            IRON..DISTURBANCE => initial(&mut random, i, "initial_hard_iron"),
            DISTURBANCE..HORIZONTAL => initial(&mut random, i, "disturbance"),
            DELAY => initial(&mut random, i, "initial_delay"),
            _ => 0.0,
        };
    }
    (truth.mean[HORIZONTAL], truth.mean[HORIZONTAL + 1]) = (0.5, -0.866);
    let mut estimator = Estimator::<f64, SelfCalKF<f64>>::new(told, Settings::default());
    let tilt = draw(&mut random, value("initial_inclination"));
    let wrong = exp_half(Vec3::new(0.5 * tilt.x, 0.5 * tilt.y, 0.0));
    estimator.start_from(wrong * truth.q);
    let phase = random.normal3();
    let pseudo = value("velocity") * (2.0 * value("velocity_time") / 0.1_f64).sqrt();
    let kept = (-dt / value("disturbance_time")).exp();
    let mut acceleration = Vec3::zero();
    let mut count = 0;
    for k in 0..4000 {
        let time = f64::from(k) * dt;
        let rate = Vec3::of([
            1.5 * (0.9 * time + phase[0]).sin(),
            1.8 * (0.7 * time + phase[1]).cos(),
            1.2 * (0.5 * time + phase[2]).sin(),
        ]);
        truth.q = rotate_by(truth.q, rate, dt);
        // The velocity at the end of each block is what the pseudo-measurement says but for its noise.
        if k % 10 == 0 {
            acceleration = (draw(&mut random, pseudo) - truth.velocity()) * 10.0;
        }
        truth.put(true, VELOCITY, truth.velocity() + acceleration * dt);
        truth.put(true, BIAS, truth.bias() + draw(&mut random, value("bias_noise") * dt.sqrt()));
        truth.put(true, IRON, truth.hard_iron() + draw(&mut random, value("hard_iron_noise") * dt.sqrt()));
        let fresh = draw(&mut random, value("disturbance") * (1.0 - kept * kept).sqrt());
        truth.put(true, DISTURBANCE, truth.disturbance() * kept + fresh);

        let turning = value("rate_noise") * value("rate_noise") * rate.norm2();
        let gyr_noise = draw(&mut random, ((value("gyr_noise") * value("gyr_noise") + turning) / dt).sqrt());
        // (I + M) (ω − b) = rate.
        let once = rate - truth.misaligned(rate);
        let gyr = rate - truth.misaligned(once) + truth.bias() + gyr_noise;
        let up = Vec3::new(0.0, 0.0, truth.gravity());
        let acc = truth.q.conj().rotate(acceleration + up) + truth.acc_bias();
        let acc = acc + draw(&mut random, value("velocity_noise") / dt.sqrt());
        let field = Vec3::new(0.0, truth.mean[HORIZONTAL], truth.mean[HORIZONTAL + 1]) + truth.disturbance();
        let late = rotate_by(truth.q, rate, -truth.mean[DELAY]);
        let mag = late.conj().rotate(field) + truth.hard_iron();
        let spread = value("mag_noise").powi(2) + value("mag_rate_noise").powi(2) * rate.norm2();
        let mag = mag + draw(&mut random, (spread / dt).sqrt());
        estimator.step(gyr, Some(acc), Some(mag), dt);
        if k < 500 || k % 100 != 99 {
            continue;
        }
        count += 1;
        let filter = estimator.filter();
        let state = filter.state();
        let scale = filter.field_scale();
        let turn = truth.q * state.q.conj();
        let sign = if turn.w < 0.0 { -2.0 } else { 2.0 };
        let mut error = truth.mean - state.mean;
        (error[0], error[1], error[2]) = (sign * turn.x, sign * turn.y, sign * turn.z);
        // The error of the velocity turns with the heading.
        let v = state.velocity();
        error[VELOCITY] += error[TURN] * v.y;
        error[VELOCITY + 1] -= error[TURN] * v.x;
        for i in IRON..DELAY {
            error[i] = truth.mean[i] * scale - state.mean[i];
        }
        for ((_, start, len), sum) in GROUPS.iter().zip(found.iter_mut()) {
            *sum += squared(|i| error[start + i], |i, j| state.p[(start + i, start + j)], *len);
        }
    }
    count
}

#[test]
fn its_errors_on_data_of_its_own_model_have_the_covariances_that_it_says() {
    let told = with(MODEL);
    let runs = 100;
    let mut sums = [0.0; GROUPS.len()];
    let mut count = 0;
    for seed in 0..runs {
        count += consistency(1000 + seed, &told, &mut sums);
    }
    for ((name, _, len), sum) in GROUPS.iter().zip(sums) {
        let mean = sum / (count * len) as f64;
        // The band of 95 %, as if the errors of a run were one: those that do not change are.
        let band = 1.96 * (2.0 / (runs as usize * len) as f64).sqrt();
        assert!((mean - 1.0).abs() < band, "{name}: {mean} is not within {band} of 1");
    }
}

#[test]
fn told_too_little_noise_it_is_found_out() {
    let runs = 20;
    for (name, group) in [("disturbance", "disturbance"), ("mag_noise", "delay")] {
        let half = 0.5 * MODEL.iter().find(|(model, _)| *model == name).unwrap().1;
        let told = with(&[MODEL, &[(name, half)]].concat());
        let mut sums = [0.0; GROUPS.len()];
        let count: usize = (0..runs).map(|seed| consistency(1000 + seed, &told, &mut sums)).sum();
        let index = GROUPS.iter().position(|(other, ..)| *other == group).unwrap();
        let len = GROUPS[index].2;
        let mean = sums[index] / (count * len) as f64;
        let band = 1.96 * (2.0 / (runs as usize * len) as f64).sqrt();
        assert!(mean > 1.0 + band, "half of {name}: {group} {mean}");
    }
}
