//! Every check of an array that comes from Python.

use ahrs_rs_batch::Number;
use ndarray::{ArrayView2, ArrayView3, ArrayViewD, Axis, Dimension};
use numpy::{
    Element, PyArray1, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The two dtypes of numpy that are computed in.
pub trait Dtype: Number + Element {}
impl Dtype for f32 {}
impl Dtype for f64 {}

/// A `ValueError` that names the argument.
pub fn bad(name: &str, expected: &str, came: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("{name}: expected {expected}, got {came}"))
}

/// A shape as Python writes it.
pub fn shape_text(shape: &[usize]) -> String {
    let sizes: Vec<_> = shape.iter().map(usize::to_string).collect();
    if sizes.len() == 1 { format!("({},)", sizes.join("")) } else { format!("({})", sizes.join(", ")) }
}

/// `numpy.asarray(object)` if it holds real numbers.
fn numbers<'py>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = object.py();
    let array = match object.cast::<PyUntypedArray>() {
        Ok(array) if array.is_exact_instance_of::<PyUntypedArray>() => array.clone(),
        Ok(array) if array.hasattr(intern!(py, "mask"))? => masked(name, array)?,
        _ => py
            .import(intern!(py, "numpy"))?
            .call_method1(intern!(py, "asarray"), (object,))
            .map_err(|error| bad(name, "an array of numbers", error.value(py)))?
            .cast_into::<PyUntypedArray>()?,
    };
    match array.dtype().kind() {
        b'f' | b'i' | b'u' | b'b' => Ok(array),
        _ => Err(bad(name, "an array of real numbers", format!("dtype {}", array.dtype()))),
    }
}

/// A masked array as one with NaN where it is masked: what is masked is no measurement.
fn masked<'py>(name: &str, array: &Bound<'py, PyUntypedArray>) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = array.py();
    let narrow = array.dtype().kind() == b'f' && array.dtype().itemsize() == size_of::<f32>();
    let floats = array.call_method1(intern!(py, "astype"), (if narrow { "float32" } else { "float64" },));
    let floats = floats.map_err(|error| bad(name, "an array of real numbers", error.value(py)))?;
    Ok(floats.call_method1(intern!(py, "filled"), (f64::NAN,))?.cast_into::<PyUntypedArray>()?)
}

/// Whether the object is an array of 32-bit floats.
pub fn is_f32(name: &str, object: &Bound<'_, PyAny>) -> PyResult<bool> {
    let dtype = numbers(name, object)?.dtype();
    Ok(dtype.kind() == b'f' && dtype.itemsize() == size_of::<f32>())
}

/// Whether all of the arrays that are given hold 32-bit floats: a run over them is computed in float32.
#[pyfunction]
#[pyo3(signature = (gyr, acc=None, mag=None))]
pub fn all_float32(
    gyr: &Bound<'_, PyAny>,
    acc: Option<&Bound<'_, PyAny>>,
    mag: Option<&Bound<'_, PyAny>>,
) -> PyResult<bool> {
    // Each is looked at, so that the first that holds no numbers is the one that is named.
    [("gyr", Some(gyr)), ("acc", acc), ("mag", mag)]
        .into_iter()
        .try_fold(true, |all, (name, object)| Ok(object.map_or(Ok(true), |object| is_f32(name, object))? && all))
}

/// The object as an array of `T`; copied only where dtype, byte order or alignment ask for it.
pub fn array<'py, T: Dtype>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = object.py();
    let array = match object.cast::<PyArrayDyn<T>>() {
        Ok(array) if array.is_aligned() && array.is_exact_instance_of::<PyUntypedArray>() => {
            return readonly(name, array);
        }
        _ => numbers(name, object)?,
    };
    let options = PyDict::new(py);
    options.set_item(intern!(py, "dtype"), T::DTYPE)?;
    options.set_item(intern!(py, "requirements"), "A")?;
    let converted = py.import(intern!(py, "numpy"))?.call_method(intern!(py, "require"), (array,), Some(&options))?;
    readonly(name, converted.cast::<PyArrayDyn<T>>()?)
}

