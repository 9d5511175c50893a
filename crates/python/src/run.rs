//! Whole recordings: from Python's arrays to jobs of the batch engine and back.

use ahrs_rs_batch::threads::{Job, run_all};
use ahrs_rs_batch::{Outputs, Recording, Stream, Time};
use ndarray::{ArrayViewMut2, ArrayViewMutD, Axis};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{
    Dtype, Fill, array, bad, check_apart, check_not_infinite, check_stamps, new_array, output, rows3, same_shape,
    stamps, start_quats,
};
use crate::filter::{Recipe, Snapshot};

/// What a run was called with.
pub struct Arguments<'a, 'py> {
    pub gyr: &'a Bound<'py, PyAny>,
    pub acc: Option<&'a Bound<'py, PyAny>>,
    pub mag: Option<&'a Bound<'py, PyAny>>,
    pub t: Option<&'a PyReadonlyArrayDyn<'py, f64>>,
    pub q0: Option<&'a Bound<'py, PyAny>>,
    pub states: Option<&'a [Snapshot]>,
    pub outputs: &'a [usize],
    pub out: Option<&'a Bound<'py, PyAny>>,
    pub threads: Option<usize>,
}

/// Runs the filter and gives (quat, `gyr_bias` or None, status, outputs, snapshots).
pub fn run<'py, T: Dtype>(
    py: Python<'py>,
    recipe: &Recipe,
    arguments: &Arguments<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let gyr = array::<T>("gyr", arguments.gyr)?;
    let acc = arguments.acc.map(|acc| array::<T>("acc", acc)).transpose()?;
    let mag = arguments.mag.map(|mag| array::<T>("mag", mag)).transpose()?;
    let shape = gyr.shape().to_vec();
    let gyr_rows = rows3("gyr", &gyr)?;
    let given = [("gyr", Some(&gyr)), ("acc", acc.as_ref()), ("mag", mag.as_ref())];
    for (name, other) in &given {
        if let Some(other) = other {
            same_shape(name, other.shape(), &shape)?;
        }
    }
    let views = given.map(|(name, array)| (name, array.map(|array| array.as_array())));
    py.detach(|| {
        views.iter().try_for_each(|(name, view)| view.as_ref().map_or(Ok(()), |view| check_not_infinite(name, view)))
    })
    .map_err(PyValueError::new_err)?;
    let acc_rows = acc.as_ref().map(|acc| rows3("acc", acc)).transpose()?;
    let mag_rows = mag.as_ref().map(|mag| rows3("mag", mag)).transpose()?;
    let (n, samples) = (gyr_rows.len_of(Axis(0)), gyr_rows.len_of(Axis(1)));

    let batch = (shape.len() == 3).then_some(n);
    if let Some(states) = arguments.states.filter(|states| states.len() != n) {
        return Err(bad("state", &format!("{n} states, one for each recording"), format!("{} states", states.len())));
    }
    let q0 = arguments.q0.map(|q0| start_quats::<T>(q0, batch)).transpose()?;
    let streams = streams(recipe, arguments, n, q0.as_deref())?;
    let times = times(recipe, arguments, &shape, samples, &streams)?;

    let spec = recipe.entry.spec;
    let leading = shape.split_last().map(|(_, leading)| leading.to_vec()).unwrap_or_default();
    let with = |row: &[usize]| -> Vec<usize> { leading.iter().chain(row).copied().collect() };
    let new = |row: &[usize], fill: Fill| new_array::<T>(py, fill, &with(row), T::DTYPE);
    let quat = match arguments.out {
        Some(out) => {
            for input in [Some(arguments.gyr), arguments.acc, arguments.mag, arguments.t.map(|t| t.as_any())] {
                check_apart(out, input)?;
            }
            output::<T>(out, &with(&[4]))?
        }
        None => new(&[4], Fill::Nothing)?,
    };
    let zero_bias = streams.iter().all(|stream| stream.bias_stays_zero());
    let bias_fill = if zero_bias { Fill::Zeros } else { Fill::Nothing };
    let gyr_bias = spec.gyr_bias.then(|| new(&[3], bias_fill)).transpose()?;
    let status = new_array::<u8>(py, Fill::Nothing, &leading, "uint8")?;
    let asked: Vec<_> =
        arguments.outputs.iter().filter_map(|&index| spec.outputs.get(index).map(|output| (index, output))).collect();
    let extra = asked.iter().map(|(_, output)| new(output.shape, Fill::Nothing)).collect::<PyResult<Vec<_>>>()?;

    let snapshots = {
        // Views of the results as (N, T, values), taken apart by recording.
        let mut quat = writing("out", &quat)?;
        let mut quat = rows_mut(quat.as_array_mut(), n, samples, 4)?.into_iter();
        let mut gyr_bias =
            gyr_bias.as_ref().filter(|_| !zero_bias).map(|array| writing("gyr_bias", array)).transpose()?;
        let mut gyr_bias = match &mut gyr_bias {
            Some(array) => rows_mut(array.as_array_mut(), n, samples, 3)?.into_iter().map(Some).collect(),
            None => Vec::new(),
        }
        .into_iter();
        let mut status = writing("status", &status)?;
        let mut status = rows_mut(status.as_array_mut(), n, samples, 1)?.into_iter();
        let mut extra = extra.iter().map(|array| writing("outputs", array)).collect::<PyResult<Vec<_>>>()?;
        let mut extra = extra
            .iter_mut()
            .zip(&asked)
            .map(|(array, (index, output))| {
                Ok((*index, rows_mut(array.as_array_mut(), n, samples, output.len())?.into_iter()))
            })
            .collect::<PyResult<Vec<_>>>()?;

        let mut jobs = Vec::with_capacity(n);
        for (index, (time, stream)) in times.into_iter().zip(streams).enumerate() {
            let (Some(quat), Some(status)) = (quat.next(), status.next()) else { break };
            jobs.push(Job {
                stream,
                recording: Recording {
                    gyr: gyr_rows.index_axis_move(Axis(0), index),
                    acc: acc_rows.map(|rows| rows.index_axis_move(Axis(0), index)),
                    mag: mag_rows.map(|rows| rows.index_axis_move(Axis(0), index)),
                    time,
                },
                outputs: Outputs {
                    quat,
                    gyr_bias: gyr_bias.next().flatten(),
                    status: status.index_axis_move(Axis(1), 0),
                    extra: extra.iter_mut().filter_map(|(index, rows)| Some((*index, rows.next()?))).collect(),
                },
            });
        }
        let threads = arguments.threads;
        py.detach(|| run_all(&mut jobs, threads));
        snapshots(&mut jobs, arguments.states, samples)
    };
    Ok((quat, gyr_bias, status, extra, snapshots).into_pyobject(py)?.into_any())
}

