//! A filter in lanes: as many recordings, or parameter sets, as a vector register has numbers.

use ahrs_rs::params::{ParamError, ParamSet};
use ahrs_rs::{Estimator, Filter, Mask, Quat, Reading, Scalar, Settings, Vec3};

use crate::metric::{Metric, Sums};
use crate::prefetch::{PrefetchPlan, Prefetcher};
use crate::simd::{Instructions, Kernel, Vector};
use crate::transpose::{deinterleave, interleave};
use crate::{Number, is_small};

/// A run of samples of several recordings, and room for what comes out.
///
/// A row holds a sample of each lane, ordered by component, then lane: (x₀ x₁ … y₀ y₁ … z₀ z₁ …).
pub struct Rows<'a, T> {
    /// Angular rates in rad/s.
    pub gyr: &'a [T],
    /// Specific forces in m/s², as many, or none.
    pub acc: Option<&'a [T]>,
    /// Magnetic fields in µT, as many, or none.
    pub mag: Option<&'a [T]>,
    /// The time in s since the sample before, as many.
    pub dt: &'a [T],
    /// Attitudes out.
    pub quat: &'a mut [T],
    /// Gyroscope biases out, or none.
    pub gyr_bias: Option<&'a mut [T]>,
    /// Status bits out.
    pub status: &'a mut [u16],
    /// The memory of the next rows.
    pub prefetch: &'a PrefetchPlan,
}

/// A filter with several lanes.
pub trait Bank<T>: Send {
    /// How many.
    fn lanes(&self) -> usize;
    /// Gives a lane every variable of a filter, as `Stream::save` gave them.
    fn load(&mut self, lane: usize, variables: &[f64]);
    /// Every variable of a lane.
    fn save(&mut self, lane: usize) -> Vec<f64>;
    /// Goes on by the samples. Stops at the shortest of the slices.
    fn run(&mut self, rows: &mut Rows<'_, T>);
    /// Numbers of as many sources as lanes into the order of the lanes; each source holds as many as there is room for.
    fn interleave(&self, to: &mut [T], from: &[&[T]]);
    /// Numbers in the order of the lanes to the places of the first lanes.
    fn deinterleave(&self, from: &[T], to: &mut [&mut [T]]);
    /// Adds the squared errors of the attitudes of some rows against those of a reference to the sums of the lanes.
    fn score(&self, metric: Metric, quat: &[T], reference: &[Option<[T; 4]>], sums: &mut Sums);
}

/// The bank of filter `F` with parameters of its own in each lane; lanes beyond the last set have the first one's.
/// Choices are those of the first set.
pub fn bank<T, I, F>(instructions: I, sets: &[&[f64]], settings: Settings) -> Result<Box<dyn Bank<T>>, ParamError>
where
    T: Number,
    I: Instructions<T>,
    F: Filter<I::Vector> + Send + 'static,
{
    let params = F::Params::from_lanes(sets)?;
    Ok(Box::new(Lanes { instructions, estimator: Estimator::<I::Vector, F>::new(&params, settings) }))
}

struct Lanes<I, S: Scalar, F> {
    instructions: I,
    estimator: Estimator<S, F>,
}

impl<T, I, F> Bank<T> for Lanes<I, I::Vector, F>
where
    T: Number,
    I: Instructions<T>,
    F: Filter<I::Vector> + Send,
{
    fn lanes(&self) -> usize {
        I::Vector::LANES
    }

    fn load(&mut self, lane: usize, variables: &[f64]) {
        let mut variables = variables.iter();
        self.estimator.each_variable(&mut |value| {
            if let Some(&saved) = variables.next() {
                value.set_lane(lane, T::from_f64(saved));
            }
        });
    }

    fn save(&mut self, lane: usize) -> Vec<f64> {
        let mut variables = Vec::new();
        self.estimator.each_variable(&mut |value| variables.push(value.lane(lane).to_f64()));
        variables
    }

    fn run(&mut self, rows: &mut Rows<'_, T>) {
        let lanes = I::Vector::LANES;
        let acc = rows.acc.map_or(usize::MAX, |values| values.len() / (3 * lanes));
        let mag = rows.mag.map_or(usize::MAX, |values| values.len() / (3 * lanes));
        let (gyr, dt) = (rows.gyr.len() / (3 * lanes), rows.dt.len() / lanes);
        let end = gyr.min(dt).min(acc).min(mag).min(rows.quat.len() / (4 * lanes)).min(rows.status.len() / lanes);
        let mut prefetcher = rows.prefetch.spread_over(end);
        let (estimator, mut row) = (&mut self.estimator, 0);
        // What is rare is a kernel of its own, so that it costs the steps nothing.
        loop {
            let (prefetcher, at) = (&mut prefetcher, &mut row);
            self.instructions.run(Steps { estimator, rows, prefetcher, at });
            if row >= end {
                return;
            }
            self.instructions.run(Attention { estimator, rows, at: row });
        }
    }

    fn interleave(&self, to: &mut [T], from: &[&[T]]) {
        let done = self.instructions.interleave(to, from);
        interleave(to, from, done);
    }

    fn deinterleave(&self, from: &[T], to: &mut [&mut [T]]) {
        let done = self.instructions.deinterleave(from, to);
        deinterleave(from, I::Vector::LANES, to, done);
    }

    fn score(&self, metric: Metric, quat: &[T], reference: &[Option<[T; 4]>], sums: &mut Sums) {
        metric.score::<T, I>(self.instructions, quat, reference, sums);
    }
}

/// The steps from a row on, up to the end or to a row that needs attention first.
struct Steps<'a, 'b, 'c, S: Scalar, F> {
    estimator: &'a mut Estimator<S, F>,
    rows: &'a mut Rows<'b, S::Real>,
    prefetcher: &'a mut Prefetcher<'c>,
    at: &'a mut usize,
}

