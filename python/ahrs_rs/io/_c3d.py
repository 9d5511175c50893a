"""C3D: inertial sensors among the analog channels of a motion capture, through ezc3d in a process of its own.

Channels are found by their labels (Gyr X, ACC.Y, "Sensor 3: IM ACCX1", ...). Units are often left empty in the file,
and are then asked for: there is no usual one. There is no clock but the analog rate. Damaged files crash ezc3d, so a
child process reads.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from ahrs_rs.io._child import read_in_child
from ahrs_rs.io._contents import Options, SensorData, SensorInfo, require
from ahrs_rs.io._library import refuse, understood
from ahrs_rs.io._source import Source
from ahrs_rs.io._units import conversion

WHAT = "C3D file"
#: Stream -> what stands for it in a label. A label has one of these and an axis.
NAMES = {
    "gyr": r"gyroscope|gyros?|gyr|angular ?velocity|ang ?vel",
    "acc": r"accelerometer|acceleration|accel|acc",
    "mag": r"magnetometer|magn|mag",
}
#: A unit of each, for the message that asks for it.
EXAMPLES = {"gyr": "deg/s", "acc": "g", "mag": "uT"}
_LABEL = {
    stream: re.compile(
        rf"(?P<before>.*?)(?<![a-z])(?:{names})[ ._:\-]*(?P<number>\d*)[ ._:\-]*(?P<axis>[xyz])(?P<after>[^a-z].*)?",
        re.I,
    )
    for stream, names in NAMES.items()
}


def sniff(source: Source) -> bool:
    """Whether the second byte is C3D's key, the first points to a parameter block, and it is no text (GPS_Week,...)."""
    head = source.head
    return len(head) >= 512 and head[1] == 0x50 and 2 <= head[0] < 128 and 0 in head[:512]


def prepare() -> None:
    """What the child imports before its memory is bounded."""
    require("ezc3d", extra="c3d")


