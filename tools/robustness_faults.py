"""What happens to a recording: the faults of docs/robustness.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from robustness_scenes import TURN_TIME, Clean

Floats = NDArray[np.float64]

#: s of the turn that is lost in motion, and of the longer losses.
LOST, ALL_LOST, ACC_LOST, MAG_LOST, LOSSES, HOLE = 1.0, 5.0, 10.0, 60.0, 30.0, 36.0
#: s between the rows on both sides of the longer hole, and by which the clock is set ahead.
HOUR, JUMP = 3600.0, 2e8
#: Part of the rows that are lost at random; s of a burst, and on average between the beginnings of two.
LOSS, BURST, EVERY = 0.05, (0.1, 0.5), 2.0


@dataclass(slots=True)
class Rows:
    """The rows of a recording, and what has become of them."""

    clean: Clean
    gyr: Floats
    acc: Floats
    mag: Floats
    t: Floats
    kept: NDArray[np.bool_]

    @classmethod
    def of(cls, clean: Clean) -> Rows:
        """Those that nothing has happened to."""
        one = clean.recording
        assert one.acc is not None
        assert one.mag is not None
        return cls(clean, one.gyr.copy(), one.acc.copy(), one.mag.copy(), one.t.copy(), np.ones(len(one), bool))

    @property
    def hit(self) -> NDArray[np.bool_]:
        """The rows during the fault."""
        t = self.clean.recording.t
        start, end = self.clean.start, self.clean.start + self.clean.length
        return np.asarray((t >= start) & (t < end))

    @property
    def behind(self) -> NDArray[np.bool_]:
        """The rows behind it."""
        return np.asarray(self.clean.recording.t >= self.clean.start + self.clean.length)


Change = Callable[[Rows, np.random.Generator], None]


@dataclass(frozen=True, slots=True)
class Fault:
    """A kind of fault."""

    name: str
    text: str
    change: Change
    #: s in motion, and at rest, where the sensor's one turn is a part of it.
    length: float
    at_rest: float
    #: Whether it needs rates beyond the gyroscope's range: the turn, in motion too.
    beyond: bool = False
    #: Whether the data tell it: by a NaN, a missing row, or readings at the known limit.
    told: bool = True
    #: Whether the filter is told the gyroscope's range.
    gyr_range: bool = False
    #: Whether it matters to filters without a magnetometer.
    six: bool = True

    def rows(self, clean: Clean) -> Rows:
        """The recording after the fault; random where it is, by the seed."""
        rows = Rows.of(clean)
        self.change(rows, np.random.default_rng([clean.seed, 5]))
        return rows


def no_gyr(rows: Rows, _draw: np.random.Generator) -> None:
    rows.gyr[rows.hit] = np.nan


def no_acc(rows: Rows, _draw: np.random.Generator) -> None:
    rows.acc[rows.hit] = np.nan


def no_mag(rows: Rows, _draw: np.random.Generator) -> None:
    rows.mag[rows.hit] = np.nan


def no_sensor(rows: Rows, _draw: np.random.Generator) -> None:
    for array in (rows.gyr, rows.acc, rows.mag):
        array[rows.hit] = np.nan


def dropped(rows: Rows, _draw: np.random.Generator) -> None:
    rows.kept &= ~rows.hit


def clipped(rows: Rows, _draw: np.random.Generator) -> None:
    np.clip(rows.gyr, -rows.clean.gyr_range, rows.clean.gyr_range, out=rows.gyr)


def flipped(rows: Rows, _draw: np.random.Generator) -> None:
    rows.gyr[np.abs(rows.gyr) > rows.clean.gyr_range] *= -1.0


def wrapped(rows: Rows, _draw: np.random.Generator) -> None:
    limit = rows.clean.gyr_range
    # Readings within the range keep their bits.
    rows.gyr = np.where(np.abs(rows.gyr) > limit, (rows.gyr + limit) % (2.0 * limit) - limit, rows.gyr)


def jumped(rows: Rows, _draw: np.random.Generator) -> None:
    rows.t[rows.behind] += JUMP


def hour(rows: Rows, draw: np.random.Generator) -> None:
    dropped(rows, draw)
    rows.t[rows.behind] += HOUR - rows.clean.length


def scattered(rows: Rows, draw: np.random.Generator) -> None:
    lost = draw.random(len(rows.t)) < LOSS
    rows.kept &= ~(lost & (rows.hit | rows.behind))


def bursts(rows: Rows, draw: np.random.Generator) -> None:
    t, time, end = rows.clean.recording.t, rows.clean.start, rows.clean.start + rows.clean.length
    while True:
        length = draw.uniform(*BURST)
        if time + length > end:
            return
        rows.kept &= ~((t >= time) & (t < time + length))
        time += length + draw.exponential(EVERY)


FAULTS = [
    Fault("turn, NaN", f"the gyroscope's rows are NaN for {LOST:g} s (rest: {TURN_TIME:g} s)", no_gyr, LOST, TURN_TIME),
    Fault("turn, dropped", "the same rows are missing, of all sensors; the stamps tell", dropped, LOST, TURN_TIME),
    Fault(
        "clipped, told",
        "a turn beyond the gyroscope's range, cut there; the filter knows the range (`gyr_range=`)",
        clipped,
        LOST,
        TURN_TIME,
        beyond=True,
        gyr_range=True,
    ),
    Fault("clipped", "the same, and nobody tells", clipped, LOST, TURN_TIME, beyond=True, told=False),
    Fault(
        "sign flip", "what is beyond the range has the other sign", flipped, LOST, TURN_TIME, beyond=True, told=False
    ),
    Fault(
        "wrapped",
        "what is beyond the range begins again at its other end",
        wrapped,
        LOST,
        TURN_TIME,
        beyond=True,
        told=False,
    ),
    Fault(
        "clock", f"the clock is set ahead by {JUMP:.0e} s, and nothing is lost".replace("e+0", "e"), jumped, 0.0, 0.0
    ),
    Fault("hole 36 s", f"all rows of {HOLE:g} s are missing, in which the sensor moves", dropped, HOLE, HOLE),
    Fault("hole 1 h", f"the same rows are missing, and the stamps are {HOUR:g} s apart", hour, HOLE, HOLE),
    Fault(
        "5 % lost",
        f"each row is missing with a probability of {LOSS:g}, to the end: errors count from the beginning",
        scattered,
        0.0,
        TURN_TIME,
    ),
    Fault(
        "bursts",
        f"for {LOSSES:g} s, all rows of {BURST[0]:g} to {BURST[1]:g} s are missing, some {EVERY:g} s apart",
        bursts,
        LOSSES,
        LOSSES,
    ),
    Fault("acc lost", f"the accelerometer's rows are NaN for {ACC_LOST:g} s", no_acc, ACC_LOST, ACC_LOST),
    Fault("mag lost", f"the magnetometer's rows are NaN for {MAG_LOST:g} s", no_mag, MAG_LOST, MAG_LOST, six=False),
    Fault("all lost", f"the rows of all sensors are NaN for {ALL_LOST:g} s", no_sensor, ALL_LOST, ALL_LOST),
]
