"""Xsens MT Manager's text export: lines that begin with //, a header, one row a packet.

Acc m/s², Gyr rad/s, Mag in units of the local field; orientations from the sensor to the frame that the file names
(ENU unless set otherwise). Time is SampleTimeFine (0.1 ms, 32 bits); where that is empty, PacketCounter over the
stated rate. A lost packet shows as a jump of PacketCounter (16 bits) only.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import Table, cells, head_lines, is_number, is_text, read_table, separator_of
from ahrs_rs.io._packets import COUNTER, FINE, packet_times
from ahrs_rs.io._source import Source

#: Stream -> names of its columns.
GROUPS: dict[str, tuple[tuple[str, ...], ...]] = {
    "acc": (("Acc_X", "Acc_Y", "Acc_Z"),),
    "gyr": (("Gyr_X", "Gyr_Y", "Gyr_Z"),),
    "mag": (("Mag_X", "Mag_Y", "Mag_Z"),),
    "temperature": (("Temperature",), ("Temp",)),
    "pressure": (("Pressure",), ("Baro",)),
    "velocity": (("Vel_X", "Vel_Y", "Vel_Z"), ("Vel_E", "Vel_N", "Vel_U")),
    "quaternion": (
        ("Quat_q0", "Quat_q1", "Quat_q2", "Quat_q3"),
        ("Quat_w", "Quat_x", "Quat_y", "Quat_z"),
        ("q0", "q1", "q2", "q3"),
    ),
    "matrix": (tuple(f"Mat[{row}][{column}]" for column in (1, 2, 3) for row in (1, 2, 3)),),
    "euler": (("Roll", "Pitch", "Yaw"),),
}
COUNTERS = (COUNTER, "Counter")
FINE_UNIT = 1e-4
#: What looks like a sensor and is none of ours: increments over a sample, acceleration without gravity.
OTHERS = re.compile(r"(FreeAcc|VelInc|OriInc|RawAcc|RawGyr|RawMag|AccHR|GyrHR|dv|dq).*")


def sniff(source: Source) -> bool:
    """Whether the file begins with lines of MT Manager."""
    if not is_text(source.head):
        return False
    lines = head_lines(source.head)
    return lines[0].startswith("//") and any("PacketCounter" in line or "MT Manager" in line for line in lines)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read one device's export."""
    content = source.read()
    lines = head_lines(content)
    skip = next((index for index, line in enumerate(lines) if line.strip() and not line.startswith("//")), None)
    if skip is None:
        raise ValueError("has lines of MT Manager, but no table")
    names, separator = cells(lines[skip], separator_of(lines[skip])), separator_of(lines[skip])
    if all(is_number(name) for name in names if name):
        raise ValueError("has no header line: export it from MT Manager with the header switched on")
    found = {stream: indices for stream, choices in GROUPS.items() if (indices := _indices(names, choices))}
    if not {"acc", "gyr", "mag"} & set(found):
        raise ValueError(f"has no columns Acc_X, Gyr_X or Mag_X, only {', '.join(names)}: export inertial data")
    stamps = [names.index(name) for name in (*COUNTERS, FINE) if name in names]
    wanted = [*stamps, *(index for indices in found.values() for index in indices)]
    table = read_table(
        content, skip + 1, names, wanted, separator, decimal=_decimal(lines[skip + 1 :], separator), exact=stamps
    )
    preamble = _preamble(lines[:skip])
    data = SensorData(streams={}, meta={"repairs": table.repairs})
    t = _times(table, names, preamble, options, data)
    for stream in ("gyr", "acc", "mag", "temperature", "pressure", "velocity"):
        if stream in found:
            values = table.vectors(found[stream])
            data.streams[stream] = (t, values[:, 0] if values.shape[1] == 1 else values)
    orientation = _orientation(table, found)
    if orientation is not None:
        data.streams["device_quat"] = (t, orientation)
        data.meta["device_frame"] = preamble.get("coordinate system", "ENU")
    units = {"gyr": "rad/s", "acc": "m/s²", "mag": "normalised", "temperature": "°C", "pressure": "Pa"}
    data.meta["units"] = {stream: units[stream] for stream in data.streams if stream in units}
    data.meta["columns"] = {stream: [names[index] for index in indices] for stream, indices in found.items()}
    data.meta["info"] = preamble
    others = [name for name in names if OTHERS.fullmatch(name)]
    if others:
        data.say("ignored", f"columns {', '.join(others)}")
    return {preamble.get("deviceid", "imu"): data}


def _indices(names: Sequence[str], choices: tuple[tuple[str, ...], ...]) -> list[int]:
    for choice in choices:
        if all(name in names for name in choice):
            return [names.index(name) for name in choice]
    return []


def _decimal(rows: Sequence[str], separator: str) -> str:
    """A comma where a row has commas and is not separated by them."""
    first = next((row for row in rows if row.strip()), "")
    return "," if separator != "," and "," in first else "."


def _preamble(lines: Sequence[str]) -> dict[str, str]:
    """ "//  Key: value" of the lines, keys in lower case."""
    found = {}
    for line in lines:
        key, colon, value = line.lstrip("/ ").partition(":")
        if colon and value.strip():
            found[key.strip().lower()] = value.strip()
    return found


def _times(
    table: Table, names: Sequence[str], preamble: dict[str, str], options: Options, data: SensorData
) -> FloatArray:
    counter = next((table.columns[names.index(name)] for name in COUNTERS if name in names), None)
    clock = table.columns[names.index(FINE)] if FINE in names else None
    return packet_times(len(table), counter, clock, FINE_UNIT, _rate(preamble), options, data)


def _rate(preamble: dict[str, str]) -> float | None:
    for key in ("update rate", "sample rate", "output rate", "samplerate"):
        number = re.match(r"[\d.]+", preamble.get(key, ""))
        if number:
            rate = float(number[0].rstrip("."))
            return rate if rate > 0 else None
    return None


def _orientation(table: Table, found: dict[str, list[int]]) -> FloatArray | None:
    if "quaternion" in found:
        return _attitude.recorded(table.vectors(found["quaternion"]))
    if "matrix" in found:  # columns of the matrix one after the other
        return _attitude.from_matrix(table.vectors(found["matrix"]).reshape(-1, 3, 3).swapaxes(1, 2))
    if "euler" in found:
        roll, pitch, yaw = np.radians(table.vectors(found["euler"])).T
        return _attitude.from_euler(roll, pitch, yaw)
    return None
