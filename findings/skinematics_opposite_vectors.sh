#!/usr/bin/env bash
# scikit-kinematics: the shortest rotation from a vector to its opposite is no rotation.
#
# q_shortest_rotation(v1, v2) gives the quaternion that turns v1 into v2. For opposite vectors there are many of
# 180 degrees, so one expects one of these, or an error. It answers zeros, in this package's short form the
# identity: a sensor that was mounted upside down is "aligned" without being turned, and gravity stays on the
# wrong side. A thousandth of a degree off, the answer is right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check scikit-kinematics==0.10.4 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import os
import sys

os.environ.update(MPLBACKEND="agg", SDL_VIDEODRIVER="dummy", PYGAME_HIDE_SUPPORT_PROMPT="1", QT_QPA_PLATFORM="offscreen")
import numpy as np
from skinematics import vector

up = np.array([0.0, 0, 9.81])


def miss(v):  # degrees between v, after the rotation from it to up, and up
    after = vector.rotate_vector(v, vector.q_shortest_rotation(v, up))
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(after, up)), after @ up))


near = np.array([9.81 * np.sin(np.radians(1e-3)), 0, -9.81 * np.cos(np.radians(1e-3))])
print("scikit-kinematics", importlib.metadata.version("scikit-kinematics"))
print("guess: after the rotation the vector points up")
print(f"seen: from 179.999 degrees it misses by {miss(near):.3f} degrees, from 180 by {miss(-up):.3f}; the rotation is {vector.q_shortest_rotation(-up, up)}")
sys.exit(0 if miss(near) < 0.01 and abs(miss(-up) - 180) < 1e-9 else "this has changed")
PY
