"""What stands between an estimate and a reference: constant rotations of both frames, and an offset of the clocks.

The reference shows ref(t) = q_earth ⊗ est(t + τ) ⊗ q_sensor. With r = log(ref* ⊗ aligned), the error in the sensor
frame, an error δs of q_sensor (on its right) adds δs to r, one of q_earth (δe, on its left) adds Rᵀ δe with R the
aligned attitude, and one of τ adds ω δτ with ω its angular rate: Gauss-Newton on Σ r², from closed forms.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _quat
from ahrs_rs._slerp import Attitudes
from ahrs_rs._typing import FloatArray
from ahrs_rs.metrics._orientation import _unit
from ahrs_rs.metrics._statistics import checked_mask

__all__ = ["Alignment", "align"]


EARTH = ("full", "heading", "none")
#: Samples that are needed: beyond the seven unknowns the residuals have to say something.
FEWEST = 10
#: Rotations over so many seconds give the first guess: far less than half a turn, far more than the noise.
SPAN = 0.1
#: Samples from which the first guess is made.
GUESSED = 2000
#: Smallest eigenvalue of the normal matrix over the number of samples. Of a rotation about one axis with excursions α
#: (RMS) about others it is α²/2: 6° here, where a systematic error of 1° comes back ten times as large.
DETERMINED = 5e-3
#: The offset of the clocks asks for so much angular rate (RMS), rad/s.
SLOWEST = 0.05
ROUNDS = 50
HALVINGS = 20
#: Changes of what the motion does not determine to rounding are left out.
SINGULAR = 1e-9
#: Gauss-Newton ends where the mean square becomes smaller by less than this part of it.
SETTLED = 1e-9
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """ref(t) ≈ q_earth ⊗ est(t + time_offset) ⊗ q_sensor, and what is left.

    Parameters
    ----------
    q_earth : ndarray
        (4,) from the earth frame of the estimate to that of the reference.
    q_sensor : ndarray
        (4,) from the sensor frame of the reference to that of the estimate.
    time_offset : float
        S: what the reference shows at t the estimate shows at t + time_offset. Positive where the
        estimate is late.
    rms : float
        Root of the mean square of the angles that are left, rad: no other such rotations and offset
        leave less.
    median : float
        Median of these angles, rad.
    largest : float
        Largest of these angles, rad.
    samples : int
        How many samples were compared.
    determined : bool
        Whether the motion determines the rotations and the offset: always, unless `align` was told
        not to ask for it.
    t : ndarray, optional
        (T,) the times of the estimate, s; None where no offset was looked for.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=20.0, noise=False)
    >>> found = ar.metrics.align(rec.ref, rec.ref, rate=100.0)
    >>> bool(found.determined), round(found.rms, 6)
    (True, 0.0)
    """

    q_earth: FloatArray
    q_sensor: FloatArray
    time_offset: float
    rms: float
    median: float
    largest: float
    samples: int
    determined: bool
    t: FloatArray | None = field(default=None, repr=False)

    def apply(self, q: ArrayLike, *, t: ArrayLike | None = None) -> FloatArray:
        """The estimate in the frames and at the times of the reference.

        Parameters
        ----------
        q : array_like
            (T, 4), or any (..., 4) where the time offset is zero.
        t : array_like, optional
            (T,) the times of q, s; by default those of the estimate that was aligned.

        Returns
        -------
        ndarray
            (T, 4) at the times of the reference.
        """
        quat = _unit("q", q)
        if self.time_offset:
            times = self.t if t is None else _times(t, None, len(quat))
            if times is None or quat.shape != (len(times), 4):
                expected = "(T, 4)" if times is None else f"({len(times)}, 4)"
                raise ValueError(f"q: expected shape {expected}, one for each time, got {quat.shape}")
            quat, _ = Attitudes(quat, times).at(times + self.time_offset)
        return _quat.multiply(_quat.multiply(self.q_earth, quat), self.q_sensor)

    def pair(self, q: ArrayLike, ref: ArrayLike, *, t: ArrayLike | None = None) -> tuple[FloatArray, FloatArray]:
        """Estimate and reference in one frame, for scores: `metrics.score(*alignment.pair(q, ref))`.

        The estimate is that of `apply`, and both are turned into the earth frame of the estimate, whose z axis is the
        vertical: heading and inclination errors mean nothing in an earth frame with another one.

        Parameters
        ----------
        q : array_like
            (T, 4) the estimate.
        ref : array_like
            (T, 4) the reference.
        t : array_like, optional
            (T,) stamps of the estimate in s; by default those of the alignment.

        Returns
        -------
        tuple
            Estimate and reference, (T, 4) each.
        """
        back = _quat.conjugate(self.q_earth)
        return _quat.multiply(back, self.apply(q, t=t)), _quat.multiply(back, _unit("ref", ref))


def align(
    q: ArrayLike,
    ref: ArrayLike,
    mask: ArrayLike | None = None,
    *,
    t: ArrayLike | None = None,
    rate: float | None = None,
    earth: str = "full",
    sensor: bool = True,
    time: bool = True,
    largest_offset: float = 1.0,
    check: bool = True,
) -> Alignment:
    """Find the constant rotations and the offset of the clocks between an estimate and a reference.

    A motion capture system has an earth frame of its own, and its markers a frame that is not the sensor's; often its
    clock is not the sensor's either. The rotations and the offset are those with the smallest RMS of the total error.

    Parameters
    ----------
    q : array_like
        (T, 4) estimate.
    ref : array_like
        (T, 4) reference at the same times; rows with NaN (missing) are left out.
    mask : array_like, optional
        Bool (T,), the samples that count; None takes all of them.
    t : array_like, optional
        (T,) s, not decreasing; or rate : Hz. One of them is needed where the offset is looked for.
    rate : float, optional
        Hz, in place of stamps.
    earth : str, optional
        ``"full"``, any rotation between the earth frames; ``"heading"``, one about the vertical
        (both have z up); ``"none"``, they are the same.
    sensor : bool, optional
        Whether there is a rotation between the sensor frames.
    time : bool, optional
        Whether there is an offset between the clocks.
    largest_offset : float, optional
        S, where the offset is searched: -largest_offset to largest_offset.
    check : bool, optional
        False takes one of the rotations that fit alike where the motion does not determine them
        (`determined` says so). That is enough for a score, which they do not change; it is no
        calibration of the frames.

    Returns
    -------
    Alignment
        Rotations, offset, and what is left.

    Raises
    ------
    ValueError
        Too few samples that count; motion that does not determine what is asked for (the message says what is missing).

    Notes
    -----
    First guess: the offset by the norms of the angular rates, which no rotation changes; the sensor frame by the
    rotations over 0.1 s, which no earth frame changes (least squares by singular values); the earth frame by the mean
    of quaternions. Then Gauss-Newton over all unknowns, the estimate interpolated (slerp).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=20.0, noise=False)
    >>> round(ar.metrics.align(rec.ref, rec.ref, rate=100.0).rms, 6)
    0.0
    """
    est, truth = _unit("q", q), _unit("ref", ref)
    if est.ndim != 2 or est.shape != truth.shape:
        raise ValueError(f"q, ref: expected shape (T, 4) for both, got {est.shape} and {truth.shape}")
    if earth not in EARTH:
        raise ValueError(f"earth: expected one of {', '.join(EARTH)}, got {earth!r}")
    if not (math.isfinite(largest_offset) and largest_offset > 0.0):
        raise ValueError(f"largest_offset: expected a positive number of s, got {largest_offset}")
    counted: NDArray[np.bool_] = np.logical_not(np.isnan(truth).any(axis=1))
    if mask is not None:
        counted &= checked_mask("mask", mask, counted.shape)
    compared = int(np.count_nonzero(counted & ~np.isnan(est).any(axis=1)))
    if compared < FEWEST:
        raise ValueError(f"q, ref: expected at least {FEWEST} samples with an estimate and a reference, got {compared}")
    given = t is not None or rate is not None
    if time and not given:
        raise ValueError("t: expected stamps, or rate, to find a time offset (or time=False), got neither")
    # Without stamps the rotations over 0.1 s are those over ten samples.
    times = _times(t, rate if given else 10.0 / SPAN, len(est))

    problem = _Problem(Attitudes(est, times), truth, counted, earth, sensor, time)
    offset = _first_offset(problem, largest_offset) if time else 0.0
    found, lacking = _refined(problem, _first_rotations(problem, offset), largest_offset)
    if lacking and check:
        raise ValueError(lacking)
    angles = np.linalg.norm(found.residual, axis=1)
    return Alignment(
        q_earth=found.earth,
        q_sensor=found.sensor,
        time_offset=found.offset,
        rms=float(np.sqrt(np.mean(angles**2))),
        median=float(np.median(angles)),
        largest=float(angles.max()),
        samples=len(angles),
        determined=not lacking,
        t=times if time else None,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    motion: Attitudes
    ref: FloatArray
    counted: NDArray[np.bool_]
    earth: str
    sensor: bool
    time: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Guess:
    """Rotations and offset with what they leave."""

    problem: _Problem
    earth: FloatArray
    sensor: FloatArray
    offset: float
    residual: FloatArray = field(init=False)
    """(n, 3) log(ref* ⊗ aligned) of the samples that count."""
    aligned: FloatArray = field(init=False)
    """(n, 4)"""
    rates: FloatArray = field(init=False)
    """(n, 3) of the aligned attitudes in the reference's sensor frame, rad/s."""

    def __post_init__(self) -> None:
        motion, ref = self.problem.motion, self.problem.ref[self.problem.counted]
        quat, rates = motion.quat, np.zeros((0, 3))
        if self.problem.time:
            quat, rates = motion.at(motion.t[self.problem.counted] + self.offset)
        else:
            quat = quat[self.problem.counted]
        there = ~np.isnan(quat).any(axis=1)
        if np.count_nonzero(there) < FEWEST:
            raise ValueError(f"q, ref: fewer than {FEWEST} samples overlap at an offset of {self.offset:.3g} s")
        aligned = _quat.multiply(_quat.multiply(self.earth, quat[there]), self.sensor)
        put = object.__setattr__
        put(self, "aligned", aligned)
        put(self, "residual", _quat.log(_quat.multiply(_quat.conjugate(ref[there]), aligned)))
        put(self, "rates", _quat.rotate(_quat.conjugate(self.sensor), rates[there]) if self.problem.time else rates)

    @property
    def cost(self) -> float:
        return float(np.mean(np.sum(self.residual**2, axis=1)))

    def columns(self) -> tuple[FloatArray, FloatArray]:
        """(n, 3, k) how the residual changes with the unknowns; (k,) their scales (1/RMS of the rate for the time)."""
        back = _quat.conjugate(self.aligned)
        axes = {"full": (0, 1, 2), "heading": (2,), "none": ()}[self.problem.earth]
        parts = [_quat.rotate(back, np.eye(3)[axis]) for axis in axes]
        if self.problem.sensor:
            parts += [np.broadcast_to(unit, self.residual.shape) for unit in np.eye(3)]
        scale = np.ones(len(parts) + self.problem.time)
        if self.problem.time:
            rate = float(np.sqrt(np.mean(np.sum(self.rates**2, axis=1))))
            if rate < SLOWEST:
                raise ValueError(
                    f"q: turns by {rate:.3g} rad/s (RMS) only: a time offset is not observable (give time=False, or "
                    "compare over faster turns)"
                )
            scale[-1] = 1.0 / rate
            parts.append(self.rates)
        stacked = np.stack(parts, axis=-1) if parts else np.zeros((len(self.residual), 3, 0))
        return stacked * scale, scale

    def moved(self, change: FloatArray) -> _Guess:
        """With the unknowns changed, in the order of `columns`."""
        turned = {"full": change[:3], "heading": np.array([0.0, 0.0, change[0]]) if len(change) else change}
        first = {"full": 3, "heading": 1, "none": 0}[self.problem.earth]
        earth, sensor, offset = self.earth, self.sensor, self.offset
        if first:
            earth = _normalised(_quat.multiply(_quat.exp(turned[self.problem.earth]), earth))
        if self.problem.sensor:
            sensor = _normalised(_quat.multiply(sensor, _quat.exp(change[first : first + 3])))
        if self.problem.time:
            offset += float(change[-1])
        return _Guess(self.problem, earth, sensor, offset)


