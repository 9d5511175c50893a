"""Calibration of sensors: what their noise is, and where they rest."""

from ahrs_rs.calibration.allan import Allan, Coefficient, allan, allan_deviation
from ahrs_rs.calibration.noise import Noise, SensorNoise, noise
from ahrs_rs.calibration.rest import GyroscopeBias, Rest, find_rest, gyroscope_bias

__all__ = [
    "Allan",
    "Coefficient",
    "GyroscopeBias",
    "Noise",
    "Rest",
    "SensorNoise",
    "allan",
    "allan_deviation",
    "find_rest",
    "gyroscope_bias",
    "noise",
]
