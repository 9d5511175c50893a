"""Stamps put in order: what is late, what is missing, what leapt."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray

#: A stamp that falls back by more steps than this is no jitter but an outlier, or, where as many stamps stay
#: behind, a clock that started anew.
JITTER_STEPS = 10
#: A step that is longer than so many usual ones leaves a hole; one that is shorter than so many is shared by two
#: clocks.
HOLE, SHORT = 1.75, 0.5


def ordered(t: FloatArray, repairs: list[str], name: str = "t") -> tuple[FloatArray, NDArray[np.intp] | None]:
    """Finite times that do not decrease, changed as little as can be told from the stamps alone.

    1. A missing stamp is interpolated between its neighbours (at the ends: continued with the median step).
    2. Rows that come late, and fill the holes that they left, are sorted by their stamps.
    3. A single stamp far ahead of both neighbours takes the time before it.
    4. A far fall that the next stamps do not make good is a clock that started anew: the stamps from there on
       are shifted, so that they continue with the median step.
    5. A stamp that is then still far behind holds the time before it; the others are sorted. Where stamps were missing,
    all
       that decrease hold the time before.

    Parameters
    ----------
    t : (n,) s, NaN where missing.
    repairs : sentences about what was changed are added to it.
    name : of the clock, for the sentences.

    Returns
    -------
    t : (n,) in the order of the rows below.
    order : which row stands where, or None where all stay.
    """
    if t.ndim != 1:
        raise ValueError(f"{name}: expected shape (T,), got {t.shape}")
    missing = ~np.isfinite(t)
    complete = not missing.any()
    if not complete:
        t = _filled(t, missing, name)
        repairs.append(f"{name}: {int(missing.sum())} missing stamps interpolated")
    rises = np.diff(t)
    if not (rises < 0).any():
        return t, None
    if not (rises > 0).any():
        raise ValueError(f"{name}: expected times that increase, got decreasing ones only")
    step = float(np.median(rises[rises > 0]))
    if complete and _late(t, step):
        return _sorted(t, repairs, name)

    fall = np.zeros(len(t), dtype=np.bool_)
    fall[:-2] = (t[1:-1] - t[2:] > JITTER_STEPS * step) & (t[2:] >= t[:-2])
    ahead = np.flatnonzero(fall) + 1
    if ahead.size:
        t = t.copy()
        t[ahead] = t[ahead - 1]
        repairs.append(f"{name}: {ahead.size} stamps far ahead, first at index {ahead[0]}, hold the time before")

    padded = np.append(t[1:], np.full(JITTER_STEPS - 1, np.inf))
    behind = np.lib.stride_tricks.sliding_window_view(padded, JITTER_STEPS).max(axis=1) < t[:-1]
    restarts = np.flatnonzero((t[:-1] - t[1:] > JITTER_STEPS * step) & behind) + 1
    if restarts.size:
        shift = np.zeros(len(t))
        shift[restarts] = t[restarts - 1] - t[restarts] + step
        t = t + np.cumsum(shift)
        repairs.append(f"{name}: clock restarts {restarts.size} times, first at index {restarts[0]}; continued")

    falls = np.flatnonzero(np.diff(t) < 0) + 1
    highest = np.maximum.accumulate(t)
    held = (highest - t > JITTER_STEPS * step) if complete else t < highest
    if falls.size and held.any():
        first = int(np.argmax(held))
        t = np.where(held, highest, t)
        repairs.append(f"{name}: decreases {int(held.sum())} times, first at index {first}; the time before is held")
    return _sorted(t, repairs, name) if (np.diff(t) < 0).any() else (t, None)


def _late(t: FloatArray, step: float) -> bool:
    """Whether sorting fills holes: fewer leaps are left than there were, and no more short steps than before.

    A clock that started anew would make a hole, or share its times with the one before; a stamp far ahead leaves a hole
    where it was and makes another one where it goes.
    """
    before, after = np.diff(t), np.diff(np.sort(t))
    holes = np.count_nonzero(after > HOLE * step) < np.count_nonzero(before > HOLE * step)
    short = np.count_nonzero(after < SHORT * step) <= np.count_nonzero((before >= 0) & (before < SHORT * step))
    return bool(holes and short)


def _sorted(t: FloatArray, repairs: list[str], name: str) -> tuple[FloatArray, NDArray[np.intp]]:
    order = np.argsort(t, kind="stable")
    late = int(np.count_nonzero(t < np.maximum.accumulate(t)))
    first = int(np.argmax(np.diff(t) < 0)) + 1
    repairs.append(f"{name}: {late} rows come late, first at index {first}; sorted by their stamps")
    return t[order], order


def _filled(t: FloatArray, missing: NDArray[np.bool_], name: str) -> FloatArray:
    valid = np.flatnonzero(~missing)
    if valid.size < 2:
        raise ValueError(f"{name}: expected at least two valid times, got {valid.size}")
    index = np.arange(len(t))
    filled = np.interp(index, valid, t[valid])
    rates = np.diff(t[valid]) / np.diff(valid)
    step = max(float(np.median(rates)), 0.0)
    first, last = valid[0], valid[-1]
    filled[:first] = t[first] + step * (index[:first] - first)
    filled[last:] = t[last] + step * (index[last:] - last)
    return filled
