"""Relative orientations and angles of joints, with their uncertainty.

An attitude's error δ stands in the sensor frame: the true one is q ⊗ exp(δ). For r = q_first* ⊗ q_second the error in
the frame of the second sensor is then δ = δ_second - Rᵀ δ_first, R being the matrix of r.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _native, _quat, _validate
from ahrs_rs._estimate import Estimate
from ahrs_rs._typing import FloatArray
from ahrs_rs.chain._common import Attitudes, pair, quaternions, unit_vector
from ahrs_rs.chain._heading import HeadingCorrection
from ahrs_rs.chain._hinge import HingeAxis
from ahrs_rs.rotation import continuous, shortest_arc, swing_twist, unwrap

__all__ = ["JointAngle", "Relative", "joint_angle", "relative"]


@dataclass(frozen=True, slots=True, eq=False)
class Relative:
    """The orientation of the second sensor as the first one sees it.

    Parameters
    ----------
    quat : ndarray
        (..., T, 4) from the frame of the second sensor to that of the first; of continuous sign.
    covariance : ndarray, optional
        (..., T, 3, 3) of its error in the frame of the second sensor, rad²; None where it is not known.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> level = [[1.0, 0.0, 0.0, 0.0]] * 3
    >>> ar.chain.relative(level, level)
    Relative(quat(3, 4))
    """

    quat: FloatArray
    covariance: FloatArray | None = None

    def __repr__(self) -> str:
        known = "" if self.covariance is None else ", covariance"
        return f"Relative(quat{self.quat.shape}{known})"


@dataclass(frozen=True, slots=True, eq=False)
class JointAngle:
    """The angle of a hinge.

    Parameters
    ----------
    angle : ndarray
        (..., T) rad, without jumps; positive is a turn of the second segment against the first about the axis, by the
        right-hand rule.
    std : ndarray, optional
        (..., T) standard deviation, rad; None where no covariance is known.
    off_axis : ndarray
        (..., T) by how much the relative orientation is none of a hinge with this axis, rad.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> first, second = [[1.0, 0.0, 0.0, 0.0]] * 2, ar.rotation.about_axis("y", [0.1, 0.2])
    >>> ar.chain.joint_angle(ar.chain.relative(first, second), [0.0, 1.0, 0.0])
    JointAngle(angle(2,))
    """

    angle: FloatArray
    std: FloatArray | None
    off_axis: FloatArray = field(repr=False)

    def __repr__(self) -> str:
        return f"JointAngle(angle{self.angle.shape}{'' if self.std is None else ', std'})"


def relative(
    first: Attitudes,
    second: Attitudes,
    *,
    heading: HeadingCorrection | ArrayLike | None = None,
    covariances: tuple[ArrayLike, ArrayLike] | None = None,
) -> Relative:
    """The orientation of the second sensor as the first one sees it: q_first* ⊗ q_second.

    Parameters
    ----------
    first : Estimate or array_like
        Of the first sensor, or its attitudes (..., T, 4).
    second : Estimate or array_like
        Of the second sensor, at the same times.
    heading : HeadingCorrection or array_like, optional
        What `correct_heading` has found, or turns of the second about the vertical (...,), rad. The uncertainty of the
        two headings is then that of the correction, not that of the filters.
    covariances : tuple of array_like, optional
        (..., T, 3, 3) of the errors of both in their sensor frames, rad². By default those of the estimates, where
        both have them (``outputs=["covariance"]``).

    Returns
    -------
    Relative
        With a covariance where both are known. The errors of the two sensors are taken to be independent.

    Raises
    ------
    ValueError
        Shapes, times or frames that differ.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> est = ar.MEKF(rate=100.0).run(rec, outputs=["covariance"])
    >>> ar.chain.relative(est, est)
    Relative(quat(500, 4), covariance)
    """
    p, q = pair(first, second)
    turn, turn_std = _heading(heading, q.shape[:-1])
    if turn is not None:
        q = _quat.multiply(_quat.about_axis(2, turn), q)
    if covariances is None and isinstance(first, Estimate) and isinstance(second, Estimate):
        own = first.covariance, second.covariance
        covariances = None if own[0] is None or own[1] is None else (own[0], own[1])
    if covariances is not None and (not isinstance(covariances, (tuple, list)) or len(covariances) != 2):
        raise ValueError(f"covariances: expected a pair, of the first and the second sensor, got {covariances!r}")
    r = _quat.multiply(_quat.conjugate(p), q)
    covariance = None
    if covariances is not None:
        a, b = (
            _covariance(name, each, p.shape[:-1]) for name, each in zip(("first", "second"), covariances, strict=True)
        )
        if turn is not None:
            # Of both headings the difference alone counts, and it is that of the correction.
            a, b = _without_heading(a, p), _without_heading(b, q)
        back = np.swapaxes(_native.rotation_matrices(r), -1, -2)
        covariance = b + back @ a @ np.swapaxes(back, -1, -2)
        if turn_std is not None:
            up = _vertical(q)
            covariance = covariance + turn_std[..., np.newaxis, np.newaxis] ** 2 * _outer(up)
    if r.ndim > 1:
        r = np.asarray(continuous(r), dtype=np.float64)
    return Relative(r, covariance)


def joint_angle(
    relative: Relative | ArrayLike,
    axis: ArrayLike | HingeAxis,
    second_axis: ArrayLike | None = None,
    *,
    zero: ArrayLike | None = None,
) -> JointAngle:
    """The angle of a hinge: the twist of the relative orientation about the axis.

    Parameters
    ----------
    relative : Relative or array_like
        What `relative` has given, or quaternions (..., T, 4) from the second frame to the first.
    axis : array_like or HingeAxis
        (3,) the axis in the frame of the first sensor; what `hinge_axis` has found stands for both.
    second_axis : array_like, optional
        (3,) the same axis in the frame of the second sensor; by default the same vector, as of sensors that are aligned
        with their segments.
    zero : array_like, optional
        (4,) the relative orientation at which the angle is 0, such as the mean of a still pose. By default the shortest
        rotation that takes the axes together, so that the angle has a constant offset that depends on how the sensors
        are mounted.

    Returns
    -------
    JointAngle
        With a standard deviation where `relative` has a covariance. It is that of the attitudes: an error of the axis
        is in it only as far as it shows in `off_axis`.

    Raises
    ------
    ValueError
        Another shape, or a vector that is zero.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> thigh, bend = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1)), np.array([0.0, 0.5, 1.0])
    >>> shank = ar.rotation.about_axis("y", bend)
    >>> ar.chain.joint_angle(ar.chain.relative(thigh, shank), [0.0, 1.0, 0.0]).angle.round(6)
    array([0. , 0.5, 1. ])
    """
    given = relative if isinstance(relative, Relative) else Relative(quaternions("relative", relative))
    one, other = _axes(axis, second_axis)
    aligned = quaternions("zero", shortest_arc(other, one) if zero is None else zero)
    if aligned.shape != (4,):
        raise ValueError(f"zero: expected shape (4,), got {aligned.shape}")
    turn = _quat.multiply(given.quat, _quat.conjugate(aligned))
    swing, _, angle = swing_twist(turn, one)
    off_axis = 2.0 * np.arctan2(np.linalg.norm(swing[..., 1:], axis=-1), np.abs(swing[..., 0]))
    std = None
    if given.covariance is not None:
        # angle = 2 atan2(v·a, w); of a small turn δ on the right dw = -½ v·δ and dv = ½ (w δ + v × δ), so that the
        # gradient is (w (w a + a × v) + (v·a) v) / (w² + (v·a)²).
        w, v = turn[..., :1], turn[..., 1:]
        along = np.sum(v * one, axis=-1, keepdims=True)
        gradient = (w * (w * one + np.cross(one, v)) + along * v) / (w * w + along * along)
        # δ of the second sensor frame, turned by what takes that frame to the first at angle 0.
        gradient = _quat.rotate(_quat.conjugate(aligned), gradient)
        std = np.sqrt(np.einsum("...i,...ij,...j->...", gradient, given.covariance, gradient))
    smooth = np.asarray(unwrap(angle) if angle.ndim else angle, dtype=np.float64)
    return JointAngle(smooth, std, np.asarray(off_axis, dtype=np.float64))


def _axes(first: ArrayLike | HingeAxis, second: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
    if isinstance(first, HingeAxis):
        return first.first, first.second
    one = unit_vector("axis", first)
    return one, one if second is None else unit_vector("second_axis", second)


def _heading(
    given: HeadingCorrection | ArrayLike | None, shape: tuple[int, ...]
) -> tuple[FloatArray | None, FloatArray | None]:
    if given is None:
        return None, None
    std: FloatArray | None = None
    if isinstance(given, HeadingCorrection):
        correction: HeadingCorrection = given
        given, std = correction.delta, correction.std
    turn = _validate.reals("heading", given).astype(np.float64, copy=False)
    try:
        return np.broadcast_to(turn, shape), std
    except ValueError:
        raise ValueError(f"heading: expected shape {shape}, got {turn.shape}") from None


def _covariance(name: str, given: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    matrix = _validate.rows(name, given, 3, 3).astype(np.float64, copy=False)
    if matrix.shape != (*shape, 3, 3):
        raise ValueError(f"covariances: expected shape {(*shape, 3, 3)} of the {name} one, got {matrix.shape}")
    return matrix


def _vertical(quat: FloatArray) -> FloatArray:
    """The vertical in the sensor frame."""
    return _quat.rotate(_quat.conjugate(quat), np.array([0.0, 0.0, 1.0]))


def _without_heading(covariance: FloatArray, quat: FloatArray) -> FloatArray:
    """The covariance of the inclination alone."""
    level = np.eye(3) - _outer(_vertical(quat))
    return level @ covariance @ level


def _outer(vector: FloatArray) -> FloatArray:
    return vector[..., :, np.newaxis] * vector[..., np.newaxis, :]