/// The array for writing; refused where something else uses it.
fn writing<'py, E: numpy::Element>(
    name: &str,
    array: &Bound<'py, PyArrayDyn<E>>,
) -> PyResult<PyReadwriteArrayDyn<'py, E>> {
    array.try_readwrite().map_err(|error| bad(name, "a writeable array that is no input", error))
}

/// An array (T, values...) or (N, T, values...) as the (T, values) parts of its recordings.
fn rows_mut<E>(
    view: ArrayViewMutD<'_, E>,
    n: usize,
    samples: usize,
    values: usize,
) -> PyResult<Vec<ArrayViewMut2<'_, E>>> {
    // An array of another layout than C's can only be one given as `out`, which has its axes already.
    let shaped = match (view.ndim(), values) {
        (2, 4) => view.insert_axis(Axis(0)).into_dimensionality(),
        (3, 4) => view.into_dimensionality(),
        _ => view.into_shape_with_order((n, samples, values)),
    };
    let mut rest = shaped.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let mut parts = Vec::with_capacity(n);
    for _ in 0..n {
        let (first, others) = rest.split_at(Axis(0), 1);
        parts.push(first.index_axis_move(Axis(0), 0));
        rest = others;
    }
    Ok(parts)
}

/// The filter of each recording, as it is before the first sample.
fn streams<T: Dtype>(
    recipe: &Recipe,
    arguments: &Arguments<'_, '_>,
    n: usize,
    q0: Option<&[[T; 4]]>,
) -> PyResult<Vec<Box<dyn Stream<T>>>> {
    let one = |index| {
        let mut stream = recipe.stream(arguments.states.and_then(|states| states.get(index)))?;
        if let Some(q0) = q0.and_then(|q0| q0.get(index)) {
            stream.start_from(*q0);
        }
        Ok(stream)
    };
    (0..n).map(one).collect()
}

/// The time of each recording, checked.
fn times<'a, T: Dtype>(
    recipe: &Recipe,
    arguments: &'a Arguments<'_, '_>,
    shape: &[usize],
    samples: usize,
    streams: &[Box<dyn Stream<T>>],
) -> PyResult<Vec<Time<'a>>> {
    let n = streams.len();
    let step = recipe.rate.map(|rate| 1.0 / rate);
    let stamps = arguments.t.map(|t| stamps(t, shape)).transpose()?;
    let Some(stamps) = stamps else {
        let step = match step {
            Some(step) => step,
            // Nothing to integrate over: an empty recording needs no time.
            None if samples == 0 => 0.0,
            None => return Err(bad("t", "stamps in s, as the filter was made without rate", "None")),
        };
        return Ok(vec![Time { stamps: None, first: step, step }; n]);
    };
    (0..n)
        .zip(streams)
        .map(|(index, stream)| {
            let row = stamps.index_axis_move(Axis(0), if stamps.nrows() == 1 { 0 } else { index });
            let last = arguments.states.and_then(|states| states.get(index)).and_then(|(_, last, _)| *last);
            check_stamps(row.iter().copied(), last).map_err(|error| {
                PyValueError::new_err(if n > 1 { format!("{error} of recording {index}") } else { error })
            })?;
            let mut ahead = row.iter().copied();
            let (t0, t1) = (ahead.next(), ahead.next());
            let first = match (last, step, t0, t1) {
                (Some(last), _, Some(t0), _) => t0 - last,
                (None, Some(step), _, _) => step,
                (None, None, Some(t0), Some(t1)) => t1 - t0,
                (None, None, Some(_), None) if !stream.is_fresh() => {
                    return Err(bad(
                        "rate",
                        "a rate in Hz: the step before a single sample is not known from t",
                        "None",
                    ));
                }
                _ => 0.0,
            };
            Ok(Time { stamps: Some(row), first, step: 0.0 })
        })
        .collect()
}

/// The states after the last sample.
fn snapshots<T: Dtype>(jobs: &mut [Job<'_, T>], before: Option<&[Snapshot]>, samples: usize) -> Vec<Snapshot> {
    let mut before = before.map(<[_]>::iter);
    jobs.iter_mut()
        .map(|job| {
            let (last, count) = before.as_mut().and_then(Iterator::next).map_or((None, 0), |(_, last, n)| (*last, *n));
            let last = match &job.recording.time.stamps {
                Some(stamps) => stamps.last().copied().or(last),
                None => last.map(|last| last + job.recording.time.step * samples as f64),
            };
            (job.stream.save(), last, count + samples as u64)
        })
        .collect()
}
