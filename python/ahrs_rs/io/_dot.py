"""Movella DOT (formerly Xsens DOT): the app's and the data exporter's CSV.

"sep=,", lines "Key:,value", a header, one row a packet. Acc m/s², Gyr in deg/s (the file does not say so), Mag in
units of the local field. Time is SampleTimeFine (µs, 32 bits: it wraps after 71.6 minutes). Lost packets are jumps of
PacketCounter. Quat_* and Euler_* are the sensor's own estimate, from the sensor to a frame with z up.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import cells, head_lines, is_text, read_table, separator_of
from ahrs_rs.io._packets import COUNTER, FINE, packet_times
from ahrs_rs.io._source import Source

GROUPS: dict[str, tuple[str, ...]] = {
    "acc": ("Acc_X", "Acc_Y", "Acc_Z"),
    "gyr": ("Gyr_X", "Gyr_Y", "Gyr_Z"),
    "mag": ("Mag_X", "Mag_Y", "Mag_Z"),
    "quaternion": ("Quat_W", "Quat_X", "Quat_Y", "Quat_Z"),
    "euler": ("Euler_X", "Euler_Y", "Euler_Z"),
}
FINE_UNIT = 1e-6
#: Columns that only this device writes.
OWN = re.compile(r"Quat_[WXYZ]|Euler_[XYZ]|dq_[WXYZ]|dv\[[123]\]|ClipCountAcc|Status")
#: What looks like a sensor and is none of ours.
OTHERS = re.compile(r"(FreeAcc_|dq_|dv\[).*")


def sniff(source: Source) -> bool:
    """Whether the file has the lines or the columns of a DOT."""
    if not is_text(source.head):
        return False
    lines = head_lines(source.head)
    header = next((line for line in lines if COUNTER in line and FINE in line), "")
    tagged = any(line.lstrip('"').startswith("DeviceTag") for line in lines)
    return tagged or bool(header and not lines[0].startswith("//") and _own(header))


def _own(header: str) -> bool:
    return any(OWN.fullmatch(name) for name in cells(header, separator_of(header)))


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read one sensor's file."""
    content = source.read()
    lines = head_lines(content)
    row = next((index for index, line in enumerate(lines) if COUNTER in line or "Acc_X" in line), None)
    if row is None:
        raise ValueError("has lines of a Movella DOT, but no header with PacketCounter")
    separator = separator_of(lines[row])
    names = cells(lines[row], separator)
    found = {
        stream: [names.index(name) for name in group] for stream, group in GROUPS.items() if set(group) <= set(names)
    }
    if not {"acc", "gyr", "mag"} & set(found):
        raise ValueError(
            f"has no columns Acc_X, Gyr_X or Mag_X, only {', '.join(names)}: record inertial data (custom mode 5)"
        )
    stamps = [names.index(name) for name in (COUNTER, FINE) if name in names]
    wanted = [*stamps, *(index for indices in found.values() for index in indices)]
    table = read_table(content, row + 1, names, wanted, separator, exact=stamps)
    preamble = _preamble(lines[:row])
    data = SensorData(streams={}, meta={"repairs": table.repairs, "info": preamble})
    stated = re.match(r"\d+(\.\d+)?", preamble.get("outputrate", ""))
    counter = table.columns[names.index(COUNTER)] if COUNTER in names else None
    clock = table.columns[names.index(FINE)] if FINE in names else None
    t = packet_times(len(table), counter, clock, FINE_UNIT, float(stated[0]) or None if stated else None, options, data)
    for stream in ("gyr", "acc", "mag"):
        if stream in found:
            values = table.vectors(found[stream])
            data.streams[stream] = (t, np.radians(values) if stream == "gyr" else values)
    if "quaternion" in found:
        data.streams["device_quat"] = (t, _attitude.recorded(table.vectors(found["quaternion"])))
    elif "euler" in found:
        roll, pitch, yaw = np.radians(table.vectors(found["euler"])).T
        data.streams["device_quat"] = (t, _attitude.from_euler(roll, pitch, yaw))
    if "device_quat" in data.streams:
        data.meta["device_frame"] = "ENU"
    units = {"gyr": "deg/s", "acc": "m/s²", "mag": "normalised"}
    data.meta["units"] = {stream: units[stream] for stream in data.streams if stream in units}
    data.meta["columns"] = {stream: [names[index] for index in indices] for stream, indices in found.items()}
    others = [name for name in names if OTHERS.fullmatch(name)]
    if others:
        data.say("ignored", f"columns {', '.join(others)}")
    return {preamble.get("devicetag") or "imu": data}


def _preamble(lines: Sequence[str]) -> dict[str, str]:
    """ "Key:,value" of the lines, keys in lower case without blanks."""
    found = {}
    for line in lines:
        key, colon, value = line.partition(":")
        if colon:
            found[re.sub(r"\W", "", key.lower())] = value.strip(' ,"\t;')
    return found
