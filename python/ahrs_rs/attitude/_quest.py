"""QUEST: the largest eigenvalue by Newton's method, and the eigenvector in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat
from ahrs_rs._typing import FloatArray, Floats
from ahrs_rs.attitude import _arguments
from ahrs_rs.attitude._pairs import profile

#: Newton's steps at most. It converges in a few; at a double root, which is no determined attitude, linearly.
STEPS = 60


def quest(sensor: ArrayLike, earth: ArrayLike, *, weights: ArrayLike | None = None) -> Floats:
    """QUEST: Wahba's problem by a polynomial's largest root and a closed form, with its sequential rotations.

    Parameters
    ----------
    sensor : array_like
        (..., n, 3) directions in the sensor frame, of any length, n ≥ 2.
    earth : array_like
        (..., n, 3) the same in the earth frame; leading axes broadcast.
    weights : array_like, optional
        (..., n) weights; equal ones by default. Those of the smallest error are 1/σ², for directions with
        the standard deviations σ. Only their ratios count.

    Returns
    -------
    ndarray
        (..., 4) quaternions from sensor to earth. Pairs with a zero vector or a NaN are left out; NaN where
        the rest does not determine the attitude.

    Raises
    ------
    ValueError
        Arrays of another shape, infinite values, or negative weights.

    Notes
    -----
    Source: M. D. Shuster and S. D. Oh, "Three-axis attitude determination from vector observations", Journal of
    Guidance and Control 4(1), 1981, equations 63 to 71, as the documentation of the package `ahrs` has them. The
    closed form is 0/0 at half a turn (w = 0). The paper then turns the frame by half a turn about one of its axes;
    here the best of the four frames is always taken, so that no attitude is singular. The polynomial loses more
    digits than `svd` where the directions are nearly on one line: with two of them at an angle θ, the error is
    about 16 ε/θ⁴ in place of 4 ε/θ². It is NaN where that is a degree, from 0.04° down.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> earth = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    >>> ar.attitude.quest([[0.0, 0.0, -9.81], [0.0, 1.0, 0.0]], earth)  # half a turn about y
    array([0., 0., 1., 0.])
    """
    found = profile(sensor, earth, weights)
    largest = _largest_root(found.matrix)
    turns = (_closed_form(found.matrix, largest, turn) for turn in range(4))
    return found.finished(_arguments.longest(np.stack(list(turns), axis=-2)), polynomial=True)


def _largest_root(b: FloatArray) -> FloatArray:
    """λ, the largest root of equation 70, by Newton's method from 1, the sum of the weights, which bounds it."""
    sigma, delta, kappa, s, z = _parts(b)
    sz = np.einsum("...ij,...j->...i", s, z)
    # Equation 71
    p = sigma**2 - kappa
    q = sigma**2 + np.sum(z * z, axis=-1)
    c = delta + np.sum(z * sz, axis=-1)
    d = np.sum(sz * sz, axis=-1)
    # Equation 70: λ⁴ - (p + q) λ² - c λ + (p q + c σ - d) = 0
    root, moving = np.ones(sigma.shape), np.ones(sigma.shape, dtype=bool)
    for _ in range(STEPS):
        value = root**4 - (p + q) * root**2 - c * root + (p * q + c * sigma - d)
        slope = 4.0 * root**3 - 2.0 * (p + q) * root - c
        step = np.divide(value, slope, out=np.zeros_like(value), where=moving & (slope > 0.0))
        # All roots are real, and the polynomial is convex beyond the largest: steps from there are never negative.
        moving = step > np.finfo(np.float64).eps
        if not moving.any():
            break
        root = root - np.where(moving, step, 0.0)
    return root


def _closed_form(b: FloatArray, largest: FloatArray, turn: int) -> FloatArray:
    """The quaternion (..., 4), not of unit norm, found with the sensor turned by half a turn, or by none.

    Its length is the size of its scalar part, once it has unit norm, times what is the same for all turns.
    """
    sigma, delta, kappa, s, z = _parts(_arguments.SIGNS[turn][:, np.newaxis] * b)
    alpha = largest**2 - sigma**2 + kappa  # equation 66
    beta = largest - sigma
    gamma = (largest + sigma) * alpha - delta
    sz = np.einsum("...ij,...j->...i", s, z)
    ssz = np.einsum("...ij,...j->...i", s, sz)
    x = alpha[..., np.newaxis] * z + beta[..., np.newaxis] * sz + ssz  # equation 68
    quat = np.concatenate((gamma[..., np.newaxis], x), axis=-1)  # equation 69
    return _quat.multiply(quat, np.broadcast_to(_arguments.HALF_TURNS[turn], quat.shape))


def _parts(b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """σ, Δ, κ, S and Z of equation 63: κ is the trace of the adjugate of S = B + Bᵀ."""
    s = b + np.swapaxes(b, -1, -2)
    sigma = np.trace(b, axis1=-2, axis2=-1)
    z = np.stack([b[..., i, j] - b[..., j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)
    minors = [s[..., i, i] * s[..., j, j] - s[..., i, j] ** 2 for i, j in ((0, 1), (0, 2), (1, 2))]
    return sigma, _arguments.determinant(s), sum(minors[1:], minors[0]), s, z
