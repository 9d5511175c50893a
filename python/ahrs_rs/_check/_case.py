"""What the checks look at: the readings in steps of about 10 ms, and their statistics over half a second."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._rate import nominal_rate
from ahrs_rs._recording import Recording
from ahrs_rs._streams import GAP_STEPS

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SENSORS = ("gyr", "acc", "mag")
#: Faster readings are taken together until no more than this many are left a second, Hz: attitudes over a second need
#: no more, and an hour at 1 kHz is then looked at in a tenth of the time.
COARSE = 125.0
#: Statistics are taken over cells of this length, s, of at least so many rows.
CELL, FEWEST = 0.5, 8
#: Rows that are worked on at a time.
BLOCK = 1 << 16
#: A cell is at rest below these standard deviations (root of the sum over the axes) and this angular rate.
REST_GYR, REST_ACC, REST_RATE = 0.02, 0.15, 0.15
#: The specific force at rest does not turn by more than this from one cell to the next, rad.
REST_TURN = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Coarse:
    """The readings of one clock in steps of about 10 ms."""

    t: FloatArray
    """(n,) s, at the end of each step."""
    step: FloatArray
    """(n,) s."""
    turn: FloatArray
    """(n, 3) the integral of the angular rate over each step; NaN where it is not known."""
    acc: FloatArray | None
    """(n, 3) means of the readings of each step, NaN where there are none."""
    mag: FloatArray | None
    ref: FloatArray | None
    """(n, 4) at the end of each step."""

    def __len__(self) -> int:
        """The number of steps."""
        return len(self.t)

    @property
    def rate(self) -> float:
        """Hz."""
        return nominal_rate(self.t) if len(self.t) > 1 and self.t[-1] > self.t[0] else 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Statistics of one sensor over half a second each."""

    t: FloatArray
    """(c,) s, the middles."""
    share: FloatArray
    """(c,) which part of the rows has a reading."""
    mean: FloatArray
    """(c, 3), NaN where there is none."""
    std: FloatArray
    """(c, 3)"""


@dataclass(slots=True, eq=False)
class Case:
    """A recording that is being checked, with what the checks have found so far.

    Units that are found wrong are put right for the checks that follow: `factors` holds what readings and times are
    multiplied by.
    """

    recording: Recording
    place: tuple[float, float, float] | None = None
    date: Any = None
    up: str | None = None
    factors: dict[str, float] = field(default_factory=lambda: {"t": 1.0, "gyr": 1.0, "acc": 1.0, "mag": 1.0})
    rotations: dict[str, FloatArray] = field(default_factory=dict)
    """Sensor -> matrix that its readings have to be multiplied by, where that is sure."""
    known: dict[str, Any] = field(default_factory=dict)
    """What one check tells another."""
    _made: dict[Any, Any] = field(default_factory=dict)

    def rows(self, name: str) -> FloatArray | None:
        """The rows of a sensor as recorded."""
        rows: FloatArray | None = getattr(self.recording, name)
        return rows if rows is not None and len(rows) else None

    @property
    def has(self) -> tuple[str, ...]:
        """The sensors that are there, with at least one reading."""
        if "has" not in self._made:
            self._made["has"] = tuple(name for name in SENSORS if _any_reading(self.rows(name)))
        found: tuple[str, ...] = self._made["has"]
        return found

    @property
    def rate(self) -> float:
        """Rows a second, Hz, with the unit of time put right."""
        return self.recording.rate / self.factors["t"]

    @property
    def duration(self) -> float:
        """s"""
        return self.recording.duration * self.factors["t"]

    def coarse(self) -> Coarse:
        """In steps of about 10 ms; made once, in the units that are right by then."""
        key = ("coarse", *self.factors.values(), *sorted(self.rotations))
        if self._made.get("coarse key") != key:
            self._made["coarse key"], self._made["coarse"] = key, _coarse(self)
        made: Coarse = self._made["coarse"]
        return made

    def cells(self, name: str) -> Cells:
        """Statistics over half a second."""
        key = (name, self.factors["t"], self.factors[name], name in self.rotations)
        if key not in self._made:
            self._made[key] = _cells(self, name)
        made: Cells = self._made[key]
        return made

    def still(self) -> BoolArray:
        """(c,) the cells at rest: nothing varies, the gyroscope shows a bias at most, gravity does not turn."""
        key = ("still", *self.factors.values())
        if key not in self._made:
            self._made[key] = _still(self)
        made: BoolArray = self._made[key]
        return made


def _any_reading(rows: FloatArray | None) -> bool:
    return rows is not None and any(
        bool(np.isfinite(rows[i : i + BLOCK]).all(axis=1).any()) for i in range(0, len(rows), BLOCK)
    )


