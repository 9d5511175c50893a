"""Which axes, signs and unit of the gyroscope explain how a vector turns: all candidates at once.

In a window R(t) is the attitude, relative to its start, that the gyroscope gives. A vector of the earth, read as v(t)
in the sensor, has the same mean of R v over the first and over the last part of the window. The candidates are the 48
signed permutations of the angular rate, times a few units. A rotation P of the axes turns R into P R Pᵀ; a mirrored one
is a rotation of −ω. So two integrations, of ω and of −ω, serve all 48: only the sums of R_ij v_k are needed.

A vector that stands still in the sensor (hard iron h, an offset) is solved for by least squares: it adds ΔR h.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _native
from ahrs_rs._check._case import BoolArray, Coarse

FloatArray = NDArray[np.float64]

#: Windows that are looked at, evenly over all.
MOST = 1500
#: Units of the angular rate that are candidates: as it is; deg/s taken as rad/s; turned into rad/s twice.
FACTORS = (1.0, np.pi / 180.0, 180.0 / np.pi)
#: A part of a window needs readings in so many of its steps, and the gyroscope may miss so many.
LEAST, MISSED = 0.05, 0.1
#: So many windows have to turn, by so much (rad), before anything is said.
FEWEST, TURNED = 8, 0.15
#: Standard scores from which on a candidate is the better one.
CLEAR = 4.0
#: A constant vector that is solved for is at most about this part of the field.
OFFSET = 3.0


def rotations() -> FloatArray:
    """(24, 3, 3) the signed permutations that are rotations, the identity first."""
    found = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[range(3), order] = signs
            if np.linalg.det(matrix) > 0.0:
                found.append(matrix)
    found.sort(key=lambda one: -float(np.trace(one)))
    return np.array(found)


ROTATIONS = rotations()


@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """Of the windows, for one sign and unit of the angular rate."""

    first: FloatArray
    """(w, 3, 3, 4) means of R_ij v_k over the first part, and of R_ij (k = 3)."""
    last: FloatArray
    turned: FloatArray
    """(w,) by how much the attitude changes between the parts, rad."""
    index: NDArray[np.intp]
    """(w,) first step of each window."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """What the angular rate is multiplied by: a signed permutation and a unit."""

    rotation: int
    sign: float
    factor: float

    @property
    def matrix(self) -> FloatArray:
        """(3, 3) of the angular rate, without the unit."""
        return np.asarray(self.sign * ROTATIONS[self.rotation])


@dataclass(frozen=True, slots=True, eq=False)
class Tie:
    """What the costs of the candidates say."""

    candidates: list[Candidate]
    costs: FloatArray
    """(w, c) of every window and candidate."""
    turned: FloatArray
    """(w,) rad, of the gyroscope as it is in the best unit."""

    @property
    def mean(self) -> FloatArray:
        """(c,)"""
        return np.asarray(self.costs.mean(axis=0))

    @property
    def best(self) -> int:
        """The candidate of the smallest cost."""
        return int(np.argmin(self.mean))

    def score(self, other: int, best: int | None = None, part: slice | None = None) -> float:
        """By how many standard errors another candidate is worse than the best, over paired windows."""
        costs = self.costs[part or slice(None)]
        apart = costs[:, other] - costs[:, self.best if best is None else best]
        if len(apart) < 2:
            return 0.0
        spread = float(apart.std(ddof=1))
        return float(apart.mean()) / max(spread / math.sqrt(len(apart)), 1e-9)

    def scores(self) -> FloatArray:
        """(c,) of every candidate against the best; infinite for itself."""
        apart = self.costs - self.costs[:, [self.best]]
        spread = np.maximum(apart.std(axis=0, ddof=1) / np.sqrt(len(apart)), 1e-9)
        found = apart.mean(axis=0) / spread
        found[self.best] = np.inf
        return np.asarray(found)

    def find(self, rotation: int, sign: float, factor: float) -> int:
        """The number of a candidate."""
        return self.candidates.index(Candidate(rotation, sign, factor))


def windows(coarse: Coarse, seconds: float, readings: FloatArray) -> tuple[NDArray[np.intp], int]:
    """First steps of the windows of which enough is known, and their length in steps."""
    length = max(round(seconds * coarse.rate), 4)
    count = len(coarse) // length
    if count < 2:
        return np.zeros(0, dtype=np.intp), length
    starts = np.arange(count) * length
    turn_known: BoolArray = np.asarray(np.isfinite(coarse.turn).all(axis=1))
    there: BoolArray = np.asarray(np.isfinite(readings).all(axis=1))
    used = count * length
    known = turn_known[:used].reshape(count, length).mean(axis=1) >= 1.0 - MISSED
    known &= there[:used].reshape(count, length).mean(axis=1) >= LEAST
    known &= coarse.step[:used].reshape(count, length).sum(axis=1) <= 1.5 * seconds
    starts = starts[known]
    if len(starts) > MOST:
        starts = starts[np.linspace(0, len(starts) - 1, MOST).round().astype(np.intp)]
    return starts, length


def sums(coarse: Coarse, vectors: FloatArray, seconds: float, part: float, factor: float) -> Sums:
    """Integrate the turns times `factor` in every window, and sum up the vectors in the frame of its start.

    Parameters
    ----------
    coarse : the steps.
    vectors : (n, 3), NaN where there is no reading.
    seconds, part : length of a window and of its first and last part, s.
    factor : of the angular rate, with its sign.
    """
    from ahrs_rs.filters import FILTERS

    starts, length = windows(coarse, seconds, vectors)
    ends = max(round(part * coarse.rate), 1)
    size = (len(starts), 3, 3, 4)
    first, last = np.full(size, np.nan), np.full(size, np.nan)
    integrate = FILTERS["GyroIntegration"](rate=1.0)
    at_once = max((1 << 17) // length, 1)
    for i in range(0, len(starts), at_once):
        chosen = starts[i : i + at_once]
        index = chosen[:, np.newaxis] + np.arange(length)
        turn = np.nan_to_num(coarse.turn[index]) * factor
        turn[:, 0] = 0.0
        quat = np.asarray(integrate.run(turn).quat)
        v = vectors[index]
        for rows, into in ((slice(0, ends), first), (slice(length - ends, length), last)):
            matrix = _native.rotation_matrices(np.ascontiguousarray(quat[:, rows]))
            part_v = v[:, rows]
            there = np.isfinite(part_v).all(axis=2)
            extended = np.concatenate(
                [np.where(there[..., np.newaxis], part_v, 0.0), there[..., np.newaxis].astype(np.float64)], axis=2
            )
            number = there.sum(axis=1)
            total = matrix.reshape(*matrix.shape[:2], 9).swapaxes(1, 2) @ extended
            mean = np.full(total.shape, np.nan)
            np.divide(total, number[:, None, None], out=mean, where=(number > 0)[:, None, None])
            into[i : i + len(chosen)] = mean.reshape(-1, 3, 3, 4)
    known = np.isfinite(first).all(axis=(1, 2, 3)) & np.isfinite(last).all(axis=(1, 2, 3))
    first, last, starts = first[known], last[known], starts[known]
    turned = np.linalg.norm(first[..., 3] - last[..., 3], axis=(1, 2)) / np.sqrt(2.0)
    return Sums(first, last, np.asarray(turned), starts)


def parts(found: Sums, matrix: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Means of both parts (w, 3) for readings turned by `matrix`, and of R there (w, 3, 3)."""
    a = np.einsum("wijk,jk->wi", found.first[..., :3], matrix)
    b = np.einsum("wijk,jk->wi", found.last[..., :3], matrix)
    return a, b, found.first[..., 3], found.last[..., 3]


