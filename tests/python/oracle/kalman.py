"""What the Kalman filters share: the textbook update, bounds of a covariance, and its report in the sensor frame.

Everything is written in whole matrices. The library updates by one scalar at a time and keeps one triangle; with a
diagonal measurement covariance the two are the same filter.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from .so3 import Quat, Vec3, matrix

Array: TypeAlias = NDArray[np.float64]

ACC_REJECTED = 8
MAG_REJECTED = 16
REST = 32
RECOVERING = 128

#: Variance of an angle of which nothing is known: uniform on [-π, π] (rad²).
UNKNOWN_ANGLE = math.pi**2 / 3
#: Relative growth of the diagonal in every prediction, in epsilons of the scalar: more than the rounding of a step.
INFLATION = 8 * float(np.finfo(np.float64).eps)
#: Largest specific force that is used, and largest field relative to its reference: 16 times the expected.
SATURATION = 16.0
#: Largest turn of a first-order step (rad), of the matrix or half of it of the quaternion.
LARGEST_TURN = 10.0
#: Largest bias, in its initial standard deviations.
LARGEST_BIAS = 20.0
#: A new attitude whose vertical is off by less than this (rad) only turns about the vertical.
SAME_VERTICAL = 1e-4


def angle_variance(variance: float) -> float:
    """The variance of an angle at the start: at most that of one of which nothing is known."""
    return min(variance, UNKNOWN_ANGLE)


def skew(v: Array) -> Array:
    """[v×], the matrix with [v×] w = v × w."""
    x, y, z = v.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation(q: Quat) -> Array:
    """R(q) as an array: v_earth = R v_sensor."""
    return np.array(matrix(q))


def triple(v: Array) -> Vec3:
    """Three components as a tuple of floats."""
    x, y, z = v.tolist()
    return (x, y, z)


def saturated(v: Array, limit: float) -> Array:
    """V, shortened to the length `limit` if it is longer."""
    norm = math.hypot(*v.tolist())
    return v * (limit / norm) if norm > limit else v


def inflated(p: Array) -> Array:
    """P with its diagonal grown by eight epsilons, so that rounding does not make it indefinite."""
    return p + INFLATION * np.diag(np.diag(p))


def capped(p: Array, variances: Array) -> Array:
    """D P D, with the diagonal D ≤ 1 that brings every variance down to its cap (inf: none): correlations stay."""
    diagonal = np.diag(p)
    over = diagonal > variances
    d = np.sqrt(np.where(over, variances, 1.0) / np.where(over, diagonal, 1.0))
    scaled: Array = p * np.outer(d, d)
    return scaled


def gain(p: Array, h: Array, r: Array) -> tuple[Array, Array]:
    """Kalman gain P Hᵀ S⁻¹ and innovation covariance S = H P Hᵀ + R; h (m, n), r (m, m)."""
    s: Array = h @ p @ h.T + r
    return np.asarray(np.linalg.solve(s, h @ p).T, dtype=np.float64), s


def joseph(p: Array, k: Array, h: Array, r: Array) -> Array:
    """(I - K H) P (I - K H)ᵀ + K R Kᵀ, the covariance after a step with any gain, symmetrised."""
    a = np.eye(len(p)) - k @ h
    p = a @ p @ a.T + k @ r @ k.T
    return (p + p.T) / 2


def normalised_square(nu: Array, s: Array) -> float:
    """The innovation νᵀ S⁻¹ ν, chi-square distributed with len(ν) degrees of freedom if the model is true."""
    return float(nu @ np.linalg.solve(s, nu))


def reported(p: Array, up: Array, heading_known: bool) -> Array:
    """Attitude covariance (3, 3) in the sensor frame (rad²).

    Where the heading is not known, or its variance is beyond that of an unknown angle, the error about the vertical
    `up` (unit vector, sensor frame) counts as uniform and as independent of the inclination's.
    """
    if heading_known and up @ p @ up <= UNKNOWN_ANGLE:
        return p
    t = np.eye(3) - np.outer(up, up)
    return t @ p @ t + UNKNOWN_ANGLE * np.outer(up, up)