def _coarse(case: Case) -> Coarse:
    recording = case.recording
    t = recording.t * case.factors["t"] if case.factors["t"] != 1.0 else recording.t
    group = max(int(case.rate // COARSE), 1)
    count = len(t) // group
    used = count * group
    ends = t[group - 1 : used : group]
    usual = group / case.rate
    step = np.diff(ends, prepend=ends[0] - usual) if count else np.zeros(0)
    gyr = case.rows("gyr")
    turn = np.full((count, 3), np.nan)
    if gyr is not None:
        matrix = case.rotations.get("gyr")
        for i, part in _groups(gyr, group, count):
            mean = part.mean(axis=1) * case.factors["gyr"]
            turn[i : i + len(part)] = mean if matrix is None else mean @ matrix.T
        turn *= step[:, np.newaxis]
        turn[step > GAP_STEPS * usual] = np.nan  # what turned in a gap is not known
    found: dict[str, FloatArray | None] = {}
    for name in ("acc", "mag"):
        rows = case.rows(name) if name in case.has else None
        if rows is None:
            found[name] = None
            continue
        made = np.full((count, 3), np.nan)
        matrix = case.rotations.get(name)
        for i, part in _groups(rows, group, count):
            mean = _mean(part) * case.factors[name]
            made[i : i + len(part)] = mean if matrix is None else mean @ matrix.T
        found[name] = made
    ref = recording.ref
    return Coarse(ends, step, turn, found["acc"], found["mag"], None if ref is None else ref[group - 1 : used : group])


def _groups(rows: FloatArray, group: int, count: int) -> Any:
    """Blocks (b, group, 3) of the rows, each with the number of its first group."""
    at_once = max(BLOCK // group, 1)
    for i in range(0, count, at_once):
        end = min(i + at_once, count)
        yield i, rows[i * group : end * group].reshape(end - i, group, 3)


def _mean(part: FloatArray) -> FloatArray:
    """Means over the rows that have a reading, NaN where none has."""
    if part.shape[1] == 1:
        return part[:, 0]
    there = np.isfinite(part).all(axis=2, keepdims=True)
    count = there.sum(axis=1)
    total = np.where(there, part, 0.0).sum(axis=1)
    mean = np.full(total.shape, np.nan)
    np.divide(total, count, out=mean, where=count > 0)
    return mean


def _cells(case: Case, name: str) -> Cells:
    rows = case.rows(name)
    assert rows is not None
    length = max(round(CELL * case.rate), FEWEST)
    count = len(rows) // length
    share, mean, std = np.zeros(count), np.full((count, 3), np.nan), np.full((count, 3), np.nan)
    for i, part in _groups(rows, length, count):
        there = np.isfinite(part).all(axis=2, keepdims=True)
        number = there.sum(axis=1)
        filled = np.where(there, part, 0.0)
        middle = filled.sum(axis=1) / np.maximum(number, 1)
        apart = np.where(there, filled - middle[:, np.newaxis], 0.0)
        spread = np.sqrt((apart * apart).sum(axis=1) / np.maximum(number - 1, 1))
        end = i + len(part)
        share[i:end] = number[:, 0] / length
        known = number[:, 0] > 0
        mean[i:end][known], std[i:end][known] = middle[known], spread[known]
    factor = case.factors[name]
    middle_t = case.recording.t[length // 2 : count * length : length][:count] * case.factors["t"]
    matrix = case.rotations.get(name)
    mean = mean * factor if matrix is None else (mean * factor) @ matrix.T
    return Cells(middle_t, share, mean, std * factor if matrix is None else (std * factor) @ np.abs(matrix.T))


def _still(case: Case) -> BoolArray:
    count = len(case.recording) // max(round(CELL * case.rate), FEWEST)
    still = np.ones(count, dtype=np.bool_)
    if "gyr" in case.has:
        cells = case.cells("gyr")
        still &= np.linalg.norm(cells.std, axis=1) <= REST_GYR
        still &= np.linalg.norm(cells.mean, axis=1) <= REST_RATE
    if "acc" in case.has:
        cells = case.cells("acc")
        known = cells.share > 0.05
        still &= known & (np.linalg.norm(cells.std, axis=1) <= REST_ACC)
        norm = np.linalg.norm(cells.mean, axis=1)
        direction = cells.mean / np.where(norm > 0.5, norm, np.nan)[:, np.newaxis]
        turned = np.linalg.norm(np.diff(direction, axis=0), axis=1) > REST_TURN
        turned &= np.isfinite(turned)
        moving = np.zeros(count, dtype=np.bool_)
        moving[1:] |= turned
        moving[:-1] |= turned
        still &= ~moving
    if not {"gyr", "acc"} & set(case.has):
        return np.zeros(count, dtype=np.bool_)
    # A single cell between moving ones is no rest.
    beside = np.zeros(count, dtype=np.bool_)
    beside[1:] |= still[:-1]
    beside[:-1] |= still[1:]
    alone: BoolArray = still & beside
    return alone
