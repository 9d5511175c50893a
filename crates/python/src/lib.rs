//! The native part of the Python package `ahrs_rs`.

// PyO3's macros expand to code that these lints see as ours.
#![allow(clippy::needless_pass_by_value)]

mod arrays;
mod calibration;
mod describe;
mod euler;
mod filter;
mod run;
mod signal;
mod sweep;
mod watch;

use pyo3::prelude::*;

/// The compiled core of `ahrs_rs`.
#[pymodule(gil_used = false)]
mod _native {
    use pyo3::exceptions::PyImportError;
    use pyo3::prelude::*;

    /// Refuses to load where the environment names instructions that are not there; else tells which are used.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let isa = ahrs_rs_batch::isa::chosen().map_err(PyImportError::new_err)?;
        module.add("INSTRUCTIONS", isa.map_or("scalar", ahrs_rs_batch::Isa::name))
    }

    #[pymodule_export]
    use super::arrays::all_float32;
    #[pymodule_export]
    use super::calibration::{calibrate, calibrate_at};
    #[pymodule_export]
    use super::describe::{frames, gyr_holds, registry, repeated_rules, status_bits};
    #[pymodule_export]
    use super::euler::{euler_angles, rotation_matrices};
    #[pymodule_export]
    use super::filter::NativeFilter;
    #[pymodule_export]
    use super::signal::low_pass;
}
