#!/usr/bin/env bash
# pyubx2 gives a u-blox sensor's small negative rate as 16.8 million.
#
# A u-blox receiver with dead reckoning sends its gyroscope and accelerometer in ESF-MEAS: a type, and a signed
# number of 24 bits in steps of 2^-12 deg/s or 2^-10 m/s2. Its solution comes in ESF-INS, in steps of 1e-3 deg/s
# and 1e-2 m/s2. One expects parse() to give both in their units, or at least both signs. ESF-INS is scaled and
# signed, ESF-MEAS neither: -1 deg/s is 16773120. ESF-RAW, with the same field, comes as bytes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyubx2==1.4.0
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import struct
import sys

from pyubx2 import UBXReader


def message(identity, payload):
    body = bytes([0x10, identity]) + struct.pack("<H", len(payload)) + payload
    a = b = 0
    for byte in body:
        a = (a + byte) & 255
        b = (b + a) & 255
    return UBXReader.parse(b"\xb5\x62" + body + bytes([a, b]))


def measured(kind, value):  # type 5: gyroscope z; 18: accelerometer z
    return struct.pack("<I", kind << 24 | value & 0xFFFFFF)


meas = message(0x02, struct.pack("<IHH", 1000, 2 << 11, 0) + measured(5, -4096) + measured(18, -10045))
ins = message(0x15, struct.pack("<I4xI6i", 0x3F01, 1000, 0, 0, -1000, 0, 0, -981))
raw = message(0x03, bytes(4) + measured(5, -4096) + struct.pack("<I", 1000))
print("pyubx2", importlib.metadata.version("pyubx2"))
print("guess: -1 deg/s and -9.81 m/s2 in both messages (or -4096 and -10045 in ESF-MEAS)")
print(f"seen: ESF-INS {ins.zAngRate} and {ins.zAccel}; ESF-MEAS {meas.dataField_01} and {meas.dataField_02}; ESF-RAW {raw.data_01}")
same = abs(ins.zAngRate + 1) < 1e-9 and abs(ins.zAccel + 9.81) < 1e-9 and meas.dataType_01 == 5
sys.exit(0 if same and (meas.dataField_01, meas.dataField_02) == (2**24 - 4096, 2**24 - 10045) else "this has changed")
PY
