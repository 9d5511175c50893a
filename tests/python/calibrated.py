"""Sensors with known errors, and the numbers of Hyyti & Visala 2015, for the tests of calibration."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ahrs_rs.calibration import Calibration, TemperatureCalibration

FloatArray = NDArray[np.float64]
DEGREE = math.pi / 180.0

#: Table 4: the accelerometer, in m/s² and °C.
TABLE_4_ACC = TemperatureCalibration(
    gain_slope=np.array([-0.00049316, 0.00040477, 0.00102091]),
    gain_at_zero=np.array([1.06731340, 1.03869310, 0.98073082]),
    bias_slope=np.array([-0.01551443, -0.00457992, -0.01929765]),
    bias_at_zero=np.array([0.99740194, 0.05868846, 0.48880423]),
)
#: Table 4: the gyroscope; the biases of the paper are in °/s.
TABLE_4_GYR = TemperatureCalibration(
    gain_slope=np.array([0.00027886, -0.00122424, -0.00246201]),
    gain_at_zero=np.array([0.99130982, 1.03580126, 1.08040715]),
    bias_slope=np.array([-0.01188330, -0.00845710, 0.00542382]) * DEGREE,
    bias_at_zero=np.array([0.24566657, 0.19236960, -0.21682853]) * DEGREE,
)

#: What tests/calibration/written.rs was written from.
WRITTEN_MAG = Calibration(
    np.array([[1.1, 0.01, -0.02], [0.01, 0.9, 0.03], [-0.02, 0.03, 1.0 / 3.0]]), np.array([12.0, -3.5, 1e-5])
)


def directions(random: np.random.Generator, count: int) -> FloatArray:
    """(count, 3) unit vectors, evenly spread over the sphere."""
    u = random.standard_normal((count, 3))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def symmetric(random: np.random.Generator, parameters: int, spread: float = 0.2) -> FloatArray:
    """S of 6 parameters (diagonal) or 9 (symmetric and positive definite), of scales within 1 ± spread."""
    scales = np.diag(random.uniform(1.0 - spread, 1.0 + spread, 3))
    if parameters == 6:
        return scales
    q, _ = np.linalg.qr(random.standard_normal((3, 3)))
    s: FloatArray = q @ scales @ q.T
    return 0.5 * (s + s.T)


def vector_of(s: FloatArray, b: FloatArray, parameters: int) -> FloatArray:
    """The parameters in the order of `EllipsoidFit.values`."""
    off = [s[0, 1], s[0, 2], s[1, 2]] if parameters == 9 else []
    return np.concatenate((np.diag(s), off, b))


def sensor(
    seed: int, parameters: int, *, count: int = 400, norm: float = 48.0, noise: float = 0.4, iron: float = 40.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Readings (count, 3) of a sensor with white noise of its own, turned at random, and its S and b."""
    random = np.random.default_rng(seed)
    s = symmetric(random, parameters)
    b = random.uniform(-iron, iron, 3)
    x = norm * directions(random, count) @ np.linalg.inv(s).T + b
    return x + noise * random.standard_normal(x.shape), s, b
