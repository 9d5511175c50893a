"""Joints of one, two and three degrees of freedom: by how much a heading contradicts them.

The headings of two estimates differ by δ: the attitude of the second sensor in the earth frame of the first is
Rz(δ) ⊗ q_second. Each joint says for every δ how far the relative attitude is from one that the joint can have.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import FloatArray
from ahrs_rs.chain._common import unit_vector
from ahrs_rs.chain._hinge import HingeAxis
from ahrs_rs.rotation import to_euler

__all__ = ["Ball", "Hinge", "Joint", "Universal"]

#: Samples of a window and headings for which the angles of a ball joint are computed; others are interpolated.
BALL_SAMPLES, BALL_HEADINGS = 10, 240
#: Axes of a universal joint that are nearly parallel turn about nearly one axis.
LEAST_ANGLE = math.radians(20.0)


class Joint(Protocol):
    """What the heading is corrected by; a class of your own may have this method too.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> joint: ar.chain.Joint = ar.chain.Hinge([0.0, 1.0, 0.0], [0.0, 1.0, 0.0])
    """

    def square_error(self, first: FloatArray, second: FloatArray, heading: FloatArray) -> FloatArray:
        """The mean square of the angles by which attitudes contradict the joint.

        Parameters
        ----------
        first : ndarray
            (n, 4) attitudes of the first sensor.
        second : ndarray
            (n, 4) attitudes of the second sensor.
        heading : ndarray
            (m,) turns of the second about the vertical, rad.

        Returns
        -------
        ndarray
            (m,) rad².
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Hinge:
    """A joint of one degree of freedom, such as a knee or a finger: both segments have the axis in common.

    Parameters
    ----------
    first : array_like or HingeAxis
        (3,) the axis in the frame of the first sensor; what `hinge_axis` has found stands for both.
    second : array_like, optional
        (3,) the same axis in the frame of the second sensor.

    Raises
    ------
    ValueError
        A vector that is none, or zero.

    Notes
    -----
    Rz(δ) takes the axis as the second sensor has it to where the first one has it, which only its horizontal part
    shows: D. Laidig, T. Schauer and T. Seel, "Exploiting kinematic constraints to compensate magnetic disturbances when
    calculating joint angles of approximate hinge joints from orientation estimates of inertial sensors", ICORR 2017.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> knee = ar.chain.Hinge([0.0, 1.0, 0.0], [0.0, 1.0, 0.0])
    >>> level = np.array([[1.0, 0.0, 0.0, 0.0]])
    >>> knee.square_error(level, level, np.array([0.0, 0.1])).round(6)
    array([0.      , 0.009992])
    """

    first: ArrayLike | HingeAxis
    second: ArrayLike | None = None

    def __post_init__(self) -> None:
        first, second = self.first, self.second
        if isinstance(first, HingeAxis):
            found: HingeAxis = first
            first, second = found.first, found.second
        if second is None:
            raise ValueError("second: expected the axis in the frame of the second sensor, got None")
        object.__setattr__(self, "first", unit_vector("first", first))
        object.__setattr__(self, "second", unit_vector("second", second))

    def square_error(self, first: FloatArray, second: FloatArray, heading: FloatArray) -> FloatArray:
        """The mean square of the distance between the axes, which is the angle between them where it is small.

        Parameters
        ----------
        first : ndarray
            (n, 4) attitudes of the first sensor.
        second : ndarray
            (n, 4) attitudes of the second sensor.
        heading : ndarray
            (m,) turns of the second about the vertical, rad.

        Returns
        -------
        ndarray
            (m,) rad².
        """
        a, b = _quat.rotate(first, np.asarray(self.first)), _quat.rotate(second, np.asarray(self.second))
        cosine, sine, level = _dot_terms(a, b)
        # |a - Rz(δ) b|² = 2 - 2 a·Rz(δ) b
        mean = 2.0 - 2.0 * (np.mean(cosine) * np.cos(heading) + np.mean(sine) * np.sin(heading) + np.mean(level))
        square: FloatArray = np.maximum(mean, 0.0)
        return square


