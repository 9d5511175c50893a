"""How late a magnetometer is behind the gyroscope, from their readings alone.

A reading m(t) shows the field of t − τ. With the attitude R that the gyroscope gives over a short window, R(t − τ) m(t)
is the field in a frame that stands still: it is constant at the right τ, and goes to and fro with the rate of rotation
at any other, as its derivative by τ is −R (ω × m). What else makes it vary is estimated beside τ, in linear least
squares:

- a field that wanders: a constant and a slope in every window;
- hard iron h, seen as R h, and soft iron A, as R A Rᵀ B;
- the gyroscope's bias and matrix (scale, misalignment), by the attitude error θ that they leave: as B × θ with
  θ = ∫ R (δb + δM ω) dt. The error of the scale grows with the angle of a turn, that of τ with its rate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _native
from ahrs_rs._recording import Recording
from ahrs_rs._slerp import Attitudes
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration._common import CalibrationError, readings

__all__ = ["MagDelay", "mag_delay"]

#: Standard deviations of what is unknown before: a step of τ in s; hard iron and the elements of soft iron relative to
#: the field; gyroscope bias in rad/s and elements of its matrix. All are wider than sensors that are calibrated need.
PRIOR = np.array([0.1] + [0.3] * 3 + [0.05] * 9 + [0.03] * 3 + [0.03] * 9)
#: Readings closer to each other than this, s, are taken to have one error.
CORRELATION = 0.05
#: Windows with a mean square residual of so many times the median count half.
TAIL = 4.0
#: Windows are left out one part of so many after the other for the standard error.
PARTS = 20
FEWEST_WINDOWS = 10
FEWEST_READINGS = 8
#: Windows that are computed at a time.
CHUNK = 64
#: Residual, relative to the field, from which on the readings do not belong together.
LARGEST_RESIDUAL = 0.25
#: Larger delays are none of a sensor, s.
LONGEST = 0.5
#: Changes of the angular rate that count as motion, rad/s: what changes less may be the gyroscope's noise.
SLOWEST = 0.03
ADVICE = "turn the sensor quickly to and fro, about twice a second, about two axes, for half a minute"


@dataclass(frozen=True, slots=True, eq=False)
class MagDelay:
    """How late the magnetometer's readings are.

    Parameters
    ----------
    delay : float
        S; negative where the gyroscope's readings are late. The parameter `mag_delay` of the
        filters that have it.
    standard_error : float
        S.
    windows : int
        How many windows of the recording were used.
    residual : float
        What the field varies by beyond all that was estimated (median of the windows' RMS),
        relative to its norm.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=60.0, noise=False)
    >>> found = ar.calibration.mag_delay(rec)
    >>> abs(found.delay) < 0.005
    True
    """

    delay: float
    standard_error: float
    windows: int
    residual: float

    def summary(self) -> str:
        """The delay for reading.

        Returns
        -------
        str
            Several lines.
        """
        return (
            f"delay      {1e3 * self.delay:.2f} ± {1e3 * self.standard_error:.2f} ms behind the gyroscope\n"
            f"windows    {self.windows}, in which the field varies by {100 * self.residual:.2g} %"
        )


def mag_delay(recording: Recording, *, window: float = 1.0, largest_error: float = 0.005) -> MagDelay:
    """Estimate how late the magnetometer is behind the gyroscope.

    No reference and no accelerometer are needed, and the magnetometer need not be calibrated. Rows of the magnetometer
    without a reading (a slower one) do not count.

    Parameters
    ----------
    recording : Recording
        With gyroscope and magnetometer, in motion.
    window : float, optional
        s. Over one the field may have any value and slope.
    largest_error : float, optional
        S; a larger standard error is an error.

    Returns
    -------
    MagDelay
        The delay, with its standard error.

    Raises
    ------
    CalibrationError
        Too few readings, or motion that does not determine the delay; the message says what to record.

    Notes
    -----
    Windows that vary more than others count less (Student's t). The standard error is that of the estimates without one
    twentieth of the recording after the other (jackknife), or that of the residuals as noise of 50 ms' correlation,
    whichever is larger. Filters take the rate of the sample for that over the delay; here R(t − τ) is interpolated.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=60.0, noise=False)
    >>> abs(ar.calibration.mag_delay(rec).delay) < 0.005
    True
    """
    positive("window", window)
    positive("largest_error", largest_error)
    if recording.mag is None:
        raise CalibrationError("mag: the recording has no magnetometer")
    sums = _Windows(recording, window)
    delay, normal, found = 0.0, np.zeros((0, 0)), np.zeros(0)
    for _ in range(20):
        sums.compute(delay)
        weight, unit = sums.weights()
        normal = np.tensordot(weight, sums.normal, 1) + np.diag(unit / PRIOR**2)
        found = np.linalg.solve(normal, weight @ sums.right)
        delay += float(found[0])
        if abs(delay) > LONGEST:
            raise CalibrationError(
                f"mag: no delay within {LONGEST:g} s fits: is the magnetometer's frame the gyroscope's? Or {ADVICE}"
            )
        if abs(found[0]) < 1e-5:
            break
    changes = float(np.sqrt(weight @ sums.normal[:, 0, 0] / (weight @ sums.count)))
    if changes < SLOWEST:
        raise CalibrationError(f"mag: the angular rate changes by {changes:.2g} rad/s (RMS) only: {ADVICE}")
    residual = float(np.sqrt(np.median(sums.mean_squares(found))))
    error = max(_left_out(sums, weight, unit), float(np.sqrt(np.linalg.inv(normal)[0, 0] * unit)))
    if error > largest_error:
        raise CalibrationError(f"mag: the delay would be known to ±{1e3 * error:.2g} ms only: {ADVICE}")
    if residual > LARGEST_RESIDUAL:
        raise CalibrationError(
            f"mag: the field varies by {100 * residual:.0f} % in the frame of the gyroscope: is it the magnetometer of "
            "this sensor, in the same axes?"
        )
    return MagDelay(delay, error, len(sums.starts), residual)


def _left_out(sums: _Windows, weight: FloatArray, unit: float) -> float:
    """The jackknife's standard error over contiguous parts."""
    parts = np.array_split(np.arange(len(weight)), min(PARTS, len(weight)))
    normals = np.stack([np.tensordot(weight[part], sums.normal[part], 1) for part in parts])
    rights = np.stack([weight[part] @ sums.right[part] for part in parts])
    without = normals.sum(axis=0) - normals + np.diag(unit / PRIOR**2)
    estimates = np.linalg.solve(without, (rights.sum(axis=0) - rights)[..., np.newaxis])[:, 0, 0]
    count = len(parts)
    return float(np.sqrt((count - 1) / count * np.sum((estimates - estimates.mean()) ** 2)))


