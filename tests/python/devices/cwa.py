"""Axivity's continuous wave accelerometry file (.cwa) of an AX6, by Open Movement's documentation."""

from __future__ import annotations

import struct
from collections.abc import Collection
from datetime import datetime, timedelta

import numpy as np

RATE_CODES = {12.5: 7, 25.0: 8, 50.0: 9, 100.0: 10, 200.0: 11, 400.0: 12}


def stamp(time: datetime) -> int:
    """The packed time of whole seconds: year from 2000 in 6 bits, month 4, day 5, hour 5, minute 6, second 6."""
    date = (time.year - 2000) << 26 | time.month << 22 | time.day << 17
    return date | time.hour << 12 | time.minute << 6 | time.second


def header(rate: float, device: int = 12345, start: datetime | None = None) -> bytes:
    """The header of 1024 bytes: an AX6 at ±8 g and ±2000 °/s."""
    code = RATE_CODES[rate] | (1 << 6)
    begin = stamp(start) if start else 0
    fixed = struct.pack("<2sHBHIHIIIBB", b"MD", 1020, 0x64, device, 1, 0, begin, 0xFFFFFFFF, 0, 0, 0)
    block = bytearray(fixed.ljust(1024, b"\xff"))
    block[35] = 0x02  # gyroscope ±2000 °/s
    block[36] = code
    block[37:41] = struct.pack("<I", begin)
    block[41] = 44
    return bytes(block)


def block(sequence: int, time: datetime, offset: int, values: np.ndarray, rate: float) -> bytes:
    """One block of 512 bytes: up to 40 rows of int16 (gyroscope, then accelerometer).

    The whole second `time` holds at the sample `offset` from the block's first one, which may lie outside of it.
    """
    code = RATE_CODES[rate] | (1 << 6)
    light = (4 << 13) | (2 << 10) | 100  # 4096 per g; 8000 / 2² °/s full scale
    fields = (b"AX", 508, 0, 1, sequence, stamp(time), light, 300, 0, 200, code, 0x62, offset, len(values))
    head = struct.pack("<2sHHIIIHHBBBBhH", *fields)
    data = head + values.astype("<i2").tobytes().ljust(480, b"\0")
    total = sum(struct.unpack("<255H", data)) & 0xFFFF
    return data + struct.pack("<H", -total & 0xFFFF)


def log(values: np.ndarray, rate: float, start: datetime, lost: Collection[int] = ()) -> bytes:
    """A file of rows at a constant rate from `start` (whole seconds) on; the blocks in `lost` are left out."""
    out = [header(rate, start=start)]
    for number, first in enumerate(range(0, len(values), 40)):
        second = -int(-first // rate)
        if number not in lost:
            offset = round(second * rate) - first
            out.append(block(number, start + timedelta(seconds=second), offset, values[first : first + 40], rate))
    return b"".join(out)
