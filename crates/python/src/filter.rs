//! The base class of all filter classes.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ahrs_rs::estimator::LONGEST_STEP;
use ahrs_rs::params::ParamError;
use ahrs_rs::{FilterSpec, Frame, GyrHold, Repeated, Settings};
use ahrs_rs_batch::{Entry, Offline, OfflineEntry, Stream, entry, offline_entry};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Dtype, Values, bad, start_quats, vector};
use crate::run::{Call, Way, run_calls};
use crate::sweep::{TrialCall, run_sweep};

/// A snapshot: every variable of the filter, the last stamp in s where stamps were given, and the number of samples.
pub type Snapshot = (Vec<f64>, Option<f64>, u64);

/// A filter of one of the registry's two kinds.
#[derive(Clone, Copy)]
pub enum Kind {
    /// It goes on from sample to sample.
    Streaming(&'static Entry),
    /// It takes whole recordings.
    Offline(&'static OfflineEntry),
}

impl Kind {
    /// The filter of a name.
    fn of(name: &str) -> Option<Kind> {
        entry(name).map(Kind::Streaming).or_else(|| offline_entry(name).map(Kind::Offline))
    }
    /// The description.
    pub fn spec(self) -> &'static FilterSpec {
        match self {
            Kind::Streaming(entry) => entry.spec,
            Kind::Offline(entry) => entry.spec,
        }
    }
}

/// What a filter object is made of, and what a run needs to make more of its kind.
pub struct Recipe {
    pub kind: Kind,
    pub values: Vec<f64>,
    pub settings: Settings,
    pub rate: Option<f64>,
}

impl Recipe {
    /// The entry of the registry; refused where the filter is offline.
    pub fn streaming(&self) -> PyResult<&'static Entry> {
        match self.kind {
            Kind::Streaming(entry) => Ok(entry),
            Kind::Offline(_) => Err(self.offline_error()),
        }
    }

    /// The exception for what an offline filter does not have.
    fn offline_error(&self) -> PyErr {
        let name = self.kind.spec().name;
        PyTypeError::new_err(format!(
            "{name} is offline: it takes whole recordings by run, and has no state between samples"
        ))
    }

    /// The offline filter with these parameters.
    pub fn offline(&self, entry: &OfflineEntry) -> PyResult<Box<dyn Offline>> {
        (entry.make)(&self.values, self.settings).map_err(wrong)
    }

    /// A new filter with these parameters, going on from the snapshot where there is one.
    pub fn stream<T: Dtype>(&self, snapshot: Option<&Snapshot>) -> PyResult<Box<dyn Stream<T>>> {
        let mut stream = T::stream(self.streaming()?, &self.values, self.settings).map_err(wrong)?;
        match snapshot {
            Some((values, _, _)) if !stream.load(values) => {
                Err(bad("state", &format!("a state of {}", self.kind.spec().name), format!("{} values", values.len())))
            }
            Some(_) if !stream.is_unit() => {
                Err(bad("state", "attitudes of unit norm", format!("{:?}", stream.quat().map(T::to_f64))))
            }
            _ => Ok(stream),
        }
    }
}

/// The exception for values of parameters that are not allowed.
fn wrong(error: ParamError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The filter in use, and its clock.
struct Current<T> {
    stream: Box<dyn Stream<T>>,
    status: u16,
    last_stamp: Option<f64>,
    samples: u64,
}

enum Live {
    F32(Current<f32>),
    F64(Current<f64>),
}

/// Calls the same code for either dtype.
macro_rules! with_live {
    ($live:expr, $current:ident => $body:expr) => {
        match $live {
            Live::F32($current) => $body,
            Live::F64($current) => $body,
        }
    };
}

/// A filter with its parameters: the native part of every filter class.
#[pyclass(subclass, frozen, module = "ahrs_rs._native")]
pub struct NativeFilter {
    recipe: Recipe,
    /// None of an offline filter.
    live: Option<Mutex<Live>>,
}

impl NativeFilter {
    /// The state under its lock. A panic while it was held left whole numbers, so the lock is taken all the same.
    ///
    /// Nothing of Python may be called while it is held: that could let another thread run, which could wait for the
    /// lock without letting this one go on.
    fn lock(&self) -> PyResult<MutexGuard<'_, Live>> {
        match &self.live {
            Some(live) => Ok(live.lock().unwrap_or_else(PoisonError::into_inner)),
            None => Err(self.recipe.offline_error()),
        }
    }

    /// Whether the filter computes in 32 bits; that never changes.
    fn is_f32(&self) -> PyResult<bool> {
        Ok(matches!(&*self.lock()?, Live::F32(_)))
    }

    /// The time step of one update in s.
    fn step(&self, dt: Option<f64>) -> PyResult<f64> {
        match (dt, self.recipe.rate) {
            (Some(dt), _) if dt.is_finite() && dt >= 0.0 => Ok(dt),
            (Some(dt), _) => Err(bad("dt", "a finite number of seconds, not negative", dt)),
            (None, Some(rate)) => Ok(1.0 / rate),
            (None, None) => Err(bad("dt", "a time step in s, as the filter was made without rate", "None")),
        }
    }
}

