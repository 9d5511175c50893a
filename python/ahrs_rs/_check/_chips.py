"""Chips whose magnetometer has other axes than their gyroscope and accelerometer, by their data sheets.

A matrix turns the readings of the magnetometer, as the chip gives them, into the axes of the accelerometer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Chip:
    """One kind of chip."""

    names: str
    axes: str
    """Of the magnetometer, in the axes of the accelerometer: "y, x, -z"."""
    alone: bool
    """Whether no other chip has these axes or their negatives: then the sign of the field is told by the chip."""


#: PS-MPU-9250A-01, section 9.1: the AK8963's x is the gyroscope's y, its y the x, its z points the other way. DS-000189
#: (ICM-20948), section 14: the AK09916's y and z point the other way. LSM9DS1, figure 1: x points the other way, which
#: is the negative of the one before.
CHIPS = (
    Chip("AK8963 and AK8975 (MPU-9250, MPU-9150)", "y,x,-z", True),
    Chip("AK09916 (ICM-20948), or negated of the LSM9DS1", "x,-y,-z", False),
)


def matrix_of(axes: str) -> FloatArray:
    """The matrix of "y,x,-z": which of the old axes the new x, y, z are; mirrored ones too."""
    matrix = np.zeros((3, 3))
    for row, part in enumerate(one.strip() for one in axes.split(",")):
        matrix[row, "xyz".index(part[-1])] = -1.0 if part.startswith("-") else 1.0
    return matrix


def axes_of(matrix: FloatArray) -> str:
    """The name of a signed permutation: "y, x, -z"."""
    parts = []
    for row in matrix:
        column = int(np.argmax(np.abs(row)))
        parts.append(("-" if row[column] < 0 else "") + "xyz"[column])
    return ", ".join(parts)


def chip_of(matrix: FloatArray) -> Chip | None:
    """The chip whose magnetometer this is, up to the sign of the field."""
    for chip in CHIPS:
        own = matrix_of(chip.axes)
        if np.array_equal(own, matrix) or np.array_equal(own, -matrix):
            return chip
    return None
