#!/usr/bin/env bash
# ahrs 0.4.0: a complementary filter without magnetometer takes no heading from the gyroscope.
#
# A complementary filter mixes the gyroscope's angles with those of accelerometer and magnetometer. Without a
# magnetometer nothing measures the heading, so one expects it to follow the gyroscope (and to drift). Here the
# accelerometer's "heading" of 0 is mixed in like a measurement: a sensor that turns flat by 57 degrees is said
# to have not have turned at all, whatever the gain, even with the 1 that stands for "gyroscopes only". Roll and
# pitch are not touched by it.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ahrs==0.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import numpy as np
from ahrs.filters import AngularRate, Complementary

n, rate = 101, 100.0
gyr, acc = np.zeros((n, 3)), np.tile([0.0, 0.0, 9.81], (n, 1))
gyr[:, 2] = 1.0  # rad/s about the vertical, for a second


def turned(q):
    return np.degrees(2 * np.arctan2(q[3], q[0]))


alone = turned(np.asarray(AngularRate(gyr=gyr, frequency=rate).Q).reshape(-1, 4)[-1])
mixed = {gain: turned(np.asarray(Complementary(gyr=gyr, acc=acc, frequency=rate, gain=gain, representation="quaternion").Q)[-1]) for gain in (0.5, 0.9, 0.99, 1.0)}
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: 57 degrees of heading, from the gyroscope, as nothing else can see it")
print(f"seen: AngularRate {alone:.1f}; Complementary " + ", ".join(f"{angle:.1f} with gain {gain}" for gain, angle in mixed.items()))
sys.exit(0 if alone > 56 and max(map(abs, mixed.values())) < 1e-6 else "this has changed")
PY
