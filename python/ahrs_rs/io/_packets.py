"""Times of packets that carry a number and, mostly, the sensor's clock: as Xsens and Movella write them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._stamps import unwrapped

COUNTER, FINE = "PacketCounter", "SampleTimeFine"
#: The clock has so many bits; the numbers have so few, unless one is larger.
CLOCK_BITS, COUNTER_BITS = 32, 16


def packet_times(
    count: int,
    counter: NDArray[Any] | None,
    clock: NDArray[Any] | None,
    unit: float,
    stated: float | None,
    options: Options,
    data: SensorData,
) -> FloatArray:
    """Times of the packets, s, 0 at the first; what was lost and which clock it is, is told to `data`.

    Parameters
    ----------
    count : packets.
    counter, clock : (count,) their numbers and the sensor's clock, NaN where missing; None without such a column.
    unit : of the clock, s.
    stated : packets a second, as the file says.
    options : a given rate goes before the sensor's clock. Missing packets are gaps in time with it, too.

    Raises
    ------
    ValueError
        There is no clock, and no rate either.
    """
    numbers = _unwrapped(counter)
    if numbers is not None:
        known = numbers[np.isfinite(numbers)]
        lost = int(known.max() - known.min()) + 1 - len(np.unique(known))
        if lost:
            data.say("lost", f"{lost} of {lost + count} packets by {COUNTER}; they are gaps in time")
    if clock is not None and options.rate is None and np.isfinite(np.asarray(clock, dtype=np.float64)).sum() > 1:
        data.meta["clock"] = f"{FINE} of the sensor"
        return _by_clock(unwrapped(clock, CLOCK_BITS) * unit, numbers)
    rate = options.rate or stated
    if rate is None:
        raise ValueError(f"has packet numbers, but neither {FINE} nor an update rate: give rate=")
    if numbers is None:
        data.meta["clock"] = "none: rows at the stated rate"
        return np.arange(count) / rate
    data.meta["clock"] = f"{COUNTER} at {rate:g} Hz"
    times: FloatArray = (numbers - numbers[np.isfinite(numbers)][0]) / rate
    return times


def _unwrapped(counter: NDArray[Any] | None) -> FloatArray | None:
    if counter is None:
        return None
    values = np.asarray(counter, dtype=np.float64)
    if not np.isfinite(values).any():
        return None
    return unwrapped(values, CLOCK_BITS if np.nanmax(values) >= 2.0**COUNTER_BITS else COUNTER_BITS)


def _by_clock(t: FloatArray, numbers: FloatArray | None) -> FloatArray:
    """Times from the first on; a packet without one stands between its neighbours by its number."""
    t = t - t[np.isfinite(t)][0]
    if numbers is not None:
        known = np.isfinite(t) & np.isfinite(numbers)
        missing = ~np.isfinite(t) & np.isfinite(numbers)
        if missing.any() and known.any() and (np.diff(numbers[known]) > 0).all():
            t[missing] = np.interp(numbers[missing], numbers[known], t[known], left=np.nan, right=np.nan)
    return t
