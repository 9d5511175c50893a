"""Windows of a recording in which an accelerometer shows gravity alone, and the attitudes in which a sensor was held.

This is a selection of readings for a fit: each window is judged by itself, at no rate but its own length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration._common import CalibrationError, readings

#: Windows vary at rest by at most so many times the spread of the quietest tenth of all windows ...
TIMES_QUIETEST = 3.0
#: ... and never by more than the second of these, nor need they by less than the first: m/s² (16 bits over 16 g are
#: steps of 5 mm/s²) and rad/s (16 bits over 2000 °/s are steps of 1 mrad/s).
ACC_LIMITS = (5e-3, 0.05 * GRAVITY)
GYR_LIMITS = (1e-3, 0.05)
#: What turns faster than the typical rest is a turn, rad/s.
SLOWEST_TURN = 0.1


@dataclass(frozen=True, slots=True)
class Rest:
    """The windows at rest."""

    means: FloatArray
    """(w, 3)"""
    index: NDArray[np.int64]
    """(w,) which windows they are."""
    length: int
    """Samples of a window."""


def split(x: FloatArray, rate: float, window: float) -> tuple[FloatArray, int]:
    """The readings as windows (w, length, 3); what is left over at the end is dropped."""
    length = max(round(positive("rate", rate) * positive("window", window)), 1)
    count = len(x) // length
    return x[: count * length].reshape(count, length, 3), length


def means(x: FloatArray, rate: float, window: float) -> FloatArray:
    """(w, 3) means of the windows of which at least half is there."""
    parts, length = split(x, rate, window)
    there: NDArray[np.bool_] = np.asarray(~np.isnan(parts).any(axis=2))
    enough = there.sum(axis=1) >= max(0.5 * length, 1)
    found: FloatArray = np.nanmean(np.where(there[:, :, None], parts, np.nan)[enough], axis=1)
    return found


def resting(x: FloatArray, rate: float, window: float, limits: tuple[float, float] = ACC_LIMITS) -> Rest:
    """The windows whose readings vary no more than at rest."""
    parts, length = split(x, rate, window)
    there: NDArray[np.bool_] = np.asarray(~np.isnan(parts).any(axis=2))
    enough = np.flatnonzero(there.sum(axis=1) >= max(0.5 * length, 2))
    if not enough.size:
        return Rest(np.empty((0, 3)), enough, length)
    chosen = np.where(there[:, :, None], parts, np.nan)[enough]
    mean = np.nanmean(chosen, axis=1)
    spread = np.sqrt(np.nanmean(((chosen - mean[:, None]) ** 2).sum(axis=2), axis=1))
    limit = min(max(TIMES_QUIETEST * float(np.quantile(spread, 0.1)), limits[0]), limits[1])
    still = spread <= limit
    return Rest(mean[still], enough[still], length)


def gyroscope_rests(gyr: ArrayLike, rate: float, *, hold: float = 0.5, slowest: float = SLOWEST_TURN) -> list[slice]:
    """The phases in which a gyroscope rests.

    Parameters
    ----------
    gyr : array_like
        (T, 3) angular rate in rad/s; a row with a NaN is missing.
    rate : float
        Sampling rate in Hz.
    hold : float, optional
        The shortest rest in s.
    slowest : float, optional
        A rate beyond this, in rad/s about the median of all rests, is no rest but a steady turn.

    Returns
    -------
    list of slice
        The samples of each phase.

    Raises
    ------
    CalibrationError
        The sensor does not rest for long enough.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr = np.zeros((300, 3))
    >>> gyr[100:200] = 1.0
    >>> ar.calibration.gyroscope_rests(gyr, 100.0)
    [slice(0, 100, None), slice(200, 300, None)]
    """
    window = 0.1
    rest = resting(readings("gyr", gyr)[0], rate, window, GYR_LIMITS)
    # A steady turn varies as little, about another mean.
    typical = np.median(rest.means, axis=0) if len(rest.means) else np.zeros(3)
    index = rest.index[np.linalg.norm(rest.means - typical, axis=1) < slowest]
    if not index.size:
        raise CalibrationError("gyr: the sensor does not rest: let it lie still for some seconds")
    runs = np.split(index, np.flatnonzero(np.diff(index) > 1) + 1)
    least = max(round(hold / window), 1)
    phases = [slice(int(run[0]) * rest.length, (int(run[-1]) + 1) * rest.length) for run in runs if len(run) >= least]
    if not phases:
        raise CalibrationError(
            f"gyr: the sensor does not rest for {hold} s anywhere: let it lie still for some seconds"
        )
    return phases


def attitudes(x: FloatArray, rate: float, window: float, hold: float, apart: float) -> list[slice]:
    """The samples of each attitude that was held for at least `hold` s, without the windows at both ends.

    Windows at rest one after the other are one attitude while their means are within `apart` m/s² of the first one's.
    """
    rest = resting(x, rate, window)
    runs: list[list[int]] = []
    first = np.zeros(3)
    for mean, index in zip(rest.means, rest.index, strict=True):
        if runs and index == runs[-1][1] + 1 and np.linalg.norm(mean - first) < apart:
            runs[-1][1] = int(index)
        else:
            runs.append([int(index), int(index)])
            first = mean
    least = max(round(hold / window), 3)
    return [slice((start + 1) * rest.length, stop * rest.length) for start, stop in runs if stop - start + 1 >= least]
