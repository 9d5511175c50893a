#!/usr/bin/env bash
# imufusion 1.3.3: acceleration_rejection alone rejects nothing.
#
# acceleration_rejection is the angle in degrees from which on the accelerometer is not believed; 0, the
# default, is never. One expects that 10 ignores an acceleration 29 degrees off. Nothing is ignored, and the
# attitude is the same to the last bit as without the setting, until rejection_timeout is set too: its default
# of 0 does not mean "give up never" but turns the rejection off. Magnetic rejection is the same.
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

up, off = np.array([0.0, 0, 1]), np.array([0, np.sin(0.5), np.cos(0.5)])


def roll(rejection, timeout):
    ahrs, settings = imufusion.Ahrs(), imufusion.AhrsSettings()
    settings.sample_rate, settings.acceleration_rejection, settings.rejection_timeout = 100.0, rejection, timeout
    ahrs.set_settings(settings)
    for k in range(700):  # 5 s level, then 2 s of an acceleration that leans by 29 degrees
        ahrs.update_no_magnetometer(np.zeros(3), up if k < 500 else off)
    return imufusion.quaternion_to_euler(ahrs.get_quaternion())[0]


none, alone, both = roll(0.0, 0.0), roll(10.0, 0.0), roll(10.0, 5.0)
print("imufusion", importlib.metadata.version("imufusion"))
print("guess: with a rejection of 10 degrees the roll stays near 0 for the 2 s")
print(f"seen: {none:.2f} degrees without, {alone:.2f} with the rejection, {both:.2f} with the rejection and a timeout of 5 s")
sys.exit(0 if none == alone > 15 and abs(both) < 0.1 else "this has changed")
PY
