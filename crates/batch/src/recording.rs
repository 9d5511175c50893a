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

/// The buffers of a tile of inputs.
struct Staged<T> {
    gyr: Vec<[T; 3]>,
    acc: Vec<[T; 3]>,
    mag: Vec<[T; 3]>,
    dt: Vec<T>,
}

/// Runs the stream over the recording.
pub fn run<T: Number>(stream: &mut dyn Stream<T>, recording: &Recording<'_, T>, outputs: &mut Outputs<'_, T>) {
    let total = recording.gyr.nrows();
    let mut staged = Staged { gyr: Vec::new(), acc: Vec::new(), mag: Vec::new(), dt: Vec::new() };
    let zero = T::zero();
    let mut quat = vec![[zero; 4]; TILE.min(total)];
    let mut gyr_bias = vec![[zero; 3]; if outputs.gyr_bias.is_some() { TILE.min(total) } else { 0 }];
    let mut status = vec![0; TILE.min(total)];
    let mut extra: Vec<_> = outputs.extra.iter().map(|(index, _)| (*index, Vec::new())).collect();

    for start in (0..total).step_by(TILE) {
        let end = total.min(start + TILE);
        let rows = s![start..end, ..];
        stage(&mut staged.gyr, &recording.gyr.slice(rows));
        if let Some(acc) = &recording.acc {
            stage(&mut staged.acc, &acc.slice(rows));
        }
        if let Some(mag) = &recording.mag {
            stage(&mut staged.mag, &mag.slice(rows));
        }
        stage_steps(&mut staged.dt, &recording.time, start, end);
        stream.run(&mut Tile {
            gyr: &staged.gyr,
            acc: recording.acc.as_ref().map(|_| staged.acc.as_slice()),
            mag: recording.mag.as_ref().map(|_| staged.mag.as_slice()),
            dt: &staged.dt,
            quat: &mut quat,
            gyr_bias: outputs.gyr_bias.as_ref().map(|_| gyr_bias.as_mut_slice()),
            status: &mut status,
            extra: &mut extra,
        });
        write_rows(outputs.quat.slice_mut(rows), &quat);
        if let Some(out) = &mut outputs.gyr_bias {
            write_rows(out.slice_mut(rows), &gyr_bias);
        }
        for (out, bits) in outputs.status.slice_mut(s![start..end]).iter_mut().zip(&status) {
            *out = *bits;
        }
        for ((_, out), (_, values)) in outputs.extra.iter_mut().zip(&extra) {
            for (out, value) in out.slice_mut(rows).iter_mut().zip(values) {
                *out = *value;
            }
        }
    }
}

/// Copies the rows of an array of any layout next to each other.
fn stage<T: Number>(buffer: &mut Vec<[T; 3]>, rows: &ArrayView2<'_, T>) {
    buffer.clear();
    if let Some(values) = rows.as_slice() {
        buffer.extend_from_slice(values.as_chunks::<3>().0);
    } else {
        let columns = (rows.index_axis(Axis(1), 0), rows.index_axis(Axis(1), 1), rows.index_axis(Axis(1), 2));
        buffer.extend(columns.0.iter().zip(columns.1).zip(columns.2).map(|((&x, &y), &z)| [x, y, z]));
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

/// Writes rows into an array of any layout.
fn write_rows<T: Number, const N: usize>(mut out: ArrayViewMut2<'_, T>, rows: &[[T; N]]) {
    if let Some(values) = out.as_slice_mut() {
        for (out, row) in values.as_chunks_mut::<N>().0.iter_mut().zip(rows) {
            *out = *row;
        }
    } else {
        for (mut out, row) in out.outer_iter_mut().zip(rows) {
            for (out, value) in out.iter_mut().zip(row) {
                *out = *value;
            }
        }
    }
}