def _refined(problem: _Problem, guess: _Guess, largest_offset: float) -> tuple[_Guess, str]:
    """Gauss-Newton: the gradient is exact, as log's derivative leaves the direction of the residual as it is.

    With it comes what the motion does not determine, and what to do about it; nothing of which moves from the guess.
    """
    lacking = ""
    for _ in range(ROUNDS):
        columns, scale = guess.columns()
        if not len(scale):
            break
        flat = columns.reshape(-1, len(scale))
        values, vectors = np.linalg.eigh(flat.T @ flat / len(columns))
        lacking = _lacking(problem, vectors[:, 0]) if values[0] < DETERMINED else ""
        inverse = (vectors * np.where(values > SINGULAR, 1.0 / np.maximum(values, SINGULAR), 0.0)) @ vectors.T
        change = -scale * (inverse @ (flat.T @ guess.residual.ravel() / len(columns)))
        before = guess
        for _ in range(HALVINGS):
            tried = guess.moved(change)
            if tried.cost < guess.cost:
                guess = tried
                break
            change = 0.5 * change
        if problem.time and abs(guess.offset) > largest_offset:
            raise ValueError(
                f"q, ref: the time offset leaves the range of ±{largest_offset:g} s (largest_offset): do they show the "
                "same motion?"
            )
        if before.cost - guess.cost <= SETTLED * before.cost:
            break
    return guess, lacking


