#!/usr/bin/env bash
# pyrr: a turn about z by its name and a turn about (0, 0, 1) go opposite ways.
#
# matrix33 has create_from_z_rotation(angle) and create_from_axis_rotation(axis, angle). One expects that the
# first is the second with the axis z. They are each other's inverse. Quaternions have both functions too, and
# there they agree; the matrix of the quaternion is the one of create_from_z_rotation, yet applied to a vector
# by the package's own functions quaternion and matrix turn it opposite ways.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyrr==0.10.3 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import numpy as np
from pyrr import matrix33, quaternion

x, angle = np.array([1.0, 0, 0]), np.pi / 2
by_name = matrix33.apply_to_vector(matrix33.create_from_z_rotation(angle), x)
by_axis = matrix33.apply_to_vector(matrix33.create_from_axis_rotation(np.array([0.0, 0, 1]), angle), x)
q_name, q_axis = quaternion.create_from_z_rotation(angle), quaternion.create_from_axis_rotation(np.array([0.0, 0, 1]), angle)
turned = quaternion.apply_to_vector(q_name, x)
of_q = matrix33.apply_to_vector(matrix33.create_from_quaternion(q_name), x)
print("pyrr", importlib.metadata.version("pyrr"))
print("guess: 90 degrees about z turn x to y, whichever function makes the rotation")
print(f"seen: matrix by name {np.round(by_name) + 0.0}, by axis {np.round(by_axis) + 0.0}; quaternion {np.round(turned) + 0.0}, its matrix {np.round(of_q) + 0.0}")
y = np.array([0.0, 1, 0])
same = np.allclose(q_name, q_axis) and np.allclose(turned, y)
sys.exit(0 if same and np.allclose(by_name, -y) and np.allclose(by_axis, y) and np.allclose(of_q, -y) else "this has changed")
PY
