"""What is drawn: streams of random numbers, drifts, rows that are missing."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.simulate._sensor import Triad

#: Largest ratio of weights within one cumulative sum of a decaying process: three digits of sixteen are lost.
LARGEST_WEIGHT = 1e3
#: Values of a drift in its shortest correlation time: what is lost by lines in between is a seventh of that process's
#: deviation at most.
STEPS = 25
#: Allan deviation of a Gauss-Markov process with deviation 1 at its peak, and of flicker noise with B = 1.
MARKOV_PEAK, FLICKER_FLOOR = 0.6174, math.sqrt(2.0 * math.log(2.0) / math.pi)


class Part(IntEnum):
    """Who draws: the first number of a stream's key. New ones come last, so that the old streams stay."""

    MOTION = 0
    CLOCK = 1
    GYR = 2
    ACC = 3
    MAG = 4
    TEMPERATURE = 5
    DISTURBANCE = 6


class Effect(IntEnum):
    """What is drawn: the second number of the key."""

    BIAS = 0
    MATRIX = 1
    WHITE = 2
    INSTABILITY = 3
    RANDOM_WALK = 4
    MISSING = 5


def stream(seed: int, part: int, effect: int = 0) -> np.random.Generator:
    """The generator of one effect: an effect that is left out or added leaves all others as they are."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(part, effect)))


class Drift:
    """Instability and random walk of one triad over so many rows at a constant rate in Hz.

    Drawn `STEPS` times in the shortest correlation time (or at every row, if those are fewer), and linear in between.
    """

    def __init__(self, triad: Triad, seed: int, part: Part, rate: float, count: int) -> None:
        walk, instability = (np.broadcast_to(one, 3) for one in (triad.random_walk, triad.instability))
        times = np.array(triad.instability_times)
        self._any = bool(walk.any() or instability.any())
        if not self._any:
            return
        self._step = max(1, int(rate * times[0] / STEPS))
        dt, nodes = self._step / rate, -(-count // self._step) + 1
        self._values = np.zeros((3, nodes))
        if walk.any():
            steps = stream(seed, part, Effect.RANDOM_WALK).standard_normal((3, nodes - 1))
            self._values[:, 1:] += np.cumsum(walk[:, None] * math.sqrt(dt) * steps, axis=1)
        if instability.any():
            generator = stream(seed, part, Effect.INSTABILITY)
            deviation = (markov_deviation(times) * instability)[:, None]
            for time in times:
                kicks = deviation * generator.standard_normal((3, nodes))
                kicks[:, 1:] *= math.sqrt(-math.expm1(-2.0 * dt / time))
                self._values += decaying_sum(kicks, math.exp(-dt / time))

    def __bool__(self) -> bool:
        """Whether there is any."""
        return self._any

    def at(self, start: int, stop: int) -> FloatArray:
        """(T, 3) at the rows from start to stop."""
        step, first = self._step, start // self._step
        if step == 1:
            return self._values[:, start:stop].T
        values = self._values[:, first : (stop - 1) // step + 2, None]
        between = values[:, :-1] + (values[:, 1:] - values[:, :-1]) * (np.arange(step) / step)
        return between.reshape(3, -1)[:, start - first * step : stop - first * step].T


def markov_deviation(times: FloatArray) -> float:
    """Standard deviation of each Gauss-Markov process that together make flicker noise with B = 1.

    Processes of equal variance σ² whose correlation times rise by a factor r have together the one-sided
    power density σ²/(f ln r); flicker noise has B²/(π f).
    """
    if len(times) == 1:
        return FLICKER_FLOOR / MARKOV_PEAK
    return math.sqrt(math.log(times[1] / times[0]) / math.pi)


def decaying_sum(kicks: FloatArray, keep: float) -> FloatArray:
    """x[k] = keep · x[k-1] + kicks[k] along the last axis of (rows, T), from x[-1] = 0.

    Within a run, x[k] keep^-k is a cumulative sum; the last values of the runs are such a sequence again.
    """
    count = kicks.shape[1]
    if keep < 1e-100:  # forgets at once; the weights below would underflow
        return kicks
    length = min(count, max(2, int(math.log(LARGEST_WEIGHT) / -math.log(keep))))
    runs = -(-count // length)
    padded = np.zeros((len(kicks), runs * length))
    padded[:, :count] = kicks
    blocks = padded.reshape(-1, runs, length)
    weight = keep ** np.arange(1, length + 1)
    blocks /= weight
    np.cumsum(blocks, axis=2, out=blocks)
    blocks *= weight
    if runs > 1:
        blocks[:, 1:] += weight * decaying_sum(blocks[:, :-1, -1], float(weight[-1]))[:, :, None]
    return padded[:, :count]


def missing_rows(part: float, length: float, count: int, generator: np.random.Generator) -> NDArray[np.bool_]:
    """(count,) which rows are missing: the given part of them, in groups of the given mean length.

    Where so many are missing that the groups must be longer, they are.
    """
    if part <= 0.0:
        return np.zeros(count, dtype=np.bool_)
    if part >= 1.0:
        return np.ones(count, dtype=np.bool_)
    # Present and missing runs take turns, with geometric lengths of the right means, which are at least one row.
    length = max(length, part / (1.0 - part))
    present = max(length * (1.0 - part) / part, 1.0)
    missing = np.zeros(count, dtype=np.bool_)
    at = 0
    while at < count:
        runs = max(16, int(1.2 * (count - at) / (present + length)))
        gaps = np.minimum(generator.geometric(1.0 / present, runs), count)
        gaps[0] -= at == 0  # the first row may be missing too
        lengths = np.minimum(generator.geometric(1.0 / length, runs), count)
        ends = at + np.cumsum(gaps + lengths)
        steps = np.zeros(count + 1, dtype=np.int64)
        np.add.at(steps, np.minimum(ends - lengths, count), 1)
        np.add.at(steps, np.minimum(ends, count), -1)
        missing |= np.cumsum(steps)[:count] > 0
        at = int(ends[-1])
    return missing
