"""Wahba's problem by matrix decompositions: singular values, and Davenport's eigenvector; its covariance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat
from ahrs_rs._typing import Floats
from ahrs_rs.attitude import _arguments
from ahrs_rs.attitude._pairs import checked, determined, largest, profile, room_of


def svd(sensor: ArrayLike, earth: ArrayLike, *, weights: ArrayLike | None = None) -> Floats:
    """Wahba's problem by the singular values of the attitude profile: the most robust method.

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
    Source: F. L. Markley, "Attitude determination using vector observations and the singular value decomposition",
    Journal of the Astronautical Sciences 36(3), 1988.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> earth = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
    >>> sensor = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    >>> ar.attitude.svd(sensor, earth, weights=[1.0, 1.0, 0.5]).round(6)
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    found = profile(sensor, earth, weights)
    u, s, v = np.linalg.svd(found.matrix)  # B = U S Vᵀ; numpy's v is Vᵀ
    # A = U diag(1, 1, det U det V) Vᵀ from earth to sensor: transposed here.
    signs = np.ones(found.matrix.shape[:-1])
    signs[..., 2] = np.sign(_arguments.determinant(u) * _arguments.determinant(v))
    matrix = np.swapaxes(v, -1, -2) @ (signs[..., np.newaxis] * np.swapaxes(u, -1, -2))
    return found.finished(_arguments.of_matrix(matrix), room_of(s, signs[..., 2]))


def davenport(sensor: ArrayLike, earth: ArrayLike, *, weights: ArrayLike | None = None) -> Floats:
    """Davenport's q method: Wahba's problem by the eigenvectors of a symmetric 4 × 4 matrix.

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
    Source: P. B. Davenport (1968), as J. Keat, "Analysis of least-squares attitude determination routine DOAOP",
    CSC/TM-77/6034, 1977, has it.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> earth = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    >>> ar.attitude.davenport([[0.0, 0.0, 9.81], [30.0, 0.0, 0.0]], earth).round(6)
    array([0.707107, 0.      , 0.      , 0.707107])
    """
    found = profile(sensor, earth, weights)
    return found.finished(*largest(found.davenport()))


def wahba_loss(quat: ArrayLike, sensor: ArrayLike, earth: ArrayLike, *, weights: ArrayLike | None = None) -> Floats:
    """Wahba's loss of an attitude: ½ Σ aᵢ |bᵢ - Rᵀ rᵢ|², with weights of the sum 1.

    Parameters
    ----------
    quat : array_like
        (..., 4) quaternions from sensor to earth, of any length but zero.
    sensor : array_like
        (..., n, 3) directions in the sensor frame, of any length, n ≥ 2.
    earth : array_like
        (..., n, 3) the same in the earth frame; leading axes broadcast.
    weights : array_like, optional
        (..., n) weights; equal ones by default.

    Returns
    -------
    ndarray
        (...,) from 0, where all directions fit, to 2. Pairs with a zero vector or a NaN are left out; NaN where none is
        left.

    Raises
    ------
    ValueError
        Arrays of another shape, infinite values, or negative weights.

    Notes
    -----
    Source: G. Wahba, "A least squares estimate of satellite attitude", SIAM Review 7(3), 1965. Half the squared angle
    between the directions, in rad², where that is small and all weights are equal.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> directions = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
    >>> ar.attitude.wahba_loss([1.0, 0.0, 0.0, 0.0], directions, directions)
    np.float64(0.0)
    """
    b, r, there, dtype = checked(sensor, earth)
    q = np.asarray(quat)
    if q.dtype.kind not in "fiu" or q.ndim < 1 or q.shape[-1] != 4:
        raise ValueError(f"quat: expected an array (..., 4) of real numbers, got {q.shape} of the dtype {q.dtype}")
    a = _arguments.shares("weights", weights, there)
    dtype = np.promote_types(dtype, q.dtype if q.dtype.kind == "f" else np.float64)
    q = q.astype(np.float64)
    norm = np.linalg.norm(q, axis=-1, keepdims=True)
    q = np.divide(q, norm, out=np.full_like(q, np.nan), where=norm > 0.0)
    misfit = np.sum((b - _quat.rotate(_quat.conjugate(q)[..., np.newaxis, :], r)) ** 2, axis=-1)
    loss = 0.5 * np.sum(np.where(a > 0.0, a * misfit, 0.0), axis=-1)
    return np.where(np.sum(a, axis=-1) > 0.0, loss, np.nan).astype(dtype)[()]


def wahba_covariance(sensor: ArrayLike, sigma: ArrayLike, *, weights: ArrayLike | None = None) -> Floats:
    """Covariance of the attitude that `svd`, `davenport`, `quest`, `flae` and `oleq` find.

    Parameters
    ----------
    sensor : array_like
        (..., n, 3) directions in the sensor frame, of any length, n ≥ 2.
    sigma : array_like
        (..., n) standard deviations of the directions, in rad: of the angle about each axis across the
        direction, measured and known side together.
    weights : array_like, optional
        (..., n) the weights that the attitude was found with; those of the smallest error, 1/σ², by default.

    Returns
    -------
    ndarray
        (..., 3, 3) covariance of the rotation vector of the error in the sensor frame, in rad². Pairs with a
        zero vector or a NaN are left out; NaN where the rest does not determine the attitude.

    Raises
    ------
    ValueError
        Arrays of another shape, infinite values, negative weights, or standard deviations that are not positive.

    Notes
    -----
    To first order in sigma. With the default weights it is (Σ (I - bᵢbᵢᵀ)/σᵢ²)⁻¹, the covariance of QUEST by M. D.
    Shuster and S. D. Oh (Journal of Guidance and Control 4(1), 1981). With others it is M⁻¹ (Σ aᵢ²σᵢ² (I - bᵢbᵢᵀ))
    M⁻¹ for M = Σ aᵢ (I - bᵢbᵢᵀ), which the condition of the smallest loss gives when it is differentiated.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> P = ar.attitude.wahba_covariance([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], [0.01, 0.02])
    >>> np.sqrt(np.diag(P)).round(5)
    array([0.00894, 0.01   , 0.02   ])
    """
    given = _arguments.vectors("sensor", sensor, rows=2)
    b, there = _arguments.units(given)
    s = _arguments.numbers("sigma", sigma, there.shape, positive=True)
    a = _arguments.shares("weights", s**-2.0 if weights is None else weights, there)
    across = np.eye(3) - b[..., :, np.newaxis] * b[..., np.newaxis, :]
    bread = np.einsum("...n,...nij->...ij", a, across)
    filling = np.einsum("...n,...nij->...ij", (a * s) ** 2, across)
    # The true directions on earth differ from these by a rotation, which changes no singular value.
    profile_here = np.einsum("...n,...ni,...nj->...ij", a, b, b)
    known = determined(room_of(np.linalg.svd(profile_here, compute_uv=False), np.ones(())), given.dtype)
    inverse = np.linalg.inv(np.where(known[..., np.newaxis, np.newaxis], bread, np.eye(3)))
    covariance = np.where(known[..., np.newaxis, np.newaxis], inverse @ filling @ inverse, np.nan)
    return (0.5 * (covariance + np.swapaxes(covariance, -1, -2))).astype(given.dtype)
