"""What the faults of docs/robustness.md happen to: simulated rest and motion, and recordings of BROAD."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ahrs_rs as ar
from ahrs_rs import _quat
from ahrs_rs.simulate import SCENARIOS, Sensor, record, still

Floats = NDArray[np.float64]

#: After good measurements are back, s: when errors are taken, and the half width of the window of each.
AFTER = (1.0, 10.0, 30.0)
HALF = 0.5
#: s from the last of them to the end of a run.
TAIL = 0.6

#: Hz of the simulations; their noise (standard deviation of a sample) and constant biases: those of a consumer sensor.
RATE = 100.0
GYR_NOISE, GYR_BIAS = 1.4e-3, 5e-3  # rad/s
ACC_NOISE, ACC_BIAS = 0.014, 0.02  # m/s²
MAG_NOISE = 0.3  # µT

#: s of good measurements before a fault begins in a simulation; in motion by the seed between this and the last.
FIRST, LAST = 30.0, 50.0
#: The longest fault, s.
LONGEST = 60.0
#: At rest: the one turn (rad), its time (s), and the gyroscope's range that it exceeds (rad/s).
TURN, TURN_TIME, REST_RANGE = 0.5 * np.pi, 0.4, 1.0
#: Elsewhere: one turn beyond the range, back to where it began, so that the biases stay those of the sensor. The range
#: is this factor above the largest rate of the recording, and the largest rate of the turn this many times the range.
WHOLE, MARGIN, EXCESS = 2.0 * np.pi, 1.05, (1.3, 1.8)
#: m from the origin within which the way points of the simulated motion are, half a second apart: accelerations of
#: some 2 m/s².
REACH = 0.15
#: Files of BROAD by their numbers.
BROAD = ("02", "05", "07", "16")
#: s of movement before a fault on BROAD.
MOVED = 5.0


@dataclass(frozen=True, slots=True)
class Turn:
    """A quick turn of the sensor about an axis of its own: the rate rises and falls as a squared sine."""

    start: float
    length: float
    axis: Floats
    angle: float

    def at(self, t: Floats) -> Floats:
        """Quaternions (T, 4) of what has been turned at the times t (T,)."""
        u = np.clip((t - self.start) / self.length, 0.0, 1.0)
        run = u - np.sin(2.0 * np.pi * u) / (2.0 * np.pi)
        return _quat.exp(self.angle * run[:, None] * self.axis)

    def added(self, recording: ar.Recording) -> ar.Recording:
        """The recording of a sensor that makes this turn beside its own motion, about its accelerometer."""
        assert recording.acc is not None
        assert recording.mag is not None
        assert recording.ref is not None
        t = recording.t
        step = np.diff(t, prepend=t[0] - 1.0 / recording.rate)[:, None]
        turned = self.at(t)
        before = self.at(t - step[:, 0])
        back = _quat.conjugate(turned)
        turn = _quat.multiply(_quat.conjugate(before), _quat.multiply(_quat.exp(recording.gyr * step), turned))
        return replace(
            recording,
            gyr=_quat.log(turn) / step,
            acc=_quat.rotate(back, recording.acc),
            mag=_quat.rotate(back, recording.mag),
            ref=_quat.multiply(recording.ref, turned),
        )


@dataclass(frozen=True, slots=True)
class Clean:
    """A recording of good measurements, and where a fault is to happen to it."""

    recording: ar.Recording
    key: tuple[int, bool]
    """Equal for equal recordings of a scene."""
    start: float
    """s, when the fault begins."""
    length: float
    """s, how long it lasts."""
    gyr_range: float
    """rad/s, which only a turn beyond the range exceeds."""
    seed: int


@dataclass(frozen=True)
class Scene:
    """A kind of recording: one for each seed, or always the same with the fault at another time."""

    name: str
    short: str
    rate: float
    gyr_range: float
    _plain: Callable[[int], ar.Recording]
    #: Whether every seed has a recording of its own.
    own: bool
    rest: bool

    def clean(self, seed: int, length: float, beyond: bool) -> Clean:
        """The recording of a seed for a fault of a length in s; with a turn beyond the gyroscope's range or without."""
        if self.rest:
            # The turn is that of all faults; a fault that takes no time comes after it, at rest.
            start = FIRST if length else FIRST + 5.0
            return Clean(self._plain(seed), (seed, True), start, length, self.gyr_range, seed)
        plain = self._plain(seed)
        draw = np.random.default_rng([seed, 1])
        excess = draw.uniform(*EXCESS)
        axis = direction(draw)
        # The integral of the squared sine is half of its time.
        turn_time = 2.0 * WHOLE * np.abs(axis).max() / (excess * self.gyr_range)
        length = turn_time if beyond else length
        start = self._start(plain, length, np.random.default_rng([seed, 2]))
        if beyond:
            plain = Turn(start, turn_time, axis, WHOLE).added(plain)
        return Clean(plain, (seed if self.own or beyond else 0, beyond), start, length, self.gyr_range, seed)

    def _start(self, plain: ar.Recording, length: float, draw: np.random.Generator) -> float:
        """When a fault begins: in the movement, and so that the truth is known where errors are taken."""
        if self.own:
            return float(draw.uniform(FIRST, LAST))
        assert plain.mask is not None
        assert plain.ref is not None
        moving = plain.t[plain.mask]
        latest = moving[-1] - length - AFTER[-1] - HALF
        while True:
            start = float(draw.uniform(moving[0] + MOVED, latest))
            windows = [np.abs(plain.t - (start + length + after)) <= HALF for after in AFTER]
            windows += [np.abs(plain.t - (start - before)) <= HALF for before in AFTER[:2]]
            if all(np.isfinite(plain.ref[window, 0]).mean() > 0.5 for window in windows):
                return start


