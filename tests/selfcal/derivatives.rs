//! The linear model against differences.

use ahrs_rs::filters::selfcal::block::Block;
use ahrs_rs::filters::selfcal::measurement::Seen;
use ahrs_rs::filters::selfcal::prediction::Transition;
use ahrs_rs::filters::selfcal::state::{
    ACC_BIAS, BIAS, DELAY, GRAVITY, HORIZONTAL, IRON, N, State, THETA, TURN, VELOCITY,
};
use ahrs_rs::so3::{exp_half, rotate_by};
use ahrs_rs::{Quat, Vec3};

use crate::params;
use crate::random::Random;

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
        block.turns(r, gyr, rate, turning, [dt, dt]);
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
            // The velocity by bias and matrix, within a block: as if force and rotation were the same all the time, which here
            // turns by 0.4 rad, which misses as much of ½ |F| T² = 0.05, times the rate of 3.5 rad/s.
            let within = (VELOCITY..ACC_BIAS).contains(&k) && (BIAS..VELOCITY).contains(&i);
            let bound = if within { 7e-2 } else { 2e-3 };
            let error = (derivative[k] - column[k]).abs();
            assert!(error < bound, "d x{k} / d x{i} is {}, not {}", derivative[k], column[k]);
            if !within {
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
