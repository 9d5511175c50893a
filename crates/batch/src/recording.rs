//! One recording through one filter: arrays of any layout, cut into tiles that stay in the cache.

use ahrs_rs::status;
use ndarray::{ArrayView1, ArrayView2, ArrayViewMut1, ArrayViewMut2, Axis, s};

use crate::registry::Number;
use crate::threads::Watch;
use ahrs_rs_lanes::stream::{Stream, Tile};

/// Samples in a tile: its buffers fit the first-level cache, and the cost of a call per tile vanishes.
const TILE: usize = 256;

/// When the samples were taken.
#[derive(Clone, Copy)]
pub struct Time<'a> {
    /// The stamps in s, not decreasing, or none for a constant step.
    pub stamps: Option<ArrayView1<'a, f64>>,
    /// The time in s that the first sample comes after the start.
    pub first: f64,
    /// The constant step in s where there are no stamps.
    pub step: f64,
}

/// The measurements of one recording; rows are samples.
#[derive(Clone, Copy)]
pub struct Recording<'a, T> {
    /// (T, 3) angular rates in rad/s.
    pub gyr: ArrayView2<'a, T>,
    /// (T, 3) specific forces in m/s².
    pub acc: Option<ArrayView2<'a, T>>,
    /// (T, 3) magnetic fields in µT.
    pub mag: Option<ArrayView2<'a, T>>,
    /// When.
    pub time: Time<'a>,
}

/// Room for the results of one recording; rows are samples.
pub struct Outputs<'a, T> {
    /// (T, 4) attitudes.
    pub quat: ArrayViewMut2<'a, T>,
    /// (T, 3) biases in rad/s.
    pub gyr_bias: Option<ArrayViewMut2<'a, T>>,
    /// (T,) status bits.
    pub status: ArrayViewMut1<'a, u16>,
    /// Indices of further outputs of the filter with (T, values) arrays.
    pub extra: Vec<(usize, ArrayViewMut2<'a, T>)>,
}

impl Time<'_> {
    /// Appends the steps to samples `start..end`. Stamps are subtracted in `f64` before anything is rounded.
    pub fn steps<T: Number>(&self, steps: &mut Vec<T>, start: usize, end: usize) {
        if start >= end {
            return;
        }
        let before = steps.len();
        if start == 0 {
            steps.push(T::from_f64(self.first));
        }
        match &self.stamps {
            None => steps.resize(before + end - start, T::from_f64(self.step)),
            Some(stamps) => {
                let before = stamps.slice(s![start.max(1) - 1..end.max(1) - 1]);
                let after = stamps.slice(s![start.max(1)..end.max(1)]);
                steps.extend(before.iter().zip(after).map(|(before, after)| T::from_f64(after - before)));
            }
        }
    }
}

/// All status bits of a tile, in the buffer or in the array itself.
fn status_of(buffer: &[[u16; 1]], out: &ArrayViewMut2<'_, u16>) -> u16 {
    let bits = |all: u16, status: &u16| all | status;
    if buffer.is_empty() { out.iter().fold(0, bits) } else { buffer.as_flattened().iter().fold(0, bits) }
}

/// Whether a measurement of samples `start..end` is infinite.
pub fn sensors_infinite<T: Number>(recording: &Recording<'_, T>, start: usize, end: usize) -> bool {
    let sensors = [Some(recording.gyr), recording.acc, recording.mag];
    sensors.into_iter().flatten().any(|view| match view.slice_move(s![start..end, ..]) {
        part if part.is_standard_layout() => any_infinite(part.to_slice().unwrap_or_default()),
        part => part.iter().any(|value| any_infinite(&[*value])),
    })
}

/// Whether one of the values is infinite; NaN is a missing value.
fn any_infinite<T: Number>(values: &[T]) -> bool {
    // Reducing without a branch is several times as fast as stopping at the first.
    values.iter().fold(false, |any, value| any | T::splat(T::MAX).lt(value.abs()))
}

