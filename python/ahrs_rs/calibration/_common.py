"""What the fits share: reading arrays, and what is said where they are not what they should be."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _arrays
from ahrs_rs._typing import FloatArray

AXES = "xyz"


class CalibrationError(ValueError):
    """The data cannot determine what is asked for; the message says what to record.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> issubclass(ar.calibration.CalibrationError, ValueError)
    True
    """


class CalibrationWarning(UserWarning):
    """A calibration that was computed, and that should be looked at.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> issubclass(ar.calibration.CalibrationWarning, UserWarning)
    True
    """


def readings(name: str, value: ArrayLike) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Readings (T, 3) in float64, and which rows are there (no NaN); a ValueError for anything else."""
    value = _arrays.vectors(name, value)
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu":
            raise TypeError(f"dtype {array.dtype}")
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected an array of real numbers, got {error}") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: expected shape (T, 3), got {array.shape}")
    x: FloatArray = array.astype(np.float64, copy=False)
    total = x.sum(axis=1)  # a row that is not finite has a sum that is not
    valid = np.isfinite(total)
    if not valid.all():
        infinite = np.flatnonzero(np.isinf(x).any(axis=1))
        if infinite.size:
            raise ValueError(
                f"{name}: expected finite values or NaN (missing), got an infinite one at row {infinite[0]}"
            )
        valid = ~np.isnan(x).any(axis=1)
    return x, valid


def vector(name: str, value: ArrayLike, length: int) -> FloatArray:
    """One number for each reading, in float64."""
    value = _arrays.vectors(name, value)
    try:
        array: FloatArray = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected an array of real numbers, got {error}") from None
    if array.shape != (length,):
        raise ValueError(f"{name}: expected shape ({length},), got {array.shape}")
    return array


def count_of(value: Any, options: tuple[int, ...]) -> int:
    """The number of parameters of a fit, one of those that there are."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value not in options:
        listed = f"{', '.join(map(str, options[:-1]))} or {options[-1]}"
        raise ValueError(f"parameters: expected {listed}, got {value!r}")
    return int(value)


def several(name: str, value: Any, what: str) -> list[Any]:
    """The parts of an argument that has several: a list, a tuple, or what else can be gone through."""
    if not isinstance(value, (str, bytes, Mapping)):
        try:
            return list(value)
        except TypeError:
            pass
    raise ValueError(f"{name}: expected {what}, got {type(value).__name__}")
