"""Gyroflow's log (.gcsv): lines "key,value", a header t,gx,gy,gz,..., integers with a scale.

tscale gives s, gscale rad/s, ascale g, mscale gauss. `orientation` orders the axes as Gyroflow's camera has them.
Read here and not by telemetry-parser, which gives the field 10,000 times too small (0.3.0), and ends at an empty
cell.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ahrs_rs._constants import GRAVITY
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import cells, head_lines, is_text, read_table
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import utc

TITLES = ("GYROFLOW IMU LOG", "CAMERA IMU LOG")
#: Stream -> columns, key of the scale, factor to our unit.
GROUPS = {
    "gyr": (("gx", "gy", "gz"), "gscale", 1.0),
    "acc": (("ax", "ay", "az"), "ascale", GRAVITY),
    "mag": (("mx", "my", "mz"), "mscale", 100.0),
}
#: Names of the angular rate in the first logs.
OLDER = {"rx": "gx", "ry": "gy", "rz": "gz"}
UNITS = {"gyr": "rad/s", "acc": "g", "mag": "gauss"}


def sniff(source: Source) -> bool:
    """Whether the first line is Gyroflow's."""
    return is_text(source.head) and head_lines(source.head)[0].strip().upper().startswith(TITLES)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a log."""
    content = source.read()
    lines = head_lines(content)
    row = next(
        (i for i, line in enumerate(lines) if cells(line, ",")[:2] in (["t", "gx"], ["t", "rx"], ["t", "ax"])), None
    )
    if row is None:
        raise ValueError("has no header t,gx,gy,gz")
    names = [OLDER.get(name, name) for name in cells(lines[row], ",")]
    keys = {
        key.strip().lower(): value.strip()
        for line in lines[1:row]
        for key, comma, value in [line.partition(",")]
        if comma
    }
    found = {
        stream: [names.index(one) for one in group]
        for stream, (group, _, _) in GROUPS.items()
        if set(group) <= set(names)
    }
    table = read_table(content, row + 1, names, [0, *(one for group in found.values() for one in group)], ",")
    t = np.asarray(table.columns[0], dtype=np.float64) * _scale(keys, "tscale")
    data = SensorData(
        {}, meta={"repairs": table.repairs, "units": {}, "columns": {}, "info": keys, "clock": "of the logger"}
    )
    order = keys.get("orientation", "XYZ")
    turn = _matrix(order)
    if turn is None:
        data.say("doubts", f"orientation {order!r} is no rotation, so axes are left as in the file")
        turn = np.eye(3)
    for stream, group in found.items():
        scale = _scale(keys, GROUPS[stream][1]) * GROUPS[stream][2]
        data.streams[stream] = (t, table.vectors(group) @ turn.T * scale)
        data.meta["units"][stream], data.meta["columns"][stream] = UNITS[stream], [names[one] for one in group]
    data.meta["axes"] = "of Gyroflow's camera, by orientation"
    stamp = keys.get("timestamp", "")
    start = utc(float(stamp)) if stamp.isdigit() and len(stamp) < 12 else None
    if start:
        data.meta["info"]["recorded"] = start
    return {"camera": data}


def _scale(keys: dict[str, str], name: str) -> float:
    text = keys.get(name, "")
    try:
        scale = float(text)
    except ValueError:
        scale = 0.0
    if not (np.isfinite(scale) and scale > 0):
        raise ValueError(f"{name}: expected a positive number, got {text!r}")
    return scale


def _matrix(order: str) -> Any:
    """The rotation that an order such as YxZ stands for, None where it is none."""
    if len(order) != 3 or set(order.lower()) != set("xyz"):
        return None
    matrix = np.zeros((3, 3))
    for row, one in enumerate(order):
        matrix[row, "xyz".index(one.lower())] = 1.0 if one.isupper() else -1.0
    return matrix if np.linalg.det(matrix) > 0 else None
