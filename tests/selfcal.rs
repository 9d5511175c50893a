//! `SelfCalKF`: its derivatives against differences, and what it finds of planted calibrations.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::cast_precision_loss, reason = "small counters")]

#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

use ahrs_rs::filters::selfcal::block::Block;
use ahrs_rs::filters::selfcal::measurement::Seen;
use ahrs_rs::filters::selfcal::prediction::Transition;
use ahrs_rs::filters::selfcal::state::{
    ACC_BIAS, BIAS, DELAY, DISTURBANCE, GRAVITY, HORIZONTAL, IRON, MATRIX, N, State, THETA, TURN, VELOCITY,
};
use ahrs_rs::filters::{SelfCalKF, selfcal};
use ahrs_rs::params::ParamSet;
use ahrs_rs::so3::{exp_half, rotate_by};
use ahrs_rs::{Estimator, Filter, Quat, Real, Settings, Vec3};
use random::Random;

type Params = <SelfCalKF<f64> as Filter<f64>>::Params;

fn params() -> Params {
    with(&[])
}

/// The defaults with other values.
fn with(changes: &[(&str, f64)]) -> Params {
    let specs = selfcal::SPEC.params;
    let mut values: Vec<_> = specs.iter().map(|spec| spec.default()).collect();
    for (name, value) in changes {
        values[specs.iter().position(|spec| spec.name == *name).unwrap()] = *value;
    }
    Params::from_values(&values).unwrap()
}

/// A state that is nowhere zero.
fn some_state() -> State<f64> {
    let mut state = State::new(&params());
    let mut random = Random(5);
    state.q = Quat::of(random.rotation());
    for i in BIAS..N {
        let size = if i == GRAVITY { continue } else { 0.02 };
        state.mean[i] = size * random.normal();
    }
    state.mean[HORIZONTAL] = 0.4;
    state.mean[HORIZONTAL + 1] = -0.9;
    state
}

/// The state with an error added.
fn off(state: &State<f64>, i: usize, by: f64) -> State<f64> {
    let mut state = state.clone();
    if i < BIAS {
        let mut turn = [0.0; 3];
        turn[i] = 0.5 * by;
        state.q = exp_half(Vec3::of(turn)) * state.q;
        if i == TURN {
            // The velocity turns with the heading.
            let v = state.velocity();
            (state.mean[VELOCITY], state.mean[VELOCITY + 1]) = (v.x - by * v.y, v.y + by * v.x);
        }
    } else {
        state.mean[i] += by;
    }
    state
}

/// A block of samples as the filter takes it, from a state: the block, and the state at its end.
fn block_of(start: &State<f64>) -> (Block<f64>, State<f64>) {
    let (mut block, mut state) = (Block::new(), start.clone());
    let dt = 0.001;
    for k in 0..100 {
        let t = f64::from(k) * dt;
        let gyr = Vec3::new(1.0 + t, -2.0 + 3.0 * t, 1.5 * (20.0 * t).cos());
        let rate = gyr - state.bias();
        let turning = rate + state.misaligned(rate);
        state.q = rotate_by(state.q, turning, dt);
        let r = state.q.matrix();
        block.turns(r, gyr, rate, turning, dt);
        block.pushes(true, r, Vec3::new(3.0, -1.0 + 20.0 * t, 9.0), &state, dt);
        block.points(true, r, Vec3::new(0.3, -0.5, 0.8), turning, state.mean[DELAY]);
    }
    (block, state)
}

/// The rotation vector of the turn between two attitudes in the earth frame.
fn turn_between(to: Quat<f64>, from: Quat<f64>) -> [f64; 3] {
    let q = to * from.conj();
    [2.0 * q.x, 2.0 * q.y, 2.0 * q.z]
}

