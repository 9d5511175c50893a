#!/usr/bin/env bash
# imufusion 1.3.3: one sample near the end of the gyroscope's range sets the heading back to zero.
#
# With gyroscope_range set, a rate that is out of range begins a new start of three seconds, for roll and pitch
# are to be found again from the accelerometer. One expects that the heading goes on from where it was, as
# without magnetometer nothing can find it again. But update_no_magnetometer holds the heading at zero in every
# start: a sample of 98.5 % of the range, which the sensor still measures, for 10 ms, and the heading of 40
# degrees is 0. The first start is alike: a sensor that turns from the first sample on loses the turn of the
# first three seconds.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check imufusion==1.3.3 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import imufusion
import numpy as np

up = np.array([0.0, 0, 1])


def heading(gyroscope_range, rates):
    ahrs, settings = imufusion.Ahrs(), imufusion.AhrsSettings()
    settings.sample_rate, settings.gyroscope_range = 100.0, gyroscope_range
    ahrs.set_settings(settings)
    for rate in rates:
        ahrs.update_no_magnetometer(np.array([0, 0, rate]), up)
    return imufusion.quaternion_to_euler(ahrs.get_quaternion())[2]


def jerk(peak):  # 5 s of rest, a turn by 40 degrees, a jerk there and back, 5 s of rest
    return [0.0] * 500 + [40.0] * 100 + [peak, -peak] + [0.0] * 500


free, below, near = heading(0.0, jerk(1970.0)), heading(2000.0, jerk(1950.0)), heading(2000.0, jerk(1970.0))
turn = heading(0.0, [25.0] * 500)
print("imufusion", importlib.metadata.version("imufusion"))
print("guess: a turn by 40 degrees, then a jerk there and back at less than 2000 deg/s: the heading is about 40 degrees")
print(f"seen: {free:.1f} degrees without a range, {below:.1f} with a range of 2000 and a jerk of 1950, {near:.1f} with a jerk of 1970")
print(f"seen: 25 deg/s for 5 s from the first sample are {turn:.1f} degrees of heading")
same = abs(free - 40) < 1 and abs(below - 40) < 1
sys.exit(0 if same and abs(near) < 1 and abs(turn - 50) < 1 else "this has changed")
PY
