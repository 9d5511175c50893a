//! The low-pass filter over arrays.

use ahrs_rs::signal::Butterworth;
use ahrs_rs::signal::butterworth::is_measurement;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use numpy::{PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Dtype, Fill, array, bad, check_not_infinite, check_stamps, is_f32, new_array, signals, stamps};

/// What goes on of one recording: all variables, channel after channel, and the last stamp in s where stamps were given.
type Snapshot = (Vec<f64>, Option<f64>);

/// Filters x, (T,), (T, C) or (N, T, C), by a Butterworth low-pass of an order and a cut-off frequency in Hz, from the
/// snapshots on where there are some: (filtered, snapshots).
#[pyfunction]
#[pyo3(signature = (x, order, cutoff, rate=None, t=None, snapshots=None))]
pub fn low_pass<'py>(
    x: &Bound<'py, PyAny>,
    order: usize,
    cutoff: f64,
    rate: Option<f64>,
    t: Option<&Bound<'py, PyAny>>,
    snapshots: Option<Vec<Snapshot>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Snapshot>)> {
    let run = if is_f32("x", x)? { run::<f32> } else { run::<f64> };
    run(x, order, cutoff, rate, t, snapshots)
}

fn run<'py, T: Dtype>(
    x: &Bound<'py, PyAny>,
    order: usize,
    cutoff: f64,
    rate: Option<f64>,
    t: Option<&Bound<'py, PyAny>>,
    snapshots: Option<Vec<Snapshot>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Snapshot>)> {
    let py = x.py();
    let design = (order, T::from_f64(cutoff));
    Butterworth::<T>::new(order, design.1).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let values = array::<T>("x", x)?;
    let shape = values.shape().to_vec();
    let values = signals("x", &values)?;
    let (n, samples, channels) = values.dim();
    let times = t.map(|t| array::<f64>("t", t)).transpose()?;
    let leading = if shape.len() == 3 { vec![n, samples, channels] } else { vec![samples, channels] };
    let times = times.as_ref().map(|times| stamps(times, &leading)).transpose()?;
    let snapshots = match snapshots {
        Some(snapshots) if snapshots.len() == n => snapshots,
        Some(snapshots) => return Err(bad("state", &format!("{n} snapshots"), snapshots.len())),
        None => vec![(Vec::new(), None); n],
    };
    let out = new_array::<T>(py, Fill::Nothing, &shape, T::DTYPE)?;
    let mut out_values = out.try_readwrite().map_err(|error| bad("x", "an array of its own", error))?;
    let mut out_view = out_values.as_array_mut().into_shape_with_order((n, samples, channels));
    let out_view = out_view.as_mut().map_err(|error| bad("x", "a plain shape", error))?;
    let after = py.detach(|| {
        check_not_infinite("x", &values.view().into_dyn())?;
        let rows = values.axis_iter(Axis(0)).zip(out_view.axis_iter_mut(Axis(0))).zip(snapshots);
        rows.enumerate()
            .map(|(index, ((x, out), (variables, last)))| {
                // Stamps of one recording are those of all, unless there are as many rows of them.
                let row = times.as_ref().map(|times| times.row(if times.nrows() == 1 { 0 } else { index }));
                let stamps = row.as_ref().map(|row| row.iter().copied());
                check_stamps(stamps.clone().into_iter().flatten(), last)?;
                let first = match (&row, last) {
                    (Some(row), Some(last)) => row.first().map_or(0.0, |first| first - last),
                    (Some(row), None) if rate.is_none() => {
                        row.iter().zip(row.iter().skip(1)).next().map_or(0.0, |(first, second)| second - first)
                    }
                    _ => rate.map_or(0.0, f64::recip),
                };
                let mut saved = Vec::with_capacity(variables.len());
                match stamps {
                    Some(stamps) => {
                        let steps = stamps.clone().zip(stamps.skip(1)).map(|(before, after)| after - before);
                        let steps = std::iter::once(first).chain(steps);
                        each_channel(&design, x, out, &steps, &variables, &mut saved)?;
                    }
                    None => each_channel(&design, x, out, &std::iter::repeat(first), &variables, &mut saved)?,
                }
                let last =
                    row.map_or(last.map(|last| last + samples as f64 * first), |row| row.last().copied().or(last));
                Ok((saved, last))
            })
            .collect::<Result<Vec<Snapshot>, String>>()
    });
    let after = after.map_err(PyValueError::new_err)?;
    drop(out_values);
    Ok((out.into_any(), after))
}

/// What a recording is filtered by: order and cut-off frequency in Hz.
type Design<T> = (usize, T);

/// Filters the channels of one recording, three at a time (they share what depends on the step), then one at a time.
fn each_channel<T: Dtype>(
    design: &Design<T>,
    x: ArrayView2<'_, T>,
    mut out: ArrayViewMut2<'_, T>,
    steps: &(impl Iterator<Item = f64> + Clone),
    variables: &[f64],
    saved: &mut Vec<f64>,
) -> Result<(), String> {
    let (channels, mut first) = (x.ncols(), 0);
    let mut variables = variables.iter().copied();
    let goes_on = variables.len() > 0;
    while first < channels {
        let left = goes_on.then_some(&mut variables);
        if channels - first >= 3 {
            group::<T, 3>(design, first, x, out.view_mut(), steps.clone(), left, saved)?;
            first += 3;
        } else {
            group::<T, 1>(design, first, x, out.view_mut(), steps.clone(), left, saved)?;
            first += 1;
        }
    }
    if variables.next().is_some() { Err(wrong_state()) } else { Ok(()) }
}

fn wrong_state() -> String {
    "state: expected finite variables, as many as the channels of x have, got others".to_owned()
}

/// Filters N channels from the first one on, going on from the variables where there are some.
fn group<T: Dtype, const N: usize>(
    &(order, cutoff): &Design<T>,
    first: usize,
    x: ArrayView2<'_, T>,
    mut out: ArrayViewMut2<'_, T>,
    steps: impl Iterator<Item = f64>,
    variables: Option<&mut impl Iterator<Item = f64>>,
    saved: &mut Vec<f64>,
) -> Result<(), String> {
    let mut filter = Butterworth::<T, N>::new(order, cutoff).map_err(|error| error.to_string())?;
    if let Some(variables) = variables {
        let mut fits = true;
        filter.each(&mut |variable| match variables.next().filter(|value| value.is_finite()) {
            Some(value) => *variable = T::from_f64(value),
            None => fits = false,
        });
        if !fits {
            return Err(wrong_state());
        }
    }
    for ((x, mut y), dt) in x.rows().into_iter().zip(out.rows_mut()).zip(steps) {
        let mut values = [T::NAN; N];
        // A row in which a channel is no measurement is none in the others either.
        if x.iter().all(|x| is_measurement(*x)) {
            values.iter_mut().zip(x.iter().skip(first)).for_each(|(value, x)| *value = *x);
        }
        let filtered = filter.step_lanes(true, values, T::from_f64(dt));
        y.iter_mut().skip(first).zip(filtered).for_each(|(y, filtered)| *y = filtered);
    }
    filter.each(&mut |variable| saved.push(variable.to_f64()));
    Ok(())
}