fn readonly<'py, T: Dtype>(name: &str, array: &Bound<'py, PyArrayDyn<T>>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    array.try_readonly().map_err(|_| bad(name, "an array that nothing else writes to", "one that is in use as out"))
}

/// The measurements of `n` recordings of `t` samples, (T, 3) or (N, T, 3), as (N, T, 3).
pub fn rows3<'a, T: Dtype>(name: &str, array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<ArrayView3<'a, T>> {
    let view = array.as_array();
    let shape = view.shape().to_vec();
    match shape.as_slice() {
        [_, 3] => view.insert_axis(Axis(0)).into_dimensionality(),
        [_, _, 3] => view.into_dimensionality(),
        _ => return Err(bad(name, "shape (T, 3) or (N, T, 3)", shape_text(&shape))),
    }
    .map_err(|error| bad(name, "shape (T, 3) or (N, T, 3)", error))
}

/// Signals (T,), (T, C) or (N, T, C) as (N, T, C).
pub fn signals<'a, T: Dtype>(name: &str, array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<ArrayView3<'a, T>> {
    let view = array.as_array();
    let shape = view.shape().to_vec();
    match shape.as_slice() {
        [_] => view.insert_axis(Axis(0)).insert_axis(Axis(2)).into_dimensionality(),
        [_, _] => view.insert_axis(Axis(0)).into_dimensionality(),
        [_, _, _] => view.into_dimensionality(),
        _ => return Err(bad(name, "shape (T,), (T, C) or (N, T, C)", shape_text(&shape))),
    }
    .map_err(|error| bad(name, "shape (T,), (T, C) or (N, T, C)", error))
}

/// Checks that another sensor's array has the shape of the gyroscope's.
pub fn same_shape(name: &str, shape: &[usize], gyr: &[usize]) -> PyResult<()> {
    if shape == gyr {
        return Ok(());
    }
    Err(bad(name, &format!("the shape of gyr, {}", shape_text(gyr)), shape_text(shape)))
}

/// Checks that no value is infinite (NaN is missing data).
pub fn check_not_infinite<T: Dtype>(name: &str, view: &ArrayViewD<'_, T>) -> Result<(), String> {
    let infinite = |value: &T| T::splat(T::MAX).lt(value.abs());
    // Reducing without a branch is several times as fast as stopping at the first.
    let any = match view.as_slice_memory_order() {
        Some(values) => values.iter().fold(false, |any, value| any | infinite(value)),
        None => view.iter().fold(false, |any, value| any | infinite(value)),
    };
    if !any {
        return Ok(());
    }
    let first = view.indexed_iter().find(|(_, value)| infinite(value)).map(|(index, _)| index);
    let index = first.map(|index| index.slice().to_vec()).unwrap_or_default();
    Err(format!(
        "{name}: expected finite values or NaN (missing), got an infinite value at index {}",
        shape_text(&index)
    ))
}

/// Checks the stamps of one recording: finite and not decreasing, from `last` on where there is one.
pub fn check_stamps(stamps: impl Iterator<Item = f64>, last: Option<f64>) -> Result<(), String> {
    let mut before = last;
    for (index, stamp) in stamps.enumerate() {
        if !stamp.is_finite() {
            return Err(format!("t: expected finite stamps, got {stamp} at index {index}"));
        }
        if let Some(before) = before.filter(|&before| stamp < before) {
            return Err(format!(
                "t: expected stamps that do not decrease, got {stamp} after {before} at index {index}"
            ));
        }
        before = Some(stamp);
    }
    Ok(())
}

