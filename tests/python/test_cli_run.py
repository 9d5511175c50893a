"""Laws of `ahrs-rs run`."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from commands import EVERY_FILTER, HAS_PRESET, Capture, error_of, output_of, quat_of, saved, simulated


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return saved(tmp_path / "walk.npz")


@EVERY_FILTER
def test_run_writes_what_the_filter_estimates(
    cls: type[ar.Filter], file: Path, tmp_path: Path, capsys: Capture
) -> None:
    output_of(capsys, "run", file, "--filter", cls.NAME, "-o", tmp_path / "out.npz")
    recording = ar.read(file)
    est = cls(rate=50.0).run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    with np.load(tmp_path / "out.npz") as written:
        assert np.array_equal(written["t"], recording.t)
        assert np.array_equal(written["quat"], est.quat)
        assert np.array_equal(written["status"], est.status)
        assert ("gyr_bias" in written) == (est.gyr_bias is not None)


def test_run_writes_the_same_quaternions_to_every_format(file: Path, tmp_path: Path, capsys: Capture) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    for ending in ("npz", "csv", "parquet"):
        output_of(capsys, "run", file, "--filter", "Madgwick", "-o", tmp_path / f"out.{ending}")
    with (tmp_path / "out.csv").open() as text:
        rows = list(csv.DictReader(text))
    table = parquet.read_table(tmp_path / "out.parquet")
    for i, name in enumerate(("qw", "qx", "qy", "qz")):
        expected = quat_of(tmp_path / "out.npz")[:, i]
        assert np.array_equal([float(row[name]) for row in rows], expected)
        assert np.array_equal(table[name].to_numpy(), expected)


@EVERY_FILTER
def test_filter_names_are_found_in_any_case(cls: type[ar.Filter], file: Path, capsys: Capture) -> None:
    shown = output_of(capsys, "run", file, "--filter", cls.NAME)
    assert output_of(capsys, "run", file, "--filter", cls.NAME.upper()) == shown
    assert output_of(capsys, "run", file, "--filter", cls.NAME.lower()) == shown


@EVERY_FILTER
def test_every_parameter_is_set_by_the_text_of_its_value(
    cls: type[ar.Filter], file: Path, tmp_path: Path, capsys: Capture
) -> None:
    recording = ar.read(file)
    for param in cls.PARAMS.values():
        if param.options is not None:
            value: float | str | bool = next(option for option in reversed(param.options) if option != param.default)
        else:
            assert param.range is not None
            value = min(max(0.5 * float(param.default) + 0.01, param.range[0]), param.range[1])
        out = tmp_path / "out.npz"
        output_of(capsys, "run", file, "--filter", cls.NAME, "--set", f"{param.name}={value}", "-o", out)
        keywords: dict[str, Any] = {param.name: value}
        f = cls(rate=50.0, **keywords)
        expected = f.run(recording.gyr, recording.acc, recording.mag, t=recording.t)
        assert np.array_equal(quat_of(out), expected.quat)


@pytest.mark.parametrize(("cls", "preset"), HAS_PRESET, ids=[f"{c.NAME}-{p}" for c, p in HAS_PRESET])
def test_every_preset_is_the_one_of_its_class(
    cls: type[ar.Filter], preset: str, file: Path, tmp_path: Path, capsys: Capture
) -> None:
    output_of(capsys, "run", file, "--filter", cls.NAME, "--preset", preset, "-o", tmp_path / "out.npz")
    recording = ar.read(file)
    f = cls.preset(preset, rate=50.0)
    expected = f.run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    assert np.array_equal(quat_of(tmp_path / "out.npz"), expected.quat)


def test_set_goes_over_the_preset(file: Path, capsys: Capture) -> None:
    options = ("--filter", "Mahony", "--preset", "parikh2021", "--set", "kp=3")
    assert "kp=3 ki=0.01 " in output_of(capsys, "run", file, *options)


@pytest.mark.parametrize(
    ("options", "keywords", "with_mag"),
    [
        (["--6d"], {}, False),
        (["--frame", "ned"], {"frame": "NED"}, True),
        (["--declination", "-4.5"], {"declination": math.radians(-4.5)}, True),
        (["--gyr-hold", "linear"], {"gyr_hold": "linear"}, True),
    ],
    ids=["6d", "frame", "declination in degrees", "gyr-hold"],
)
def test_settings_are_those_of_the_filter(
    options: list[str], keywords: dict[str, Any], with_mag: bool, file: Path, tmp_path: Path, capsys: Capture
) -> None:
    output_of(capsys, "run", file, "--filter", "Madgwick", *options, "-o", tmp_path / "out.npz")
    recording = ar.read(file)
    f = ar.FILTERS["Madgwick"](rate=50.0, **keywords)
    expected = f.run(recording.gyr, recording.acc, recording.mag if with_mag else None, t=recording.t)
    assert np.array_equal(quat_of(tmp_path / "out.npz"), expected.quat)


def test_summary_counts_samples_flags_and_errors(file: Path, capsys: Capture) -> None:
    recording = ar.read(file)
    assert recording.ref is not None
    assert recording.mask is not None
    est = ar.FILTERS["Tilt"](rate=50.0).run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    score = ar.metrics.score(est.quat, recording.ref, recording.mask)
    shown = output_of(capsys, "run", file, "--filter", "tilt")
    assert "300 in 5.98 s, 50 Hz" in shown
    assert "MAG_MISSING 200 (66.7 %)\n" in shown
    assert f"total {score.total:.2f}°, heading {score.heading:.2f}°" in shown
    assert f"inclination {score.inclination:.2f}° (over {np.count_nonzero(recording.mask)} samples" in shown


def test_errors_do_not_depend_on_the_frame_of_the_output(file: Path, capsys: Capture) -> None:
    lines = [
        next(
            line
            for line in output_of(capsys, "run", file, "--filter", "mahony", "--frame", frame).splitlines()
            if line.startswith("RMSE")
        )
        for frame in ("ENU", "NED", "NWU")
    ]
    assert len(set(lines)) == 1
    assert lines[0].endswith("in ENU)")


def test_reference_without_a_named_frame_is_taken_to_be_in_the_frame_asked_for(tmp_path: Path, capsys: Capture) -> None:
    file = saved(tmp_path / "walk.npz", meta={})
    assert "reference, in NED)" in output_of(capsys, "run", file, "--filter", "tilt", "--frame", "NED")


def test_run_without_a_reference_shows_no_error(tmp_path: Path, capsys: Capture) -> None:
    assert "RMSE" not in output_of(capsys, "run", saved(tmp_path / "a.npz", ref=None), "--filter", "tilt")


def test_run_without_output_writes_nothing(file: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.chdir(file.parent)
    output_of(capsys, "run", file, "--filter", "tilt")
    assert list(file.parent.iterdir()) == [file]


def test_rate_takes_the_place_of_the_times_of_a_file(file: Path, tmp_path: Path, capsys: Capture) -> None:
    output_of(capsys, "run", file, "--filter", "Madgwick", "--rate", "25", "-o", tmp_path / "out.npz")
    recording = ar.read(file)
    f = ar.FILTERS["Madgwick"](rate=25.0)
    expected = f.run(recording.gyr, recording.acc, recording.mag, t=np.arange(300) / 25.0)
    assert np.array_equal(quat_of(tmp_path / "out.npz"), expected.quat)


def test_rate_serves_a_file_without_times(tmp_path: Path, capsys: Capture) -> None:
    recording = simulated()
    np.savez(tmp_path / "a.npz", gyr=recording.gyr)
    assert "has no times" in error_of(capsys, "run", tmp_path / "a.npz", "--filter", "tilt")
    shown = output_of(capsys, "run", tmp_path / "a.npz", "--filter", "tilt", "--rate", "50")
    assert "300 in 5.98 s, 50 Hz" in shown


def test_assumed_units_are_told(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("pyarrow")
    recording = simulated()
    table = np.column_stack((recording.t, recording.gyr))
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="t,gx,gy,gz", comments="")
    shown = output_of(capsys, "run", tmp_path / "a.csv", "--filter", "tilt")
    assert "gyr in rad/s" in shown
    assert "NOT_ALIGNED 300 (100 %)" in shown
