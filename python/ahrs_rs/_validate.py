"""Checks of arguments, and the one form of their errors: ``name: expected …, got …``."""

from __future__ import annotations

import difflib
import operator
from collections.abc import Iterable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _arrays
from ahrs_rs._typing import FloatArray

# Arrays of float32 have the type of float64 here: the arithmetic of `_quat` is the same for both.

#: Largest difference of a quaternion's norm from 1. Four components rounded to 3 decimals stay within it.
NORM_TOLERANCE = 1e-3


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """``" (did you mean beta?)"`` where one of the known names is close, whatever its case; else nothing."""
    by_name = {each.lower(): each for each in known}
    close = difflib.get_close_matches(name.lower(), by_name, n=1) if isinstance(name, str) else []
    return f" (did you mean {by_name[close[0]]}?)" if close else ""


def number(name: str, value: object) -> float:
    """The argument as a float; ``ValueError`` where it is no number."""
    if type(value) is float:
        return value
    if isinstance(value, (str, bytes, bool)):
        raise ValueError(f"{name}: expected a number, got {value!r}")
    try:
        return float(cast(Any, value))
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name}: expected a number, got {value!r}") from None


def positive(name: str, value: object) -> float:
    """The argument as a positive finite number; ``ValueError`` where it is none."""
    found = number(name, value)
    if not 0.0 < found < np.inf:
        raise ValueError(f"{name}: expected a positive number, got {value}")
    return found


def choice(name: str, value: object, options: tuple[str, ...]) -> str:
    """The argument, one of the options; ``ValueError`` where it is none of them."""
    if not isinstance(value, str) or value not in options:
        wanted = ", ".join(map(repr, options))
        raise ValueError(f"{name}: expected one of {wanted}, got {value!r}{did_you_mean(value, options)}")
    return value


def axes(name: str, value: object, shape: tuple[int, ...], what: str) -> list[int]:
    """Axes of a shape, each once, counted from 0; ``ValueError`` where they are none.

    `value` is one whole number or several.
    """
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        several = isinstance(value, (tuple, list))
        given: list[Any] = list(cast(Any, value)) if several else [value]
        wanted = [operator.index(k) for k in given]
        wanted = [range(len(shape))[k] for k in wanted]
    except (TypeError, IndexError):
        wanted = [-1]
    if -1 in wanted or len(set(wanted)) < len(wanted):
        raise ValueError(f"{name}: expected {what} {shape}, got {value!r}")
    return wanted


def thread_count(threads: int | None) -> int | None:
    """The number of threads; ``ValueError`` where it is none."""
    if threads is None:
        return None
    try:
        count = 0 if isinstance(threads, bool) else operator.index(threads)
    except TypeError:
        count = 0
    if count < 1:
        raise ValueError(f"threads: expected a positive whole number or None, got {threads!r}")
    return count


def reals(name: str, value: object) -> FloatArray:
    """The argument as an array of float32 or float64, NaN where a number is missing; ``ValueError`` for all else."""
    found = _array(name, value)
    bad = np.argwhere(np.isinf(found))
    if len(bad):
        raise ValueError(f"{name}: expected finite numbers or NaN (missing), got {found[tuple(bad[0])]}{_at(bad[0])}")
    return found


def rows(name: str, value: object, *width: int) -> FloatArray:
    """The argument as an array of shape (..., *width), float32 or float64; ``ValueError`` where it is none."""
    return _shaped(name, reals(name, value), width)


def unit_quaternions(name: str, value: object) -> FloatArray:
    """Quaternions (..., 4), normalised, float32 or float64; a row with a NaN becomes NaN as a whole.

    ``ValueError`` where a norm differs from 1 by more than `NORM_TOLERANCE`.
    """
    quat = _shaped(name, _array(name, value), (4,))
    with np.errstate(over="ignore"):  # a huge component gives an infinite norm, which is refused below
        norm = np.sqrt((quat * quat).sum(axis=-1, keepdims=True))
    bad = np.argwhere(np.abs(norm[..., 0] - 1.0) > NORM_TOLERANCE)
    if len(bad):
        raise ValueError(f"{name}: expected unit quaternions, got norm {norm[tuple(bad[0])][0]:.6g}{_at(bad[0])}")
    unit: FloatArray = quat / norm
    return unit


def together(names: str, *arrays: FloatArray, rows: int = 1) -> tuple[FloatArray, ...]:
    """Arrays of one dtype: float32 where all are, else float64; ``ValueError`` where their leading axes do not fit.

    The last axes (`rows` of each) are no leading ones.
    """
    leading = [array.shape[: array.ndim - rows] for array in arrays]
    try:
        np.broadcast_shapes(*leading)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ValueError(f"{names}: expected leading axes that fit each other, got shapes {shapes}") from None
    dtype = np.float32 if all(array.dtype == np.float32 for array in arrays) else np.float64
    return tuple(array.astype(dtype, copy=False) for array in arrays)


def times(name: str, t: object | None, rate: object | None, count: int) -> FloatArray:
    """Times (count,) in s, finite and not decreasing, of stamps or of a rate in Hz; ``ValueError`` for what is none."""
    if t is not None and rate is not None:
        raise ValueError(f"{name}, rate: expected one of them, got both")
    if t is None:
        hertz = number("rate", np.nan if rate is None else rate)
        if not 0.0 < hertz < np.inf:
            raise ValueError(f"{name}: expected stamps in s, or a positive rate in Hz, got {rate!r}")
        return np.arange(count, dtype=np.float64) / hertz
    stamps: FloatArray = reals(name, t).astype(np.float64, copy=False)
    if stamps.shape != (count,):
        raise ValueError(f"{name}: expected shape ({count},), got {stamps.shape}")
    bad = np.flatnonzero(~np.isfinite(stamps))
    if bad.size:
        raise ValueError(f"{name}: expected finite times, got {stamps[bad[0]]} at index {bad[0]}")
    bad = np.flatnonzero(np.diff(stamps) < 0.0)
    if bad.size:
        raise ValueError(f"{name}: expected times that do not decrease, got a decrease at index {bad[0] + 1}")
    return stamps


def _array(name: str, value: object) -> FloatArray:
    value = _arrays.vectors(name, value)
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O":  # with None, which is missing
            array = array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected an array of real numbers, got {error}") from None
    if array.dtype.kind not in "fiu" and array.size:
        raise ValueError(f"{name}: expected an array of real numbers, got dtype {array.dtype}")
    return array if array.dtype == np.float32 else array.astype(np.float64, copy=False)


def _shaped(name: str, array: FloatArray, width: tuple[int, ...]) -> FloatArray:
    if array.shape[max(array.ndim - len(width), 0) :] != width:
        raise ValueError(f"{name}: expected shape (..., {', '.join(map(str, width))}), got {array.shape}")
    return array


def _at(index: NDArray[np.intp]) -> str:
    """Where in an array, for a message; nothing of an array without axes."""
    place = tuple(int(i) for i in index)
    return f" at index {place[0] if len(place) == 1 else place}" if place else ""
