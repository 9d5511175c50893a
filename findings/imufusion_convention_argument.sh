#!/usr/bin/env bash
# imufusion 1.3.3: AhrsSettings(convention=...) is accepted, and the convention stays NWU.
#
# The settings are given as keywords, sample_rate, gain and the rest, and convention is one of them: a wrong keyword is refused,
# this one is not. One expects that it is set like the others. It keeps its default, north-west-up, and a recording that
# should come out in north-east-down is on its head, with yaw the other way round. As an attribute, settings.convention =
# ..., it works.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check imufusion==1.3.3 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import importlib.metadata
import sys

import imufusion
import numpy as np

print("imufusion", importlib.metadata.version("imufusion"))
given = imufusion.AhrsSettings(sample_rate=200.0, gain=0.7, convention=imufusion.CONVENTION_NED)
by_attribute = imufusion.AhrsSettings(sample_rate=200.0, gain=0.7)
by_attribute.convention = imufusion.CONVENTION_NED
try:
    imufusion.AhrsSettings(conventions=imufusion.CONVENTION_NED)
    refused = False
except TypeError:
    refused = True


def roll(settings):
    ahrs = imufusion.Ahrs()
    ahrs.set_settings(settings)
    for _ in range(2000):
        ahrs.update_no_magnetometer(np.zeros(3, np.float32), np.array([0.0, 0.6, 0.8], np.float32))
    return float(abs(imufusion.quaternion_to_euler(ahrs.get_quaternion())[0]))


print(f"guess: convention {imufusion.CONVENTION_NED} (NED), in which a sensor with z up has a roll beyond 90 degrees")
print(f"seen: sample rate {given.sample_rate}, gain {given.gain:.1f}, convention {given.convention}; a wrong keyword is refused: {refused}")
print(f"seen: roll {roll(given):.1f} degrees by the keyword, {roll(by_attribute):.1f} degrees by the attribute")
as_told = refused and given.sample_rate == 200.0 and given.convention == imufusion.CONVENTION_NWU
sys.exit(0 if as_told and roll(given) < 40.0 and roll(by_attribute) > 140.0 else "this has changed")
PY
