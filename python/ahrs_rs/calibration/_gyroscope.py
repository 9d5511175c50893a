"""Gyroscopes: bias at rest, gain against turns by known angles or against a reference orientation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _html, _quat
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration._common import AXES, CalibrationError, readings
from ahrs_rs.calibration._model import Calibration
from ahrs_rs.calibration._turns import WORST_CONDITION, Turn, doubt, fit_gain, steps, turns_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes


__all__ = ["GyroscopeFit", "gyroscope", "gyroscope_from_reference"]

#: Nothing that is called a rest turns faster, rad/s: uncalibrated biases are up to 20 °/s.
FASTEST_REST = 0.5
#: Windows farther from the reference than so many robust standard deviations are left out.
CUT = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class GyroscopeFit:
    """x = G y + b, so that y = S (x − b) with S = G⁻¹.

    Parameters
    ----------
    calibration : Calibration
        S and b.
    gain : ndarray
        (3, 3) G; diagonal unless cross axes were asked for.
    bias : ndarray
        (3,) rad/s.
    gain_std : ndarray
        (3, 3) standard deviations, by the noise at rest as white noise; NaN of an axis that no turn
        is about.
    bias_std : ndarray
        (3,) rad/s.
    residual : ndarray
        (K, 3) rad: what the calibrated turns lack; or (1, 3), the RMS over the windows of a
        reference.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> fit = ar.calibration.gyroscope(np.full((500, 3), 0.01))
    >>> fit.bias
    array([0.01, 0.01, 0.01])
    """

    calibration: Calibration
    gain: FloatArray
    bias: FloatArray
    gain_std: FloatArray
    bias_std: FloatArray
    residual: FloatArray

    def _repr_html_(self) -> str:
        gain, std = np.diag(self.gain), np.diag(self.gain_std)
        rows = [
            (axis, f"gain {gain[k]:.6g} ± {std[k]:.2g}, bias {self.bias[k]:.5g} ± {self.bias_std[k]:.2g} rad/s")
            for k, axis in enumerate("xyz")
        ]
        return _html.summary("Fit of a gyroscope", rows)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw what the calibrated turns lack, in degrees, for each turn and axis.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default on a new figure.

        Returns
        -------
        Axes
            With three bars for each turn.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        """
        from ahrs_rs import plots  # for drawing only

        return plots.turns(self, ax=ax)


