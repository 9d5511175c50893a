"""The clocks of two recordings, by their angular rates.

The norm of the angular rate is the same in every sensor of a rigid body, however it is mounted, and across a hinge the
norm of its part that is perpendicular to the axis. Of such two signals the offset is where their cross-correlation is
largest: over everything on a coarse clock, then in blocks, between samples, by the phases of the cross-spectrum.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _lags, _validate
from ahrs_rs._rate import median
from ahrs_rs._recording import Recording
from ahrs_rs._streams import Stream, make_stream
from ahrs_rs._typing import FloatArray
from ahrs_rs.chain._hinge import HingeAxis

__all__ = ["ClockOffset", "synchronise"]

#: The coarse clock, Hz, and the shortest overlap, s.
COARSE, SHORTEST = 50.0, 2.0
#: The least correlation of the coarse clock, and of a block that counts.
CORRELATION = 0.5
#: Blocks are at least so long, s, and at most so many; the clocks are compared at this rate at most, Hz.
BLOCK, BLOCKS, FASTEST = 10.0, 60, 200.0
#: What bodies do is slower than this, Hz; what is faster is noise.
BAND = 15.0
#: In a block the offset is looked for within this of the coarse one, s: two steps, and crystals of 100 ppm in an hour.
NEAR = 0.4
ROUNDS, STEPS = 3, 20
#: Blocks whose offset is farther from the line than so many standard deviations do not count.
OUTLIER = 5.0
NORMAL = 1.4826


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """What the clock of the first recording shows when that of the second shows t: t + offset + skew (t - origin).

    Parameters
    ----------
    offset : float
        S, to be added to the times of the second recording.
    skew : float
        By how much the first clock is faster: 2e-5 is 20 ppm. 0 where it was not asked for.
    origin : float
        S on the second clock: the middle of what both have recorded.
    std : float
        Standard deviation of the offset, s, by how blocks of the recordings differ; NaN of a single block.
    correlation : float
        Of the logarithms of the rates at this offset.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.chain.ClockOffset(2.0, 0.0, 0.0, 0.001, 0.9).apply([0.0, 0.5])
    array([2. , 2.5])
    """

    offset: float
    skew: float
    origin: float
    std: float
    correlation: float

    def apply(self, t: ArrayLike) -> FloatArray:
        """Times of the second recording on the clock of the first.

        Parameters
        ----------
        t : array_like
            Times of the second recording, s.

        Returns
        -------
        ndarray
            Times of the first, s.
        """
        times = _validate.reals("t", t).astype(np.float64, copy=False)
        return times + self.offset + self.skew * (times - self.origin)

    def onto(self, recording: Recording, t: ArrayLike) -> Recording:
        """The second recording on stamps of the first.

        Parameters
        ----------
        recording : Recording
            The second one.
        t : array_like
            (T,) stamps of the first recording, s.

        Returns
        -------
        Recording
            In rows at t: means of the angular rate over the steps, lines between readings of other sensors. NaN where
            it has recorded nothing, and over gaps.
        """
        stamps = _validate.times("t", t, None, np.size(np.asarray(t)))
        moved = {name: Stream(self.apply(one.t), one.values) for name, one in recording.streams.items()}
        rows: dict[str, Any] = {}
        for name in ("gyr", "acc", "mag", "ref", "temperature"):
            if name in moved:
                one = moved[name]
                how = one.averaged if name == "gyr" else one.turning if name == "ref" else one.linear
                rows[name] = how(stamps)
        return Recording(t=stamps, meta={**recording.meta, "clock": self.offset}, **rows)


def synchronise(
    first: Recording | tuple[ArrayLike, ArrayLike],
    second: Recording | tuple[ArrayLike, ArrayLike],
    *,
    axis: HingeAxis | None = None,
    skew: bool = False,
) -> ClockOffset:
    """The offset between the clocks of two sensors that turn together.

    Both are on one segment, or on two whose joint moves little against what both do together; across a hinge `axis`
    makes it exact.

    Parameters
    ----------
    first : Recording or tuple of array_like
        Of the first sensor; or times (n,) in s and angular rates (n, 3) in rad/s.
    second : Recording or tuple of array_like
        Of the second sensor, by its own clock and at its own rate.
    axis : HingeAxis, optional
        The axis of the hinge between them (`hinge_axis`, after a first offset): what is across it counts.
    skew : bool, optional
        Whether to look for a difference of the clocks' rates, too; for recordings of minutes and longer.

    Returns
    -------
    ClockOffset
        The offset, to a part of a sample, and its uncertainty.

    Raises
    ------
    ValueError
        No gyroscope, less than 2 s, or rates that agree at no offset.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=30.0)
    >>> found = ar.chain.synchronise(rec, (rec.t[::2] - 7.5, rec.gyr[::2]))
    >>> round(found.offset, 2)
    7.5
    """
    one, other = _rates("first", first), _rates("second", second)
    if axis is not None:
        if not isinstance(axis, HingeAxis):
            raise ValueError(f"axis: expected a HingeAxis (what hinge_axis gives), got {axis!r}")
        one, other = _across(one, axis.first), _across(other, axis.second)
    coarse, correlation = _coarse(one, other)
    rate = min(max(one.rate, other.rate), FASTEST)
    begin = max(one.t[0], other.t[0] + coarse)
    end = min(one.t[-1], other.t[-1] + coarse)
    count = int(min(max((end - begin) // BLOCK, 1), BLOCKS))
    edges = np.linspace(begin, end, count + 1)
    origin = 0.5 * (begin + end) - coarse
    offset, slope, std = coarse, 0.0, math.nan
    for _ in range(ROUNDS):
        found = []
        for low, high in itertools.pairwise(edges):
            middle = 0.5 * (low + high) - coarse
            near = offset + slope * (middle - origin)
            block = _block_offset(one, other, float(low), float(high), near, rate)
            if block is not None:
                found.append((middle - origin, *block))
        if not found:
            break
        places, offsets, weights = np.array(found).T
        offset, slope, std = _line(places, offsets, weights, skew and len(found) > 2)
    return ClockOffset(float(offset), float(slope), float(origin), float(std), correlation)


def _rates(name: str, given: Recording | tuple[ArrayLike, ArrayLike]) -> Stream:
    if isinstance(given, Recording):
        given.require("gyr")
        stream = given.streams["gyr"].present()
    elif isinstance(given, tuple) and len(given) == 2:
        stream = make_stream(name, *given).present()
    else:
        raise ValueError(f"{name}: expected a Recording, or times and angular rates, got {type(given).__name__}")
    if stream.values.ndim != 2 or stream.values.shape[1] != 3:
        raise ValueError(f"{name}: expected angular rates (n, 3), got shape {stream.values.shape}")
    if len(stream) < 2 or stream.t[-1] - stream.t[0] < SHORTEST:
        raise ValueError(f"{name}: expected at least {SHORTEST:.0f} s of angular rates, got {len(stream)} rows")
    return stream


def _across(stream: Stream, axis: FloatArray) -> Stream:
    return Stream(stream.t, np.cross(stream.values, axis))


def _coarse(one: Stream, other: Stream) -> tuple[float, float]:
    """The offset at which the norms of the rates are most alike, over all at which a third of the shorter overlaps."""
    x, y = _lags.norms_of_rates(one, COARSE), _lags.norms_of_rates(other, COARSE)
    shorter = min(x.size, y.size)
    lags, score = _lags.correlations(x, y, min(max(shorter // 3, round(SHORTEST * COARSE)), shorter))
    if np.isnan(score).all():
        raise ValueError("second: too little overlaps, or nothing turns: an offset cannot be found")
    best = int(np.nanargmax(score))
    if not score[best] >= CORRELATION:
        raise ValueError(
            f"second: its rates of turn agree with those of the first at no offset (correlation {score[best]:.2f}): do "
            "they show the same motion?"
        )
    return float(one.t[0] - other.t[0] + lags[best] / COARSE), float(score[best])


def _block_offset(
    one: Stream, other: Stream, low: float, high: float, near: float, rate: float
) -> tuple[float, float] | None:
    """The offset in a part of the recordings, and its weight; None where nothing turns alike."""
    # Both clocks begin with a sample, so that samples of one rate are taken as they are.
    start = one.t[min(int(np.searchsorted(one.t, low)), len(one) - 1)]
    begun = other.t[int(np.argmin(np.abs(other.t + near - start)))]
    shift = float(start - begun)
    count = int((high - low - abs(start - low)) * rate)
    if count < SHORTEST * rate * 0.5:
        return None
    steps = np.arange(count) / rate
    x, y = (np.linalg.norm(each.linear(at + steps), axis=1) for each, at in ((one, start), (other, begun)))
    if np.isnan(x).any() or np.isnan(y).any():
        there = ~np.isnan(x + y)
        if np.count_nonzero(there) < 0.8 * count:
            return None
        x, y = (np.where(there, each, each[there].mean()) for each in (x, y))
    taper = np.hanning(count)
    x, y = taper * (x - np.average(x, weights=taper)), taper * (y - np.average(y, weights=taper))
    size = 1 << (2 * count).bit_length()
    waves = 2.0 * math.pi * np.fft.rfftfreq(size, 1.0 / rate)
    low_pass = waves <= 2.0 * math.pi * min(BAND, 0.4 * rate)
    a, b = np.fft.rfft(x, size) * low_pass, np.fft.rfft(y, size) * low_pass
    power = math.sqrt(float(np.sum(np.abs(a) ** 2) * np.sum(np.abs(b) ** 2)))
    if not power > 0.0:
        return None
    cross = a * np.conj(b)
    series = np.fft.irfft(cross, size)
    reach = min(int(NEAR * rate), count // 2)
    lags = np.arange(-reach, reach + 1)
    peak = int(np.argmax(series[lags]))
    if peak in (0, len(lags) - 1):
        return None
    late = lags[peak] / rate
    curvature = 0.0
    for _ in range(STEPS):
        turned = cross * np.exp(1j * waves * late)
        curvature = float(np.sum(waves**2 * turned.real))
        change = -float(np.sum(waves * turned.imag)) / curvature if curvature > 0.0 else 0.0
        late += max(-0.5 / rate, min(0.5 / rate, change))
        if abs(change) < 1e-12:
            break
    correlation = float(np.sum((cross * np.exp(1j * waves * late)).real)) / power
    if correlation < CORRELATION or not curvature > 0.0:
        return None
    # The variance of a delay is that of the noise over the mean square of the slope.
    return shift + late, curvature / power * correlation / (1.0 - min(correlation, 1.0) ** 2 + 1e-9)


def _line(places: FloatArray, offsets: FloatArray, weights: FloatArray, skew: bool) -> tuple[float, float, float]:
    """Weighted least squares over blocks without outliers: offset, slope, and the offset's standard deviation."""
    kept = np.ones(len(offsets), dtype=np.bool_)
    offset = slope = 0.0
    std = math.nan
    for _ in range(ROUNDS):
        columns = np.column_stack([np.ones(len(offsets)), places])[:, : 2 if skew else 1]
        root = np.sqrt(weights * kept)
        solution = np.linalg.lstsq(root[:, np.newaxis] * columns, root * offsets)[0]
        offset, slope = float(solution[0]), float(solution[1]) if skew else 0.0
        left = offsets - columns @ solution
        free = int(np.count_nonzero(kept)) - columns.shape[1]
        if free < 1:
            break
        total = float(np.sum(weights * kept))
        std = math.sqrt(float(np.sum(weights * kept * left**2)) / total / free)
        spread = NORMAL * median(np.abs(left))
        kept = np.abs(left) <= OUTLIER * max(spread, 1e-9)
    return offset, slope, std
