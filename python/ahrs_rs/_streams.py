"""Readings of one sensor with a clock of their own, and how they come onto the stamps of another."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _arrays, _quat
from ahrs_rs._rate import nominal_rate
from ahrs_rs._typing import FloatArray

__all__ = ["Stream"]


#: A step of a stream that is longer than so many usual ones is a gap, over which nothing is interpolated.
GAP_STEPS = 2.5


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """Readings of one sensor at its own times.

    Parameters
    ----------
    t : (n,) s, finite and not decreasing, on the clock of the recording.
    values : (n,) or (n, k), float64 or bool; NaN is no reading.

    Raises
    ------
    ValueError
        Shapes that do not fit, or times that decrease.
    """

    t: FloatArray
    values: NDArray[Any]

    def __post_init__(self) -> None:
        if self.t.ndim != 1 or self.values.ndim not in (1, 2) or len(self.values) != len(self.t):
            raise ValueError(
                f"expected n times and n rows of values, got shapes {self.t.shape} and {self.values.shape}"
            )
        bad = np.flatnonzero(~np.isfinite(self.t))
        if bad.size:
            raise ValueError(f"expected finite times, got {self.t[bad[0]]} at index {bad[0]}")
        bad = np.flatnonzero(self.t[1:] < self.t[:-1])
        if bad.size:
            raise ValueError(f"expected times that do not decrease, got a decrease at index {bad[0] + 1}")

    def __len__(self) -> int:
        """The number of readings."""
        return len(self.t)

    def __iter__(self) -> Iterator[NDArray[Any]]:
        """Times and values, so that ``t, acc = rec.streams["acc"]`` has both."""
        yield self.t
        yield self.values

    def __repr__(self) -> str:
        rate = f", {self.rate:.6g} Hz" if len(self) > 1 and self.t[-1] > self.t[0] else ""
        return f"Stream({len(self)} readings{rate}, values{self.values.shape})"

    @property
    def rate(self) -> float:
        """Readings a second, over the parts without a gap, Hz; ValueError where all times are the same."""
        return nominal_rate(self.t)

    @property
    def missing(self) -> NDArray[np.bool_]:
        """(n,) where nothing was read: all values of a row are NaN."""
        if self.values.dtype.kind != "f":
            return np.zeros(len(self), dtype=np.bool_)
        columns = self.values.reshape(len(self), math.prod(self.values.shape[1:]))
        nothing: NDArray[np.bool_] = np.ones(len(self), dtype=np.bool_)
        for k in range(columns.shape[1]):
            nothing &= np.isnan(columns[:, k])
            if not nothing.any():  # as nearly always after the first column
                break
        return nothing

    def present(self) -> Stream:
        """The readings without the rows in which nothing was read."""
        missing = self.missing
        return Stream(self.t[~missing], self.values[~missing]) if missing.any() else self

    def between(self, start: float, end: float) -> Stream:
        """The readings with start <= t <= end, as views."""
        part = slice(int(np.searchsorted(self.t, start)), int(np.searchsorted(self.t, end, side="right")))
        return Stream(self.t[part], self.values[part])

    # -- onto another clock ------------------------------------------------------------------------------------------

    def arriving(self, clock: FloatArray) -> FloatArray:
        """Each reading on the first stamp of the clock at or after its own, NaN elsewhere.

        Of several that arrive at one stamp the last is kept; where stamps are repeated on both sides (packets), the
        k-th reading of a stamp stands in its k-th row. What comes after the last stamp, or more than a step of its own
        before the first one, is left out.
        """
        if self._shares(clock):
            return np.asarray(self.values, dtype=np.float64)
        rows = np.full((len(clock), *self.values.shape[1:]), np.nan)
        times, values = self.present()
        if not len(times) or not len(clock):
            return rows
        stale = times < clock[0] - (1.0 / nominal_rate(times) if times[-1] > times[0] else 0.0)
        index = np.searchsorted(clock, times, side="left")
        arrived = (index < len(clock)) & ~stale
        index, times, values = index[arrived], times[arrived], values[arrived]
        rank = np.arange(len(times)) - np.searchsorted(times, times, side="left")
        last = np.searchsorted(clock, clock[index], side="right") - 1
        rows[np.minimum(index + rank, last)] = values
        return rows

    def linear(self, clock: FloatArray) -> FloatArray:
        """The line between the readings before and after each stamp, NaN in gaps and outside.

        A gap is a step of more than 2.5 usual ones, or a row in which nothing was read.
        """
        if self._shares(clock):
            return np.asarray(self.values, dtype=np.float64)
        if len(self) < 2:
            return self.arriving(clock)
        index, part, _ = self._between_rows(clock)
        weight = part.reshape(-1, *[1] * (self.values.ndim - 1))
        before, after = self.values[index], self.values[index + 1]
        # At a reading's own time the other one has no say, though it may be missing or far.
        found = np.where(weight == 0.0, before, np.where(weight == 1.0, after, before + weight * (after - before)))
        return self._outside_of_gaps(found, clock, index, part)

    def turning(self, clock: FloatArray) -> FloatArray:
        """The shortest rotation between the quaternions before and after each stamp (slerp); NaN as in `linear`."""
        if self._shares(clock):
            return np.asarray(self.values, dtype=np.float64)
        if len(self) < 2:
            return self.arriving(clock)
        index, part, _ = self._between_rows(clock)
        before, after = self.values[index], self.values[index + 1]
        turn = _quat.log(_quat.multiply(_quat.conjugate(before), after))
        turn = np.where((part == 0.0)[:, np.newaxis], 0.0, turn)  # the other one may be missing there
        found = _quat.multiply(before, _quat.exp(part[:, np.newaxis] * turn))
        found = np.where((part == 1.0)[:, np.newaxis], after, found)
        return self._outside_of_gaps(found, clock, index, part)

    def held(self, clock: FloatArray) -> NDArray[Any]:
        """The last value at or before each stamp; the first one before that."""
        if self._shares(clock):
            return self.values
        index = np.searchsorted(self.t, clock, side="right") - 1
        held: NDArray[Any] = self.values[np.maximum(index, 0)]
        return held

    def averaged(self, clock: FloatArray) -> FloatArray:
        """The mean over the step before each stamp of what holds over the step before each reading (an angular rate).

        Integrated over the new steps it gives what it gave over the old ones. NaN where the readings miss a part.
        """
        if self._shares(clock):
            return np.asarray(self.values, dtype=np.float64)
        if len(self) < 2:
            return self.arriving(clock)
        steps = np.diff(self.t)[:, np.newaxis]
        values = self.values[1:].reshape(len(self) - 1, -1)
        known = ~np.isnan(values).any(axis=1, keepdims=True) & (steps <= self._longest_step())
        sums = np.vstack([np.zeros((1, values.shape[1])), np.cumsum(np.where(known, values * steps, 0.0), axis=0)])
        lost = np.concatenate([[0.0], np.cumsum(np.where(known, 0.0, steps)[:, 0])])
        begins = np.concatenate([[2.0 * clock[0] - clock[1]] if len(clock) > 1 else [self.t[0]], clock[:-1]])
        ends = clock
        over = np.column_stack([_line(ends, self.t, column) - _line(begins, self.t, column) for column in sums.T])
        missed = _line(ends, self.t, lost) - _line(begins, self.t, lost)
        inside = np.minimum(ends, self.t[-1]) - np.maximum(begins, self.t[0])
        covered = inside - missed
        width = (ends - begins)[:, np.newaxis]
        enough = (covered >= 0.5 * (ends - begins)) & (width[:, 0] > 0.0)
        mean = np.full_like(over, np.nan)
        np.divide(over, covered[:, np.newaxis], out=mean, where=enough[:, np.newaxis])
        return mean.reshape(len(clock), *self.values.shape[1:])

    def _shares(self, clock: FloatArray) -> bool:
        return self.t is clock or np.array_equal(self.t, clock)

    def _longest_step(self) -> float:
        """The longest step that is no gap, s."""
        return GAP_STEPS / nominal_rate(self.t) if self.t[-1] > self.t[0] else 0.0

    def _between_rows(self, clock: FloatArray) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
        """The row before each stamp, which part of the step has passed, and the step, s."""
        index = np.clip(np.searchsorted(self.t, clock, side="right") - 1, 0, len(self) - 2)
        step = self.t[index + 1] - self.t[index]
        part = np.zeros(len(clock))
        np.divide(clock - self.t[index], step, out=part, where=step > 0.0)
        return index, part, step

    def _outside_of_gaps(
        self, found: FloatArray, clock: FloatArray, index: NDArray[np.intp], part: FloatArray
    ) -> FloatArray:
        step = self.t[index + 1] - self.t[index]
        wrong = (clock < self.t[0]) | (clock > self.t[-1])
        wrong |= (step > self._longest_step()) & (part != 0.0) & (part != 1.0)
        found[wrong] = np.nan
        return found


def make_stream(name: str, t: ArrayLike, values: ArrayLike) -> Stream:
    """A checked stream of float64 (of bool for a mask); the errors name it."""
    try:
        times, array = np.asarray(_arrays.vectors(name, t)), np.asarray(_arrays.vectors(name, values))
        for what in (times, array):
            if what.dtype.kind not in "fiub":
                raise ValueError(f"expected arrays of real numbers, got dtype {what.dtype}")
        kept = array.dtype.kind == "b"
        return Stream(times.astype(np.float64, copy=False), array if kept else array.astype(np.float64, copy=False))
    except ValueError as error:
        told = str(error).removeprefix(f"{name}: ")
        raise ValueError(f"{name}: {told}") from None


def _line(at: FloatArray, t: FloatArray, values: FloatArray) -> FloatArray:
    return np.interp(at, t, values)
