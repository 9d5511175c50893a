"""The phone app Sensor Logger: a zip or folder with a CSV file a sensor, or one of these files.

What a file holds is told by its name alone; the order of its columns differs between exports. `time` is ns since
1970. Accelerometer is without gravity; TotalAcceleration (Android) is with it, elsewhere Accelerometer and Gravity
are added. iOS gives all accelerations with the other sign, unless "Standardise Units & Frames" is on; Metadata.csv
tells both.
"""

from __future__ import annotations

import csv
import re
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import header_of, is_text, read_named
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

XYZ, WXYZ = ("x", "y", "z"), ("qw", "qx", "qy", "qz")
#: File -> stream, columns, factor to SI.
FILES: dict[str, tuple[str, tuple[str, ...], float]] = {
    "gyroscope": ("gyr", XYZ, 1.0),
    "totalacceleration": ("acc", XYZ, 1.0),
    "accelerometer": ("linear_acceleration", XYZ, 1.0),
    "gravity": ("gravity", XYZ, 1.0),
    "magnetometer": ("mag", XYZ, 1.0),
    "orientation": ("device_quat", WXYZ, 1.0),
    "barometer": ("pressure", ("pressure",), 100.0),
    "compass": ("heading", ("magneticBearing",), np.pi / 180.0),
}
UNCALIBRATED = {"gyroscopeuncalibrated": "gyr", "accelerometeruncalibrated": "acc", "magnetometeruncalibrated": "mag"}
#: Accelerations, which iOS gives with the other sign.
ACCELERATIONS = ("acc", "linear_acceleration", "gravity")
CLOCK = "time"


def sniff(source: Source) -> bool:
    """Whether a folder or file has the names and columns of the app."""
    if source.names:
        return any(_kind(name) and _has_columns(source.read(name, 4096)) for name in source.names)
    return bool(_kind(source.name)) and is_text(source.head) and _has_columns(source.head)


def _kind(name: str) -> str:
    """What a file holds, by its name: Gyroscope.csv, walk_Gyroscope.csv, Gyroscope (1).csv."""
    path = PurePosixPath(name)
    if path.suffix.lower() != ".csv":
        return ""
    last = re.split(r"[_\-]", re.sub(r"\s*\(\d+\)$", "", path.stem))[-1].strip().lower()
    return last if last in FILES or last in UNCALIBRATED else ""


def _has_columns(head: bytes) -> bool:
    names = header_of(head)
    return CLOCK in names and "seconds_elapsed" in names


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the phone's sensors."""
    files = {kind: name for name in (source.names or (source.name,)) if (kind := _kind(name))}
    if not files:
        raise ValueError(
            f"has no Gyroscope.csv, Accelerometer.csv or Magnetometer.csv, only {', '.join(source.names[:6])}"
        )
    metadata = _metadata(source)
    data = SensorData(
        streams={}, meta={"repairs": [], "columns": {}, "info": metadata, "clock": "of the sensors, ns since 1970"}
    )
    data.meta["axes"] = "of the phone: x to the right, y to the top, z out of the screen"
    stamps: dict[str, NDArray[Any]] = {}
    values: dict[str, Any] = {}
    for kind, name in files.items():
        if kind in FILES:
            stream, columns, factor = FILES[kind]
            _take(source, name, stream, columns, factor, stamps, values, data)
    android = "totalacceleration" in files  # no other system has it
    flipped = _is_flipped(metadata, data, not android and any(stream in values for stream in ACCELERATIONS))
    for stream in ACCELERATIONS:
        if stream in values and flipped:
            values[stream] = -values[stream]
    _uncalibrated(source, files, metadata, stamps, values, data)
    _with_gravity(stamps, values, data)
    if not values:
        raise ValueError("has no rows in any of its files")
    times, origin = seconds(stamps, 1e-9)
    start = utc(origin)
    if start:
        data.meta["start"] = start
    shared = {stamp.tobytes(): times[name] for name, stamp in reversed(stamps.items())}
    data.streams = {stream: (shared[stamps[stream].tobytes()], values[stream]) for stream in values}
    if "device_quat" in values:
        data.streams["device_quat"] = (data.streams["device_quat"][0], _attitude.recorded(values["device_quat"]))
        data.meta["device_frame"] = "z up, x to the north" if _is_ios(metadata) else "ENU"
    units = {"gyr": "rad/s", "acc": "m/s²", "mag": "µT", "linear_acceleration": "m/s²", "gravity": "m/s²"}
    data.meta["units"] = {stream: unit for stream, unit in units.items() if stream in values}
    return {"phone": data}


