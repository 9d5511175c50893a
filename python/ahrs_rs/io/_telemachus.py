"""telemachus, a table of a vehicle's telematics (Parquet): ts, ax_mps2, gx_rad_s, mx_uT, with a manifest beside it.

Read through pyarrow (the package telemachus itself is under the AGPL and not imported). Whether the acceleration has
gravity in it is told by acc_periods of the manifest: "raw" is specific force, "compensated" is without. Without a
manifest the norm tells.
"""

from __future__ import annotations

import datetime
import re
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import Options, SensorData, require
from ahrs_rs.io._library import refuse, understood
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

ACC, GYR, MAG = (
    tuple(f"{name}{axis}{unit}" for axis in "xyz") for name, unit in (("a", "_mps2"), ("g", "_rad_s"), ("m", "_uT"))
)
OTHERS = {"speed_mps": "speed", "heading_deg": "heading"}
WHAT = "telemachus file"
#: A median norm above this has gravity in it, m/s².
WITH_GRAVITY = 7.0
MANIFESTS = ("manifest.yaml", "manifest.yml")


def sniff(source: Source) -> bool:
    """Whether a Parquet file, or one in a folder with a manifest, has telemachus's columns."""
    if source.names:
        return any(PurePosixPath(name).name in MANIFESTS for name in source.names) and bool(_tables(source))
    if not source.head.startswith(b"PAR1"):
        return False
    try:
        parquet = require("pyarrow.parquet")
        with source.open() as stream, parquet.ParquetFile(stream) as file:
            names = set(file.schema_arrow.names)
    except Exception:  # no pyarrow, or damaged: the general reader says so
        return False
    return "ts" in names and bool(names & {*ACC, *GYR})


def _tables(source: Source) -> list[str]:
    return [name for name in source.names if name.lower().endswith(".parquet")]


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read one table, or those of a folder one after the other."""
    parquet = require("pyarrow.parquet")
    names = [*GYR, *ACC, *MAG, *OTHERS, "ts", "device_id", "trip_id"]
    parts: dict[str, list[Any]] = {}
    with understood(WHAT):
        for one in _tables(source) or [""]:
            with (source.child(one) if one else source).open() as stream, parquet.ParquetFile(stream) as file:
                there = [name for name in names if name in file.schema_arrow.names]
                table = file.read(columns=there)
            for name in there:
                column = table[name]
                parts.setdefault(name, []).append(
                    column.to_numpy() if name != "ts" else column.cast("timestamp[us]").to_numpy().astype(np.int64)
                )
        if "ts" not in parts:
            raise refuse("has no column ts")
        columns = {name: np.concatenate(held) for name, held in parts.items()}
    return {str(name): _sensor(columns, rows, source) for name, rows in _devices(columns).items()}


def _devices(columns: dict[str, Any]) -> dict[str, Any]:
    """Device -> its rows."""
    if "device_id" not in columns:
        return {"vehicle": slice(None)}
    devices = np.array([str(one) for one in columns["device_id"]])
    names = list(dict.fromkeys(devices.tolist()))
    return {"vehicle": slice(None)} if len(names) == 1 else {name: devices == name for name in names}


def _sensor(columns: dict[str, Any], rows: Any, source: Source) -> SensorData:
    times, origin = seconds({"t": columns["ts"][rows]}, 1e-6)
    t = times["t"]
    data = SensorData({}, meta={"units": {}, "columns": {}, "clock": "ts, UTC"})
    start = utc(origin)
    if start:
        data.meta["start"] = start
    for stream, group, unit in (("gyr", GYR, "rad/s"), ("acc", ACC, "m/s²"), ("mag", MAG, "µT")):
        if set(group) <= set(columns):
            values = np.column_stack([np.asarray(columns[name][rows], dtype=np.float64) for name in group])
            data.streams[stream] = (t, values)
            data.meta["units"][stream], data.meta["columns"][stream] = unit, list(group)
    for name, stream in OTHERS.items():
        if name in columns:
            values = np.asarray(columns[name][rows], dtype=np.float64)
            data.streams[stream] = (t, np.radians(values) if stream == "heading" else values)
    if not {"gyr", "acc", "mag"} & set(data.streams):
        raise ValueError("has no columns ax_mps2, gx_rad_s or mx_uT")
    if "acc" in data.streams:
        _gravity(data, t, origin, source)
    return data


def _gravity(data: SensorData, t: FloatArray, origin: float, source: Source) -> None:
    """What is without gravity becomes linear_acceleration."""
    values = data.streams["acc"][1]
    name = next((one for one in source.names if PurePosixPath(one).name in MANIFESTS), None)
    periods = _periods(source.read(name).decode("utf-8", errors="replace")) if name else []
    without = np.zeros(len(t), dtype=np.bool_)
    if periods:
        for begin, end, frame in periods:
            inside = (t + origin >= begin) & (t + origin < end)
            if frame != "raw":
                without |= inside
        if any(frame == "partial" for _, _, frame in periods):
            data.say(
                "doubts",
                "acceleration has a part of gravity in it in some periods (partial); taken as without gravity there",
            )
    else:
        norm = np.linalg.norm(values, axis=1)
        without[:] = not np.nanmedian(norm) > WITH_GRAVITY if np.isfinite(norm).any() else False
        data.say(
            "assumed",
            f"acceleration is {'without' if without.any() else 'with'} gravity, by its norm (there is no manifest)",
        )
    if without.any():
        data.streams["linear_acceleration"] = (t, np.where(without[:, None], values, np.nan))
        kept = np.where(without[:, None], np.nan, values)
        if np.isfinite(kept).any():
            data.streams["acc"] = (t, kept)
        else:
            del data.streams["acc"]
            data.say("doubts", "acceleration is there without gravity only (linear_acceleration): no acc")


def _periods(text: str) -> list[tuple[float, float, str]]:
    """acc_periods of a manifest: start and end (s since 1970) and frame. A few keys of YAML, read without a library."""
    match = re.search(r"^acc_periods:\s*\n((?:[ \t\-].*\n?|\s*\n)*)", text, re.M)
    found = []
    for entry in re.split(r"^\s*-\s", match[1], flags=re.M)[1:] if match else []:
        keys = dict(re.findall(r"(\w+):\s*[\"']?([^\"'\n#]+?)[\"']?\s*(?:#.*)?$", entry, re.M))
        try:
            times = [datetime.datetime.fromisoformat(keys[key]) for key in ("start", "end")]
        except (KeyError, ValueError):
            raise ValueError("manifest: acc_periods: expected start, end (ISO 8601) and frame in each") from None
        begin, end = (one.replace(tzinfo=one.tzinfo or datetime.UTC).timestamp() for one in times)
        found.append((begin, end, keys.get("frame", "raw")))
    return found
