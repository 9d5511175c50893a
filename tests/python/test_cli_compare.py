"""Laws of `ahrs-rs compare`."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from commands import DATA, Capture, error_of, needs_data, output_of, quat_of, saved
from recordings import repoimu_rows, write_repoimu
from signals import multiply, quats, random_turns


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return saved(tmp_path / "walk.npz")


def compare_rows(capsys: Capture, tmp_path: Path, *argv: object) -> dict[tuple[str, str], dict[str, str]]:
    """The table that `compare --csv` writes, by filter and file."""
    output_of(capsys, "compare", *argv, "--csv", tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(encoding="utf-8") as text:
        return {(row["filter"], row["file"]): row for row in csv.DictReader(text)}


def test_compare_scores_every_filter_over_the_mask(file: Path, tmp_path: Path, capsys: Capture) -> None:
    rows = compare_rows(capsys, tmp_path, file)
    assert set(rows) == {(name, "") for name in ar.FILTERS}
    recording = ar.read(file)
    assert recording.ref is not None
    for name, cls in ar.FILTERS.items():
        est = cls(rate=50.0).run(recording.gyr, recording.acc, recording.mag, t=recording.t)
        score = ar.metrics.score(est.quat, recording.ref, recording.mask)
        row = rows[name, ""]
        assert float(row["total_deg"]) == score.total
        assert float(row["heading_deg"]) == score.heading
        assert float(row["inclination_deg"]) == score.inclination
        assert row["sensors"] == ("9D" if cls.MAGNETOMETER else "6D")


def test_table_is_ordered_by_the_total_error(file: Path, capsys: Capture) -> None:
    lines = output_of(capsys, "compare", file).splitlines()
    assert lines[2].split() == ["filter", "sensors", "total", "heading", "inclination", "ns/sample"]
    totals = [float(line.split()[2]) for line in lines[3:]]
    assert len(totals) == len(ar.FILTERS)
    assert totals == sorted(totals)


def test_mean_row_is_the_mean_of_the_rows_of_the_files(tmp_path: Path, capsys: Capture) -> None:
    files = [saved(tmp_path / f"{seed}.npz", seed) for seed in range(3)]
    rows = compare_rows(capsys, tmp_path, *files, "--per-file", "--filters", "tilt,MADGWICK")
    names = ["", *(file.name for file in files)]
    assert set(rows) == {(name, file) for name in ("Tilt", "Madgwick") for file in names}
    for name in ("Tilt", "Madgwick"):
        for column in ("total_deg", "heading_deg", "inclination_deg"):
            each = [float(rows[name, file.name][column]) for file in files]
            # Sums of three doubles in another order: a few roundings.
            assert float(rows[name, ""][column]) == pytest.approx(np.mean(each), rel=1e-14)


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path: Path, capsys: Capture) -> None:
    files = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        files.append(saved(tmp_path / folder / "walk.npz"))
    rows = compare_rows(capsys, tmp_path, *files, "--per-file", "--filters", "tilt")
    assert {file for _, file in rows} == {"", *map(str, files)}


def test_parameter_for_one_filter_goes_before_the_one_for_all(file: Path, tmp_path: Path, capsys: Capture) -> None:
    options = ("--set", "madgwick.integration=first-order", "--set", "integration=exponential")
    rows = compare_rows(capsys, tmp_path, file, *options, "--set", "ki=0.5")
    assert rows["Madgwick", ""]["parameters"] == "integration=first-order"
    assert rows["Mahony", ""]["parameters"] == "ki=0.5"
    assert rows["Tilt", ""]["parameters"] == ""


def test_preset_is_used_by_the_filters_that_have_it(file: Path, tmp_path: Path, capsys: Capture) -> None:
    rows = compare_rows(capsys, tmp_path, file, "--preset", "ludwig2018")
    for name, cls in ar.FILTERS.items():
        defaults = {key: param.default for key, param in cls.PARAMS.items()}
        preset = dict(cls.PRESETS.get("ludwig2018", {}))
        changed = {key: value for key, value in preset.items() if value != defaults[key]}
        expected = " ".join(f"{key}={value:.6g}" for key, value in changed.items())
        assert rows[name, ""]["parameters"] == expected


def test_6d_takes_the_magnetometer_from_every_filter_and_says_what_the_heading_is(
    file: Path, tmp_path: Path, capsys: Capture
) -> None:
    assert {row["sensors"] for row in compare_rows(capsys, tmp_path, file, "--6d").values()} == {"6D"}
    assert "the heading is relative to the start" in output_of(capsys, "compare", file, "--6d")


def test_files_without_a_reference_are_skipped_and_named(file: Path, tmp_path: Path, capsys: Capture) -> None:
    no_ref = saved(tmp_path / "no_ref.npz", ref=None)
    no_mask = saved(tmp_path / "no_mask.npz", mask=np.zeros(300, dtype=bool))
    shown = output_of(capsys, "compare", no_ref, file, no_mask, "--filters", "tilt")
    assert "RMSE in degrees (one file)" in shown
    assert "note: skipped, no reference: no_ref.npz\n" in shown
    assert "note: skipped, no reference at any sample that counts: no_mask.npz\n" in shown


def test_compare_without_any_reference_is_an_error(tmp_path: Path, capsys: Capture) -> None:
    file = saved(tmp_path / "no_ref.npz", ref=None)
    assert error_of(capsys, "compare", file) == "nothing to compare with: skipped, no reference: no_ref.npz"


def test_reference_that_is_not_in_an_earth_frame_is_noted(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("pyarrow")
    file = write_repoimu(tmp_path / "stick.csv", repoimu_rows(ar.simulate.demo(6.0, 50.0)))
    for argv in (("compare", file, "--filters", "tilt"), ("run", file, "--filter", "tilt")):
        assert "the reference frame is not the earth frame (Vicon" in output_of(capsys, *argv)


@needs_data
def test_compare_agrees_with_the_scores_of_a_real_recording(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("h5py")
    path = min((Path(DATA) / "broad").glob("*.hdf5"))
    rows = compare_rows(capsys, tmp_path, path, "--set", "beta=0.1", "--plot", tmp_path / "errors.png")
    recording = ar.read(path)
    assert recording.ref is not None
    f = ar.FILTERS["Madgwick"](rate=recording.rate, beta=0.1)
    est = f.run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    expected = ar.metrics.score(est.quat, recording.ref, recording.mask)
    assert float(rows["Madgwick", ""]["total_deg"]) == expected.total
    assert (tmp_path / "errors.png").stat().st_size > 0


@needs_data
def test_run_reads_every_kind_of_real_recording(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("h5py")
    pytest.importorskip("pyarrow")
    for folder, ending in (("broad", "hdf5"), ("repoimu", "csv"), ("fusion", "csv"), ("vqf", "npz")):
        path = min((Path(DATA) / folder).glob(f"*.{ending}"))
        output_of(capsys, "run", path, "--filter", "mahony", "-o", tmp_path / f"{folder}.npz")
        assert np.isfinite(quat_of(tmp_path / f"{folder}.npz")).all()


def turned_stick(path: Path) -> Path:
    """A recording whose reference stands in other frames."""
    recording = ar.simulate.demo(30.0, 50.0)
    assert recording.ref is not None
    earth, sensor = quats(random_turns(2, 3))
    turned = dataclasses.replace(recording, ref=multiply(multiply(earth, recording.ref), sensor))
    return write_repoimu(path, repoimu_rows(turned))


def test_align_takes_the_frames_of_the_reference_out_of_the_errors(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("pyarrow")
    file = turned_stick(tmp_path / "stick.csv")
    argv = (file, "--filters", "vqf,tilt")
    assert float(compare_rows(capsys, tmp_path, *argv)["VQF", ""]["total_deg"]) > 30.0
    row = compare_rows(capsys, tmp_path, *argv, "--align", "--plot", tmp_path / "errors.png")["VQF", ""]
    assert (tmp_path / "errors.png").stat().st_size > 0
    with pytest.warns(ar.DataWarning, match="held truth"):
        recording = ar.read(file)
    est = ar.VQF(rate=recording.rate).run(recording.gyr, recording.acc, recording.mag, t=recording.t)
    assert recording.ref is not None
    found = ar.metrics.align(est.quat, recording.ref, recording.mask, t=recording.t)
    score = ar.metrics.score(*found.pair(est.quat, recording.ref), recording.mask)
    assert float(row["total_deg"]) == score.total
    assert float(row["heading_deg"]) == score.heading
    assert float(row["inclination_deg"]) == score.inclination
    shown = output_of(capsys, "compare", *argv, "--align")
    assert "(one file, aligned)" in shown
    assert "is not the earth frame" not in shown
    shown = output_of(capsys, "run", file, "--filter", "vqf", "--align")
    assert f"total {score.total:.2f}°" in shown
    assert "in ENU, aligned)" in shown


def test_only_the_parts_that_were_asked_for_are_aligned(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("pyarrow")
    file = turned_stick(tmp_path / "stick.csv")
    rows = [
        float(compare_rows(capsys, tmp_path, file, "--filters", "vqf", *options)["VQF", ""]["total_deg"])
        for options in (("--align",), ("--align-parts", "earth,sensor"), ("--align-parts", "Heading, time"))
    ]
    assert rows[0] <= rows[1] * (1 + 1e-9)
    assert rows[2] > 10 * rows[1]
    for parts in ("", "sensor,north", "earth,heading"):
        shown = error_of(capsys, "compare", file, "--align-parts", parts)
        assert shown == f"--align-parts: expected some of earth or heading, sensor, time, got {parts!r}"


def test_what_cannot_be_aligned_is_said(tmp_path: Path, capsys: Capture) -> None:
    still = ar.simulate.scenario("static", duration=20.0)
    assert still.ref is not None
    still.save(tmp_path / "still.npz")
    shown = output_of(capsys, "compare", tmp_path / "still.npz", "--filters", "vqf", "--align")
    assert "note: aligned without an offset of the clocks, which was not found: still.npz" in shown
    assert "note: the motion does not determine the rotation of the sensor frame" in shown
