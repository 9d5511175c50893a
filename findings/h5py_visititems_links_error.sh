#!/usr/bin/env bash
# h5py 3.16.0: an exception raised in the function that is given to Group.visititems_links does not come out of it.
#
# One would guess that it does, as with Group.visititems, whose function may raise to end the walk and say why. What comes out
# is a SystemError about an internal lock ("returned a result with an exception set"), which no `except` clause for one's own
# error catches; one's own exception is only its __cause__. So a check of a file's links (for instance: none leads to another
# file) has to collect what it finds, and raise after the walk.
#
# Exit status 0 while that is so; 1 when both functions behave alike.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check h5py==3.16.0 numpy==2.4.6
"$folder/venv/bin/python" - "$folder/recording.h5" <<'PYTHON'
import sys

import h5py
import numpy as np


class Found(Exception):
    """What the walk is to end with."""


def ends(name, item):
    raise Found(name)


def outcome(walk):
    try:
        walk(ends)
    except Exception as error:
        return f"{type(error).__name__} (cause: {type(error.__cause__).__name__})", type(error)
    return "no exception", None


with h5py.File(sys.argv[1], "w") as file:
    file["imu/gyr"] = np.zeros((5, 3))
    file["imu/acc"] = np.zeros((5, 3))
with h5py.File(sys.argv[1], "r") as file:
    items, links = outcome(file.visititems), outcome(file.visititems_links)
print(f"h5py {h5py.__version__}, HDF5 {h5py.version.hdf5_version}")
print("guess: both let the exception of the function through, Found")
print(f"seen:  visititems gives {items[0]}, visititems_links gives {links[0]}")
sys.exit(0 if items[1] is Found and links[1] is SystemError else 1)
PYTHON
