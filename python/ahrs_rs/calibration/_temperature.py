"""Gain and bias as lines over the temperature, by the two strategies of Hyyti & Visala 2015, section 3.4."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration import _positions
from ahrs_rs.calibration._common import AXES, CalibrationError, readings, vector
from ahrs_rs.calibration._model import Calibration, TemperatureCalibration
from ahrs_rs.calibration._turns import Turn, fit_gain

__all__ = ["two_temperatures", "warm_up_accelerometer", "warm_up_gyroscope"]

#: Temperatures closer than this tell nothing of a slope, °C.
CLOSEST = 1.0


@dataclass(frozen=True, slots=True)
class _Line:
    """A regression line of readings over the temperature: mean + slope (T − centre), with independent errors."""

    centre: float
    mean: FloatArray
    slope: FloatArray
    mean_variance: FloatArray
    """(3,)"""
    slope_variance: FloatArray
    low: float
    high: float

    def at(self, temperature: float) -> FloatArray:
        return self.mean + self.slope * (temperature - self.centre)


def two_temperatures(
    first: Calibration, second: Calibration, temperatures: tuple[float, float]
) -> TemperatureCalibration:
    """The line through two calibrations, each at a constant temperature (the first strategy).

    Parameters
    ----------
    first, second : Calibration
        With a scale for each axis alone (6 parameters).
    temperatures : tuple
        Of the two, °C.

    Returns
    -------
    TemperatureCalibration
        The line.

    Raises
    ------
    CalibrationError
        Temperatures that differ by less than 1 °C.
    ValueError
        A calibration with terms between axes: the model has none.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> cold = ar.calibration.Calibration(np.eye(3), np.zeros(3))
    >>> warm = ar.calibration.Calibration(np.eye(3), np.full(3, 0.2))
    >>> ar.calibration.two_temperatures(cold, warm, (10.0, 30.0)).bias_slope.round(6)
    array([0.01, 0.01, 0.01])
    """
    low, high = (float(one) for one in temperatures)
    if not abs(high - low) >= CLOSEST:
        raise CalibrationError(f"temperatures: expected two that differ by at least {CLOSEST} °C, got {low} and {high}")
    gains = []
    for name, one in (("first", first), ("second", second)):
        diagonal = np.diag(one.matrix)
        if not np.array_equal(one.matrix, np.diag(diagonal)):
            raise ValueError(f"{name}: expected a calibration without terms between axes, got {one.matrix.tolist()}")
        gains.append(1.0 / diagonal)
    gain = np.diff(gains, axis=0)[0] / (high - low)
    bias = (second.offset - first.offset) / (high - low)
    return TemperatureCalibration(
        gain_slope=gain,
        gain_at_zero=gains[0] - gain * low,
        bias_slope=bias,
        bias_at_zero=first.offset - bias * low,
        range=(min(low, high), max(low, high)),
        info={"method": "two temperatures"},
    )


def warm_up_accelerometer(
    positions: Sequence[tuple[ArrayLike, ArrayLike]], *, gravity: float = GRAVITY
) -> TemperatureCalibration:
    """Gain and bias from six positions, in each of which the cooled sensor warmed up at rest (the second strategy).

    In each position the readings of each axis are a regression line over the temperature; the lines give the readings
    of the six positions at the two ends of the range that all have seen, from which `six_positions` gives the two
    calibrations.

    Parameters
    ----------
    positions : sequence of tuple
        Six or more of (acc (T, 3) m/s², temperature (T,) °C).
    gravity : float, optional
        Local gravity, m/s².

    Returns
    -------
    TemperatureCalibration
        The lines.

    Raises
    ------
    CalibrationError
        Too few positions, a position with too small a range, ranges that do not overlap.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> temperature = np.linspace(10.0, 40.0, 300)
    >>> held = [sign * 9.80665 * np.eye(3)[axis] for axis in range(3) for sign in (1, -1)]
    >>> warm_ups = [(np.tile(force, (300, 1)) + 0.001 * temperature[:, None], temperature) for force in held]
    >>> ar.calibration.warm_up_accelerometer(warm_ups).bias_slope.round(6)
    array([0.001, 0.001, 0.001])
    """
    gravity = positive("gravity", gravity)
    lines = [_line(f"positions[{k}]", *one) for k, one in enumerate(positions)]
    if not lines:
        raise CalibrationError("positions: expected at least six, got 0")
    low, high = max(line.low for line in lines), min(line.high for line in lines)
    if not high - low >= CLOSEST:
        raise CalibrationError(
            f"positions: expected warm-ups over the same temperatures, got {low:.3g} °C as the highest begin and "
            f"{high:.3g} °C as the lowest end"
        )
    ends = [np.array([line.at(end) for line in lines]) for end in (low, high)]
    fits = [_positions.six_positions(list(mean), gravity=gravity) for mean in ends]
    found = two_temperatures(fits[0].calibration, fits[1].calibration, (low, high))
    # Parameters at the ends change with the lines' means and slopes; then lines through the ends.
    offsets = np.array([[end - line.centre for line in lines] for end in (low, high)])
    variances = np.array([[line.mean_variance, line.slope_variance] for line in lines])  # (K, 2, 3)
    slopes = [
        _positions.sensitivity(mean, fit.gain, fit.bias) for mean, fit in zip(ends, fits, strict=True)
    ]  # (6, K, 3) each
    by_mean = np.concatenate([slope.reshape(6, -1) for slope in slopes])
    by_slope = np.concatenate(
        [(slope * offset[:, None]).reshape(6, -1) for slope, offset in zip(slopes, offsets, strict=True)]
    )
    at_ends = (by_mean * variances[:, 0].ravel()) @ by_mean.T + (by_slope * variances[:, 1].ravel()) @ by_slope.T
    through = np.array([[-1.0, 1.0], [high, -low]]) / (high - low)  # slope, value at zero
    transform = np.zeros((12, 12))
    for axis in range(3):
        for part in range(2):  # gain, bias
            for row in range(2):
                transform[6 * part + 3 * row + axis, [3 * part + axis, 6 + 3 * part + axis]] = through[row]
    return TemperatureCalibration(
        found.gain_slope,
        found.gain_at_zero,
        found.bias_slope,
        found.bias_at_zero,
        (low, high),
        transform @ at_ends @ transform.T,
        {"method": f"warm-up in {len(lines)} positions", "gravity": gravity},
    )


def warm_up_gyroscope(
    rest: tuple[ArrayLike, ArrayLike], turns: Sequence[tuple[Turn, ArrayLike]] = ()
) -> TemperatureCalibration:
    """Bias from a warm-up at rest, gains from turns by known angles at several temperatures.

    Parameters
    ----------
    rest : tuple
        Gyr (T, 3) rad/s at rest and temperature (T,) °C while the sensor warms up.
    turns : sequence of tuple, optional
        Each with its temperatures (T,) or its one temperature, °C; about each axis at two
        temperatures or more. None leaves the gains at 1.

    Returns
    -------
    TemperatureCalibration
        The lines.

    Raises
    ------
    CalibrationError
        Too small a range of temperatures; an axis without turns at two temperatures.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> temperature = np.linspace(10.0, 40.0, 300)
    >>> rest = np.repeat(1e-4 * temperature[:, None], 3, axis=1)
    >>> ar.calibration.warm_up_gyroscope((rest, temperature)).bias_slope.round(8)
    array([0.0001, 0.0001, 0.0001])
    """
    bias = _line("rest", *rest)
    gain_slope, gain_at_zero = np.zeros(3), np.ones(3)
    covariance = np.zeros((12, 12))
    at_zero_variance = bias.mean_variance + bias.centre**2 * bias.slope_variance
    for axis in range(3):
        covariance[6 + axis, 6 + axis] = bias.slope_variance[axis]
        covariance[9 + axis, 9 + axis] = at_zero_variance[axis]
        covariance[6 + axis, 9 + axis] = covariance[9 + axis, 6 + axis] = -bias.centre * bias.slope_variance[axis]
    low, high = bias.low, bias.high
    if turns:
        integrals = [turn.integral(f"turns[{k}]") for k, (turn, _) in enumerate(turns)]
        warmth = np.array([float(np.nanmean(np.asarray(t, dtype=np.float64))) for _, t in turns])
        reached = np.array(
            [total - bias.at(one) * duration for (total, duration, _), one in zip(integrals, warmth, strict=True)]
        )
        angles = np.array([turn.vector for turn, _ in turns])
        fit_gain(angles, reached, np.zeros_like(angles), cross_axis=False)  # refuses what is no set of turns
        low, high = min(low, float(warmth.min())), max(high, float(warmth.max()))
        for axis, name in enumerate(AXES):
            about = np.abs(angles[:, axis]) > 0
            if np.ptp(warmth[about]) < CLOSEST:
                raise CalibrationError(
                    f"turns: about {name} they are all at {warmth[about].mean():.3g} °C: turn the sensor at another "
                    "temperature too"
                )
            # reached = (slope T + at_zero) angle
            design = angles[about, axis, None] * np.stack((warmth[about], np.ones(about.sum())), axis=1)
            gain_slope[axis], gain_at_zero[axis] = np.linalg.lstsq(design, reached[about, axis], rcond=None)[0]
            noise = np.array([duration**2 for _, duration, _ in integrals])[about] * bias.mean_variance[axis]
            pseudo = np.linalg.pinv(design)
            both = [axis, 3 + axis]
            covariance[np.ix_(both, both)] = (pseudo * noise) @ pseudo.T
    return TemperatureCalibration(
        gain_slope,
        gain_at_zero,
        bias.slope,
        bias.mean - bias.slope * bias.centre,
        (low, high),
        covariance,
        {"method": f"warm-up at rest and {len(turns)} turns"},
    )


def _line(name: str, x: ArrayLike, temperature: ArrayLike) -> _Line:
    array, valid = readings(name, x)
    warmth = vector(f"{name}: temperature", temperature, len(array))
    used = valid & np.isfinite(warmth)
    rows, warmth = array[used], warmth[used]
    if len(rows) < 3:
        raise CalibrationError(f"{name}: expected readings with temperatures, got {len(rows)}")
    low, high = float(warmth.min()), float(warmth.max())
    if not high - low >= CLOSEST:
        raise CalibrationError(
            f"{name}: expected a warm-up over at least {CLOSEST} °C, got {low:.3g} to {high:.3g} °C: cool it first"
        )
    centre = float(warmth.mean())
    centred = warmth - centre
    power = float(centred @ centred)
    mean = rows.mean(axis=0)
    slope = centred @ rows / power
    rest = rows - mean - np.outer(centred, slope)
    variance = (rest**2).sum(axis=0) / (len(rows) - 2)
    return _Line(centre, mean, slope, variance / len(rows), variance / power, low, high)
