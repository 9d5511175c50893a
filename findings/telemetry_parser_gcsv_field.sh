#!/usr/bin/env bash
# telemetry-parser gives the magnetic field of a Gyroflow log 10,000 times too small.
#
# In a .gcsv log "mscale" times the raw number is in gauss. The library answers in microtesla, so one expects its
# result times 100. It divides by 100 where it should multiply: 0.5 gauss, the earth's field, comes out as 0.005
# uT and not as 50 uT. Its rates and accelerations from the same file are right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check telemetry-parser==0.3.0
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import math
import sys

import telemetry_parser

header = "GYROFLOW IMU LOG\nversion,1.3\nid,logger\norientation,XYZ\ntscale,0.001\ngscale,0.001\nascale,0.001\nmscale,0.001\n"
rows = "".join(f"{k},100,0,0,0,0,1000,500,0,0\n" for k in range(10))
with open("video.gcsv", "w") as file:
    file.write(header + "t,gx,gy,gz,ax,ay,az,mx,my,mz\n" + rows)
parser = telemetry_parser.Parser("video.gcsv")
row = parser.normalized_imu()[0]
unit = parser.telemetry()[0]["Magnetometer"]["Unit"]
print("telemetry-parser", importlib.metadata.version("telemetry-parser"))
print("guess: 500 at 0.001 gauss each are 50 uT")
print(f"seen: {row['magn'][0]:g}, by the unit {unit!r}; gyroscope {row['gyro'][0]:.4f} deg/s, accelerometer {row['accl'][2]:.4f} m/s2")
right = math.isclose(row["gyro"][0], math.degrees(0.1)) and math.isclose(row["accl"][2], 9.80665)
sys.exit(0 if right and math.isclose(row["magn"][0], 0.005) else "this has changed")
PY
