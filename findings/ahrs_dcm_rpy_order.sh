#!/usr/bin/env bash
# ahrs 0.4.0: DCM(rpy=...) and Quaternion(rpy=...) of the same three angles are two different rotations.
#
# Both classes take roll, pitch and yaw by a keyword of one name. One expects one attitude, as a matrix and as a
# quaternion. The quaternion turns by the first angle about x and by the last about z; the matrix turns by the
# first about z and by the last about x. A pure heading of 90 degrees, written as a matrix, is a roll of 90
# degrees. Only the pitch means the same in both.
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
from ahrs import DCM, Quaternion

heading = [0.0, 0.0, np.pi / 2]  # roll, pitch, yaw
matrix = np.asarray(DCM(rpy=heading))
quaternion = np.asarray(Quaternion(rpy=heading).to_DCM())
north = np.array([1.0, 0.0, 0.0])
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: roll 0, pitch 0, yaw 90 degrees turns the x axis to y, as matrix and as quaternion")
print(f"seen: the quaternion turns it to {np.round(quaternion @ north, 6) + 0.0}, the matrix to {np.round(matrix @ north, 6) + 0.0}")
other = np.asarray(DCM(rpy=[0.1, 0.2, 0.3]))
exchanged = np.asarray(Quaternion(rpy=[0.3, 0.2, 0.1]).to_DCM())
print(f"seen: with first and last angle exchanged the two agree to {np.abs(other - exchanged).max():.0e}")
right = np.allclose(quaternion @ north, [0, 1, 0]) and np.allclose(other, exchanged)
sys.exit(0 if right and np.allclose(matrix @ north, north) else "this has changed")
PY