/// The stamps of `n` recordings of `samples` each, (T,) or (N, T), as (N, T) or (1, T) for all.
pub fn stamps<'a>(array: &'a PyReadonlyArrayDyn<'_, f64>, shape: &[usize]) -> PyResult<ArrayView2<'a, f64>> {
    let view = array.as_array();
    let own = view.shape().to_vec();
    let expected = match shape {
        [n, t, _] => format!("({t},) or ({n}, {t})"),
        [t, _] => format!("({t},)"),
        _ => String::new(),
    };
    let view = match (own.as_slice(), shape) {
        ([own], [t, _] | [_, t, _]) if own == t => view.insert_axis(Axis(0)),
        ([rows, own], [n, t, _]) if rows == n && own == t => view,
        _ => return Err(bad("t", &format!("shape {expected}"), shape_text(&own))),
    };
    view.into_dimensionality().map_err(|error| bad("t", &expected, error))
}

/// Unit quaternions (4,), or (N, 4) for `n` recordings, one per recording.
pub fn start_quats<T: Dtype>(object: &Bound<'_, PyAny>, n: Option<usize>) -> PyResult<Vec<[T; 4]>> {
    let array = array::<f64>("q0", object)?;
    let view = array.as_array();
    let expected = n.map_or("shape (4,)".to_owned(), |n| format!("shape (4,) or ({n}, 4)"));
    let rows: Vec<f64> = match (view.shape(), n) {
        ([4], _) => view.iter().copied().cycle().take(4 * n.unwrap_or(1)).collect(),
        ([rows, 4], Some(n)) if *rows == n => view.iter().copied().collect(),
        (shape, _) => return Err(bad("q0", &expected, shape_text(shape))),
    };
    let unit = |row: &[f64; 4]| {
        let largest = row.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        if !row.iter().all(|value| value.is_finite()) || largest < f64::MIN_POSITIVE {
            return Err(bad("q0", "a quaternion of finite, non-zero norm", format!("{row:?}")));
        }
        let norm = row.iter().map(|value| (value / largest).powi(2)).sum::<f64>().sqrt();
        Ok(row.map(|value| T::from_f64(value / largest / norm)))
    };
    rows.as_chunks::<4>().0.iter().map(unit).collect()
}

/// A vector of three numbers that are not infinite, for one streaming update.
pub fn vector<T: Dtype>(name: &str, object: &Bound<'_, PyAny>) -> PyResult<[T; 3]> {
    // The common cases first: an array of three of the right dtype, or of float64, needs no view.
    if let Ok(vector) = object.cast::<PyArray1<T>>()
        && let Some(values) = three(vector)
    {
        return Ok(values);
    }
    if let Ok(vector) = object.cast::<PyArray1<f64>>()
        && let Some(values) = three(vector)
    {
        return Ok(values.map(T::from_f64));
    }
    let array = array::<f64>(name, object)?;
    let view = array.as_array();
    if view.shape() != [3] {
        return Err(bad(name, "shape (3,)", shape_text(view.shape())));
    }
    check_not_infinite(name, &view).map_err(PyValueError::new_err)?;
    // A number beyond the filter's dtype becomes infinite here: a measurement that is missing, not an error.
    let mut values = view.iter().copied();
    Ok([(); 3].map(|()| T::from_f64(values.next().unwrap_or(0.0))))
}

/// The values of an aligned array of three, if none is infinite.
fn three<T: Dtype>(vector: &Bound<'_, PyArray1<T>>) -> Option<[T; 3]> {
    if !vector.is_aligned() || vector.len() != 3 || !vector.is_exact_instance_of::<PyUntypedArray>() {
        return None;
    }
    let values = [vector.get_owned(0)?, vector.get_owned(1)?, vector.get_owned(2)?];
    values.iter().all(|value| !T::splat(T::MAX).lt(value.abs())).then_some(values)
}

/// What is in a new array.
#[derive(Clone, Copy)]
pub enum Fill {
    /// Anything: all values are still to be written.
    Nothing,
    /// Zeros, which cost nothing until they are read.
    Zeros,
}

