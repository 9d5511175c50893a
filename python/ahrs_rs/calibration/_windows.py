"""Windows of a recording in which an accelerometer shows gravity alone, and the attitudes in which a sensor was held.

This is a selection of readings for a fit: each window is judged by itself, at no rate but its own length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._common import GRAVITY, FloatArray, positive

#: Windows vary at rest by at most so many times the spread of the quietest tenth of all windows ...
TIMES_QUIETEST = 3.0
#: ... and never by more than the second of these, nor need they by less than the first: m/s² (16 bits over 16 g are
#: steps of 5 mm/s²) and rad/s (16 bits over 2000 °/s are steps of 1 mrad/s).
ACC_LIMITS = (5e-3, 0.05 * GRAVITY)
GYR_LIMITS = (1e-3, 0.05)


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