def direction(draw: np.random.Generator) -> Floats:
    """A unit vector (3,) of any direction."""
    vector = draw.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def noisy(recording: ar.Recording, seed: int) -> ar.Recording:
    """With the noise and the biases of a consumer sensor."""
    assert recording.acc is not None
    assert recording.mag is not None
    draw = np.random.default_rng([seed, 3])
    shape = recording.gyr.shape
    return replace(
        recording,
        gyr=recording.gyr + GYR_BIAS * draw.standard_normal(3) + GYR_NOISE * draw.standard_normal(shape),
        acc=recording.acc + ACC_BIAS * draw.standard_normal(3) + ACC_NOISE * draw.standard_normal(shape),
        mag=recording.mag + MAG_NOISE * draw.standard_normal(shape),
    )


def resting(seed: int) -> ar.Recording:
    """At rest in any attitude, but for one turn."""
    draw = np.random.default_rng([seed, 4])
    angles = draw.uniform(-np.pi, np.pi, 3)
    exact = record(still(*angles), rate=RATE, duration=FIRST + LONGEST + AFTER[-1] + TAIL)
    return noisy(Turn(FIRST, TURN_TIME, direction(draw), TURN).added(exact), seed)


def moving(seed: int) -> ar.Recording:
    """Through random way points without a rest."""
    duration = LAST + LONGEST + AFTER[-1] + TAIL
    setup = SCENARIOS["way_points"].setup(rate=RATE, duration=duration, seed=seed, sensor=Sensor(), reach=REACH)
    return noisy(setup.record(seed), seed)


def scene_of(which: str, folder: Path, seeds: int) -> Scene:
    """Simulated "rest" or "motion", or a recording of BROAD by its number."""
    if which == "rest":
        return Scene("rest", "R", RATE, REST_RANGE, cache(resting), own=True, rest=True)
    if which == "motion":
        plain = cache(moving)
        largest = max(float(np.abs(plain(seed).gyr).max()) for seed in range(seeds))
        return Scene("motion", "M", RATE, MARGIN * largest, plain, own=True, rest=False)
    (file,) = folder.glob(f"broad/{which}_*.hdf5")
    one = ar.read(file)
    largest = float(np.abs(one.gyr).max())
    return Scene(f"BROAD {which}", which, one.rate, MARGIN * largest, lambda _: one, own=False, rest=False)
