#!/usr/bin/env bash
# npTDMS moves what was recorded before a pause behind it.
#
# A TDMS file (LabVIEW) is written in segments, and a waveform's wf_start_time may be written anew with each. A
# logger that pauses for a minute starts its second segment with the time at which it went on. One expects
# time_track(absolute_time=True) to have a hole of a minute, or to count on from the first start. It counts from
# the last start that was written: the samples from before the pause carry the time after it, and what was
# recorded at 03:05:05 is said to be of 03:05:05.05.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check nptdms==1.13.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import datetime
import importlib.metadata
import sys

import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter

start = datetime.datetime(2026, 1, 2, 3, 4, 5)
with TdmsWriter("imu.tdms") as writer:
    for number in range(2):
        properties = {"wf_increment": 0.01, "wf_start_offset": 0.0, "wf_start_time": start + number * datetime.timedelta(minutes=1)}
        writer.write_segment([ChannelObject("imu", "gyr_z", np.arange(5.0) + 5 * number, properties=properties)])
channel = TdmsFile.read("imu.tdms")["imu"]["gyr_z"]
seconds = (channel.time_track(absolute_time=True) - np.datetime64(start)) / np.timedelta64(1, "s")
print("npTDMS", importlib.metadata.version("nptdms"))
print("guess: five samples from 0 s on, five from 60 s on")
print(f"seen: samples {channel[:].astype(int).tolist()} at {seconds.round(2).tolist()} s")
sys.exit(0 if len(channel[:]) == 10 and np.allclose(seconds, 60 + np.arange(10) / 100) else "this has changed")
PY
