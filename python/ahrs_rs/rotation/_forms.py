"""Rotations as matrices and as rotation vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _native, _quat, _validate
from ahrs_rs._typing import Floats

__all__ = ["from_matrix", "from_rotvec", "to_matrix", "to_rotvec"]

#: Largest entry of RᵀR - 1. Nine entries rounded to 3 decimals stay within it.
ORTHONORMAL_TOLERANCE = 3e-3
#: RᵀR - 1 in rounding errors up to which a matrix is a rotation as it stands.
ROUNDING = 64.0


def from_matrix(matrix: ArrayLike) -> Floats:
    """Quaternions of rotation matrices: ``v_earth = matrix @ v_sensor``.

    A matrix that is no rotation to rounding, as of a file with few decimals, gives the nearest rotation: that with the
    least sum of squares of the differences of the entries.

    Parameters
    ----------
    matrix : array_like
        (..., 3, 3).

    Returns
    -------
    ndarray
        (..., 4), w >= 0.

    Raises
    ------
    ValueError
        Another shape, a mirror image, or columns that are not orthonormal to 0.003.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.from_matrix([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).round(6)
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    given = _validate.rows("matrix", matrix, 3, 3)
    error = np.abs(np.swapaxes(given, -1, -2) @ given - np.eye(3, dtype=given.dtype)).max(axis=(-2, -1))
    if (error > ORTHONORMAL_TOLERANCE).any():
        raise ValueError(f"matrix: expected orthonormal columns, got RᵀR that differs from 1 by {np.nanmax(error):.3g}")
    x, y, z = np.moveaxis(given, -1, 0)
    if (np.sum(np.cross(x, y) * z, axis=-1) < 0.0).any():
        raise ValueError("matrix: expected rotations, got a mirror image (determinant -1)")
    quat = _quat.of_matrix(given)
    rough = error > ROUNDING * np.finfo(given.dtype).eps
    if rough.any():
        largest = np.linalg.eigh(_quat.products_of(given[rough]))[1][..., -1]
        quat[rough] = _quat.upper(largest)
    return quat


def to_matrix(q: ArrayLike) -> Floats:
    """Rotation matrices of quaternions: ``v_earth = matrix @ v_sensor``.

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first.

    Returns
    -------
    ndarray
        (..., 3, 3).

    Raises
    ------
    ValueError
        Another shape, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.to_matrix([0.6, 0.0, 0.0, 0.8]).round(6) + 0.0
    array([[-0.28, -0.96,  0.  ],
           [ 0.96, -0.28,  0.  ],
           [ 0.  ,  0.  ,  1.  ]])
    """
    return _native.rotation_matrices(_validate.unit_quaternions("q", q))


def from_rotvec(vector: ArrayLike, *, degrees: bool = False) -> Floats:
    """Quaternions of rotation vectors: the axis, times the angle.

    Parameters
    ----------
    vector : array_like
        (..., 3) rad, of any length.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 4).

    Raises
    ------
    ValueError
        Another shape.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.from_rotvec([0.0, 60.0, 0.0], degrees=True).round(6)
    array([0.866025, 0.      , 0.5     , 0.      ])
    """
    vectors = _validate.rows("vector", vector, 3)
    return _quat.exp(np.radians(vectors) if degrees else vectors)


def to_rotvec(q: ArrayLike, *, degrees: bool = False) -> Floats:
    """Rotation vectors of quaternions: the axis, times the angle, which is at most half a turn.

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first; q and -q give the same.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 3) rad.

    Raises
    ------
    ValueError
        Another shape, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.to_rotvec([0.6, 0.0, 0.0, -0.8]).round(6) + 0.0
    array([ 0.     ,  0.     , -1.85459])
    """
    vectors = _quat.log(_validate.unit_quaternions("q", q))
    return np.degrees(vectors) if degrees else vectors
