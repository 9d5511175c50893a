"""What all of the chain takes: attitudes of two sensors at the same times, and unit vectors."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _validate
from ahrs_rs._estimate import Estimate
from ahrs_rs._status import Status
from ahrs_rs._typing import FloatArray

#: Status bits of rows whose attitude is unknown: one of these, or both of those (nothing was measured).
LOST, NOTHING = Status.NOT_ALIGNED | Status.RECOVERING, Status.GYR_HELD | Status.ACC_MISSING
#: An estimate of a filter, or quaternions (..., 4).
Attitudes: TypeAlias = Estimate | ArrayLike


def quaternions(name: str, given: Attitudes) -> FloatArray:
    """Unit quaternions (..., 4), float64; of an estimate NaN where it says itself that it does not know."""
    if not isinstance(given, Estimate):
        return _validate.unit_quaternions(name, given).astype(np.float64, copy=False)
    quat = _validate.unit_quaternions(name, given.quat).astype(np.float64)
    quat[((given.status & LOST) != 0) | ((given.status & NOTHING) == NOTHING)] = np.nan
    return quat


def pair(first: Attitudes, second: Attitudes) -> tuple[FloatArray, FloatArray]:
    """Attitudes of two sensors, at the same times and in the same earth frame."""
    p, q = quaternions("first", first), quaternions("second", second)
    if isinstance(first, Estimate) and isinstance(second, Estimate):
        if first.frame != second.frame:
            raise ValueError(
                f"second: expected an estimate in the frame of the first, {first.frame}, got {second.frame}"
            )
        if first.t.shape == second.t.shape and first.t.size > 1:
            apart = float(np.max(np.abs(first.t - second.t)))
            if apart > 0.5 * float(np.median(np.diff(first.t, axis=-1))):
                raise ValueError(
                    f"second: expected the times of the first, got times that are up to {apart:.3g} s from them "
                    "(synchronise finds the clocks, ClockOffset.onto brings a recording to the stamps of another)"
                )
    if p.shape != q.shape:
        raise ValueError(f"second: expected the shape of the first, {p.shape}, got {q.shape}")
    return p, q


def unit_vector(name: str, given: ArrayLike) -> FloatArray:
    """A unit vector (3,), float64."""
    vector = _validate.reals(name, given).astype(np.float64, copy=False)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not 0.0 < length < np.inf:
        raise ValueError(f"{name}: expected a vector (3,) that is not zero, got {np.array2string(vector, threshold=6)}")
    return vector / length


def clock(given: Attitudes, t: ArrayLike | None, rate: float | None, count: int) -> FloatArray:
    """The times of attitudes (count, 4): those that are given, else the estimate's."""
    if t is None and rate is None and isinstance(given, Estimate):
        t = given.t
    return _validate.times("t", t, rate, count)