def gyroscope(rest: ArrayLike, turns: Sequence[Turn] = (), *, cross_axis: bool = False) -> GyroscopeFit:
    """Bias of a gyroscope at rest, and gains from turns by known angles (Hyyti & Visala 2015, section 3.4).

    Parameters
    ----------
    rest : array_like
        (T, 3) rad/s, readings at rest.
    turns : sequence of Turn, optional
        From rest to rest, in their order. The gain of an axis that no turn is about stays at 1, with
        a warning; none leaves all of them at 1.
    cross_axis : bool, optional
        Estimate all of G (scale, misalignment) instead of a gain for each axis.

    Returns
    -------
    GyroscopeFit
        The calibration, with its standard deviations.

    Raises
    ------
    CalibrationError
        Readings at rest that turn; a turn that is about another axis, or in the other direction, than
        is told; turns about one axis that disagree; with `cross_axis` turns that do not reach all
        axes.
    ValueError
        Angles that are off by more than a factor of 2: another unit.

    Warns
    -----
    CalibrationWarning
        An axis without a turn; a gain that is farther from 1 than that of any gyroscope.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> rates = {name: np.tile(axis, (101, 1)) for name, axis in zip("xyz", np.eye(3))}
    >>> turns = [ar.calibration.Turn(gyr, name, 1.01, rate=100.0) for name, gyr in rates.items()]
    >>> ar.calibration.gyroscope(np.zeros((500, 3)), turns).gain.round(6)
    array([[0.990099, 0.      , 0.      ],
           [0.      , 0.990099, 0.      ],
           [0.      , 0.      , 0.990099]])
    """
    array, valid = readings("rest", rest)
    still = array[valid]
    if len(still) < 2:
        raise CalibrationError(f"rest: expected readings at rest, got {len(still)}: let the sensor lie still")
    bias, spread = still.mean(axis=0), still.std(axis=0, ddof=1)
    _check_rest(bias, spread)
    variance = spread**2 / len(still)
    gain, gain_std, residual = np.eye(3), np.zeros((3, 3)), np.zeros((0, 3))
    turns = turns_of(turns)
    if turns:
        integrals = [turn.integral(f"turns[{k}]") for k, turn in enumerate(turns)]
        reached = np.array([total - bias * duration for total, duration, _ in integrals])
        angles = np.array([turn.vector for turn in turns])
        noise = np.array([spread**2 * square + variance * duration**2 for _, duration, square in integrals])
        gain, gain_std = fit_gain(angles, reached, noise, cross_axis, some=not cross_axis)
        residual = reached @ np.linalg.inv(gain).T - angles
        doubt(gain, gain_std)
    info = {
        "method": f"rest and {len(turns)} turns" if turns else "rest",
        "bias_std": np.sqrt(variance).tolist(),
        "gain_std": [[None if math.isnan(one) else one for one in row] for row in gain_std.tolist()],
    }
    inverse = np.linalg.inv(gain).astype(np.float64, copy=False)
    calibration = Calibration(inverse, bias, info)
    return GyroscopeFit(calibration, gain, bias, gain_std, np.sqrt(variance), residual)


