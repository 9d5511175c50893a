#!/usr/bin/env bash
# ahrs 0.4.0: AngularRate by a series is the worse, the more terms it has.
#
# method="series" integrates the angular rate by the series of the matrix exponential, and order= is how many terms are
# taken; a higher one should come closer to method="closed", the exact rotation of a constant rate. The first order does what
# it says. From the second one on the matrix is raised to powers element by element, not as a matrix, and the result goes
# to another rotation as the order grows.
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

gyr = np.tile([1.0, 2.0, -1.5], (100, 1))
closed = np.array(ahrs.filters.AngularRate(gyr=gyr, frequency=100.0, method="closed").Q[-1])
errors = []
for order in (1, 2, 3, 6):
    series = np.array(ahrs.filters.AngularRate(gyr=gyr, frequency=100.0, method="series", order=order).Q[-1])
    errors.append(np.degrees(2.0 * np.arccos(min(1.0, abs(series @ closed)))))
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: errors after 1 s at 2.7 rad/s that shrink with the order")
print("seen: for the orders 1, 2, 3, 6:", ", ".join(f"{each:.3g}" for each in errors), "degrees")
sys.exit(0 if min(errors[1:]) > 5.0 * errors[0] else "this has changed")
PY
