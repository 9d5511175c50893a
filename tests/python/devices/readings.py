"""Readings that look like those of a sensor that is turned about: of 1 g, 50 µT and some rad/s."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def gyr(n: int) -> FloatArray:
    """(n, 3) rad/s."""
    k = np.arange(n)[:, None]
    return np.hstack([0.5 * np.sin(0.1 * k), -0.3 * np.cos(0.07 * k), 0.2 + 0.1 * np.sin(0.011 * k)])


def acc(n: int) -> FloatArray:
    """(n, 3) m/s², of about 9.8."""
    k = np.arange(n)[:, None]
    tilt = 0.3 * np.sin(0.05 * k)
    return 9.81 * np.hstack([np.sin(tilt), 0.1 * np.sin(0.03 * k), np.cos(tilt)])


def mag(n: int) -> FloatArray:
    """(n, 3) µT."""
    k = np.arange(n)[:, None]
    return np.hstack([20.0 + np.sin(0.02 * k), 1.0 + 0.0 * k, -44.0 + np.cos(0.013 * k)])


def quat(n: int) -> FloatArray:
    """(n, 4) unit quaternions about one axis, scalar-first."""
    half = 0.01 * np.arange(n)
    return np.column_stack([np.cos(half), 0.0 * half, 0.6 * np.sin(half), 0.8 * np.sin(half)])
