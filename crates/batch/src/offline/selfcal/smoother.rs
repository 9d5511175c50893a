//! A Kalman filter over the blocks, linear about a nominal trajectory, and the smoother that goes back over it.
//!
//! The smoother needs no inverse of a covariance: what later measurements say is carried back as r with
//! x_smoothed = x + P r, and its covariance N with P_smoothed = P − P N P (Bryson & Frazier 1963; in this form de Jong 1989,
//! Durbin & Koopman 2012, section 4.5). A scalar measurement of gain K gives r := r + hᵀ(ν/s − Kᵀr), a prediction r := Fᵀr. The
//! smoothed states follow forward from the first one: x := F x + u + Q r.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use ahrs_rs::filters::kalman::{Column, Square, zeros};
use ahrs_rs::filters::selfcal::measurement::{self, Row, Seen};
use ahrs_rs::filters::selfcal::prediction::Transition;
use ahrs_rs::filters::selfcal::state::{BIAS, N, State, THETA, VELOCITY, initial_variance};
use ahrs_rs::filters::selfcal::Params;
use ahrs_rs::so3::exp_half;

use super::blocks::{Summed, Trajectory, rotation_vector};

/// A weight below this is none.
const SMALLEST_WEIGHT: f64 = 1e-4;
/// The states of whose smoothed covariance somebody asks at every block: the attitude's error and the gyroscope's bias.
pub const ASKED: usize = 6;

/// A measurement that was taken: what it shows, its gain, and its innovation over the innovation's variance.
struct Taken {
    at: [usize; 7],
    h: [f64; 7],
    gain: Column<f64, N>,
    nu_over_s: f64,
    over_s: f64,
}

/// What the way back needs of a block.
struct Step {
    transition: Transition<f64>,
    noises: [(usize, f64); 5],
    /// How the states move beside the transition: those of the nominal block, and the change to the next one's nominal.
    moved: Column<f64, N>,
    taken: Vec<Taken>,
    /// The rows of the covariance at the end that are asked for.
    known: Option<Box<[Column<f64, N>; ASKED]>>,
}

/// What a pass gives.
pub struct Smoothed {
    /// The trajectory.
    pub trajectory: Trajectory,
    /// The covariance of the last block: that of what does not change with time.
    pub last: Box<Square<f64, N>>,
    /// The covariances of the attitude's error and the bias at the end of each block.
    pub covariances: Vec<Square<f64, ASKED>>,
}

/// Filters and smooths the blocks about a nominal trajectory; `prior` are the states before the recording.
pub fn smooth(
    blocks: &[Summed],
    nominal: &Trajectory,
    prior: &Column<f64, N>,
    params: &Params<f64>,
    covariances: bool,
) -> Option<Smoothed> {
    let (_, first) = nominal.at(0)?;
    let mut state = State::new(params);
    for i in 0..N {
        for j in 0..N {
            state.p[(i, j)] = if i == j { initial_variance(params, i) } else { 0.0 };
        }
    }
    let start = prior - first;
    let start_covariance = state.p;
    let mut x = start;
    let mut steps = Vec::with_capacity(blocks.len());
    for (node, block) in blocks.iter().enumerate() {
        let step = forward(block, (node, nominal), &mut state, &mut x, (params, covariances))?;
        steps.push(step);
    }
    let last = Box::new(state.p);

    // Back.
    let mut r: Column<f64, N> = zeros();
    let mut n: Square<f64, N> = zeros();
    let mut adjoints = Vec::with_capacity(blocks.len());
    let mut spread = Vec::new();
    for step in steps.iter().rev() {
        if let Some(known) = &step.known {
            spread.push(smoothed_covariance(known, &n));
        }
        for taken in step.taken.iter().rev() {
            taken.carry_back(&mut r);
            if covariances {
                taken.carry_covariance_back(&mut n);
            }
        }
        adjoints.push(r);
        step.transition.apply_transposed(&mut r);
        if covariances {
            carry_covariance_back(&step.transition, &mut n);
        }
    }
    spread.reverse();

    // Forward again.
    let mut x = start + start_covariance * r;
    let mut trajectory = Trajectory { quat: Vec::with_capacity(blocks.len() + 1), mean: Vec::with_capacity(blocks.len() + 1) };
    let mut put = |node: usize, x: &Column<f64, N>| -> Option<()> {
        let (q, mean) = nominal.at(node)?;
        let turn = exp_half(ahrs_rs::Vec3::new(x[0], x[1], x[2]) * 0.5);
        let mut mean = mean + x;
        for i in THETA..BIAS {
            mean[i] = 0.0;
        }
        let sound = mean.iter().chain(x.iter()).all(|value| value.is_finite());
        trajectory.quat.push((turn * q).unit_or(q));
        trajectory.mean.push(mean);
        sound.then_some(())
    };
    put(0, &x)?;
    for (node, (step, adjoint)) in steps.iter().zip(adjoints.iter().rev()).enumerate() {
        step.transition.apply(&mut x);
        x += step.moved;
        for (start, noise) in step.noises {
            for i in start..start + 3 {
                x[i] += noise * adjoint[i];
            }
        }
        put(node + 1, &x)?;
    }
    Some(Smoothed { trajectory, last, covariances: spread })
}