#[test]
fn the_transition_is_the_derivative_of_a_block() {
    let start = some_state();
    let (block, end) = block_of(&start);
    let transition = Transition::new(true, &block, &start, &params());
    let moved = |start: &State<f64>| {
        let (block, mut end) = block_of(start);
        Transition::new(true, &block, start, &params()).move_mean(true, &mut end, &block);
        end
    };
    let mean = moved(&start);
    assert!((end.q.w - mean.q.w).abs() <= 0.0);
    let small = 1e-6;
    let mut largest: f64 = 0.0;
    for i in 0..N {
        let mut column = start.mean;
        column.iter_mut().for_each(|value| *value = 0.0);
        column[i] = 1.0;
        transition.apply(&mut column);
        let other = moved(&off(&start, i, small));
        let mut derivative = [0.0; N];
        for (k, turn) in turn_between(other.q, mean.q).into_iter().enumerate() {
            derivative[THETA + k] = turn / small;
        }
        for k in BIAS..N {
            derivative[k] = (other.mean[k] - mean.mean[k]) / small;
        }
        if i == TURN {
            let v = mean.velocity();
            derivative[VELOCITY] += v.y;
            derivative[VELOCITY + 1] -= v.x;
        }
        for k in 0..N {
            // Left out: what bias and matrix do to the velocity within a block, by way of the attitude: at most
            // ½ |ΣR a dt| dt for one, times the rate for the other: 0.05 and 0.25.
            let dropped = (VELOCITY..ACC_BIAS).contains(&k) && (BIAS..VELOCITY).contains(&i);
            let bound = if dropped { 0.25 } else { 2e-3 };
            let error = (derivative[k] - column[k]).abs();
            assert!(error < bound, "d x{k} / d x{i} is {}, not {}", derivative[k], column[k]);
            if !dropped {
                largest = largest.max(error);
            }
        }
    }
    // The sums take the attitude at the end of each step of 1 ms, half a step late: 0.5 ms · 5 rad/s · |(I + M)| 0.1 s.
    println!("largest difference {largest:e}");
}

#[test]
fn the_field_s_rows_are_the_derivatives_of_its_innovation() {
    let state = some_state();
    let innovation = |state: &State<f64>| {
        let (block, end) = block_of(state);
        Seen::new(&block, &end).rows(true, &end, 1.0).map(|row| row.z)
    };
    let (block, end) = block_of(&state);
    let rows = Seen::new(&block, &end).rows(true, &end, 1.0);
    let before = innovation(&state);
    let small = 1e-6;
    for i in (THETA..BIAS).chain(IRON..N) {
        let after = innovation(&off(&state, i, small));
        for (k, row) in rows.iter().enumerate() {
            let by_row: f64 = row.at.iter().zip(row.h).filter(|(at, _)| **at == i).map(|(_, h)| h).sum();
            let derivative = -(after[k] - before[k]) / small;
            // The turn of the hard iron (0.02) with the attitude is left out, and so is that of the rates in the delay.
            assert!((derivative - by_row).abs() < 0.05, "row {k}, state {i}: {derivative}, not {by_row}");
        }
    }
}

/// What is wrong with the simulated sensors.
#[derive(Clone, Copy, Default)]
struct Faults {
    bias: [f64; 3],
    matrix: [f64; 9],
    delay: f64,
    iron: [f64; 3],
}

/// How the simulated sensor turns, in rad/s.
trait Motion: FnMut(&mut Random, f64) -> [f64; 3] {}
impl<F: FnMut(&mut Random, f64) -> [f64; 3]> Motion for F {}

/// Three seconds of rest, then turns to and fro, each angle bounded.
fn swinging(seed: u64) -> impl Motion {
    let phase = Random(seed ^ 77).normal3();
    move |_, time| {
        if time < 3.0 {
            return [0.0; 3];
        }
        [2.5 * (0.9 * time + phase[0]).sin(), 3.0 * (0.7 * time + phase[1]).cos(), 2.0 * (0.5 * time + phase[2]).sin()]
    }
}

/// Three seconds of rest, then a tumble whose axis changes every second: no error of the gyroscope turns back by itself.
fn tumbling() -> impl Motion {
    let (mut from, mut to, mut start) = ([0.0; 3], [0.0; 3], 3.0);
    move |random: &mut Random, time: f64| {
        if time >= start {
            (from, to, start) = (to, random.normal3().map(|x| 2.5 * x), start + 1.0);
        }
        let share = (time - start + 1.0).clamp(0.0, 1.0);
        [0, 1, 2].map(|i| from[i] + share * (to[i] - from[i]))
    }
}