impl<S: Vector, F: Filter<S>> Kernel for Steps<'_, '_, '_, S, F> {
    #[inline(always)]
    fn run(self) {
        if const { is_small::<Estimator<S, F>, S>() } {
            let mut copy = self.estimator.clone();
            *self.at = steps(&mut copy, self.rows, self.prefetcher, *self.at);
            *self.estimator = copy;
        } else {
            *self.at = steps(self.estimator, self.rows, self.prefetcher, *self.at);
        }
    }
}

/// Gives the row at which it ended.
#[inline(always)]
fn steps<S: Vector, F: Filter<S>>(
    estimator: &mut Estimator<S, F>,
    rows: &mut Rows<'_, S::Real>,
    prefetcher: &mut Prefetcher<'_>,
    from: usize,
) -> usize {
    let lanes = S::LANES;
    let mut acc = rows.acc.map(|values| rest(values, 3 * lanes, from).chunks_exact(3 * lanes));
    let mut mag = rows.mag.map(|values| rest(values, 3 * lanes, from).chunks_exact(3 * lanes));
    let mut gyr_bias =
        rows.gyr_bias.as_mut().map(|values| rest_mut(values, 3 * lanes, from).chunks_exact_mut(3 * lanes));
    let gyr = rest(rows.gyr, 3 * lanes, from).chunks_exact(3 * lanes);
    let dt = rest(rows.dt, lanes, from).chunks_exact(lanes);
    let quat = rest_mut(rows.quat, 4 * lanes, from).chunks_exact_mut(4 * lanes);
    let status = rest_mut(rows.status, lanes, from).chunks_exact_mut(lanes);
    let mut at = from;
    for ((gyr, dt), (quat, status)) in gyr.zip(dt).zip(quat.zip(status)) {
        let acc = match acc.as_mut().and_then(Iterator::next) {
            Some(row) => Some(loaded3(row)),
            None => None,
        };
        let mag = match mag.as_mut().and_then(Iterator::next) {
            Some(row) => Some(loaded3(row)),
            None => None,
        };
        let (reading, dt) = (Reading::new(loaded3(gyr), acc, mag), S::load(dt));
        if estimator.needs_attention(&reading, dt) {
            break;
        }
        prefetcher.prefetch_row::<S>();
        let output = estimator.go_on(&reading, dt);
        let Quat { w, x, y, z } = output.quat;
        for (value, to) in [w, x, y, z].into_iter().zip(quat.chunks_exact_mut(lanes)) {
            value.store(to);
        }
        if output.flags.any().any() {
            for (lane, bits) in status.iter_mut().enumerate() {
                *bits = output.flags.bits(lane);
            }
        } else {
            status.fill(0);
        }
        if let Some(row) = gyr_bias.as_mut().and_then(Iterator::next) {
            let Vec3 { x, y, z } = estimator.filter().gyr_bias();
            for (value, to) in [x, y, z].into_iter().zip(row.chunks_exact_mut(lanes)) {
                value.store(to);
            }
        }
        at += 1;
    }
    at
}

/// What is done before the step of a row.
struct Attention<'a, 'b, S: Scalar, F> {
    estimator: &'a mut Estimator<S, F>,
    rows: &'a Rows<'b, S::Real>,
    at: usize,
}

impl<S: Vector, F: Filter<S>> Kernel for Attention<'_, '_, S, F> {
    #[inline(always)]
    fn run(self) {
        let row = |values| loaded3(rest(values, 3 * S::LANES, self.at));
        let reading = Reading::new(row(self.rows.gyr), self.rows.acc.map(row), self.rows.mag.map(row));
        self.estimator.attend(&reading, S::load(rest(self.rows.dt, S::LANES, self.at)));
    }
}

/// The rows from one on; none where there are fewer.
#[inline(always)]
fn rest<T>(values: &[T], width: usize, from: usize) -> &[T] {
    values.get(width * from..).unwrap_or_default()
}

#[inline(always)]
fn rest_mut<T>(values: &mut [T], width: usize, from: usize) -> &mut [T] {
    values.get_mut(width * from..).unwrap_or_default()
}

/// A vector in each lane.
#[inline(always)]
fn loaded3<S: Vector>(row: &[S::Real]) -> Vec3<S> {
    let (x, rest) = row.split_at_checked(S::LANES).unwrap_or_default();
    let (y, z) = rest.split_at_checked(S::LANES).unwrap_or_default();
    Vec3::new(S::load(x), S::load(y), S::load(z))
}
