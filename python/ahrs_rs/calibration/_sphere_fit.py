"""The numbers behind hard iron alone: ‖x − b‖ = ρ, a sphere of four unknowns, or a circle of three in a plane.

As of an ellipsoid (`_ellipsoid_fit`): a linear least squares |x|² = 2 b·x + k inside of a least median of squares is
the start, Gauss-Newton on the residuals ‖x − b‖ − ρ of all readings within `CUT` robust standard deviations the end,
and the sandwich covariance times the correlation time of the residuals the uncertainty.

Arrays of readings stand as (d, n) here, d = 2 or 3: a row an axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ahrs_rs._typing import BoolArray, FloatArray
from ahrs_rs.calibration._ellipsoid_fit import (
    CONVERGED,
    CORE,
    CUT,
    NORMAL_QUANTILES,
    ROUNDING,
    START_READINGS,
    WIDE_CUT,
    correlation_time,
)
from ahrs_rs.calibration._linear import DRAWS, NoEllipsoidError, areas, quantile

#: Readings that a random sample of the start has beyond the unknowns.
MORE = 3
#: The refinement needs three or four steps, and some more where readings join or leave.
STEPS = 60
#: The worst determined combination has so much of the information of evenly spread directions: its deviation is 14
#: times as large. A drone that tilts by 30° in a field that dips by 66° has 0.02 to 0.03, one that tilts by 15° 0.006.
LEAST_OBSERVABILITY = 0.005


@dataclass(frozen=True, slots=True)
class Sphere:
    """A fit: θ = (ρ, b), and what is known of it."""

    radius: float
    centre: FloatArray
    """(d,)"""
    covariance: FloatArray
    """(d + 1, d + 1) of θ."""
    keep: BoolArray
    residual: FloatArray
    """(n,) ‖x − b‖ − ρ."""
    deviation: float
    correlation: float
    observability: float
    """The smallest eigenvalue of the information over that of evenly spread directions, which is 1/d."""


def fit(x: FloatArray) -> Sphere:
    """The sphere or the circle of the readings (d, n); `NoEllipsoidError` where they determine none."""
    axes, count = x.shape
    random = np.random.default_rng(0)
    few = x if count <= START_READINGS else x[:, random.integers(0, count, START_READINGS)]
    weights = areas(few)
    shift = quantile(few, weights, 0.5)
    size = float(quantile(np.sqrt(((few - shift[:, None]) ** 2).sum(axis=0)), weights, 0.5))
    if not size > 0:
        raise NoEllipsoidError
    z, few = (x - shift[:, None]) / size, (few - shift[:, None]) / size
    radius, b = _start(few, weights, random)
    cut, keep = WIDE_CUT, np.ones(count, dtype=np.bool_)
    for _ in range(STEPS):
        border = max(
            cut * float(quantile(np.abs(_residual(few, radius, b)), weights, CORE)) / NORMAL_QUANTILES[CORE], ROUNDING
        )
        chosen = np.abs(_residual(z, radius, b)) <= border
        jacobian = _jacobian(z[:, chosen], b)
        information = jacobian @ jacobian.T
        if not _observability(information / max(int(chosen.sum()), 1), axes) >= LEAST_OBSERVABILITY:
            raise NoEllipsoidError
        step = np.linalg.solve(information, jacobian @ _residual(z[:, chosen], radius, b)).astype(
            np.float64, copy=False
        )
        same, keep = bool(np.array_equal(chosen, keep)), chosen
        radius, b = radius + float(step[0]), b + step[1:]
        if not (radius > 0 and np.isfinite(radius)):
            raise NoEllipsoidError
        if same and float(np.abs(step).max()) < CONVERGED * (1.0 + float(np.abs(b).max())):
            if cut == CUT:
                break
            cut = CUT
    residual = _residual(z, radius, b)
    kept = residual[keep]
    jacobian = _jacobian(z[:, keep], b)
    information = jacobian @ jacobian.T
    inverse = np.linalg.inv(information).astype(np.float64, copy=False)
    correlation = correlation_time(kept)
    scores = (jacobian * kept**2) @ jacobian.T
    return Sphere(
        radius=radius * size,
        centre=shift + size * b,
        covariance=inverse @ scores @ inverse * (correlation * size**2),
        keep=keep,
        residual=residual * size,
        deviation=float(np.sqrt(kept @ kept / max(len(kept) - axes - 1, 1))) * size,
        correlation=correlation,
        observability=_observability(information / len(kept), axes),
    )


def _residual(z: FloatArray, radius: float, b: FloatArray) -> FloatArray:
    residual: FloatArray = np.sqrt(((z - b[:, None]) ** 2).sum(axis=0)) - radius
    return residual


def _jacobian(z: FloatArray, b: FloatArray) -> FloatArray:
    """(d + 1, n) of ρ + u·db, by which ‖z − b‖ is to be met: u are the unit vectors from the centre."""
    v = z - b[:, None]
    length = np.sqrt((v * v).sum(axis=0))
    jacobian: FloatArray = np.vstack((np.ones(z.shape[1]), v / np.where(length > 0, length, 1.0)))
    return jacobian


def _observability(information: FloatArray, axes: int) -> float:
    return max(float(np.linalg.eigvalsh(information)[0]) * axes, 0.0)


def _start(z: FloatArray, weights: FloatArray, random: np.random.Generator) -> tuple[float, FloatArray]:
    """Of the linear fits to all readings and to many random samples that with the smallest median distance."""
    axes, count = z.shape
    size = axes + 1 + MORE
    groups = [np.arange(count)]
    if count >= 2 * size:
        # The smallest of exponential numbers over weights are a sample by weight, without repetition.
        groups += list((random.exponential(size=(DRAWS, count)) / weights).argpartition(size, axis=1)[:, :size])
    best: tuple[float, float, FloatArray] | None = None
    for k, group in enumerate(groups):
        found = _linear(z[:, group], weights if k == 0 else np.ones(size))
        if found is None:
            continue
        median = float(quantile(np.abs(_residual(z, *found)), weights, CORE))
        if best is None or median < best[0]:
            best = (median, *found)
    if best is None:
        raise NoEllipsoidError
    return best[1], best[2]


def _linear(z: FloatArray, weights: FloatArray) -> tuple[float, FloatArray] | None:
    """|z|² = 2 b·z + k by least squares, about the mean; None where it is singular."""
    mean = z @ weights / weights.sum()
    v = z - mean[:, None]
    design = np.vstack((2.0 * v, np.ones(z.shape[1])))
    gram = (design * weights) @ design.T
    try:
        solution = np.linalg.solve(gram, (design * weights) @ (v * v).sum(axis=0)).astype(np.float64, copy=False)
    except np.linalg.LinAlgError:
        return None
    b = solution[:-1]
    square = float(solution[-1] + b @ b)
    return (float(np.sqrt(square)), b + mean) if square > 0 and np.isfinite(solution).all() else None
