//! The low-pass filter over arrays.

use ahrs_rs::signal::Butterworth;
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
    let design = Butterworth::<T>::new(order, T::from_f64(cutoff));
    let design = design.map_err(|error| PyValueError::new_err(error.to_string()))?;
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
                    (Some(row), None) if rate.is_none() => row.iter().nth(1).map_or(0.0, |next| next - row[0]),
                    _ => rate.map_or(0.0, f64::recip),
                };
                let mut filters = filters(&design, channels, &variables)?;
                match stamps {
                    Some(stamps) => {
                        let steps = stamps.clone().zip(stamps.skip(1)).map(|(before, after)| after - before);
                        each_row(&mut filters, x, out, std::iter::once(first).chain(steps));
                    }
                    None => each_row(&mut filters, x, out, std::iter::repeat(first)),
                }
                let last =
                    row.map_or(last.map(|last| last + samples as f64 * first), |row| row.last().copied().or(last));
                let mut saved = Vec::with_capacity(variables.len());
                filters.iter_mut().for_each(|filter| filter.each(&mut |variable| saved.push(variable.to_f64())));
                Ok((saved, last))
            })
            .collect::<Result<Vec<Snapshot>, String>>()
    });
    let after = after.map_err(PyValueError::new_err)?;
    drop(out_values);
    Ok((out.into_any(), after))
}

/// A filter for each channel, going on from the variables where there are some.
fn filters<T: Dtype>(
    design: &Butterworth<T>,
    channels: usize,
    variables: &[f64],
) -> Result<Vec<Butterworth<T>>, String> {
    let mut filters = vec![design.clone(); channels];
    if !variables.is_empty() {
        let mut count = 0;
        filters.iter_mut().for_each(|filter| filter.each(&mut |_| count += 1));
        if count != variables.len() || !variables.iter().all(|value| value.is_finite()) {
            return Err(format!("state: expected {count} finite variables, got {}", variables.len()));
        }
        let mut saved = variables.iter();
        filters.iter_mut().for_each(|filter| {
            filter.each(&mut |variable| *variable = T::from_f64(saved.next().copied().unwrap_or(0.0)));
        });
    }
    Ok(filters)
}

/// A row in which a channel is no measurement is none in the others either.
fn each_row<T: Dtype>(
    filters: &mut [Butterworth<T>],
    x: ArrayView2<'_, T>,
    mut out: ArrayViewMut2<'_, T>,
    steps: impl Iterator<Item = f64>,
) {
    let usable = |x: &T| (*x * *x).le(T::MAX);
    for ((x, mut y), dt) in x.rows().into_iter().zip(out.rows_mut()).zip(steps) {
        let (measured, dt) = (x.iter().all(usable), T::from_f64(dt));
        for ((filter, x), y) in filters.iter_mut().zip(x).zip(&mut y) {
            *y = filter.step(if measured { *x } else { T::NAN }, dt);
        }
    }
}
