"""Axes of a sensor under other names: "x,-y,-z"."""

from __future__ import annotations

import re

import numpy as np

from ahrs_rs._typing import FloatArray

#: Streams of vectors in the sensor frame, alone or at the start of a name (acc_high_range).
SENSOR_VECTORS = ("gyr", "acc", "mag", "linear_acceleration", "gravity")
#: Streams of orientations from the sensor to an earth frame.
ORIENTATIONS = ("ref", "device_quat")


def axes_matrix(axes: str) -> FloatArray:
    """The rotation matrix of "x,-y,-z" and the like: each entry says which of the old axes the new x, y, z is.

    Raises
    ------
    ValueError
        Not three axes with their signs, an axis that comes twice, or a mirror image.
    """
    parts = [part.strip().lower() for part in axes.split(",")] if isinstance(axes, str) else []
    if len(parts) != 3 or not all(re.fullmatch(r"[+-]?[xyz]", part) for part in parts):
        raise ValueError(f"axes: expected three of x, y, z with their signs, like 'x,-y,-z', got {axes!r}")
    matrix = np.zeros((3, 3))
    for row, part in enumerate(parts):
        matrix[row, "xyz".index(part[-1])] = -1.0 if part.startswith("-") else 1.0
    determinant = round(float(np.linalg.det(matrix)))
    if determinant == 0:
        raise ValueError(f"axes: expected each of x, y, z once, got {axes!r}")
    if determinant < 0:
        raise ValueError(f"axes: expected a rotation, got the mirror image {axes!r}: change one sign, or swap two axes")
    return matrix


def is_sensor_vector(name: str) -> bool:
    """Whether a stream of this name holds vectors in the sensor frame."""
    return any(name == one or name.startswith(f"{one}_") for one in SENSOR_VECTORS)
