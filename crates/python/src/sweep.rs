//! Sweeps over parameter sets: from Python's arrays to the batch engine and back.

use ahrs_rs_batch::isa;
use ahrs_rs_batch::metric::Metric;
use ahrs_rs_batch::sweep::{Sweep, Trial, sweep};
use ahrs_rs_batch::{Recording, Time};
use ndarray::Axis;
use numpy::{PyArray1, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Dtype, array, bad, check_not_infinite, check_stamps, rows3, same_shape};
use crate::filter::Recipe;
use crate::watch::watched;

/// A recording with its truth in Python: (gyr, acc, mag, t, rate, ref), rows of NaN in ref where it does not count.
pub type TrialCall<'py> = (
    Bound<'py, PyAny>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Bound<'py, PyAny>,
    f64,
    Bound<'py, PyAny>,
);

/// The arrays of a trial, checked.
struct Checked<'py, T: Dtype> {
    gyr: PyReadonlyArrayDyn<'py, T>,
    acc: Option<PyReadonlyArrayDyn<'py, T>>,
    mag: Option<PyReadonlyArrayDyn<'py, T>>,
    t: PyReadonlyArrayDyn<'py, f64>,
    rate: f64,
    reference: Vec<Option<[T; 4]>>,
}

impl<'py, T: Dtype> Checked<'py, T> {
    fn new(call: &TrialCall<'py>) -> PyResult<Self> {
        let (gyr, acc, mag, t, rate, reference) = call;
        let gyr = array::<T>("gyr", gyr)?;
        let acc = acc.as_ref().map(|acc| array::<T>("acc", acc)).transpose()?;
        let mag = mag.as_ref().map(|mag| array::<T>("mag", mag)).transpose()?;
        for (name, other) in [("gyr", Some(&gyr)), ("acc", acc.as_ref()), ("mag", mag.as_ref())] {
            if let Some(other) = other {
                same_shape(name, other.shape(), gyr.shape())?;
                check_not_infinite(name, &other.as_array()).map_err(PyValueError::new_err)?;
            }
        }
        let t = array::<f64>("t", t)?;
        check_stamps(t.as_array().iter().copied(), None).map_err(PyValueError::new_err)?;
        let reference = array::<f64>("ref", reference)?;
        let samples = rows3("gyr", &gyr)?.len_of(Axis(1));
        if reference.shape() != [samples, 4] || t.shape() != [samples] || gyr.shape().len() != 2 {
            let came = format!("{:?}, {:?} and {:?}", gyr.shape(), t.shape(), reference.shape());
            return Err(bad("recording", "gyr (T, 3), t (T,) and ref (T, 4)", came));
        }
        let reference: Vec<f64> = reference.as_array().iter().copied().collect();
        let known = |row: &[f64; 4]| row.iter().all(|x| x.is_finite()).then(|| row.map(T::from_f64));
        let reference = reference.as_chunks::<4>().0.iter().map(known).collect();
        Ok(Checked { gyr, acc, mag, t, rate: *rate, reference })
    }

    fn trial(&self) -> PyResult<Trial<'_, T>> {
        let rows = |name, array| rows3(name, array).map(|rows| rows.index_axis_move(Axis(0), 0));
        let stamps = self.t.as_array().into_dimensionality().map_err(|error| bad("t", "(T,)", error))?;
        Ok(Trial {
            recording: Recording {
                gyr: rows("gyr", &self.gyr)?,
                acc: self.acc.as_ref().map(|acc| rows("acc", acc)).transpose()?,
                mag: self.mag.as_ref().map(|mag| rows("mag", mag)).transpose()?,
                time: Time { stamps: Some(stamps), first: 1.0 / self.rate, step: 0.0 },
            },
            reference: &self.reference,
        })
    }
}

/// The errors in rad of parameter sets over trials, (sets · trials,), NaN where there is none or it was not computed; which
/// were computed; and the exception that ended the work, or None.
pub fn run_sweep<'py, T: Dtype>(
    py: Python<'py>,
    recipe: &Recipe,
    sets: &[Vec<f64>],
    trials: &[TrialCall<'py>],
    metric: &str,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let names: Vec<_> = Metric::ALL.iter().map(|(name, _)| *name).collect();
    let metric =
        Metric::from_name(metric).ok_or_else(|| bad("metric", &format!("one of {names:?}"), format!("{metric:?}")))?;
    let entry = recipe.streaming()?;
    let checked = trials.iter().map(Checked::<T>::new).collect::<PyResult<Vec<_>>>()?;
    let trials = checked.iter().map(Checked::trial).collect::<PyResult<Vec<_>>>()?;
    let plan =
        Sweep { entry, sets, settings: recipe.settings, metric, isa: isa::chosen().unwrap_or_default(), threads };
    let samples = trials.iter().map(|trial| trial.reference.len() * sets.len()).sum();
    let (errors, error) = watched(py, samples, progress, |watch| sweep(&plan, &trials, watch))?;
    let errors = errors.map_err(|error| PyValueError::new_err(error.to_string()))?;
    let values: Vec<f64> = errors.iter().map(|error| error.unwrap_or(f64::NAN)).collect();
    let done: Vec<bool> = errors.iter().map(Option::is_some).collect();
    let error = error.map(|error| error.into_value(py));
    Ok((PyArray1::from_vec(py, values), PyArray1::from_vec(py, done), error).into_pyobject(py)?.into_any())
}
