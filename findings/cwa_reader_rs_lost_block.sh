#!/usr/bin/env bash
# cwa-reader-rs hides a block that an Axivity AX6 has lost.
#
# A .cwa file holds blocks of 40 samples, each with a number and a whole second at a sample. When one block of 0.4
# s is missing, one expects a hole of 0.4 s in the time index. There is none: the block after it is stretched back
# over the hole, its 40 samples are 20 ms apart instead of 10, and the first of them is stamped 0.4 s too early.
# Angular rates integrate over that as if the device had turned at half its speed. Three lost blocks (1.2 s) do
# leave a hole.
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
    return (26 << 26) | (1 << 22) | (2 << 17) | (3 << 12) | (4 << 6) | (5 + k)


def recording(lost):
    head = struct.pack("<2sHBHIHIIIBB", b"MD", 1020, 0x64, 1, 1, 0, second(0), 0xFFFFFFFF, 0, 0, 0)
    head = bytearray(head.ljust(1024, b"\xff"))
    head[35:41] = bytes([2, 0x4A]) + struct.pack("<I", second(0))  # gyroscope 2000 deg/s; 100 Hz, 8 g
    blocks = [bytes(head)]
    for number in range(20):
        first = 40 * number
        rows = np.zeros((40, 6), "<i2")
        rows[:, 0], rows[:, 5] = np.arange(first, first + 40), 4096  # the x axis counts the samples
        whole = -(-first // 100)
        fields = (b"AX", 508, 0, 1, number, second(whole), 0x8864, 300, 0, 200, 0x4A, 0x62, 100 * whole - first, 40)
        block = struct.pack("<2sHHIIIHHBBBBhH", *fields) + rows.tobytes()
        block += struct.pack("<H", -sum(struct.unpack("<255H", block)) & 0xFFFF)
        if number not in lost:
            blocks.append(block)
    return b"".join(blocks)


def longest_step_and_error(lost):
    with open("device.cwa", "wb") as file:
        file.write(recording(lost))
    table = cwa_reader_rs.read_cwa_file("device.cwa")
    stamps = table.index.to_numpy().astype("datetime64[us]").astype(np.int64) / 1e6
    count = np.rint(table["gyro_x"].to_numpy() * 32768 / 2000)
    return np.diff(stamps).max(), np.abs(stamps - stamps[0] - count / 100).max(), len(table)


print("cwa-reader-rs", importlib.metadata.version("cwa-reader-rs"))
print("guess: without the 5th block the longest step is 0.41 s, and every stamp is right")
whole, one, three = (longest_step_and_error(lost) for lost in ((), (4,), (4, 5, 6)))
print(f"seen: nothing lost: longest step {whole[0]:.3f} s, largest error {whole[1]:.3f} s, {whole[2]} samples")
print(f"seen: one block lost: longest step {one[0]:.3f} s, largest error {one[1]:.3f} s, {one[2]} samples")
print(f"seen: three blocks lost: longest step {three[0]:.3f} s, largest error {three[1]:.3f} s, {three[2]} samples")
same = whole[1] < 1e-5 and abs(one[0] - 0.02) < 1e-5 and abs(one[1] - 0.4) < 1e-5 and abs(three[0] - 1.21) < 1e-5 > three[1]
sys.exit(0 if same else "this has changed")
PY
