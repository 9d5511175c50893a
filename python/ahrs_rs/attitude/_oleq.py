"""OLEQ: the attitude as the fixed point of a linear map."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._typing import Floats
from ahrs_rs.attitude._pairs import profile

#: The map is applied 2^k times, for k up to this: enough for eigenvalues that differ by 1e-14.
SQUARINGS = 52


def oleq(sensor: ArrayLike, earth: ArrayLike, *, weights: ArrayLike | None = None) -> Floats:
    """OLEQ, the optimal linear estimator of quaternion: Wahba's problem by the fixed point of a map.

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
    Source: Z. Zhou, J. Wu, J. Wang and H. Fourati, "Optimal, recursive and sub-optimal linear solutions to attitude
    determination from vector observations for GNSS/accelerometer/magnetometer orientation measurement", Remote
    Sensing 10(3), 2018, as the documentation of the package `ahrs` has it: q ← ½ (W + I) q, again and again, from a
    random quaternion. Its error shrinks by (1 + λ₂)/(1 + λ₁) a step, by a few percent for gravity and field, so
    hundreds of steps are due. Here the matrix is squared in place of that: k squarings are 2^k steps. No start is
    drawn: the columns of the result are what the four unit quaternions become, and the longest one is taken.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> earth = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    >>> ar.attitude.oleq([[0.0, 0.0, 9.81], [30.0, 0.0, 0.0]], earth).round(6)
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    found = profile(sensor, earth, weights)
    power = 0.5 * (found.davenport() + np.eye(4))  # eigenvalues within 0 and 1, as |bᵢ| = |rᵢ| = 1 and Σ aᵢ = 1
    moving = np.ones(power.shape[:-2], dtype=bool)
    for _ in range(SQUARINGS):
        # Of trace 1: then it is q qᵀ where it no longer changes.
        power = power / np.trace(power, axis1=-2, axis2=-1)[..., np.newaxis, np.newaxis]
        square = power @ power
        moving &= np.abs(square - power).max(axis=(-2, -1)) > np.finfo(np.float64).eps
        if not moving.any():
            break
        power = np.where(moving[..., np.newaxis, np.newaxis], square, power)
    longest = np.argmax(np.diagonal(power, axis1=-2, axis2=-1), axis=-1)
    return found.finished(np.take_along_axis(power, longest[..., np.newaxis, np.newaxis], axis=-1)[..., 0])
