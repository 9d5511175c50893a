"""What is drawn: streams of random numbers, drifts, rows that are missing."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .functions import FloatArray
from .sensor import Triad

#: Largest ratio of weights within one cumulative sum of a decaying process: three digits of sixteen are lost.
LARGEST_WEIGHT = 1e3
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
    """Instability and random walk of one triad, block after block, at a constant rate in Hz."""

    def __init__(self, triad: Triad, seed: int, part: Part, rate: float) -> None:
        self._walk = np.broadcast_to(triad.random_walk, 3) / math.sqrt(rate)
        self._walk_stream = stream(seed, part, Effect.RANDOM_WALK)
        self._walked = np.zeros(3)
        self._markov_stream = stream(seed, part, Effect.INSTABILITY)
        times = np.array(triad.instability_times)
        deviation = markov_deviation(times) * np.broadcast_to(triad.instability, 3)
        self._keeps = np.exp(-1.0 / (rate * times)) if deviation.any() else np.zeros(0)
        self._kick = np.sqrt(-np.expm1(-2.0 / (rate * times)))[:, None] * deviation
        self._states = deviation * self._markov_stream.standard_normal((len(times), 3))

    def __bool__(self) -> bool:
        """Whether there is any."""
        return bool(len(self._keeps) or self._walk.any())

    def take(self, count: int) -> FloatArray:
        """The next rows, (count, 3)."""
        total = np.zeros((count, 3))
        if self._walk.any():
            steps = self._walk * self._walk_stream.standard_normal((count, 3))
            total += self._walked + np.cumsum(steps, axis=0)
            self._walked = total[-1].copy()
        if len(self._keeps):
            kicks = self._markov_stream.standard_normal((count, len(self._keeps), 3))
            for i, keep in enumerate(self._keeps):
                process = decaying_sum(self._kick[i] * kicks[:, i], float(keep), self._states[i])
                self._states[i] = process[-1]
                total += process
        return total


def markov_deviation(times: FloatArray) -> float:
    """Standard deviation of each Gauss-Markov process that together make flicker noise with B = 1.

    Processes of equal variance σ² whose correlation times rise by a factor r have together the one-sided
    power density σ²/(f ln r); flicker noise has B²/(π f).
    """
    if len(times) == 1:
        return FLICKER_FLOOR / MARKOV_PEAK
    return math.sqrt(math.log(times[1] / times[0]) / math.pi)


def decaying_sum(kicks: FloatArray, keep: float, before: FloatArray) -> FloatArray:
    """x[k] = keep · x[k-1] + kicks[k] for kicks (T, columns), from x[-1] = before.

    Within a run of rows, x[k] keep^-k is a cumulative sum; the last rows of the runs are such a sequence again.
    """
    count = len(kicks)
    if keep < 1e-100:  # forgets at once; the weights below would underflow
        return kicks
    length = min(count, max(2, int(math.log(LARGEST_WEIGHT) / -math.log(keep))))
    runs = -(-count // length)
    padded = np.zeros((runs * length, kicks.shape[1]))
    padded[:count] = kicks
    blocks = padded.reshape(runs, length, -1)
    weight = keep ** np.arange(1, length + 1)
    blocks /= weight[:, None]
    np.cumsum(blocks, axis=1, out=blocks)
    blocks *= weight[:, None]
    starts = np.empty((runs, kicks.shape[1]))
    starts[0] = before
    if runs > 1:
        starts[1:] = decaying_sum(blocks[:-1, -1], float(weight[-1]), before)
    blocks += weight[:, None] * starts[:, None]
    return padded[:count]


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
        gaps = generator.geometric(1.0 / present, runs)
        gaps[0] -= at == 0  # the first row may be missing too
        lengths = generator.geometric(1.0 / length, runs)
        ends = at + np.cumsum(gaps + lengths)
        steps = np.zeros(count + 1, dtype=np.int64)
        np.add.at(steps, np.minimum(ends - lengths, count), 1)
        np.add.at(steps, np.minimum(ends, count), -1)
        missing |= np.cumsum(steps)[:count] > 0
        at = int(ends[-1])
    return missing