impl<T: Dtype> Current<T> {
    fn new(recipe: &Recipe, snapshot: Option<&Snapshot>) -> PyResult<Self> {
        let stream = recipe.stream(snapshot)?;
        let (last_stamp, samples) = snapshot.map_or((None, 0), |(_, last, samples)| (*last, *samples));
        Ok(Current { stream, status: 0, last_stamp, samples })
    }

    fn update(&mut self, gyr: [T; 3], acc: Option<[T; 3]>, mag: Option<[T; 3]>, dt: f64) -> [T; 4] {
        self.status = self.stream.update(gyr, acc, mag, T::from_f64(dt.min(LONGEST_STEP)));
        self.last_stamp = self.last_stamp.map(|last| last + dt);
        self.samples += 1;
        self.stream.quat()
    }

    fn reset(&mut self, recipe: &Recipe, q0: Option<[T; 4]>) -> PyResult<()> {
        *self = Current::new(recipe, None)?;
        if let Some(q0) = q0 {
            self.stream.start_from(q0);
        }
        Ok(())
    }
}

/// The vector of a sensor that may not be there.
fn read<T: Dtype>(name: &str, object: Option<&Bound<'_, PyAny>>) -> PyResult<Option<[T; 3]>> {
    object.map(|object| vector(name, object)).transpose()
}

