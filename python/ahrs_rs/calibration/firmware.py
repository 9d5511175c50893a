"""Calibrations as constants in source code, in the float32 that firmware computes in."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ._common import AXES, FloatArray
from .model import Calibration, TemperatureCalibration

SAFE_NAME = "a name of letters, digits and _, that begins with a letter"


def rust(calibrations: Mapping[str, Calibration | TemperatureCalibration]) -> str:
    """A module of constants by their names; they are used as `MAG.apply(raw)`."""
    _check_names(calibrations)
    kinds = {type(one) for one in calibrations.values()}
    used = ["Calibration"] * (Calibration in kinds) + ["TemperatureCalibration"] * (TemperatureCalibration in kinds)
    lines = ["//! Written by ahrs_rs from a calibration: y = S (x − b).", ""]
    if TemperatureCalibration in kinds:
        lines.append("use ahrs_rs::calibration::Linear;")
    lines += [f"use ahrs_rs::{{{', '.join([*used, 'Vec3'])}}};"]
    for name, one in calibrations.items():
        lines += ["", f"/// {_description(one)}", f"pub const {name}: {type(one).__name__}<f32> = {_rust_value(one)};"]
    return "\n".join(lines) + "\n"


def c(calibrations: Mapping[str, Calibration | TemperatureCalibration]) -> str:
    """A header of constant arrays: NAME_MATRIX and NAME_OFFSET, or the lines of gain and bias over the temperature."""
    _check_names(calibrations)
    guard = "AHRS_RS_CALIBRATION_H"
    lines = ["/* Written by ahrs_rs from a calibration: y = S (x - b). */", f"#ifndef {guard}", f"#define {guard}"]
    for name, one in calibrations.items():
        lines += ["", f"/* {_description(one)} */"]
        if isinstance(one, Calibration):
            rows = ",\n".join(f"    {{{_row(row, 'f')}}}" for row in one.matrix)
            lines.append(f"static const float {name}_MATRIX[3][3] = {{\n{rows},\n}};")
            lines.append(f"static const float {name}_OFFSET[3] = {{{_row(one.offset, 'f')}}};")
        else:
            for part in ("gain_slope", "gain_at_zero", "bias_slope", "bias_at_zero"):
                lines.append(f"static const float {name}_{part.upper()}[3] = {{{_row(getattr(one, part), 'f')}}};")
    return "\n".join([*lines, "", "#endif"]) + "\n"


def _description(one: Calibration | TemperatureCalibration) -> str:
    if isinstance(one, Calibration):
        return "y = S (x - b)."
    fitted = f", fitted from {one.range[0]:.4g} to {one.range[1]:.4g} deg C" if one.range is not None else ""
    return f"y = (x - bias(T)) / gain(T), both slope * T + at_zero, T in deg C{fitted}."


def _rust_value(one: Calibration | TemperatureCalibration) -> str:
    if isinstance(one, Calibration):
        rows = "".join(f"        [{_row(row)}],\n" for row in one.matrix)
        return f"Calibration {{\n    matrix: [\n{rows}    ],\n    offset: {_rust_vector(one.offset)},\n}}"
    parts = "".join(
        f"    {part}: Linear {{\n"
        f"        slope: {_rust_vector(getattr(one, f'{part}_slope'))},\n"
        f"        at_zero: {_rust_vector(getattr(one, f'{part}_at_zero'))},\n    }},\n"
        for part in ("gain", "bias")
    )
    return f"TemperatureCalibration {{\n{parts}}}"


def _rust_vector(values: FloatArray) -> str:
    return f"Vec3 {{ {', '.join(f'{axis}: {_number(value)}' for axis, value in zip(AXES, values, strict=True))} }}"


def _row(values: FloatArray, suffix: str = "") -> str:
    return ", ".join(f"{_number(value)}{suffix}" for value in values)


def _number(value: float) -> str:
    """The shortest text that is read back as the float32 nearest to the value."""
    if not abs(value) <= float(np.finfo(np.float32).max):
        raise ValueError(f"expected numbers within the range of float32, got {value}")
    # Valid in Rust and C alike, with a point or an exponent in each.
    return str(np.float32(value))


def _check_names(names: Mapping[str, object]) -> None:
    if not names:
        raise ValueError("expected at least one calibration, got none")
    for name in names:
        if not (name.isascii() and name.isidentifier() and name[0].isalpha()):
            raise ValueError(f"name: expected {SAFE_NAME}, got {name!r}")
