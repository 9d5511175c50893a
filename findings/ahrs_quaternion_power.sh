#!/usr/bin/env bash
# ahrs 0.4.0: a Quaternion to the power of 1 is not itself.
#
# q ** 2 is documented as the exponential of 2 log q, the rotation by twice the angle; one expects q * q, and q for q ** 1. The
# exponential that is taken is that of each number by itself: q ** 1 is [1, exp(x), exp(y), exp(z)] of the parts of log
# q, not of unit norm, and no rotation that has to do with q. The product q * q is right.
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

q = ahrs.Quaternion([np.cos(0.3), 0.0, 0.0, np.sin(0.3)])  # 0.6 rad about z
twice = np.array(q * q)
one, two = np.array(q**1), np.array(q**2)
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: q ** 1 is", np.array(q).round(4), "and q ** 2 is", twice.round(4))
print(f"seen: q ** 1 is {one.round(4)} and q ** 2 is {two.round(4)}, of norm {np.linalg.norm(two):.3f}")
elements = np.allclose(one, np.exp([0.0, 0.0, 0.0, 0.3]))
sys.exit(0 if elements and np.allclose(twice, [np.cos(0.6), 0.0, 0.0, np.sin(0.6)]) else "this has changed")
PY
