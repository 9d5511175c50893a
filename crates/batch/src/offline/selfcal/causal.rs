//! What the causal filter says of a recording, and what it could have said had it known of its losses before.
//!
//! Where the causal filter has lost the attitude and found it again, the trajectory about which the smoother is linear would be
//! wrong for the time between. The attitude that was found is turned back by the gyroscope: to the loss where the data tell of it;
//! else to the sample that forces and fields say, and that one is a loss from then on.

use ahrs_rs::filters::kalman::Column;
use ahrs_rs::filters::selfcal::state::N;
use ahrs_rs::so3::exp_half;
use ahrs_rs::{Quat, Vec3};

use super::blocks::{Samples, rotation_vector};

/// The longest time in s over which an attitude is turned back.
const LONGEST: f64 = 60.0;
/// A loss of which no data tell is somewhere within this time in s of where it was found.
const LOSS_TIME: f64 = 0.25;

/// What the causal filter says of a recording.
pub struct Causal {
    pub quat: Vec<Quat<f64>>,
    /// Status bits of what the recording lacks.
    pub missing: Vec<u16>,
    /// Where the attitude was found again.
    pub findings: Vec<Finding>,
    /// The states at the end.
    pub mean: Column<f64, N>,
}

/// An attitude that was found again.
pub struct Finding {
    /// The sample before whose step it was.
    pub index: usize,
    /// The gyroscope's bias there.
    pub bias: Vec3<f64>,
    /// The sample before whose step it was seen to be lost, where no data had told.
    pub unnoticed: Option<usize>,
}

impl Causal {
    /// Turns back what was found.
    pub fn turn_back(&mut self, samples: &mut Samples) {
        let mut earliest = 0;
        for finding in &self.findings {
            let turned = turned_back(&self.quat, samples, finding, earliest);
            let first = finding.index - turned.len();
            let start = match finding.unnoticed {
                None => first,
                Some(seen) => {
                    let split = split(&self.quat, &turned, samples, first, seen.min(finding.index));
                    if let (Some(&before), Some(&after)) = (self.quat.get(split), turned.get(split - first))
                        && split > first
                    {
                        lose(samples, split, rotation_vector(after * before.conj()).norm2());
                    }
                    split
                }
            };
            let turned = turned.get(start - first..).unwrap_or_default();
            for (quat, &turned) in self.quat.iter_mut().skip(start).zip(turned) {
                *quat = turned;
            }
            earliest = finding.index;
        }
    }
}

/// The attitudes before the sample of a finding: from the sample at the end of the last loss on, where it was told of, and not
/// before the earliest sample.
fn turned_back(quat: &[Quat<f64>], samples: &Samples, finding: &Finding, earliest: usize) -> Vec<Quat<f64>> {
    let mut turned = Vec::new();
    let Some(&(mut q)) = quat.get(finding.index) else { return turned };
    let steps = samples.rates.iter().zip(&samples.steps).zip(&samples.lost).take(finding.index + 1).skip(earliest + 1);
    let mut time = 0.0;
    for ((&rate, &dt), &lost) in steps.rev() {
        time += dt;
        if (finding.unnoticed.is_none() && lost > 0.0) || time > LONGEST {
            break;
        }
        q = (q * exp_half((rate - finding.bias) * (-0.5 * dt))).renormalized();
        turned.push(q);
    }
    turned.reverse();
    turned
}

/// The sample from which on the attitudes that were turned back fit the measurements better, and before which the others do.
fn split(quat: &[Quat<f64>], turned: &[Quat<f64>], samples: &Samples, first: usize, last: usize) -> usize {
    let (mut cost, mut least, mut best) = (0.0, 0.0, first);
    for (index, (&before, &after)) in quat.iter().skip(first).zip(turned).enumerate() {
        let index = first + index;
        if index >= last {
            break;
        }
        cost += misfit(samples, index, before) - misfit(samples, index, after);
        if cost < least {
            (least, best) = (cost, index + 1);
        }
    }
    best.min(first + turned.len().saturating_sub(1)).max(first)
}

/// How far the directions of force and field are from the vertical and from the plane of the meridian.
fn misfit(samples: &Samples, index: usize, q: Quat<f64>) -> f64 {
    let row = |rows: &[Option<Vec3<f64>>]| rows.get(index).copied().flatten();
    let force = row(&samples.acc).map_or(0.0, |force| {
        let up = q.rotate(force.unit());
        2.0 - 2.0 * up.z
    });
    let field = row(&samples.mag).map_or(0.0, |field| {
        let field = q.rotate(field.unit());
        let across = field.x.hypot(field.y);
        // The square of the horizontal part that is not north.
        2.0 * across * (across - field.y)
    });
    force + field
}

/// A loss of this variance in rad² around a sample.
fn lose(samples: &mut Samples, at: usize, variance: f64) {
    let mut around = Vec::new();
    for back in [false, true] {
        let mut time = 0.0;
        let mut index = if back { at.checked_sub(1) } else { Some(at) };
        while let Some(i) = index.filter(|_| time < LOSS_TIME) {
            let Some(dt) = samples.steps.get(i) else { break };
            time += dt;
            around.push(i);
            index = if back { i.checked_sub(1) } else { Some(i + 1) };
        }
    }
    // Each half may be all of it.
    let each = 2.0 * variance / around.len().max(1) as f64;
    for index in around {
        if let Some(lost) = samples.lost.get_mut(index) {
            *lost += each;
        }
    }
}
