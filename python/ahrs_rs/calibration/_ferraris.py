"""Accelerometer and gyroscope together, from six positions and three turns (Ferraris, Grimaldi & Parvis 1995)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration._calibrations import Calibrations
from ahrs_rs.calibration._common import AXES, CalibrationError, readings, several
from ahrs_rs.calibration._gyroscope import FASTEST_REST
from ahrs_rs.calibration._model import Calibration
from ahrs_rs.calibration._turns import Turn, fit_gain, turns_of

__all__ = ["FerrarisFit", "ferraris"]

#: A position is one of an axis up or down where that axis shows so much of the norm: within 26°, as of turns.
SAME_AXIS = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class FerrarisFit:
    """Both sensors, with scale, cross axes and offset: acc = G_a y + b_a, gyr = G_g ω + K acc + b_g.

    Parameters
    ----------
    calibrations : Calibrations
        Of the accelerometer and the gyroscope; they leave out K, which the model of cal.json has
        no place for.
    acc_gain, acc_bias : ndarray
        (3, 3) G_a and (3,) b_a in m/s².
    gyr_gain, gyr_bias : ndarray
        (3, 3) G_g and (3,) b_g in rad/s.
    g_sensitivity : ndarray
        (3, 3) K in rad/s per m/s², of calibrated accelerations.
    acc_gain_std, gyr_gain_std : ndarray
        (3, 3) standard deviations, by the noise at rest as white noise.
    acc_residual : ndarray
        (K, 3) m/s²: what the calibrated positions are off their axes.
    gyr_residual : ndarray
        (M, 3) rad: what the calibrated turns lack.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> held = [(np.tile(s * 9.80665 * axis, (50, 1)), np.zeros((50, 3))) for axis in np.eye(3) for s in (1, -1)]
    >>> turns = [ar.calibration.Turn(np.tile(axis, (101, 1)), axis, 1.0, rate=100.0) for axis in np.eye(3)]
    >>> fit = ar.calibration.ferraris(held, turns)
    >>> [sensor for sensor, _ in fit.calibrations]
    ['gyr', 'acc']
    """

    calibrations: Calibrations
    acc_gain: FloatArray
    acc_bias: FloatArray
    gyr_gain: FloatArray
    gyr_bias: FloatArray
    g_sensitivity: FloatArray
    acc_gain_std: FloatArray
    gyr_gain_std: FloatArray
    acc_residual: FloatArray
    gyr_residual: FloatArray


def ferraris(
    positions: Sequence[tuple[ArrayLike, ArrayLike]], turns: Sequence[Turn], *, gravity: float = GRAVITY
) -> FerrarisFit:
    """Calibrate accelerometer and gyroscope by six positions at rest and a turn about each axis.

    The sensor's housing lies on each of its six sides, and is turned about each of its axes by a known angle, as on
    the edge of a table (Ferraris, Grimaldi & Parvis, Sensors and Materials 7(5), 1995). As the directions are known,
    misalignment to the housing is found too, which no ellipsoid tells.

    Parameters
    ----------
    positions : sequence of tuple
        For each the readings (n, 3) of accelerometer (m/s²) and gyroscope (rad/s); each axis up and
        down once at least, in any order: which it is, gravity tells.
    turns : sequence of Turn
        About each axis at least one, or about three directions that are in no plane.
    gravity : float, optional
        Local gravity, m/s².

    Returns
    -------
    FerrarisFit
        The calibrations, with their standard deviations.

    Raises
    ------
    CalibrationError
        A position that is missing or is none of the six; a sensor that turns at rest; turns that are not those told.
    ValueError
        Readings of another unit, or of another shape.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> held = [(np.tile(s * 9.8 * axis + 0.1, (50, 1)), np.zeros((50, 3))) for axis in np.eye(3) for s in (1, -1)]
    >>> turns = [ar.calibration.Turn(np.tile(axis, (101, 1)), axis, 1.0, rate=100.0) for axis in np.eye(3)]
    >>> ar.calibration.ferraris(held, turns, gravity=9.8).acc_bias.round(6)
    array([0.1, 0.1, 0.1])
    """
    gravity = positive("gravity", gravity)
    turns = turns_of(turns)
    positions = [_pair(k, one) for k, one in enumerate(several("positions", positions, "pairs of readings (acc, gyr)"))]
    acc, acc_variance = _means("acc", [one for one, _ in positions])
    gyr, gyr_variance = _means("gyr", [one for _, one in positions])
    up = _sides(acc, gravity)
    if float(np.abs(gyr).max(initial=0.0)) > FASTEST_REST:
        raise CalibrationError(
            f"positions: the sensor turns by {np.abs(gyr).max():.3g} rad/s: let it lie still (or are these °/s?)"
        )
    # Both sensors read an affine function of a force that is known: the six sides determine its twelve numbers.
    design = np.column_stack((gravity * up, np.ones(len(up))))
    pseudo = np.linalg.pinv(design)  # (4, K)
    acc_map, gyr_map = (pseudo @ acc).T, (pseudo @ gyr).T
    acc_std, gyr_std = np.sqrt((pseudo**2 @ acc_variance).T), np.sqrt((pseudo**2 @ gyr_variance).T)
    acc_gain, acc_bias = acc_map[:, :3], acc_map[:, 3]
    g_sensitivity, gyr_bias = gyr_map[:, :3], gyr_map[:, 3]

    integrals = [turn.integral(f"turns[{k}]") for k, turn in enumerate(turns)]
    if not integrals:
        raise CalibrationError("turns: expected one about each axis, got none")
    reached = np.array([total - gyr_bias * duration for total, duration, _ in integrals])
    angles = np.array([turn.vector for turn in turns])
    white = np.mean([readings("gyr", one)[0].var(axis=0) for _, one in positions], axis=0)
    noise = np.array([white * square + gyr_std[:, 3] ** 2 * duration**2 for _, duration, square in integrals])
    gyr_gain, gyr_gain_std = fit_gain(angles, reached, noise, cross_axis=True)

    method = f"Ferraris: {len(up)} positions, {len(turns)} turns"
    inverse = [np.linalg.inv(one).astype(np.float64, copy=False) for one in (acc_gain, gyr_gain)]
    calibrations = Calibrations(
        acc=Calibration(
            inverse[0],
            acc_bias,
            {
                "method": method,
                "gravity": gravity,
                "gain_std": acc_std[:, :3].tolist(),
                "bias_std": acc_std[:, 3].tolist(),
            },
        ),
        gyr=Calibration(
            inverse[1],
            gyr_bias,
            {
                "method": method,
                "gain_std": gyr_gain_std.tolist(),
                "bias_std": gyr_std[:, 3].tolist(),
                "g_sensitivity": g_sensitivity.tolist(),
            },
        ),
    )
    return FerrarisFit(
        calibrations,
        acc_gain,
        acc_bias,
        gyr_gain,
        gyr_bias,
        g_sensitivity,
        acc_std[:, :3],
        gyr_gain_std,
        (acc - acc_bias) @ inverse[0].T - gravity * up,
        reached @ inverse[1].T - angles,
    )


def _pair(k: int, given: object) -> tuple[ArrayLike, ArrayLike]:
    parts = several(f"positions[{k}]", given, "a pair of readings (acc, gyr)")
    if len(parts) != 2:
        raise ValueError(f"positions[{k}]: expected a pair of readings (acc, gyr), got {len(parts)} parts")
    return parts[0], parts[1]


def _means(name: str, parts: Sequence[ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """(K, 3) means of the positions, and (K, 3) their variances; 0 of a position with one reading."""
    means, variances = [], []
    for k, part in enumerate(parts):
        array, valid = readings(f"positions[{k}]: {name}", part)
        rows = array[valid]
        if not len(rows):
            raise CalibrationError(f"positions[{k}]: {name}: expected readings, got NaN only")
        means.append(rows.mean(axis=0))
        variances.append(rows.var(axis=0, ddof=1) / len(rows) if len(rows) > 1 else np.zeros(3))
    return np.array(means).reshape(-1, 3), np.array(variances).reshape(-1, 3)


def _sides(acc: FloatArray, gravity: float) -> FloatArray:
    """(K, 3) the direction of up in each position: one of the six half axes of the sensor."""
    norm = np.linalg.norm(acc, axis=1)
    ratio = float(np.median(norm)) / gravity if len(acc) else 1.0
    if not 0.5 <= ratio <= 2.0:
        unit = f": are they in g (times {GRAVITY})?" if 0.5 <= ratio * gravity <= 2.0 else ""
        raise ValueError(f"positions: expected readings of about {gravity:.4g} m/s², got {ratio * gravity:.3g}{unit}")
    up = np.zeros_like(acc)
    for k, one in enumerate(acc):
        axis = int(np.argmax(np.abs(one)))
        if abs(one[axis]) < SAME_AXIS * norm[k]:
            shown = ", ".join(f"{part:.2f}" for part in one)
            raise CalibrationError(f"positions[{k}]: expected an axis up or down, got a force of ({shown}) m/s²")
        up[k, axis] = np.sign(one[axis])
    missing = [
        f"{axis} {word}"
        for k, axis in enumerate(AXES)
        for word, side in (("up", 1.0), ("down", -1.0))
        if not (up[:, k] == side).any()
    ]
    if missing:
        raise CalibrationError(
            f"positions: there is none with {', '.join(missing)}: lay the sensor on each of its sides"
        )
    return up
