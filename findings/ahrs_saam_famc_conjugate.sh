#!/usr/bin/env bash
# ahrs 0.4.0: SAAM and FAMC give opposite rotations for the same accelerometer and magnetometer.
#
# Both are closed forms of the same problem, with the same two reference directions, and both are documented to estimate
# the orientation as a quaternion. One expects that one can take the place of the other. SAAM's quaternion takes vectors
# from the earth to the sensor, FAMC's from the sensor to the earth: each is the conjugate of the other one. A sensor
# that is turned by 30 degrees to the left is so by one, and to the right by the other.
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

turn, dip = np.radians(30.0), np.radians(60.0)
acc = 9.81 * np.array([0.0, np.sin(0.2), np.cos(0.2)])
level = np.array([np.cos(dip) * np.cos(turn), -np.cos(dip) * np.sin(turn), -np.sin(dip)])
roll = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(0.2), np.sin(0.2)], [0.0, -np.sin(0.2), np.cos(0.2)]])
mag = 50.0 * roll @ level
saam = ahrs.filters.SAAM().estimate(acc=acc, mag=mag)
famc = ahrs.filters.FAMC().estimate(acc=acc, mag=mag)
saam, famc = (q * np.sign(q[0]) for q in (saam, famc))
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: the same quaternion")
print("seen: SAAM", saam.round(4), "FAMC", famc.round(4))
opposite = np.allclose(saam, famc * [1.0, -1.0, -1.0, -1.0], atol=1e-12)
sys.exit(0 if opposite and not np.allclose(saam, famc, atol=0.1) else "this has changed")
PY
