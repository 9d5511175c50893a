"""The nominal rate of stamps, however they come: regular, in packets, in pairs, by a coarse clock, with gaps."""

from __future__ import annotations

import numpy as np

from ahrs_rs._typing import FloatArray

#: A step (or a sum of steps) is usual within this part of the median.
USUAL = 0.25
#: Steps of a regular clock: so many are usual, and no more than so many are shorter than half of the median.
REGULAR, SHORT = 0.5, 0.05
#: Sums over packets: so many have to be usual. Fewer than this are broken by gaps, or the packets are longer.
PACKED = 0.8
#: A step of a regular clock that is longer than so many medians has lost at least one sample in between.
LOST = 1.75
#: The time between packets is usually longer than so many medians; where samples are lost, usually one or two are.
BETWEEN = 4.0
#: A packet that takes longer than so many medians.
LATE = 1.5
#: The longest packets that are looked for, in samples.
LONGEST_PACKET = 512
#: Where nothing is alike, a step that is longer than so many usual ones is a gap.
BREAK = 10.0
#: Steps from which the usual one is found, evenly over all.
SOME = 1 << 16
#: Sums that are needed before they tell anything.
FEWEST = 8


def median(values: FloatArray) -> float:
    """The median of some numbers without NaN; numpy's own imports masked arrays for it."""
    half = len(values) // 2
    if len(values) % 2:
        return float(np.partition(values, half)[half])
    low, high = np.partition(values, (half - 1, half))[half - 1 : half + 1].tolist()
    return float(0.5 * (low + high))


def unbroken(t: FloatArray) -> tuple[FloatArray, int]:
    """The times that unbroken parts take, and how many samples each of them has.

    The times between samples of a regular clock are nearly all alike, and a longer one is a gap. Stamps that come in
    packets, in pairs, or from a clock that ticks slower than the samples have many steps of nothing and few long ones:
    there the times of 2, 4, 8, ... samples are looked at, until they are alike.

    Parameters
    ----------
    t : (T,) s, finite and not decreasing.

    Returns
    -------
    durations : (n,) s, those of the parts without a gap
    samples : int, steps in each of them
    """
    samples = 1
    while samples == 1 or (samples <= LONGEST_PACKET and (len(t) - 1) // samples >= FEWEST):
        durations = np.diff(t[::samples])
        middle = median(durations[:: max(durations.size // SOME, 1)]) if durations.size else 0.0
        if middle > 0.0:
            usual = np.count_nonzero(np.abs(durations - middle) <= USUAL * middle) / durations.size
            short = np.count_nonzero(durations < 0.5 * middle) / durations.size
            alike = usual >= (REGULAR if samples == 1 else PACKED) and short <= SHORT
            if alike and not (samples == 1 and _in_packets(durations, middle)):
                longest = LOST if samples == 1 else LATE
                return durations[durations <= longest * middle], samples
        samples *= 2
    durations = np.diff(t)
    steps = durations[durations > 0.0]
    return durations[durations <= BREAK * median(steps)] if steps.size else durations, 1


def _in_packets(steps: FloatArray, usual: float) -> bool:
    """Whether most of the time passes in long steps that come again and again: between packets, not in gaps."""
    long = steps[steps > LOST * usual]
    often = long.size > SHORT * steps.size and median(long) > BETWEEN * usual
    return often and float(long.sum()) > 0.5 * float(steps.sum())


def nominal_rate(t: FloatArray) -> float:
    """Samples a second, over the parts of `t` without a gap.

    Parameters
    ----------
    t : (T,) s, finite and not decreasing.

    Returns
    -------
    float
        Hz. Without a gap (T - 1) / (t[-1] - t[0]), of stamps that are repeated at the ends whole packets only.

    Raises
    ------
    ValueError
        All times are the same.

    Examples
    --------
    >>> import numpy as np
    >>> float(nominal_rate(np.arange(2000) // 4 * 0.04))  # four samples in a packet
    100.0
    """
    if not len(t) or not t[-1] > t[0]:
        raise ValueError("rate: expected a number, as t has no two different times, got None")
    durations, samples = unbroken(t)
    if durations.size * samples >= (len(t) - 1) // samples * samples:  # nothing is broken: the whole counts
        # From the first sample of one packet to the first of another: a part of a packet would count for nothing.
        return float(np.searchsorted(t, t[-1]) / (t[-1] - t[0]))
    return float(durations.size * samples / durations.sum())
