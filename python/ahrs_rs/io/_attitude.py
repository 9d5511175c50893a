"""Orientations as devices write them, as unit quaternions: scalar-first, from the sensor to the earth frame."""

from __future__ import annotations

import numpy as np

from ahrs_rs import _quat
from ahrs_rs._typing import FloatArray


def from_matrix(matrix: FloatArray) -> FloatArray:
    """Unit quaternions (n, 4) of rotation matrices (n, 3, 3) from the sensor to the earth frame; NaN where one is none.

    Of the four squares 4w², 4x², 4y², 4z², which the diagonal gives, the largest is divided by.
    """
    m = np.asarray(matrix, dtype=np.float64)
    d = np.diagonal(m, axis1=1, axis2=2)
    sums = np.column_stack(
        [d.sum(axis=1), d[:, 0] - d[:, 1] - d[:, 2], d[:, 1] - d[:, 0] - d[:, 2], d[:, 2] - d[:, 0] - d[:, 1]]
    )
    squares = 1.0 + sums
    a, b, c = m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]
    e, f, g = m[:, 0, 1] + m[:, 1, 0], m[:, 0, 2] + m[:, 2, 0], m[:, 1, 2] + m[:, 2, 1]
    rows = np.stack(
        [
            np.column_stack([squares[:, 0], a, b, c]),
            np.column_stack([a, squares[:, 1], e, f]),
            np.column_stack([b, e, squares[:, 2], g]),
            np.column_stack([c, f, g, squares[:, 3]]),
        ],
        axis=1,
    )
    largest = np.argmax(np.nan_to_num(squares), axis=1)
    return normalised(rows[np.arange(len(m)), largest])


def from_euler(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> FloatArray:
    """Unit quaternions (n, 4) of the intrinsic Z-Y'-X'' angles, rad."""
    turned = _quat.multiply(_quat.about_axis(2, yaw), _quat.about_axis(1, pitch))
    return _quat.multiply(turned, _quat.about_axis(0, roll))


def normalised(q: FloatArray) -> FloatArray:
    """Unit quaternions; NaN where the norm is zero or not finite (no orientation)."""
    q = np.asarray(q, dtype=np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        norm = np.linalg.norm(q, axis=1, keepdims=True)
    out = np.full_like(q, np.nan)
    np.divide(q, norm, out=out, where=(norm > 1e-6) & np.isfinite(norm))
    return out


def recorded(q: FloatArray) -> FloatArray:
    """Quaternions as they were recorded, NaN where all four numbers are zero (no orientation)."""
    q = np.array(q, dtype=np.float64)
    q[(q == 0.0).all(axis=1)] = np.nan
    return q
