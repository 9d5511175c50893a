"""The ends of a sensor's range: where readings heap up, they are clipped."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ahrs_rs._typing import BoolArray, FloatArray

#: Rows that are worked on at a time.
BLOCK = 1 << 16
#: A clipped end: so many readings at it, so many of them in a row, and this part of all in the last tenth before it.
ENDS, IN_A_ROW, HEAPED = 5, 3, 0.3
#: And it is so many counts away, so that a sensor at rest with few counts is none that clips.
FAR = 20.0
#: Rows in which the size of a count is looked for.
SOME = 20000
#: Readings within this part of an end are at it.
WIDTH = 1e-6


class End(NamedTuple):
    """An end of the range of an axis, at which readings heap up."""

    axis: int
    value: float
    sign: float
    """1.0 for the upper end, -1.0 for the lower one."""
    readings: int
    """How many are at it."""

    def at(self, rows: FloatArray) -> BoolArray:
        """(n,) which of the rows are at it."""
        found: BoolArray = np.abs(rows[:, self.axis] - self.value) <= WIDTH * abs(self.value)
        return found


def ends(rows: FloatArray, new: BoolArray, low: FloatArray, high: FloatArray) -> list[End]:
    """The ends of the range that readings (n, 3) were clipped at, of those `new`, between their extremes."""
    found = []
    for axis in range(3):
        count = _count(rows[:SOME, axis])
        for end, sign in ((high[axis], 1.0), (low[axis], -1.0)):
            if not np.isfinite(end) or not sign * end > FAR * count or low[axis] == high[axis]:
                continue
            at, near, longest = heap(rows[:, axis], new, float(end), sign)
            if (at >= ENDS and longest >= IN_A_ROW and at > HEAPED * (near + at)) or (
                at >= 2 * ENDS and longest >= 2 and at > 3.0 * near
            ):
                found.append(End(axis, float(end), sign, at))
    return found


def clipped(rows: FloatArray) -> BoolArray:
    """(n,) the rows of readings (n, 3) in which an axis is at an end of its range."""
    found = np.zeros(len(rows), dtype=np.bool_)
    if len(rows):
        for end in ends(rows, is_new(rows), *extremes(rows)):
            found |= end.at(rows)
    return found


def extremes(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest value of each axis."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for block in _blocks(rows):
        known = np.isfinite(block)
        low = np.minimum(low, np.where(known, block, np.inf).min(axis=0))
        high = np.maximum(high, np.where(known, block, -np.inf).max(axis=0))
    return low, high


def is_new(rows: FloatArray) -> BoolArray:
    """(n,) the rows that are not the row before once more: a sensor slower than the rows is held, not clipped."""
    new = np.ones(len(rows), dtype=np.bool_)
    for i in range(0, len(rows) - 1, BLOCK):
        end = min(i + BLOCK, len(rows) - 1)
        new[i + 1 : end + 1] = (rows[i + 1 : end + 1] != rows[i:end]).any(axis=1)
    return new


def heap(values: FloatArray, new: BoolArray, end: float, sign: float, width: float = WIDTH) -> tuple[int, int, int]:
    """How many readings are at the end, how many in the tenth before it, and the longest row of those at it."""
    tolerance = width * abs(end)
    at = near = longest = carried = 0
    for i in range(0, len(values), BLOCK):
        block = values[i : i + BLOCK][new[i : i + BLOCK]]
        hit = np.abs(block - end) <= tolerance
        number = int(np.count_nonzero(hit))
        near += int(np.count_nonzero(sign * block > 0.9 * sign * end)) - number
        if not number:
            carried = 0
            continue
        at += number
        breaks = np.flatnonzero(~hit)
        edges = np.concatenate([[-1 - carried], breaks, [len(block)]])
        longest = max(longest, int(np.max(np.diff(edges))) - 1)
        carried = int(len(block) - 1 - breaks[-1]) if breaks.size else carried + len(block)
    return at, near, longest


def _count(values: FloatArray) -> float:
    """The smallest difference between values that come more than once; 0 where they do not."""
    unique = np.unique(values[np.isfinite(values)])
    return float(np.diff(unique).min()) if 1 < unique.size < 0.5 * len(values) else 0.0


def _blocks(rows: FloatArray) -> Iterator[FloatArray]:
    for i in range(0, len(rows), BLOCK):
        yield rows[i : i + BLOCK]
