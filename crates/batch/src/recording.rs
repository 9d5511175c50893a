//! One recording through one filter: arrays of any layout, cut into tiles that stay in the cache.

use ndarray::{ArrayView1, ArrayView2, ArrayViewMut1, ArrayViewMut2, Axis, s};

use crate::registry::Number;
use crate::stream::{Stream, Tile};

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
    pub status: ArrayViewMut1<'a, u8>,
    /// Indices of further outputs of the filter with (T, values) arrays.
    pub extra: Vec<(usize, ArrayViewMut2<'a, T>)>,
}

/// Runs the stream over the recording.
pub fn run<T: Number>(stream: &mut dyn Stream<T>, recording: &Recording<'_, T>, outputs: &mut Outputs<'_, T>) {
    let total = recording.gyr.nrows();
    let (mut gyr, mut acc, mut mag) = (Vec::new(), Vec::new(), Vec::new());
    let mut dt = Vec::with_capacity(TILE.min(total));
    let (mut quat, mut gyr_bias, mut status) = (Vec::new(), Vec::new(), Vec::new());
    let mut extra: Vec<_> = outputs.extra.iter().map(|(index, _)| (*index, Vec::new())).collect();

    for start in (0..total).step_by(TILE) {
        let end = total.min(start + TILE);
        let rows = s![start..end, ..];
        stage_steps(&mut dt, &recording.time, start, end);
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
            status: room::<u8, 1>(&mut status, &mut status_out).as_flattened_mut(),
            extra: &mut extra,
        });
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

/// The steps to samples `start..end`. Stamps are subtracted in `f64` before anything is rounded.
fn stage_steps<T: Number>(buffer: &mut Vec<T>, time: &Time<'_>, start: usize, end: usize) {
    buffer.clear();
    if start == 0 {
        buffer.push(T::from_f64(time.first));
    }
    match &time.stamps {
        None => buffer.resize(end - start, T::from_f64(time.step)),
        Some(stamps) => {
            let before = stamps.slice(s![start.max(1) - 1..end - 1]);
            let after = stamps.slice(s![start.max(1)..end]);
            buffer.extend(before.iter().zip(after).map(|(before, after)| T::from_f64(after - before)));
        }
    }
}
