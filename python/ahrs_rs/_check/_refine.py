"""Small errors, once the axes are known: misalignment, scale of the gyroscope, hard iron, by least squares.

With D = A − B of a window (see `_ties`), a rotation δ of the vector's axes adds Σ M [δ×], a scale 1 + s of the
gyroscope s ∂D/∂s (by a difference), and a constant vector h adds ΔR h. Standard errors are those of the estimates
without one tenth of the windows after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check._case import Coarse
from ahrs_rs._check._ties import TURNED, parts, sums

FloatArray = NDArray[np.float64]

#: Difference of the scale.
STEP = 0.02
#: Left out one part of so many after the other.
PARTS = 10
FEWEST = 20
ROUNDS = 6
#: Windows that are off by more than this part of the vector count little.
TAIL = 0.08


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """What is found, each with its standard error."""

    rotation: FloatArray
    """(3,) rad: the vector's axes have to be turned by it."""
    rotation_error: FloatArray
    scale: float
    """The angular rate has to be multiplied by 1 + scale."""
    scale_error: float
    constant: FloatArray
    """(3,) that has to be taken off the vector."""
    constant_error: FloatArray
    size: float
    """Median norm of the vector."""
    windows: int
    left: float
    """Median of what is left, relative to the vector."""


def refine(coarse: Coarse, vectors: FloatArray, seconds: float, part: float, *, constant: bool) -> Refined | None:
    """The small errors of one vector against the gyroscope; None where too little turns."""
    found = [sums(coarse, vectors, seconds, part, factor) for factor in (1.0, 1.0 + STEP, 1.0 - STEP)]
    middle = found[0]
    chosen = middle.turned > TURNED
    if np.count_nonzero(chosen) < FEWEST or not all(len(one.first) == len(middle.first) for one in found):
        return None
    norms = np.linalg.norm(vectors, axis=1)
    size = float(np.nanmedian(norms))
    identity = np.eye(3)
    a, b, r_a, r_b = parts(middle, identity)
    apart = (a - b)[chosen] / size
    columns = []
    for axis in range(3):
        generator = np.zeros((3, 3))
        generator[(axis + 1) % 3, (axis + 2) % 3], generator[(axis + 2) % 3, (axis + 1) % 3] = -1.0, 1.0
        turned = parts(middle, generator)
        columns.append((turned[0] - turned[1])[chosen] / size)
    more, less = parts(found[1], identity), parts(found[2], identity)
    columns.append(((more[0] - more[1]) - (less[0] - less[1]))[chosen] / size / (2.0 * STEP))
    if constant:
        change = (r_a - r_b)[chosen]
        columns += [-change[:, :, axis] for axis in range(3)]
    design = np.stack(columns, axis=-1)
    estimate = _solved(design, apart, np.arange(len(apart)))
    count = len(apart)
    pieces = np.array_split(np.arange(count), PARTS)
    without = np.array(
        [
            _solved(design, apart, np.concatenate([p for k, p in enumerate(pieces) if k != left]))
            for left in range(PARTS)
        ]
    )
    error = np.sqrt((PARTS - 1) / PARTS * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
    rest = apart + design @ estimate
    h, h_error = (estimate[4:7] * size, error[4:7] * size) if constant else (np.zeros(3), np.zeros(3))
    return Refined(
        estimate[:3],
        error[:3],
        float(estimate[3]),
        float(error[3]),
        h,
        h_error,
        size,
        count,
        float(np.median(np.linalg.norm(rest, axis=1))),
    )


def _solved(design: FloatArray, apart: FloatArray, index: NDArray[np.intp]) -> FloatArray:
    """Least squares of apart + design x, windows with a large rest counting less."""
    x, y = design[index], apart[index]
    prior = np.array([0.3] * 3 + [0.2] + [1.0] * (x.shape[2] - 4))
    estimate = np.zeros(x.shape[2])
    for _ in range(ROUNDS):
        rest = np.linalg.norm(y + x @ estimate, axis=1)
        weight = 1.0 / (1.0 + (rest / TAIL) ** 2)
        normal = np.einsum("w,wij,wik->jk", weight, x, x) + np.diag((0.03 / prior) ** 2)
        estimate = -np.linalg.solve(normal, np.einsum("w,wij,wi->j", weight, x, y))
    return np.asarray(estimate)
