"""Motions: orientation, angular rate, position, velocity and acceleration, each exact at every time.

Whatever has the methods of `Motion` can be recorded: a class of your own too.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _quat
from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs.simulate._functions import SPLINE_ROUNDS, Function, constant


class Motion(Protocol):
    """What a simulated sensor follows. All methods take times (T,) in s, also before zero.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> motion: ar.simulate.Motion = ar.simulate.still()
    >>> motion.velocity(np.zeros(1))
    array([[0., 0., 0.]])
    """

    def orientation(self, t: FloatArray) -> FloatArray:
        """Unit quaternions, sensor to earth (ENU).

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 4).
        """
        ...

    def angular_rate(self, t: FloatArray) -> FloatArray:
        """The angular rate in the sensor frame, at the instants.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) rad/s.
        """
        ...

    def position(self, t: FloatArray) -> FloatArray:
        """The position in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m.
        """
        ...

    def velocity(self, t: FloatArray) -> FloatArray:
        """The velocity in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s.
        """
        ...

    def acceleration(self, t: FloatArray) -> FloatArray:
        """The acceleration in ENU, without gravity.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s².
        """
        ...


class _Carried:
    """Position, velocity and acceleration from the function `path`."""

    __slots__ = ()
    path: Function

    def position(self, t: FloatArray) -> FloatArray:
        """The position in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m.
        """
        return self.path.derivative(t, 0)

    def velocity(self, t: FloatArray) -> FloatArray:
        """The velocity in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s.
        """
        return self.path.derivative(t, 1)

    def acceleration(self, t: FloatArray) -> FloatArray:
        """The acceleration in ENU, without gravity.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s².
        """
        return self.path.derivative(t, 2)


NOWHERE = constant(np.zeros(3))
EASTWARD = constant(np.zeros(1))


@dataclass(frozen=True, slots=True)
class EulerMotion:
    """Roll, pitch, yaw (intrinsic Z-Y'-X'') in rad as functions of time, and a path in m.

    The sensor stands at `lever` (m, in its own axes) from the point that moves along the path.

    Parameters
    ----------
    angles : Function
        Roll, pitch, yaw in rad (three columns).
    path : Function, optional
        In m, ENU (three columns).
    lever : tuple, optional
        Of the sensor from the path, m, in its own axes.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> m = ar.simulate.EulerMotion(ar.simulate.constant([0.0, 0.0, 0.0]))
    >>> m.angular_rate(np.zeros(2))
    array([[0., 0., 0.],
           [0., 0., 0.]])
    """

    angles: Function
    path: Function = NOWHERE
    lever: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def orientation(self, t: FloatArray) -> FloatArray:
        """Unit quaternions, sensor to earth (ENU).

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 4), continuous in sign.
        """
        return from_euler(self.angles.derivative(t, 0))

    def angular_rate(self, t: FloatArray) -> FloatArray:
        """The angular rate in the sensor frame, at the instants.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) rad/s.
        """
        roll, pitch, _ = self.angles.derivative(t, 0).T
        roll_rate, pitch_rate, yaw_rate = self.angles.derivative(t, 1).T
        across = yaw_rate * np.cos(pitch)
        return _quat.columns(
            roll_rate - yaw_rate * np.sin(pitch),
            pitch_rate * np.cos(roll) + across * np.sin(roll),
            across * np.cos(roll) - pitch_rate * np.sin(roll),
        )

    def position(self, t: FloatArray) -> FloatArray:
        """The position in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m.
        """
        position = self.path.derivative(t, 0)
        if any(self.lever):
            position = position + _quat.rotate(self.orientation(t), np.broadcast_to(self.lever, position.shape))
        return position

    def velocity(self, t: FloatArray) -> FloatArray:
        """The velocity in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s.
        """
        velocity = self.path.derivative(t, 1)
        if any(self.lever):
            velocity = velocity + _quat.rotate(self.orientation(t), np.cross(self.angular_rate(t), self.lever))
        return velocity

    def acceleration(self, t: FloatArray) -> FloatArray:
        """The acceleration in ENU, without gravity.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s².
        """
        acceleration = self.path.derivative(t, 2)
        if any(self.lever):
            rate = self.angular_rate(t)
            turning = np.cross(self._angular_acceleration(t), self.lever) + np.cross(rate, np.cross(rate, self.lever))
            acceleration = acceleration + _quat.rotate(self.orientation(t), turning)
        return acceleration

    def _angular_acceleration(self, t: FloatArray) -> FloatArray:
        """(T, 3) rad/s² in the sensor frame: the derivative of `angular_rate`."""
        (roll, pitch, _), (p, q, r), (p_rate, q_rate, r_rate) = (self.angles.derivative(t, i).T for i in range(3))
        s, c = np.sin(roll), np.cos(roll)
        across, across_rate = r * np.cos(pitch), r_rate * np.cos(pitch) - r * q * np.sin(pitch)
        return _quat.columns(
            p_rate - r_rate * np.sin(pitch) - r * q * np.cos(pitch),
            q_rate * c + across_rate * s + p * (across * c - q * s),
            across_rate * c - q_rate * s - p * (across * s + q * c),
        )


@dataclass(frozen=True, slots=True)
class ThrustMotion(_Carried):
    """A multirotor on a path (m): its z axis is along the specific force, its heading (rad) is given.

    The attitude is the shortest rotation that tilts the vertical to the force, after a turn about the vertical by the
    heading. The path needs a continuous third derivative, and the specific force must not point straight down.

    Parameters
    ----------
    path : Function
        In m, ENU (three columns).
    heading : Function, optional
        In rad (one column).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> m = ar.simulate.ThrustMotion(ar.simulate.constant([0.0, 0.0, 0.0]))
    >>> m.orientation(np.zeros(1))
    array([[1., 0., 0., 0.]])
    """

    path: Function
    heading: Function = EASTWARD

    def orientation(self, t: FloatArray) -> FloatArray:
        """Unit quaternions, sensor to earth (ENU).

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 4), continuous in sign.
        """
        axis = self._axis(t)[0]
        return _quat.multiply(_tilt(axis), _quat.about_axis(2, self.heading.derivative(t, 0)[:, 0]))

    def angular_rate(self, t: FloatArray) -> FloatArray:
        """The angular rate in the sensor frame, at the instants.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) rad/s.
        """
        axis, norm = self._axis(t)
        jerk = self.path.derivative(t, 3)
        turn = (jerk - axis * (axis * jerk).sum(axis=1, keepdims=True)) / norm
        tilt = _tilt(axis)
        # Derivative of the tilt's quaternion (w, -z_y/2w, z_x/2w, 0) with w² = (1 + z_z)/2.
        w = tilt[:, :1]
        w_rate = turn[:, 2:] / (4.0 * w)
        side = np.concatenate((-turn[:, 1:2], turn[:, :1]), axis=1) / (2.0 * w) - tilt[:, 1:3] * (w_rate / w)
        change = np.concatenate((w_rate, side, np.zeros_like(w)), axis=1)
        tilting = 2.0 * _quat.multiply(_quat.conjugate(tilt), change)[:, 1:]
        heading, heading_rate = (self.heading.derivative(t, order)[:, 0] for order in (0, 1))
        rate = _quat.rotate(_quat.about_axis(2, -heading), tilting)
        rate[:, 2] += heading_rate
        return rate

    def _axis(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The direction of the specific force (T, 3) in ENU, and its norm (T, 1)."""
        force = self.path.derivative(t, 2) + np.array([0.0, 0.0, GRAVITY])
        norm = np.linalg.norm(force, axis=1, keepdims=True)
        return force / norm, norm


