"""What all readers share: the raw contents of a file, and the one place where they are repaired."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording, nominal_rate

FloatArray: TypeAlias = NDArray[np.float64]

#: A reference quaternion whose norm differs from 1 by no more than this is kept as recorded (rounding to 3
#: decimals); up to the second value it is normalised; beyond, it is no orientation but a mark of a lost one.
NORM_KEPT, NORM_MENDED = 1e-3, 0.1

#: A stamp that falls back by more steps than this is no jitter but an outlier, or, where as many stamps stay
#: behind, a clock that started anew.
JITTER_STEPS = 10


@dataclass(slots=True)
class Raw:
    """Contents of a file in the units of `Recording`, before any repair; `t` or `rate` must be there."""

    gyr: Any
    t: Any = None
    rate: float | None = None
    acc: Any = None
    mag: Any = None
    ref: Any = None
    mask: Any = None
    temperature: Any = None
    meta: dict[str, Any] = field(default_factory=dict)


def require(module: str) -> Any:
    """Import an optional module, or say how to install it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0]
        if error.name != package:
            raise
        raise ImportError(f"this file format needs {package}: pip install ahrs-rs[io]") from error


def one_line(error: BaseException) -> str:
    """The message of another library's error, on one line."""
    return " ".join(str(error).split()) or type(error).__name__


@np.errstate(over="ignore", invalid="ignore")  # absurd times and quaternions are refused by their result
def finish(raw: Raw, path: Path, format: str) -> Recording:
    """A `Recording` of `raw`: infinite values and impossible truth become NaN, times are put in order.

    Every change is told in meta["repairs"]. No row is added or removed.
    """
    repairs: list[str] = list(raw.meta.get("repairs", ()))
    arrays: dict[str, Any] = {}
    for name in ("gyr", "acc", "mag", "ref", "temperature"):
        value = getattr(raw, name)
        if value is not None:
            arrays[name] = _without_inf(name, value, repairs)
    if not np.size(arrays["gyr"]):
        raise ValueError("has no samples")
    if "ref" in arrays:
        arrays["ref"] = _orientations(arrays["ref"], repairs)
    if raw.mask is not None:
        arrays["mask"] = raw.mask
    if raw.t is not None:
        t = _ordered_times(np.asarray(raw.t, dtype=np.float64), repairs)
    elif raw.rate is not None and raw.rate > 0:
        t = np.arange(len(arrays["gyr"])) / raw.rate
    else:
        raise ValueError("has no times (t) and no sampling rate: give rate=")
    rate = raw.rate if raw.rate is not None else nominal_rate(t)
    meta = {**raw.meta, "path": str(path), "format": format, "repairs": repairs}
    return Recording(t=t, rate=rate, meta=meta, **arrays)


def _without_inf(name: str, value: Any, repairs: list[str]) -> FloatArray:
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: expected real numbers, got dtype {array.dtype}")
    array = array.astype(np.float64)
    infinite = np.isinf(array)
    if infinite.any():
        array[infinite] = np.nan
        repairs.append(f"{name}: {int(infinite.sum())} infinite values turned into NaN")
    return array


def _orientations(ref: FloatArray, repairs: list[str]) -> FloatArray:
    if ref.ndim != 2 or ref.shape[1] != 4:
        return ref  # the wrong shape is told by Recording
    norm = np.linalg.norm(ref, axis=1)
    deviation = np.abs(norm - 1.0)
    mended = (deviation > NORM_KEPT) & (deviation <= NORM_MENDED)
    lost = deviation > NORM_MENDED
    if mended.any():
        ref[mended] /= norm[mended, None]
        repairs.append(f"ref: {int(mended.sum())} quaternions normalised")
    if lost.any():
        ref[lost] = np.nan
        repairs.append(f"ref: {int(lost.sum())} rows with a norm far from 1 turned into NaN")
    return ref


def _ordered_times(t: FloatArray, repairs: list[str]) -> FloatArray:
    """Finite times that do not decrease, changed as little as can be told from the stamps alone.

    1. A missing stamp is interpolated between its neighbours (at the ends: continued with the median step).
    2. A single stamp far ahead of both neighbours takes the time before it.
    3. A far fall that the next stamps do not make good is a clock that started anew: the stamps from there on
       are shifted, so that they continue with the median step.
    4. What then still decreases holds the time before it.
    """
    if t.ndim != 1:
        raise ValueError(f"t: expected shape (T,), got {t.shape}")
    missing = ~np.isfinite(t)
    if missing.any():
        t = _fill_times(t, missing)
        repairs.append(f"t: {int(missing.sum())} missing stamps interpolated")
    rises = np.diff(t)
    if not (rises < 0).any():
        return t
    if not (rises > 0).any():
        raise ValueError("t: expected times that increase, got decreasing ones only")
    step = float(np.median(rises[rises > 0]))

    fall = np.zeros(len(t), dtype=np.bool_)
    fall[:-2] = (t[1:-1] - t[2:] > JITTER_STEPS * step) & (t[2:] >= t[:-2])
    ahead = np.flatnonzero(fall) + 1
    if ahead.size:
        t = t.copy()
        t[ahead] = t[ahead - 1]
        repairs.append(f"t: {ahead.size} stamps far ahead, first at index {ahead[0]}, hold the time before")

    padded = np.append(t[1:], np.full(JITTER_STEPS - 1, np.inf))
    behind = np.lib.stride_tricks.sliding_window_view(padded, JITTER_STEPS).max(axis=1) < t[:-1]
    restarts = np.flatnonzero((t[:-1] - t[1:] > JITTER_STEPS * step) & behind) + 1
    if restarts.size:
        shift = np.zeros(len(t))
        shift[restarts] = t[restarts - 1] - t[restarts] + step
        t = t + np.cumsum(shift)
        repairs.append(f"t: clock restarts {restarts.size} times, first at index {restarts[0]}; continued")

    falls = np.flatnonzero(np.diff(t) < 0) + 1
    if falls.size:
        t = np.maximum.accumulate(t)
        repairs.append(f"t: decreases {falls.size} times, first at index {falls[0]}; the time before is held")
    return t


def _fill_times(t: FloatArray, missing: NDArray[np.bool_]) -> FloatArray:
    valid = np.flatnonzero(~missing)
    if valid.size < 2:
        raise ValueError(f"t: expected at least two valid times, got {valid.size}")
    index = np.arange(len(t))
    filled = np.interp(index, valid, t[valid])
    rates = np.diff(t[valid]) / np.diff(valid)
    step = max(float(np.median(rates)), 0.0)
    first, last = valid[0], valid[-1]
    filled[:first] = t[first] + step * (index[:first] - first)
    filled[last:] = t[last] + step * (index[last:] - last)
    return filled
