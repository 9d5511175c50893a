#!/usr/bin/env bash
# ahrs 0.4.0: WMM(date).magnetic_field(place) is the field of today, not of the date.
#
# The magnetic model is made for a date; magnetic_field() then takes a place, and optionally a date. One expects
# that the date of the model holds if no other is given. It does not: the method falls back to the day on which
# the package was imported and overwrites the model's date, and even its epoch's coefficients. A declination for
# a recording of 2016 is off by the drift of all years since (some 1.5 degrees in Munich). The place given with
# the date to the constructor is right.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check ahrs==0.4.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
import datetime
import importlib.metadata
import sys

from ahrs.utils import WMM

then, place = datetime.date(2016, 7, 1), (48.1, 11.6, 0.5)
at_once = WMM(then, latitude=place[0], longitude=place[1], height=place[2])
model = WMM(then)
before = (model.date, model.model)
model.magnetic_field(*place)
spoken = WMM(then)
spoken.magnetic_field(*place, date=then)
today = WMM(then)
today.magnetic_field(*place, date=datetime.date.today())
print("ahrs", importlib.metadata.version("ahrs"))
print(f"guess: a model of {then} gives the declination of {then}, {at_once.D:.2f} degrees")
print(f"seen: {model.D:.2f} degrees; the model's date, {before[0]} ({before[1]}), has become {model.date} ({model.model})")
print(f"seen: {spoken.D:.2f} degrees where the date is said twice, {today.D:.2f} degrees for today")
same = abs(at_once.D - spoken.D) < 1e-9 and abs(model.D - today.D) < 0.01
sys.exit(0 if same and abs(model.D - at_once.D) > 1 else "this has changed")
PY
