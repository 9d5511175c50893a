"""Stamps as devices write them: integers since a start or since 1970, counters that wrap, packets that were lost."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray

#: A clock that shows more seconds than this counts since an epoch, not since the device was switched on (3 years).
EPOCH = 1e8
#: What a clock since 1970 can show: from 1990 to 2100, s.
UNIX = (631152000.0, 4102444800.0)


def seconds(stamps: Mapping[str, NDArray[Any]], unit: float) -> tuple[dict[str, FloatArray], float]:
    """Stamps of the streams of one device in seconds, exact where they count since an epoch.

    Parameters
    ----------
    stamps : stream -> (n,) integers or floats of one clock.
    unit : of the stamps, s.

    Returns
    -------
    times : stream -> (n,) float64 s. As the clock shows them; since the earliest stamp where that is beyond 3 years, as
        the sum of an epoch and a step of 1 µs has no room in a float64.
    origin : what the clock showed at t = 0, s (0 where nothing was taken off).
    """
    finite = [
        array if array.dtype.kind != "f" or np.isfinite(array.sum()) else array[np.isfinite(array)]
        for array in stamps.values()
    ]
    firsts = [array.min() for array in finite if len(array)]
    first = min(firsts) if firsts else 0
    if not abs(float(first)) * unit > EPOCH:
        return {name: np.asarray(array, dtype=np.float64) * unit for name, array in stamps.items()}, 0.0
    whole = int(first) if float(first).is_integer() or isinstance(first, np.integer) else first
    times = {}
    for name, array in stamps.items():
        if array.dtype.kind in "iu":
            # Unsigned differences wrap; of 64 bits, both sides are below 2^63 where they are times.
            times[name] = (array.astype(np.int64) - np.int64(whole)).astype(np.float64) * unit
        else:
            times[name] = (np.asarray(array, dtype=np.float64) - float(whole)) * unit
    return times, float(whole) * unit


def utc(origin: float) -> str | None:
    """A time since 1970 in ISO 8601, UTC; None where it can be none (see `UNIX`)."""
    if not UNIX[0] <= origin <= UNIX[1]:
        return None
    return datetime.datetime.fromtimestamp(origin, datetime.UTC).isoformat()


def unwrapped(counter: NDArray[Any], bits: int) -> FloatArray:
    """A counter of so many bits without its wraps: every step is taken as the shortest one forward or back.

    Parameters
    ----------
    counter : (n,) integers, or floats with NaN where one is missing.
    bits : after which it starts again.

    Returns
    -------
    ndarray
        (n,) float64, from the first value on. A step of more than half of the range is a wrap; late packets stay late.
    """
    values = np.asarray(counter, dtype=np.float64)
    known = np.isfinite(values)
    size = float(2**bits)
    steps = np.diff(values[known])
    turns = -np.round(steps / size)
    out = np.full(values.shape, np.nan)
    if known.any():
        out[known] = values[known] + size * np.concatenate([[0.0], np.cumsum(turns)])
    return out


def wrap_of(stamps: NDArray[Any]) -> int:
    """After how many bits (16 or 32) whole numbers of a clock start again, 0 where they do not.

    A clock that wraps falls from the end of its range to the beginning, by nearly all of it, and no number is beyond. A
    device that was switched off and on is told from it where more than a twentieth of the range is missing between.
    """
    if not (stamps[1:] < stamps[:-1]).any():
        return 0
    known = stamps[np.isfinite(stamps)] if stamps.dtype.kind == "f" else stamps
    if known.min() < 0 or not np.array_equal(known, known // 1):
        return 0
    steps = np.diff(known.astype(np.float64))
    for bits in (16, 32):
        size = float(2**bits)
        falls = steps[steps < -0.5 * size]
        if known.max() < size and falls.size and falls.max() < -0.95 * size:
            return bits
    return 0
