"""Calibrations of a sensor's parts together."""

from __future__ import annotations

import dataclasses
import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ahrs_rs._recording import Recording
from ahrs_rs.calibration import _cal_json, _firmware
from ahrs_rs.calibration._cal_json import UNITS
from ahrs_rs.calibration._common import CalibrationWarning
from ahrs_rs.calibration._model import Calibration, SensorCalibration, TemperatureCalibration, load_all, to_content

__all__ = ["Calibrations", "load"]


@dataclass(frozen=True, slots=True)
class Calibrations:
    """What is known of a sensor's parts; None is a part whose readings stay as they are.

    Parameters
    ----------
    gyr : Calibration or TemperatureCalibration, optional
        Of the gyroscope.
    acc : Calibration or TemperatureCalibration, optional
        Of the accelerometer.
    mag : Calibration or TemperatureCalibration, optional
        Of the magnetometer.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> c = ar.calibration.Calibrations(mag=ar.calibration.Calibration.identity())
    >>> [sensor for sensor, _ in c]
    ['mag']
    """

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

    def _repr_html_(self) -> str:
        parts = [f"<p><b>{sensor}</b></p>\n{calibration._repr_html_()}" for sensor, calibration in self]
        return "\n".join(parts) or "<p>No sensor is calibrated.</p>"

    def apply(self, recording: Recording) -> Recording:
        """The recording with calibrated readings; a sensor that it lacks is passed over.

        Parameters
        ----------
        recording : Recording
            Raw readings.

        Returns
        -------
        Recording
            With calibrated readings.

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

        Parameters
        ----------
        path : str or path-like
            A name that ends in .json.

        Raises
        ------
        ValueError
            No sensor is calibrated, or `path` does not end in .json.
        """
        _cal_json.write(path, {sensor: to_content(sensor, calibration) for sensor, calibration in self})

    def to_rust(self) -> str:
        """Rust source with a constant for each sensor (`GYR`, `ACC`, `MAG`), in float32.

        Returns
        -------
        str
            The source.
        """
        return _firmware.rust({sensor.upper(): calibration._constants() for sensor, calibration in self})

    def to_c(self) -> str:
        """A C header with the constants of each sensor, in float32.

        Returns
        -------
        str
            The header.
        """
        return _firmware.c({sensor.upper(): calibration._constants() for sensor, calibration in self})


def load(path: str | os.PathLike[str]) -> Calibrations:
    """The calibrations of a file that `Calibrations.save` wrote.

    Parameters
    ----------
    path : str or path-like
        Of a cal.json.

    Returns
    -------
    Calibrations
        Of all sensors in the file.

    Raises
    ------
    ValueError
        It is no such file, is of a newer version, or lacks a number.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "cal.json")
    ...     ar.calibration.Calibration.identity().save(path, "mag")
    ...     found = ar.calibration.load(path)
    >>> found.mag.offset
    array([0., 0., 0.])
    """
    return Calibrations(**load_all(path))


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