def constant(found: Sums, matrix: FloatArray, size: float) -> FloatArray:
    """(3,) the vector, constant in the turned sensor, that explains most of what the readings move: h of ΔR h."""
    a, b, r_a, r_b = parts(found, matrix)
    change = r_a - r_b
    apart = a - b
    weight = 1.0 / (1.0 + (apart**2).sum(axis=1) / (0.1 * size) ** 2)
    normal = np.einsum("w,wij,wik->jk", weight, change, change)
    normal += np.eye(3) * len(a) * 1e-3 + np.eye(3) * 1e-9
    return np.asarray(np.linalg.solve(normal, np.einsum("w,wij,wi->j", weight, change, apart)))


def tie(
    coarse: Coarse,
    vectors: FloatArray,
    seconds: float,
    part: float,
    *,
    offset: bool,
    factors: tuple[float, ...] = FACTORS,
) -> Tie | None:
    """The costs of all candidates, or None where too few windows turn."""
    norms = np.linalg.norm(vectors, axis=1)
    known = np.isfinite(norms)
    if not known.any():
        return None
    size = float(np.median(norms[known]))
    if not size > 0.0:
        return None
    candidates: list[Candidate] = []
    costs: list[FloatArray] = []
    turned = np.zeros(0)
    for factor in factors:
        for sign in (1.0, -1.0):
            found = sums(coarse, vectors, seconds, part, sign * factor)
            if factor == 1.0 and sign > 0:
                turned = found.turned
                if np.count_nonzero(turned > TURNED) < FEWEST and len(factors) == 1:
                    return None
            for k, matrix in enumerate(ROTATIONS):
                # P ω with P = sign · Q is what turns v: in the sensor's own axes that is Qᵀ … Q.
                a, b, r_a, r_b = parts(found, sign_free(matrix))
                if offset:
                    h = constant(found, sign_free(matrix), size)
                    a, b = a - r_a @ h, b - r_b @ h
                mean = 0.5 * (np.linalg.norm(a, axis=1) + np.linalg.norm(b, axis=1))
                cost = np.linalg.norm(a - b, axis=1) / np.maximum(mean, 1e-3 * size)
                candidates.append(Candidate(k, sign, factor))
                costs.append(np.minimum(cost, 1.0))
    if len(turned) < FEWEST:
        return None
    return Tie(candidates, np.column_stack(costs), turned)


def sign_free(matrix: FloatArray) -> FloatArray:
    """Q of P = ± Q acts on the readings as Qᵀ: R(P ω) v = Q R(± ω) Qᵀ v, whose lengths are those of R(± ω) Qᵀ v."""
    return matrix.T
