//! Whole recordings: from Python's arrays to jobs of the batch engine and back.

use ahrs_rs_batch::simd::Isa;
use ahrs_rs_batch::threads::{Job, Plan, run_all};
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
use crate::watch::watched;

/// What a run is called with in Python: (gyr, acc, mag, t, q0, states, outputs, out).
pub type Call<'py> = (
    Bound<'py, PyAny>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Vec<Snapshot>>,
    Vec<usize>,
    Option<Bound<'py, PyAny>>,
);

/// How calls are run.
pub struct Way<'a, 'py> {
    pub threads: Option<usize>,
    /// Called with the number of recordings that are finished.
    pub progress: Option<&'a Bound<'py, PyAny>>,
    /// Whether the first call that is wrong ends all.
    pub raising: bool,
}

/// Runs the filter over the recordings of each call, all of them at once. Each gives (quat, `gyr_bias` or None, status,
/// outputs, snapshots), or the exception that says what is wrong with it.
pub fn run_calls<'py, T: Dtype>(
    py: Python<'py>,
    recipe: &Recipe,
    calls: &[Call<'py>],
    way: &Way<'_, 'py>,
) -> PyResult<Vec<PyResult<Bound<'py, PyAny>>>> {
    let mut prepared = Vec::with_capacity(calls.len());
    for call in calls {
        match Prepared::<T>::new(py, recipe, call) {
            Err(error) if way.raising => return Err(error),
            made => prepared.push(made),
        }
    }
    let mut rooms: Vec<_> = prepared.iter().filter_map(|made| made.as_ref().ok().map(Prepared::room)).collect();
    let mut jobs = Vec::new();
    let mut counts = Vec::new();
    for (room, made) in rooms.iter_mut().zip(prepared.iter().flatten()) {
        let before = jobs.len();
        jobs.extend(made.jobs(recipe, room.as_mut().map_err(|error| error.clone_ref(py))?)?);
        counts.push(jobs.len() - before);
    }
    let plan = Plan {
        entry: recipe.entry,
        values: &recipe.values,
        settings: recipe.settings,
        isa: Isa::fastest(),
        threads: way.threads,
    };
    let samples = jobs.iter().map(|job| job.recording.gyr.nrows()).sum();
    let ((), error) = watched(py, samples, way.progress, |watch| run_all(&mut jobs, &plan, watch))?;
    if let Some(error) = error {
        return Err(error);
    }
    let mut jobs = jobs.iter_mut();
    let mut ends = Vec::with_capacity(counts.len());
    for (&count, made) in counts.iter().zip(prepared.iter().flatten()) {
        let own: Vec<_> = jobs.by_ref().take(count).collect();
        // Where a filter took an infinite value for missing it is looked for.
        let finite = if own.iter().any(|job| job.infinite) { made.check_finite(py) } else { Ok(()) };
        match finite {
            Err(error) if way.raising => return Err(error),
            finite => ends.push(finite.map(|()| made.snapshots(own.into_iter()))),
        }
    }
    drop(rooms);
    let mut ends = ends.into_iter();
    Ok(prepared
        .into_iter()
        .map(|made| {
            let Prepared { quat, gyr_bias, status, extra, .. } = made?;
            let after = ends.next().unwrap_or_else(|| Ok(Vec::new()))?;
            Ok((quat, gyr_bias, status, extra, after).into_pyobject(py)?.into_any())
        })
        .collect())
}

/// A call whose arguments are checked, with arrays for its results.
struct Prepared<'py, T: Dtype> {
    gyr: PyReadonlyArrayDyn<'py, T>,
    acc: Option<PyReadonlyArrayDyn<'py, T>>,
    mag: Option<PyReadonlyArrayDyn<'py, T>>,
    t: Option<PyReadonlyArrayDyn<'py, f64>>,
    q0: Option<Vec<[T; 4]>>,
    states: Option<Vec<Snapshot>>,
    n: usize,
    samples: usize,
    zero_bias: bool,
    quat: Bound<'py, PyArrayDyn<T>>,
    gyr_bias: Option<Bound<'py, PyArrayDyn<T>>>,
    status: Bound<'py, PyArrayDyn<u8>>,
    extra: Vec<Bound<'py, PyArrayDyn<T>>>,
    /// Indices of the outputs that are asked for, and their sizes.
    asked: Vec<(usize, usize)>,
}

