#!/usr/bin/env bash
# telemetry-parser puts the accelerometer of a GoPro into the first half of each second where the gyroscope is
# twice as fast.
#
# Cameras whose gyroscope has twice the accelerometer's rate exist. normalized_imu() gives rows with one stamp, a
# rate and an acceleration. One expects the acceleration of that time, or none in every other row. Within each
# metadata payload (about a second) the k-th row takes the k-th acceleration instead: what was measured 0.9 s into
# the second stands at 0.45 s, and the second half has none.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check telemetry-parser==0.3.0
cd "$folder"
cat > camera.py <<'PY'
"""A GoPro's MP4 with a metadata track alone: payloads of a second, 200 rows of gyroscope and 100 of accelerometer."""
import struct


def klv(key, kind, size, repeat, data):
    return key + struct.pack(">BBH", kind, size, repeat) + data.ljust(-(-len(data) // 4) * 4, b"\0")


def nest(key, *parts):
    data = b"".join(parts)
    return klv(key, 0, 1, len(data), data)


def text(key, value):
    return klv(key, ord("c"), 1, len(value), value)


def stream(key, rows, total, scale, unit):
    data = b"".join(struct.pack(">3h", *row) for row in rows)
    parts = (klv(b"TSMP", ord("L"), 4, 1, struct.pack(">I", total)), text(b"ORIN", b"XYZ"), text(b"SIUN", unit))
    return nest(b"STRM", *parts, klv(b"SCAL", ord("s"), 2, 1, struct.pack(">h", scale)), klv(key, ord("s"), 6, len(rows), data))


def payload(second):
    """Both sensors' x axis counts hundredths of a second."""
    gyr = [(second * 100 + k // 2, 0, 0) for k in range(200)]
    acc = [(second * 100 + k, 0, 981) for k in range(100)]
    parts = (stream(b"ACCL", acc, (second + 1) * 100, 100, b"m/s\xb2"), stream(b"GYRO", gyr, (second + 1) * 200, 100, b"rad/s"))
    return nest(b"DEVC", klv(b"DVID", ord("L"), 4, 1, struct.pack(">I", 1)), text(b"DVNM", b"Hero9 Black"), *parts)


def box(kind, *parts, full=None):
    data = (b"" if full is None else struct.pack(">I", full)) + b"".join(parts)
    return struct.pack(">I", len(data) + 8) + kind + data


def mp4(payloads):
    n, total = len(payloads), 1000 * len(payloads)
    ftyp = box(b"ftyp", b"mp41", struct.pack(">I", 0), b"mp41")
    offsets, start = [], len(ftyp) + 8
    for data in payloads:
        offsets.append(start)
        start += len(data)
    matrix = struct.pack(">9I", 0x10000, 0, 0, 0, 0x10000, 0, 0, 0, 0x40000000)
    times = struct.pack(">4I", 0, 0, 1000, total)
    mvhd = box(b"mvhd", times, struct.pack(">IH", 0x10000, 0x100), bytes(10), matrix, bytes(24), struct.pack(">I", 2), full=0)
    tkhd = box(b"tkhd", struct.pack(">5I", 0, 0, 1, 0, total), bytes(16), matrix, bytes(8), full=15)
    mdhd = box(b"mdhd", times, struct.pack(">2H", 0x55C4, 0), full=0)
    hdlr = box(b"hdlr", b"mhlrmeta", bytes(12), b"\x0bGoPro MET  ", full=0)
    stsd = box(b"stsd", struct.pack(">I", 1), box(b"gpmd", bytes(6), struct.pack(">HI", 1, 0)), full=0)
    stts = box(b"stts", struct.pack(">3I", 1, n, 1000), full=0)
    stsc = box(b"stsc", struct.pack(">4I", 1, 1, 1, 1), full=0)
    stsz = box(b"stsz", struct.pack(">2I", 0, n), *(struct.pack(">I", len(one)) for one in payloads), full=0)
    stco = box(b"stco", struct.pack(">I", n), *(struct.pack(">I", one) for one in offsets), full=0)
    dinf = box(b"dinf", box(b"dref", struct.pack(">I", 1), box(b"url ", full=1), full=0))
    minf = box(b"minf", box(b"gmhd", full=0), dinf, box(b"stbl", stsd, stts, stsc, stsz, stco))
    return ftyp + box(b"mdat", *payloads) + box(b"moov", mvhd, box(b"trak", tkhd, box(b"mdia", mdhd, hdlr, minf)))
PY
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import math
import sys

import camera
import telemetry_parser

with open("video.mp4", "wb") as file:
    file.write(camera.mp4([camera.payload(second) for second in range(4)]))
rows = telemetry_parser.Parser("video.mp4").normalized_imu()
empty = [row["timestamp_ms"] / 1000 for row in rows if row["accl"] is None]
late = rows[290]
print("telemetry-parser", importlib.metadata.version("telemetry-parser"))
print("guess: the row at 1.45 s has the acceleration of 1.45 s, and every other row has none")
print(f"seen: the row at {late['timestamp_ms'] / 1000:.2f} s has the acceleration of {late['accl'][0]:.2f} s")
print(f"seen: of {len(rows)} rows {len(empty)} have none, first those from {empty[0]:.3f} to {empty[99]:.3f} s without a break")
halves = all((row["accl"] is None) == (k % 200 >= 100) for k, row in enumerate(rows))
turned = abs(math.radians(late["gyro"][0]) - 1.45) < 0.01
sys.exit(0 if len(rows) == 800 and halves and turned and abs(late["accl"][0] - 1.9) < 0.001 else "this has changed")
PY
