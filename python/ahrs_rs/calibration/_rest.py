"""Where a sensor rests in a recording, and the bias of its gyroscope there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._recording import Recording
from ahrs_rs._stillness import ACC_DEVIATION, GYR_DEVIATION, GYR_MEAN, SHORTEST, WINDOW, find
from ahrs_rs._typing import FloatArray

__all__ = ["GyroscopeBias", "Rest", "find_rest", "gyroscope_bias"]


#: Blocks in which the mean of a rest is taken for its standard error.
BLOCKS = 16


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """Where a sensor rests.

    Parameters
    ----------
    mask : ndarray
        (T,) whether the sensor rests at a sample.
    phases : tuple of slice
        The rests, slices of the samples.
    t : ndarray
        (T,) the times, s.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=10.0)
    >>> rest = ar.calibration.find_rest(rec)
    >>> bool(rest.mask.all()), len(rest.phases)
    (True, 1)
    """

    mask: NDArray[np.bool_]
    phases: tuple[slice, ...]
    t: FloatArray

    @property
    def seconds(self) -> tuple[tuple[float, float], ...]:
        """First and last time of each phase, s."""
        return tuple((float(self.t[one.start]), float(self.t[one.stop - 1])) for one in self.phases)

    @property
    def longest(self) -> slice:
        """The phase with the most samples."""
        return max(self.phases, key=lambda one: one.stop - one.start)

    @property
    def duration(self) -> float:
        """All phases together, s."""
        return sum(end - start for start, end in self.seconds)


@dataclass(frozen=True, slots=True, eq=False)
class GyroscopeBias:
    """What a gyroscope reads at rest.

    Parameters
    ----------
    value : ndarray
        (3,) rad/s.
    standard_error : ndarray
        (3,) rad/s, of the mean over these rests: the bias at another time differs by its
        instability.
    samples : int
        How many were at rest.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> rest = ar.simulate.still()
    >>> rec = ar.simulate.record(rest, rate=100.0, duration=10.0)
    >>> bias = ar.calibration.gyroscope_bias(rec)
    >>> np.abs(bias.value).max() < 1e-9
    np.True_
    """

    value: FloatArray
    standard_error: FloatArray
    samples: int


def find_rest(
    recording: Recording,
    *,
    window: float = WINDOW,
    gyr_deviation: float = GYR_DEVIATION,
    acc_deviation: float = ACC_DEVIATION,
    gyr_mean: float = GYR_MEAN,
    shortest: float = SHORTEST,
) -> Rest:
    """Find the phases in which the sensor rests.

    A sample is at rest where, over the window around it, the standard deviations of angular rate and specific force
    (root of the sum over the axes' variances) and the norm of the mean angular rate are all below their thresholds: the
    last one tells a slow steady rotation from a bias. The window makes a phase begin and end half of it away from
    motion. Rows with a NaN do not count; where less than half of a window is measured nothing is known, and that is no
    rest.

    Parameters
    ----------
    recording : Recording
        With a gyroscope; the accelerometer is used where it is there.
    window : float, optional
        s.
    gyr_deviation : float, optional
        Rad/s (0.01 rad/s is 0.6 °/s; sensors at rest have 0.05 to 0.3 °/s).
    acc_deviation : float, optional
        M/s².
    gyr_mean : float, optional
        Rad/s, above the largest bias (0.1 rad/s is 6 °/s).
    shortest : float, optional
        S; shorter phases do not count.

    Returns
    -------
    Rest
        Where it rests.

    Raises
    ------
    ValueError
        A threshold that is not positive, or no rest; the message says how close to it the recording came.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=10.0)
    >>> len(ar.calibration.find_rest(rec).phases)
    1
    """
    numbers = {"window": window, "gyr_deviation": gyr_deviation, "acc_deviation": acc_deviation}
    for name, value in {**numbers, "gyr_mean": gyr_mean, "shortest": shortest}.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name}: expected a positive number, got {value}")
    half = max(1, round(0.5 * window * recording.rate))
    if len(recording) < 2 * half + 1:
        have = f"{len(recording)} samples at {recording.rate:g} Hz"
        raise ValueError(f"recording: expected more than a window of {window:g} s, got {have}")
    phases, gyr, acc = find(
        recording.t, recording.require("gyr"), recording.acc, half, gyr_deviation, acc_deviation, gyr_mean, shortest
    )
    if not phases:
        came = f"the smallest deviations are {_smallest(gyr):.2g} rad/s"
        if acc is not None:
            came += f" and {_smallest(acc):.2g} m/s²"
        limits = f"{gyr_deviation:g} rad/s and {acc_deviation:g} m/s²"
        raise ValueError(
            f"recording: expected a rest of {shortest:g} s or more with deviations below {limits}, but {came}"
        )
    found = np.zeros(len(recording), dtype=np.bool_)
    for one in phases:
        found[one] = True
    return Rest(found, phases, recording.t)


def gyroscope_bias(recording: Recording, rest: Rest | None = None) -> GyroscopeBias:
    """The mean angular rate at rest, with its standard error.

    The standard error is that of white noise, σ/√n, or what the means of 16 blocks say (the Allan deviation of the
    blocks over √16, which knows drift), whichever is larger. Phases count by their samples.

    Parameters
    ----------
    recording : Recording
        Its rows of `gyr` with a NaN do not count.
    rest : Rest, optional
        From `find_rest`, which is called where None is given.

    Returns
    -------
    GyroscopeBias
        The bias.

    Raises
    ------
    ValueError
        No rest, or fewer than 32 samples in it.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=10.0)
    >>> np.abs(ar.calibration.gyroscope_bias(rec).value).max() < 1e-9
    np.True_
    """
    rest = find_rest(recording) if rest is None else rest
    samples = recording.require("gyr")[rest.mask]
    samples = samples[~np.isnan(samples).any(axis=1)]
    if len(samples) < 2 * BLOCKS:
        raise ValueError(f"gyr: expected at least {2 * BLOCKS} samples at rest, got {len(samples)}")
    value = samples.mean(axis=0)
    white = samples.var(axis=0, ddof=1) / len(samples)
    blocks = np.stack([block.mean(axis=0) for block in np.array_split(samples, BLOCKS)])
    drifting = 0.5 * np.mean(np.diff(blocks, axis=0) ** 2, axis=0) / BLOCKS
    return GyroscopeBias(value, np.sqrt(np.maximum(white, drifting)), len(samples))


def _smallest(deviation: FloatArray) -> float:
    return float(np.nanmin(deviation)) if not np.isnan(deviation).all() else math.nan
