#!/usr/bin/env bash
# pyquaternion: interpolating between two attitudes changes the first of them.
#
# Quaternion.slerp(q0, q1, 0.5) says that it may normalise its arguments. One expects that unit quaternions come
# out of it as they went in. Where the short way needs the other sign, it is q0 itself that is negated, in the
# caller's hands. A track whose signs were continuous has a jump afterwards, and distance(), which tells the
# signs apart, between the changed element and its unchanged neighbour goes from near 0 to near pi.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyquaternion==0.9.9 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import numpy as np
from pyquaternion import Quaternion

track = [Quaternion(np.array([np.cos(a / 2), 0, 0, np.sin(a / 2)])) for a in (0.0, 0.1, 0.2)]
target = Quaternion(-np.array([np.cos(0.2), 0, 0, np.sin(0.2)]))  # 0.4 rad, with the other sign
before, near = track[1].elements.copy(), Quaternion.distance(track[0], track[1])
Quaternion.slerp(track[1], target, 0.5)
after, far = track[1].elements, Quaternion.distance(track[0], track[1])
print("pyquaternion", importlib.metadata.version("pyquaternion"))
print("guess: the unit quaternion that was interpolated from is what it was")
print(f"seen: before {before.round(4)}, after {after.round(4)}; its distance from its neighbour went from {near:.3f} to {far:.3f}")
sys.exit(0 if np.allclose(after, -before) and near < 0.06 and far > 3 else "this has changed")
PY
