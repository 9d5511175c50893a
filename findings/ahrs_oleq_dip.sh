#!/usr/bin/env bash
# ahrs 0.4.0: OLEQ takes a magnetic dip of 60 degrees for one of 30.
#
# The filters of this package take the dip of the earth's field in degrees, as a float, and make their reference
# vector of it. In north-east-down its northward part is the cosine of the dip and its downward part the sine;
# QUEST has it so. One expects the same of OLEQ, whose frame is also north-east-down by default. It exchanges
# the two, and only at 45 degrees nothing is wrong. In the other frame, east-north-up, they stand right. Where
# no dip is given and the reference comes from the magnetic model (for Munich, dip 64 degrees), the same
# exchange is made.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ahrs==0.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import numpy as np
from ahrs.filters import OLEQ, QUEST


def dip(down, north):
    return np.degrees(np.arctan2(down, north))


quest, ned, enu, munich = QUEST(magnetic_dip=60.0).m_q, OLEQ(magnetic_ref=60.0).m_ref, OLEQ(magnetic_ref=60.0, frame="ENU").m_ref, OLEQ().m_ref
print("ahrs", importlib.metadata.version("ahrs"))
print("guess: a dip of 60 degrees is the vector (0.5, 0, 0.866) in north-east-down, for every filter")
print(f"seen: QUEST {quest.round(3)}, dip {dip(quest[2], quest[0]):.1f}; OLEQ {ned.round(3)}, dip {dip(ned[2], ned[0]):.1f}")
print(f"seen: OLEQ in east-north-up {enu.round(3)}, dip {dip(-enu[2], enu[1]):.1f}; for Munich without a dip {munich.round(3)}, dip {dip(munich[2], munich[0]):.1f}")
print("seen: the dip of Munich's field is above 60 degrees")
same = abs(dip(quest[2], quest[0]) - 60) < 1e-6
sys.exit(0 if same and abs(dip(ned[2], ned[0]) - 30) < 1e-6 and dip(munich[2], munich[0]) < 30 else "this has changed")
PY