def _lacking(problem: _Problem, direction: FloatArray) -> str:
    """What the motion does not determine, given the direction in which the residuals change least, and what to do."""
    if problem.time and direction[-1] ** 2 > 0.25:
        what = "the time offset cannot be told from a rotation, as the sensor turns at a constant rate"
        return f"q: {what}: give time=False, or compare over turns to and fro"
    turns = "about one axis only, or hardly at all" if problem.earth == "full" else "about the vertical only"
    what = f"the rotation of the sensor frame is not observable, as the sensor turns {turns}"
    remedy = "sensor=False, earth='none'" if problem.earth == "full" else "sensor=False"
    return f"q: {what}: give {remedy}, or check=False if only the score matters, or compare over turns about two axes"


def _first_offset(problem: _Problem, largest: float) -> float:
    """The shift at which the norms of the angular rates agree best: the vertex of the parabola about it."""
    motion = problem.motion
    step = float(np.median(motion.step[np.isfinite(motion.step)])) if np.isfinite(motion.step).any() else math.nan
    if not step > 0.0:
        raise ValueError("t: has no two different times, so that a time offset is not observable")
    grid = np.arange(motion.t[0], motion.t[-1], step)
    ref = np.where(problem.counted[:, np.newaxis], problem.ref, np.nan)
    est, truth = (_norms(Attitudes(quat, motion.t), grid, step) for quat in (motion.quat, ref))
    farthest = math.floor(largest / step)
    lags = range(-farthest, farthest + 1)
    costs = np.full(len(lags), np.nan)
    for i, lag in enumerate(lags):
        # What the reference shows at t the estimate shows at t + lag.
        first, second = truth[max(-lag, 0) : len(grid) - max(lag, 0)], est[max(lag, 0) : len(grid) - max(-lag, 0)]
        off = (first - second) ** 2
        there = ~np.isnan(off)
        if np.count_nonzero(there) >= FEWEST:
            costs[i] = float(off[there].mean())
    if np.isnan(costs).all():
        raise ValueError("q, ref: too few samples with angular rates of both to find a time offset")
    best = int(np.nanargmin(costs))
    near = costs[best - 1 : best + 2]
    bend = near[0] - 2.0 * near[1] + near[2] if len(near) == 3 else math.nan
    return float(step * (lags[best] + (0.5 * (near[0] - near[2]) / bend if bend > 0.0 else 0.0)))