class _Windows:
    """The recording's windows, and the sums of each that a linear least squares fit needs."""

    def __init__(self, recording: Recording, window: float) -> None:
        from ahrs_rs.filters import FILTERS

        gyr, _ = readings("gyr", recording.require("gyr"))
        mag, there = readings("mag", recording.mag if recording.mag is not None else np.zeros((0, 3)))
        self.length = max(round(window * recording.rate), FEWEST_READINGS)
        count = len(gyr) // self.length
        starts = np.arange(count) * self.length
        enough = np.add.reduceat(there[: count * self.length], starts) >= FEWEST_READINGS if count else starts > 0
        self.starts: NDArray[np.intp] = starts[enough]
        if len(self.starts) < FEWEST_WINDOWS:
            raise CalibrationError(
                f"mag: expected at least {FEWEST_WINDOWS} windows of {window:g} s with {FEWEST_READINGS} readings, got "
                f"{len(self.starts)}: {ADVICE}"
            )
        norm = float(np.median(np.linalg.norm(mag[there], axis=1)))
        if not norm > 0.0:
            raise CalibrationError("mag: the field is zero")
        integrated = FILTERS["GyroIntegration"](rate=recording.rate).run(gyr, t=recording.t)
        self.attitudes = Attitudes(np.asarray(integrated.quat), recording.t)
        self.t, self.there, self.mag = recording.t, there, np.where(there[:, np.newaxis], mag / norm, 0.0)
        rate = np.where(np.isnan(gyr), 0.0, gyr)
        self.steps = np.diff(recording.t, prepend=recording.t[0])
        self.turns = rate * self.steps[:, np.newaxis]

    def compute(self, delay: float) -> None:
        """Sums about a delay, s."""
        chunks = [self._sums(self.starts[i : i + CHUNK], delay) for i in range(0, len(self.starts), CHUNK)]
        #: (W, P, P), (W, P), (W,): squares of the columns, their products with the field, squares of the field.
        self.normal, self.right, self.squares = (
            np.concatenate(one) for one in zip(*(c[:3] for c in chunks), strict=True)
        )
        self.count = np.concatenate([chunk[3] for chunk in chunks])

    def mean_squares(self, found: FloatArray) -> FloatArray:
        """(W,) of the residuals, per axis and reading."""
        rest = self.squares - 2.0 * self.right @ found + np.einsum("p,wpq,q->w", found, self.normal, found)
        mean: FloatArray = np.maximum(rest, 0.0) / (3.0 * self.count)
        return mean

    def weights(self) -> tuple[FloatArray, float]:
        """(W,) weights of the windows, and the variance of a reading as if its error were alone."""
        weight = np.ones(len(self.starts))
        apart = float(np.median(np.diff(self.t)))
        together = max(CORRELATION / apart, 1.0) if apart > 0.0 else 1.0
        typical = float(np.median(self.squares / (3.0 * self.count)))
        for _ in range(8):
            unit = max(typical, 1e-12) * together
            normal = np.tensordot(weight, self.normal, 1) + np.diag(unit / PRIOR**2)
            squares = self.mean_squares(np.linalg.solve(normal, weight @ self.right))
            typical = float(np.median(squares))
            weight = 1.0 / (1.0 + squares / (TAIL * max(typical, 1e-12)))
        return weight, max(typical, 1e-12) * together

    def _sums(self, starts: NDArray[np.intp], delay: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        index = starts[:, np.newaxis] + np.arange(self.length)
        shape = index.shape
        t, m = self.t[index], self.mag[index]
        quat, rate = self.attitudes.at((t - delay).ravel())
        known = self.there[index] & ~np.isnan(quat).any(axis=1).reshape(shape)
        # A window stands in its own frame.
        quat = np.where(np.isnan(quat), 0.0, quat).reshape(*shape, 4)
        rate = rate.reshape(*shape, 3)
        r = _native.rotation_matrices(quat)
        y = np.einsum("wnij,wnj->wni", r, m)
        count = np.maximum(known.sum(axis=1), 1).astype(np.float64)
        field = np.where(known[..., np.newaxis], y, 0.0).sum(axis=1) / count[:, np.newaxis]
        seen = np.einsum("wnji,wj->wni", r, field)  # the field in the sensor frame
        r_now = _native.rotation_matrices(self.attitudes.quat[index])
        theta = np.concatenate(
            (
                r_now * self.steps[index][..., np.newaxis, np.newaxis],
                (r_now[..., np.newaxis] * self.turns[index][:, :, np.newaxis, np.newaxis, :]).reshape(*shape, 3, 9),
            ),
            axis=-1,
        ).cumsum(axis=1)
        columns = np.concatenate(
            (
                np.einsum("wnij,wnj->wni", r, np.cross(rate, m))[..., np.newaxis],
                r,
                (r[..., np.newaxis] * seen[:, :, np.newaxis, np.newaxis, :]).reshape(*shape, 3, 9),
                np.cross(field[:, np.newaxis, np.newaxis, :], theta.swapaxes(-1, -2)).swapaxes(-1, -2),
            ),
            axis=-1,
        )
        both = np.concatenate((columns, y[..., np.newaxis]), axis=-1).reshape(*shape, -1)
        both = _without_line(both, t, known, count)
        both = both.reshape(len(starts), 3 * self.length, -1)
        sums = both.swapaxes(1, 2) @ both
        return sums[:, :-1, :-1], sums[:, :-1, -1], sums[:, -1, -1], count


def _without_line(values: FloatArray, t: FloatArray, known: NDArray[np.bool_], count: FloatArray) -> FloatArray:
    """The values (w, n, c) without their means and slopes over the known rows of each window; zero in the others."""
    weight = known.astype(np.float64)
    middle = (weight * t).sum(axis=1) / count
    slope = weight * (t - middle[:, np.newaxis])
    length = np.sqrt((slope**2).sum(axis=1))
    basis = np.stack(
        (weight / np.sqrt(count)[:, np.newaxis], slope / np.where(length > 0.0, length, 1.0)[:, np.newaxis]), axis=1
    )
    values = values * weight[..., np.newaxis]
    rest: FloatArray = values - basis.swapaxes(1, 2) @ (basis @ values)
    return rest
