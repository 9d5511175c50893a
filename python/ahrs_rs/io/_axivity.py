"""Axivity's AX6 (and AX3, which has no gyroscope): .cwa, through cwa-reader-rs.

g and deg/s as the device scaled them, neither filtered nor resampled; times by the device's clock (without a time
zone), to which the library ties each block of 40 samples. The library takes a block with a wrong checksum for a good
one, and refuses a file that ends within a block: both are seen to here.
"""

from __future__ import annotations

import datetime
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import Options, SensorData, SensorInfo, require
from ahrs_rs.io._library import refuse, understood
from ahrs_rs.io._source import Source

MAGIC = b"MD\xfc\x03"
HEADER, BLOCK = 1024, 512
GROUPS = {"gyr": ("gyro", np.pi / 180.0), "acc": ("acc", GRAVITY)}
WHAT = "CWA file of an Axivity"


def sniff(source: Source) -> bool:
    """Whether the file begins with a header of 1020 bytes."""
    return source.head.startswith(MAGIC)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the device's file."""
    reader = require("cwa_reader_rs", extra="axivity")
    content = source.read()
    if len(content) < HEADER + BLOCK:
        raise ValueError("is an Axivity file without a whole block of samples")
    data = SensorData(streams={}, meta={"units": {"gyr": "deg/s", "acc": "g"}})
    whole = HEADER + (len(content) - HEADER) // BLOCK * BLOCK
    with understood(WHAT), _whole_blocks(source, content, whole) as path:
        about = reader.read_metadata(str(path))
        table = reader.read_cwa_file(str(path), include_light=False, include_battery=False)
        stamps = table.index.to_numpy().astype("datetime64[ns]").astype(np.int64)
        values = {name: table[name].to_numpy(dtype=np.float64) for name in table.columns}
    if not len(stamps):
        raise ValueError("is an Axivity file without samples")
    t = ((stamps - stamps.min()) / 1e9).astype(np.float64)
    t = _with_gaps(t, content[HEADER:whole], data)
    for stream, (prefix, factor) in GROUPS.items():
        names = [f"{prefix}_{axis}" for axis in "xyz"]
        if set(names) <= set(values):
            data.streams[stream] = (t, np.column_stack([values[name] for name in names]) * factor)
    if "temperature" in values:
        data.streams["temperature"] = (t, values["temperature"])
    data.meta["units"] = {stream: unit for stream, unit in data.meta["units"].items() if stream in data.streams}
    data.meta |= _described(about, int(stamps.min()))
    if whole < len(content):
        data.say("lost", "the last block is cut off and left out")
    _doubt_blocks(content[HEADER:whole], data)
    if any(name.startswith("mag_") for name in values):
        data.say("ignored", "the magnetometer, whose unit the format does not state")
    return {"imu": data}


class _whole_blocks:  # noqa: N801
    """The file itself, or a copy that ends with its last whole block."""

    def __init__(self, source: Source, content: bytes, whole: int) -> None:
        self._source, self._content, self._whole = source, content, whole
        self._held: Any = None

    def __enter__(self) -> Path:
        if self._whole == len(self._content):
            self._held = self._source.file()
            path: Path = self._held.__enter__()
            return path
        self._held = tempfile.TemporaryDirectory(prefix="ahrs_rs_")
        path = Path(self._held.__enter__()) / "whole.cwa"
        path.write_bytes(self._content[: self._whole])
        return path

    def __exit__(self, *exc: Any) -> None:
        self._held.__exit__(*exc)


def _described(about: dict[str, Any], first: int) -> dict[str, Any]:
    """What the header tells, and the device's clock at t = 0 (which has no time zone: no UTC)."""
    info = {
        key: about[key]
        for key in ("hardware_type", "device_id", "sample_rate_hz", "accel_range", "gyro_range")
        if key in about
    }
    begin = datetime.datetime(1970, 1, 1) + datetime.timedelta(microseconds=first // 1000)
    return {"info": info | {"device_clock_at_start": begin.isoformat()}, "clock": "of the device, local time"}


def _with_gaps(t: FloatArray, blocks: bytes, data: SensorData) -> FloatArray:
    """Times with the gaps that lost blocks leave, by the blocks' sequence numbers.

    Over a gap of up to about a second the library stretches the block after it back to the block before, so that there
    is none; the end of the stretched block is right.
    """
    held = np.frombuffer(blocks, dtype=np.uint8).reshape(-1, BLOCK)
    held = held[(held[:, 0] == ord("A")) & (held[:, 1] == ord("X"))]
    counts = held[:, 28:30].copy().view("<u2")[:, 0].astype(np.int64)
    numbers = held[:, 10:14].copy().view("<u4")[:, 0].astype(np.int64)
    missing = np.diff(numbers) - 1
    gaps = np.flatnonzero(missing > 0)
    if not gaps.size:
        return t
    if counts.sum() != len(t):
        data.say("doubts", "blocks are missing by their numbers, and which readings come before them is not known")
        return t
    data.say("lost", f"{int(missing[gaps].sum())} blocks by their sequence numbers; they are gaps in time")
    step = float(np.median(np.diff(t)))
    ends = np.cumsum(counts)
    out = t.copy()
    for after in gaps + 1:
        count, end = int(counts[after]), int(ends[after])
        if count > 1:
            until = t[end] if end < len(t) else t[end - 1] + (t[end - 1] - t[end - 2])
            out[end - count : end] = until - step * np.arange(count, 0, -1)
    return out


def _doubt_blocks(blocks: bytes, data: SensorData) -> None:
    """Say which blocks are damaged: their 16-bit words do not sum up to zero, or they are none at all."""
    held = np.frombuffer(blocks, dtype=np.uint8).reshape(-1, BLOCK)
    are_data = (held[:, 0] == ord("A")) & (held[:, 1] == ord("X"))
    words: NDArray[np.uint16] = held.view("<u2").astype(np.uint16)
    sums = words.sum(axis=1, dtype=np.uint64) & 0xFFFF
    stated = words[:, -1] != 0  # a checksum of zero is none
    wrong = np.flatnonzero(are_data & stated & (sums != 0))
    if wrong.size:
        data.say(
            "doubts",
            f"{wrong.size} of {len(held)} blocks have a wrong checksum, first {wrong[0]}: readings may be wrong there",
        )
    if not are_data.all():
        none = np.flatnonzero(~are_data)
        data.say("lost", f"{none.size} of {len(held)} blocks are no data, first block {none[0]}; they are gaps in time")


def sensors(source: Source, options: Options) -> list[SensorInfo]:
    """The device, by its header and the counts in its blocks."""
    reader = require("cwa_reader_rs", extra="axivity")
    with source.file() as path:
        with understood(WHAT):
            about = reader.read_metadata(str(path))
        blocks = np.memmap(path, dtype=np.uint8, mode="r", offset=HEADER)
        held = blocks[: len(blocks) // BLOCK * BLOCK].reshape(-1, BLOCK)
        are_data = (held[:, 0] == ord("A")) & (held[:, 1] == ord("X"))
        counts: FloatArray = held[:, 28] + 256.0 * held[:, 29]
        total = int(counts[are_data].sum())
        axes = int(held[are_data][0, 25]) >> 4 if are_data.any() else 0
        del held, blocks
    if not axes:
        raise refuse("is an Axivity file without samples")
    names = ("gyr", "acc") if axes >= 6 else ("acc",)
    rate = float(about["sample_rate_hz"])
    return [SensorInfo("imu", dict.fromkeys(names, total), dict.fromkeys(names, rate))]
