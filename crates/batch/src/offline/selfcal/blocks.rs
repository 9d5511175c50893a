//! The samples of a recording as the smoother takes them, and the sums over blocks of them about a nominal trajectory.

#![allow(clippy::indexing_slicing, reason = "matrices with sizes as types; every index is a constant below them")]

use ahrs_rs::filters::kalman::Column;
use ahrs_rs::filters::rest::{Rest, Thresholds};
use ahrs_rs::filters::selfcal::block::{Block, LONGEST_INTERVAL, Steps, bounded_rate};
use ahrs_rs::filters::selfcal::magnetic::{HEADING_SHARE, LARGEST_DEVIATION, weight};
use ahrs_rs::filters::selfcal::measurement::Seen;
use ahrs_rs::filters::selfcal::state::{DELAY, N, State};
use ahrs_rs::filters::selfcal::{BLOCK, LONGEST_FIELD};
use ahrs_rs::so3::exp_half;
use ahrs_rs::trig::atan2;
use ahrs_rs::{Quat, Vec3};

use crate::offline::Row;

/// The samples of a recording.
#[derive(Default)]
pub struct Samples {
    /// Angular rates in rad/s: where rows are missing, the held ones.
    pub rates: Vec<Vec3<f64>>,
    /// The time in s since the sample before; zero for the first one, which only aligns.
    pub steps: Vec<f64>,
    /// The variance in rad² of the rotation that was lost in the step: nobody saw it.
    pub lost: Vec<f64>,
    /// Specific forces in m/s².
    pub acc: Vec<Row>,
    /// Fields, in norms of the median one.
    pub mag: Vec<Row>,
    /// Where the sensor rests.
    pub rest: Vec<bool>,
    /// Where an axis of the gyroscope is at the end of its range.
    pub clipped: Vec<[bool; 3]>,
}

/// The estimate of all states at the ends of the blocks: one more than there are blocks.
#[derive(Clone)]
pub struct Trajectory {
    /// The attitudes.
    pub quat: Vec<Quat<f64>>,
    /// The other states, zeros in the place of the attitude's error.
    pub mean: Vec<Column<f64, N>>,
}

impl Trajectory {
    /// The attitude and the states at the start of a block.
    pub fn at(&self, node: usize) -> Option<(Quat<f64>, &Column<f64, N>)> {
        Some((*self.quat.get(node)?, self.mean.get(node)?))
    }
}

/// A block about the nominal trajectory.
pub struct Summed {
    /// The sums.
    pub sums: Block<f64>,
    /// The attitude at its end to which the angular rate leads.
    pub quat: Quat<f64>,
    /// The time in s for which its field counts.
    pub interval: f64,
    /// The weight of its field.
    pub weight: f64,
    /// The time in s for which each axis of the gyroscope is at the end of its range.
    pub clipped: [f64; 3],
    /// The variance in rad² of the rotation that was lost.
    pub lost: f64,
}

impl Samples {
    /// Where the blocks end: the index after the last sample of each.
    pub fn block_ends(&self) -> Vec<usize> {
        let mut ends = Vec::new();
        let mut time = 0.0;
        for (index, &dt) in self.steps.iter().enumerate() {
            time += dt;
            // With a spare, so that the rounding of a stamp moves no end.
            if dt > 0.0 && BLOCK - 1e-9 <= time + 0.5 * dt {
                ends.push(index + 1);
                time = 0.0;
            }
        }
        if ends.last().copied().unwrap_or(0) < self.steps.len() {
            ends.push(self.steps.len());
        }
        ends
    }

    /// Finds where the sensor rests: where forward or backward in time it has been still for long enough.
    pub fn find_rest(&mut self, limits: &Thresholds<f64>, bias: Vec3<f64>) {
        let (rates, acc) = (&self.rates, &self.acc);
        let forward = detected(limits, bias, rates.iter().zip(acc).zip(self.steps.iter().copied()));
        // Seen from the end, a sample comes after the step that the next one ends.
        let back = std::iter::once(0.0).chain(self.steps.iter().skip(1).rev().copied());
        let backward = detected(limits, bias, rates.iter().zip(acc).rev().zip(back));
        self.rest = forward.iter().zip(backward.iter().rev()).map(|(a, b)| a | b).collect();
    }