def gyroscope_from_reference(
    gyr: ArrayLike,
    ref: ArrayLike,
    *,
    rate: float | None = None,
    t: ArrayLike | None = None,
    window: float = 0.5,
) -> GyroscopeFit:
    """Gain and bias of each axis, so that the integrated readings give the rotations of a reference.

    Over windows of the recording the rotation of the reference, q(start)* ⊗ q(end), is compared with the integral of
    the calibrated readings (exponential map); Gauss-Newton on the six parameters, windows farther off than four robust
    standard deviations (a reference that is lost) left out.

    Parameters
    ----------
    gyr : array_like
        (T, 3) rad/s; gyr[k] holds over (t[k-1], t[k]].
    ref : array_like
        (T, 4) orientations of this sensor's frame, scalar-first, to any fixed frame; NaN where
        unknown.
    rate : float, optional
        Hz; or t : (T,) s.
    t : array_like, optional
        (T,) stamps in s, in place of the rate.
    window : float, optional
        s. Long windows tell more about the bias, short ones forgive a lost reference.

    Returns
    -------
    GyroscopeFit
        The calibration, with its standard deviations.

    Raises
    ------
    CalibrationError
        Too few windows, or too little turning about an axis; a reference of another frame than the sensor's.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=20.0, noise=False)
    >>> ar.calibration.gyroscope_from_reference(rec.gyr, rec.ref, rate=100.0).gain.round(2)
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    array, _ = readings("gyr", gyr)
    quat = np.asarray(ref, dtype=np.float64)
    if quat.shape != (len(array), 4):
        raise ValueError(f"ref: expected shape ({len(array)}, 4), got {quat.shape}")
    dt = steps(len(array), rate, t)
    length = max(round(positive("window", window) / float(np.median(dt[dt > 0]))), 1) if (dt > 0).any() else 1
    count = len(dt) // length
    x = array[1 : 1 + count * length].reshape(count, length, 3)
    step = dt[: count * length].reshape(count, length)
    ends = quat[: 1 + count * length : length]
    good = ~np.isnan(x).any(axis=(1, 2)) & ~np.isnan(ends[:-1]).any(axis=1) & ~np.isnan(ends[1:]).any(axis=1)
    if np.count_nonzero(good) < 10:
        raise CalibrationError(
            f"gyr: expected at least 10 windows of {window:g} s with a reference, got {np.count_nonzero(good)}"
        )
    ends = ends / np.linalg.norm(ends, axis=1, keepdims=True)
    target = _quat.multiply(_quat.conjugate(ends[:-1]), ends[1:])[good]
    x, step = x[good], step[good]

    s, b = np.ones(3), np.zeros(3)
    keep = np.ones(len(x), dtype=np.bool_)
    for _ in range(20):
        error, jacobian = _windows_error(x, step, target, s, b)
        size = np.linalg.norm(error, axis=1)
        keep = size <= max(CUT * 1.4826 * float(np.median(size)), 1e-9)
        j = jacobian[keep].reshape(-1, 6)
        gram = j.T @ j
        scale = np.sqrt(np.diag(gram))
        if not (scale > 0).all() or np.linalg.cond(gram / np.outer(scale, scale)) > WORST_CONDITION:
            raise CalibrationError("gyr: too little turning for gains: turn the sensor about each of its axes")
        change = np.linalg.solve(gram, j.T @ error[keep].ravel())
        s, b = s + change[:3], b + change[3:]
        if not ((s > 0.5) & (s < 2.0)).all():
            raise CalibrationError(
                "ref: does not turn as the sensor does: is it of the sensor's own frame, and gyr in rad/s?"
            )
        if float(np.abs(change).max()) < 1e-12:
            break
    freedom = max(error[keep].size - 6, 1)
    covariance = np.linalg.inv(gram) * (float((error[keep] ** 2).sum()) / freedom)
    std = np.sqrt(np.diag(covariance))
    if std[:3].max() > 0.1:
        raise CalibrationError(
            f"gyr: the gain of {AXES[int(np.argmax(std[:3]))]} would be known to {std[:3].max():.0%} only: "
            "turn the sensor about each of its axes"
        )
    rms = np.sqrt((error[keep] ** 2).mean(axis=0, keepdims=True))
    info = {
        "method": f"reference, {int(keep.sum())} windows of {window:g} s",
        "scale_std": std[:3].tolist(),
        "bias_std": std[3:].tolist(),
    }
    # d(1/s) = ds/s²
    return GyroscopeFit(Calibration(np.diag(s), b, info), np.diag(1 / s), b, np.diag(std[:3] / s**2), std[3:], rms)


def _windows_error(
    x: FloatArray, dt: FloatArray, target: FloatArray, s: FloatArray, b: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(w, 3) rotation vectors from the integrals to the targets, in the sensor frame at the end; (w, 3, 6) slopes."""
    after = np.zeros((len(x), 4))
    after[:, 0] = 1.0
    jacobian = np.zeros((len(x), 3, 6))
    for k in range(x.shape[1] - 1, -1, -1):
        centred = x[:, k] - b
        h = dt[:, k, None]
        # The change of this step, turned into the frame of the end: exp(a + da) = exp(a) exp(da) to first order.
        for axis, unit in enumerate(np.eye(3)):
            turned = _quat.rotate(_quat.conjugate(after), np.broadcast_to(unit, centred.shape)) * h
            jacobian[:, :, axis] += turned * centred[:, axis, None]
            jacobian[:, :, 3 + axis] -= turned * s[axis]
        after = _quat.multiply(_quat.exp(s * centred * h), after)
    return _quat.log(_quat.multiply(_quat.conjugate(after), target)), jacobian


def _check_rest(bias: FloatArray, spread: FloatArray) -> None:
    if float(np.abs(bias).max()) > FASTEST_REST:
        raise CalibrationError(
            f"rest: turns by {float(np.abs(bias).max()):.3g} rad/s: let the sensor lie still (or are these °/s?)"
        )
    if float(spread.max()) > FASTEST_REST:
        raise CalibrationError(f"rest: varies by {float(spread.max()):.3g} rad/s: let the sensor lie still")
