"""Calibration of gyroscope, accelerometer and magnetometer. One model everywhere: y = S (x − b).

>>> import numpy as np
>>> import ahrs_rs as ar
>>> random = np.random.default_rng(0)
>>> field = random.standard_normal((2000, 3))
>>> field *= 48.0 / np.linalg.norm(field, axis=1, keepdims=True)
>>> fit = ar.calibration.magnetometer(field + [12.0, -3.0, 5.0])
>>> fit.calibration.offset.round(6)
array([12., -3.,  5.])

`magnetometer` and `accelerometer` fit the ellipsoid that readings in all directions lie on; `six_positions` an
accelerometer that was held still; `gyroscope` bias and gain from rests and known turns; `ferraris` both by six
positions and three turns; `two_temperatures` and the `warm_up_...` functions what changes with the temperature;
`mag_delay` how late a magnetometer is. `Calibrations` holds what is known of a sensor, applies it to recordings, and is
saved as cal.json, as Rust and as a C header; `store` keeps it by device and date, and `find` finds it again.
"""

from ahrs_rs._constants import GRAVITY
from ahrs_rs.calibration._allan import Allan, Coefficient, allan, allan_deviation
from ahrs_rs.calibration._calibrations import Calibrations, load
from ahrs_rs.calibration._common import CalibrationError, CalibrationWarning
from ahrs_rs.calibration._ellipsoid import accelerometer, ellipsoid, magnetometer
from ahrs_rs.calibration._ferraris import FerrarisFit, ferraris
from ahrs_rs.calibration._fit_result import EllipsoidFit
from ahrs_rs.calibration._gyroscope import GyroscopeFit, gyroscope, gyroscope_from_reference
from ahrs_rs.calibration._live import LiveMagnetometer
from ahrs_rs.calibration._mag_delay import MagDelay, mag_delay
from ahrs_rs.calibration._model import Calibration, TemperatureCalibration
from ahrs_rs.calibration._noise import Noise, SensorNoise, noise
from ahrs_rs.calibration._positions import PositionsFit, held_attitudes, six_positions
from ahrs_rs.calibration._rest import GyroscopeBias, Rest, find_rest, gyroscope_bias
from ahrs_rs.calibration._store import devices, find, store, stored
from ahrs_rs.calibration._temperature import two_temperatures, warm_up_accelerometer, warm_up_gyroscope
from ahrs_rs.calibration._turns import Turn
from ahrs_rs.calibration._windows import gyroscope_rests

__all__ = [
    "GRAVITY",
    "Allan",
    "Calibration",
    "CalibrationError",
    "CalibrationWarning",
    "Calibrations",
    "Coefficient",
    "EllipsoidFit",
    "FerrarisFit",
    "GyroscopeBias",
    "GyroscopeFit",
    "LiveMagnetometer",
    "MagDelay",
    "Noise",
    "PositionsFit",
    "Rest",
    "SensorNoise",
    "TemperatureCalibration",
    "Turn",
    "accelerometer",
    "allan",
    "allan_deviation",
    "devices",
    "ellipsoid",
    "ferraris",
    "find",
    "find_rest",
    "gyroscope",
    "gyroscope_bias",
    "gyroscope_from_reference",
    "gyroscope_rests",
    "held_attitudes",
    "load",
    "mag_delay",
    "magnetometer",
    "noise",
    "six_positions",
    "store",
    "stored",
    "two_temperatures",
    "warm_up_accelerometer",
    "warm_up_gyroscope",
]