def _norms(motion: Attitudes, grid: FloatArray, step: float) -> FloatArray:
    """Norms of the angular rates at the times of a grid, means over `SPAN` about them, rad/s."""
    half = max(round(0.5 * SPAN / step), 1) * step
    before, after = motion.at(grid - half)[0], motion.at(grid + half)[0]
    turned: FloatArray = np.linalg.norm(_quat.log(_quat.multiply(_quat.conjugate(before), after)), axis=1)
    return turned / (2.0 * half)


def _first_rotations(problem: _Problem, offset: float) -> _Guess:
    """Closed forms, from some of the samples, improved in turn: the best of several starts."""
    counted = np.flatnonzero(problem.counted)
    motion = problem.motion
    quat = motion.at(motion.t[counted] + offset)[0] if offset else motion.quat[counted]
    ref = problem.ref[counted]
    starts = [IDENTITY]
    if problem.sensor and problem.earth == "full":
        starts = [_sensor_frame(quat, ref, motion.t[counted])]
    there = np.flatnonzero(~np.isnan(quat).any(axis=1))
    there = there[:: max(len(there) // GUESSED, 1)]
    quat, ref = quat[there], ref[there]
    if problem.sensor and problem.earth == "heading":
        # A turn about a horizontal axis alone does not give the sensor frame by its rates.
        headings = [_quat.about_axis(2, np.asarray(angle)) for angle in np.arange(8) * (math.pi / 4.0)]
        starts = [_quat.mean(_quat.multiply(_quat.conjugate(_quat.multiply(one, quat)), ref)) for one in headings]
    guesses = []
    for sensor in starts:
        for _ in range(20 if problem.sensor else 1):
            turned = _quat.multiply(ref, _quat.conjugate(_quat.multiply(quat, sensor)))
            earth = IDENTITY
            if problem.earth != "none":
                earth = _quat.mean(turned) if problem.earth == "full" else _mean_heading(turned)
            if problem.sensor:
                sensor = _quat.mean(_quat.multiply(_quat.conjugate(_quat.multiply(earth, quat)), ref))
        guesses.append(_Guess(problem, earth, sensor, offset))
    return min(guesses, key=lambda one: one.cost)


def _sensor_frame(quat: FloatArray, ref: FloatArray, t: FloatArray) -> FloatArray:
    """ref_k* ⊗ ref_l = s* ⊗ (q_k* ⊗ q_l) ⊗ s: the rotation s between pairs of rotation vectors, by singular values."""
    step = float(np.median(np.diff(t)))
    apart = max(round(SPAN / step), 1) if step > 0.0 else 1
    near = t[apart:] - t[:-apart] <= 2.0 * SPAN  # no pairs over what is left out
    a, b = (_quat.log(_quat.multiply(_quat.conjugate(one[:-apart]), one[apart:]))[near] for one in (quat, ref))
    there = ~(np.isnan(a).any(axis=1) | np.isnan(b).any(axis=1))
    u, _, vt = np.linalg.svd(a[there].T @ b[there])  # a = R b
    matrix = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return _quat.of_matrix(matrix)


def _mean_heading(quat: FloatArray) -> FloatArray:
    """The turn about the vertical nearest to rotations: the largest Σ (w cos ψ/2 + z sin ψ/2)²."""
    w, z = quat[:, 0], quat[:, 3]
    return _quat.about_axis(2, np.arctan2(2.0 * np.sum(w * z), np.sum(w * w - z * z)))


def _normalised(quat: FloatArray) -> FloatArray:
    unit: FloatArray = quat / np.linalg.norm(quat)
    return unit if unit[0] >= 0.0 else -unit


def _times(t: ArrayLike | None, rate: float | None, count: int) -> FloatArray:
    if t is None:
        if rate is None or not (math.isfinite(rate) and rate > 0.0):
            raise ValueError(f"rate: expected a positive number of Hz, got {rate}")
        return np.arange(count, dtype=np.float64) / rate
    times: FloatArray = np.asarray(t, dtype=np.float64)
    if times.shape != (count,):
        raise ValueError(f"t: expected shape ({count},), got {times.shape}")
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        raise ValueError("t: expected finite times that do not decrease")
    return times