@dataclass(frozen=True, slots=True)
class SplineMotion(_Carried):
    """A quaternion spline through way points, and a path in m: see `through`.

    A cumulative cubic B-spline: with control points c and the turns d between them, the orientation in a
    segment is c ⊗ exp(β₁d₁) ⊗ exp(β₂d₂) ⊗ exp(β₃d₃), where the β rise from 0 to 1 as cubic polynomials of time.
    Angular rate and acceleration are continuous. Before the first and after the last way point it rests there.
    (Kim, Kim, Shin, "A general construction scheme for unit quaternion curves", SIGGRAPH 1995.)

    Parameters
    ----------
    control : ndarray
        (n + 2, 4) control points.
    interval : float
        S between two way points.
    path : Function, optional
        In m, ENU (three columns).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> m = ar.simulate.SplineMotion.through_turns([[0.0, 0.0, 1.0]], 2.0)
    >>> m.orientation(np.array([2.0])).round(3)
    array([[0.878, 0.   , 0.   , 0.479]])
    """

    control: FloatArray
    interval: float
    path: Function = NOWHERE
    #: The turns between control points: axes (n, 3) and half angles (n,).
    axes: FloatArray = field(init=False, repr=False)
    halves: FloatArray = field(init=False, repr=False)
    _columns: tuple[FloatArray, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        turns = _quat.log(_quat.multiply(_quat.conjugate(self.control[:-1]), self.control[1:]))
        angles = np.linalg.norm(turns, axis=1)
        object.__setattr__(self, "axes", turns / np.where(angles > 0.0, angles, 1.0)[:, None])
        object.__setattr__(self, "halves", 0.5 * angles)
        columns = tuple(np.ascontiguousarray(one.T) for one in (self.control, self.axes))
        object.__setattr__(self, "_columns", columns)

    @classmethod
    def through(cls, orientations: ArrayLike, interval: float, path: Function = NOWHERE) -> SplineMotion:
        """The spline that is at orientations (n, 4) at the times 0, interval, 2·interval, ...

        Parameters
        ----------
        orientations : array_like
            (n, 4) way points.
        interval : float
            S between two of them.
        path : Function, optional
            In m, ENU (three columns).

        Returns
        -------
        SplineMotion
            The motion.

        Raises
        ------
        ValueError
            Fewer than two way points, or ones too far apart: the turn from one to the next must stay well below π.
        """
        given = np.asarray(orientations, dtype=np.float64)
        if given.ndim != 2 or given.shape[1] != 4 or len(given) < 2:
            raise ValueError(f"orientations: expected shape (n, 4) with n of at least 2, got {given.shape}")
        norm = np.linalg.norm(given, axis=1, keepdims=True)
        if not (np.isfinite(norm).all() and norm.min() > 0.0):
            raise ValueError("orientations: expected finite quaternions that are not zero")
        if not (np.isfinite(interval) and interval > 0.0):
            raise ValueError(f"interval: expected a positive number of s, got {interval}")
        through = given / norm
        inner = through
        for _ in range(SPLINE_ROUNDS):
            control = np.concatenate((inner[1:2], inner, inner[-2:-1]))  # mirrored: no rate at the ends
            turn = _quat.log(_quat.multiply(_quat.conjugate(control[:-1]), control[1:]))
            at = _quat.multiply(
                control[:-2], _quat.multiply(_quat.exp(5.0 / 6.0 * turn[:-1]), _quat.exp(turn[1:] / 6.0))
            )
            missing = _quat.log(_quat.multiply(_quat.conjugate(at), through))
            inner = _quat.multiply(inner, _quat.exp(1.5 * missing))
            inner = inner / np.linalg.norm(inner, axis=1, keepdims=True)
        if not np.abs(missing).max() < 1e-9:
            raise ValueError("orientations: the turns between way points are too large for a spline; give more of them")
        # Equal signs along the curve, so that the segments join without a jump from q to -q.
        control = np.concatenate((inner[1:2], inner, inner[-2:-1]))
        sign = np.where((control[1:] * control[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
        control[1:] *= np.cumprod(sign)[:, None]
        return cls(control, float(interval), path)

    @classmethod
    def through_turns(cls, turns: ArrayLike, interval: float, path: Function = NOWHERE) -> SplineMotion:
        """The spline from the identity on, which turns by each of the rotation vectors (n - 1, 3) in rad in turn.

        Parameters
        ----------
        turns : array_like
            (n - 1, 3) rotation vectors in rad.
        interval : float
            S of each.
        path : Function, optional
            In m, ENU (three columns).

        Returns
        -------
        SplineMotion
            The motion.
        """
        q = np.array([1.0, 0.0, 0.0, 0.0])
        orientations = [q]
        for turn in _quat.exp(np.asarray(turns, dtype=np.float64)):
            q = _quat.multiply(q, turn)
            orientations.append(q)
        return cls.through(np.array(orientations), interval, path)

    @property
    def end(self) -> float:
        """Time of the last way point, s."""
        return (len(self.control) - 3) * self.interval

    def orientation(self, t: FloatArray) -> FloatArray:
        """Unit quaternions, sensor to earth (ENU).

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 4), continuous in sign.
        """
        segment, u = self._segments(t)
        q = self._columns[0].take(segment, axis=1).T
        for i, weight in enumerate(_weights(u)):
            q = _quat.multiply(q, self._turn(segment + i, weight))
        return q

    def angular_rate(self, t: FloatArray) -> FloatArray:
        """The angular rate in the sensor frame, at the instants.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) rad/s.
        """
        segment, u = self._segments(t)
        rate = np.zeros((3, len(t))).T
        for i, (weight, slope) in enumerate(zip(_weights(u), _slopes(u), strict=True)):
            added = self._columns[1].take(segment + i, axis=1) * (
                2.0 * self.halves[segment + i] * slope / self.interval
            )
            rate = _quat.rotate(self._turn(segment + i, -weight), rate) + added.T
        rate[(t < 0.0) | (t >= self.end)] = 0.0
        return rate

    def _segments(self, t: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Each time's segment, and the part of it that has passed."""
        x = np.clip(t / self.interval, 0.0, len(self.control) - 3)
        segment = np.minimum(x.astype(np.intp), len(self.control) - 4)
        return segment, x - segment

    def _turn(self, which: NDArray[np.intp], part: FloatArray) -> FloatArray:
        """Quaternions (T, 4) of a part of the turns between control points."""
        half = part * self.halves[which]
        sine = np.sin(half)
        x, y, z = self._columns[1].take(which, axis=1)
        return _quat.columns(np.cos(half), sine * x, sine * y, sine * z)


@dataclass(frozen=True, slots=True)
class PacedMotion:
    """A motion run at another pace: at time t it is where the motion is at s(t) (one column, in s).

    Parameters
    ----------
    motion : Motion
        What is run.
    pace : Function
        s(t) in s (one column).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> m = ar.simulate.PacedMotion(ar.simulate.still(), ar.simulate.Polynomial(np.array([[0.0], [2.0]])))
    >>> m.position(np.zeros(1))
    array([[0., 0., 0.]])
    """

    motion: Motion
    pace: Function

    def orientation(self, t: FloatArray) -> FloatArray:
        """Unit quaternions, sensor to earth (ENU).

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 4), continuous in sign.
        """
        return self.motion.orientation(self._pace(t, 0))

    def angular_rate(self, t: FloatArray) -> FloatArray:
        """The angular rate in the sensor frame, at the instants.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) rad/s.
        """
        return self.motion.angular_rate(self._pace(t, 0)) * self._pace(t, 1)[:, None]

    def position(self, t: FloatArray) -> FloatArray:
        """The position in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m.
        """
        return self.motion.position(self._pace(t, 0))

    def velocity(self, t: FloatArray) -> FloatArray:
        """The velocity in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s.
        """
        return self.motion.velocity(self._pace(t, 0)) * self._pace(t, 1)[:, None]

    def acceleration(self, t: FloatArray) -> FloatArray:
        """The acceleration in ENU, without gravity.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s².
        """
        s = self._pace(t, 0)
        velocity, curvature = self.motion.velocity(s), self.motion.acceleration(s)
        return curvature * (self._pace(t, 1) ** 2)[:, None] + velocity * self._pace(t, 2)[:, None]

    def _pace(self, t: FloatArray, order: int) -> FloatArray:
        return self.pace.derivative(t, order)[:, 0]


@dataclass(frozen=True, slots=True)
class Compound:
    """A motion with another one added: the orientation base ⊗ added, and the sum of the two paths (both in ENU).

    So a vibration is put on a flight: the sensor turns against the frame that carries it.

    Parameters
    ----------
    base : Motion
        A motion.
    added : Motion
        What moves relative to it.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> m = ar.simulate.Compound(ar.simulate.still(), ar.simulate.still(yaw=1.0))
    >>> m.orientation(np.zeros(1)).shape
    (1, 4)
    """

    base: Motion
    added: Motion

    def orientation(self, t: FloatArray) -> FloatArray:
        """Unit quaternions, sensor to earth (ENU).

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 4), continuous in sign.
        """
        return _quat.multiply(self.base.orientation(t), self.added.orientation(t))

    def angular_rate(self, t: FloatArray) -> FloatArray:
        """The angular rate in the sensor frame, at the instants.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) rad/s.
        """
        back = _quat.conjugate(self.added.orientation(t))
        return _quat.rotate(back, self.base.angular_rate(t)) + self.added.angular_rate(t)

    def position(self, t: FloatArray) -> FloatArray:
        """The position in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m.
        """
        return self.base.position(t) + self.added.position(t)

    def velocity(self, t: FloatArray) -> FloatArray:
        """The velocity in ENU.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s.
        """
        return self.base.velocity(t) + self.added.velocity(t)

    def acceleration(self, t: FloatArray) -> FloatArray:
        """The acceleration in ENU, without gravity.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T, 3) m/s².
        """
        return self.base.acceleration(t) + self.added.acceleration(t)


def still(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> EulerMotion:
    """At rest for ever, at Euler angles in rad.

    Parameters
    ----------
    roll : float, optional
        In rad.
    pitch : float, optional
        In rad.
    yaw : float, optional
        In rad.

    Returns
    -------
    EulerMotion
        A motion at rest.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.still().orientation(np.zeros(1))
    array([[1., 0., 0., 0.]])
    """
    return EulerMotion(constant([roll, pitch, yaw]))


def from_euler(angles: FloatArray) -> FloatArray:
    """Quaternions (T, 4) of roll, pitch, yaw (T, 3) in rad: the product of the turns about z, y and x."""
    half = 0.5 * angles.T
    (cx, cy, cz), (sx, sy, sz) = np.cos(half), np.sin(half)
    w, x, y, z = cz * cy, -sz * sy, cz * sy, sz * cy
    return _quat.columns(w * cx - x * sx, w * sx + x * cx, y * cx + z * sx, z * cx - y * sx)


def _tilt(axis: FloatArray) -> FloatArray:
    """The shortest rotations (T, 4) that take the vertical to unit vectors (T, 3)."""
    w = np.sqrt(0.5 * (1.0 + axis[:, 2]))
    return _quat.columns(w, -axis[:, 1] / (2.0 * w), axis[:, 0] / (2.0 * w), np.zeros_like(w))


def _weights(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The cumulative cubic basis at u in [0, 1]."""
    return (5.0 + u * (3.0 - u * (3.0 - u))) / 6.0, (1.0 + u * (3.0 + u * (3.0 - 2.0 * u))) / 6.0, u * u * u / 6.0


def _slopes(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Its derivatives."""
    return 0.5 * (1.0 - u) ** 2, 0.5 * (1.0 + 2.0 * u * (1.0 - u)), 0.5 * u * u
