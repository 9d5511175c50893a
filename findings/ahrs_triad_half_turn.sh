#!/usr/bin/env bash
# ahrs 0.4.0: TRIAD's quaternion is not the rotation of its matrix where the sensor is turned by half a turn.
#
# representation="quaternion" gives what representation="rotmat" gives, in another form, one would think. The matrix is right.
# The quaternion comes from `chiaverini`, which gives each part the sign of a difference that is zero for half a turn. The sign
# of zero is taken as zero, so that parts vanish, or all of them, and then the identity is returned: off by 180 degrees, without
# a warning. Only where rounding makes all differences other than zero is the quaternion right. The package's own `shepperd` is
# right for the same matrices.
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
from ahrs.common.orientation import q2R, shepperd

rng = np.random.default_rng(0)
v1, v2 = np.array([0.0, 0.0, 1.0]), np.array([0.5, 0.0, np.sqrt(0.75)])
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: quaternion and matrix are the same rotation")
count, wrong, identity, good = 200, 0, 0, 0
for _ in range(count):
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    w1, w2 = (2.0 * (axis @ v) * axis - v for v in (v1, v2))  # half a turn about the axis
    kinds = ("rotmat", "quaternion")
    dcm, q = (ahrs.filters.TRIAD(w1=w1, w2=w2, v1=v1, v2=v2, representation=kind).A for kind in kinds)
    assert np.allclose(dcm, 2.0 * np.outer(axis, axis) - np.eye(3), atol=1e-9)
    wrong += not np.allclose(q2R(q), dcm, atol=0.01)
    identity += np.allclose(q, [1.0, 0.0, 0.0, 0.0])
    good += np.allclose(q2R(shepperd(dcm)), dcm, atol=1e-6)
print(f"seen: {wrong} of {count} quaternions are another rotation, {identity} of them the identity; by shepperd {count - good}")
sys.exit(0 if wrong > count / 2 and good == count else "this has changed")
PY