    /// Finds where an axis of the gyroscope is at the end of its range: the given one, or where it is zero the largest rate
    /// of the recording, if the axis is not only near it but stays there.
    pub fn find_clipped(&mut self, range: f64) {
        self.clipped = vec![[false; 3]; self.rates.len()];
        for axis in 0..3 {
            let rates = self.rates.iter().map(|rate| [rate.x, rate.y, rate.z].get(axis).map_or(0.0, |x| x.abs()));
            let rates: Vec<f64> = rates.collect();
            let largest = if range > 0.0 { range } else { rates.iter().copied().fold(0.0, f64::max) };
            let at_the_end = |rate: &f64| *rate > AT_THE_END * largest;
            let staying =
                || rates.chunk_by(|a, b| at_the_end(a) == at_the_end(b)).filter(|run| run.iter().all(at_the_end));
            let stays: usize = staying().map(<[f64]>::len).filter(|&len| len >= CLIPPED_SAMPLES).sum();
            let near = rates.iter().filter(|&&rate| rate > NEAR_THE_END * largest).count();
            if range > 0.0 || (largest > SMALLEST_RANGE && near as f64 <= NEAR_FOR_EACH * stays as f64) {
                for (clipped, rate) in self.clipped.iter_mut().zip(&rates) {
                    if let Some(clipped) = clipped.get_mut(axis) {
                        *clipped = at_the_end(rate);
                    }
                }
            }
        }
    }

    /// The sums of all blocks about a trajectory, with their weights.
    pub fn sums(&self, ends: &[usize], nominal: &Trajectory, state: &mut State<f64>) -> Vec<Summed> {
        let mut blocks = Vec::with_capacity(ends.len());
        let mut steps = Steps::new();
        let mut acc_interval = 0.0;
        let mut interval: f64 = 0.0;
        let mut start = 0;
        for (node, &end) in ends.iter().enumerate() {
            let Some((q, mean)) = nominal.at(node) else { break };
            (state.q, state.mean) = (q, *mean);
            let mut sums = Block::new();
            let rows = start..end;
            let sensors =
                self.acc.get(rows.clone()).into_iter().flatten().zip(self.mag.get(rows.clone()).into_iter().flatten());
            let rest = self.rest.get(rows.clone()).into_iter().flatten();
            let rest = rest.zip(self.clipped.get(rows.clone()).into_iter().flatten());
            let mut clipped = [0.0; 3];
            let steps_of = self.steps.get(rows.clone()).into_iter().flatten();
            let steps_of = steps_of.zip(self.lost.get(rows.clone()).into_iter().flatten());
            let rates = self.rates.get(rows).into_iter().flatten().zip(steps_of);
            let mut lost = 0.0;
            for (((&gyr, (&dt, &loses)), (acc, mag)), (&rest, ends)) in rates.zip(sensors).zip(rest) {
                let (rate, turning) = state.advance(gyr, dt);
                let r = state.q.matrix();
                let turning = bounded_rate(turning);
                // A rotation that was lost shows nothing of the gyroscope.
                sums.turns(r, gyr, rate, turning, [if loses > 0.0 { 0.0 } else { dt }, dt]);
                lost += loses;
                sums.slip += steps.slip(turning, dt);
                acc_interval = LONGEST_INTERVAL.min(acc_interval + dt);
                if let Some(acc) = *acc {
                    sums.pushes(true, r, acc, state, acc_interval);
                    acc_interval = 0.0;
                }
                if rest {
                    sums.rest += dt;
                }
                for (time, &end) in clipped.iter_mut().zip(ends) {
                    *time += if end { dt } else { 0.0 };
                }
                if let Some(mag) = *mag {
                    sums.points(true, r, mag, turning, state.mean[DELAY]);
                }
            }
            interval = LONGEST_FIELD.min(interval + sums.time);
            blocks.push(Summed { quat: state.q.renormalized(), interval, weight: 1.0, clipped, lost, sums });
            if blocks.last().is_some_and(|block| block.sums.fields > 0.0) {
                interval = 0.0;
            }
            start = end;
        }
        blocks
    }

