"""FLAE: the largest eigenvalue in closed form, and the eigenvector of it by Cramer's rule."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _validate
from ahrs_rs._typing import FloatArray, Floats
from ahrs_rs.attitude._arguments import columns, determinant, dot, longest
from ahrs_rs.attitude._pairs import largest, profile

METHODS = ("symbolic", "newton", "eig")
#: Newton's steps at most, from 1, and after the closed form, which has lost digits.
STEPS, POLISHED = 60, 3


def flae(
    sensor: ArrayLike,
    earth: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    method: str = "symbolic",
) -> Floats:
    """FLAE, the fast linear attitude estimator: Wahba's problem by the roots of a quartic.

    Parameters
    ----------
    sensor : array_like
        (..., n, 3) directions in the sensor frame, of any length, n ≥ 2.
    earth : array_like
        (..., n, 3) the same in the earth frame; leading axes broadcast.
    weights : array_like, optional
        (..., n) weights; equal ones by default. Those of the smallest error are 1/σ², for directions with
        the standard deviations σ. Only their ratios count.
    method : {"symbolic", "newton", "eig"}, optional
        How the largest eigenvalue is found: in closed form, by Newton's method from 1, or by the eigenvalues
        of the matrix W, which is `davenport`.

    Returns
    -------
    ndarray
        (..., 4) quaternions from sensor to earth. Pairs with a zero vector or a NaN are left out; NaN where
        the rest does not determine the attitude.

    Raises
    ------
    ValueError
        Arrays of another shape, infinite values, negative weights, or an unknown method.

    Notes
    -----
    Source: J. Wu, Z. Zhou, B. Gao, R. Li, Y. Cheng and H. Fourati, "Fast linear quaternion attitude estimator using
    vector observations", IEEE Transactions on Automation Science and Engineering 15(1), 2018, equations 42 to 58,
    as the documentation of the package `ahrs` has them. Three things differ, none in exact arithmetic. The cube
    root of equation 53 is that of a complex number, and taken as such. The root of the closed form, which has lost
    half of its digits where two eigenvalues are close, is put right by Newton's steps (equation 51). Equations 55
    to 58 fix one part of the quaternion at -1; here it is the largest one, so that none has to be other than zero.
    "symbolic" and "newton" lose digits, and are NaN, as `quest` is.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> earth = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    >>> ar.attitude.flae([[0.0, 0.0, 9.81], [30.0, 0.0, 0.0]], earth).round(6)
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    _validate.choice("method", method, METHODS)
    found = profile(sensor, earth, weights)
    w = found.davenport()  # equation 44: the same matrix
    if method == "eig":
        return found.finished(*largest(w))
    h = found.matrix  # equation 42: its columns are H_x, H_y and H_z
    t1 = -2.0 * np.sum(h * h, axis=(-2, -1))  # equation 49
    t2 = -8.0 * determinant(h)
    t3 = np.linalg.det(w)
    if method == "newton":
        root = _newton(np.ones(t1.shape), t1, t2, t3, STEPS)
    else:
        root = _newton(_symbolic(t1, t2, t3), t1, t2, t3, POLISHED)
    return found.finished(_null_vector(w - root[..., np.newaxis, np.newaxis] * np.eye(4)), polynomial=True)


def _newton(root: FloatArray, t1: FloatArray, t2: FloatArray, t3: FloatArray, steps: int) -> FloatArray:
    """Newton's steps towards the largest root."""
    moving = np.ones(root.shape, dtype=bool)
    for _ in range(steps):
        value = root**4 + t1 * root**2 + t2 * root + t3  # equation 48
        slope = 4.0 * root**3 + 2.0 * t1 * root + t2  # equation 50
        step = np.divide(value, slope, out=np.zeros_like(value), where=moving & (slope > 0.0))
        root = root - step  # equation 51
        moving = np.abs(step) > np.finfo(np.float64).eps
        if not moving.any():
            break
    return root


def _symbolic(t1: FloatArray, t2: FloatArray, t3: FloatArray) -> FloatArray:
    """The largest root in closed form.

    W is symmetric, so all roots are real, and T₁ of equation 53 is complex: with D = τ₁² + 12 τ₃, 2^(2/3) T₁ and
    2^(4/3) D / T₁ are conjugate, and their sum is 4 √D cos(φ/3), φ being the angle of T₀ + i √(4 D³ - T₀²).
    """
    d = np.maximum(t1**2 + 12.0 * t3, 0.0)
    t0 = 2.0 * t1**3 + 27.0 * t2**2 - 72.0 * t1 * t3  # equation 53
    phi = np.arctan2(np.sqrt(np.maximum(4.0 * d**3 - t0**2, 0.0)), t0)
    big = np.sqrt(np.maximum(-4.0 * t1 + 4.0 * np.sqrt(d) * np.cos(phi / 3.0), 0.0))  # T₂
    ratio = np.divide(t2, big, out=np.zeros_like(t2), where=big > 0.0)
    inner = np.maximum(-(big**2) - 12.0 * t1 - 12.0 * np.sqrt(6.0) * ratio, 0.0)
    largest: FloatArray = (big + np.sqrt(inner)) / (2.0 * np.sqrt(6.0))  # equation 52: λ₂ of its four
    return largest


def _null_vector(n: FloatArray) -> FloatArray:
    """The vector (..., 4) that a singular symmetric matrix (..., 4, 4) takes to zero, not of unit norm.

    Equations 54 to 58 by Cramer's rule, multiplied by the determinant in place of being divided by it, with each of the
    parts as the one that is -1: the longest of the four results is that of the largest part.
    """
    rows = []
    for fixed in range(4):
        others = [k for k in range(4) if k != fixed]
        first, second, third = (n[..., others, k] for k in others)
        right = n[..., others, fixed]
        across = np.cross(second, third)
        row = np.empty(n.shape[:-1])
        row[..., fixed] = -dot(first, across)
        row[..., others] = columns(
            dot(right, across), dot(first, np.cross(right, third)), dot(first, np.cross(second, right))
        )
        rows.append(row)
    return longest(np.stack(rows, axis=-2))
