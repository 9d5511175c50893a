"""Sums over the readings of an ellipsoid fit: gradient and normal equations of Σ r², r = ρ (‖A (x − b)‖ − 1).

Arrays of readings stand as (3, n) here: a row an axis. They are gone through in pieces that stay in the cache.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ahrs_rs._typing import BoolArray, FloatArray
from ahrs_rs.calibration._linear import PAIRS

#: Readings that are worked on together: their Jacobian stays in the cache.
CHUNK = 1 << 12


def symmetric(values: FloatArray) -> FloatArray:
    """The symmetric matrix of three values on the diagonal and, with six, three beyond it."""
    matrix = np.diag(values[:3])
    for value, (i, j) in zip(values[3:], PAIRS, strict=False):
        matrix[i, j] = matrix[j, i] = value
    return matrix


def residuals(z: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    norms = [np.sqrt(((a @ (z[:, i : i + CHUNK] - b[:, None])) ** 2).sum(axis=0)) for i in range(0, z.shape[1], CHUNK)]
    residual: FloatArray = mean_radius(a) * (np.concatenate(norms) - 1.0)
    return residual


def mean_radius(a: FloatArray) -> float:
    """The mean radius of ‖A x‖ = 1: that of the sphere of the same volume."""
    radius: float = float(np.linalg.det(a)) ** (-1.0 / 3.0)
    return radius


def _shape_slope(a: FloatArray, parameters: int) -> FloatArray:
    """(p,) w of w dA = tr(A⁻¹ dA) / 3 = −dρ/ρ."""
    inverse = np.linalg.inv(a)
    w = np.zeros(parameters)
    w[: parameters - 3] = [inverse[i, i] for i in range(3)] + [2.0 * inverse[i, j] for i, j in PAIRS[: parameters - 6]]
    return w / 3.0


def _pieces(
    z: FloatArray, a: FloatArray, b: FloatArray, keep: BoolArray | float, residual: FloatArray
) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """By pieces v = x − b, u = A v / ‖A v‖ and f = ‖A v‖ − 1, the latter two zero where a reading is left out.

    `keep` tells which are kept, or up to which residual; `residual` is filled.
    """
    radius = mean_radius(a)
    for start in range(0, z.shape[1], CHUNK):
        part = slice(start, start + CHUNK)
        v = z[:, part] - b[:, None]
        y = a @ v
        norm = np.sqrt((y * y).sum(axis=0))
        f = norm - 1.0
        np.multiply(f, radius, out=residual[part])
        kept = np.abs(residual[part]) <= keep if isinstance(keep, float) else keep[part]
        f *= kept
        y *= kept / np.maximum(norm, np.finfo(np.float64).tiny)
        yield v, y, f


def gradient(
    z: FloatArray, a: FloatArray, b: FloatArray, parameters: int, keep: BoolArray | float
) -> tuple[FloatArray, FloatArray]:
    """Σ J r over the readings that are kept, and all residuals r."""
    residual = np.empty(z.shape[1])
    by_matrix, by_centre, power = np.zeros((3, 3)), np.zeros(3), 0.0
    for v, u, f in _pieces(z, a, b, keep, residual):
        power += float(f @ f)
        u *= f
        by_matrix += u @ v.T
        by_centre += u.sum(axis=1)
    by_matrix += by_matrix.T
    pairs = [by_matrix[i, j] for i, j in PAIRS[: parameters - 6]]
    g = np.concatenate((0.5 * np.diag(by_matrix), pairs, -a @ by_centre))
    return mean_radius(a) ** 2 * (g - power * _shape_slope(a, parameters)), residual


def normal_equations(
    z: FloatArray,
    a: FloatArray,
    b: FloatArray,
    parameters: int,
    keep: BoolArray,
    inverse_h: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Σ J Jᵀ and Σ J r over the readings that are kept, all residuals r, and Σ r² of those that are kept.

    With H⁻¹ J is weighted by r / √(1 − Jᵀ H⁻¹ J): the residual, by which the fit has shortened it (MacKinnon and White,
    Journal of Econometrics 29:305-325, 1985: HC2).

    J = ρ (J₀ − f w), where J₀ and f are those of ‖A (x − b)‖ − 1 and w dA = −dρ/ρ.
    """
    radius, w = mean_radius(a), _shape_slope(a, parameters)
    h, g, power = np.zeros((parameters, parameters)), np.zeros(parameters), 0.0
    residual = np.empty(z.shape[1])
    for v, u, f in _pieces(z, a, b, keep, residual):
        j0 = np.empty((parameters, v.shape[1]))
        np.multiply(u, v, out=j0[:3])
        if parameters == 9:
            for k, (i, j) in enumerate(PAIRS):
                np.multiply(u[i], v[j], out=j0[3 + k])
                j0[3 + k] += u[j] * v[i]
        np.matmul(-a, u, out=j0[-3:])
        if inverse_h is not None:
            j0 = radius * (j0 - w[:, None] * f)
            leverage = (j0 * (inverse_h @ j0)).sum(axis=0)
            j0 *= radius * f / np.sqrt(np.maximum(1.0 - leverage, 1e-3))
        h += j0 @ j0.T
        g += j0 @ f
        power += float(f @ f)
    if inverse_h is None:
        cross = np.outer(g, w)
        h = radius**2 * (h - cross - cross.T + power * np.outer(w, w))
        g = radius**2 * (g - power * w)
    return h, g, residual, radius**2 * power
