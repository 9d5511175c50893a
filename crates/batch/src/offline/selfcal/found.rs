//! What `SelfCalSmoother` has found of a recording: the trajectory, from pass to pass, and what is reported of it.

use ahrs_rs::Quat;
use ahrs_rs::filters::kalman::{Column, Square, congruent, put_rows, reported, rows, transposed, zeros};
use ahrs_rs::filters::selfcal::Params as CausalParams;
use ahrs_rs::filters::selfcal::measurement::Seen;
use ahrs_rs::filters::selfcal::state::{
    ACC_BIAS, DELAY, DISTURBANCE, GRAVITY, HORIZONTAL, IRON, MATRIX, N, State, VELOCITY, VERTICAL,
};

use super::blocks::{Samples, Summed, Trajectory, rotation_vector, weigh};
use super::causal::Causal;
use super::median;
use super::smoother::{ASKED, smooth};
use crate::threads::Watch;

/// Gravity is that of the parameter as long as the specific force at rest is no further from it than this, in m/s²: beyond
/// that the accelerometer's scale is another one.
const LARGEST_ACC_BIAS: f64 = 0.1;

/// What has been found so far.
pub struct Found {
    pub trajectory: Trajectory,
    pub blocks: Vec<Summed>,
    prior: Column<f64, N>,
    last: Option<Box<Square<f64, N>>>,
    covariances: Vec<Square<f64, ASKED>>,
}

impl Found {
    /// The trajectory of the causal filter, with what it knew at the end, and the reference field that most blocks show.
    pub fn new(
        samples: &Samples,
        ends: &[usize],
        causal: &Causal,
        state: &mut State<f64>,
        params: &CausalParams<f64>,
    ) -> Self {
        let start = causal.quat.first().copied().unwrap_or(Quat::identity());
        let nodes = ends.iter().map(|&end| causal.quat.get(end - 1).copied().unwrap_or(Quat::identity()));
        let mut mean = causal.mean;
        for (from, len) in [(VELOCITY, 3), (DISTURBANCE, 3)] {
            for i in from..from + len {
                mean[i] = 0.0;
            }
        }
        let quat: Vec<_> = std::iter::once(start).chain(nodes).collect();
        let mut trajectory = Trajectory { mean: vec![mean; quat.len()], quat };
        let blocks = samples.sums(ends, &trajectory, state);
        let seen = blocks.iter().filter(|block| block.sums.fields > 0.0).map(|block| {
            state.mean = mean;
            let field = Seen::new(&block.sums, state).clean;
            (field.x.hypot(field.y), field.z)
        });
        let (across, up): (Vec<_>, Vec<_>) = seen.unzip();
        let (across, up) = (median(across), median(up));
        for mean in &mut trajectory.mean {
            (mean[HORIZONTAL], mean[VERTICAL]) = (across, up);
        }
        let mut prior = zeros();
        let still = samples.acc.iter().zip(&samples.rest).filter(|(_, rest)| **rest).filter_map(|(acc, _)| *acc);
        let still: Vec<_> = still.map(|acc| acc.norm2().sqrt()).collect();
        let norm = if still.is_empty() { params.gravity } else { median(still) };
        let gravity = if (norm - params.gravity).abs() < LARGEST_ACC_BIAS { params.gravity } else { norm };
        (prior[GRAVITY], prior[HORIZONTAL], prior[VERTICAL]) = (gravity, across, up);
        Found { trajectory, blocks, prior, last: None, covariances: Vec::new() }
    }

    /// Smooths once more, with the covariances or without; gives the largest correction of an attitude in rad. Where the
    /// numbers leave their range, or where it is told to stop, all stays as it is.
    pub fn smooth(
        &mut self,
        state: &mut State<f64>,
        params: &CausalParams<f64>,
        covariances: bool,
        watch: &Watch,
    ) -> f64 {
        weigh(&mut self.blocks, &self.trajectory, state, (params.mag_tolerance, params.mag_tail));
        let smoothed = smooth(&self.blocks, &self.trajectory, &self.prior, params, covariances, watch);
        let Some(smoothed) = smoothed else { return 0.0 };
        let turns = self.trajectory.quat.iter().zip(&smoothed.trajectory.quat);
        let largest2 = turns.map(|(&old, &new)| rotation_vector(new * old.conj()).norm2()).fold(0.0, f64::max);
        self.trajectory = smoothed.trajectory;
        self.last = Some(smoothed.last);
        self.covariances = smoothed.covariances;
        largest2.sqrt()
    }

    /// The values of an output of the description, one row after the other.
    pub fn output(&self, index: usize, ends: &[usize], (quats, headed): (&[Quat<f64>], bool), norm: f64) -> Vec<f64> {
        let sigma = |i: usize| self.last.as_ref().map_or(0.0, |p| p[(i, i)].max(0.0).sqrt());
        let mut values = Vec::new();
        let mut start = 0;
        for (block, &end) in ends.iter().enumerate() {
            let Some(mean) = self.trajectory.mean.get(block + 1) else { break };
            let covariance = self.covariances.get(block).copied().unwrap_or(Square::<f64, ASKED>::zeros());
            let mut row = Vec::new();
            match index {
                0 => {
                    let p = covariance.fixed_view::<3, 3>(0, 0).into_owned();
                    for q in quats.get(start..end).into_iter().flatten() {
                        let r = q.matrix();
                        let p = congruent(&transposed(&rows(r)), &p);
                        put_rows(&reported(&p, r.z, headed), &mut |value| values.push(value));
                    }
                }
                1 => row.push((3..ASKED).map(|i| covariance[(i, i)]).fold(0.0, f64::max).sqrt()),
                2 => row.extend((MATRIX..VELOCITY).map(|i| mean[i])),
                3 => row.extend((MATRIX..VELOCITY).map(sigma)),
                4 => row.extend((ACC_BIAS..GRAVITY).map(|i| mean[i])),
                5 => row.push(mean[DELAY]),
                6 => row.push(sigma(DELAY)),
                7 => row.extend((IRON..DISTURBANCE).map(|i| mean[i] * norm)),
                8 => row.extend((DISTURBANCE..HORIZONTAL).map(|i| mean[i] * norm)),
                9 => row.push(self.blocks.get(block).map_or(0.0, |block| block.weight)),
                _ => row.extend([HORIZONTAL, VERTICAL].map(|i| mean[i] * norm)),
            }
            if !row.is_empty() {
                for _ in start..end {
                    values.extend(&row);
                }
            }
            start = end;
        }
        values
    }
}