/// Runs the stream over the recording from sample `from` on, until the end or until it is told to stop; true where a
/// measurement is infinite, which the filters take for missing.
pub fn run_from<T: Number>(
    stream: &mut dyn Stream<T>,
    recording: &Recording<'_, T>,
    outputs: &mut Outputs<'_, T>,
    from: usize,
    watch: &Watch,
) -> bool {
    let total = recording.gyr.nrows();
    let (mut gyr, mut acc, mut mag) = (Vec::new(), Vec::new(), Vec::new());
    let mut dt = Vec::with_capacity(TILE.min(total));
    let (mut quat, mut gyr_bias, mut status) = (Vec::new(), Vec::new(), Vec::new());
    let mut extra: Vec<_> = outputs.extra.iter().map(|(index, _)| (*index, Vec::new())).collect();

    let mut infinite = false;
    for start in (from..total).step_by(TILE) {
        if !watch.go_on() {
            return infinite;
        }
        let end = total.min(start + TILE);
        let rows = s![start..end, ..];
        dt.clear();
        recording.time.steps(&mut dt, start, end);
        let mut quat_out = outputs.quat.slice_mut(rows);
        let mut bias_out = outputs.gyr_bias.as_mut().map(|out| out.slice_mut(rows));
        let mut status_out = outputs.status.slice_mut(s![start..end]).insert_axis(Axis(1));
        stream.run(&mut Tile {
            gyr: staged(&mut gyr, &recording.gyr.slice_move(rows)),
            acc: recording.acc.map(|view| staged(&mut acc, &view.slice_move(rows))),
            mag: recording.mag.map(|view| staged(&mut mag, &view.slice_move(rows))),
            dt: &dt,
            quat: room(&mut quat, &mut quat_out),
            gyr_bias: bias_out.as_mut().map(|out| room(&mut gyr_bias, out)),
            status: room::<u16, 1>(&mut status, &mut status_out).as_flattened_mut(),
            extra: &mut extra,
        });
        let missing = status_of(&status, &status_out);
        if missing & status::ANY_MISSING != 0 && sensors_infinite(recording, start, end) {
            infinite = true;
        }
        write_back(&quat, &mut quat_out);
        if let Some(out) = &mut bias_out {
            write_back(&gyr_bias, out);
        }
        write_back(&status, &mut status_out);
        for ((_, out), (_, values)) in outputs.extra.iter_mut().zip(&extra) {
            for (out, value) in out.slice_mut(rows).iter_mut().zip(values) {
                *out = *value;
            }
        }
    }
    infinite
}

/// The rows of an array next to each other: where they lie, or copied into the buffer.
fn staged<'a, T: Number>(buffer: &'a mut Vec<[T; 3]>, rows: &ArrayView2<'a, T>) -> &'a [[T; 3]] {
    if let Some(values) = rows.to_slice() {
        return values.as_chunks::<3>().0;
    }
    buffer.clear();
    buffer.extend(rows.outer_iter().map(|row| {
        let mut values = row.iter().copied();
        [(); 3].map(|()| values.next().unwrap_or(T::zero()))
    }));
    buffer
}

/// Room for the rows of an array next to each other: in the array itself, or in the buffer until `write_back`.
fn room<'a, E: Copy + Default, const N: usize>(
    buffer: &'a mut Vec<[E; N]>,
    out: &'a mut ArrayViewMut2<'_, E>,
) -> &'a mut [[E; N]] {
    let rows = out.nrows();
    buffer.clear();
    if let Some(values) = out.as_slice_mut() {
        return values.as_chunks_mut::<N>().0;
    }
    buffer.resize(rows, [E::default(); N]);
    buffer
}

/// Writes what stands in the buffer, if the array had no room of its own.
fn write_back<E: Copy, const N: usize>(buffer: &[[E; N]], out: &mut ArrayViewMut2<'_, E>) {
    for (mut out, row) in out.outer_iter_mut().zip(buffer) {
        for (out, value) in out.iter_mut().zip(row) {
            *out = *value;
        }
    }
}
