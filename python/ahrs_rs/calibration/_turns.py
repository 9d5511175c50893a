"""Turns by known angles: whether the readings make them, and the gains that follow."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import number, positive
from ahrs_rs.calibration._common import (
    AXES,
    CalibrationError,
    CalibrationWarning,
    readings,
    several,
    vector,
)

__all__ = ["Turn"]

#: A turn of a smaller angle says less about the gain than about the bias, rad.
SMALLEST_TURN = 0.5
#: A turn is the one that is told where its axis is within 26° of that one's: no housing is farther off.
SAME_AXIS = 0.9
#: Turns about one axis whose gains differ by more than this are not all by the angles that are told: a turn by hand
#: from edge to edge is within 2°, of 90° one part in 45.
LARGEST_DISAGREEMENT = 0.1
#: No gyroscope's gain is off by more: data sheets say 1 to 10 %.
LARGEST_ERROR = 0.2
#: Information closer to singular than this tells nothing.
WORST_CONDITION = 1e6


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """A turn by a known angle about one axis that is fixed in the sensor, from rest to rest.

    Parameters
    ----------
    gyr : array_like
        (T, 3) rad/s, with the rest before and after.
    axis : str or array_like
        "x", "y", "z", or a direction (3,) in the sensor frame.
    angle : float
        Rad, positive by the right-hand rule.
    rate : float, optional
        Hz; or t : (T,) s.
    t : array_like, optional
        (n,) stamps in s, in place of the rate.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr = np.tile([0.0, 0.0, 1.0], (101, 1))
    >>> turn = ar.calibration.Turn(gyr, "z", 1.0, rate=100.0)
    >>> turn.axis, turn.angle
    ('z', 1.0)
    """

    gyr: ArrayLike
    axis: str | ArrayLike
    angle: float
    rate: float | None = None
    t: ArrayLike | None = None

    @property
    def vector(self) -> FloatArray:
        """(3,) axis times angle."""
        if isinstance(self.axis, str):
            if self.axis not in tuple(AXES):
                raise ValueError(f"axis: expected x, y, z or a direction, got {self.axis!r}")
            direction = np.eye(3)[AXES.index(self.axis)]
        else:
            direction = vector("axis", self.axis, 3)
        length, angle = float(np.linalg.norm(direction)), number("angle", self.angle)
        if not (math.isfinite(length) and length > 0 and math.isfinite(angle)):
            raise ValueError(f"axis, angle: expected a direction and rad, got {self.axis!r} and {self.angle}")
        if abs(angle) < SMALLEST_TURN:
            raise CalibrationError(f"angle: expected a turn of at least {SMALLEST_TURN} rad, got {angle:.3g}")
        turned: FloatArray = direction / length * angle
        return turned

    def integral(self, name: str) -> tuple[FloatArray, float, float]:
        """∫ gyr dt in rad, the duration in s, and Σ dt² in s²; missing rows hold the last rate.

        Parameters
        ----------
        name : str
            Of the turn, for messages.

        Returns
        -------
        tuple
            The integral, the duration and the sum of squared steps.
        """
        array, valid = readings(name, self.gyr)
        if not valid.any() or len(array) < 2:
            raise CalibrationError(f"{name}: expected a turn, got {int(valid.sum())} readings")
        last = np.maximum.accumulate(np.where(valid, np.arange(len(array)), int(np.argmax(valid))))
        dt = steps(len(array), self.rate, self.t)
        return dt @ array[last[1:]], float(dt.sum()), float(dt @ dt)


def turns_of(given: object) -> list[Turn]:
    """The turns of an argument; a ValueError where something is none."""
    turns: list[Turn] = several("turns", given, "Turns, as many as were made")
    for k, one in enumerate(turns):
        if not isinstance(one, Turn):
            raise ValueError(f"turns[{k}]: expected a Turn, got {type(one).__name__}")
    return turns


def fit_gain(
    angles: FloatArray, reached: FloatArray, noise: FloatArray, cross_axis: bool, *, some: bool = False
) -> tuple[FloatArray, FloatArray]:
    """G and its standard deviations: reached (K, 3) = G angles (K, 3), with the variances of what was reached.

    Parameters
    ----------
    some : turns about some of the axes are enough; the gains of the others are 1, with NaN for a deviation.
    """
    check_turns(angles, reached)
    turned = np.abs(angles).max(axis=0) >= SMALLEST_TURN
    if not (turned.any() if some else turned.all()):
        lacking = ", ".join(axis for axis, one in zip(AXES, turned, strict=True) if not one)
        raise CalibrationError(f"turns: there is none about {lacking}: turn the sensor by a known angle")
    if not cross_axis:
        power = np.where(turned, (angles**2).sum(axis=0), 1.0)
        gain = np.where(turned, (angles * reached).sum(axis=0) / power, 1.0)
        found, std = np.diag(gain), np.sqrt((angles**2 * noise).sum(axis=0)) / power
        deviation = np.diag(np.where(turned, std, np.nan))
        deviation[~np.eye(3, dtype=np.bool_)] = 0.0
    else:
        gram = angles.T @ angles
        if np.linalg.cond(gram) > WORST_CONDITION:
            raise CalibrationError("turns: their axes lie in a plane: turn the sensor about each of its axes")
        inverse = np.linalg.inv(gram) @ angles.T  # (3, K)
        found, deviation = (inverse @ reached).T, np.sqrt((inverse**2 @ noise).T)
    _check_agreement(angles, reached, found)
    return found, deviation


def check_turns(angles: FloatArray, reached: FloatArray) -> None:
    """Refuse turns (K, 3) that the readings do not make: another unit, another axis or direction."""
    size, length = np.linalg.norm(angles, axis=1), np.linalg.norm(reached, axis=1)
    ratio = float(np.median(length / size))
    if not 0.5 <= ratio <= 2.0:
        unit = ": are the readings in °/s?" if 0.5 <= ratio * math.pi / 180 <= 2.0 else ""
        raise ValueError(f"turns: the readings turn by {ratio:.3g} times the angles that are given{unit}")
    along = (angles * reached).sum(axis=1) / size
    wrong = np.flatnonzero(~(along >= SAME_AXIS * length) | ~(along >= 0.5 * size) | ~(along <= 2.0 * size))
    if wrong.size:
        first = int(wrong[0])
        every = "" if len(angles) == 1 else f"; all of them: {', '.join(map(told, reached))}"
        raise CalibrationError(
            f"turns[{first}]: expected a turn by {told(angles[first])}, got one by {told(reached[first])}: are order, "
            f"signs and angles of the turns right{every}"
        )


def told(turn: FloatArray) -> str:
    """A turn (3,) in words: 360° about z."""
    axis = int(np.argmax(np.abs(turn)))
    size = float(np.linalg.norm(turn))
    if abs(turn[axis]) >= SAME_AXIS * size:
        return f"{math.degrees(math.copysign(size, turn[axis])):.0f}° about {AXES[axis]}"
    x, y, z = turn / size
    return f"{math.degrees(size):.0f}° about ({x:.2f}, {y:.2f}, {z:.2f})"


def _check_agreement(angles: FloatArray, reached: FloatArray, gain: FloatArray) -> None:
    power = (angles**2).sum(axis=1)
    off = (angles * (reached - angles @ gain.T)).sum(axis=1) / power
    if float(np.abs(off).max()) > LARGEST_DISAGREEMENT:
        raise CalibrationError(
            f"turns: expected angles that agree, got gains that differ: told are {', '.join(map(told, angles))}, and "
            f"the readings turn by {', '.join(map(told, reached))}"
        )


def doubt(gain: FloatArray, std: FloatArray) -> None:
    """Warn of gains that nothing is known of, or that no gyroscope has."""
    unknown = [axis for k, axis in enumerate(AXES) if math.isnan(std[k, k])]
    if unknown:
        warnings.warn(
            f"turns: there is none about {', '.join(unknown)}, whose gains stay at 1", CalibrationWarning, stacklevel=4
        )
    for k, axis in enumerate(AXES):
        if abs(gain[k, k] - 1.0) > LARGEST_ERROR:
            warnings.warn(
                f"turns: the gain of {axis} is {gain[k, k]:.3g}, and no gyroscope is off by so much: are the angles of "
                "the turns right?",
                CalibrationWarning,
                stacklevel=4,
            )


def steps(count: int, rate: float | None, t: ArrayLike | None) -> FloatArray:
    """(T − 1,) time between samples, s."""
    if t is not None:
        stamps = vector("t", t, count)
        dt: FloatArray = np.diff(stamps)
        if not np.isfinite(stamps).all() or (dt < 0).any():
            raise ValueError(
                f"t: expected finite times that do not decrease, got {np.array2string(stamps, threshold=6)}"
            )
        return dt
    if rate is None:
        raise ValueError("rate: expected a number where t is not given, got None")
    return np.full(max(count - 1, 0), 1.0 / positive("rate", rate))
