#!/usr/bin/env bash
# pyxdf spreads a pause of 4.5 s over a whole recording.
#
# XDF (Lab Streaming Layer) files stamp each sample. load_xdf takes the jitter out of the stamps of regular
# streams, piece by piece between breaks; a second is the threshold of a break. One expects that a sensor of 100
# Hz that was silent for 4.5 s has a step of 4.5 s. But a break must also be longer than 500 samples, a second
# threshold meant for signals of 500 Hz and more, so for an inertial sensor it is five seconds and not one: one
# line is fitted through all stamps, the pause is gone, every sample is 13 ms from the next, and stamps are
# wrong by up to 2.2 s. Integrated, the sensor turned by a third too much. A log message says that the rate
# differs, not that there was a pause. With dejitter_timestamps=False the stamps are right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyxdf==1.17.5 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import logging
import struct
import sys

import numpy as np
import pyxdf

logging.disable(logging.CRITICAL)


def sized(n):
    return b"\x04" + struct.pack("<I", n)


def chunk(tag, content):
    return sized(len(content) + 2) + struct.pack("<H", tag) + content


def write(stamps):
    one = struct.pack("<I", 1)
    fields = {"name": "imu", "type": "Gyroscope", "channel_count": 1, "nominal_srate": 100, "channel_format": "double64", "created_at": 0, "desc": ""}
    info = "".join(f"<{key}>{value}</{key}>" for key, value in fields.items())
    out = b"XDF:" + chunk(1, b"<?xml version='1.0'?><info><version>1.0</version></info>")
    out += chunk(2, one + f"<?xml version='1.0'?><info>{info}</info>".encode())
    for part in np.array_split(stamps, len(stamps) // 100):
        out += chunk(3, one + sized(len(part)) + b"".join(b"\x08" + struct.pack("<dd", t, t) for t in part))
    last = f"<first_timestamp>{stamps[0]}</first_timestamp><last_timestamp>{stamps[-1]}</last_timestamp><sample_count>{len(stamps)}</sample_count>"
    out += chunk(6, one + f"<?xml version='1.0'?><info>{last}</info>".encode())
    with open("imu.xdf", "wb") as file:
        file.write(out)


def loaded(pause, **options):  # each sample's value is its own time
    stamps = 1000 + np.arange(2000) / 100
    stamps[1000:] += pause
    write(stamps)
    stream = pyxdf.load_xdf("imu.xdf", **options)[0][0]
    return np.diff(stream["time_stamps"]).max(), np.abs(stream["time_stamps"] - stream["time_series"][:, 0]).max()


print("pyxdf", importlib.metadata.version("pyxdf"))
print("guess: a pause of 4.5 s is a step of 4.51 s")
short, long, raw = loaded(4.5), loaded(5.5), loaded(4.5, dejitter_timestamps=False)
for name, (step, error) in (("4.5 s", short), ("5.5 s", long), ("4.5 s, no dejitter", raw)):
    print(f"seen: {name}: longest step {step:.3f} s, largest error of a stamp {error:.3f} s")
sys.exit(0 if short[0] < 0.02 and short[1] > 2 and long[0] > 5.5 and max(long[1], raw[1]) < 1e-6 else "this has changed")
PY
