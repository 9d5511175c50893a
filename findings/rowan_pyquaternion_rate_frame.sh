#!/usr/bin/env bash
# rowan and pyquaternion integrate the same angular rate to different attitudes.
#
# Both have integrate(rate, step) for a quaternion with the scalar part first. A gyroscope measures in the
# sensor's frame, and one expects that both take that. pyquaternion does; rowan's rate is of the fixed frame,
# which its documentation leaves to a formula. From a level start no difference shows, so a test at rest or
# about one axis passes; a sensor that was rolled by 90 degrees, then turns by 90 degrees about its own z axis,
# ends 90 degrees apart.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check rowan==1.3.2 pyquaternion==0.9.9 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import numpy as np
import rowan
from pyquaternion import Quaternion

half = np.sqrt(0.5)


def ends(start, rate, steps=1000):
    mine, theirs = Quaternion(start), np.array(start)
    for _ in range(steps):
        mine.integrate(rate, 1 / steps)
        theirs = rowan.calculus.integrate(theirs, rate, 1 / steps)
    return mine.elements, theirs


def forward(q):  # where the sensor's x axis points
    return np.round(rowan.rotate(q, [1.0, 0, 0]), 6) + 0.0


rate = np.array([0.0, 0, np.pi / 2])
level, rolled = ends([1.0, 0, 0, 0], rate), ends([half, half, 0, 0], rate)
print("rowan", importlib.metadata.version("rowan"), "pyquaternion", importlib.metadata.version("pyquaternion"))
print("guess: a turn about the sensor's z axis, after a roll by 90 degrees, points its x axis up, in both")
print(f"seen: from level pyquaternion {forward(level[0])}, rowan {forward(level[1])}; rolled pyquaternion {forward(rolled[0])}, rowan {forward(rolled[1])}")
same = np.allclose(level[0], level[1])
sys.exit(0 if same and np.allclose(forward(rolled[0]), [0, 0, 1]) and np.allclose(forward(rolled[1]), [0, 1, 0]) else "this has changed")
PY
