"""Rotations along time: between samples, on another clock, and without jumps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _quat, _validate
from ahrs_rs._rate import nominal_rate
from ahrs_rs._streams import GAP_STEPS
from ahrs_rs._typing import FloatArray, Floats

__all__ = ["continuous", "interpolate", "slerp", "unwrap"]


def slerp(p: ArrayLike, q: ArrayLike, fraction: ArrayLike) -> Floats:
    """Rotations between two, along the shortest way at a constant rate (spherical linear interpolation).

    Parameters
    ----------
    p : array_like
        (..., 4) quaternions, scalar-first.
    q : array_like
        (..., 4) quaternions, scalar-first; of q and -q the one that is nearer to p is taken.
    fraction : array_like
        (...,) how much of the way: 0 gives p, 1 gives q or -q; others go on at the same rate.

    Returns
    -------
    ndarray
        (..., 4), with the leading axes of all three.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, or a norm that is not 1.

    Notes
    -----
    K. Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985. Between rotations that are half a turn
    apart there are two shortest ways; it is one of them.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> p, q = ar.rotation.about_axis("z", [0.0, 80.0], degrees=True)
    >>> ar.rotation.to_rotvec(ar.rotation.slerp(p, q, [0.25, 0.5]), degrees=True).round(6) + 0.0
    array([[ 0.,  0., 20.],
           [ 0.,  0., 40.]])
    """
    part = _validate.reals("fraction", fraction)
    first, second = _validate.unit_quaternions("p", p), _validate.unit_quaternions("q", q)
    if isinstance(fraction, (int, float)):  # a number has no dtype of its own
        part = part.astype(np.result_type(first, second))
    first, second, column = _validate.together("p, q, fraction", first, second, part[..., np.newaxis])
    return _quat.slerp(first, second, column[..., 0])


def interpolate(q: ArrayLike, t: ArrayLike, at: ArrayLike, *, max_gap: float | None = None) -> Floats:
    """Rotations on another clock: the shortest rotation between the samples before and after each time.

    Nothing is made up: a row with a NaN is no sample, and between samples that are farther apart than `max_gap`, before
    the first and after the last one the result is NaN.

    Parameters
    ----------
    q : array_like
        (..., T, 4) quaternions, scalar-first.
    t : array_like
        (T,) their times in s, not decreasing; of samples with one time the last one counts.
    at : array_like
        (n,) times in s, in any order; NaN gives NaN.
    max_gap : float, optional
        S; ``math.inf`` interpolates over all gaps. By default 2.5 usual steps of t.

    Returns
    -------
    ndarray
        (..., n, 4); of continuous sign along times that do not decrease.

    Raises
    ------
    ValueError
        Another shape, times that decrease or are not finite, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.about_axis("z", [0.0, 10.0, 20.0, 90.0], degrees=True)
    >>> found = ar.rotation.interpolate(q, [0.0, 0.1, 0.2, 0.9], [0.05, 0.15, 0.5, 0.9], max_gap=0.2)
    >>> ar.rotation.to_rotvec(found, degrees=True)[:, 2].round(6)
    array([ 5., 15., nan, 90.])
    """
    quat = samples("q", q)
    times = _validate.times("t", t, None, quat.shape[-2])
    wanted = _validate.reals("at", at).astype(np.float64, copy=False)
    if wanted.ndim != 1:
        raise ValueError(f"at: expected shape (n,), got {wanted.shape}")
    if max_gap is None:
        longest = GAP_STEPS / nominal_rate(times) if len(times) > 1 and times[-1] > times[0] else 0.0
    else:
        longest = _validate.number("max_gap", max_gap)
        if not longest >= 0.0:
            raise ValueError(f"max_gap: expected a number of s that is not negative, got {max_gap!r}")
    found = np.full((*quat.shape[:-2], len(wanted), 4), np.nan, dtype=quat.dtype)
    for index in np.ndindex(*quat.shape[:-2]):
        found[index] = _one(quat[index], times, wanted, longest)
    return found


def continuous(q: ArrayLike) -> Floats:
    """The same rotations without jumps between q and -q along time.

    Parameters
    ----------
    q : array_like
        (..., T, 4) quaternions, scalar-first. A row with a NaN stays, and the sign goes on after it.

    Returns
    -------
    ndarray
        (..., T, 4); the first sample with w >= 0.

    Raises
    ------
    ValueError
        Another shape, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.continuous([[-1.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 0.6], [-0.6, 0.0, 0.0, -0.8]]) + 0.0
    array([[1. , 0. , 0. , 0. ],
           [0.8, 0. , 0. , 0.6],
           [0.6, 0. , 0. , 0.8]])
    """
    return _continuous(samples("q", q))


def unwrap(angles: ArrayLike, *, period: float = 2.0 * math.pi, axis: int = -1) -> Floats:
    """Angles without jumps along time: whole turns are added until no step is longer than half a turn.

    Parameters
    ----------
    angles : array_like
        Of any shape. A NaN stays, and the angles go on after it (numpy's ``unwrap`` gives NaN from there on).
    period : float, optional
        A turn in the unit of the angles: 360.0 for degrees.
    axis : int, optional
        The axis of time: -2 for Euler angles (..., T, 3).

    Returns
    -------
    ndarray
        Of the same shape; the first angle is as it was.

    Raises
    ------
    ValueError
        An axis that is not there, or a period that is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.rotation.unwrap([170.0, np.nan, -170.0, -150.0], period=360.0)
    array([170.,  nan, 190., 210.])
    """
    given = _validate.reals("angles", angles)
    turn = _validate.positive("period", period)
    along = _validate.axes("axis", (axis,), given.shape, "one of an array of shape")[0]
    rows = np.moveaxis(given, along, -1)
    before, _ = _last_known(rows, ~np.isnan(rows))
    step = rows[..., 1:] - before[..., :-1]
    turns = np.cumsum(np.where(np.isnan(step), 0.0, np.round(step / turn)), axis=-1)
    found = rows.copy()
    found[..., 1:] -= (turn * turns).astype(rows.dtype, copy=False)
    return np.moveaxis(found, -1, along)


def samples(name: str, given: ArrayLike) -> FloatArray:
    quat = _validate.unit_quaternions(name, given)
    if quat.ndim < 2:
        raise ValueError(f"{name}: expected shape (..., T, 4), got {quat.shape}")
    return quat


def _continuous(quat: FloatArray) -> FloatArray:
    known = ~np.isnan(quat[..., 0])
    before, any_before = _last_known(np.moveaxis(quat, -1, 0), known)
    first = np.array([1.0, 0.0, 0.0, 0.0], dtype=quat.dtype)
    last = np.concatenate(
        [np.broadcast_to(first, (*quat.shape[:-2], 1, 4)), np.moveaxis(before, 0, -1)[..., :-1, :]], axis=-2
    )
    begun = np.concatenate([np.zeros((*known.shape[:-1], 1), dtype=np.bool_), any_before[..., :-1]], axis=-1)
    last = np.where(begun[..., np.newaxis], last, first)
    flipped = np.sum(quat * last, axis=-1) < 0.0
    odd = np.logical_xor.accumulate(flipped, axis=-1)
    return np.where(odd[..., np.newaxis], -quat, quat)


def _last_known(rows: FloatArray, known: NDArray[np.bool_]) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Along the last axis the last row that is known at each, itself included, and whether there is one."""
    place = np.where(known, np.arange(known.shape[-1]), -1)
    last = np.maximum.accumulate(place, axis=-1) if known.shape[-1] else place
    index = np.broadcast_to(np.maximum(last, 0), rows.shape)
    return np.take_along_axis(rows, index, axis=-1), last >= 0


def _one(quat: FloatArray, t: FloatArray, at: FloatArray, longest: float) -> FloatArray:
    """One recording."""
    found = np.full((len(at), 4), np.nan, dtype=quat.dtype)
    known = ~np.isnan(quat[:, 0])
    quat, t = _continuous(quat[known]), t[known]
    if not len(t):
        return found
    inside = (at >= t[0]) & (at <= t[-1])
    times = at[inside]
    before = np.searchsorted(t, times, side="right") - 1
    after = np.minimum(before + 1, len(t) - 1)
    step = t[after] - t[before]
    part = np.divide(times - t[before], step, out=np.zeros(len(times)), where=step > 0.0).astype(quat.dtype)
    between = _quat.slerp(quat[before], quat[after], part)
    between = np.where((times == t[before])[:, np.newaxis], quat[before], between)
    between[(step > longest) & (times != t[before])] = np.nan
    found[inside] = between
    return found
