"""The command `ahrs-rs check`: what it prints, writes and returns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.cli import main
from check_faults import good, times, with_rows
from commands import Capture, error_of, without


def told(capsys: Capture, *argv: object) -> tuple[int, str]:
    """Exit status and output."""
    status = main(["check", *map(str, argv)])
    captured = capsys.readouterr()
    assert captured.err == ""
    return status, captured.out


@pytest.fixture
def right(tmp_path: Path) -> Path:
    path = tmp_path / "right.npz"
    good().save(path)
    return path


@pytest.fixture
def wrong(tmp_path: Path) -> Path:
    path = tmp_path / "wrong.npz"
    times(good(), "gyr", [1.0, 1.0, -1.0]).save(path)
    return path


def test_the_exit_status_is_that_of_the_gravest_file(capsys: Capture, right: Path, wrong: Path) -> None:
    assert told(capsys, right)[0] == 0
    status, out = told(capsys, right, wrong)
    assert status == 1
    assert out.count("recording ") == 2
    assert "error    axes.gyr" in out
    assert main(["check", "/nowhere.csv"]) == 2


def test_strict_counts_warnings(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "warned.npz"
    level = 0.7 * float(np.abs(good().gyr).max())
    with_rows(good(), gyr=np.clip(good().gyr, -level, level)).save(path)
    assert told(capsys, path)[0] == 0
    assert told(capsys, path, "--strict")[0] == 1


def test_fix_writes_the_recording_with_what_is_sure_put_right(capsys: Capture, tmp_path: Path, wrong: Path) -> None:
    for ending in ("npz", "csv", "parquet"):
        out = tmp_path / f"fixed.{ending}"
        status, text = told(capsys, wrong, "--fix", out)
        assert status == 1
        assert "fixed      gyr: axes x, y, -z" in text
        fixed = ar.read(out)
        assert fixed.gyr[:, 2] == pytest.approx(good().gyr[:, 2])
    assert ar.read(tmp_path / "fixed.npz").meta["fixed"] == ["gyr: axes x, y, -z"]
    _, text = told(capsys, wrong, "--fix", tmp_path / "notes.npz", "--fix-notes")
    assert "fixed      gyr: bias (" in text


def test_json_and_page_hold_every_finding(capsys: Capture, tmp_path: Path, wrong: Path) -> None:
    pytest.importorskip("plotly")
    found, page = tmp_path / "found.json", tmp_path / "page.html"
    assert told(capsys, wrong, "--json", found, "--html", page, "--brief")[0] == 1
    read = json.loads(found.read_text(encoding="utf-8"))
    text = page.read_text(encoding="utf-8")
    assert read["severity"] == "error"
    for one in read["findings"]:
        assert f"<td>{one['code']}</td>" in text
    plots = json.loads(text.partition('id="figures">')[2].partition("</script>")[0])
    assert len(plots) == text.count('class="plot"') == 5


def test_readings_that_are_refused_elsewhere_are_checked(capsys: Capture, tmp_path: Path) -> None:
    path = tmp_path / "g.csv"
    table = np.column_stack([good().t, good().gyr, good().acc / 9.80665])
    header = "t,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z"
    np.savetxt(path, table, delimiter=",", header=header, comments="")
    with pytest.raises(ValueError, match="looks like g"):
        ar.read(path)
    status, out = told(capsys, path, "--brief")
    assert status == 1
    assert "error    acc.unit" in out
    assert main(["run", str(path), "--filter", "vqf"]) == 2


@pytest.mark.parametrize("unit", ["ms", "us", "ns"])
def test_times_in_other_units_are_checked(capsys: Capture, tmp_path: Path, unit: str) -> None:
    path = tmp_path / "t.csv"
    size = {"ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
    table = np.column_stack([np.round(good().t * size), good().gyr, good().acc])
    np.savetxt(path, table, delimiter=",", header="t,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z", comments="", fmt="%.9g")
    assert told(capsys, path)[0] in (0, 1)  # 1 where the reader does not see it by itself


@pytest.mark.parametrize(
    "command",
    [
        ["run", "FILE", "--filter", "vqf"],
        ["compare", "FILE", "--filters", "vqf"],
        ["calibrate", "mag", "FILE"],
        ["tune", "FILE", "--filter", "vqf", "--param", "tau_acc=2,3"],
    ],
    ids=lambda command: command[0],
)
def test_other_commands_point_to_the_check_where_an_error_is_sure(
    capsys: Capture, command: list[str], right: Path, wrong: Path
) -> None:
    for path, expected in ((right, False), (wrong, True)):
        words = [str(path) if word == "FILE" else word for word in command]
        assert main(words) == 0
        assert ("see `ahrs-rs check`" in capsys.readouterr().out) is expected


def test_wrong_options_are_errors_of_one_line(capsys: Capture, tmp_path: Path, right: Path) -> None:
    assert "expected one recording" in error_of(capsys, "check", right, right, "--fix", tmp_path / "a.npz")
    assert "expected --fix" in error_of(capsys, "check", right, "--fix-notes")
    assert "ends in .npz" in error_of(capsys, "check", right, "--fix", tmp_path / "a.txt")
    assert "up: expected one of x, y, z" in error_of(capsys, "check", right, "--up", "north")
    assert "expected LAT,LON,ALT" in error_of(capsys, "check", right, "--place", "Berlin")
    assert "is the recording itself" in error_of(capsys, "check", right, "--fix", right)


def test_the_page_without_plotly_says_what_to_install(
    capsys: Capture, tmp_path: Path, right: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "plotly")
    main(["check", str(right), "--html", str(tmp_path / "a.html")])
    assert "pip install ahrs-rs[papers]" in capsys.readouterr().err
    assert not (tmp_path / "a.html").exists()
