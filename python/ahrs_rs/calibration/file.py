"""Calibrations of a sensor's parts together, and cal.json: a readable, versioned file of them."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ahrs_rs import _atomic, _json
from ahrs_rs._stored import shown
from ahrs_rs.recording import Recording

from ._common import CalibrationWarning
from .model import Calibration, TemperatureCalibration

__all__ = ["Calibrations", "load"]

SensorCalibration: TypeAlias = Calibration | TemperatureCalibration

FORMAT = "ahrs_rs.calibration"
VERSION = 1
#: The sensors in the order of the file, with the unit of what is calibrated.
UNITS = {"gyr": "rad/s", "acc": "m/s²", "mag": "µT"}
MODEL = "y = S (x - b)"

CONSTANT = ("matrix", "offset")
LINES = ("gain_slope", "gain_at_zero", "bias_slope", "bias_at_zero")


@dataclass(frozen=True, slots=True)
class Calibrations:
    """What is known of a sensor's parts; None is a part whose readings stay as they are."""

    gyr: SensorCalibration | None = None
    acc: SensorCalibration | None = None
    mag: SensorCalibration | None = None

    def __post_init__(self) -> None:
        for sensor in UNITS:
            value = getattr(self, sensor)
            if value is not None and not isinstance(value, SensorCalibration):
                raise ValueError(f"{sensor}: expected a Calibration or a TemperatureCalibration, got {value!r}")

    def __iter__(self) -> Iterator[tuple[str, SensorCalibration]]:
        """The sensors that are calibrated, with their calibrations."""
        return ((sensor, getattr(self, sensor)) for sensor in UNITS if getattr(self, sensor) is not None)

    def apply(self, recording: Recording) -> Recording:
        """The recording with calibrated readings; a sensor that it lacks is passed over.

        Raises
        ------
        ValueError
            A calibration over the temperature, for a recording without temperatures.

        Warns
        -----
        CalibrationWarning
            Temperatures outside of the range that the calibration was fitted on.
        """
        changes: dict[str, Any] = {}
        for sensor, calibration in self:
            readings = getattr(recording, sensor)
            if readings is None:
                continue
            if isinstance(calibration, Calibration):
                changes[sensor] = calibration.apply(readings)
                continue
            if recording.temperature is None:
                raise ValueError(f"temperature: needed for the calibration of {sensor}, and not in the recording")
            _check_range(sensor, calibration, recording.temperature)
            changes[sensor] = calibration.apply(readings, recording.temperature)
        meta = recording.meta | {"calibrated": [*recording.meta.get("calibrated", []), *changes]}
        return dataclasses.replace(recording, **changes, meta=meta)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write cal.json; what was in it goes.

        Raises
        ------
        ValueError
            No sensor is calibrated, or `path` does not end in .json.
        """
        path = Path(path)
        if path.suffix.lower() != ".json":
            raise ValueError(f"path: expected a name that ends in .json, got {path.name!r}")
        sensors = {sensor: _to_json(sensor, calibration) for sensor, calibration in self}
        if not sensors:
            raise ValueError("expected at least one sensor with a calibration, got none")
        text = json.dumps(
            {"format": FORMAT, "version": VERSION, "model": MODEL, **sensors},
            indent=2,
            ensure_ascii=False,
            allow_nan=False,
        )
        # Rows of numbers stand in one line.
        text = re.sub(r"\[[^][{}]*\]", lambda found: " ".join(found[0].split()).replace("[ ", "["), text)
        _atomic.write_text(path, text.replace(" ]", "]") + "\n")

    def to_rust(self) -> str:
        """Rust source with a constant for each sensor (`GYR`, `ACC`, `MAG`), in float32."""
        from . import firmware

        return firmware.rust({sensor.upper(): calibration for sensor, calibration in self})

    def to_c(self) -> str:
        """A C header with the constants of each sensor, in float32."""
        from . import firmware

        return firmware.c({sensor.upper(): calibration for sensor, calibration in self})


def load(path: str | os.PathLike[str]) -> Calibrations:
    """The calibrations of a file that `Calibrations.save` wrote.

    Raises
    ------
    ValueError
        It is no such file, is of a newer version, or lacks a number.
    """
    path = Path(path)
    try:
        content = _json.read(path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError(f'{path}: is not a calibration: no "format": "{FORMAT}"')
    if content.get("version") != VERSION:
        raise ValueError(f"{path}: expected version {VERSION} of the format, got {shown(content.get('version'))}")
    if content.get("model", MODEL) != MODEL:
        raise ValueError(f"{path}: model: expected {MODEL!r}, got {shown(content['model'])}")
    unknown = [key for key in content if key not in (*UNITS, "format", "version", "model")]
    if unknown:
        raise ValueError(f"{path}: expected the sensors {', '.join(UNITS)}, got {shown(unknown[0])}")
    found: dict[str, SensorCalibration] = {}
    for sensor in UNITS:
        if sensor in content:
            try:
                found[sensor] = _from_json(sensor, content[sensor])
            except ValueError as error:
                raise ValueError(f"{path}: {sensor}: {error}") from None
    return Calibrations(**found)


def get(path: str | os.PathLike[str], sensor: str | None) -> SensorCalibration:
    """The calibration of one sensor in a file."""
    found = dict(load(path))
    if sensor is None:
        if len(found) != 1:
            raise ValueError(f"sensor: expected a name, as {path} holds {', '.join(found) or 'none'}, got None")
        return next(iter(found.values()))
    _check_sensor(sensor)
    if sensor not in found:
        raise ValueError(f"{path}: holds no calibration of {sensor}, only of {', '.join(found) or 'none'}")
    return found[sensor]


def put(path: str | os.PathLike[str], sensor: str, calibration: SensorCalibration) -> None:
    """Write the calibration of one sensor; the others of an existing file stay."""
    joined(path, sensor, calibration).save(path)


def joined(path: str | os.PathLike[str], sensor: str, calibration: SensorCalibration) -> Calibrations:
    """The calibrations of a file, if it is there, with that of one sensor replaced or added."""
    _check_sensor(sensor)
    before = load(path) if Path(path).exists() else Calibrations()
    replaced: dict[str, Any] = {sensor: calibration}
    return dataclasses.replace(before, **replaced)


def _check_sensor(sensor: str) -> None:
    if sensor not in UNITS:
        raise ValueError(f"sensor: expected one of {', '.join(UNITS)}, got {sensor!r}")


def _check_range(sensor: str, calibration: TemperatureCalibration, temperature: np.ndarray) -> None:
    if calibration.range is None:
        return
    low, high = calibration.range
    outside = int(np.count_nonzero((temperature < low) | (temperature > high)))
    if outside:
        warnings.warn(
            f"{sensor} was calibrated from {low:.3g} to {high:.3g} °C; {outside} of {len(temperature)} samples are "
            f"outside ({np.nanmin(temperature):.3g} to {np.nanmax(temperature):.3g} °C)",
            CalibrationWarning,
            stacklevel=3,
        )


def _to_json(sensor: str, calibration: SensorCalibration) -> dict[str, Any]:
    names = CONSTANT if isinstance(calibration, Calibration) else LINES
    content: dict[str, Any] = {name: getattr(calibration, name).tolist() for name in names}
    if isinstance(calibration, TemperatureCalibration):
        if calibration.range is not None:
            content["range"] = list(calibration.range)
        if calibration.covariance is not None:
            content["covariance"] = calibration.covariance.tolist()
    content["unit"] = UNITS[sensor]
    if calibration.info:
        content["info"] = json.loads(json.dumps(dict(calibration.info), default=str))
    return content


def _from_json(sensor: str, content: object) -> SensorCalibration:
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
    unit = content.get("unit", UNITS[sensor])
    if not isinstance(unit, str) or unit.replace("μ", "µ") != UNITS[sensor]:
        raise ValueError(f"unit: expected {UNITS[sensor]}, which readings and offsets are in, got {shown(unit)}")
    info = content.get("info", {})
    if not isinstance(info, dict):
        raise ValueError(f"info: expected an object, got {shown(info)}")
    numbers = [content[name] for name in names]
    if names is CONSTANT:
        return Calibration(numbers[0], numbers[1], info)
    return TemperatureCalibration(
        numbers[0], numbers[1], numbers[2], numbers[3], content.get("range"), content.get("covariance"), info
    )
