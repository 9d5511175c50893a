"""TRIAD: the attitude of two pairs of directions, of which the first is taken as exact."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._typing import FloatArray, Floats
from ahrs_rs.attitude import _arguments
from ahrs_rs.attitude._pairs import checked


def triad(sensor: ArrayLike, earth: ArrayLike) -> Floats:
    """TRIAD: two pairs, the first one met exactly, the second one only in its plane with the first.

    Parameters
    ----------
    sensor : array_like
        (..., 2, 3) directions in the sensor frame, of any length.
    earth : array_like
        (..., 2, 3) the same in the earth frame; leading axes broadcast.

    Returns
    -------
    ndarray
        (..., 4) quaternions from sensor to earth. NaN where a vector is zero or holds a NaN, or where the two
        directions of one side are along one line.

    Raises
    ------
    ValueError
        Arrays of another shape, more than two pairs, or infinite values.

    Notes
    -----
    Source: H. D. Black, "A passive system for determining the attitude of a satellite", AIAA Journal 2(7), 1964; the
    equation numbers are those of G. M. Lerner in Wertz (ed.), *Spacecraft Attitude Determination and Control*, 1978,
    section 12.2.2, as the documentation of the package `ahrs` has them.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> up_and_north = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    >>> ar.attitude.triad([[0.0, 0.0, 9.81], [1.0, 0.0, 0.0]], up_and_north).round(6)  # x points north
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    b, r, there, dtype = checked(sensor, earth)
    two(b)
    (sensor_axes, sensor_sine), (earth_axes, earth_sine) = _axes(b), _axes(r)
    least = _arguments.LOST * float(np.finfo(dtype).eps)
    known = there.all(axis=-1) & (np.minimum(sensor_sine, earth_sine) > least)
    # Equation 12-45, transposed: A = M_b M_rᵀ turns from earth to sensor.
    matrix = earth_axes @ np.swapaxes(sensor_axes, -1, -2)
    return _arguments.finished(_arguments.of_matrix(matrix), known, dtype)


def triad_covariance(sensor: ArrayLike, sigma: ArrayLike) -> Floats:
    """Covariance of the attitude that `triad` finds.

    Parameters
    ----------
    sensor : array_like
        (..., 2, 3) directions in the sensor frame, of any length; the first one is that which TRIAD meets.
    sigma : array_like
        (..., 2) standard deviations of the two directions, in rad: of the angle about each axis across the
        direction, measured and known side together.

    Returns
    -------
    ndarray
        (..., 3, 3) covariance of the rotation vector of the error in the sensor frame, in rad². NaN where
        the directions do not determine the attitude.

    Raises
    ------
    ValueError
        Arrays of another shape, infinite values, or standard deviations that are negative.

    Notes
    -----
    Source: M. D. Shuster and S. D. Oh, "Three-axis attitude determination from vector observations", Journal of
    Guidance and Control 4(1), 1981: the covariance of TRIAD, to first order in sigma; it is what the derivatives of
    `triad` give. It holds for `saam`, `famc` and `fqa` too, with the accelerometer as the first direction.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> P = ar.attitude.triad_covariance([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], [0.01, 0.02])
    >>> np.sqrt(np.diag(P))  # the heading is that of the second direction
    array([0.01, 0.01, 0.02])
    """
    given = _arguments.vectors("sensor", sensor, rows=2)
    two(given)
    w, there = _arguments.units(given)
    s = _arguments.numbers("sigma", sigma, w.shape[:-1]) ** 2
    first, second = w[..., 0, :], w[..., 1, :]
    sine2 = np.sum(np.cross(first, second) ** 2, axis=-1)
    cosine = np.sum(first * second, axis=-1)
    least = (_arguments.LOST * float(np.finfo(given.dtype).eps)) ** 2
    known = there.all(axis=-1) & (sine2 > least)
    mixed = _outer(first, second)
    bracket = _by(s[..., 1] - s[..., 0], _outer(first, first))
    bracket = bracket + _by(s[..., 0] * cosine, mixed + np.swapaxes(mixed, -1, -2))
    # P = σ₁² I + ((σ₂² - σ₁²) W₁W₁ᵀ + σ₁² (W₁·W₂)(W₁W₂ᵀ + W₂W₁ᵀ)) / |W₁ × W₂|²
    covariance = _by(s[..., 0], np.eye(3)) + _by(1.0 / np.where(known, sine2, 1.0), bracket)
    result: Floats = np.where(known[..., np.newaxis, np.newaxis], covariance, np.nan).astype(given.dtype)
    return result


def two(directions: Floats) -> None:
    """ValueError where these are not two directions."""
    if directions.shape[-2] != 2:
        raise ValueError(f"sensor: expected two directions, (..., 2, 3), got {directions.shape}: svd takes more")


def _axes(pair: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Three axes as columns (..., 3, 3), and the sine of the angle between the two directions (...)."""
    first = pair[..., 0, :]
    cross = np.cross(first, pair[..., 1, :])
    sine = _arguments.length(cross)
    second = cross / np.where(sine > 0.0, sine, 1.0)[..., np.newaxis]  # equation 12-39b
    third = np.cross(first, second)  # equation 12-39c
    return np.stack((first, second, third), axis=-1), sine  # equations 12-41, 12-42


def _outer(u: FloatArray, v: FloatArray) -> FloatArray:
    outer: FloatArray = u[..., :, np.newaxis] * v[..., np.newaxis, :]
    return outer


def _by(number: FloatArray, matrix: FloatArray) -> FloatArray:
    product: FloatArray = number[..., np.newaxis, np.newaxis] * matrix
    return product