def in_child(path: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The analog channels, their labels, units and rate."""
    ezc3d = require("ezc3d", extra="c3d")
    with understood(WHAT):
        file = ezc3d.c3d(path)
        analog = file["parameters"].get("ANALOG", {})
        rate = [float(one) for one in _values(analog, "RATE")]
        labels = [str(one) for key in ("LABELS", "LABELS2", "LABELS3") for one in _values(analog, key)]
        units = [str(one) for key in ("UNITS", "UNITS2", "UNITS3") for one in _values(analog, key)]
        samples = np.asarray(file["data"]["analogs"], dtype=np.float64)
        samples = samples[0] if samples.ndim == 3 else samples.reshape(0, 0)
        held = {"rate": rate[0] if rate else 0.0, "labels": labels, "units": units, "stated": _stated(Path(path))}
        return {"samples": samples}, held


def _stated(path: Path) -> int:
    """Samples of a channel by the header, 0 where it does not tell; ezc3d takes as many as there are in silence.

    The header counts up to 65,535 frames; of a longer file, of which ezc3d reads so many, the size tells.
    """
    with path.open("rb") as file:
        head = file.read(512)
        file.seek(512 * (head[0] - 1) + 3)
        processor = file.read(1)
    words = np.frombuffer(head, dtype="<u2")
    if processor not in (b"T", b"U"):  # neither Intel nor DEC
        return 0
    points, channels, first, last, block, a_frame = (int(words[index]) for index in (1, 2, 3, 4, 8, 9))
    frames = max(last - first + 1, 0)
    if last == 0xFFFF:
        number = 4 if head[15] & 0x80 else 2  # a negative scale: float32
        frames = max((path.stat().st_size - 512 * (block - 1)) // max(number * (4 * points + channels), 1), 0)
        frames = frames if frames > last + 512 else last  # the last block is filled up
    return frames * a_frame


def _values(group: Any, key: str) -> list[Any]:
    value = group[key]["value"] if key in group else []
    return list(value)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the inertial sensors among the analog channels."""
    require("ezc3d", extra="c3d")
    with source.file() as path:
        arrays, told = read_in_child("_c3d", path, WHAT)
    samples, labels = arrays["samples"], [label.strip() for label in told["labels"]]
    found = _sensors(labels)
    if not found:
        there = ", ".join(labels[:12]) or "none"
        raise ValueError(f"has no analog channels of an inertial sensor (labelled as ACC.X, GyrX), only {there}"[:300])
    rate = options.rate or told["rate"]
    if not rate > 0:
        raise ValueError("has no analog rate: give rate=")
    units = [one.strip() for one in told["units"]] + [""] * len(labels)
    _ask_for_units(found, labels, units, options)
    sensors = {}
    for name, streams in found.items():
        data = SensorData({}, rate=rate, meta={"units": {}, "columns": {}, "clock": f"none: samples at {rate:g} Hz"})
        if told["stated"] > samples.shape[-1]:
            data.say(
                "lost",
                f"of {told['stated']} samples that the file states or has room for, {samples.shape[-1]} were read",
            )
        for stream, channels in streams.items():
            if max(channels) >= len(samples):
                raise ValueError(f"is damaged: has {len(labels)} labels and {len(samples)} analog channels")
            factor, offset, unit = _unit(
                stream, [units[one] for one in channels], [labels[one] for one in channels], options
            )
            data.streams[stream] = (None, samples[channels].T * factor + offset)
            data.meta["units"][stream], data.meta["columns"][stream] = unit, [labels[one] for one in channels]
        sensors[name] = data
    return sensors


def _sensors(labels: list[str]) -> dict[str, dict[str, list[int]]]:
    """Sensor (what labels have in common beside quantity and axis) -> stream -> channels of x, y, z."""
    found: dict[str, dict[str, dict[str, int]]] = {}
    for index, label in enumerate(labels):
        for stream, pattern in _LABEL.items():
            match = pattern.fullmatch(label)
            if match:
                parts = f"{match['before']} {match['number']} {match['after'] or ''}".replace(":", " ")
                name = " ".join(parts.split()).strip(" ._-") or "imu"
                found.setdefault(name, {}).setdefault(stream, {}).setdefault(match["axis"].lower(), index)
                break
    whole = {
        name: {stream: [axes[axis] for axis in "xyz"] for stream, axes in streams.items() if len(axes) == 3}
        for name, streams in found.items()
    }
    return {name: streams for name, streams in whole.items() if streams}


def _ask_for_units(
    found: dict[str, dict[str, list[int]]], labels: list[str], units: list[str], options: Options
) -> None:
    """An error where channels state no unit, with the option that gives it."""
    asked = options.units or {}
    bare = {
        stream: channels[0]
        for streams in found.values()
        for stream, channels in streams.items()
        if stream not in asked and not any(units[one] for one in channels)
    }
    if bare:
        shown = ", ".join(f"{stream!r}: {EXAMPLES[stream]!r}" for stream in bare)
        typed = ",".join(f"{stream}={EXAMPLES[stream]}" for stream in bare)
        names = ", ".join(f"{labels[channel]} ..." for channel in bare.values())
        raise ValueError(f"channels {names} state no unit: give it, as units={{{shown}}} (--units {typed})")


def _unit(stream: str, units: list[str], labels: list[str], options: Options) -> tuple[float, float, str]:
    """Factor and offset to our unit, by the option or the file."""
    asked = (options.units or {}).get(stream)
    if asked is None and len(set(units)) > 1:
        raise ValueError(f"channels {', '.join(labels)}: units differ among axes, {units}")
    unit = asked or units[0]
    factor, offset = conversion(stream, unit)
    return factor, offset, unit


def sensors(source: Source, options: Options) -> list[SensorInfo]:
    """The sensors by their labels."""
    with source.file() as path:
        arrays, told = read_in_child("_c3d", path, WHAT)
    count, rate = arrays["samples"].shape[-1] if arrays["samples"].size else 0, told["rate"] or None
    found = _sensors([label.strip() for label in told["labels"]])
    if not found:
        raise refuse("has no analog channels of an inertial sensor")
    return [
        SensorInfo(name, dict.fromkeys(streams, count), dict.fromkeys(streams, rate)) for name, streams in found.items()
    ]
