#!/usr/bin/env bash
# ezc3d writes more than 65,535 frames into a C3D file, and reads 65,535 of them.
#
# C3D's header counts frames in 16 bits. At 100 frames a second that is 10.9 minutes. One expects a longer
# recording to be refused, or to come back whole (the file is as large as it should be). Everything is written,
# and reading ends after 65,535 frames without a word: of a recording of 70,000 frames the last 45 s are lost.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ezc3d==1.7.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import os
import sys
import warnings

import ezc3d
import numpy as np

warnings.simplefilter("error")


def written(frames):
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["M1"]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [100]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = ["AccX", "AccY", "AccZ"]
    file["data"]["points"] = np.ones((4, 1, frames))
    file["data"]["analogs"] = np.tile(np.arange(frames, dtype=float), (1, 3, 1))
    file.write("walk.c3d")
    back = ezc3d.c3d("walk.c3d")
    return back["data"]["analogs"].shape[2], os.path.getsize("walk.c3d")


print("ezc3d", importlib.metadata.version("ezc3d"))
print("guess: 70,000 frames are refused, or come back")
short, size_short = written(65_000)
long, size_long = written(70_000)
room = (size_long - size_short) / (5000 * (4 + 3) * 4)
print(f"seen: of 65,000 frames {short} come back; of 70,000 frames {long}, from a file that has room for {room:.1%} of the 5,000 more")
sys.exit(0 if (short, long) == (65_000, 65_535) and abs(room - 1) < 0.01 else "this has changed")
PY
