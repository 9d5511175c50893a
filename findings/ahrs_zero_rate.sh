#!/usr/bin/env bash
# ahrs 0.4.0: Mahony and Madgwick do not correct the attitude while the gyroscope reads exactly zero.
#
# A gyroscope that shows zero at rest is what one has in simulations, of a sensor with a dead band, or after rounding to a
# coarse unit. One expects that the accelerometer then pulls the attitude to the vertical as ever, and best of all, as the
# sensor is still. Both filters return the last attitude for a rate of norm zero. A rate of 1e-9 rad/s makes them work.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ahrs==0.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import ahrs
import numpy as np

count = 3000
acc = np.tile([0.0, 0.0, 9.81], (count, 1))
start = np.array([np.cos(0.2), np.sin(0.2), 0.0, 0.0])  # 23 degrees off: the sensor lies level
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: after 30 s both are level, below 1 degree")
good = True
for name, gains in (("Mahony", {"k_P": 1.0, "k_I": 0.3}), ("Madgwick", {"gain": 0.1})):
    tilts = []
    for rate in (0.0, 1e-9):
        f = getattr(ahrs.filters, name)(gyr=np.full((count, 3), rate), acc=acc, frequency=100.0, q0=start, **gains)
        tilts.append(np.degrees(2.0 * np.arcsin(np.hypot(*f.Q[-1][1:3]))))
    print(f"seen: {name}: {tilts[0]:.1f} degrees with a rate of 0, {tilts[1]:.2f} degrees with one of 1e-9 rad/s")
    good &= tilts[0] > 22.0 and tilts[1] < 1.0
sys.exit(0 if good else "this has changed")
PY