/// The arrays of the results while they are written.
struct Room<'py, T: Dtype> {
    quat: PyReadwriteArrayDyn<'py, T>,
    gyr_bias: Option<PyReadwriteArrayDyn<'py, T>>,
    status: PyReadwriteArrayDyn<'py, u8>,
    extra: Vec<PyReadwriteArrayDyn<'py, T>>,
}

impl<'py, T: Dtype> Prepared<'py, T> {
    fn new(py: Python<'py>, recipe: &Recipe, call: &Call<'py>) -> PyResult<Self> {
        let (gyr_given, acc_given, mag_given, t_given, q0, states, outputs, out) = call;
        let t = t_given.as_ref().map(|t| array::<f64>("t", t)).transpose()?;
        let gyr = array::<T>("gyr", gyr_given)?;
        let acc = acc_given.as_ref().map(|acc| array::<T>("acc", acc)).transpose()?;
        let mag = mag_given.as_ref().map(|mag| array::<T>("mag", mag)).transpose()?;
        let shape = gyr.shape().to_vec();
        let rows = rows3("gyr", &gyr)?;
        let (n, samples) = (rows.len_of(Axis(0)), rows.len_of(Axis(1)));
        for (name, other) in [("acc", &acc), ("mag", &mag)] {
            if let Some(other) = other {
                same_shape(name, other.shape(), &shape)?;
            }
        }
        if let Some(states) = states.as_ref().filter(|states| states.len() != n) {
            let came = format!("{} states", states.len());
            return Err(bad("state", &format!("{n} states, one for each recording"), came));
        }
        let q0 = q0.as_ref().map(|q0| start_quats::<T>(q0, (shape.len() == 3).then_some(n))).transpose()?;

        let spec = recipe.entry.spec;
        let leading = shape.split_last().map(|(_, leading)| leading.to_vec()).unwrap_or_default();
        let with = |row: &[usize]| -> Vec<usize> { leading.iter().chain(row).copied().collect() };
        let new = |row: &[usize], fill: Fill| new_array::<T>(py, fill, &with(row), T::DTYPE);
        let quat = match out {
            Some(out) => {
                for input in [Some(gyr_given), acc_given.as_ref(), mag_given.as_ref(), t.as_deref().map(Bound::as_any)]
                {
                    check_apart(out, input)?;
                }
                output::<T>(out, &with(&[4]))?
            }
            None => new(&[4], Fill::Nothing)?,
        };
        let asked: Vec<_> =
            outputs.iter().filter_map(|&index| spec.outputs.get(index).map(|output| (index, output))).collect();
        let extra = asked.iter().map(|(_, output)| new(output.shape, Fill::Nothing)).collect::<PyResult<Vec<_>>>()?;
        let asked = asked.into_iter().map(|(index, output)| (index, output.len())).collect();
        let status = new_array::<u8>(py, Fill::Nothing, &leading, "uint8")?;
        let mut made = Prepared {
            gyr,
            acc,
            mag,
            t,
            q0,
            states: states.clone(),
            n,
            samples,
            zero_bias: false,
            quat,
            gyr_bias: None,
            status,
            extra,
            asked,
        };
        let streams = made.streams(recipe)?;
        made.times(recipe, &streams)?;
        made.zero_bias = streams.iter().all(|stream| stream.bias_stays_zero());
        let fill = if made.zero_bias { Fill::Zeros } else { Fill::Nothing };
        made.gyr_bias = spec.gyr_bias.then(|| new(&[3], fill)).transpose()?;
        Ok(made)
    }

    /// Checks that no measurement is infinite.
    fn check_finite(&self, py: Python<'py>) -> PyResult<()> {
        let given = [("gyr", Some(&self.gyr)), ("acc", self.acc.as_ref()), ("mag", self.mag.as_ref())];
        let views = given.map(|(name, array)| (name, array.map(|array| array.as_array())));
        py.detach(|| {
            views
                .iter()
                .try_for_each(|(name, view)| view.as_ref().map_or(Ok(()), |view| check_not_infinite(name, view)))
        })
        .map_err(PyValueError::new_err)
    }

