"""x-io's x-IMU3 and NGIMU: a folder a device, a CSV file a message, each with stamps of its own.

x-IMU3 (its converter): "Timestamp (us)", deg/s, g, a.u. NGIMU (its logger): "Time (s)", deg/s, g, µT, hPa. The
quaternion is the device's estimate, from the sensor to the earth frame (NWU unless set otherwise).
"""

from __future__ import annotations

import json
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._constants import GRAVITY
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import head_lines, is_text, read_named
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

#: File, in lower case -> stream -> its columns without units, and the factor to SI.
XIMU3: dict[str, dict[str, tuple[tuple[str, ...], float]]] = {
    "inertial.csv": {
        "gyr": (tuple(f"Gyroscope {axis}" for axis in "XYZ"), np.pi / 180.0),
        "acc": (tuple(f"Accelerometer {axis}" for axis in "XYZ"), GRAVITY),
    },
    "magnetometer.csv": {"mag": (("X", "Y", "Z"), 1.0)},
    "highgaccelerometer.csv": {"acc_high_range": (("X", "Y", "Z"), GRAVITY)},
    "temperature.csv": {"temperature": (("Temperature",), 1.0)},
    "quaternion.csv": {"device_quat": (("W", "X", "Y", "Z"), 1.0)},
    "linearacceleration.csv": {"linear_acceleration": (("X", "Y", "Z"), GRAVITY)},
    "rotationmatrix.csv": {"matrix": (("XX", "XY", "XZ", "YX", "YY", "YZ", "ZX", "ZY", "ZZ"), 1.0)},
    "eulerangles.csv": {"euler": (("Roll", "Pitch", "Yaw"), np.pi / 180.0)},
}
NGIMU: dict[str, dict[str, tuple[tuple[str, ...], float]]] = {
    "sensors.csv": {
        "gyr": (tuple(f"Gyroscope {axis}" for axis in "XYZ"), np.pi / 180.0),
        "acc": (tuple(f"Accelerometer {axis}" for axis in "XYZ"), GRAVITY),
        "mag": (tuple(f"Magnetometer {axis}" for axis in "XYZ"), 1.0),
        "pressure": (("Barometer",), 100.0),
    },
    "quaternion.csv": {"device_quat": (("W", "X", "Y", "Z"), 1.0)},
    "linear.csv": {"linear_acceleration": (("X", "Y", "Z"), GRAVITY)},
    "euler.csv": {"euler": (("Roll", "Pitch", "Yaw"), np.pi / 180.0)},
}
UNITS = {"gyr": "deg/s", "acc": "g", "acc_high_range": "g", "linear_acceleration": "g"}
FRAME = "NWU"
#: The recording of an x-IMU3 before it is converted.
UNCONVERTED = ".ximu3"


def sniff(source: Source) -> bool:
    """Whether a folder has the files of a device, or the file is one of them, or not yet converted."""
    if source.name.lower().endswith(UNCONVERTED):
        return True
    if source.names:
        return bool(_devices(source))
    name = source.name.lower()
    if (name not in XIMU3 and name not in NGIMU) or not is_text(source.head):
        return False
    first = head_lines(source.head)[0]
    return (
        first.startswith("Timestamp (us)")
        if name in XIMU3 and name != "quaternion.csv"
        else first.startswith(("Timestamp (us)", "Time (s)"))
    )


