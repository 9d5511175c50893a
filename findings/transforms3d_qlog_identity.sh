#!/usr/bin/env bash
# transforms3d: the logarithm of no rotation is not zero.
#
# The logarithm of the unit quaternion 1 is 0, and its norm over a step is half the angle of the step. So one
# expects a norm that goes to 0 with the angle and is 0 for a sensor that rests. For the identity alone qlog
# answers 1 instead of 0: a step without any turn has the norm of a turn of 2 rad, more than any other step of
# the recording. A millionth of a radian is right. qexp hides it, as it answers 1 for any quaternion without a
# vector part, also for the true logarithm of 2.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check transforms3d==0.4.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import numpy as np
from transforms3d.quaternions import qexp, qlog


def turned(angle):  # twice the norm of the logarithm of a turn about x
    return 2 * np.linalg.norm(qlog(np.array([np.cos(angle / 2), np.sin(angle / 2), 0, 0])))


angles = (1e-1, 1e-3, 1e-6, 0.0)
seen = [turned(angle) for angle in angles]
print("transforms3d", importlib.metadata.version("transforms3d"))
print("guess: twice the norm of qlog is the angle, down to 0 for the identity")
print("seen: " + ", ".join(f"{value:.3g} for {angle:g} rad" for angle, value in zip(angles, seen)))
print(f"seen: qlog of the identity is {qlog(np.array([1.0, 0, 0, 0]))}; qexp of log 2 is {qexp(np.array([np.log(2), 0, 0, 0]))}")
right = np.allclose(seen[:3], angles[:3], rtol=1e-2)
sys.exit(0 if right and seen[3] == 2 else "this has changed")
PY