    fn room(&self) -> PyResult<Room<'py, T>> {
        let bias = self.gyr_bias.as_ref().filter(|_| !self.zero_bias);
        Ok(Room {
            quat: writing("out", &self.quat)?,
            gyr_bias: bias.map(|array| writing("gyr_bias", array)).transpose()?,
            status: writing("status", &self.status)?,
            extra: self.extra.iter().map(|array| writing("outputs", array)).collect::<PyResult<_>>()?,
        })
    }

    /// A job for each recording.
    fn jobs<'a>(&'a self, recipe: &Recipe, room: &'a mut Room<'py, T>) -> PyResult<Vec<Job<'a, T>>> {
        let (n, samples) = (self.n, self.samples);
        let gyr_rows = rows3("gyr", &self.gyr)?;
        let acc_rows = self.acc.as_ref().map(|acc| rows3("acc", acc)).transpose()?;
        let mag_rows = self.mag.as_ref().map(|mag| rows3("mag", mag)).transpose()?;
        let streams = self.streams(recipe)?;
        let times = self.times(recipe, &streams)?;
        // Views of the results as (N, T, values), taken apart by recording.
        let mut quat = rows_mut(room.quat.as_array_mut(), n, samples, 4)?.into_iter();
        let mut gyr_bias = match &mut room.gyr_bias {
            Some(array) => rows_mut(array.as_array_mut(), n, samples, 3)?.into_iter().map(Some).collect(),
            None => Vec::new(),
        }
        .into_iter();
        let mut status = rows_mut(room.status.as_array_mut(), n, samples, 1)?.into_iter();
        let extra = room.extra.iter_mut().zip(&self.asked);
        let mut extra = extra
            .map(|(array, (index, len))| Ok((*index, rows_mut(array.as_array_mut(), n, samples, *len)?.into_iter())))
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
                infinite: false,
            });
        }
        Ok(jobs)
    }

    /// The filter of each recording, as it is before the first sample.
    fn streams(&self, recipe: &Recipe) -> PyResult<Vec<Box<dyn Stream<T>>>> {
        let one = |index| {
            let mut stream = recipe.stream(self.states.as_ref().and_then(|states| states.get(index)))?;
            if let Some(q0) = self.q0.as_ref().and_then(|q0| q0.get(index)) {
                stream.start_from(*q0);
            }
            Ok(stream)
        };
        (0..self.n).map(one).collect()
    }

    /// The time of each recording, checked.
    fn times(&self, recipe: &Recipe, streams: &[Box<dyn Stream<T>>]) -> PyResult<Vec<Time<'_>>> {
        let (n, samples) = (self.n, self.samples);
        let step = recipe.rate.map(|rate| 1.0 / rate);
        let stamps = self.t.as_ref().map(|t| stamps(t, self.gyr.shape())).transpose()?;
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
                let last = self.states.as_ref().and_then(|states| states.get(index)).and_then(|(_, last, _)| *last);
                check_stamps(row.iter().copied(), last).map_err(|error| {
                    PyValueError::new_err(if n > 1 { format!("{error} of recording {index}") } else { error })
                })?;
                let mut ahead = row.iter().copied();
                let (t0, t1) = (ahead.next(), ahead.next());
                let first = match (last, step, t0, t1) {
                    (Some(last), _, Some(t0), _) => t0 - last,
                    (None, Some(step), _, _) => step,
                    // Without a given attitude nothing is known of a time before the first stamp.
                    (None, None, Some(_), _) if stream.is_fresh() => 0.0,
                    (None, None, Some(t0), Some(t1)) => t1 - t0,
                    (None, None, Some(_), None) => {
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
    fn snapshots<'a, 'b: 'a>(&self, jobs: impl Iterator<Item = &'a mut Job<'b, T>>) -> Vec<Snapshot> {
        let mut before = self.states.as_ref().map(|states| states.iter());
        jobs.map(|job| {
            let (last, count) = before.as_mut().and_then(Iterator::next).map_or((None, 0), |(_, last, n)| (*last, *n));
            let last = match &job.recording.time.stamps {
                Some(stamps) => stamps.last().copied().or(last),
                None => last.map(|last| last + job.recording.time.step * self.samples as f64),
            };
            (job.stream.save(), last, count + self.samples as u64)
        })
        .collect()
    }
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
