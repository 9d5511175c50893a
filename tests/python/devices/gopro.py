"""A GoPro's MP4 with a track of GPMF metadata, by GoPro's gpmf-parser documentation and ISO 14496-12."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np


def klv(key: str, kind: str, size: int, repeat: int, data: bytes) -> bytes:
    """Key, length, value; padded to four bytes."""
    code = ord(kind) if kind else 0
    return key.encode() + struct.pack(">BBH", code, size, repeat) + data.ljust(-(-len(data) // 4) * 4, b"\0")


def nest(key: str, *children: bytes) -> bytes:
    """A nested element."""
    data = b"".join(children)
    return klv(key, "", 1, len(data), data)


def text(key: str, value: str) -> bytes:
    """An element of characters (Latin-1)."""
    data = value.encode("latin-1")
    return klv(key, "c", 1, len(data), data)


def stream(key: str, values: np.ndarray, total: int, scale: int, unit: str, name: str, order: str | None = None,
           stamp: int | None = None) -> bytes:  # fmt: skip
    """A stream of int16 rows; `total` counts all samples up to and with these, `stamp` is in µs."""
    parts = [klv("TSMP", "L", 4, 1, struct.pack(">I", total))]
    if stamp is not None:
        parts.insert(0, klv("STMP", "J", 8, 1, struct.pack(">Q", stamp)))
    parts.append(text("STNM", name))
    if order:
        parts += [text("ORIN", order), text("ORIO", "ZXY")]
    parts.append(text("SIUN", unit))
    parts.append(klv("SCAL", "s", 2, 1, struct.pack(">h", scale)))
    width = values.shape[1] * 2
    parts.append(klv(key, "s", width, len(values), values.astype(">i2").tobytes()))
    return nest("STRM", *parts)


def payload(*streams: bytes, device: str = "Hero9 Black") -> bytes:
    """One second's metadata."""
    return nest("DEVC", klv("DVID", "L", 4, 1, struct.pack(">I", 1)), text("DVNM", device), *streams)


def _box(kind: str, *parts: bytes) -> bytes:
    data = b"".join(parts)
    return struct.pack(">I", len(data) + 8) + kind.encode() + data


def _full(kind: str, *parts: bytes, version: int = 0, flags: int = 0) -> bytes:
    return _box(kind, struct.pack(">I", version << 24 | flags), *parts)


def mp4(payloads: Sequence[bytes], durations: Sequence[int], timescale: int = 1000) -> bytes:
    """An MP4 with the metadata track alone; `durations` of the payloads in units of 1 / `timescale` s."""
    ftyp = _box("ftyp", b"mp41", struct.pack(">I", 0x20131018), b"mp41")
    start = len(ftyp) + 8
    offsets = []
    for data in payloads:
        offsets.append(start)
        start += len(data)
    total = sum(durations)
    matrix = struct.pack(">9I", 0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000)
    times, speed = struct.pack(">4I", 0, 0, timescale, total), struct.pack(">IH", 0x10000, 0x100)
    mvhd = _full("mvhd", times, speed, bytes(10), matrix, bytes(24), struct.pack(">I", 2))
    track = struct.pack(">5I", 0, 0, 1, 0, total)
    tkhd = _full("tkhd", track, bytes(16), matrix, bytes(8), flags=15)
    mdhd = _full("mdhd", struct.pack(">4I", 0, 0, timescale, total), struct.pack(">2H", 0x55C4, 0))
    hdlr = _full("hdlr", b"mhlrmeta", bytes(12), b"\x0bGoPro MET  ")
    stsd = _full("stsd", struct.pack(">I", 1), _box("gpmd", bytes(6), struct.pack(">HI", 1, 0)))
    stts = _full("stts", struct.pack(">I", len(durations)), *(struct.pack(">2I", 1, value) for value in durations))
    stsc = _full("stsc", struct.pack(">4I", 1, 1, 1, 1))
    stsz = _full("stsz", struct.pack(">2I", 0, len(payloads)), *(struct.pack(">I", len(data)) for data in payloads))
    stco = _full("stco", struct.pack(">I", len(offsets)), *(struct.pack(">I", value) for value in offsets))
    dinf = _box("dinf", _full("dref", struct.pack(">I", 1), _full("url ", flags=1)))
    minf = _box("minf", _full("gmhd"), dinf, _box("stbl", stsd, stts, stsc, stsz, stco))
    trak = _box("trak", tkhd, _box("mdia", mdhd, hdlr, minf))
    return ftyp + _box("mdat", *payloads) + _box("moov", mvhd, trak)
