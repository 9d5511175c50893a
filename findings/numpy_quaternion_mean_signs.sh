#!/usr/bin/env bash
# numpy-quaternion: the mean of an attitude and the same attitude is NaN if one has the other sign.
#
# q and -q are one rotation, and devices that keep the scalar part positive change the sign whenever they pass
# 180 degrees. mean_rotor_in_chordal_metric says that it minimises the chordal distance of rotors; of a function
# for means of rotations one expects that signs do not matter (Markley's mean, scipy's Rotation.mean). It adds
# the quaternions up: q and -q cancel, and headings of 179 and 181 degrees, as such a device gives them, have a
# mean heading near 0 degrees.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check numpy-quaternion==2024.0.13 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys
import warnings

import numpy as np
import quaternion
from scipy.spatial.transform import Rotation

warnings.simplefilter("ignore")


def heading(q):
    return np.degrees(2 * np.arctan2(q[3], q[0])) % 360


def device(degrees):  # scalar part kept positive
    q = np.array([np.cos(np.radians(degrees) / 2), 0, 0, np.sin(np.radians(degrees) / 2)])
    return q if q[0] >= 0 else -q


pair = np.array([device(178.0), device(183.0)])
mean = quaternion.as_float_array(quaternion.mean_rotor_in_chordal_metric(quaternion.from_float_array(pair)))
other = Rotation.from_quat(pair, scalar_first=True).mean().as_quat(scalar_first=True)
same = np.array([pair[0], -pair[0]])
none = quaternion.as_float_array(quaternion.mean_rotor_in_chordal_metric(quaternion.from_float_array(same)))
print("numpy-quaternion", importlib.metadata.version("numpy-quaternion"))
print("guess: 178 and 183 degrees have the mean 180.5, and one attitude with both signs has itself as its mean")
print(f"seen: {heading(mean):.1f} degrees (scipy: {heading(other):.1f}), and {none}")
right = abs(heading(other) - 180.5) < 1e-6
sys.exit(0 if right and abs(heading(mean) - 0.5) < 1e-6 and np.isnan(none).all() else "this has changed")
PY
