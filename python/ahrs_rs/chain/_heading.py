"""The heading of one sensor against another, from what the joint between them cannot do.

Over a window of time the joint says how likely every heading is; from window to window the heading wanders (gyroscope
biases), about a steady drift. That is a hidden Markov chain on the circle. Its two passes are computed on a grid (a
point-mass smoother), so that headings of which several fit, or whole ranges do, are what they are until the motion
decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.chain._common import Attitudes, clock, pair
from ahrs_rs.chain._joints import Joint
from ahrs_rs.rotation import unwrap

__all__ = ["HeadingCorrection", "correct_heading"]

#: Headings of the grid: so many to a standard deviation, and the fewest and most on the circle.
PER_DEVIATION, FEWEST, MOST = 2.0, 256, 4096
#: Steady drifts that are tried, rad/s, and the standard deviation of what is expected before.
DRIFTS = np.radians(np.linspace(-2.0, 2.0, 41))
STEADY = math.radians(0.5)
#: Drifts of a smaller probability do not count.
NEGLIGIBLE = 1e-3
#: Probability of a heading that the joint excludes, of the largest one: windows may be wrong.
LEAST = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class HeadingCorrection:
    """By how much the second sensor is to be turned about the vertical.

    Parameters
    ----------
    delta : ndarray
        (T,) rad, without jumps: the corrected attitude is Rz(delta) ⊗ second.
    std : ndarray
        (T,) standard deviation, rad: large where the motion so far and later leaves the heading open.
    quat : ndarray
        (T, 4) the corrected attitudes of the second sensor, in the earth frame of the first.
    residual : float
        RMS of the angles by which the corrected attitudes contradict the joint, rad.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> still = np.tile([1.0, 0.0, 0.0, 0.0], (300, 1))
    >>> turned = ar.rotation.product(ar.rotation.about_axis("z", 0.5), still)
    >>> hinge = ar.chain.Hinge([1.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    >>> found = ar.chain.correct_heading(still, turned, hinge, rate=100.0)
    >>> float(found.delta[0].round(6))
    -0.5
    """

    delta: FloatArray
    std: FloatArray
    quat: FloatArray = field(repr=False)
    residual: float = 0.0

    def __repr__(self) -> str:
        return f"HeadingCorrection(delta{self.delta.shape}, residual={math.degrees(self.residual):.3g}°)"


def correct_heading(
    first: Attitudes,
    second: Attitudes,
    joint: Joint,
    *,
    t: ArrayLike | None = None,
    rate: float | None = None,
    window: float = 1.0,
    error: float = math.radians(5.0),
    drift: float = math.radians(0.5),
) -> HeadingCorrection:
    """The heading of the second sensor in the earth frame of the first, without a magnetometer.

    Parameters
    ----------
    first : Estimate or array_like
        Of the first sensor, or its attitudes (T, 4).
    second : Estimate or array_like
        Of the second sensor, at the same times. Rows with a NaN in either say nothing.
    joint : Joint
        `Hinge`, `Universal` or `Ball`, between the segments.
    t : array_like, optional
        (T,) times in s; by default those of `first`, if it is an estimate.
    rate : float, optional
        Hz, for attitudes without stamps.
    window : float, optional
        S over which the error of the joint is taken to be the same: a window counts as one measurement.
    error : float, optional
        Standard deviation of that, rad: soft tissue, axes, and inclinations.
    drift : float, optional
        By how much the heading wanders, rad in a second (and √n times that in n seconds), about a steady drift that
        is found, too (up to 2°/s).

    Returns
    -------
    HeadingCorrection
        Heading, uncertainty, and the corrected attitudes. Before the first and after the last window the heading is
        that of the nearest one.

    Raises
    ------
    ValueError
        Shapes, times or frames that differ, no time, numbers that are not positive, or no row that says something.

    Notes
    -----
    The constraints of joints of one, two and three degrees of freedom are those of Laidig et al. (ICORR 2017, EMBC
    2019) and Lehmann et al. (IFAC 2020), as `Hinge`, `Universal` and `Ball` say. They filter the heading of each window
    forward, with ratings; here all windows, before and after, are weighed by probabilities, so that there is no lag.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> still = np.tile([1.0, 0.0, 0.0, 0.0], (300, 1))
    >>> turned = ar.rotation.product(ar.rotation.about_axis("z", 0.5), still)
    >>> hinge = ar.chain.Hinge([1.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    >>> ar.chain.correct_heading(still, turned, hinge, rate=100.0)
    HeadingCorrection(delta(300,), residual=0°)
    """
    if not callable(getattr(joint, "square_error", None)):
        raise ValueError(f"joint: expected a Hinge, Universal or Ball (or a class with square_error), got {joint!r}")
    p, q = pair(first, second)
    if p.ndim != 2:
        raise ValueError(f"first: expected shape (T, 4), got {p.shape}")
    times = clock(first, t, rate, len(p))
    width, deviation, wander = positive("window", window), positive("error", error), positive("drift", drift)
    known = ~np.isnan(p[:, 0] + q[:, 0])
    if not known.any():
        raise ValueError("first, second: expected a row in which both have an attitude, got none")
    index = np.floor((times - times[0]) / width).astype(np.intp)
    grid = _grid(deviation, wander * math.sqrt(width))
    order = np.flatnonzero(known)
    starts = np.flatnonzero(np.diff(index[order], prepend=-1))
    windows = np.split(order, starts[1:])
    square = np.stack([joint.square_error(p[rows], q[rows], grid) for rows in windows])
    middle = np.array([times[rows].mean() for rows in windows])
    mean = _smoothed(-0.5 * square / deviation**2, middle, wander) @ np.exp(1j * grid)
    delta = np.asarray(unwrap(np.angle(mean)), dtype=np.float64)
    # Of a wrapped normal distribution |mean| = exp(-σ²/2); a uniform one has π/√3 by convention.
    std = np.minimum(np.sqrt(-2.0 * np.log(np.clip(np.abs(mean), 1e-300, 1.0))), math.pi / math.sqrt(3.0))
    found, spread = np.interp(times, middle, delta), np.interp(times, middle, std)
    left = [float(joint.square_error(p[rows], q[rows], delta[k : k + 1])[0]) for k, rows in enumerate(windows)]
    sizes = np.array([len(rows) for rows in windows])
    return HeadingCorrection(
        found,
        spread,
        _quat.multiply(_quat.about_axis(2, found), q),
        math.sqrt(float(np.average(left, weights=sizes))),
    )


def _grid(error: float, wander: float) -> FloatArray:
    """Headings, fine enough for the least uncertainty that the two passes can end with."""
    # A random walk of q per step, measured with r, is known to √(q r) after, and to √(q r / 2) between measurements.
    least = math.sqrt(0.5 * error * min(wander, error))
    count = 1 << max(math.ceil(math.log2(2.0 * math.pi * PER_DEVIATION / least)), 0)
    count = min(max(count, FEWEST), MOST)
    grid: FloatArray = np.arange(count, dtype=np.float64) * (2.0 * math.pi / count) - math.pi
    return grid


def _smoothed(likelihood: FloatArray, times: FloatArray, wander: float) -> FloatArray:
    """Probabilities (windows, grid) of the headings given all windows, from the logarithms of their likelihoods.

    For every steady drift there is a smoother of its own; they are mixed by how well each foretells the windows.
    """
    likelihood = np.maximum(np.exp(likelihood - likelihood.max(axis=1, keepdims=True)), LEAST)
    steps = np.diff(times)
    chance, evidence = np.ones((len(DRIFTS), likelihood.shape[1])), np.zeros(len(DRIFTS))
    for k, row in enumerate(likelihood):
        chance = chance * row
        total = chance.sum(axis=1)
        chance /= total[:, np.newaxis]
        evidence += np.log(total)
        if k < len(steps):
            chance = _wandered(chance, DRIFTS, steps[k], wander)
    evidence -= 0.5 * (DRIFTS / STEADY) ** 2
    weights = np.exp(evidence - evidence.max())
    found = np.zeros_like(likelihood)
    for drift, weight in zip(DRIFTS, weights / weights.sum(), strict=True):
        if weight > NEGLIGIBLE:
            found += weight * _both_ways(likelihood, steps, wander, np.array([drift]))
    normalised: FloatArray = found / found.sum(axis=1, keepdims=True)
    return normalised


def _both_ways(likelihood: FloatArray, steps: FloatArray, wander: float, drift: FloatArray) -> FloatArray:
    """Probabilities (windows, grid) given a steady drift (1,)."""
    found = np.ones_like(likelihood)
    for k in range(1, len(found)):
        found[k] = _wandered((found[k - 1] * likelihood[k - 1])[np.newaxis], drift, steps[k - 1], wander)[0]
    after = np.ones(likelihood.shape[1])
    for k in range(len(found) - 1, -1, -1):
        found[k] *= likelihood[k] * after
        found[k] /= found[k].sum()
        if k:
            after = _wandered((after * likelihood[k])[np.newaxis], -drift, steps[k - 1], wander)[0]
    return found


def _wandered(chance: FloatArray, drift: FloatArray, step: float, wander: float) -> FloatArray:
    """Probabilities (n, grid) a time later, at drifts (n,) in rad/s.

    They are convolved with wrapped normal distributions, whose Fourier series are exp(-m² σ²/2 - i m μ).
    """
    count = chance.shape[1]
    waves = np.arange(count // 2 + 1)
    series = np.exp(-0.5 * (waves * wander) ** 2 * step - 1j * drift[:, np.newaxis] * step * waves)
    spread = np.fft.irfft(np.fft.rfft(chance, axis=1) * series, count, axis=1)
    kept: FloatArray = np.maximum(spread / spread.max(axis=1, keepdims=True), LEAST)
    kept /= kept.sum(axis=1, keepdims=True)
    return kept
