"""Pairs of directions: as the sensor measures them, and as they are on earth."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _validate
from ahrs_rs._typing import BoolArray, FloatArray, Floats
from ahrs_rs.attitude import _arguments

#: The earth frames, as the filters have them.
FRAMES = ("ENU", "NED", "NWU")


class Profile(NamedTuple):
    """What Wahba's problem needs of the pairs."""

    matrix: FloatArray
    """B = Σ aᵢ bᵢ rᵢᵀ, (..., 3, 3), for directions b in the sensor frame and r on earth."""
    dtype: Any

    def davenport(self) -> FloatArray:
        """Davenport's matrix K (..., 4, 4), scalar-first: its eigenvector of the largest eigenvalue is the attitude."""
        b = self.matrix
        trace = np.trace(b, axis1=-2, axis2=-1)[..., np.newaxis, np.newaxis]
        # z = Σ aᵢ bᵢ × rᵢ
        z = np.stack([b[..., i, j] - b[..., j, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)[..., np.newaxis]
        square = b + np.swapaxes(b, -1, -2) - trace * np.eye(3)
        return np.block([[trace, np.swapaxes(z, -1, -2)], [z, square]])

    def finished(self, quat: FloatArray, room: FloatArray | None = None, *, polynomial: bool = False) -> Floats:
        """The result of these quaternions, which a polynomial's root was used for or not: NaN where they are lost."""
        if room is None:
            s = np.linalg.svd(self.matrix, compute_uv=False)
            room = room_of(s, np.sign(_arguments.determinant(self.matrix)))
        known = determined(room, self.dtype)
        if polynomial:
            # The root's error ε / room makes one of ε / room² of the attitude.
            known &= room**2 > _arguments.LOST * np.finfo(np.float64).eps
        return _arguments.finished(quat, known, self.dtype)


def checked(sensor: ArrayLike, earth: ArrayLike) -> tuple[FloatArray, FloatArray, BoolArray, Any]:
    """Unit vectors (..., n, 3) of both sides, the pairs that there are (..., n), and the dtype of the result."""
    measured, known = (_arguments.vectors(name, each, rows=2) for name, each in (("sensor", sensor), ("earth", earth)))
    dtype = _arguments.precision(measured, known)
    if measured.shape[-2] != known.shape[-2]:
        raise ValueError(f"sensor, earth: expected as many directions, got {measured.shape[-2]} and {known.shape[-2]}")
    measured, known = _arguments.together(sensor=measured, earth=known)
    (b, b_there), (r, r_there) = _arguments.units(measured), _arguments.units(known)
    return b, r, b_there & r_there, dtype


def profile(sensor: ArrayLike, earth: ArrayLike, weights: ArrayLike | None) -> Profile:
    """The attitude profile of pairs."""
    b, r, there, dtype = checked(sensor, earth)
    a = _arguments.shares("weights", weights, there)
    matrix = np.einsum("...n,...ni,...nj->...ij", a, b, r)
    return Profile(matrix, dtype)


def room_of(values: Floats, sign: FloatArray) -> FloatArray:
    """(s₂ + d s₃) / s₁, 0 to 2, for a profile's singular values s and the sign d of its determinant; 0 if all is zero.

    The attitude is determined where that is not zero (Markley 1988). Half the distance of the two largest eigenvalues
    of Davenport's matrix is s₂ + d s₃; for two pairs of an angle θ, small and the same on both sides, it is about θ²/4.
    """
    least: FloatArray = values[..., 1] + sign * values[..., 2]
    quotient: FloatArray = np.divide(least, values[..., 0], out=np.zeros_like(least), where=values[..., 0] > 0.0)
    return quotient


def largest(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The eigenvector of the largest eigenvalue of Davenport's matrix, and its room: λ₁ and λ₂ are s₁ ± (s₂ + d s₃)."""
    values, directions = np.linalg.eigh(matrix)  # they ascend
    total = values[..., 3] + values[..., 2]
    room = np.divide(values[..., 3] - values[..., 2], total, out=np.zeros_like(total), where=total > 0.0)
    return directions[..., 3], room


def determined(room: FloatArray, dtype: Any) -> BoolArray:
    """Where the attitude is determined: rounding by ε turns it by about ε / room, that of the inputs by ε / √room."""
    computed, given = (_arguments.LOST * float(np.finfo(each).eps) for each in (np.float64, dtype))
    known: BoolArray = room > max(computed, given**2)
    return known


def pairs(
    acc: ArrayLike,
    mag: ArrayLike,
    *,
    frame: str = "ENU",
    dip: float | None = None,
    declination: float = 0.0,
) -> tuple[Floats, Floats]:
    """Pairs of directions from an accelerometer and a magnetometer: up, and the magnetic field.

    Parameters
    ----------
    acc : array_like
        (..., 3) specific force, in any unit.
    mag : array_like
        (..., 3) magnetic field, in any unit.
    frame : {"ENU", "NED", "NWU"}, optional
        Earth frame.
    dip : float, optional
        Angle of the field below the horizontal, in rad (`ar.earth.field` knows it). Without it, it is that of each
        measurement, so that the two pairs fit exactly and weights have no effect.
    declination : float, optional
        Angle from true north to magnetic north, in rad, positive east.

    Returns
    -------
    sensor : ndarray
        (..., 2, 3) unit vectors of acc and mag; NaN where one is zero or holds a NaN.
    earth : ndarray
        (..., 2, 3) unit vectors of up and of the field in the earth frame.

    Raises
    ------
    ValueError
        Arrays that are not (..., 3), infinite values, an unknown frame, or a dip beyond ±π/2.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> sensor, earth = ar.attitude.pairs([0.0, 0.0, 9.81], [0.0, 3.0, -4.0], frame="NED")
    >>> earth
    array([[ 0. ,  0. , -1. ],
           [ 0.6,  0. ,  0.8]])
    >>> ar.attitude.triad(sensor, earth).round(6)
    array([0.      , 0.707107, 0.707107, 0.      ])
    """
    a, m, there, dtype = acc_and_mag(acc, mag)
    _validate.choice("frame", frame, FRAMES)
    turn = angle("declination", declination)
    if dip is None:
        sine = -np.sum(a * m, axis=-1)
        cosine = _arguments.length(np.cross(a, m))
    else:
        below = angle("dip", dip)
        if abs(below) > 0.5 * np.pi:
            raise ValueError(f"dip: expected an angle within ±π/2 rad, got {below}")
        sine, cosine = np.full(a.shape[:-1], np.sin(below)), np.full(a.shape[:-1], np.cos(below))
    north, east, zero, one = cosine * np.cos(turn), cosine * np.sin(turn), np.zeros_like(sine), np.ones_like(sine)
    if frame == "ENU":
        up, field = (zero, zero, one), (east, north, -sine)
    elif frame == "NWU":
        up, field = (zero, zero, one), (north, -east, -sine)
    else:
        up, field = (zero, zero, -one), (north, east, sine)
    sensor = np.where(there[..., np.newaxis, np.newaxis], np.stack((a, m), axis=-2), np.nan)
    earth = np.stack((_arguments.columns(*up), _arguments.columns(*field)), axis=-2)
    return sensor.astype(dtype), (earth + 0.0).astype(dtype)


def acc_and_mag(acc: ArrayLike, mag: ArrayLike) -> tuple[FloatArray, FloatArray, BoolArray, Any]:
    """Unit vectors (..., 3) of both sensors, where both are there (...), and the dtype of the result."""
    force, field = _arguments.vectors("acc", acc), _arguments.vectors("mag", mag)
    dtype = _arguments.precision(force, field)
    force, field = _arguments.together(acc=force, mag=field)
    (a, a_there), (m, m_there) = _arguments.units(force), _arguments.units(field)
    return a, m, a_there & m_there, dtype


def angle(name: str, given: object) -> float:
    """A finite number; ValueError where it is none."""
    value = _validate.number(name, given)
    if not np.isfinite(value):
        raise ValueError(f"{name}: expected a finite angle in rad, got {value}")
    return value