def _devices(source: Source) -> dict[str, list[str]]:
    """Folder of a device -> its files."""
    found: dict[str, list[str]] = {}
    for name in source.names:
        path = PurePosixPath(name)
        if path.name.lower() in XIMU3 or path.name.lower() in NGIMU:
            found.setdefault(path.parent.as_posix(), []).append(name)
    kept = {}
    for folder, files in found.items():
        main = next(
            (file for file in files if PurePosixPath(file).name.lower() in ("inertial.csv", "sensors.csv")), files[0]
        )
        if head_lines(source.read(main, 4096))[0].startswith(("Timestamp (us)", "Time (s)")):
            kept[folder] = files
    return kept


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read all devices of a folder, or one file."""
    if source.name.lower().endswith(UNCONVERTED):
        raise ValueError(
            "is an x-IMU3 file that is not converted: convert it (x-IMU3 GUI, ximu3's FileConverter), read the folder"
        )
    if not source.names:
        return {"imu": _device(source, [""])}
    devices = _devices(source)
    names = {folder: _name(source, folder) for folder in devices}
    if len(set(names.values())) < len(names):
        names = {folder: folder for folder in devices}
    wanted = {folder: files for folder, files in devices.items() if options.sensor in (None, names[folder])} or devices
    return {names[folder]: _device(source, files) for folder, files in wanted.items()}


def _name(source: Source, folder: str) -> str:
    """Serial number, as the device has told it; the folder's name otherwise."""
    path = f"{folder}/Command.json" if folder != "." else "Command.json"
    if path in source.names:
        try:
            commands = json.loads(source.read(path))
            ping: Any = next((one["ping"] for one in commands if isinstance(one, dict) and "ping" in one), {})
            if isinstance(ping, dict) and str(ping.get("sn", "")):
                return str(ping["sn"])
        except ValueError:
            pass
    return folder if folder != "." else "imu"


def _device(source: Source, files: list[str]) -> SensorData:
    stamps: dict[str, NDArray[Any]] = {}
    values: dict[str, Any] = {}
    units, columns, repairs, unit = {}, {}, [], 1e-6
    for file in files:
        kind = PurePosixPath(file or source.name).name.lower()
        try:
            table = read_named(source.read(file or None), exact=["Timestamp (us)"])
        except ValueError as error:
            if "no rows" in str(error):  # a message that was never sent
                continue
            raise ValueError(f"{kind}: {error}") from error
        bare = {name.partition("(")[0].strip(): name for name in table.columns}
        clock = next((name for name in table.columns if name.startswith(("Timestamp", "Time"))), None)
        if clock is None:
            raise ValueError(f"{kind}: has no column Timestamp, only {', '.join(table.names)}"[:300])
        unit = 1e-6 if clock.endswith("(us)") else 1.0
        for stream, (wanted, factor) in (XIMU3 if unit == 1e-6 else NGIMU).get(kind, {}).items():
            if set(wanted) <= set(bare):
                names = [bare[name] for name in wanted]
                stamps[stream], values[stream] = table.columns[clock], table.vectors(names) * factor
                columns[stream] = names
        repairs += [f"{kind}: {sentence}" for sentence in table.repairs]
    if "mag" in values:
        units["mag"] = "normalised" if unit == 1e-6 else "µT"
    if not {"gyr", "acc", "mag"} & set(values):
        raise ValueError("has no gyroscope, accelerometer or magnetometer with rows")
    if "matrix" in values:
        stamps["device_quat"] = stamps.setdefault("device_quat", stamps["matrix"])
        matrix = _attitude.from_matrix(values.pop("matrix").reshape(-1, 3, 3))
        values.setdefault("device_quat", matrix)
        del stamps["matrix"]
    if "euler" in values:
        euler = _attitude.from_euler(*values.pop("euler").T)
        if "device_quat" not in values:
            stamps["device_quat"], values["device_quat"] = stamps["euler"], euler
        del stamps["euler"]
    times, origin = seconds(stamps, unit)
    shared = {id(stamp): times[name] for name, stamp in reversed(stamps.items())}
    used = {stream: names for stream, names in columns.items() if stream in values}
    meta: dict[str, Any] = {"repairs": repairs, "columns": used, "clock": "of the device"}
    meta["units"] = {**{stream: one for stream, one in UNITS.items() if stream in values}, **units}
    start = utc(origin)
    if start:
        meta["start"] = start
    if "device_quat" in values:
        values["device_quat"] = _attitude.recorded(values["device_quat"])
        meta["device_frame"] = FRAME
    return SensorData({stream: (shared[id(stamps[stream])], values[stream]) for stream in values}, meta=meta)
