#!/usr/bin/env bash
# ahrs 0.4.0: q2euler says that some rotations by 120 degrees and 180 degrees are none.
#
# One expects angles of zero for the identity alone. The function looks whether the elements of [1, 0, 0, 0] - q add up to
# zero, and not whether all are zero, and so returns zeros for every quaternion whose four elements have the sum 1: the
# rotation by 120 degrees (0.5, 0.5, 0.5, -0.5), half a turn about x, (0, 1, 0, 0), and others. A quaternion that is close by
# has its proper angles, so that a smooth motion jumps to zero and back.
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
from ahrs.common.orientation import q2euler

print("ahrs", importlib.metadata.version("ahrs"))
print("guess: angles of zero for the identity alone")
good = True
for q in ([0.5, 0.5, 0.5, -0.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]):
    near = np.array(q) + [1e-6, 0.0, 0.0, 2e-6]
    near /= np.linalg.norm(near)
    there, beside = np.degrees(q2euler(np.array(q))), np.degrees(q2euler(near))
    print(f"seen: {q}: {there} degrees; 3e-6 beside it: {beside.round(2)} degrees")
    good &= not there.any() and np.abs(beside).max() > 80.0
sys.exit(0 if good else "this has changed")
PY
