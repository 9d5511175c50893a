"""APDM (Opal; Moveo, Mobility Lab, Motion Studio): HDF5 files and CSV exports, several sensors side by side.

rad/s, m/s², µT, times in µs since 1970; orientations scalar-first from the sensor to the earth frame (NWU).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData, SensorInfo
from ahrs_rs.io._hdf5 import array, opened
from ahrs_rs.io._library import refuse, understood
from ahrs_rs.io._lines import cells, head_lines, is_text, read_table
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

HDF5 = b"\x89HDF\r\n\x1a\n"
#: Stream -> names of the data set, of versions 5 and 2 to 4.
DATASETS = {
    "gyr": ("Gyroscope", "Gyroscopes"),
    "acc": ("Accelerometer", "Accelerometers"),
    "mag": ("Magnetometer", "Magnetometers"),
    "temperature": ("Temperature",),
    "pressure": ("Barometer",),
}
UNITS = {"gyr": "rad/s", "acc": "m/s²", "mag": "µT", "temperature": "°C", "pressure": "kPa"}
#: Stream -> group of a CSV of format 7, with its axes.
FORMAT_7 = {
    "acc": ("Accelerometer", "XYZ"),
    "gyr": ("Gyroscope", "XYZ"),
    "mag": ("Magnetometer", "XYZ"),
    "pressure": ("Barometer", ("",)),
    "device_quat": ("Orientation", "SXYZ"),
}
#: Stream -> quantity in a name such as Lumbar/Static/Acceleration/X, with its axes.
NAMED = {
    "acc": ("Acceleration", "XYZ"),
    "gyr": ("Angular Velocity", "XYZ"),
    "mag": ("Magnetic Field", "XYZ"),
    "device_quat": ("Orientation", ("Scalar", "X", "Y", "Z")),
    "temperature": ("Temperature", ("",)),
    "pressure": ("Air Pressure", ("",)),
}
WHAT = "HDF5 file of APDM"
CLOCK = "synchronised, µs since 1970"
FRAME = "NWU"


def sniff_hdf5(source: Source) -> bool:
    """Whether an HDF5 file has sensors of APDM."""
    if not source.head.startswith(HDF5):
        return False
    try:
        with opened(source) as file:
            return "Sensors" in file or any("Calibrated" in file[name] for name in file if _is_group(file[name]))
    except ValueError:  # damaged: the reader says how
        return False


def _is_group(item: Any) -> bool:
    return hasattr(item, "keys")


def _devices(file: Any) -> dict[str, tuple[str, Any]]:
    """Sensor's name -> (its number, its group): the label where each has one of its own."""
    root = file.get("Sensors", file)
    groups = {name: root[name] for name in root if _is_group(root[name])}
    if "Sensors" not in file:
        groups = {name: group for name, group in groups.items() if "Calibrated" in group}
    labels = {name: _label(group) for name, group in groups.items()}
    unique = len({label for label in labels.values() if label}) == len(labels)
    return {labels[name] if unique else name: (name, group) for name, group in groups.items()}


def _label(group: Any) -> str:
    attributes = dict(group["Configuration"].attrs) if "Configuration" in group else dict(group.attrs)
    for key in ("Label 0", "Label", "MonitorLabel"):
        if key in attributes:
            value = attributes[key]
            return (value.decode("latin-1") if isinstance(value, bytes) else str(value)).strip("\0 ")
    return ""


def sensors_hdf5(source: Source, options: Options) -> list[SensorInfo]:
    """The sensors of a file, from the shapes of its data sets."""
    with opened(source) as file, understood(WHAT):
        found = []
        for name, (_, group) in _devices(file).items():
            held = group.get("Calibrated", group)
            counts = {stream: _length(held, keys) for stream, keys in DATASETS.items()}
            samples = {stream: count for stream, count in counts.items() if count is not None}
            found.append(SensorInfo(name, samples, dict.fromkeys(samples)))
        return found


def _length(group: Any, keys: Sequence[str]) -> int | None:
    return next((max(group[key].shape) for key in keys if key in group), None)


