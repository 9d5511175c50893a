"""Where a sensor rests, from its readings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs._typing import FloatArray

#: What is called a rest: window, s; standard deviations, rad/s and m/s²; mean rate, rad/s; shortest phase, s.
WINDOW, GYR_DEVIATION, ACC_DEVIATION, GYR_MEAN, SHORTEST = 1.0, 0.01, 0.1, 0.1, 2.0


class Stillness(NamedTuple):
    """The phases in which a sensor rests, and what they were found by."""

    phases: tuple[slice, ...]
    gyr: FloatArray
    """(T,) moving standard deviation, root of the sum over the axes, rad/s."""
    acc: FloatArray | None
    """(T,) the same, m/s²; None without an accelerometer."""


def find(
    t: FloatArray,
    gyr: FloatArray,
    acc: FloatArray | None,
    half: int,
    gyr_deviation: float = GYR_DEVIATION,
    acc_deviation: float = ACC_DEVIATION,
    gyr_mean: float = GYR_MEAN,
    shortest: float = SHORTEST,
) -> Stillness:
    """The rests in readings (T, 3), by the rules of `calibration.find_rest`; a window has `half` samples each way."""
    mean, turning = moving(gyr, half)
    mask = (turning <= gyr_deviation) & (np.sqrt(np.sum(mean**2, axis=1)) <= gyr_mean)
    shaking = None
    if acc is not None:
        shaking = moving(acc, half)[1]
        mask &= shaking <= acc_deviation
    phases = tuple(one for one in runs(mask) if t[one.stop - 1] - t[one.start] >= shortest * (1.0 - 1e-9))
    return Stillness(phases, turning, shaking)


def moving(values: ArrayLike, half: int) -> tuple[FloatArray, FloatArray]:
    """Mean (T, 3) and standard deviation (T,) over the samples within `half` of each; NaN where too few are there."""
    array = np.asarray(values, dtype=np.float64)
    measured: NDArray[np.bool_] = np.logical_not(np.isnan(array).any(axis=1))
    if not measured.any():
        return np.full_like(array, np.nan), np.full(len(array), np.nan)
    # Near zero, so that sums of squares do not cancel.
    centre = np.median(array[measured], axis=0)
    array = np.where(measured[:, np.newaxis], array - centre, 0.0)
    first = np.maximum(np.arange(len(array)) - half, 0)
    last = np.minimum(np.arange(len(array)) + half + 1, len(array))

    def windowed(terms: FloatArray) -> FloatArray:
        sums = np.concatenate((np.zeros((1, terms.shape[1])), np.cumsum(terms, axis=0)))
        total: FloatArray = sums[last] - sums[first]
        return total

    count = windowed(measured[:, np.newaxis].astype(np.float64))
    enough = count[:, 0] >= np.maximum(0.5 * (last - first), 2.0)
    count = np.where(enough[:, np.newaxis], count, np.nan)
    mean = windowed(array) / count
    variance = windowed(array**2) / count - mean**2
    return mean + centre, np.sqrt(np.maximum(variance, 0.0).sum(axis=1))


def runs(mask: NDArray[np.bool_]) -> Iterator[slice]:
    """The slices in which the mask is true."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    for start, stop in edges.reshape(-1, 2).tolist():
        yield slice(start, stop)