/// A new array. numpy allocates, because it reuses pages.
pub fn new_array<'py, E: Element>(
    py: Python<'py>,
    fill: Fill,
    shape: &[usize],
    dtype: &str,
) -> PyResult<Bound<'py, PyArrayDyn<E>>> {
    let numpy = py.import(intern!(py, "numpy"))?;
    let function = match fill {
        Fill::Nothing => intern!(py, "empty"),
        Fill::Zeros => intern!(py, "zeros"),
    };
    let array = numpy.call_method1(function, (PyTuple::new(py, shape)?, dtype))?;
    Ok(array.cast_into::<PyArrayDyn<E>>()?)
}

/// The array given as `out`, if results of this shape and dtype can be written into it.
pub fn output<'py, T: Dtype>(object: &Bound<'py, PyAny>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let expected = format!("a writeable {} array of shape {}", T::DTYPE, shape_text(shape));
    let array = object.cast::<PyArrayDyn<T>>().map_err(|_| match object.cast::<PyUntypedArray>() {
        Ok(array) => bad("out", &expected, format!("dtype {}", array.dtype())),
        Err(_) => bad("out", &expected, object.get_type()),
    })?;
    if array.shape() != shape {
        return Err(bad("out", &expected, shape_text(array.shape())));
    }
    if !array.is_aligned() {
        return Err(bad("out", &expected, "one that is not aligned"));
    }
    if !elements_apart(array.shape(), array.strides(), size_of::<T>()) {
        return Err(bad("out", &expected, "one whose elements share memory"));
    }
    Ok(array.clone())
}

/// Whether each axis of an array steps over all that the axes inside it reach.
fn elements_apart(shape: &[usize], strides: &[isize], itemsize: usize) -> bool {
    let mut axes: Vec<_> = strides.iter().map(|stride| stride.unsigned_abs()).zip(shape.iter().copied()).collect();
    axes.sort_unstable();
    let mut reach = itemsize;
    axes.into_iter().filter(|(_, size)| *size > 1).all(|(stride, size)| {
        let apart = stride >= reach;
        reach += stride * (size - 1);
        apart
    }) || shape.contains(&0)
}

/// `numpy.copyto(out, array)`.
pub fn copy_into<T: Dtype>(out: &Bound<'_, PyArrayDyn<T>>, array: &Bound<'_, PyArrayDyn<T>>) -> PyResult<()> {
    let py = out.py();
    py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "copyto"), (out, array)).map(drop)
}

/// Refuses an `out` that shares memory with an input; what is written would be read as a measurement.
pub fn check_apart(out: &Bound<'_, PyAny>, input: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    let Some(input) = input.filter(|input| input.cast::<PyUntypedArray>().is_ok()) else { return Ok(()) };
    let py = out.py();
    let options = PyDict::new(py);
    // Exact for all but contrived strides, which count as shared.
    options.set_item(intern!(py, "max_work"), 100_000)?;
    let numpy = py.import(intern!(py, "numpy"))?;
    let shared = numpy.call_method(intern!(py, "shares_memory"), (out, input), Some(&options));
    if shared.is_ok_and(|shared| !shared.is_truthy().unwrap_or(true)) {
        return Ok(());
    }
    Err(bad("out", "a writeable array that is no input", "one that shares memory with an input"))
}

/// Numbers of either dtype on their way to numpy.
pub enum Values {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl From<Vec<f32>> for Values {
    fn from(values: Vec<f32>) -> Self {
        Values::F32(values)
    }
}

impl From<Vec<f64>> for Values {
    fn from(values: Vec<f64>) -> Self {
        Values::F64(values)
    }
}

impl Values {
    /// A numpy array that takes over the values.
    pub fn into_numpy(self, py: Python<'_>) -> Bound<'_, PyAny> {
        match self {
            // Copied: an array that owns a Rust vector needs a second Python object to do so.
            Values::F32(values) => PyArray1::from_slice(py, &values).into_any(),
            Values::F64(values) => PyArray1::from_slice(py, &values).into_any(),
        }
    }
}