@dataclass(frozen=True, slots=True, eq=False)
class Universal:
    """A joint of two degrees of freedom: two axes, one fixed in each segment, at a constant angle to each other.

    Parameters
    ----------
    first : array_like
        (3,) the axis that is fixed in the first segment, in the frame of the first sensor.
    second : array_like
        (3,) the axis that is fixed in the second segment, in the frame of the second sensor.
    angle : float, optional
        Rad between the axes: a right angle of a saddle or universal joint; elbows have a carrying angle besides.

    Raises
    ------
    ValueError
        A vector that is none, or zero; axes that are nearly parallel.

    Notes
    -----
    D. Laidig, D. Lehmann, M.-A. Bégin and T. Seel, "Magnetometer-free realtime inertial motion tracking by
    exploitation of kinematic constraints in 2-DoF joints", EMBC 2019: the constraint by the orientations. One attitude
    fits two headings; movement about both axes tells which one holds.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> elbow = ar.chain.Universal([0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    >>> level = np.array([[1.0, 0.0, 0.0, 0.0]])
    >>> elbow.square_error(level, level, np.array([0.0, 0.1])).round(6)
    array([0.      , 0.009967])
    """

    first: ArrayLike
    second: ArrayLike
    angle: float = 0.5 * math.pi

    def __post_init__(self) -> None:
        object.__setattr__(self, "first", unit_vector("first", self.first))
        object.__setattr__(self, "second", unit_vector("second", self.second))
        if not LEAST_ANGLE <= _validate.number("angle", self.angle) <= math.pi - LEAST_ANGLE:
            raise ValueError(
                f"angle: expected one of {LEAST_ANGLE:.2g} to π - {LEAST_ANGLE:.2g} rad, got {self.angle!r}"
            )

    def square_error(self, first: FloatArray, second: FloatArray, heading: FloatArray) -> FloatArray:
        """The mean square of the error of the angle between the axes, to first order: of its cosine over its sine.

        Parameters
        ----------
        first : ndarray
            (n, 4) attitudes of the first sensor.
        second : ndarray
            (n, 4) attitudes of the second sensor.
        heading : ndarray
            (m,) turns of the second about the vertical, rad.

        Returns
        -------
        ndarray
            (m,) rad².
        """
        a, b = _quat.rotate(first, np.asarray(self.first)), _quat.rotate(second, np.asarray(self.second))
        cosine, sine, level = _dot_terms(a, b)
        # (c cos δ + s sin δ + l)², whose means are of six products
        terms = np.stack([cosine, sine, level - math.cos(self.angle)])
        means = terms @ terms.T / len(a)
        waves = np.stack([np.cos(heading), np.sin(heading), np.ones_like(heading)])
        square: FloatArray = np.maximum(np.sum(waves * (means @ waves), axis=0), 0.0) / math.sin(self.angle) ** 2
        return square


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """A joint of three degrees of freedom whose angles have limits, such as a hip.

    Parameters
    ----------
    limits : array_like
        (3, 2) least and largest angle, rad, in the order of the sequence.
    sequence : str, optional
        Of the angles, as `rotation.to_euler` takes it; they turn from the frame of the second segment to that of the
        first.
    first : array_like, optional
        (4,) alignment of the first sensor, from its frame to its segment's (`SegmentAlignment.quat`).
    second : array_like, optional
        (4,) alignment of the second sensor.

    Raises
    ------
    ValueError
        Limits that are none, or another sequence.

    Notes
    -----
    D. Lehmann, D. Laidig, R. Deimel and T. Seel, "Magnetometer-free inertial motion tracking of arbitrary joints with
    range of motion constraints", IFAC World Congress 2020. What the limits leave open stays open: the uncertainty of
    the heading says how much.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> hip = ar.chain.Ball(np.radians([[-30.0, 30.0], [-20.0, 20.0], [-40.0, 120.0]]), "ZXY")
    >>> level = np.array([[1.0, 0.0, 0.0, 0.0]])
    >>> np.sqrt(np.degrees(np.degrees(hip.square_error(level, level, np.radians([20.0, 35.0]))))).round(6)
    array([0., 5.])
    """

    limits: ArrayLike
    sequence: str = "ZXY"
    first: ArrayLike = (1.0, 0.0, 0.0, 0.0)
    second: ArrayLike = (1.0, 0.0, 0.0, 0.0)
    _back: tuple[FloatArray, FloatArray] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        limits = _validate.rows("limits", self.limits, 3, 2).astype(np.float64, copy=False)
        if limits.ndim != 2 or not (limits[:, 0] <= limits[:, 1]).all():
            raise ValueError(f"limits: expected (3, 2) least and largest angles in rad, got {limits.tolist()}")
        object.__setattr__(self, "limits", limits)
        both = tuple(_validate.unit_quaternions(name, getattr(self, name)) for name in ("first", "second"))
        for name, one in zip(("first", "second"), both, strict=True):
            if one.shape != (4,) or np.isnan(one).any():
                raise ValueError(f"{name}: expected a quaternion (4,), got shape {one.shape}, {one.tolist()}")
        object.__setattr__(self, "_back", tuple(_quat.conjugate(each.astype(np.float64)) for each in both))
        to_euler((1.0, 0.0, 0.0, 0.0), self.sequence)  # says what is wrong with another one

    def square_error(self, first: FloatArray, second: FloatArray, heading: FloatArray) -> FloatArray:
        """The mean square of what the angles are beyond their limits; of three of them the sum.

        Parameters
        ----------
        first : ndarray
            (n, 4) attitudes of the first sensor.
        second : ndarray
            (n, 4) attitudes of the second sensor.
        heading : ndarray
            (m,) turns of the second about the vertical, rad.

        Returns
        -------
        ndarray
            (m,) rad².
        """
        if len(heading) > BALL_HEADINGS:
            coarse = np.linspace(-math.pi, math.pi, BALL_HEADINGS + 1)
            return np.interp(
                (heading + math.pi) % (2.0 * math.pi) - math.pi, coarse, self._square_error(first, second, coarse)
            )
        return self._square_error(first, second, heading)

    def _square_error(self, first: FloatArray, second: FloatArray, heading: FloatArray) -> FloatArray:
        some = np.unique(np.linspace(0, len(first) - 1, min(len(first), BALL_SAMPLES)).round().astype(np.intp))
        p = _quat.multiply(first[some], self._back[0])
        q = _quat.multiply(second[some], self._back[1])
        turned = _quat.multiply(_quat.about_axis(2, heading)[:, np.newaxis], q)
        angles = to_euler(_quat.multiply(_quat.conjugate(p), turned), self.sequence)
        limits = np.asarray(self.limits)
        middle, half = limits.mean(axis=1), 0.5 * (limits[:, 1] - limits[:, 0])
        # By the shorter way round to the nearer limit.
        away = np.abs((angles - middle + np.pi) % (2.0 * np.pi) - np.pi)
        beyond = np.maximum(away - half, 0.0)
        square: FloatArray = np.mean(np.sum(beyond**2, axis=-1), axis=-1)
        return square


def _dot_terms(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """a·Rz(δ) b = cosine cos δ + sine sin δ + level."""
    cosine = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]
    sine = a[:, 1] * b[:, 0] - a[:, 0] * b[:, 1]
    return cosine, sine, a[:, 2] * b[:, 2]
