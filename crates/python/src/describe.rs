//! The registry as Python sees it: plain dicts, from which the package makes its classes.

use ahrs_rs::filter::{Equivariance, FilterSpec, Magnetometer};
use ahrs_rs::params::{ParamKind, is_index};
use ahrs_rs::{Frame, GyrHold, Repeated, status};
use ahrs_rs_batch::{ENTRIES, OFFLINE};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The descriptions of all filters, in the order of the registry, the offline ones last.
#[pyfunction]
pub fn registry(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let streaming = ENTRIES.iter().map(|entry| (entry.spec, true));
    let offline = OFFLINE.iter().map(|entry| (entry.spec, false));
    streaming.chain(offline).map(|(spec, streaming)| describe(py, spec, streaming)).collect()
}

/// The names of the earth frames, the default first.
#[pyfunction]
pub fn frames() -> Vec<&'static str> {
    Frame::ALL.iter().map(|(name, _)| *name).collect()
}

/// The names of the rules for the angular rate between samples, the default first.
#[pyfunction]
pub fn gyr_holds() -> Vec<&'static str> {
    GyrHold::ALL.iter().map(|(name, _)| *name).collect()
}

/// The names of the rules for rows that repeat their sensor's last one, the default first.
#[pyfunction]
pub fn repeated_rules() -> Vec<&'static str> {
    Repeated::ALL.iter().map(|(name, _)| *name).collect()
}

/// The names of the status bits, and what they are.
#[pyfunction]
pub fn status_bits() -> Vec<(&'static str, u16)> {
    status::ALL.iter().map(|&(name, bit, _)| (name, bit)).collect()
}

fn describe<'py>(py: Python<'py>, spec: &FilterSpec, streaming: bool) -> PyResult<Bound<'py, PyDict>> {
    let filter = PyDict::new(py);
    filter.set_item("name", spec.name)?;
    filter.set_item("streaming", streaming)?;
    filter.set_item("doc", spec.doc)?;
    filter.set_item("source", spec.source)?;
    filter.set_item("magnetometer", spec.magnetometer == Magnetometer::Feedback)?;
    filter.set_item("feedback", spec.feedback)?;
    filter.set_item("gyr_bias", spec.gyr_bias)?;
    filter.set_item(
        "equivariance",
        match spec.equivariance {
            Equivariance::Exact => "exact".to_owned(),
            Equivariance::Heading => "heading".to_owned(),
            Equivariance::No(reason) => format!("no: {reason}"),
        },
    )?;
    let params = spec.params.iter().map(|param| {
        let dict = PyDict::new(py);
        dict.set_item("name", param.name)?;
        dict.set_item("doc", param.doc.trim())?;
        match param.kind {
            ParamKind::Real { unit, default, min, max } => {
                dict.set_item("unit", unit)?;
                dict.set_item("default", default)?;
                dict.set_item("range", (min, max))?;
                dict.set_item("options", py.None())?;
            }
            ParamKind::Choice { options } => {
                dict.set_item("unit", "")?;
                dict.set_item("default", options.first().copied().unwrap_or_default())?;
                dict.set_item("range", py.None())?;
                dict.set_item("options", PyTuple::new(py, options)?)?;
            }
            ParamKind::Switch { default } => {
                dict.set_item("unit", "")?;
                dict.set_item("default", default)?;
                dict.set_item("range", py.None())?;
                dict.set_item("options", PyTuple::new(py, [false, true])?)?;
            }
        }
        Ok(dict)
    });
    filter.set_item("params", params.collect::<PyResult<Vec<_>>>()?)?;
    let presets = PyDict::new(py);
    for preset in spec.presets {
        let values = PyDict::new(py);
        for (name, value) in preset.values {
            match spec.params.iter().find(|param| param.name == *name).map(|param| param.kind) {
                Some(ParamKind::Choice { options }) => {
                    let chosen = options.iter().enumerate().find(|&(index, _)| is_index(index, *value));
                    values.set_item(name, chosen.map(|(_, option)| *option))?;
                }
                Some(ParamKind::Switch { .. }) => values.set_item(name, is_index(1, *value))?,
                _ => values.set_item(name, value)?,
            }
        }
        presets.set_item(preset.name, values)?;
    }
    filter.set_item("presets", presets)?;
    let outputs = PyDict::new(py);
    for output in spec.outputs {
        outputs.set_item(output.name, (output.doc, PyTuple::new(py, output.shape)?))?;
    }
    filter.set_item("outputs", outputs)?;
    Ok(filter)
}
