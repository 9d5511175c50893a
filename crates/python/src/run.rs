//! Whole recordings: from Python's arrays to jobs of the batch engine and back.

use ahrs_rs_batch::isa;
use ahrs_rs_batch::threads::{Job, Plan, Watch, run_all};
use ahrs_rs_batch::{Offline, Outputs, Recording, Stream, Time, offline};
use ndarray::{ArrayViewMut2, ArrayViewMutD, Axis};
use numpy::{BorrowError, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{
    Dtype, Fill, array, bad, check_apart, check_not_infinite, check_stamps, copy_into, new_array, output, rows3,
    same_shape, stamps, start_quats,
};
use crate::filter::{Kind, Recipe, Snapshot};
use crate::watch::{panicked, watched};

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
    apart(py, &mut prepared, way)?;
    let mut rooms: Vec<_> = prepared.iter().filter_map(|made| made.as_ref().ok().map(Prepared::room)).collect();
    let given = rooms.iter_mut().zip(prepared.iter().flatten());
    let ends = match recipe.kind {
        Kind::Streaming(entry) => {
            let plan = Plan {
                entry,
                values: &recipe.values,
                settings: recipe.settings,
                isa: isa::chosen().unwrap_or_default(),
                threads: way.threads,
            };
            let (mut jobs, counts) = all_jobs(py, recipe, given, Prepared::streams)?;
            finished(py, way, &mut jobs, 1, |jobs, watch| run_all(jobs, &plan, watch))?;
            ends(py, way, &prepared, &mut jobs, &counts, Prepared::snapshots)?
        }
        Kind::Offline(entry) => {
            let filters =
                |made: &Prepared<'py, T>, recipe: &Recipe| (0..made.n).map(|_| recipe.offline(entry)).collect();
            let (mut jobs, counts) = all_jobs::<T, dyn Offline>(py, recipe, given, filters)?;
            let threads = way.threads;
            finished(py, way, &mut jobs, OFFLINE, |jobs, watch| offline::run_all(jobs, threads, watch))?;
            ends(py, way, &prepared, &mut jobs, &counts, |_, _| Vec::new())?
        }
    };
    drop(rooms);
    let mut ends = ends.into_iter();
    Ok(prepared
        .into_iter()
        .map(|made| {
            let Prepared { quat, gyr_bias, status, extra, out, .. } = made?;
            let after = ends.next().unwrap_or_else(|| Ok(Vec::new()))?;
            if let Some(out) = out {
                copy_into(&out, &quat)?;
            }
            Ok((quat, gyr_bias, status, extra, after).into_pyobject(py)?.into_any())
        })
        .collect())
}

/// Gives every call a room of its own for its attitudes, whose `out` lies in one block of memory with inputs: columns of one
/// table, which share no element. They are copied when all is computed. An `out` that shares one with another call is refused.
fn apart<'py, T: Dtype>(
    py: Python<'py>,
    prepared: &mut [PyResult<Prepared<'py, T>>],
    way: &Way<'_, 'py>,
) -> PyResult<()> {
    for index in 0..prepared.len() {
        let Some(Ok(made)) = prepared.get(index) else { continue };
        if !matches!(made.quat.try_readwrite(), Err(BorrowError::AlreadyBorrowed)) {
            continue;
        }
        let mut others = prepared.iter().enumerate().filter(|(other, _)| *other != index);
        let apart = others.try_for_each(|(_, other)| match other {
            Ok(other) => other.arrays().into_iter().try_for_each(|array| check_apart(made.quat.as_any(), Some(array))),
            Err(_) => Ok(()),
        });
        let room = apart.and_then(|()| new_array::<T>(py, Fill::Nothing, made.quat.shape(), T::DTYPE));
        match (room, prepared.get_mut(index)) {
            (Ok(room), Some(Ok(made))) => made.out = Some(std::mem::replace(&mut made.quat, room)),
            (Err(error), _) if way.raising => return Err(error),
            (Err(error), Some(made)) => *made = Err(error),
            _ => (),
        }
    }
    Ok(())
}

/// The jobs of all calls, and how many there are of each call.
type Jobs<'a, T, F> = (Vec<Job<'a, T, F>>, Vec<usize>);

/// The jobs of all calls with their filters.
fn all_jobs<'a, 'py: 'a, T: Dtype, F: ?Sized>(
    py: Python<'py>,
    recipe: &Recipe,
    calls: impl Iterator<Item = (&'a mut PyResult<Room<'py, T>>, &'a Prepared<'py, T>)>,
    filters: impl Fn(&Prepared<'py, T>, &Recipe) -> PyResult<Vec<Box<F>>>,
) -> PyResult<Jobs<'a, T, F>> {
    let (mut jobs, mut counts) = (Vec::new(), Vec::new());
    for (room, made) in calls {
        let before = jobs.len();
        jobs.extend(made.jobs(recipe, room.as_mut().map_err(|error| error.clone_ref(py))?, filters(made, recipe)?)?);
        counts.push(jobs.len() - before);
    }
    Ok((jobs, counts))
}

/// A sample of an offline filter takes as long as so many of a streaming one.
const OFFLINE: usize = 10;