/// Runs the filter on a sensor that turns about in one place, at 100 Hz; `each` sees truth and filter at every sample.
fn simulate<S: Real>(
    seed: u64,
    seconds: f64,
    mut motion: impl Motion,
    faults: Faults,
    nine: bool,
    each: &mut impl FnMut(f64, Quat<f64>, Quat<S>),
) -> Estimator<S, SelfCalKF<S>> {
    let mut random = Random(seed);
    let params = <SelfCalKF<S> as Filter<S>>::Params::from_values(&[]).unwrap();
    let mut estimator = Estimator::<S, SelfCalKF<S>>::new(&params, Settings::default());
    let mut q = Quat::<f64>::of(random.rotation());
    let dt = 0.01;
    let of = |v: [f64; 3]| Vec3::<S>::of(v);
    for k in 0..(seconds / dt) as usize {
        let time = k as f64 * dt;
        let rate = Vec3::of(motion(&mut random, time));
        q = rotate_by(q, rate, dt);
        let m = faults.matrix;
        // ω = (I + M)⁻¹ rate + b, M being small.
        let turned = |v: Vec3<f64>| {
            Vec3::new(
                m[0] * v.x + m[1] * v.y + m[2] * v.z,
                m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z,
            )
        };
        let mut noise = |size: f64| Vec3::of([0.0; 3].map(|_: f64| size * random.normal()));
        let first = turned(rate);
        let gyr = rate - first + turned(first) + Vec3::of(faults.bias) + noise(2e-3);
        let acc = q.conj().rotate(Vec3::of([0.0, 0.0, 9.80665])) + noise(0.05);
        let late = rotate_by(q, rate, -faults.delay);
        let mag = late.conj().rotate(Vec3::of([0.0, 20.0, -40.0])) + Vec3::of(faults.iron) + noise(0.3);
        let array = |v: Vec3<f64>| of([v.x, v.y, v.z]);
        let output = estimator.step(array(gyr), Some(array(acc)), nine.then_some(array(mag)), S::from_f64(dt));
        each(time, q, output.quat);
    }
    estimator
}

fn angle(a: Quat<f64>, b: Quat<f64>) -> f64 {
    2.0 * (a.conj() * b).vector().norm2().sqrt().min(1.0).asin()
}

#[test]
fn it_finds_planted_delays_and_matrices_to_what_it_says() {
    for (seed, delay) in [(1, 0.0), (2, 0.01), (3, 0.02), (4, 0.04)] {
        let mut random = Random(100 + seed);
        let faults = Faults {
            bias: random.normal3().map(|b| 0.005 * b),
            matrix: [0; 9].map(|_| 0.003 * random.normal()),
            delay,
            iron: [0.0; 3],
        };
        let mut worst: f64 = 0.0;
        let estimator = simulate::<f64>(seed, 900.0, tumbling(), faults, true, &mut |time, truth, q| {
            if time > 450.0 {
                worst = worst.max(angle(truth, q));
            }
        });
        let state = estimator.filter().state();
        let found = state.mean[DELAY];
        println!("delay {delay}: {found:.4} ± {:.4}; worst angle {worst:.4}", state.p[(DELAY, DELAY)].sqrt());
        // The issue asks for 2 ms and 0.1 %. The filter says 0.5 ms, 0.2e-3 for the scales, and 0.9e-3 for the others: as a turn of
        // the gyroscope against the other sensors they show only in how these move within a turn.
        assert!((found - delay).abs() < 2e-3, "delay {delay}: found {found}");
        assert!(state.p[(DELAY, DELAY)] < 1e-6, "the delay is known to 1 ms");
        for i in 0..9 {
            let error = (state.mean[MATRIX + i] - faults.matrix[i]).abs();
            let bound = if i % 4 == 0 { 3e-4 } else { 1e-3 };
            assert!(error < bound, "entry {i} of the matrix is off by {error}");
        }
        // A disturbance as assumed, 0.018 of a field whose horizontal half is 0.45 of it, would be 0.04 rad.
        assert!(worst < 0.02, "the attitude is off by {worst} rad");
    }
}

