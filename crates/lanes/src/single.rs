//! One filter as a bank of one lane, for what is written over banks.

use crate::Number;
use crate::bank::{Bank, Rows};
use crate::metric::{Metric, Sums};
use crate::simd::ScalarIsa;
use crate::stream::{Stream, Tile};
use crate::transpose::{deinterleave, interleave};

/// A filter alone as a bank of one lane.
pub struct Single<T>(pub Box<dyn Stream<T>>);

impl<T: Number> Bank<T> for Single<T> {
    fn lanes(&self) -> usize {
        1
    }

    fn load(&mut self, _lane: usize, variables: &[f64]) {
        self.0.load(variables);
    }

    fn save(&mut self, _lane: usize) -> Vec<f64> {
        self.0.save()
    }

    fn run(&mut self, rows: &mut Rows<'_, T>) {
        self.0.run(&mut Tile {
            gyr: rows.gyr.as_chunks().0,
            acc: rows.acc.map(|values| values.as_chunks().0),
            mag: rows.mag.map(|values| values.as_chunks().0),
            dt: rows.dt,
            quat: rows.quat.as_chunks_mut().0,
            gyr_bias: rows.gyr_bias.as_mut().map(|values| values.as_chunks_mut().0),
            status: rows.status,
            extra: &mut [],
        });
    }

    fn interleave(&self, to: &mut [T], from: &[&[T]]) {
        interleave(to, from, 0);
    }

    fn deinterleave(&self, from: &[T], to: &mut [&mut [T]]) {
        deinterleave(from, 1, to, 0);
    }

    fn score(&self, metric: Metric, quat: &[T], reference: &[Option<[T; 4]>], sums: &mut Sums) {
        metric.score::<T, _>(ScalarIsa, quat, reference, sums);
    }
}
