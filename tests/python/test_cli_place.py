"""A place on earth on the command line: its declination, gravity and norm of the field."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from calibrated import sensor
from commands import Capture, error_of, output_of, saved

PLACE = (52.52, 13.40, 34.0)
TEXT = ",".join(map(str, PLACE))
START = "2015-06-30T12:00:00+00:00"


def test_a_run_takes_declination_and_gravity_of_the_place_at_the_recordings_date(
    tmp_path: Path, capsys: Capture
) -> None:
    pytest.importorskip("pygeomag")
    path = saved(tmp_path / "a.npz", meta={"start": START})
    rec = ar.read(path)
    out = tmp_path / "b.npz"
    shown = output_of(
        capsys, "run", path, "--filter", "mekf", "--place", TEXT, "--outputs", "linear_acceleration", "-o", out
    )
    field = ar.earth.field(*PLACE, START)
    assert f"declination {math.degrees(field.declination):.2f}°" in shown
    assert START in shown
    est = ar.MEKF(rate=rec.rate, declination=field.declination).run(rec)
    with np.load(out) as found:
        assert np.array_equal(found["quat"], est.quat)
        expected = est.linear_acceleration(rec.acc, gravity=ar.earth.gravity(PLACE[0], PLACE[2]))
        assert np.array_equal(found["linear_acceleration"], expected)
    # Between these years the declination of Berlin has changed by more than a degree.
    shown = output_of(capsys, "run", path, "--filter", "mekf", "--place", TEXT, "--date", "2025-06-30")
    other = ar.earth.declination(*PLACE, "2025-06-30")
    assert f"declination {math.degrees(other):.2f}°" in shown
    assert other - field.declination > math.radians(1.0)
    assert "field      declination" not in output_of(capsys, "run", path, "--filter", "mekf", "--place", TEXT, "--6d")


def test_calibrations_have_the_norm_and_the_gravity_of_the_place(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("pygeomag")
    x, _, _ = sensor(0, 9)
    t = np.arange(len(x)) / 100
    norm = ar.earth.field(*PLACE, START).norm
    x = x * (norm / np.median(np.linalg.norm(x - x.mean(axis=0), axis=1)))
    rec = ar.Recording(t=t, rate=100.0, gyr=np.zeros_like(x), mag=x, meta={"start": START})
    rec.save(tmp_path / "m.npz")
    cal = tmp_path / "cal.json"
    output_of(capsys, "calibrate", "mag", tmp_path / "m.npz", "--place", TEXT, "-o", cal)
    assert json.loads(cal.read_text(encoding="utf-8"))["mag"]["info"]["norm"] == pytest.approx(norm, rel=1e-12)
    fit = ar.calibration.magnetometer(x, norm=norm)
    assert ar.calibration.Calibration.load(cal, "mag") == fit.calibration


def test_a_place_that_is_none_and_a_declination_beside_it_are_refused(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("pygeomag")
    run = ("run", saved(tmp_path / "a.npz"), "--filter", "mekf", "--place")
    assert "--place: latitude: expected one within ±90°, got 99.0" in error_of(capsys, *run, "99,0,0")
    assert "expected LAT,LON,ALT in °, °, m, got 'Berlin'" in error_of(capsys, *run, "Berlin")
    assert error_of(capsys, *run, TEXT, "--declination", 4) == "--place and --declination: expected one of them"
