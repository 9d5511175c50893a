"""One recording of an inertial sensor: what `ahrs_rs.read` returns and every filter can be given."""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _atomic

__all__ = ["Recording", "nominal_rate"]

FloatArray = NDArray[np.float64]

#: The arrays of a recording, in the order shown and saved, with their columns (0: one-dimensional).
_COLUMNS = {"t": 0, "gyr": 3, "acc": 3, "mag": 3, "ref": 4, "mask": 0, "temperature": 0}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """Samples of one sensor over time, in SI units, with the truth where it is known.

    All arrays are float64, whatever the file stored, except `mask`. NaN means "no measurement".

    Parameters
    ----------
    t : (T,) s, finite and not decreasing.
    gyr : (T, 3) angular rate in the sensor frame, rad/s.
    acc : (T, 3) specific force in the sensor frame, m/s², or None.
    mag : (T, 3) magnetic field in the sensor frame, µT, or None.
    ref : (T, 4) true orientation, scalar-first, sensor to earth, or None.
    mask : (T,) bool, the samples that count in a score, or None for all of them.
    temperature : (T,) of the sensor, °C, or None.
    rate : Hz; NaN (the default) takes 1 / median step of `t`.
    meta : what else is known: path, format, units found, repairs made.

    Raises
    ------
    ValueError
        A wrong shape, length or dtype, a decreasing `t`, or a rate that is not positive.
    """

    t: FloatArray
    gyr: FloatArray
    acc: FloatArray | None = None
    mag: FloatArray | None = None
    ref: FloatArray | None = None
    mask: NDArray[np.bool_] | None = None
    temperature: FloatArray | None = None
    rate: float = math.nan
    meta: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        length = None
        for name, columns in _COLUMNS.items():
            value = getattr(self, name)
            if value is None and name not in ("t", "gyr"):
                continue
            array = _mask(value) if name == "mask" else _float_array(name, value)
            length = len(array) if length is None and array.ndim else length
            expected = (length,) if columns == 0 else (length, columns)
            if array.shape != expected:
                shown = str(expected).replace("None", "T")
                raise ValueError(f"{name}: expected shape {shown}, got {array.shape}")
            object.__setattr__(self, name, array)
        bad = np.flatnonzero(~np.isfinite(self.t))
        if bad.size:
            raise ValueError(f"t: expected finite times, got {self.t[bad[0]]} at index {bad[0]}")
        bad = np.flatnonzero(self.t[1:] < self.t[:-1])
        if bad.size:
            raise ValueError(f"t: expected times that do not decrease, got a decrease at index {bad[0] + 1}")
        rate = float(self.rate)
        object.__setattr__(self, "rate", nominal_rate(self.t) if math.isnan(rate) else rate)
        if not (math.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"rate: expected a positive number of Hz, got {rate}")

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, key: slice) -> Recording:
        """The samples of a slice without a step, as views; `rate` and `meta` stay."""
        if not isinstance(key, slice):
            raise TypeError(f"a recording is cut by a slice, like recording[10:20], not by {key!r}")
        if key.step not in (None, 1):
            raise ValueError(f"step: a slice of a recording has step 1, got {key.step}")
        arrays = {name: value[key] for name, value in self._arrays().items()}
        return Recording(**arrays, rate=self.rate, meta=dict(self.meta))

    def __repr__(self) -> str:
        names = " ".join(name for name in self._arrays() if name != "t")
        source = f", {Path(str(self.meta['path'])).name!r}" if "path" in self.meta else ""
        return f"Recording({len(self)} samples, {self.duration:.6g} s, {self.rate:.6g} Hz, {names}{source})"

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return float(self.t[-1] - self.t[0]) if len(self) else 0.0

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write an .npz file which `ahrs_rs.read` gives back with the same arrays, rate and meta.

        Values of `meta` that JSON does not know are written as text.

        Raises
        ------
        ValueError
            If `path` does not end in .npz.
        OSError
            What was there is then as it was.
        """
        path = Path(path)
        if path.suffix.lower() != ".npz":
            raise ValueError(f"path: expected a name that ends in .npz, got {path.name!r}")
        meta = json.dumps(self.meta, default=str)
        with _atomic.binary(path) as file:
            np.savez_compressed(file, rate=np.float64(self.rate), meta=np.array(meta), **self._arrays())

    def _arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _COLUMNS if getattr(self, name) is not None}


def nominal_rate(t: FloatArray) -> float:
    """1 / median step of `t` (s), over the steps that are not zero; ValueError where there is none."""
    with np.errstate(over="ignore"):  # a step beyond the range of numbers makes a rate of zero, which is refused
        steps = np.diff(t)
    steps = steps[steps > 0]
    if not steps.size:
        raise ValueError("rate: must be given, because t has no two different times")
    return 1.0 / float(np.median(steps))


def _float_array(name: str, value: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fiu":
            raise TypeError(f"dtype {array.dtype}")
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected an array of real numbers, got {error}") from None


def _mask(value: ArrayLike) -> NDArray[np.bool_]:
    array = np.asarray(value)
    if array.dtype.kind != "b" and not (array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all()):
        raise ValueError(f"mask: expected an array of bool (or of 0 and 1), got dtype {array.dtype}")
    return array.astype(np.bool_, copy=False)