/// Predicts and corrects by one block: x is the error of the nominal states, before and after.
fn forward(
    block: &Summed,
    (node, nominal): (usize, &Trajectory),
    state: &mut State<f64>,
    x: &mut Column<f64, N>,
    (params, covariances): (&Params<f64>, bool),
) -> Option<Step> {
    let (_, mean) = nominal.at(node)?;
    let (next, next_mean) = nominal.at(node + 1)?;
    let sums = &block.sums;
    (state.q, state.mean) = (block.quat, *mean);
    let transition = Transition::new(true, sums, state, params);
    transition.propagate(&mut state.p);
    let noises = transition.noises(sums, params);
    for (start, noise) in noises {
        for i in start..start + 3 {
            state.p[(i, i)] += noise;
        }
    }
    transition.apply(x);
    transition.move_mean(true, state, sums);

    let mut taken = Vec::with_capacity(9);
    let rests = sums.time < 2.0 * sums.rest;
    for row in measurement::velocity(true, rests, state, sums.time, params) {
        taken.extend(take(&row, &mut state.p, x));
    }
    if rests {
        for row in measurement::rest(true, sums.gyr * (1.0 / sums.time), state, sums.time, params) {
            taken.extend(take(&row, &mut state.p, x));
        }
    }
    if sums.fields > 0.0 && block.weight > SMALLEST_WEIGHT {
        let turning2 = sums.rate2 / sums.time;
        let noise2 = params.mag_noise * params.mag_noise + params.mag_rate_noise * params.mag_rate_noise * turning2;
        let rows = Seen::new(sums, state).rows(true, state, noise2 / (block.interval * block.weight));
        for row in rows {
            taken.extend(take(&row, &mut state.p, x));
        }
    }

    // The error of the next nominal state instead of that of the one to which this block leads.
    let mut moved = state.mean - next_mean;
    let turn = rotation_vector(block.quat * next.conj());
    (moved[0], moved[1], moved[2]) = (turn.x, turn.y, turn.z);
    *x += moved;
    let known = covariances.then(|| {
        let mut rows: Box<[Column<f64, N>; ASKED]> = Box::new([zeros(); ASKED]);
        for (i, row) in rows.iter_mut().enumerate() {
            row.copy_from(&state.p.column(THETA + i));
        }
        rows
    });
    let sound = (0..N).all(|i| x[i].is_finite() && state.p[(i, i)] >= 0.0 && state.p[(i, i)].is_finite());
    sound.then_some(Step { transition, noises, moved, taken, known })
}

/// Takes a measurement z = h x + noise.
fn take(row: &Row<f64>, p: &mut Square<f64, N>, x: &mut Column<f64, N>) -> Option<Taken> {
    let mut gain: Column<f64, N> = zeros();
    let mut expected = 0.0;
    for (&at, &h) in row.at.iter().zip(&row.h) {
        if h != 0.0 {
            for i in 0..N {
                gain[i] += p[(i, at)] * h;
            }
            expected += x[at] * h;
        }
    }
    let mut s = row.r;
    for (&at, &h) in row.at.iter().zip(&row.h) {
        s += gain[at] * h;
    }
    if !(s.is_normal() && s > 0.0) {
        return None;
    }
    let over_s = 1.0 / s;
    let nu_over_s = (row.z - expected) * over_s;
    for j in 0..N {
        let factor = gain[j] * over_s;
        for i in 0..N {
            p[(i, j)] -= gain[i] * factor;
        }
        x[j] += gain[j] * nu_over_s;
    }
    gain *= over_s;
    Some(Taken { at: row.at, h: row.h, gain, nu_over_s, over_s })
}

impl Taken {
    /// r := r + hᵀ(ν/s − Kᵀ r).
    fn carry_back(&self, r: &mut Column<f64, N>) {
        let more = self.nu_over_s - self.gain.dot(r);
        for (&at, &h) in self.at.iter().zip(&self.h) {
            r[at] += h * more;
        }
    }

    /// N := hᵀh/s + (I − K h)ᵀ N (I − K h).
    fn carry_covariance_back(&self, n: &mut Square<f64, N>) {
        let nk: Column<f64, N> = *n * self.gain;
        let more = self.over_s + nk.dot(&self.gain);
        for (&at, &h) in self.at.iter().zip(&self.h) {
            if h != 0.0 {
                for i in 0..N {
                    n[(i, at)] -= nk[i] * h;
                    n[(at, i)] -= nk[i] * h;
                }
            }
        }
        for (&j, &hj) in self.at.iter().zip(&self.h) {
            for (&i, &hi) in self.at.iter().zip(&self.h) {
                n[(i, j)] += hi * hj * more;
            }
        }
    }
}

/// N := Fᵀ N F.
fn carry_covariance_back(transition: &Transition<f64>, n: &mut Square<f64, N>) {
    for _ in 0..2 {
        for j in 0..N {
            let mut column: Column<f64, N> = n.column(j).into_owned();
            transition.apply_transposed(&mut column);
            n.set_column(j, &column);
        }
        n.transpose_mut();
    }
}

/// P − P N P for the first states.
fn smoothed_covariance(known: &[Column<f64, N>; ASKED], n: &Square<f64, N>) -> Square<f64, ASKED> {
    let mut p = zeros();
    for (j, column) in known.iter().enumerate() {
        let np: Column<f64, N> = *n * column;
        for (i, row) in known.iter().enumerate() {
            p[(i, j)] = column[i] - row.dot(&np);
        }
    }
    let _ = VELOCITY;
    p
}