#[test]
fn it_says_what_it_cannot_know() {
    let still = |_: &mut Random, _: f64| [0.0; 3];
    let faults = Faults { delay: 0.02, matrix: [0.003; 9], ..Faults::default() };
    let estimator = simulate::<f64>(21, 60.0, still, faults, true, &mut |_, _, _| {});
    let (state, before) = (estimator.filter().state(), State::new(&params()));
    for i in (MATRIX..VELOCITY).chain([DELAY]) {
        let (now, before) = (state.p[(i, i)].sqrt(), before.p[(i, i)].sqrt());
        // What the noise of the gyroscope and of its bias shows as turning is some 1e-2 rad in a minute.
        assert!(now > 0.95 * before, "state {i}: {now} of {before}");
        assert!(state.mean[i].abs() < 0.5 * before, "state {i} is {}", state.mean[i]);
    }
}

#[test]
fn ten_minutes_in_single_precision_are_those_in_double() {
    let faults = Faults { bias: [0.004, -0.003, 0.002], delay: 0.013, ..Faults::default() };
    let mut doubles = Vec::new();
    simulate::<f64>(9, 600.0, swinging(9), faults, true, &mut |_, _, q| doubles.push(q));
    let mut worst: f64 = 0.0;
    let mut k = 0;
    simulate::<f32>(9, 600.0, swinging(9), faults, true, &mut |time, _, q| {
        let q = Quat::of([q.w, q.x, q.y, q.z].map(f64::from));
        if time > 1.0 {
            worst = worst.max(angle(doubles[k], q));
        }
        k += 1;
    });
    println!("{worst:e} rad");
    // The variances of both differ by some 60 epsilon a block (the spare for rounding), 0.4 % a minute for what has no
    // noise of its own; a weight that differs so much moves the estimate by a small share of its error of 0.01 rad.
    assert!(worst < 2e-3, "{worst} rad");
}

#[test]
fn without_a_magnetometer_nothing_of_it_moves() {
    let estimator = simulate::<f64>(11, 60.0, swinging(11), Faults::default(), false, &mut |_, _, _| {});
    let state = estimator.filter().state();
    for i in (IRON..DISTURBANCE + 3).chain([HORIZONTAL, HORIZONTAL + 1, DELAY]) {
        assert!(state.mean[i].abs() <= 0.0, "state {i} is {}", state.mean[i]);
    }
}

#[test]
fn the_covariance_stays_one_in_motion_at_rest_and_over_gaps() {
    fn check<S: Real>() {
        let params = <SelfCalKF<S> as Filter<S>>::Params::from_values(&[]).unwrap();
        let mut estimator = Estimator::<S, SelfCalKF<S>>::new(&params, Settings::default());
        let mut random = Random(3);
        let mut q = Quat::<f64>::identity();
        for k in 0..60_000 {
            let dt = if random.chance(1e-3) { random.uniform(0.0, 2.0) } else { 0.01 };
            let rests = (k / 10_000) % 2 == 1;
            let rate = if rests { [0.0; 3] } else { [2.0 * (0.01 * k as f64).sin(), 1.0, -0.5] };
            q = rotate_by(q, Vec3::of(rate), dt);
            let acc = q.conj().rotate(Vec3::of([0.0, 0.0, 9.81]));
            let mag = q.conj().rotate(Vec3::of([0.0, 20.0, -40.0]));
            let of = |v: Vec3<f64>| Vec3::<S>::of([v.x, v.y, v.z]);
            let acc = if random.chance(0.05) { of(Vec3::of([f64::NAN; 3])) } else { of(acc) };
            estimator.step(Vec3::of(rate), Some(acc), Some(of(mag)), S::from_f64(dt));
            if k % 500 == 499 {
                let p = &estimator.filter().state().p;
                let mut l = [[0.0; N]; N];
                for i in 0..N {
                    for j in 0..=i {
                        assert!((p[(i, j)].to_f64() - p[(j, i)].to_f64()).abs() <= 0.0, "symmetric at ({i}, {j})");
                        let rest = p[(i, j)].to_f64() - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
                        if i == j {
                            assert!(rest > 0.0, "sample {k}: pivot {i} of {} bits is {rest:e}", 8 * size_of::<S>());
                            l[i][i] = rest.sqrt();
                        } else {
                            l[i][j] = rest / l[j][j];
                        }
                    }
                }
            }
        }
    }
    check::<f64>();
    check::<f32>();
}

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
        let default = selfcal::SPEC.params.iter().find(|spec| spec.name == name).unwrap().default();
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
