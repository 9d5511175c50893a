#!/usr/bin/env bash
# cwa-reader-rs makes up readings for the time in which an Axivity AX6 did not record, where it is asked to
# resample.
#
# A device that pauses for ten minutes (a resumed logging session) leaves a hole in its stamps. With resample_hz
# one expects a regular grid with nothing, or with NaN, in the hole. The hole is filled by the cubic
# interpolation: 8 s of readings become 604 s, none of them missing. A device that lies on one side before and on
# the other after is shown to turn over slowly, at less than a hundredth of 1 g on the way.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check cwa-reader-rs==0.5.0 numpy==2.4.6 pandas==3.1.1
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import struct
import sys

import cwa_reader_rs
import numpy as np


def second(k):  # 2026-01-02 03:04:05 and k seconds, packed
    k += 4 * 60 + 5
    return (26 << 26) | (1 << 22) | (2 << 17) | (3 << 12) | (k // 60 << 6) | k % 60


head = struct.pack("<2sHBHIHIIIBB", b"MD", 1020, 0x64, 1, 1, 0, second(0), 0xFFFFFFFF, 0, 0, 0)
head = bytearray(head.ljust(1024, b"\xff"))
head[35:41] = bytes([2, 0x4A]) + struct.pack("<I", second(0))  # gyroscope 2000 deg/s; 100 Hz, 8 g
out = [bytes(head)]
for start, up in ((0, 4096), (600, -4096)):  # 4 s with z up, and 4 s with z down ten minutes later
    for number in range(10):
        first = 40 * number
        rows = np.zeros((40, 6), "<i2")
        rows[:, 5] = up
        whole = -(-first // 100)
        fields = (b"AX", 508, 0, 1, number, second(start + whole), 0x8864, 300, 0, 200, 0x4A, 0x62, 100 * whole - first, 40)
        block = struct.pack("<2sHHIIIHHBBBBhH", *fields) + rows.tobytes()
        out.append(block + struct.pack("<H", -sum(struct.unpack("<255H", block)) & 0xFFFF))
with open("device.cwa", "wb") as file:
    file.write(b"".join(out))
plain = cwa_reader_rs.read_cwa_file("device.cwa")
regular = cwa_reader_rs.read_cwa_file("device.cwa", resample_hz=100)
norm = np.linalg.norm(regular[["acc_x", "acc_y", "acc_z"]].to_numpy(), axis=1)
print("cwa-reader-rs", importlib.metadata.version("cwa-reader-rs"))
print(f"guess: {len(plain)} readings on a grid of 100 Hz are some {len(plain)} readings, with nothing or NaN in the ten minutes between")
print(f"seen: {len(regular)} readings, {int(np.isnan(norm).sum())} of them missing; the smallest acceleration is {norm.min():.4f} g")
sys.exit(0 if (len(plain), len(regular)) == (800, 60400) and norm.min() < 0.01 else "this has changed")
PY