    /// The attitudes of all samples along a trajectory: what the angular rate does not explain of a block is spread over it
    /// in proportion to the time.
    pub fn attitudes(
        &self,
        ends: &[usize],
        trajectory: &Trajectory,
        state: &mut State<f64>,
        latency: f64,
    ) -> Vec<Quat<f64>> {
        let mut quats: Vec<Quat<f64>> = Vec::with_capacity(self.steps.len());
        let mut turns = Vec::new();
        let mut start = 0;
        for (node, &end) in ends.iter().enumerate() {
            let (Some((q, mean)), Some((next, _))) = (trajectory.at(node), trajectory.at(node + 1)) else { break };
            (state.q, state.mean) = (q, *mean);
            let mut time = 0.0;
            turns.clear();
            let rates = self.rates.get(start..end).into_iter().flatten();
            for (&gyr, &dt) in rates.zip(self.steps.get(start..end).into_iter().flatten()) {
                let (_, turning) = state.advance(gyr, dt);
                time += dt;
                turns.push((state.q, turning, time));
            }
            let rest = rotation_vector(next * state.q.conj());
            for &(q, turning, until) in &turns {
                let part = if time > 0.0 { until / time } else { 0.0 };
                let q = exp_half(rest * (0.5 * part)) * q;
                let q = if latency == 0.0 { q } else { q * exp_half(bounded_rate(turning) * (0.5 * latency)) };
                quats.push(q.unit_or(Quat::identity()));
            }
            start = end;
        }
        quats
    }
}

/// Where the sensor rests, in one direction of time.
fn detected<'a>(
    limits: &Thresholds<f64>,
    bias: Vec3<f64>,
    samples: impl Iterator<Item = ((&'a Vec3<f64>, &'a Row), f64)>,
) -> Vec<bool> {
    let mut detector = Rest::new();
    let mut interval = 0.0;
    samples
        .map(|((&rate, acc), dt)| {
            interval = LONGEST_INTERVAL.min(interval + dt);
            let value = acc.unwrap_or(Vec3::zero());
            let still = detector.step((rate, dt), (value, acc.is_some(), interval), limits);
            if acc.is_some() {
                interval = 0.0;
            }
            still & ((detector.rate() - bias).norm2() < limits.gyr * limits.gyr)
        })
        .collect()
}

/// Sets the weight of every field: that of its deviation from the reference, or of the mean deviation around it where that is
/// larger.
pub fn weigh(blocks: &mut [Summed], nominal: &Trajectory, state: &mut State<f64>, (tolerance, tail): (f64, f64)) {
    let mut fields: Vec<_> = Vec::with_capacity(blocks.len());
    for (node, block) in blocks.iter_mut().enumerate() {
        let Some((_, mean)) = nominal.at(node) else { break };
        if block.sums.fields > 0.0 {
            state.mean = *mean;
            let off = Seen::new(&block.sums, state).deviation2(HEADING_SHARE).sqrt().min(LARGEST_DEVIATION);
            fields.push((block, off));
        }
    }
    let offs: Vec<f64> = fields.iter().map(|(_, off)| *off).collect();
    for (index, (block, off)) in fields.into_iter().enumerate() {
        let around = offs.get(index.saturating_sub(AROUND)..(index + AROUND + 1).min(offs.len())).unwrap_or_default();
        block.weight = weight(off.max(around.iter().sum::<f64>() / around.len().max(1) as f64), tolerance, tail);
    }
}

/// An axis of the gyroscope is at the end of its range from this part of it on.
const AT_THE_END: f64 = 0.995;
/// The end is found where the axis stays there for so many samples, again and again: of a smooth peak twice as many samples
/// are within 2 % as within 0.5 % of it, of a cut one hardly more.
const CLIPPED_SAMPLES: usize = 3;
const NEAR_THE_END: f64 = 0.98;
const NEAR_FOR_EACH: f64 = 1.5;
/// No gyroscope has a smaller range, in rad/s.
const SMALLEST_RANGE: f64 = 2.0;
/// How many blocks on either side count for the mean deviation: 0.25 s.
const AROUND: usize = 2;

/// The rotation vector of a unit quaternion, in rad, of at most half a turn.
pub fn rotation_vector(q: Quat<f64>) -> Vec3<f64> {
    let q = if q.w < 0.0 { -q } else { q };
    let sin = q.vector().norm2().sqrt();
    let factor = if sin < 1e-9 { 2.0 } else { 2.0 * atan2(sin, q.w) / sin };
    q.vector() * factor
}
