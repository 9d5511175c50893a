//! A Kalman filter over the blocks, linear about a nominal trajectory, and the smoother that goes back over it.
//!
//! The smoother needs no inverse of a covariance: what later measurements say is carried back as r with
//! x_smoothed = x + P r, and its covariance N with P_smoothed = P − P N P (Bryson & Frazier 1963; in this form de Jong 1989,
//! Durbin & Koopman 2012, section 4.5). A scalar measurement of gain K gives r := r + hᵀ(ν/s − Kᵀr), a prediction r := Fᵀr. The
//! smoothed states follow forward from the first one: x := F x + u + Q r.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use ahrs_rs::Quat;
use ahrs_rs::filters::kalman::{Column, Square, product, rows, transposed, vec3, zeros};
use ahrs_rs::filters::selfcal::Params;
use ahrs_rs::filters::selfcal::magnetic::SMALLEST_WEIGHT;
use ahrs_rs::filters::selfcal::measurement::{self, Row, Seen};
use ahrs_rs::filters::selfcal::prediction::Transition;
use ahrs_rs::filters::selfcal::state::{
    ACC_BIAS, BIAS, DISTURBANCE, GRAVITY, MATRIX, N, State, THETA, TURN, VELOCITY, initial_variance,
};
use ahrs_rs::so3::exp_half;

use crate::threads::Watch;

use super::blocks::{Summed, Trajectory, rotation_vector};

/// How far in rad/s the rate may be beyond the gyroscope's range.
const BEYOND_RANGE: f64 = 3.0;
/// How often the variance of an angle of the inclination counts as noise of the field: its error lasts longer than a block.
const INCLINATION_NOISE: f64 = 4.0;
/// The states of whose smoothed covariance somebody asks at every block: the attitude's error and the gyroscope's bias.
pub const ASKED: usize = 6;

/// A measurement that was taken.
pub struct Taken {
    /// What it shows.
    pub row: Row<f64>,
    gain: Column<f64, N>,
    /// Its innovation, and one, over the innovation's variance.
    nu_over_s: f64,
    over_s: f64,
}

/// What the way back needs of a block.
pub struct Step {
    /// How the error goes on.
    pub transition: Transition<f64>,
    /// The variances of the noise, from the states on at which they begin.
    pub noises: [(usize, f64); 5],
    /// What a gyroscope at the end of its range adds to the attitude's covariance.
    pub lost: Option<Square<f64, 3>>,
    /// How the error moves beside, after the measurements: it is that of the next block's nominal states then.
    pub moved: Column<f64, N>,
    /// How many measurements have been taken until its end.
    pub taken: usize,
}

/// The filter on its way.
pub struct Filter<'a> {
    nominal: &'a Trajectory,
    params: &'a Params<f64>,
    state: State<f64>,
    /// The error of the nominal states.
    x: Column<f64, N>,
    /// The blocks so far.
    pub steps: Vec<Step>,
    /// Their measurements.
    pub taken: Vec<Taken>,
    /// The columns of the covariance at the end of each block that are asked for, where it is.
    known: Option<Vec<[Column<f64, N>; ASKED]>>,
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

/// Blocks between two looks at whether to stop: some tenths of a millisecond.
const LOOK: usize = 64;

/// Filters and smooths the blocks about a nominal trajectory; `prior` are the states before the recording. None where the
/// numbers leave their range, and where it is told to stop.
pub fn smooth(
    blocks: &[Summed],
    nominal: &Trajectory,
    prior: &Column<f64, N>,
    params: &Params<f64>,
    covariances: bool,
    watch: &Watch,
) -> Option<Smoothed> {
    let mut filter = Filter::new(nominal, prior, params, blocks.len(), covariances)?;
    let start = filter.x;
    for (node, block) in blocks.iter().enumerate() {
        if node % LOOK == 0 && !watch.go_on() {
            return None;
        }
        filter.go_on(node, block)?;
    }
    let Filter { state, steps, mut taken, known, .. } = filter;

    // Back.
    let mut r: Column<f64, N> = zeros();
    let mut n: Square<f64, N> = zeros();
    let mut adjoints = Vec::with_capacity(blocks.len());
    let mut smoothed = Vec::with_capacity(known.as_ref().map_or(0, Vec::len));
    let mut known = known.into_iter().flatten().rev();
    for (index, step) in steps.iter().enumerate().rev() {
        if index % LOOK == 0 && !watch.go_on() {
            return None;
        }
        if let Some(known) = known.next() {
            smoothed.push(smoothed_covariance(&known, &n));
        }
        let before = index.checked_sub(1).and_then(|before| steps.get(before)).map_or(0, |step| step.taken);
        for taken in taken.drain(before..).rev() {
            taken.carry_back(&mut r);
            if covariances {
                taken.carry_covariance_back(&mut n);
            }
        }
        adjoints.push(r);
        step.transition.apply_transposed(&mut r);
        if covariances {
            times_transition(&mut n, &step.transition);
            n.transpose_mut();
            times_transition(&mut n, &step.transition);
        }
    }
    smoothed.reverse();

    // Forward again.
    let mut x = start;
    for (i, entry) in x.iter_mut().enumerate() {
        *entry += initial_variance(params, i) * r[i];
    }
    let nodes = blocks.len() + 1;
    let mut trajectory = Trajectory { quat: Vec::with_capacity(nodes), mean: Vec::with_capacity(nodes) };
    trajectory.put(nominal.at(0)?, &x)?;
    for (node, (step, adjoint)) in steps.iter().zip(adjoints.iter().rev()).enumerate() {
        step.transition.apply(&mut x);
        x += step.moved;
        for (start, noise) in step.noises {
            for i in start..start + 3 {
                x[i] += noise * adjoint[i];
            }
        }
        for (i, j, noise) in entries(step.lost.as_ref()) {
            x[THETA + i] += noise * adjoint[THETA + j];
        }
        trajectory.put(nominal.at(node + 1)?, &x)?;
    }
    Some(Smoothed { trajectory, last: Box::new(state.p), covariances: smoothed })
}

