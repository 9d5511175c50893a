"""GoPro's MP4 with its metadata track, through telemetry-parser in a process of its own.

rad/s and m/s² in the camera's axes, which the library finds from the file (ORIN, ORIO and MTRX). There is no stamp a
sample: each payload (about a second) has a start and a length, over which its samples are spread evenly; the
gyroscope and the accelerometer each by its own count. What is lost of TSMP, the count of samples, is told. Damaged
files make the library panic or want gigabytes, so a child process reads.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs.io._child import read_in_child
from ahrs_rs.io._contents import Options, SensorData, require
from ahrs_rs.io._library import refuse, understood
from ahrs_rs.io._source import Source

WHAT = "GoPro video"
GROUPS = {"gyr": "Gyroscope", "acc": "Accelerometer", "mag": "Magnetometer"}
#: Unit as the file has it -> factor to SI.
UNITS = {"rad/s": 1.0, "deg/s": np.pi / 180.0, "m/s²": 1.0, "m/s^2": 1.0, "g": GRAVITY, "μT": 1.0, "µT": 1.0, "uT": 1.0}
#: What a video without a telemetry of a GoPro is told.
NOTHING = "is a video without the telemetry of a GoPro (HERO5 or later)"


def sniff(source: Source) -> bool:
    """Whether the file is an MP4 or MOV."""
    return source.head[4:8] == b"ftyp"


def prepare() -> None:
    """What the child imports before its memory is bounded."""
    require("telemetry_parser", extra="video")


def in_child(path: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The rows of each stream with the index of their payload, and the payloads' starts and lengths."""
    parser = require("telemetry_parser", extra="video")
    with understood(WHAT):
        file = parser.Parser(path)
        payloads = file.telemetry()
        imu = file.normalized_imu()
        if str(file.camera) != "GoPro":
            raise refuse(f"is a video of {file.camera}, which is not read: only GoPro's is")
        arrays: dict[str, Any] = {"stamps": np.array([row["timestamp_ms"] for row in imu], dtype=np.float64) / 1e3}
        units: dict[str, str] = {}
        orders: dict[str, str] = {}
        for stream, group in GROUPS.items():
            parts, counts, totals = [], [], []
            for payload in payloads:
                held = payload.get(group, {})
                rows = held.get("Data") or []
                if rows:
                    scale = held.get("Scale", 1)
                    parts.append(
                        _turned(
                            np.array([[row["x"], row["y"], row["z"]] for row in rows]) / scale, held.get("Orientation")
                        )
                    )
                    units[stream], orders[stream] = (
                        str(held.get("Unit", "")),
                        str(held.get("OrientationIn") or held.get("Orientation")),
                    )
                counts.append(len(rows))
                totals.append(int(held.get("Count", 0)))
            if parts:
                arrays[stream], arrays[f"{stream}_counts"] = np.vstack(parts), np.array(counts)
                arrays[f"{stream}_totals"] = np.array(totals)
        return arrays, {"units": units, "orders": orders, "model": str(file.model or ""), "payloads": len(payloads)}


def _turned(rows: FloatArray, order: Any) -> FloatArray:
    """Rows in the camera's axes: each letter names the channel, a small one with the other sign."""
    if not isinstance(order, str) or len(order) != 3 or set(order.lower()) != set("xyz"):
        return rows
    return np.column_stack([rows[:, "xyz".index(one.lower())] * (1.0 if one.isupper() else -1.0) for one in order])


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the camera's motion sensors."""
    require("telemetry_parser", extra="video")
    with source.file() as path:
        arrays, told = read_in_child("_gopro", path, WHAT)
    if "gyr_counts" not in arrays:
        raise ValueError(NOTHING)
    starts, lengths = _payloads(arrays["stamps"], arrays["gyr_counts"], arrays["gyr_totals"])
    data = SensorData({}, meta={"units": told["units"], "clock": "of the video, spread over each payload"})
    data.meta["axes"] = "of the camera, as telemetry-parser orders them"
    data.meta["info"] = {"model": told["model"], "order in the file": told["orders"]}
    for stream in GROUPS:
        if stream not in arrays:
            continue
        unit = told["units"][stream]
        if unit not in UNITS:
            raise ValueError(f"{GROUPS[stream]}: unknown unit {unit!r}; known are {', '.join(UNITS)}")
        counts = arrays[f"{stream}_counts"]
        data.streams[stream] = (_spread(starts, lengths, counts), arrays[stream] * UNITS[unit])
        lost = _lost(counts, arrays[f"{stream}_totals"])
        if lost:
            data.say("lost", f"{lost} samples of {stream} by TSMP, the count of samples; they are a gap in time")
    return {"camera": data}


def _payloads(stamps: FloatArray, counts: Any, totals: Any) -> tuple[FloatArray, FloatArray]:
    """Start and length of each payload, s, from the library's stamps of the gyroscope's rows.

    The library spreads all rows evenly, over a lost payload too. TSMP, the running total, tells what was lost before a
    payload: it and all later ones start as much later.
    """
    if int(counts.sum()) != len(stamps):
        raise ValueError(f"is damaged: {int(counts.sum())} rows of the gyroscope and {len(stamps)} stamps")
    if len(stamps) < 2:
        raise ValueError("has fewer than two rows of the gyroscope")
    step = float(np.median(np.diff(stamps)))
    starts, late, end = np.zeros(len(counts)), 0.0, 0
    for index, count in enumerate(counts):
        first = stamps[end] if end < len(stamps) else stamps[-1] + step
        lost = _lost_before(index, counts, totals)
        if lost and end:  # as far as the stamps do not show it themselves
            late += max(lost * step - max(first - stamps[end - 1] - step, 0.0), 0.0)
        starts[index] = first + late
        end += int(count)
    return starts, step * np.maximum(counts, 1)


def _spread(starts: FloatArray, lengths: FloatArray, counts: Any) -> FloatArray:
    """The times of a stream's rows, evenly over each payload."""
    index = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    times: FloatArray = starts[index] + lengths[index] * within / counts[index]
    return times


def _lost_before(index: int, counts: Any, totals: Any) -> int:
    """How many samples are missing between a payload and the one before, by the running total."""
    if index == 0 or not (totals[index] and totals[index - 1]):
        return 0
    return int(max(totals[index] - counts[index] - totals[index - 1], 0))


def _lost(counts: Any, totals: Any) -> int:
    """Samples that the running total has and the payloads have not."""
    return sum(_lost_before(index, counts, totals) for index in range(len(counts)))
