#!/usr/bin/env bash
# ahrs 0.4.0: SAAM gives NaN for a sensor that lies level, whatever its heading.
#
# A level sensor is the first thing that one tries, and the attitude there is as well determined as anywhere. The closed
# form that SAAM has is the quaternion times one of its own parts, and that part is zero for every rotation about the
# vertical: 0/0. One expects a formula for an everyday pose. Close to it, at a tilt of 1e-8 rad, half of the digits are
# gone. The other closed form of the package, FAMC, is right for the same vectors.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ahrs==0.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys
import warnings

import ahrs
import numpy as np

warnings.simplefilter("ignore", RuntimeWarning)
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: a rotation about the vertical")
good = True
for heading in np.radians([0.0, 30.0, -100.0]):
    mag = np.array([20.0 * np.cos(heading), -20.0 * np.sin(heading), 45.0])
    saam = ahrs.filters.SAAM().estimate(acc=np.array([0.0, 0.0, 9.81]), mag=mag)
    famc = ahrs.filters.FAMC().estimate(acc=np.array([0.0, 0.0, 9.81]), mag=mag)
    print(f"seen: heading {np.degrees(heading):.0f} degrees: SAAM {saam}, FAMC {famc.round(4)}")
    good &= not np.isfinite(saam).any() and abs(abs(famc[0]) - np.cos(heading / 2.0)) < 1e-9
sys.exit(0 if good else "this has changed")
PY