def _take(
    source: Source,
    name: str,
    stream: str,
    columns: tuple[str, ...],
    factor: float,
    stamps: dict[str, NDArray[Any]],
    values: dict[str, Any],
    data: SensorData,
) -> None:
    """Add one file's stream, where the file has rows and the columns."""
    try:
        table = read_named(source.read(name if source.names else None), exact=[CLOCK], wanted=[CLOCK, *columns])
    except ValueError as error:
        if "no rows" in str(error) and source.names:  # a sensor that gave nothing
            return
        raise ValueError(f"{name}: {error}" if source.names else str(error)) from error
    if not {CLOCK, *columns} <= set(table.columns):
        raise ValueError(f"{name}: expected columns {CLOCK}, {', '.join(columns)}, got {', '.join(table.names)}"[:300])
    stamps[stream], values[stream] = table.columns[CLOCK], table.vectors(columns) * factor
    data.meta["columns"][stream] = [f"{PurePosixPath(name).name}: {column}" for column in columns]
    data.meta["repairs"] += [f"{name}: {sentence}" for sentence in table.repairs]


def _metadata(source: Source) -> dict[str, str]:
    """The row of Metadata.csv, keys in lower case."""
    name = next((name for name in source.names if PurePosixPath(name).name.lower() == "metadata.csv"), None)
    if name is None:
        return {}
    rows = list(csv.reader(source.read(name).decode("utf-8", errors="replace").splitlines()))
    return {key.strip().lower(): value for key, value in zip(rows[0], rows[1], strict=False)} if len(rows) > 1 else {}


def _is_ios(metadata: dict[str, str]) -> bool:
    return metadata.get("platform", "").strip().lower() == "ios"


def _is_flipped(metadata: dict[str, str], data: SensorData, matters: bool) -> bool:
    """Whether accelerations have the sign of iOS."""
    if "platform" not in metadata:
        if matters:
            data.say(
                "assumed",
                "accelerations have the sign of Android, as there is no Metadata.csv (on iOS all are the other way)",
            )
        return False
    return _is_ios(metadata) and metadata.get("standardisation", "").strip().lower() != "true"


def _uncalibrated(
    source: Source,
    files: dict[str, str],
    metadata: dict[str, str],
    stamps: dict[str, NDArray[Any]],
    values: dict[str, Any],
    data: SensorData,
) -> None:
    """The raw sensors, where the calibrated ones are missing; otherwise they are named as ignored."""
    for kind, stream in UNCALIBRATED.items():
        if kind not in files:
            continue
        other = {"acc": ("acc", "linear_acceleration")}.get(stream, (stream,))
        if any(one in values for one in other):
            data.say("ignored", f"{PurePosixPath(files[kind]).name}, as {other[-1]} is calibrated")
            continue
        raw = _is_ios(metadata) and metadata.get("standardisation", "").strip().lower() != "true"
        factor = -GRAVITY if stream == "acc" and raw else 1.0
        _take(source, files[kind], stream, XYZ, factor, stamps, values, data)


def _with_gravity(stamps: dict[str, NDArray[Any]], values: dict[str, Any], data: SensorData) -> None:
    """The specific force as the sum of the acceleration without gravity and gravity, where it is not in the file."""
    if "acc" in values or not {"linear_acceleration", "gravity"} <= set(values):
        if "acc" not in values and "linear_acceleration" in values:
            data.say(
                "doubts",
                "acceleration is there without gravity only (linear_acceleration): record Gravity too",
            )
        return
    clock, other = stamps["linear_acceleration"], stamps["gravity"]
    gravity = values["gravity"] if np.array_equal(clock, other) else _at(clock, other, values["gravity"])
    stamps["acc"], values["acc"] = clock, values["linear_acceleration"] + gravity
    data.meta["columns"]["acc"] = ["Accelerometer.csv + Gravity.csv"]


def _at(clock: NDArray[Any], other: NDArray[Any], rows: FloatArray) -> FloatArray:
    """Rows on the line between their neighbours, at the stamps of another clock; NaN outside."""
    first = min(clock[0], other[0])
    order = np.argsort(other, kind="stable")
    at, known = (clock - first).astype(np.float64), (other[order] - first).astype(np.float64)
    return np.column_stack([np.interp(at, known, column, left=np.nan, right=np.nan) for column in rows[order].T])