#[pymethods]
impl NativeFilter {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
    #[pyo3(signature = (name, values, rate, frame, declination, gyr_hold, repeated, gyr_range, dtype))]
    fn new(
        name: &str,
        values: Vec<f64>,
        rate: Option<f64>,
        frame: &str,
        declination: f64,
        gyr_hold: &str,
        repeated: &str,
        gyr_range: f64,
        dtype: &str,
    ) -> PyResult<Self> {
        let kind = Kind::of(name).ok_or_else(|| bad("name", "the name of a filter", name))?;
        if let Some(rate) = rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return Err(bad("rate", "a positive, finite number of Hz", rate));
        }
        if !declination.is_finite() || declination.abs() > std::f64::consts::PI {
            return Err(bad("declination", "an angle in rad in [-pi, pi]", declination));
        }
        if !(gyr_range.is_finite() && gyr_range >= 0.0) {
            return Err(bad("gyr_range", "a finite rate in rad/s, 0 where it is not known", gyr_range));
        }
        let names = |all: &[&str]| format!("one of {all:?}");
        let settings = Settings {
            frame: Frame::from_name(frame)
                .ok_or_else(|| bad("frame", &names(&Frame::ALL.map(|(name, _)| name)), format!("{frame:?}")))?,
            declination,
            gyr_hold: GyrHold::from_name(gyr_hold)
                .ok_or_else(|| bad("gyr_hold", &names(&GyrHold::ALL.map(|(name, _)| name)), format!("{gyr_hold:?}")))?,
            repeated: Repeated::from_name(repeated).ok_or_else(|| {
                bad("repeated", &names(&Repeated::ALL.map(|(name, _)| name)), format!("{repeated:?}"))
            })?,
            gyr_range,
        };
        let recipe = Recipe { kind, values, settings, rate };
        let live = match (kind, dtype) {
            (Kind::Streaming(_), "float32") => Some(Mutex::new(Live::F32(Current::new(&recipe, None)?))),
            (Kind::Streaming(_), "float64") => Some(Mutex::new(Live::F64(Current::new(&recipe, None)?))),
            // Made for its check of the values alone.
            (Kind::Offline(entry), "float32" | "float64") => recipe.offline(entry).map(|_| None)?,
            _ => return Err(bad("dtype", "float32 or float64", dtype)),
        };
        Ok(NativeFilter { recipe, live })
    }

    /// Goes on by one sample; the attitude (4,).
    #[pyo3(signature = (gyr, acc=None, mag=None, dt=None))]
    fn update<'py>(
        &self,
        py: Python<'py>,
        gyr: &Bound<'py, PyAny>,
        acc: Option<&Bound<'py, PyAny>>,
        mag: Option<&Bound<'py, PyAny>>,
        dt: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let dt = self.step(dt)?;
        let quat = if self.is_f32()? {
            let (gyr, acc, mag) = (vector::<f32>("gyr", gyr)?, read("acc", acc)?, read("mag", mag)?);
            match &mut *self.lock()? {
                Live::F32(current) => Values::F32(current.update(gyr, acc, mag, dt).to_vec()),
                Live::F64(_) => return Err(bad("dtype", "float32", "float64")),
            }
        } else {
            let (gyr, acc, mag) = (vector::<f64>("gyr", gyr)?, read("acc", acc)?, read("mag", mag)?);
            match &mut *self.lock()? {
                Live::F64(current) => Values::F64(current.update(gyr, acc, mag, dt).to_vec()),
                Live::F32(_) => return Err(bad("dtype", "float64", "float32")),
            }
        };
        Ok(quat.into_numpy(py))
    }

    /// Starts anew, from the attitude q0 where one is given.
    #[pyo3(signature = (q0=None))]
    fn reset(&self, q0: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let q0 = q0.map(|q0| start_quats::<f64>(q0, None)).transpose()?;
        let q0 = q0.as_ref().and_then(|q0| q0.first()).copied();
        match &mut *self.lock()? {
            Live::F32(current) => current.reset(&self.recipe, q0.map(|q0| q0.map(|value| value as f32))),
            Live::F64(current) => current.reset(&self.recipe, q0),
        }
    }

    /// The last attitude (4,).
    #[getter]
    fn quat<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let quat = with_live!(&*self.lock()?, current => Values::from(current.stream.quat().to_vec()));
        Ok(quat.into_numpy(py))
    }

    /// The gyroscope's bias (3,) in rad/s, or None.
    #[getter]
    fn gyr_bias<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let bias =
            with_live!(&*self.lock()?, current => current.stream.gyr_bias().map(|bias| Values::from(bias.to_vec())));
        Ok(bias.map(|bias| bias.into_numpy(py)))
    }

    /// The status bits of the last update.
    fn _status(&self) -> PyResult<u16> {
        Ok(with_live!(&*self.lock()?, current => current.status))
    }

    /// The values of an output after the last update, in its shape.
    fn _output<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyAny>> {
        let outputs = self.recipe.kind.spec().outputs;
        let output = outputs.get(index).ok_or_else(|| bad("index", "that of an output", index))?;
        let flat = with_live!(&*self.lock()?, current => Values::from(current.stream.output(index)));
        flat.into_numpy(py).call_method1("reshape", (output.shape.to_vec(),))
    }

    /// A snapshot: (variables, last stamp or None, samples).
    fn _snapshot(&self) -> PyResult<Snapshot> {
        Ok(with_live!(&mut *self.lock()?, current => (current.stream.save(), current.last_stamp, current.samples)))
    }

    /// Goes back to a snapshot.
    fn _restore(&self, snapshot: Snapshot) -> PyResult<()> {
        match &mut *self.lock()? {
            Live::F32(current) => *current = Current::new(&self.recipe, Some(&snapshot))?,
            Live::F64(current) => *current = Current::new(&self.recipe, Some(&snapshot))?,
        }
        Ok(())
    }

    /// Runs over the recordings of several calls at once; each gives (quat, `gyr_bias` or None, status, outputs, snapshots),
    /// or its exception where `raising` is not asked for.
    #[pyo3(signature = (calls, threads, float32, progress, raising))]
    fn _run<'py>(
        &self,
        py: Python<'py>,
        calls: Vec<Call<'py>>,
        threads: Option<usize>,
        float32: bool,
        progress: Option<Bound<'py, PyAny>>,
        raising: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let way = Way { threads, progress: progress.as_ref(), raising };
        let results = if float32 {
            run_calls::<f32>(py, &self.recipe, &calls, &way)?
        } else {
            run_calls::<f64>(py, &self.recipe, &calls, &way)?
        };
        Ok(results
            .into_iter()
            .map(|result| result.unwrap_or_else(|error| error.into_value(py).into_bound(py).into_any()))
            .collect())
    }
    /// The errors in rad of parameter sets over recordings with truth: (errors, done, exception or None).
    #[allow(clippy::too_many_arguments, reason = "the keywords of the Python function")]
    #[pyo3(signature = (sets, trials, metric, threads, float32, progress))]
    fn _sweep<'py>(
        &self,
        py: Python<'py>,
        sets: Vec<Vec<f64>>,
        trials: Vec<TrialCall<'py>>,
        metric: &str,
        threads: Option<usize>,
        float32: bool,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let run = if float32 { run_sweep::<f32> } else { run_sweep::<f64> };
        run(py, &self.recipe, &sets, &trials, metric, threads, progress.as_ref())
    }
}
