"""Closed forms for an accelerometer and a magnetometer: SAAM, FAMC and FQA."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import BoolArray, FloatArray, Floats
from ahrs_rs.attitude import _arguments
from ahrs_rs.attitude._pairs import FRAMES, acc_and_mag, angle


def saam(acc: ArrayLike, mag: ArrayLike, *, frame: str = "ENU", declination: float = 0.0) -> Floats:
    """SAAM, the super-fast attitude from accelerometer and magnetometer.

    Parameters
    ----------
    acc : array_like
        (..., 3) specific force, in any unit.
    mag : array_like
        (..., 3) magnetic field, in any unit; leading axes broadcast.
    frame : {"ENU", "NED", "NWU"}, optional
        Earth frame.
    declination : float, optional
        Angle from true north to magnetic north, in rad, positive east.

    Returns
    -------
    ndarray
        (..., 4) quaternions from sensor to earth. NaN where a vector is zero or holds a NaN, or where both
        are along one line.

    Raises
    ------
    ValueError
        Arrays that are not (..., 3), infinite values, or an unknown frame.

    Notes
    -----
    Source: J. Wu, Z. Zhou, H. Fourati and Y. Cheng, "A super fast attitude determination algorithm for
    consumer-level accelerometer and magnetometer", IEEE Transactions on Consumer Electronics 64(3), 2018, equations
    12 to 18, as the documentation of the package `ahrs` has them. Their result is -4 m_N q_x times the attitude in
    NWU, so it is 0/0 for a level sensor. Here it is found four times, for the sensor as it is and turned by half a
    turn about each of its axes, and the longest result is turned back. Its covariance is that of
    `triad_covariance`.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.attitude.saam([[0.0, 0.0, 9.81], [9.81, 0.0, 0.0]], [[0.0, 22.0, -42.0], [-42.0, 22.0, 0.0]]).round(6) + 0.0
    array([[ 1.      ,  0.      ,  0.      ,  0.      ],
           [ 0.707107,  0.      , -0.707107,  0.      ]])
    """
    return _nwu(_saam, acc, mag, frame, declination)


def famc(acc: ArrayLike, mag: ArrayLike, *, frame: str = "ENU", declination: float = 0.0) -> Floats:
    """FAMC, the fast accelerometer-magnetometer combination.

    Parameters
    ----------
    acc : array_like
        (..., 3) specific force, in any unit.
    mag : array_like
        (..., 3) magnetic field, in any unit; leading axes broadcast.
    frame : {"ENU", "NED", "NWU"}, optional
        Earth frame.
    declination : float, optional
        Angle from true north to magnetic north, in rad, positive east.

    Returns
    -------
    ndarray
        (..., 4) quaternions from sensor to earth. NaN where a vector is zero or holds a NaN, or where both
        are along one line.

    Raises
    ------
    ValueError
        Arrays that are not (..., 3), infinite values, or an unknown frame.

    Notes
    -----
    Source: Z. Liu, W. Liu, X. Gong and J. Wu, "Simplified attitude determination algorithm using accelerometer and
    magnetometer with extremely low execution time", Journal of Sensors, 2018, equations 10 to 23, as the
    documentation of the package `ahrs` has them. The elimination sets the scalar part to -1, which fails at half a
    turn (w = 0). As in `saam`, it is done for four poses of the sensor, and that of the largest scalar part is
    turned back. Its covariance is that of `triad_covariance`.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.attitude.famc([0.0, 0.0, -9.81], [0.0, 22.0, 42.0]).round(6) + 0.0  # half a turn about y
    array([0., 0., 1., 0.])
    """
    return _nwu(_famc, acc, mag, frame, declination)


def fqa(acc: ArrayLike, mag: ArrayLike | None = None, *, frame: str = "ENU", declination: float = 0.0) -> Floats:
    """FQA, the factored quaternion algorithm: elevation, roll and azimuth, without angles.

    Parameters
    ----------
    acc : array_like
        (..., 3) specific force, in any unit.
    mag : array_like, optional
        (..., 3) magnetic field, in any unit; leading axes broadcast. Without it the azimuth (yaw) is zero in the chosen
        frame.
    frame : {"ENU", "NED", "NWU"}, optional
        Earth frame.
    declination : float, optional
        Angle from true north to magnetic north, in rad, positive east. Without `mag` it has no meaning.

    Returns
    -------
    ndarray
        (..., 4) quaternions from sensor to earth. NaN where a vector is zero or holds a NaN, or where both
        are along one line.

    Raises
    ------
    ValueError
        Arrays that are not (..., 3), infinite values, or an unknown frame.

    Notes
    -----
    Source: X. Yun, E. R. Bachmann and R. B. McGhee, "A simplified quaternion-based algorithm for orientation
    estimation from earth gravity and magnetic field measurements", IEEE Transactions on Instrumentation and
    Measurement 57(3), 2008, equations 20 to 41, as the documentation of the package `ahrs` has them. Where x is
    vertical, the roll is taken as zero, as there. The half-angle formulas (equations 23 and 24) lose half of the
    digits of small angles: of sine and cosine of the half angle, only the larger one is found by its formula, and
    the other one by sin θ = 2 sin(θ/2) cos(θ/2).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.attitude.fqa([0.0, 9.81, 9.81]).round(6)  # a roll of 45°
    array([0.92388 , 0.382683, 0.      , 0.      ])
    >>> ar.attitude.fqa([0.0, 9.81, 9.81], [0.0, 20.0, -42.0]).round(6)
    array([0.92388 , 0.382683, 0.      , 0.      ])
    """
    _validate.choice("frame", frame, FRAMES)
    turn = angle("declination", declination)
    if mag is None:
        force = _arguments.vectors("acc", acc)
        a, known = _arguments.units(force)
        return _arguments.finished(_tilt(a if frame != "NED" else -a), known, _arguments.precision(force))
    a, m, there, dtype = acc_and_mag(acc, mag)
    tilt = _tilt(a if frame != "NED" else -a)
    level = _quat.rotate(tilt, m)  # equation 34
    norm = np.hypot(level[..., 0], level[..., 1])
    x, y = (part / np.where(norm > 0.0, norm, 1.0) for part in (level[..., 0], level[..., 1]))  # equation 37
    north, east = np.cos(turn), np.sin(turn)  # equation 36
    nx, ny = {"ENU": (east, north), "NED": (north, east), "NWU": (north, -east)}[frame]
    cosine, sine = x * nx + y * ny, x * ny - y * nx  # equation 39
    azimuth = _half_turned(cosine, sine, 3)  # equation 40
    known = _crossed(a, m, dtype) & there
    return _arguments.finished(_quat.multiply(azimuth, tilt), known, dtype)  # equation 41


def _nwu(method: Any, acc: ArrayLike, mag: ArrayLike, frame: str, declination: float) -> Floats:
    """The result of a method that finds attitudes in NWU, of four poses of the sensor, in a frame."""
    _validate.choice("frame", frame, FRAMES)
    turn = angle("declination", declination)
    a, m, there, dtype = acc_and_mag(acc, mag)
    north = _arguments.length(np.cross(a, m))  # m_N = √(1 - m_D²), where that would lose its digits
    up = np.sum(a * m, axis=-1)  # m_D, equations 12 of SAAM and 13 of FAMC
    known = there & _crossed(a, m, dtype)
    rows = []
    for pose, signs in enumerate(_arguments.SIGNS):
        quat = method(*np.moveaxis(signs * a, -1, 0), *np.moveaxis(signs * m, -1, 0), north, up)
        rows.append(_quat.multiply(quat, np.broadcast_to(_arguments.HALF_TURNS[pose], quat.shape)))
    quat = _arguments.longest(np.stack(rows, axis=-2))
    return _arguments.finished(_quat.multiply(_from_nwu(frame, turn), quat), known, dtype)


def _saam(
    ax: FloatArray,
    ay: FloatArray,
    az: FloatArray,
    mx: FloatArray,
    my: FloatArray,
    mz: FloatArray,
    north: FloatArray,
    up: FloatArray,
) -> FloatArray:
    """Equation 16."""
    return _arguments.columns(
        ax * my - ay * (north + mx),
        (az - 1.0) * (north + mx) + ax * (up - mz),
        (az - 1.0) * my + ay * (up - mz),
        az * up - ax * north - mz,
    )


def _famc(
    ax: FloatArray,
    ay: FloatArray,
    az: FloatArray,
    mx: FloatArray,
    my: FloatArray,
    mz: FloatArray,
    north: FloatArray,
    up: FloatArray,
) -> FloatArray:
    """Equations 18 to 22: K - I with the vector first, reduced to rows (1 0 0 a), (0 1 0 b), (0 0 1 c).

    The weights are ½ and ½, and the largest eigenvalue is 1. K - I has no positive eigenvalue and one that is zero,
    so no pivot is zero unless w is. The product of the pivots is a multiple of w²: multiplied by it, the longest of the
    results for several poses is that of the largest w.
    """
    # Equation 18: the columns of B are for x, y and z of the earth; that of y is zero.
    b11, b21, b31 = 0.5 * north * mx, 0.5 * north * my, 0.5 * north * mz
    b13, b23, b33 = 0.5 * (up * mx + ax), 0.5 * (up * my + ay), 0.5 * (up * mz + az)
    # S = K - I, symmetric: its block of the vector part, and the column z of the scalar part.
    s11, s22, s33 = b11 - b33 - 1.0, -b11 - b33 - 1.0, b33 - b11 - 1.0
    s12, s13, s23 = b21, b13 + b31, b23
    z1, z2, z3 = b23, b31 - b13, -b21
    # First row, second row, third row: what each elimination leaves of the rows below.
    f12, f13 = _over(s12, s11), _over(s13, s11)
    s22, s23, z2 = s22 - f12 * s12, s23 - f12 * s13, z2 - f12 * z1
    s33, z3 = s33 - f13 * s13, z3 - f13 * z1
    f23 = _over(s23, s22)
    s33, z3 = s33 - f23 * s23, z3 - f23 * z2
    # Upwards: equation 21.
    c = _over(z3, s33)
    b = _over(z2 - s23 * c, s22)
    a = _over(z1 - s12 * b - s13 * c, s11)
    # (K - I) q = 0 for q = (-1, a, b, c), equation 22: S (a, b, c) = z.
    return (s11 * s22 * s33)[..., np.newaxis] * _arguments.columns(-np.ones_like(a), a, b, c)


def _over(number: FloatArray, pivot: FloatArray) -> FloatArray:
    """The quotient; 0 where the pivot is not beyond rounding, which makes no result that is taken."""
    quotient: FloatArray = np.divide(
        number, pivot, out=np.zeros_like(number), where=np.abs(pivot) > np.finfo(np.float64).eps
    )
    return quotient


def _tilt(up: FloatArray) -> FloatArray:
    """Elevation and roll q_e ⊗ q_r of the direction z of the earth in the sensor frame: up, or minus up in NED."""
    flat = np.hypot(up[..., 1], up[..., 2])
    level = flat == 0.0
    sine, cosine = -up[..., 0], flat  # equations 21, 22: here z is the direction of minus the paper's measurement
    elevation = _half_turned(cosine, sine, 2)  # equation 25
    some = np.where(level, 1.0, flat)
    # Equations 30 and 31; the roll is zero where x is vertical.
    roll = _half_turned(np.where(level, 1.0, up[..., 2] / some), np.where(level, 0.0, up[..., 1] / some), 1)
    return _quat.multiply(elevation, roll)


def _half_turned(cosine: FloatArray, sine: FloatArray, axis: int) -> FloatArray:
    """The quaternion of a rotation about an axis (1, 2, 3) by an angle of which sine and cosine are known.

    Equations 23 and 24, each where it does not cancel.
    """
    large = np.sqrt(0.5 * (1.0 + np.abs(cosine)))
    small = 0.5 * np.abs(sine) / large
    quat = np.zeros((*cosine.shape, 4))
    quat[..., 0] = np.where(cosine < 0.0, small, large)
    quat[..., axis] = np.copysign(np.where(cosine < 0.0, large, small), sine)
    return quat


def _crossed(a: FloatArray, m: FloatArray, dtype: Any) -> BoolArray:
    """Where two unit vectors are not along one line."""
    least = _arguments.LOST * float(np.finfo(dtype).eps)
    crossed: BoolArray = _arguments.length(np.cross(a, m)) > least
    return crossed


def _from_nwu(frame: str, declination: float) -> FloatArray:
    """The rotation from magnetic north-west-up to a frame of true north."""
    # About z by -D in NWU, as seen by a frame that is turned to true north.
    turn = _quat.about_axis(2, np.asarray(-declination))
    root = np.sqrt(0.5)
    to = {"NWU": [1.0, 0.0, 0.0, 0.0], "ENU": [root, 0.0, 0.0, root], "NED": [0.0, 1.0, 0.0, 0.0]}[frame]
    return _quat.multiply(np.array(to), turn)
