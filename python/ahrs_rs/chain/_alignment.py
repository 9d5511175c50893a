"""Sensor-to-segment alignment: how a sensor is mounted, by a pose and by a functional motion."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.chain._common import Attitudes, quaternions, unit_vector
from ahrs_rs.rotation import mean

__all__ = ["FunctionalAxis", "SegmentAlignment", "align_by_motion", "align_by_pose", "functional_axis"]

#: Share of the angular rate about the axis, below which a motion has none: what a turn about a cone of 30° has.
LEAST_SHARE = 0.75
#: Axis and vertical have to be apart by this angle, rad, to give a rotation.
LEAST_ANGLE = math.radians(10.0)


@dataclass(frozen=True, slots=True, eq=False)
class SegmentAlignment:
    """The rotation from a sensor's frame to that of its segment.

    Parameters
    ----------
    quat : ndarray
        (4,) ``v_segment = rotate(quat, v_sensor)``.
    error : float
        How far what was measured is from what was expected, rad: the RMS about the mean of a pose; by a motion, the
        difference of the measured and the expected angle between axis and vertical.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> mounted = ar.chain.align_by_pose([[0.6, 0.0, 0.8, 0.0]] * 3)
    >>> mounted.segment([0.6, 0.0, 0.8, 0.0]).round(6) + 0.0
    array([1., 0., 0., 0.])
    """

    quat: FloatArray
    error: float

    def segment(self, quat: Attitudes) -> FloatArray:
        """Attitudes of the segment from those of its sensor.

        Parameters
        ----------
        quat : Estimate or array_like
            (..., 4) attitudes of the sensor.

        Returns
        -------
        ndarray
            (..., 4) attitudes of the segment.
        """
        return _quat.multiply(quaternions("quat", quat), _quat.conjugate(self.quat))


@dataclass(frozen=True, slots=True, eq=False)
class FunctionalAxis:
    """The axis about which a sensor has turned.

    Parameters
    ----------
    axis : ndarray
        (3,) unit vector in the sensor frame; the first large turn was positive.
    share : float
        Of the mean square of the angular rate how much is about it: 1 of a turn about a fixed axis.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> swing = np.sin(np.arange(100) * 0.1)[:, np.newaxis] * [0.0, 0.6, 0.8]
    >>> ar.chain.functional_axis(swing).axis.round(6) + 0.0
    array([0. , 0.6, 0.8])
    """

    axis: FloatArray
    share: float


def align_by_pose(
    quat: Attitudes, pose: ArrayLike = (1.0, 0.0, 0.0, 0.0), *, largest_error: float = math.radians(5.0)
) -> SegmentAlignment:
    """The alignment from a pose that is known: standing upright, a robot's zero position.

    Parameters
    ----------
    quat : Estimate or array_like
        (T, 4) attitudes of the sensor while the pose is held; rows with a NaN are left out.
    pose : array_like, optional
        (4,) or (T, 4) attitude of the segment, in the same earth frame. Without a magnetometer the heading of the
        estimate is free: a wrong one turns the alignment about the vertical (`align_by_motion` needs none).
    largest_error : float, optional
        Rad (RMS) by which the pose may be left.

    Returns
    -------
    SegmentAlignment
        The mean of pose* ⊗ quat.

    Raises
    ------
    ValueError
        Another shape, or a sensor that moves against the pose.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> upright = ar.rotation.about_axis("z", [29.0, 31.0], degrees=True)
    >>> ar.rotation.to_rotvec(ar.chain.align_by_pose(upright).quat, degrees=True).round(6) + 0.0
    array([ 0.,  0., 30.])
    """
    sensor, segment = quaternions("quat", quat), quaternions("pose", pose)
    if sensor.ndim != 2:
        raise ValueError(f"quat: expected shape (T, 4), got {sensor.shape}")
    if segment.shape not in ((4,), sensor.shape):
        raise ValueError(f"pose: expected shape (4,) or {sensor.shape}, got {segment.shape}")
    each = _quat.multiply(_quat.conjugate(segment), sensor)
    each = each[~np.isnan(each[:, 0])]
    if not len(each):
        raise ValueError("quat: expected at least one row without NaN, got none")
    middle = np.asarray(mean(each), dtype=np.float64)
    apart = np.linalg.norm(_quat.log(_quat.multiply(_quat.conjugate(middle), each)), axis=1)
    error = float(np.sqrt(np.mean(apart**2)))
    if error > positive("largest_error", largest_error):
        raise ValueError(
            f"quat: expected a pose that is held within {math.degrees(largest_error):.3g}° (RMS), got "
            f"{math.degrees(error):.3g}°: choose a part of the recording in which nothing moves"
        )
    return SegmentAlignment(middle, error)


def align_by_motion(gyr: ArrayLike, axis: ArrayLike, acc: ArrayLike, up: ArrayLike) -> SegmentAlignment:
    """The alignment from a functional motion about an axis that is known, and a rest in a pose that is.

    The axis is kept exactly; the vertical of the rest says how the sensor is turned about it. No heading is needed.

    Parameters
    ----------
    gyr : array_like
        (T, 3) of the motion, rad/s, such as some swings of a knee; the first large turn is positive.
    axis : array_like
        (3,) its axis in the frame of the segment.
    acc : array_like
        (n, 3) of a rest, m/s².
    up : array_like
        (3,) the direction in the frame of the segment that points upward in that rest.

    Returns
    -------
    SegmentAlignment
        Its `error` says by how much the angle between axis and vertical differs from the expected one.

    Raises
    ------
    ValueError
        Another shape, a motion about no axis, or an axis that is nearly vertical.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> swing = np.sin(np.arange(100) * 0.1)[:, np.newaxis] * [1.0, 0.0, 0.0]
    >>> mounted = ar.chain.align_by_motion(swing, [0.0, 1.0, 0.0], [[0.0, 0.0, 9.81]], [0.0, 0.0, 1.0])
    >>> ar.rotation.to_rotvec(mounted.quat, degrees=True).round(6) + 0.0
    array([ 0.,  0., 90.])
    """
    turned = functional_axis(gyr).axis
    force = _validate.rows("acc", acc, 3).astype(np.float64, copy=False).reshape(-1, 3)
    force = force[~np.isnan(force).any(axis=1)]
    if not len(force):
        raise ValueError("acc: expected at least one row without NaN, got none")
    upward = unit_vector("acc", force.mean(axis=0))
    wanted_axis, wanted_up = unit_vector("axis", axis), unit_vector("up", up)
    measured, expected = _angle(turned, upward), _angle(wanted_axis, wanted_up)
    for name, angle in (("acc", measured), ("up", expected)):
        if not LEAST_ANGLE <= angle <= math.pi - LEAST_ANGLE:
            raise ValueError(
                f"{name}: expected a vertical that is at least {math.degrees(LEAST_ANGLE):.0f}° from the axis, got "
                f"{math.degrees(angle):.3g}°: it does not say how the sensor is turned about it"
            )
    # TRIAD: both frames have the axis, what is perpendicular to axis and vertical, and the third.
    quat = _quat.of_matrix(_frame(wanted_axis, wanted_up) @ _frame(turned, upward).T)
    return SegmentAlignment(quat, abs(measured - expected))


def functional_axis(gyr: ArrayLike) -> FunctionalAxis:
    """The axis about which a sensor turns: the direction with the largest mean square of the angular rate.

    Parameters
    ----------
    gyr : array_like
        (T, 3) rad/s, without a bias that counts beside the motion; rows with a NaN are left out.

    Returns
    -------
    FunctionalAxis
        Axis and share of the motion about it.

    Raises
    ------
    ValueError
        Another shape, no motion, or one about no axis.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> found = ar.chain.functional_axis([[0.0, 1.0, 0.1], [0.0, 2.0, -0.1], [0.0, -1.0, 0.0]])
    >>> round(found.share, 3)
    0.997
    """
    rates = _validate.rows("gyr", gyr, 3).astype(np.float64, copy=False)
    if rates.ndim != 2:
        raise ValueError(f"gyr: expected shape (T, 3), got {rates.shape}")
    rates = rates[~np.isnan(rates).any(axis=1)]
    values, vectors = np.linalg.eigh(rates.T @ rates)
    total = float(values.sum())
    if not total > 0.0:
        raise ValueError("gyr: expected a motion, got none")
    share = float(values[-1]) / total
    if share < LEAST_SHARE:
        raise ValueError(
            f"gyr: expected a motion about one axis, got one with {100.0 * share:.0f} % of the mean square about any "
            f"axis (at least {100.0 * LEAST_SHARE:.0f} %)"
        )
    axis = vectors[:, -1]
    about = rates @ axis
    # The first turn that is large: until half of the farthest way from the start.
    way = np.cumsum(about)
    first = about[0] if not np.any(way) else way[int(np.argmax(np.abs(way) >= 0.5 * np.abs(way).max()))]
    return FunctionalAxis(axis if first >= 0.0 else -axis, share)


def _angle(a: FloatArray, b: FloatArray) -> float:
    return float(2.0 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b)))


def _frame(axis: FloatArray, other: FloatArray) -> FloatArray:
    """(3, 3): columns are the axis, what is perpendicular to both, and the third."""
    across = np.cross(axis, other)
    across /= np.linalg.norm(across)
    return np.column_stack([axis, across, np.cross(axis, across)])
