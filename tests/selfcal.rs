//! `SelfCalKF`: its derivatives against differences, and what it finds of planted calibrations.

#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a test that fails may panic")]
#![allow(clippy::cast_precision_loss, reason = "small counters")]

#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

use ahrs_rs::filters::SelfCalKF;
use ahrs_rs::filters::selfcal::block::Block;
use ahrs_rs::filters::selfcal::measurement::Seen;
use ahrs_rs::filters::selfcal::prediction::Transition;
use ahrs_rs::filters::selfcal::state::{
    ACC_BIAS, BIAS, DELAY, DISTURBANCE, GRAVITY, HORIZONTAL, IRON, MATRIX, N, State, THETA, TURN, VELOCITY,
};
use ahrs_rs::params::ParamSet;
use ahrs_rs::so3::{exp_half, rotate_by};
use ahrs_rs::{Estimator, Filter, Quat, Real, Settings, Vec3};
use random::Random;

type Params = <SelfCalKF<f64> as Filter<f64>>::Params;

fn params() -> Params {
    Params::from_values(&[]).unwrap()
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
    for i in [TURN].into_iter().chain(IRON..N) {
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

/// Runs the filter on a sensor that turns about in one place, at 100 Hz; `each` sees truth and filter at every sample.
fn simulate<S: Real>(seed: u64, seconds: f64, faults: Faults, nine: bool, each: &mut impl FnMut(f64, Quat<f64>, Quat<S>)) -> Estimator<S, SelfCalKF<S>> {
    let mut random = Random(seed);
    let params = <SelfCalKF<S> as Filter<S>>::Params::from_values(&[]).unwrap();
    let mut estimator = Estimator::<S, SelfCalKF<S>>::new(&params, Settings::default());
    let mut q = Quat::<f64>::of(random.rotation());
    let phase = random.normal3();
    let dt = 0.01;
    let of = |v: [f64; 3]| Vec3::<S>::of(v);
    for k in 0..(seconds / dt) as usize {
        let time = k as f64 * dt;
        let rate = Vec3::of([
            2.5 * (0.9 * time + phase[0]).sin(),
            3.0 * (0.7 * time + phase[1]).cos(),
            2.0 * (0.5 * time + phase[2]).sin(),
        ]);
        let rate = if time < 3.0 { Vec3::zero() } else { rate };
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
        let estimator = simulate::<f64>(seed, 120.0, faults, true, &mut |time, truth, q| {
            if time > 60.0 {
                worst = worst.max(angle(truth, q));
            }
        });
        let state = estimator.filter().state();
        let found = state.mean[DELAY];
        println!("delay {delay}: {found:.4} ± {:.4}; worst angle {worst:.4}", state.p[(DELAY, DELAY)].sqrt());
        // The issue asks for 2 ms and 0.1 %.
        assert!((found - delay).abs() < 2e-3, "delay {delay}: found {found}");
        for i in 0..9 {
            let error = (state.mean[MATRIX + i] - faults.matrix[i]).abs();
            assert!(error < 1e-3, "entry {i} of the matrix is off by {error}");
        }
        assert!(worst < 0.035, "the attitude is off by {worst} rad");
    }
}

#[test]
fn ten_minutes_in_single_precision_are_those_in_double() {
    let faults = Faults { bias: [0.004, -0.003, 0.002], delay: 0.013, ..Faults::default() };
    let mut doubles = Vec::new();
    simulate::<f64>(9, 600.0, faults, true, &mut |_, _, q| doubles.push(q));
    let mut worst: f64 = 0.0;
    let mut k = 0;
    simulate::<f32>(9, 600.0, faults, true, &mut |time, _, q| {
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
    let estimator = simulate::<f64>(11, 60.0, Faults::default(), false, &mut |_, _, _| {});
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
