"""What is applied to readings: y = S (x − b), constant or over the temperature. The core computes it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _html, _native
from ahrs_rs._stored import shown
from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration import _cal_json, _firmware
from ahrs_rs.calibration._firmware import Constants

if TYPE_CHECKING:
    from typing import Self

__all__ = ["Calibration", "TemperatureCalibration"]

CONSTANT = ("matrix", "offset")
LINES = ("gain_slope", "gain_at_zero", "bias_slope", "bias_at_zero")


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """The calibration of a three-axis sensor, y = S (x − b).

    Parameters
    ----------
    matrix : ndarray
        (3, 3) S: scale factors, soft iron, cross-axis sensitivity.
    offset : ndarray
        (3,) b, in the unit of the readings: hard iron, zero-g offset, bias.
    info : mapping, optional
        What else is known and goes into the file: how it was fitted, its uncertainty.

    Raises
    ------
    ValueError
        A wrong shape, a value that is not finite, a matrix without an inverse.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> c = ar.calibration.Calibration(np.diag([2.0, 1.0, 1.0]), [1.0, 0.0, 0.0])
    >>> c.apply([[2.0, 3.0, 4.0]])
    array([[2., 3., 4.]])
    >>> c.inverse().apply(c.apply([[2.0, 3.0, 4.0]]))
    array([[2., 3., 4.]])
    """

    matrix: FloatArray
    offset: FloatArray
    info: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "matrix", _array("matrix", self.matrix, (3, 3)))
        object.__setattr__(self, "offset", _array("offset", self.offset, (3,)))
        if not np.linalg.matrix_rank(self.matrix) == 3:
            raise ValueError(f"matrix: expected one that has an inverse, got {self.matrix.tolist()}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Calibration):
            return NotImplemented
        return np.array_equal(self.matrix, other.matrix) and np.array_equal(self.offset, other.offset)

    def __hash__(self) -> int:
        return hash((self.matrix.tobytes(), self.offset.tobytes()))

    @classmethod
    def identity(cls) -> Self:
        """The calibration that changes nothing.

        Returns
        -------
        Calibration
            S = 1, b = 0.
        """
        return cls(np.eye(3), np.zeros(3))

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [("S", "  ".join(f"{one:.5g}" for one in row)) for row in self.matrix]
        rows.append(("b", "  ".join(f"{one:.5g}" for one in self.offset)))
        rows += [(str(name), value) for name, value in self.info.items() if isinstance(value, (str, int, float))]
        return _html.summary("Calibration, y = S (x − b)", rows)

    def apply(self, x: ArrayLike) -> NDArray[np.floating[Any]]:
        """The calibrated readings (..., 3), float32 for float32 with the bits that firmware gets.

        A NaN in one axis makes all three NaN: a reading that is missing. Infinite values are a ValueError.

        Parameters
        ----------
        x : array_like
            (..., 3) readings.

        Returns
        -------
        ndarray
            (..., 3) calibrated readings.
        """
        return _native.calibrate(x, self.matrix.tolist(), self.offset.tolist())

    def inverse(self) -> Calibration:
        """The calibration that takes calibrated readings back to raw ones: x = S⁻¹ (y + S b).

        Returns
        -------
        Calibration
            From calibrated to raw.
        """
        inverse = np.linalg.inv(self.matrix).astype(np.float64, copy=False)
        return Calibration(inverse, -self.matrix @ self.offset)

    def after(self, first: Calibration) -> Calibration:
        """One calibration in place of two: `first`, and then this one.

        Parameters
        ----------
        first : Calibration
            What is applied before this one.

        Returns
        -------
        Calibration
            Both in one.
        """
        moved: FloatArray = first.offset + np.linalg.solve(first.matrix, self.offset)
        return Calibration(self.matrix @ first.matrix, moved)

    def save(self, path: str | os.PathLike[str], sensor: str) -> None:
        """Write it as that of a sensor ("gyr", "acc" or "mag"); other sensors in an existing file stay.

        Parameters
        ----------
        path : str or path-like
            A name that ends in .json.
        sensor : str
            "gyr", "acc" or "mag".
        """
        put(path, sensor, self)

    @staticmethod
    def load(path: str | os.PathLike[str], sensor: str | None = None) -> Calibration:
        """The calibration of a sensor in a file; `sensor` may be left out where the file holds one.

        Parameters
        ----------
        path : str or path-like
            Of a cal.json.
        sensor : str, optional
            "gyr", "acc" or "mag"; may be left out where the file holds one.

        Returns
        -------
        Calibration
            That of the sensor.

        Raises
        ------
        ValueError
            The file is none, holds no such sensor, or one that is calibrated over the temperature.
        """
        found = get(path, sensor)
        if not isinstance(found, Calibration):
            raise ValueError(f"{path}: is calibrated over the temperature: TemperatureCalibration.load")
        return found

    def to_rust(self, name: str = "CALIBRATION") -> str:
        """Rust source of a constant for firmware, in float32.

        Parameters
        ----------
        name : str, optional
            Of the constant.

        Returns
        -------
        str
            The source.
        """
        return _firmware.rust({name: self._constants()})

    def to_c(self, name: str = "CALIBRATION") -> str:
        """A C header with the matrix and the offset as constants, in float32.

        Parameters
        ----------
        name : str, optional
            With which the constants begin.

        Returns
        -------
        str
            The header.
        """
        return _firmware.c({name: self._constants()})

    def _constants(self) -> Constants:
        return Constants("Calibration", {name: getattr(self, name) for name in CONSTANT}, "y = S (x - b).")


@dataclass(frozen=True, slots=True, eq=False)
class TemperatureCalibration:
    """Gain and bias of each axis as lines over the temperature T in °C: 12 numbers a sensor.

    The measurement model of Hyyti & Visala 2015, x = gain(T) y + bias(T) for each axis (eq 16) with gain and bias
    a T + b (eq 17), is y = S (x − b) with S = diag(1 / gain(T)) and b = bias(T).

    Parameters
    ----------
    gain_slope, gain_at_zero : ndarray
        (3,) a (per °C) and b of the gain.
    bias_slope, bias_at_zero : ndarray
        (3,) a (per °C) and b of the bias, in the unit of the readings.
    range : tuple, optional
        The lowest and the highest temperature that it was fitted on, °C.
    covariance : ndarray, optional
        (12, 12) of the numbers in the order above, or None.
    info : mapping, optional
        What else is known and goes into the file.

    Raises
    ------
    ValueError
        A wrong shape, a value that is not finite, a gain that is not positive over `range`.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> c = ar.calibration.TemperatureCalibration(np.zeros(3), np.ones(3), np.full(3, 0.01), np.zeros(3))
    >>> c.at(20.0).offset
    array([0.2, 0.2, 0.2])
    """

    gain_slope: FloatArray
    gain_at_zero: FloatArray
    bias_slope: FloatArray
    bias_at_zero: FloatArray
    range: tuple[float, float] | None = None
    covariance: FloatArray | None = None
    info: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("gain_slope", "gain_at_zero", "bias_slope", "bias_at_zero"):
            object.__setattr__(self, name, _array(name, getattr(self, name), (3,)))
        if self.covariance is not None:
            object.__setattr__(self, "covariance", _array("covariance", self.covariance, (12, 12)))
        if self.range is not None:
            low, high = _array("range", self.range, (2,)).tolist()
            if not low <= high:
                raise ValueError(f"range: expected two temperatures in °C, got {self.range}")
            object.__setattr__(self, "range", (low, high))
            for temperature in (low, high):
                gain = self.gain_slope * temperature + self.gain_at_zero
                if not (gain > 0).all():
                    raise ValueError(f"gain: expected positive ones over the range, got {gain} at {temperature} °C")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TemperatureCalibration):
            return NotImplemented
        return self.range == other.range and np.array_equal(self.numbers, other.numbers)

    def __hash__(self) -> int:
        return hash(self.numbers.tobytes())

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [
            (name.replace("_", " "), "  ".join(f"{one:.5g}" for one in getattr(self, name))) for name in LINES
        ]
        if self.range is not None:
            rows.append(("range", f"{self.range[0]:.4g} to {self.range[1]:.4g} °C"))
        return _html.summary("Calibration over the temperature", rows)

    @property
    def numbers(self) -> FloatArray:
        """(12,): slopes of the gains, gains at 0 °C, slopes of the biases, biases at 0 °C."""
        return np.concatenate((self.gain_slope, self.gain_at_zero, self.bias_slope, self.bias_at_zero))

    def at(self, temperature: float) -> Calibration:
        """The calibration at a temperature in °C.

        Parameters
        ----------
        temperature : float
            In °C.

        Returns
        -------
        Calibration
            Constant.
        """
        gain = self.gain_slope * float(temperature) + self.gain_at_zero
        if not (gain > 0).all():
            raise ValueError(f"temperature: expected one at which every gain is positive, got {gain} at {temperature}")
        return Calibration(np.diag(1.0 / gain), self.bias_slope * float(temperature) + self.bias_at_zero)

    def apply(self, x: ArrayLike, temperature: ArrayLike) -> NDArray[np.floating[Any]]:
        """The calibrated readings (..., 3), float32 for float32 with the bits that firmware gets.

        Parameters
        ----------
        x : array_like
            (..., 3).
        temperature : array_like
            Of each reading (...), or one for all, °C. NaN is a temperature that was not measured: the
            last known one holds (before the first one: the first).

        Returns
        -------
        ndarray
            (..., 3) calibrated readings.
        """
        x = x if isinstance(x, np.ndarray) else np.asarray(x)
        held = np.broadcast_to(_held(np.asarray(temperature, dtype=np.float64)), x.shape[:-1])
        lines = [
            (slope.tolist(), at_zero.tolist())
            for slope, at_zero in ((self.gain_slope, self.gain_at_zero), (self.bias_slope, self.bias_at_zero))
        ]
        return _native.calibrate_at(x, held, *lines)

    def save(self, path: str | os.PathLike[str], sensor: str) -> None:
        """Write it as that of a sensor ("gyr", "acc" or "mag"); other sensors in an existing file stay.

        Parameters
        ----------
        path : str or path-like
            A name that ends in .json.
        sensor : str
            "gyr", "acc" or "mag".
        """
        put(path, sensor, self)

    @staticmethod
    def load(path: str | os.PathLike[str], sensor: str | None = None) -> TemperatureCalibration:
        """The calibration of a sensor in a file; `sensor` may be left out where the file holds one.

        Parameters
        ----------
        path : str or path-like
            Of a cal.json.
        sensor : str, optional
            "gyr", "acc" or "mag"; may be left out where the file holds one.

        Returns
        -------
        TemperatureCalibration
            That of the sensor.
        """
        found = get(path, sensor)
        if not isinstance(found, TemperatureCalibration):
            raise ValueError(f"{path}: is calibrated for one temperature: Calibration.load")
        return found

    def to_rust(self, name: str = "CALIBRATION") -> str:
        """Rust source of a constant for firmware, in float32.

        Parameters
        ----------
        name : str, optional
            Of what is made.

        Returns
        -------
        str
            The source.
        """
        return _firmware.rust({name: self._constants()})

    def to_c(self, name: str = "CALIBRATION") -> str:
        """A C header with the lines of gain and bias as constants, in float32.

        Parameters
        ----------
        name : str, optional
            Of what is made.

        Returns
        -------
        str
            The header.
        """
        return _firmware.c({name: self._constants()})

    def _constants(self) -> Constants:
        fitted = "" if self.range is None else f", fitted from {self.range[0]:.4g} to {self.range[1]:.4g} deg C"
        comment = f"y = (x - bias(T)) / gain(T), both slope * T + at_zero, T in deg C{fitted}."
        return Constants("TemperatureCalibration", {name: getattr(self, name) for name in LINES}, comment)


SensorCalibration: TypeAlias = Calibration | TemperatureCalibration


def load_all(path: str | os.PathLike[str]) -> dict[str, SensorCalibration]:
    """The calibrations of a file by sensor, checked."""
    path = Path(path)
    found = {}
    for sensor, content in _cal_json.read(path).items():
        try:
            found[sensor] = from_content(sensor, content)
        except ValueError as error:
            raise ValueError(f"{path}: {sensor}: {error}") from None
    return found


def get(path: str | os.PathLike[str], sensor: str | None) -> SensorCalibration:
    """The calibration of one sensor in a file."""
    found = load_all(path)
    if sensor is None:
        if len(found) != 1:
            raise ValueError(f"sensor: expected a name, as {path} holds {', '.join(found) or 'none'}, got None")
        return next(iter(found.values()))
    _cal_json.check_sensor(sensor)
    if sensor not in found:
        raise ValueError(f"{path}: holds no calibration of {sensor}, only of {', '.join(found) or 'none'}")
    return found[sensor]


def put(path: str | os.PathLike[str], sensor: str, calibration: SensorCalibration) -> None:
    """Write the calibration of one sensor; the others of an existing file stay."""
    _cal_json.check_sensor(sensor)
    found = (load_all(path) if Path(path).exists() else {}) | {sensor: calibration}
    contents = {name: to_content(name, found[name]) for name in _cal_json.UNITS if name in found}
    _cal_json.write(path, contents)


def to_content(sensor: str, calibration: SensorCalibration) -> dict[str, Any]:
    """What the file holds of a sensor."""
    names = CONSTANT if isinstance(calibration, Calibration) else LINES
    content: dict[str, Any] = {name: getattr(calibration, name).tolist() for name in names}
    if isinstance(calibration, TemperatureCalibration):
        if calibration.range is not None:
            content["range"] = list(calibration.range)
        if calibration.covariance is not None:
            content["covariance"] = calibration.covariance.tolist()
    content["unit"] = _cal_json.UNITS[sensor]
    if calibration.info:
        content["info"] = json.loads(json.dumps(dict(calibration.info), default=str))
    return content


def from_content(sensor: str, content: object) -> SensorCalibration:
    """The calibration that the file holds of a sensor; ``ValueError`` where it is none."""
    if not isinstance(content, dict):
        raise ValueError(f"expected the numbers of a sensor, got {shown(content)}")
    names = CONSTANT if "matrix" in content else LINES
    missing = [name for name in names if name not in content]
    if missing:
        raise ValueError(f"expected {' and '.join(CONSTANT)}, or {', '.join(LINES)}: there is no {missing[0]}")
    more = () if names is CONSTANT else ("range", "covariance")
    unknown = [key for key in content if key not in (*names, *more, "unit", "info")]
    if unknown:
        raise ValueError(f"expected {', '.join((*names, *more))}, unit and info, got {shown(unknown[0])}")
    unit = content.get("unit", _cal_json.UNITS[sensor])
    if not isinstance(unit, str) or unit.replace("μ", "µ") != _cal_json.UNITS[sensor]:
        raise ValueError(
            f"unit: expected {_cal_json.UNITS[sensor]}, which readings and offsets are in, got {shown(unit)}"
        )
    info = content.get("info", {})
    if not isinstance(info, dict):
        raise ValueError(f"info: expected an object, got {shown(info)}")
    numbers = [content[name] for name in names]
    if names is CONSTANT:
        return Calibration(numbers[0], numbers[1], info)
    return TemperatureCalibration(
        numbers[0], numbers[1], numbers[2], numbers[3], content.get("range"), content.get("covariance"), info
    )


def _held(temperature: FloatArray) -> FloatArray:
    """Temperatures with the last known one in place of NaN."""
    known = ~np.isnan(temperature)
    if known.all():
        return temperature
    if temperature.ndim == 0 or not known.any(axis=-1).all():
        raise ValueError("temperature: expected at least one that is known, got NaN for all")
    index = np.where(known, np.arange(temperature.shape[-1]), 0)
    index = np.maximum.accumulate(index, axis=-1)
    first = np.argmax(known, axis=-1, keepdims=True)
    return np.take_along_axis(temperature, np.maximum(index, first), axis=-1)


def _array(name: str, value: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    try:
        array = np.array(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected numbers of shape {shape}, got {error}") from None
    if array.dtype.kind not in "fiu":  # text, or whole numbers beyond 64 bits
        raise ValueError(f"{name}: expected numbers of shape {shape}, got dtype {array.dtype}")
    array = array.astype(np.float64)
    if array.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got {array.tolist()}")
    array.setflags(write=False)
    return array
