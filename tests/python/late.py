"""Recordings whose magnetometer is late, with the truth."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

import ahrs_rs as ar

RATE = 100.0
#: Readings are drawn from a recording of this rate: delays are multiples of a millisecond.
FINE = 1000.0


def late(delay: float, seed: int = 0, duration: float = 60.0, recording: ar.Recording | None = None) -> ar.Recording:
    """A motion at 100 Hz whose magnetometer shows the field of `delay` s ago; without noise.

    The angular rate of a sample is the mean since the one before, as in `ar.simulate`.
    """
    fine = recording or ar.simulate.demo(duration, FINE, seed, noise=False)
    assert fine.acc is not None
    assert fine.mag is not None
    assert fine.ref is not None
    step, shift = round(fine.rate / RATE), round(delay * fine.rate)
    first = -(-shift // step) * step + step - 1  # the first sample with a whole step before it, and a field of then
    index = np.arange(first, len(fine), step)
    gyr = fine.gyr[: len(fine) // step * step].reshape(-1, step, 3).mean(axis=1)
    return ar.Recording(
        t=fine.t[index],
        rate=RATE,
        gyr=gyr[index // step],
        acc=fine.acc[index],
        mag=fine.mag[index - shift],
        ref=fine.ref[index],
        meta={"ref_frame": "ENU"},
    )


def noisy(recording: ar.Recording, seed: int, *, gyr: float = 2e-3, mag: float = 0.3, **changes: Any) -> ar.Recording:
    """With white noise of these standard deviations (rad/s, µT), and with other fields replaced."""
    assert recording.mag is not None
    draw = np.random.default_rng(seed)
    return dataclasses.replace(
        recording,
        gyr=recording.gyr + gyr * draw.standard_normal(recording.gyr.shape),
        mag=recording.mag + mag * draw.standard_normal(recording.mag.shape),
        **changes,
    )
