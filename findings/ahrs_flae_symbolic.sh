#!/usr/bin/env bash
# ahrs 0.4.0: FLAE's default method finds other attitudes than its two others.
#
# FLAE solves Wahba's problem by the largest root of a quartic, and its methods "symbolic" (the default), "newton" and
# "eig" differ in how they find the root. One expects them to agree to rounding, as they do in the paper, and all the
# more for directions without noise. By "symbolic" half of the attitudes are off by more than 0.01 degrees, and some by
# more than one: the closed form has the square root of a negative number, of which the real part, zero, is kept. The
# cube root after it needs both parts.
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

rng = np.random.default_rng(1)
dip = np.radians(60.0)
earth = np.array([[0.0, 0.0, 1.0], [np.cos(dip), 0.0, -np.sin(dip)]])  # the reference of FLAE(magnetic_dip=60)
truth = rng.standard_normal((200, 4))
truth /= np.linalg.norm(truth, axis=1, keepdims=True)


def matrix(q):
    w, x, y, z = q
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross


seen = np.array([earth @ matrix(q) for q in truth])  # rows: the directions in the sensor frame
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: all three methods give the true attitude, to rounding")
errors = {}
for method in ("symbolic", "eig"):
    flae = ahrs.filters.FLAE(acc=seen[:, 0], mag=seen[:, 1], magnetic_dip=60.0, method=method)
    errors[method] = np.degrees(2.0 * np.arccos(np.minimum(1.0, np.abs(np.sum(flae.Q * truth, axis=1)))))
    print(f"seen: {method}: median error {np.median(errors[method]):.3g} degrees, largest {errors[method].max():.3g}")
as_told = np.median(errors["symbolic"]) > 0.01 and errors["symbolic"].max() > 1.0 and errors["eig"].max() < 1e-5
sys.exit(0 if as_told else "this has changed")
PY
