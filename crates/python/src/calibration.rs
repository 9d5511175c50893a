//! Calibrations over whole arrays, by what firmware applies.

use ahrs_rs::calibration::Linear;
use ahrs_rs::{Calibration, TemperatureCalibration, Vec3};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Dtype, array, bad, check_not_infinite, is_f32, shape_text};

/// y = S (x − b) of an array (..., 3) of readings, in its dtype.
#[pyfunction]
pub fn calibrate<'py>(x: &Bound<'py, PyAny>, matrix: [[f64; 3]; 3], offset: [f64; 3]) -> PyResult<Bound<'py, PyAny>> {
    fn of<'py, T: Dtype>(
        x: &Bound<'py, PyAny>,
        matrix: [[f64; 3]; 3],
        offset: [f64; 3],
    ) -> PyResult<Bound<'py, PyAny>> {
        let calibration = Calibration::<T>::of(matrix, offset);
        each_row(&readings::<T>(x)?, |_, row| calibration.apply(row))
    }
    if is_f32("x", x)? { of::<f32>(x, matrix, offset) } else { of::<f64>(x, matrix, offset) }
}

/// The same by a calibration of the temperature (...), one of each reading, with lines as (slope, value at zero).
#[pyfunction]
pub fn calibrate_at<'py>(
    x: &Bound<'py, PyAny>,
    temperature: &Bound<'py, PyAny>,
    gain: ([f64; 3], [f64; 3]),
    bias: ([f64; 3], [f64; 3]),
) -> PyResult<Bound<'py, PyAny>> {
    fn of<'py, T: Dtype>(
        x: &Bound<'py, PyAny>,
        temperature: &Bound<'py, PyAny>,
        gain: ([f64; 3], [f64; 3]),
        bias: ([f64; 3], [f64; 3]),
    ) -> PyResult<Bound<'py, PyAny>> {
        let calibration =
            TemperatureCalibration::<T> { gain: Linear::of(gain.0, gain.1), bias: Linear::of(bias.0, bias.1) };
        let (x, temperature) = (readings::<T>(x)?, array::<T>("temperature", temperature)?);
        let leading = x.shape().split_last().map(|(_, leading)| leading).unwrap_or_default();
        if temperature.shape() != leading {
            let expected = format!("shape {}, one for each reading", shape_text(leading));
            return Err(bad("temperature", &expected, shape_text(temperature.shape())));
        }
        let view = temperature.as_array();
        check_not_infinite("temperature", &view).map_err(PyValueError::new_err)?;
        let temperatures: Vec<T> = view.iter().copied().collect();
        each_row(&x, |index, row| {
            // As many as there are rows.
            calibration.apply(row, temperatures.get(index).copied().unwrap_or(T::NAN))
        })
    }
    if is_f32("x", x)? { of::<f32>(x, temperature, gain, bias) } else { of::<f64>(x, temperature, gain, bias) }
}

fn readings<'py, T: Dtype>(x: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let array = array::<T>("x", x)?;
    if array.shape().last() != Some(&3) {
        return Err(bad("x", "shape (..., 3)", shape_text(array.shape())));
    }
    check_not_infinite("x", &array.as_array()).map_err(PyValueError::new_err)?;
    Ok(array)
}

fn each_row<'py, T: Dtype>(
    x: &PyReadonlyArrayDyn<'py, T>,
    function: impl Fn(usize, Vec3<T>) -> Vec3<T>,
) -> PyResult<Bound<'py, PyAny>> {
    let values: Vec<T> = x.as_array().iter().copied().collect();
    let rows = values.as_chunks::<3>().0.iter().enumerate();
    let out: Vec<T> = rows
        .flat_map(|(index, &[x, y, z])| {
            let Vec3 { x, y, z } = function(index, Vec3 { x, y, z });
            [x, y, z]
        })
        .collect();
    let flat = PyArrayDyn::from_owned_array(x.py(), ndarray::Array1::from_vec(out).into_dyn());
    Ok(flat.reshape(x.shape().to_vec())?.into_any())
}
