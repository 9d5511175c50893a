//! Other forms of many quaternions at once.

use ahrs_rs::{Euler, Quat};
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{Dtype, array, bad, is_f32, shape_text};

/// Roll, pitch and yaw in rad of an array (..., 4) of unit quaternions, as (..., 3).
#[pyfunction]
pub fn euler_angles<'py>(quat: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    convert(
        quat,
        |q| {
            let Euler { roll, pitch, yaw } = Euler::from_quat(q);
            [roll, pitch, yaw]
        },
        |q| {
            let Euler { roll, pitch, yaw } = Euler::from_quat(q);
            [roll, pitch, yaw]
        },
        &[3],
    )
}

/// The rotation matrices of an array (..., 4) of unit quaternions, as (..., 3, 3).
#[pyfunction]
pub fn rotation_matrices<'py>(quat: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    convert(quat, rows, rows, &[3, 3])
}

fn rows<T: Dtype>(q: Quat<T>) -> [T; 9] {
    let m = q.matrix();
    [m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z]
}

/// Applies one of two functions to each row, by the dtype of the array.
fn convert<'py, const N: usize>(
    quat: &Bound<'py, PyAny>,
    narrow: impl Fn(Quat<f32>) -> [f32; N],
    wide: impl Fn(Quat<f64>) -> [f64; N],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    if is_f32("quat", quat)? { each_row(quat, narrow, shape) } else { each_row(quat, wide, shape) }
}

fn each_row<'py, T: Dtype, const N: usize>(
    quat: &Bound<'py, PyAny>,
    function: impl Fn(Quat<T>) -> [T; N],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let array = array::<T>("quat", quat)?;
    let Some((4, leading)) = array.shape().split_last() else {
        return Err(bad("quat", "shape (..., 4)", shape_text(array.shape())));
    };
    let view = array.as_array();
    let values: Vec<T> = view.iter().copied().collect();
    let out: Vec<T> =
        values.as_chunks::<4>().0.iter().flat_map(|&[w, x, y, z]| function(Quat { w, x, y, z })).collect();
    let shape: Vec<usize> = leading.iter().chain(shape).copied().collect();
    let flat = PyArrayDyn::from_owned_array(quat.py(), ndarray::Array1::from_vec(out).into_dyn());
    Ok(flat.reshape(shape)?.into_any())
}
