"""Errors of orientation estimates against a reference."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _native, _quat
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import unit_quaternions
from ahrs_rs.metrics._statistics import checked_mask, rmse

__all__ = [
    "Score",
    "StaticDynamic",
    "chordal_distance",
    "error_angles",
    "error_quat",
    "euler",
    "euler_error",
    "geodesic_distance",
    "heading_error",
    "inclination_error",
    "inner_product_distance",
    "score",
    "static_dynamic",
    "total_error",
]


@dataclass(frozen=True, slots=True)
class Score:
    """Root-mean-square errors: numbers for one recording, arrays (N,) for N recordings of equal length.

    Parameters
    ----------
    total : float or ndarray
        Of the whole rotation.
    heading : float or ndarray
        Of its part about the vertical.
    inclination : float or ndarray
        Of the angle between the verticals.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = [[1.0, 0.0, 0.0, 0.0]]
    >>> ar.metrics.score(q, q).total
    0.0
    """

    total: float | FloatArray
    heading: float | FloatArray
    inclination: float | FloatArray


def error_quat(est: ArrayLike, ref: ArrayLike) -> FloatArray:
    """Orientation error in the earth frame, est ⊗ conj(ref), (..., 4).

    Parameters
    ----------
    est : array_like
        (..., 4) estimated quaternions, scalar-first.
    ref : array_like
        (..., 4) true quaternions, in the same earth frame.

    Returns
    -------
    ndarray
        (..., 4).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.error_quat(turned, level).round(6) + 0.0
    array([0.995004, 0.      , 0.      , 0.099833])
    """
    p, q = _pair(est, ref)
    return _quat.multiply(p, _quat.conjugate(q))


def total_error(est: ArrayLike, ref: ArrayLike, *, degrees: bool = False) -> FloatArray:
    """Angle of the rotation between estimate and reference, 0 to π (BROAD: 2 acos|w|).

    Parameters
    ----------
    est : array_like
        (..., 4) estimated quaternions, scalar-first.
    ref : array_like
        (..., 4) true quaternions, in the same earth frame.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (...,).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.total_error(turned, level).round(6) + 0.0
    np.float64(0.2)
    """
    return _angle(_total(error_quat(est, ref)), degrees)


def heading_error(est: ArrayLike, ref: ArrayLike, *, degrees: bool = False) -> FloatArray:
    """Part of the error about the vertical, 0 to π (BROAD: 2 atan|z/w|).

    Where the inclination error is π, the heading has no meaning, and 0 is returned.

    Parameters
    ----------
    est : array_like
        (..., 4) estimated quaternions, scalar-first.
    ref : array_like
        (..., 4) true quaternions, in the same earth frame.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (...,).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.heading_error(turned, level).round(6) + 0.0
    np.float64(0.2)
    """
    return _angle(_heading(error_quat(est, ref)), degrees)


def inclination_error(est: ArrayLike, ref: ArrayLike, *, degrees: bool = False) -> FloatArray:
    """Angle between the true vertical and the estimated one, 0 to π (BROAD: 2 acos √(w² + z²)).

    Parameters
    ----------
    est : array_like
        (..., 4) estimated quaternions, scalar-first.
    ref : array_like
        (..., 4) true quaternions, in the same earth frame.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (...,).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.inclination_error(turned, level).round(6) + 0.0
    np.float64(0.0)
    """
    return _angle(_inclination(error_quat(est, ref)), degrees)


def score(est_quat: ArrayLike, ref: ArrayLike, mask: ArrayLike | None = None, *, degrees: bool = True) -> Score:
    """Root-mean-square total, heading and inclination errors, as BROAD defines them.

    Parameters
    ----------
    est_quat, ref : array_like
        (..., T, 4).
    mask : array_like, optional
        Bool (..., T), the samples that count; None takes all of them.
    degrees : bool, optional
        The unit of the result; rad if False.

    Returns
    -------
    Score
        Total, heading and inclination.

    Notes
    -----
    Samples with a NaN in the estimate or in the reference do not count.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = [[1.0, 0.0, 0.0, 0.0]]
    >>> ar.metrics.score(q, q)
    Score(total=0.0, heading=0.0, inclination=0.0)
    """
    error = error_quat(est_quat, ref)
    if error.ndim < 2:
        raise ValueError(f"est_quat: expected shape (..., T, 4), got {error.shape}")
    return Score(
        total=rmse(_angle(_total(error), degrees), mask),
        heading=rmse(_angle(_heading(error), degrees), mask),
        inclination=rmse(_angle(_inclination(error), degrees), mask),
    )


def geodesic_distance(p: ArrayLike, q: ArrayLike) -> FloatArray:
    """Angle of the rotation from p to q, rad, 0 to π: Huynh's Φ6 (twice Φ3). The same as `total_error`.

    Parameters
    ----------
    p : array_like
        (..., 4) quaternions.
    q : array_like
        (..., 4) quaternions.

    Returns
    -------
    ndarray
        (...,) rad.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.geodesic_distance(turned, level).round(6) + 0.0
    np.float64(0.2)
    """
    return total_error(p, q)


def chordal_distance(p: ArrayLike, q: ArrayLike) -> FloatArray:
    """min(|p - q|, |p + q|), 0 to √2: Huynh's Φ2.

    Parameters
    ----------
    p : array_like
        (..., 4) quaternions.
    q : array_like
        (..., 4) quaternions.

    Returns
    -------
    ndarray
        (...,) 0 to √2.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.chordal_distance(turned, level).round(6) + 0.0
    np.float64(0.099958)
    """
    a, b = _pair(p, q)
    distance: FloatArray = np.minimum(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
    return distance


def inner_product_distance(p: ArrayLike, q: ArrayLike) -> FloatArray:
    """1 - |p·q|, 0 to 1: Huynh's Φ4, computed as Φ2²/2, which does not cancel where p and q are close.

    Parameters
    ----------
    p : array_like
        (..., 4) quaternions.
    q : array_like
        (..., 4) quaternions.

    Returns
    -------
    ndarray
        (...,) 0 to 1.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.inner_product_distance(turned, level).round(6) + 0.0
    np.float64(0.004996)
    """
    return 0.5 * chordal_distance(p, q) ** 2


def euler(quat: ArrayLike, *, degrees: bool = False) -> FloatArray:
    """Roll, pitch and yaw (..., 3) of the intrinsic Z-Y'-X'' sequence, in that order.

    The order is the reverse of scipy's "ZYX".
    Roll and yaw are in [-π, π], pitch in [-π/2, π/2]. Where the x axis is vertical only one combination of
    roll and yaw is defined: roll is then 0 and yaw takes the whole turn.

    Parameters
    ----------
    quat : array_like
        (..., 4) quaternions, scalar-first.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 3).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.euler(turned).round(6) + 0.0
    array([0. , 0. , 0.2])
    """
    angles: FloatArray = _native.euler_angles(_unit("quat", quat)).astype(np.float64, copy=False)
    return _angle(angles, degrees)


def euler_error(est: ArrayLike, ref: ArrayLike, *, degrees: bool = False, convention: str = "wrapped") -> FloatArray:
    """Differences of roll, pitch and yaw (..., 3), estimate minus reference.

    Parameters
    ----------
    est, ref : array_like
        (..., 4).
    degrees : bool, optional
        Degrees in place of radians.
    convention : str, optional
        ``"wrapped"`` to (-π, π]; or ``"absolute"``, |estimate| - |reference|, by which Ludwig &
        Burnham (ICUAS 2018, section IV.B) keep the jump from 180° to -180° out of their errors. It
        takes an angle of the wrong sign for a right one.

    Returns
    -------
    ndarray
        (..., 3).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.euler_error(turned, level).round(6) + 0.0
    array([0. , 0. , 0.2])
    """
    if convention not in ("wrapped", "absolute"):
        raise ValueError(f"convention: expected 'wrapped' or 'absolute', got {convention!r}")
    p, q = _pair(est, ref)
    if convention == "absolute":
        return _angle(np.abs(euler(p)) - np.abs(euler(q)), degrees)
    return _angle(_wrap(euler(p) - euler(q)), degrees)


def error_angles(est: ArrayLike, ref: ArrayLike, *, degrees: bool = False) -> FloatArray:
    """Roll, pitch and yaw (..., 3) of the error conj(est) ⊗ ref, which stands in the sensor frame.

    Cirillo et al. (IFAC 2014, section 5) report these in place of differences of Euler angles: a small error has
    small angles at every attitude.

    Parameters
    ----------
    est : array_like
        (..., 4) estimated quaternions, scalar-first.
    ref : array_like
        (..., 4) true quaternions, in the same earth frame.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 3).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> level, turned = [1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]
    >>> ar.metrics.error_angles(turned, level).round(6) + 0.0
    array([ 0. ,  0. , -0.2])
    """
    p, q = _pair(est, ref)
    return euler(_quat.multiply(_quat.conjugate(p), q), degrees=degrees)


@dataclass(frozen=True, slots=True)
class StaticDynamic:
    """Root-mean-square errors at rest and in motion.

    Parameters
    ----------
    static : ndarray
        (..., 3) of roll, pitch and yaw; NaN where there is no rest.
    dynamic : ndarray
        (..., 3).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = [[1.0, 0.0, 0.0, 0.0]] * 4
    >>> ar.metrics.static_dynamic(q, q, [True, True, False, False]).static
    array([0., 0., 0.])
    """

    static: FloatArray
    dynamic: FloatArray


def static_dynamic(
    est: ArrayLike, ref: ArrayLike, moving: ArrayLike, mask: ArrayLike | None = None, *, degrees: bool = True
) -> StaticDynamic:
    """Root-mean-square `error_angles` at rest and in motion (Cirillo et al., Table 1).

    Parameters
    ----------
    est, ref : array_like
        (..., T, 4).
    moving : array_like
        Bool (..., T), where the sensor moves; it rests elsewhere.
    mask : array_like, optional
        Bool (..., T), the samples that count; None takes all of them.
    degrees : bool, optional
        The unit of the result; rad if False.

    Returns
    -------
    StaticDynamic
        (3,) each.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = [[1.0, 0.0, 0.0, 0.0]] * 4
    >>> ar.metrics.static_dynamic(q, q, [True, True, False, False]).dynamic
    array([0., 0., 0.])
    """
    error = error_angles(est, ref, degrees=degrees)
    if error.ndim < 2:
        raise ValueError(f"est: expected shape (..., T, 4), got {(*error.shape[:-1], 4)}")
    motion = checked_mask("moving", moving, error.shape[:-1])
    counted = np.ones_like(motion) if mask is None else checked_mask("mask", mask, motion.shape)

    def over(samples: NDArray[np.bool_]) -> FloatArray:
        return np.stack([rmse(error[..., axis], samples) for axis in range(3)], axis=-1)

    return StaticDynamic(over(counted & ~motion), over(counted & motion))


def _total(error: FloatArray) -> FloatArray:
    w, x, y, z = _components(error)
    return 2.0 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(w))


def _heading(error: FloatArray) -> FloatArray:
    w, _, _, z = _components(error)
    return 2.0 * np.arctan2(np.abs(z), np.abs(w))


def _inclination(error: FloatArray) -> FloatArray:
    w, x, y, z = _components(error)
    return 2.0 * np.arctan2(np.hypot(x, y), np.hypot(w, z))


def _unit(name: str, value: ArrayLike) -> FloatArray:
    """Unit quaternions (..., 4) as float64; rows with NaN become NaN as a whole."""
    return unit_quaternions(name, np.asarray(value, dtype=np.float64))


def _pair(est: ArrayLike, ref: ArrayLike) -> tuple[FloatArray, FloatArray]:
    p, q = _unit("estimate", est), _unit("reference", ref)
    # Leading axes may be absent on one side; an axis of length 1 is not stretched, as it may be a mistake.
    ndim = min(p.ndim, q.ndim)
    if p.shape[-ndim:] != q.shape[-ndim:]:
        raise ValueError(f"reference: expected the shape of the estimate, {p.shape}, got {q.shape}")
    return p, q


def _components(quat: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    return quat[..., 0], quat[..., 1], quat[..., 2], quat[..., 3]


def _wrap(angle: FloatArray) -> FloatArray:
    """The same angles in (-π, π]."""
    wrapped: FloatArray = angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))
    # Rounding can leave half a turn just outside of the interval.
    return np.where(np.abs(wrapped) >= np.pi, np.pi, wrapped)


def _angle(radians: FloatArray, degrees: bool) -> FloatArray:
    return np.degrees(radians) if degrees else radians