def load_hdf5(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the sensors of a file."""
    with opened(source) as file, understood(WHAT):
        devices = _devices(file)
        if not devices:
            raise refuse("is an HDF5 file of APDM without sensors")
        wanted = {
            name: device
            for name, device in devices.items()
            if options.sensor in (None, name, device[0]) or not options.sensor
        } or devices
        return {name: _hdf5_sensor(file, number, group) for name, (number, group) in wanted.items()}


def _hdf5_sensor(file: Any, number: str, group: Any) -> SensorData:
    held = group.get("Calibrated", group)
    clock = next((part["Time"] for part in (group, held) if "Time" in part), None)
    if clock is None:
        raise refuse(f"has no times of sensor {number}")
    stamps = array(clock).reshape(-1)
    times, origin = seconds({"t": stamps}, 1e-6)
    data = SensorData(streams={}, meta={"units": {}, "clock": CLOCK, "info": {"number": number}})
    start = utc(origin)
    if start:
        data.meta["start"] = start
    for stream, keys in DATASETS.items():
        key = next((key for key in keys if key in held), None)
        if key is not None:
            values = array(held[key]).astype(np.float64)
            if (
                values.ndim == 2 and values.shape[0] in (1, 3) and values.shape[1] == len(stamps)
            ):  # older: a row an axis
                values = values.T
            values = values.reshape(len(values), -1)
            if len(values) != len(stamps):
                raise refuse(f"has {len(values)} rows of {key} and {len(stamps)} times of sensor {number}")
            scale = 1e3 if stream == "pressure" else 1.0
            data.streams[stream] = (times["t"], values[:, 0] * scale if values.shape[1] == 1 else values)
            data.meta["units"][stream] = UNITS[stream]
    for place in (f"Processed/{number}/Orientation", f"{number}/Orientation"):
        if place in file and file[place].shape == (len(stamps), 4):
            data.streams["device_quat"] = (times["t"], _attitude.recorded(array(file[place])))
            data.meta["device_frame"] = FRAME
            break
    return data


# -- CSV ---------------------------------------------------------------------------------------------------------------


def sniff_csv(source: Source) -> bool:
    """Whether the file begins with "Format=7" or "Test Name:", or its columns are called Label/Acceleration/X."""
    if not is_text(source.head):
        return False
    lines = head_lines(source.head)[:4]
    return lines[0].startswith("Format=7") or any(
        "/Acceleration/X" in line or "/Angular Velocity/X" in line for line in lines
    )


def load_csv(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the sensors of an export."""
    content = source.read()
    lines = head_lines(content)
    if lines[0].startswith("Format="):
        skip, found, names = 3, *_format_7([cells(line, ",") for line in lines[:3]])
        rate, unit = None, 1e-6
    else:
        row = next(
            (i for i, line in enumerate(lines[:6]) if "/Acceleration/X" in line or "/Angular Velocity/X" in line), 0
        )
        names = cells(lines[row], ",")
        found = _named(names)
        units = cells(lines[row + 1], ",") if len(lines) > row + 1 else []
        skip, unit = row + 2, {"us": 1e-6, "ms": 1e-3}.get(units[0].lower().replace("µ", "u") if units else "s", 1.0)
        _check_units(names, units, found)
        rate = _stated_rate(lines[:row])
    if not any({"acc", "gyr", "mag"} & set(streams) for streams in found.values()):
        raise ValueError(
            f"has no accelerometer, gyroscope or magnetometer among {', '.join(filter(None, names))}"[:300]
        )
    clock = next((index for index, name in enumerate(names) if name.strip().lower() == "time"), None)
    chosen = {name: streams for name, streams in found.items() if options.sensor in (None, name)} or found
    wanted = [index for streams in chosen.values() for group in streams.values() for index in group]
    table = read_table(content, skip, names, [*wanted, *([] if clock is None else [clock])], ",", exact=[0])
    out = {}
    t, start = None, None
    if clock is not None:
        times, origin = seconds({"t": table.columns[clock]}, unit)
        t, start = times["t"], utc(origin)
    elif rate is None and options.rate is None:
        raise ValueError("has neither a column Time nor a sample rate: give rate=")
    for name, streams in chosen.items():
        data = SensorData(streams={}, rate=None if clock is not None else rate or options.rate)
        data.meta = {
            "repairs": list(table.repairs),
            "units": {},
            "columns": {},
            "clock": CLOCK if unit == 1e-6 else "Time",
        }
        if start:
            data.meta["start"] = start
        for stream, group in streams.items():
            values = table.vectors(group)
            data.meta["columns"][stream] = [names[index] for index in group]
            if stream == "device_quat":
                data.streams[stream] = (t, _attitude.recorded(values))
                data.meta["device_frame"] = FRAME
            elif stream == "pressure":
                data.streams[stream] = (t, _pressure(values[:, 0], data))
            else:
                data.streams[stream] = (t, values[:, 0] if values.shape[1] == 1 else values)
            if stream in UNITS:
                data.meta["units"][stream] = UNITS[stream]
        out[name] = data
    return out


def _format_7(header: list[list[str]]) -> tuple[dict[str, dict[str, list[int]]], list[str]]:
    """Sensor -> stream -> columns, from the three lines: number and label of a sensor, group, axis."""
    if len(header) < 3:
        raise ValueError("has a header of fewer than three lines")
    devices, groups, axes = ([*line, *[""] * (len(header[1]) - len(line))] for line in header)
    starts = [index for index in range(1, len(groups)) if devices[index] and groups[index] == "Accelerometer"]
    names = [f"{group} {axis}".strip() for group, axis in zip(_filled(groups), axes, strict=False)]
    names[0] = "Time"
    found: dict[str, dict[str, list[int]]] = {}
    labels = [next((one for one in devices[start + 1 : start + 4] if one), devices[start]) for start in starts]
    for start, label, end in zip(starts, labels, [*starts[1:], len(groups)], strict=True):
        name = label if labels.count(label) == 1 else devices[start]
        streams = {}
        for stream, (group, parts) in FORMAT_7.items():
            wanted = [f"{group} {part}".strip() for part in parts]
            indices = [index for one in wanted for index in range(start, end) if names[index] == one]
            if len(indices) == len(wanted):
                streams[stream] = indices
        found[name] = streams
    return found, names


def _filled(groups: Sequence[str]) -> list[str]:
    """Each empty cell takes the group to its left."""
    out: list[str] = []
    for group in groups:
        out.append(group or (out[-1] if out else ""))
    return out


def _named(names: Sequence[str]) -> dict[str, dict[str, list[int]]]:
    """Sensor -> stream -> columns, from names such as Lumbar/Acceleration/X."""
    found: dict[str, dict[str, list[int]]] = {}
    devices = dict.fromkeys(name.rsplit("/", 2)[0] for name in names if name.count("/") >= 2)
    for device in devices:
        for stream, (quantity, axes) in NAMED.items():
            wanted = [f"{device}/{quantity}/{axis}".rstrip("/") for axis in axes]
            if all(one in names for one in wanted):
                found.setdefault(device, {})[stream] = [names.index(one) for one in wanted]
    return found


def _check_units(names: Sequence[str], units: Sequence[str], found: dict[str, dict[str, list[int]]]) -> None:
    """APDM writes SI units; others are refused rather than guessed."""
    expected = {"acc": ("m/s^2", "m/s²", "m/s/s"), "gyr": ("rad/s",), "mag": ("uT", "µT", "μT")}
    for streams in found.values():
        for stream, indices in streams.items():
            for index in indices if stream in expected else ():
                unit = units[index] if index < len(units) else ""
                if unit and unit not in expected[stream]:
                    raise ValueError(f"column {names[index]!r}: expected unit {expected[stream][0]}, got {unit!r}")


def _stated_rate(lines: Sequence[str]) -> float | None:
    for line in lines:
        match = re.match(r'"?sample rate:?"?\s*,\s*"?([\d.]+)', line, re.I)
        if match and float(match[1]) > 0:
            return float(match[1])
    return None


def _pressure(values: FloatArray, data: SensorData) -> FloatArray:
    """Pressure, Pa. Some exports of format 7 wrote the eight bytes of the float64 (kPa) as an integer."""
    bits = np.nan_to_num(values)
    if values.size and np.nanmedian(values) > 2.0**61 and (bits < 2.0**63).all():
        values = np.where(np.isfinite(values), bits.astype(np.int64).view(np.float64), np.nan)
        data.say("repairs", "pressure: numbers that are the bytes of a float64 are read as that")
    return values * 1e3
