"""Accelerometers in six positions, without accurate references (Won & Golnaraghi 2010)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _arrays, _html
from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration import _windows
from ahrs_rs.calibration._common import AXES, CalibrationError, readings, several
from ahrs_rs.calibration._model import Calibration

if TYPE_CHECKING:
    from matplotlib.axes import Axes


__all__ = ["PositionsFit", "held_attitudes", "six_positions"]

#: A step of gains and of biases over gravity below this ends the iteration.
CONVERGED = 1e-13
ITERATIONS = 50
#: Positions whose equations are closer to singular than this tell too little: errors grow by its inverse.
WORST_CONDITION = 1e3


@dataclass(frozen=True, slots=True, eq=False)
class PositionsFit:
    """Gain and bias of each axis, x = gain y + bias, so that y = S (x − b) with S = diag(1 / gain), b = bias.

    Parameters
    ----------
    calibration : Calibration
        S and b.
    gain : ndarray
        (3,) of each axis.
    bias : ndarray
        (3,) of each axis, m/s².
    covariance : ndarray, optional
        (6, 6) of gain and bias, by the spread within the positions as white noise; None where one
        is one reading.
    residual : ndarray
        (K,) norm of each calibrated position less gravity, m/s²; with six it is rounding.
    iterations : int
        Of Newton's method.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> held = [sign * 9.80665 * np.eye(3)[axis][None] for axis in range(3) for sign in (1, -1)]
    >>> fit = ar.calibration.six_positions(held)
    >>> fit.gain.round(6)
    array([1., 1., 1.])
    """

    calibration: Calibration
    gain: FloatArray
    bias: FloatArray
    covariance: FloatArray | None
    residual: FloatArray
    iterations: int

    def _repr_html_(self) -> str:
        rows = [
            (f"{axis}", f"gain {gain:.6g}, bias {bias:.5g} m/s²")
            for axis, gain, bias in zip("xyz", self.gain, self.bias, strict=True)
        ]
        return _html.summary("Fit of held positions", rows)

    def plot(self, readings: Sequence[ArrayLike], *, gravity: float = GRAVITY, ax: Axes | None = None) -> Axes:
        """Draw the norm of each position, before and after, beside gravity.

        Parameters
        ----------
        readings : sequence of array_like
            The positions that it was fitted to: for each (n, 3) or (3,), m/s².
        gravity : float, optional
            Of the place, m/s².
        ax : Axes, optional
            Where to draw; by default on a new figure.

        Returns
        -------
        Axes
            With two points for each position.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        """
        from ahrs_rs import plots  # for drawing only

        return plots.positions(self, readings, gravity=gravity, ax=ax)


def six_positions(positions: Sequence[ArrayLike], *, gravity: float = GRAVITY) -> PositionsFit:
    """Gain and bias of an accelerometer held still in six different positions (or more).

    Six equations Σ ((mᵢ − bᵢ) / gᵢ)² = gravity² of the mean readings m for six unknowns, solved by Newton's iteration
    from gain 1 and bias 0 (Won & Golnaraghi, IEEE Trans. Instrumentation and Measurement 59(8), 2010). The positions
    need not be known, only differ: each axis up and down is best. More than six are taken by least squares.

    Parameters
    ----------
    positions : sequence of array_like
        For each the readings (n, 3) or their mean (3,), m/s².
    gravity : float, optional
        Local gravity, m/s².

    Returns
    -------
    PositionsFit
        The calibration, with its covariance.

    Raises
    ------
    CalibrationError
        Fewer than six positions, or ones that do not determine gains and biases.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> held = [sign * 9.80665 * np.eye(3)[axis][None] + 0.1 for axis in range(3) for sign in (1, -1)]
    >>> ar.calibration.six_positions(held).bias.round(6)
    array([0.1, 0.1, 0.1])
    """
    gravity = positive("gravity", gravity)
    mean, variance = _means(positions)
    ratio = float(np.median(np.linalg.norm(mean, axis=1))) / gravity
    if not 0.5 <= ratio <= 2.0:
        unit = f": are they in g (times {GRAVITY})?" if 0.5 <= ratio * gravity <= 2.0 else ""
        raise ValueError(f"positions: expected readings of about {gravity:.4g} m/s², got {ratio * gravity:.3g}{unit}")
    gain, bias, iterations = solve(mean, gravity)
    jacobian = _jacobian(mean, gain, bias)
    covariance = None
    if variance is not None:
        pseudo = np.linalg.pinv(jacobian)
        slope = 2.0 * (mean - bias) / gain**2  # of each equation with its own mean
        covariance = (pseudo * np.einsum("ki,kij,kj->k", slope, variance, slope)) @ pseudo.T
    residual = np.linalg.norm((mean - bias) / gain, axis=1) - gravity
    info = {"method": f"{len(mean)} positions", "gravity": gravity}
    return PositionsFit(Calibration(np.diag(1.0 / gain), bias, info), gain, bias, covariance, residual, iterations)


def held_attitudes(
    acc: ArrayLike, rate: float, *, window: float = 0.25, hold: float = 1.0, apart: float = 1.0
) -> list[slice]:
    """The samples of each attitude in which the sensor was held still, for `six_positions`.

    Parameters
    ----------
    acc : array_like
        (T, 3) m/s².
    rate : float
        Hz.
    window : float, optional
        S; windows vary at rest no more than three times as much as the quietest tenth of them.
    hold : float, optional
        The shortest time in one attitude, s.
    apart : float, optional
        Attitudes differ by so much, m/s².

    Returns
    -------
    list of slice
        The samples of each attitude.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> acc = np.repeat([[0.0, 0.0, 9.8], [9.8, 0.0, 0.0]], 500, axis=0)
    >>> len(ar.calibration.held_attitudes(acc, 100.0))
    2
    """
    return _windows.attitudes(readings("acc", acc)[0], rate, window, positive("hold", hold), positive("apart", apart))


def solve(mean: FloatArray, gravity: float) -> tuple[FloatArray, FloatArray, int]:
    """Gain and bias from the mean readings (K, 3), and the iterations that it took."""
    gain, bias = np.ones(3), np.zeros(3)
    for iteration in range(1, ITERATIONS + 1):
        jacobian = _jacobian(mean, gain, bias)
        # In units of gravity all unknowns are near one.
        scaled = jacobian * np.array([1.0, 1.0, 1.0, gravity, gravity, gravity]) / gravity**2
        values = np.linalg.svd(scaled, compute_uv=False)
        if values[-1] * WORST_CONDITION < values[0]:
            raise CalibrationError(_lacking(mean))
        error = (((mean - bias) / gain) ** 2).sum(axis=1) - gravity**2
        step = np.linalg.lstsq(scaled, error / gravity**2, rcond=None)[0]
        gain, bias = gain - step[:3], bias - gravity * step[3:]
        if not (np.isfinite(gain).all() and (gain > 0.1).all() and (gain < 10.0).all()):
            raise CalibrationError(_lacking(mean))
        if float(np.abs(step).max()) < CONVERGED * max(1.0, float(np.abs(bias).max()) / gravity):
            return gain, bias, iteration
        if iteration > 5 and float(np.abs(step).max()) < 1e3 * CONVERGED:
            return gain, bias, iteration  # rounding keeps it from going on
    raise CalibrationError(_lacking(mean))


def _jacobian(mean: FloatArray, gain: FloatArray, bias: FloatArray) -> FloatArray:
    """(K, 6) of the equations with gains and biases."""
    centred = mean - bias
    return np.concatenate((-2.0 * centred**2 / gain**3, -2.0 * centred / gain**2), axis=1)


def sensitivity(mean: FloatArray, gain: FloatArray, bias: FloatArray) -> FloatArray:
    """(6, K, 3): the change of gains and biases with the mean readings."""
    slope = 2.0 * (mean - bias) / gain**2
    change: FloatArray = -np.linalg.pinv(_jacobian(mean, gain, bias))[:, :, None] * slope
    return change


def _means(positions: Sequence[ArrayLike]) -> tuple[FloatArray, FloatArray | None]:
    """(K, 3) means and (K, 3, 3) their covariances."""
    positions = several("positions", positions, "readings (n, 3) or (3,) of each position")
    if len(positions) < 6:
        raise CalibrationError(
            f"positions: expected at least six, got {len(positions)}: hold the sensor still with each axis up and down"
        )
    means, variances = [], []
    for k, position in enumerate(positions):
        array, valid = readings(
            f"positions[{k}]", np.atleast_2d(np.asarray(_arrays.vectors(f"positions[{k}]", position)))
        )
        rows = array[valid]
        if not len(rows):
            raise CalibrationError(f"positions[{k}]: expected readings, got NaN only")
        means.append(rows.mean(axis=0))
        variances.append(np.cov(rows.T) / len(rows) if len(rows) > 1 else None)
    known = [one for one in variances if one is not None]
    return np.array(means), np.array(known) if len(known) == len(means) else None


def _lacking(mean: FloatArray) -> str:
    """Which positions are missing."""
    direction = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    missing = [
        f"{axis} {word}"
        for k, axis in enumerate(AXES)
        for word, side in (("up", 1.0), ("down", -1.0))
        if (side * direction[:, k]).max() < np.cos(np.pi / 4)
    ]
    what = f"there is none with {', '.join(missing)}" if missing else "two of them are too much alike"
    return f"positions: these do not determine gains and biases: {what}; hold the sensor with each axis up and down"
