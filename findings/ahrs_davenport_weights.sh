#!/usr/bin/env bash
# ahrs 0.4.0: Davenport's default weights are equal, and the accelerometer counts for nothing.
#
# The weights of both sensors are 1 by default, and one expects, as in QUEST of the same package, that errors are shared
# alike. Neither the measurements nor the references are normalised: gravity is 9.8 m/s2 and the reference field 48,000 nT, so
# that a product of field vectors in nT has ten million times the weight of one of accelerations. Of a disagreement
# of two degrees between accelerometer and magnetometer, the whole goes to the accelerometer. The result depends on the units.
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

davenport, quest = ahrs.filters.Davenport(), ahrs.filters.QUEST()
up, field = np.array([0.0, 0.0, 1.0]), davenport.m_q / np.linalg.norm(davenport.m_q)
# A level sensor that points north, with the field tipped by 2 degrees towards the vertical: the angle does not fit.
axis = np.cross(field, up) / np.linalg.norm(np.cross(field, up))
tipped = np.cos(np.radians(2.0)) * field + np.sin(np.radians(2.0)) * np.cross(axis, field)


def error(q, earth, sensor):
    w, v = q[0], np.array(q[1:])
    turned = sensor + 2.0 * np.cross(v, np.cross(v, sensor) + w * sensor)
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(turned, earth)), turned @ earth))


print("ahrs", importlib.metadata.version("ahrs"), "weights", davenport.w, quest.w)
print("guess: 1 degree is left in each sensor")
found = {}
for name, estimator in (("QUEST", quest), ("Davenport", davenport)):
    # A tenth of a degree of another turn: QUEST inverts a matrix that is singular for an exactly level sensor.
    tilt = np.radians(0.1)
    small = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(tilt), np.sin(tilt)], [0.0, -np.sin(tilt), np.cos(tilt)]])
    q = estimator.estimate(acc=9.81 * small @ up, mag=48000.0 * small @ tipped)
    found[name] = error(q, up, small @ up), error(q, field, small @ tipped)
    print(f"seen: {name}: accelerometer {found[name][0]:.3f} degrees, magnetometer {found[name][1]:.6f} degrees")
alike = abs(found["QUEST"][0] - 1.0) < 0.01 and abs(found["QUEST"][1] - 1.0) < 0.01
sys.exit(0 if alike and found["Davenport"][0] > 1.99 and found["Davenport"][1] < 1e-3 else "this has changed")
PY
