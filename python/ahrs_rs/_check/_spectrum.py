"""Vibration: power at high frequencies, and near the Nyquist rate, where it may be of faster vibration (aliasing)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check._case import Case
from ahrs_rs._check._findings import Finding
from ahrs_rs._welch import density

FloatArray = NDArray[np.float64]

#: RMS in the last fifth before the Nyquist rate that matters, rad/s and m/s².
NEAR = {"gyr": 0.15, "acc": 2.5}
#: RMS above 20 Hz that matters.
SHAKEN, ABOVE = {"gyr": 1.0, "acc": 5.0}, 20.0
NAMES = {"gyr": "gyroscope", "acc": "accelerometer"}
UNITS = {"gyr": "rad/s", "acc": "m/s²"}


def spectrum(case: Case, sensor: str) -> tuple[FloatArray, FloatArray] | None:
    """Frequencies, Hz, and power density summed over the axes (one-sided), by Welch's method; None without data."""
    rows = case.rows(sensor)
    if rows is None:
        return None
    found = density(rows, case.rate)
    return None if found is None else (found[0], found[1] * case.factors[sensor] ** 2)


def check_spectrum(case: Case) -> Iterator[Finding]:
    """Findings about vibration."""
    for sensor in ("gyr", "acc"):
        if sensor not in case.has:
            continue
        found = spectrum(case, sensor)
        if found is None:
            continue
        frequency, density = found
        width = frequency[1]
        nyquist = frequency[-1]
        top = frequency > 0.8 * nyquist
        middle = (frequency > 0.4 * nyquist) & (frequency <= 0.6 * nyquist)
        near = float(np.sqrt(density[top].sum() * width))
        rising = float(density[top].mean() / max(density[middle].mean(), 1e-30))
        if near > NEAR[sensor] and rising > 0.7:
            yield Finding(
                f"{sensor}.aliasing",
                "warning" if rising > 1.5 else "note",
                f"{near:.3g} {UNITS[sensor]} (RMS) of the {NAMES[sensor]} lie just below the Nyquist rate "
                f"({nyquist:.4g} Hz): faster vibration may look like slow motion",
                near,
                UNITS[sensor],
                0.6,
                "vibration is integrated as turns"
                if sensor == "gyr"
                else "the vertical is off by the mean of vibration",
                "a higher rate, or the sensor's own low-pass filter below half of the rate",
                {"rising": rising},
            )
        high = frequency > ABOVE
        shaken = float(np.sqrt(density[high].sum() * width)) if high.any() else 0.0
        if shaken > SHAKEN[sensor]:
            yield Finding(
                f"{sensor}.vibration",
                "note",
                f"{shaken:.3g} {UNITS[sensor]} (RMS) of the {NAMES[sensor]} lie above {ABOVE:.0f} Hz",
                shaken,
                UNITS[sensor],
                0.8,
                "the accelerometer shows vibration rather than up"
                if sensor == "acc"
                else "small errors of stamps count",
                "mount it softer; a filter with a long time constant of the accelerometer",
            )