impl Trajectory {
    /// Adds a node: nominal states less their error; none where that is no number.
    fn put(&mut self, (q, mean): (Quat<f64>, &Column<f64, N>), x: &Column<f64, N>) -> Option<()> {
        let turn = exp_half(vec3(x, THETA) * 0.5);
        let mut mean = mean + x;
        for i in THETA..BIAS {
            mean[i] = 0.0;
        }
        self.quat.push((turn * q).unit_or(q));
        self.mean.push(mean);
        x.iter().all(|value| value.is_finite()).then_some(())
    }
}

impl<'a> Filter<'a> {
    /// Before the first of so many blocks.
    pub fn new(
        nominal: &'a Trajectory,
        prior: &Column<f64, N>,
        params: &'a Params<f64>,
        blocks: usize,
        covariances: bool,
    ) -> Option<Self> {
        let (_, first) = nominal.at(0)?;
        Some(Filter {
            nominal,
            params,
            state: State::new(params),
            x: prior - first,
            steps: Vec::with_capacity(blocks),
            taken: Vec::with_capacity(6 * blocks),
            known: covariances.then(|| Vec::with_capacity(blocks)),
        })
    }

    /// Predicts and corrects by one block; none where the numbers leave their range.
    pub fn go_on(&mut self, node: usize, block: &Summed) -> Option<()> {
        let (_, mean) = self.nominal.at(node)?;
        let (next, next_mean) = self.nominal.at(node + 1)?;
        let (params, sums) = (self.params, &block.sums);
        (self.state.q, self.state.mean) = (block.quat, *mean);
        let mut transition = Transition::new(true, sums, &self.state, params);
        let lost = lost(block);
        if lost.is_some() {
            // What such a rate says of the gyroscope's matrix is wrong.
            for entries in &mut transition.gyroscope {
                entries[MATRIX - BIAS..].fill(0.0);
            }
        }
        times_transposed_transition(&mut self.state.p, &transition);
        self.state.p.transpose_mut();
        times_transposed_transition(&mut self.state.p, &transition);
        let noises = transition.noises(sums, params);
        for (start, noise) in noises {
            for i in start..start + 3 {
                self.state.p[(i, i)] += noise;
            }
        }
        for (i, j, noise) in entries(lost.as_ref()) {
            self.state.p[(THETA + i, THETA + j)] += noise;
        }
        transition.apply(&mut self.x);
        transition.move_mean(true, &mut self.state, sums);

        // All of it: a part that moves has a rate that is no bias.
        let rests = sums.time < 1.001 * sums.rest;
        for row in measurement::velocity(true, rests, &self.state, sums.time, params) {
            self.take(&row);
        }
        if rests {
            for row in measurement::rest(true, sums.gyr * (1.0 / sums.time), &self.state, sums.time, params) {
                self.take(&row);
            }
        }
        if sums.fields > 0.0 && block.weight > SMALLEST_WEIGHT {
            let turning2 = sums.rate2 / sums.time;
            let noise2 = params.mag_noise * params.mag_noise + params.mag_rate_noise * params.mag_rate_noise * turning2;
            let rows = Seen::new(sums, &self.state).rows(true, &self.state, noise2 / (block.interval * block.weight));
            for row in rows {
                self.take(&self.level(row));
            }
        }

        // The error of the next nominal states instead of those to which this block leads.
        let mut moved = self.state.mean - next_mean;
        let turn = rotation_vector(block.quat * next.conj());
        (moved[0], moved[1], moved[2]) = (turn.x, turn.y, turn.z);
        self.x += moved;
        if let Some(known) = &mut self.known {
            known.push(std::array::from_fn(|i| self.state.p.column(THETA + i).into_owned()));
        }
        self.steps.push(Step { transition, noises, lost, moved, taken: self.taken.len() });
        let sound = |i: usize| self.x[i].is_finite() && (0.0..f64::INFINITY).contains(&self.state.p[(i, i)]);
        (0..N).all(sound).then_some(())
    }