/// Runs the jobs under watch until they are done; `cost` is the time of a sample beside that of a streaming filter.
fn finished<'py, T: Dtype, F: ?Sized + Send>(
    py: Python<'py>,
    way: &Way<'_, 'py>,
    jobs: &mut [Job<'_, T, F>],
    cost: usize,
    run: impl FnOnce(&mut [Job<'_, T, F>], &Watch) + Send,
) -> PyResult<()> {
    let samples: usize = jobs.iter().map(|job| job.recording.gyr.nrows()).sum();
    let ((), error) = watched(py, samples.saturating_mul(cost), way.progress, |watch| run(jobs, watch))?;
    error.map_or(Ok(()), Err)
}

/// The states after the last sample of each call, or what was wrong with its measurements.
fn ends<'py, T: Dtype, F: ?Sized>(
    py: Python<'py>,
    way: &Way<'_, 'py>,
    prepared: &[PyResult<Prepared<'py, T>>],
    jobs: &mut [Job<'_, T, F>],
    counts: &[usize],
    snapshots: impl Fn(&Prepared<'py, T>, &mut [Job<'_, T, F>]) -> Vec<Snapshot>,
) -> PyResult<Vec<PyResult<Vec<Snapshot>>>> {
    let mut rest = jobs;
    let mut all = Vec::with_capacity(counts.len());
    for (&count, made) in counts.iter().zip(prepared.iter().flatten()) {
        let (own, others) = rest.split_at_mut_checked(count).unwrap_or_default();
        rest = others;
        // Where a filter took an infinite value for missing it is looked for.
        let right = match own.iter().find_map(|job| job.panicked.as_ref()) {
            Some(text) => Err(panicked(text)),
            None if own.iter().any(|job| job.infinite) => made.check_finite(py),
            None => Ok(()),
        };
        match right {
            Err(error) if way.raising => return Err(error),
            right => all.push(right.map(|()| snapshots(made, own))),
        }
    }
    Ok(all)
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
    /// Into which the attitudes are copied at the end, where they cannot be written into it at once.
    out: Option<Bound<'py, PyArrayDyn<T>>>,
    gyr_bias: Option<Bound<'py, PyArrayDyn<T>>>,
    status: Bound<'py, PyArrayDyn<u16>>,
    extra: Vec<Bound<'py, PyArrayDyn<T>>>,
    /// Indices of the outputs that are asked for, and their sizes.
    asked: Vec<(usize, usize)>,
}

/// The arrays of the results while they are written.
struct Room<'py, T: Dtype> {
    quat: PyReadwriteArrayDyn<'py, T>,
    gyr_bias: Option<PyReadwriteArrayDyn<'py, T>>,
    status: PyReadwriteArrayDyn<'py, u16>,
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

        let spec = recipe.kind.spec();
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
        let status = new_array::<u16>(py, Fill::Nothing, &leading, "uint16")?;
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
            out: None,
            gyr_bias: None,
            status,
            extra,
            asked,
        };
        if let Kind::Offline(_) = recipe.kind {
            let given = [("q0", "an attitude", made.q0.is_some()), ("state", "a state", made.states.is_some())];
            if let Some((name, what, _)) = given.into_iter().find(|(_, _, given)| *given) {
                return Err(bad(name, &format!("None, as {} starts from the recording alone", spec.name), what));
            }
        }
        made.times(recipe)?;
        made.zero_bias = made.bias_stays_zero(recipe)?;
        let fill = if made.zero_bias { Fill::Zeros } else { Fill::Nothing };
        made.gyr_bias = spec.gyr_bias.then(|| new(&[3], fill)).transpose()?;
        Ok(made)
    }

    /// What is read while other calls write, and what is written.
    fn arrays(&self) -> Vec<&Bound<'py, PyAny>> {
        let read = [Some(&self.gyr), self.acc.as_ref(), self.mag.as_ref()].into_iter().flatten();
        let read = read.map(|array| array.as_any()).chain(self.t.as_deref().map(Bound::as_any));
        let out = self.out.as_ref().unwrap_or(&self.quat);
        read.chain([out.as_any()]).collect()
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

    /// A job for each recording, with its filter.
    fn jobs<'a, F: ?Sized>(
        &'a self,
        recipe: &Recipe,
        room: &'a mut Room<'py, T>,
        filters: Vec<Box<F>>,
    ) -> PyResult<Vec<Job<'a, T, F>>> {
        let (n, samples) = (self.n, self.samples);
        let gyr_rows = rows3("gyr", &self.gyr)?;
        let acc_rows = self.acc.as_ref().map(|acc| rows3("acc", acc)).transpose()?;
        let mag_rows = self.mag.as_ref().map(|mag| rows3("mag", mag)).transpose()?;
        let times = self.times(recipe)?;
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
        for (index, (time, stream)) in times.into_iter().zip(filters).enumerate() {
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
                panicked: None,
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

    /// Whether the bias of every recording is zero at every sample.
    fn bias_stays_zero(&self, recipe: &Recipe) -> PyResult<bool> {
        Ok(match recipe.kind {
            Kind::Streaming(_) => self.streams(recipe)?.iter().all(|stream| stream.bias_stays_zero()),
            Kind::Offline(_) => false,
        })
    }

    /// Whether each recording starts from nothing, so that the first sample's step does not matter.
    fn are_fresh(&self, recipe: &Recipe) -> PyResult<Vec<bool>> {
        Ok(match recipe.kind {
            Kind::Streaming(_) => self.streams(recipe)?.iter().map(|stream| stream.is_fresh()).collect(),
            Kind::Offline(_) => vec![true; self.n],
        })
    }

    /// The time of each recording, checked.
    fn times(&self, recipe: &Recipe) -> PyResult<Vec<Time<'_>>> {
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
            .zip(self.are_fresh(recipe)?)
            .map(|(index, fresh)| {
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
                    (None, None, Some(_), _) if fresh => 0.0,
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
    fn snapshots(&self, jobs: &mut [Job<'_, T>]) -> Vec<Snapshot> {
        let mut before = self.states.as_ref().map(|states| states.iter());
        jobs.iter_mut()
            .map(|job| {
                let (last, count) =
                    before.as_mut().and_then(Iterator::next).map_or((None, 0), |(_, last, n)| (*last, *n));
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
