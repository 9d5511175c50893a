"""Calibrations as constants in source code, in the float32 that firmware computes in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration._common import AXES

SAFE_NAME = "a name of letters, digits and _, that begins with a letter"


class Constants(NamedTuple):
    """The numbers of a calibration, as firmware applies them."""

    type: str
    """Of the Rust crate."""
    numbers: Mapping[str, FloatArray]
    """matrix and offset, or gain_slope, gain_at_zero, bias_slope and bias_at_zero."""
    comment: str


def rust(calibrations: Mapping[str, Constants]) -> str:
    """A module of constants by their names; they are used as `MAG.apply(raw)`."""
    _check_names(calibrations)
    used = sorted({each.type for each in calibrations.values()})
    lines = ["//! Written by ahrs_rs from a calibration: y = S (x − b).", ""]
    if any("matrix" not in each.numbers for each in calibrations.values()):
        lines.append("use ahrs_rs::calibration::Linear;")
    lines += [f"use ahrs_rs::{{{', '.join([*used, 'Vec3'])}}};"]
    for name, each in calibrations.items():
        lines += ["", f"/// {each.comment}", f"pub const {name}: {each.type}<f32> = {_rust_value(each)};"]
    return "\n".join(lines) + "\n"


def c(calibrations: Mapping[str, Constants]) -> str:
    """A header of constant arrays: NAME_MATRIX and NAME_OFFSET, or the lines of gain and bias over the temperature."""
    _check_names(calibrations)
    guard = "AHRS_RS_CALIBRATION_H"
    lines = ["/* Written by ahrs_rs from a calibration: y = S (x - b). */", f"#ifndef {guard}", f"#define {guard}"]
    for name, each in calibrations.items():
        lines += ["", f"/* {each.comment} */"]
        for part, values in each.numbers.items():
            if values.ndim == 2:
                rows = ",\n".join(f"    {{{_row(row, 'f')}}}" for row in values)
                lines.append(f"static const float {name}_{part.upper()}[3][3] = {{\n{rows},\n}};")
            else:
                lines.append(f"static const float {name}_{part.upper()}[3] = {{{_row(values, 'f')}}};")
    return "\n".join([*lines, "", "#endif"]) + "\n"


def _rust_value(constants: Constants) -> str:
    numbers = constants.numbers
    if "matrix" in numbers:
        rows = "".join(f"        [{_row(row)}],\n" for row in numbers["matrix"])
        fields = f"    matrix: [\n{rows}    ],\n    offset: {_rust_vector(numbers['offset'])},\n"
    else:
        fields = "".join(
            f"    {part}: Linear {{\n"
            f"        slope: {_rust_vector(numbers[f'{part}_slope'])},\n"
            f"        at_zero: {_rust_vector(numbers[f'{part}_at_zero'])},\n    }},\n"
            for part in ("gain", "bias")
        )
    return f"{constants.type} {{\n{fields}}}"


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
