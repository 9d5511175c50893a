#!/usr/bin/env bash
# ahrs 0.4.0: Madgwick takes no notice of q0 where it is given a magnetometer.
#
# With gyroscope and accelerometer alone, the first attitude is q0. One expects the same with a magnetometer beside them. There
# the first attitude is always the one of accelerometer and magnetometer, and q0 is dropped without a word: who compares
# filters from one start, or goes on from the end of another recording, compares other things than they think.
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

count = 10
q0 = np.array([np.cos(0.7), 0.0, 0.0, np.sin(0.7)])  # 80 degrees about the vertical
gyr = np.full((count, 3), 1e-6)
acc, mag = np.tile([0.0, 0.0, 9.81], (count, 1)), np.tile([20.0, 0.0, -40.0], (count, 1))
without = ahrs.filters.Madgwick(gyr=gyr, acc=acc, frequency=100.0, q0=q0).Q[0]
with_mag = ahrs.filters.Madgwick(gyr=gyr, acc=acc, mag=mag, frequency=100.0, q0=q0).Q[0]
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: the first attitude is q0,", q0.round(4))
print("seen: without magnetometer", without.round(4), "and with it", with_mag.round(4))
sys.exit(0 if np.allclose(without, q0) and not np.allclose(with_mag, q0, atol=0.1) else "this has changed")
PY
