//! From block to block: the transition F of the error, F P Fᵀ, and the noise of a block.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use super::Params;
use super::block::Block;
use super::state::{ACC_BIAS, BIAS, DISTURBANCE, GRAVITY, IRON, MATRIX, N, State, THETA, VELOCITY, within};
use crate::filters::kalman::{Column, Square, filled, rows, zeros};
use crate::scalar::Scalar;
use crate::so3::Vec3;
use crate::trig::one_minus_exp;

/// What is not the identity of the transition of a block.
#[derive(Clone, Debug)]
pub struct Transition<S: Scalar> {
    /// The derivatives of the attitude's error by the gyroscope's bias and matrix (the states from [`BIAS`] on).
    pub gyroscope: [[S; 12]; 3],
    /// Those of the velocity by the attitude's error, −[F]×. The turn about the vertical turns the velocity too, so that its
    /// error is not one of the velocity, and cannot be taken for one.
    pub tilt: Square<S, 3>,
    /// Those of the velocity by the accelerometer's bias, −Σ R dt.
    pub acc_bias: Square<S, 3>,
    /// That of the vertical velocity by gravity.
    pub fall: S,
    /// What is left of the disturbance.
    pub kept: S,
}

impl<S: Scalar> Transition<S> {
    /// That of a block where the mask is true, elsewhere the identity. With δω = (I + M)(ω − b) the attitude's error grows by Σ R ((δM)(ω − b̂) − (I + M̂) δb) dt.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn new(lanes: S::Mask, block: &Block<S>, state: &State<S>, params: &Params<S>) -> Self {
        let masked = |value: S| S::select(lanes, value, S::zero());
        let turn = rows(block.turn);
        let zero = S::zero();
        let mut gyroscope = [[zero; 12]; 3];
        for (i, (entries, sums)) in gyroscope.iter_mut().zip(block.matrix).enumerate() {
            for (j, entry) in entries.iter_mut().take(3).enumerate() {
                let mut sum = turn[(i, j)];
                for k in 0..3 {
                    sum = sum + turn[(i, k)] * state.mean[MATRIX + 3 * k + j];
                }
                *entry = masked(-sum);
            }
            let by_row = [sums.x.x, sums.x.y, sums.x.z, sums.y.x, sums.y.y, sums.y.z, sums.z.x, sums.z.y, sums.z.z];
            for (entry, sum) in entries.iter_mut().skip(3).zip(by_row) {
                *entry = masked(sum);
            }
        }
        let Vec3 { x, y, z } = Vec3::select(lanes, block.force, Vec3::zero());
        let pushed = rows(block.force_turn);
        Transition {
            gyroscope,
            // Column after column.
            tilt: Square::<S, 3>::from([[zero, -z, y], [z, zero, -x], [zero; 3]]),
            acc_bias: filled(|i, j| masked(-pushed[(i, j)])),
            fall: masked(-block.force_time),
            kept: S::one() - masked(one_minus_exp(block.time / params.disturbance_time)),
        }
    }

    /// F x. The force pushes the velocity along the mean of the attitude's errors at the start and the end of the block.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply(&self, x: &mut Column<S, N>) {
        let mut mean = [S::zero(); 3];
        for (i, entries) in self.gyroscope.iter().enumerate() {
            let mut grown = S::zero();
            for (k, entry) in entries.iter().enumerate() {
                grown = grown + *entry * x[BIAS + k];
            }
            mean[i] = x[THETA + i] + S::of(0.5) * grown;
            x[THETA + i] = x[THETA + i] + grown;
        }
        for i in 0..3 {
            let mut sum = x[VELOCITY + i];
            for k in 0..3 {
                sum = sum + (self.tilt[(i, k)] * mean[k] + self.acc_bias[(i, k)] * x[ACC_BIAS + k]);
            }
            x[VELOCITY + i] = sum;
            x[DISTURBANCE + i] = x[DISTURBANCE + i] * self.kept;
        }
        x[VELOCITY + 2] = x[VELOCITY + 2] + self.fall * x[GRAVITY];
    }

    /// Fᵀ x.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn apply_transposed(&self, x: &mut Column<S, N>) {
        // By its factors: half of the turn, the push, the other half.
        self.turn_transposed(x);
        x[GRAVITY] = x[GRAVITY] + self.fall * x[VELOCITY + 2];
        for k in 0..3 {
            for i in 0..3 {
                x[THETA + k] = x[THETA + k] + self.tilt[(i, k)] * x[VELOCITY + i];
                x[ACC_BIAS + k] = x[ACC_BIAS + k] + self.acc_bias[(i, k)] * x[VELOCITY + i];
            }
            x[DISTURBANCE + k] = x[DISTURBANCE + k] * self.kept;
        }
        self.turn_transposed(x);
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turn_transposed(&self, x: &mut Column<S, N>) {
        for k in 0..12 {
            let mut sum = S::zero();
            for (i, entries) in self.gyroscope.iter().enumerate() {
                sum = sum + entries[k] * x[THETA + i];
            }
            x[BIAS + k] = x[BIAS + k] + S::of(0.5) * sum;
        }
    }

    /// F P Fᵀ: F on each column of P, then on each row.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn propagate(&self, p: &mut Square<S, N>) {
        let mut column: Column<S, N> = zeros();
        for _ in 0..2 {
            for j in 0..N {
                for i in 0..N {
                    column[i] = p[(i, j)];
                }
                self.apply(&mut column);
                for i in 0..N {
                    p[(i, j)] = column[i];
                }
            }
            // Transposed in its place.
            for j in 1..N {
                for i in 0..j {
                    (p[(i, j)], p[(j, i)]) = (p[(j, i)], p[(i, j)]);
                }
            }
        }
        for j in 1..N {
            for i in 0..j {
                p[(j, i)] = p[(i, j)];
            }
        }
    }

    /// Carries the covariance over a block where the mask is true.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn predict(&self, lanes: S::Mask, p: &mut Square<S, N>, block: &Block<S>, params: &Params<S>) {
        self.propagate(p);
        for (start, noise) in self.noises(block, params) {
            for i in (start..start + 3).map(within) {
                p[(i, i)] = p[(i, i)] + S::select(lanes, noise, S::zero());
            }
        }
        let clipped = rows(block.clipped);
        for j in 0..3 {
            for i in 0..3 {
                // The same for (i, j) and (j, i).
                let noise = S::of(0.5) * (clipped[(i, j)] + clipped[(j, i)]);
                p[(i, j)] = p[(i, j)] + S::select(lanes, noise, S::zero());
            }
        }
        State::bounded(lanes, p, params);
    }

    /// The variances that the noise of a block adds: the first of three states, and how much to each of them.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn noises(&self, block: &Block<S>, params: &Params<S>) -> [(usize, S); 5] {
        let square = |x: S| x * x;
        let dt = block.time;
        let turning2 = square(params.rate_noise) * block.rate2;
        // What the specific force was where nothing is known of it: gravity, give or take as much.
        let unknown = (dt - block.force_time).max(S::zero()).min(S::of(1.0)) * params.gravity;
        let lost = S::one() - square(self.kept);
        // What is known exactly at the start does not wander.
        let wandering = |initial: S, noise: S| S::select(S::zero().lt(initial), square(noise) * dt, S::zero());
        [
            (THETA, square(params.gyr_noise) * dt + turning2 + block.slip),
            (BIAS, wandering(params.initial_bias, params.bias_noise)),
            (VELOCITY, square(params.velocity_noise) * dt + square(unknown)),
            (IRON, wandering(params.initial_hard_iron, params.hard_iron_noise)),
            (DISTURBANCE, square(params.disturbance) * lost),
        ]
    }

    /// The mean after a block, without the attitude, which every sample turns.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn move_mean(&self, lanes: S::Mask, state: &mut State<S>, block: &Block<S>) {
        let gravity = state.gravity();
        let up = Vec3::new(S::zero(), S::zero(), gravity * block.force_time);
        let change = block.force - up;
        state.put(lanes, VELOCITY, state.velocity() + change);
        state.put(lanes, DISTURBANCE, state.disturbance() * self.kept);
    }
}
