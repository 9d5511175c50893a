#!/usr/bin/env bash
# imufusion 1.3.3: one sample near the end of the gyroscope's range sets the heading back to zero.
#
# With gyroscope_range set, a rate that is out of range makes the filter recover, for roll and pitch are to be
# found again from the accelerometer. One expects that it goes on from the attitude that it had, as without
# magnetometer nothing can find the heading again. It starts anew: a sample of 98.5 % of the range, which the
# sensor still measures, for 10 ms, and the heading of 40 degrees is 0. Without the setting the same sample is
# integrated, and the heading is off by nothing but that.
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

still, up = np.zeros(3), np.array([0.0, 0, 1])


def heading(gyroscope_range, peak):
    ahrs, settings = imufusion.Ahrs(), imufusion.AhrsSettings()
    settings.sample_rate, settings.gyroscope_range = 100.0, gyroscope_range
    ahrs.set_settings(settings)
    for rate in [0.0] * 500 + [40.0] * 100 + [peak, -peak] + [0.0] * 500:
        ahrs.update_no_magnetometer(np.array([0, 0, rate]), up)
    return imufusion.quaternion_to_euler(ahrs.get_quaternion())[2]


free, below, near = heading(0.0, 1970.0), heading(2000.0, 1950.0), heading(2000.0, 1970.0)
print("imufusion", importlib.metadata.version("imufusion"))
print("guess: a turn by 40 degrees, then a jerk there and back at less than 2000 deg/s: the heading is about 40 degrees")
print(f"seen: {free:.1f} degrees without a range, {below:.1f} with a range of 2000 and a jerk of 1950, {near:.1f} with a jerk of 1970")
sys.exit(0 if abs(free - 40) < 1 and abs(below - 40) < 1 and abs(near) < 21 else "this has changed")
PY
