#!/usr/bin/env bash
# spatialmath-python: the distance of two attitudes halves when they are quaternions.
#
# SO3 and UnitQuaternion are the two classes for a rotation, with the same methods, and angdist() is said to
# give an angle in radians. One expects the same angle for the same two attitudes. With the defaults SO3 gives
# the angle of the rotation between them and UnitQuaternion half of it (the angle between the quaternions as
# vectors of four). Errors of a filter are half as large in the one class as in the other.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check spatialmath-python==1.1.18 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

from spatialmath import SO3, UnitQuaternion

matrix = SO3.Rx(0.1).angdist(SO3.Rx(0.5))
quaternion = UnitQuaternion.Rx(0.1).angdist(UnitQuaternion.Rx(0.5))
between = (UnitQuaternion.Rx(0.1).inv() * UnitQuaternion.Rx(0.5)).angvec()[0]
print("spatialmath-python", importlib.metadata.version("spatialmath-python"))
print("guess: rotations of 0.1 and 0.5 rad about one axis are 0.4 rad apart in both classes")
print(f"seen: {matrix:.3f} rad for SO3, {quaternion:.3f} rad for UnitQuaternion; the rotation between the two has {between:.3f} rad")
sys.exit(0 if abs(matrix - 0.4) < 1e-9 and abs(between - 0.4) < 1e-9 and abs(quaternion - 0.2) < 1e-9 else "this has changed")
PY
