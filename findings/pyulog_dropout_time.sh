#!/usr/bin/env bash
# The time of a drop-out in a PX4 log depends on which topics pyulog is asked to load.
#
# A ULog says at a place in the file that the logger has lost messages, and for how long; it has no stamp of its
# own. One expects the same time for the same drop-out of the same file. pyulog gives it the last stamp of the
# topics that are loaded: a reader that loads the slow topics only finds the drop-out up to one of their periods
# earlier. The log's last stamp moves the same way.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check pyulog==1.3.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import struct
import sys

import pyulog


def message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


out = [b"\x55\x4c\x6f\x67\x01\x12\x35", struct.pack("<BQ", 1, 0), message("B", bytes(40))]
out += [message("F", b"fast:uint64_t timestamp;float x;"), message("F", b"slow:uint64_t timestamp;float x;")]
out += [message("A", struct.pack("<BH", 0, number) + name) for number, name in enumerate((b"fast", b"slow"))]
for k in range(100):
    stamp = 1_000_000 + 4000 * k
    if k == 80:
        out.append(message("O", struct.pack("<H", 20)))
    out.append(message("D", struct.pack("<HQf", 0, stamp, 1.0)))
    if k % 50 == 0:
        out.append(message("D", struct.pack("<HQf", 1, stamp, 1.0)))
with open("log.ulg", "wb") as file:
    file.write(b"".join(out))
logs = [pyulog.ULog("log.ulg", topics) for topics in (None, ["fast"], ["slow"])]
times = [log.dropouts[0].timestamp for log in logs]
print("pyulog", importlib.metadata.version("pyulog"))
print("guess: one drop-out has one time")
print(f"seen: {times[0]} us with all topics, {times[1]} with the fast one, {times[2]} with the slow one alone")
print(f"seen: the log ends at {logs[0].last_timestamp} us with all topics, at {logs[2].last_timestamp} with the slow one alone")
sys.exit(0 if times == [1_316_000, 1_316_000, 1_200_000] else "this has changed")
PY