    /// A measurement of the field without the inclination, which it is not to move: what the inclination does to it is noise.
    fn level(&self, mut row: Row<f64>) -> Row<f64> {
        for (&at, h) in row.at.iter().zip(&mut row.h) {
            if at < TURN {
                row.r += INCLINATION_NOISE * self.state.tilt_variance() * *h * *h;
                *h = 0.0;
            }
        }
        row
    }

    /// Takes a measurement z = h x + noise, unless the numbers leave their range.
    fn take(&mut self, row: &Row<f64>) {
        let (p, x) = (&mut self.state.p, &mut self.x);
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
            return;
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
        self.taken.push(Taken { row: *row, gain, nu_over_s, over_s });
    }
}

impl Taken {
    /// r := r + hᵀ(ν/s − Kᵀ r).
    fn carry_back(&self, r: &mut Column<f64, N>) {
        let more = self.nu_over_s - self.gain.dot(r);
        for (&at, &h) in self.row.at.iter().zip(&self.row.h) {
            r[at] += h * more;
        }
    }

    /// N := hᵀh/s + (I − K h)ᵀ N (I − K h).
    fn carry_covariance_back(&self, n: &mut Square<f64, N>) {
        let nk: Column<f64, N> = *n * self.gain;
        let more = self.over_s + nk.dot(&self.gain);
        for (&at, &h) in self.row.at.iter().zip(&self.row.h) {
            if h != 0.0 {
                for i in 0..N {
                    n[(i, at)] -= nk[i] * h;
                    n[(at, i)] -= nk[i] * h;
                }
            }
        }
        for (&j, &hj) in self.row.at.iter().zip(&self.row.h) {
            for (&i, &hi) in self.row.at.iter().zip(&self.row.h) {
                n[(i, j)] += hi * hj * more;
            }
        }
    }
}

/// The covariance of the turn that is lost where axes of the gyroscope are at the end of their range, or nobody saw it.
fn lost(block: &Summed) -> Option<Square<f64, 3>> {
    if block.lost <= 0.0 && block.clipped.iter().all(|time| *time <= 0.0) {
        return None;
    }
    let mut r = rows(block.sums.turn);
    for (axis, time) in block.clipped.iter().enumerate() {
        let angle = BEYOND_RANGE * time / block.sums.time;
        for i in 0..3 {
            r[(i, axis)] *= angle;
        }
    }
    let mut covariance = product(&r, &transposed(&r));
    for i in 0..3 {
        covariance[(i, i)] += block.lost;
    }
    Some(covariance)
}

/// The entries of a covariance, if there is one.
fn entries(covariance: Option<&Square<f64, 3>>) -> impl Iterator<Item = (usize, usize, f64)> {
    covariance.into_iter().flat_map(|p| (0..9).map(|k| (k % 3, k / 3, p[(k % 3, k / 3)])))
}

/// A := A Fᵀ, by the factors of F: half of the turn, the push, the other half.
fn times_transposed_transition(a: &mut Square<f64, N>, transition: &Transition<f64>) {
    let Transition { gyroscope, tilt, acc_bias, fall, kept } = transition;
    let turn = |a: &mut Square<f64, N>| {
        for (i, entries) in gyroscope.iter().enumerate() {
            for (k, entry) in entries.iter().enumerate() {
                add(a, THETA + i, BIAS + k, 0.5 * entry);
            }
        }
    };
    turn(a);
    for i in 0..3 {
        for k in 0..3 {
            add(a, VELOCITY + i, THETA + k, tilt[(i, k)]);
            add(a, VELOCITY + i, ACC_BIAS + k, acc_bias[(i, k)]);
        }
        scale(a, DISTURBANCE + i, *kept);
    }
    add(a, VELOCITY + 2, GRAVITY, *fall);
    turn(a);
}

/// A := A F, by the same factors.
fn times_transition(a: &mut Square<f64, N>, transition: &Transition<f64>) {
    let Transition { gyroscope, tilt, acc_bias, fall, kept } = transition;
    let turn = |a: &mut Square<f64, N>| {
        for (i, entries) in gyroscope.iter().enumerate() {
            for (k, entry) in entries.iter().enumerate() {
                add(a, BIAS + k, THETA + i, 0.5 * entry);
            }
        }
    };
    turn(a);
    add(a, GRAVITY, VELOCITY + 2, *fall);
    for i in 0..3 {
        for k in 0..3 {
            add(a, THETA + k, VELOCITY + i, tilt[(i, k)]);
            add(a, ACC_BIAS + k, VELOCITY + i, acc_bias[(i, k)]);
        }
        scale(a, DISTURBANCE + i, *kept);
    }
    turn(a);
}

/// Adds a multiple of a column to another one.
fn add(a: &mut Square<f64, N>, to: usize, from: usize, factor: f64) {
    for i in 0..N {
        a[(i, to)] += a[(i, from)] * factor;
    }
}

/// Takes a multiple of a column.
fn scale(a: &mut Square<f64, N>, column: usize, factor: f64) {
    for i in 0..N {
        a[(i, column)] *= factor;
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
    p
}
