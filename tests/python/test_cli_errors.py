"""Mistakes are told in one line, and nothing is written."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ahrs_rs.cli import _compare as compare_module
from ahrs_rs.cli import main
from commands import Capture, error_of, saved, without


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return saved(tmp_path / "walk.npz")


#: Arguments, where words in capitals stand for paths, and what the error must say.
MISTAKES = """
 => expected a command: run, check, compare, view, tune, filters, sensors, formats, calibrate, noise, simulate
sail => invalid choice: 'sail'
run => the following arguments are required: FILE, --filter
run FILE => the following arguments are required: --filter
run FILE --filter tilt --colour => unrecognized arguments: --colour
run FILE --filter madgwik => unknown filter 'madgwik' (did you mean Madgwick?); there are
run FILE --filter xyz => unknown filter 'xyz'; there are GyroIntegration
filters tilted => unknown filter 'tilted' (did you mean Tilt?)
run FILE --filter madgwick --set beta => --set: expected NAME=VALUE, got 'beta'
run FILE --filter madgwick --set bet=1 => no parameter 'bet' (did you mean beta?)
run FILE --filter tilt --set beta=1 => Tilt has no parameter 'beta'; there are none
run FILE --filter madgwick --set beta=x => Madgwick.beta: expected a number, got 'x'
run FILE --filter madgwick --set beta=nan => beta: expected a number in [0, 1e+06] rad/s
run FILE --filter madgwick --set beta=-1 => beta: expected a number in [0, 1e+06] rad/s
run FILE --filter madgwick --set gradient=x => gradient: expected one of 'tangent'
run FILE --filter mahony --preset parikh => (did you mean parikh2021?); it has
run FILE --filter tilt --preset parikh2021 => it has none
run FILE --filter tilt --rate 0 => --rate: expected a positive number, got '0'
run FILE --filter tilt --rate inf => --rate: expected a number, got 'inf'
run FILE --filter tilt --declination N => --declination: expected a number, got 'N'
run FILE --filter tilt --frame up => --frame: invalid choice: 'UP'
run FILE --filter tilt --format csv => walk.npz:
run MISSING --filter tilt => missing.csv: no such file
run MISSING --filter tilt --rate 9 => missing.csv: no such file
run FOLDER --filter tilt => expected a file, got a directory
run NOISE --filter tilt => noise.bin: is of no known format
run NOISE --filter tilt --rate 9 => noise.bin: is of no known format
run FILE --filter tilt -o out.xlsx => -o: expected a name that ends in .csv, .parquet
run FILE --filter tilt -o nowhere/out.csv => there is no directory nowhere
run FILE --filter tilt -o FILE => is the recording itself
run FILE --filter tilt -o folder.csv => -o: folder.csv is a directory
compare => the following arguments are required: FILE
compare MISSING => missing.csv: no such file
compare FILE NOISE => noise.bin: is of no known format
compare FILE --filters , => --filters: expected all, or names
compare FILE --filters tilt,tild => unknown filter 'tild' (did you mean Tilt?)
compare FILE --preset x => none of these filters has the preset 'x'; there are cirillo2014
compare FILE --set betta=1 => these filters have no parameter 'betta' (did you mean beta?)
compare FILE --set madgwick.bet=1 => Madgwick has no parameter 'bet' (did you mean beta?)
compare FILE --set magwick.beta=1 => unknown filter 'magwick' (did you mean Madgwick?)
compare FILE --filters tilt --set madgwick.beta=1 => is not among the compared
compare FILE --csv nowhere/t.csv => --csv: nowhere/t.csv: there is no directory nowhere
compare FILE --plot nowhere/t.png => --plot: nowhere/t.png: there is no directory nowhere
compare FILE --plot errors.doc => --plot: expected a name that ends in
compare FILE --plot a.png --csv ./a.png => --csv and --plot: expected two files
noise FILE -o FILE.json --plot nowhere/a.png => --plot: nowhere/a.png: there is no directory nowhere
calibrate mag FILE --rust a.h --c-header ./a.h => --rust and --c-header: expected two files, got a.h twice
calibrate mag FILE --rust a.png --plot a.png => --rust and --plot: expected two files, got a.png twice
calibrate mag FILE -o cal.json --c-header cal.json => -o and --c-header: expected two files, got cal.json twice
calibrate mag FILE -o cal.json --rust cal.png --plot => --rust and --plot: expected two files, got cal.png twice
tune FILE --filter madgwick -o a.json --checkpoint folder.csv/../a.json => -o and --checkpoint: expected two files
demo -o nowhere/demo => -o: nowhere/demo: there is no directory nowhere
demo -o FILE => is not a directory
demo --seed -1 => seed: expected an integer that is not negative, got -1
demo --duration 0.01 => duration: expected at least two samples
demo --duration 1e300 => --duration: 1e+300 s at 100 Hz are over 10,000,000 samples
"""


@pytest.mark.parametrize("mistake", MISTAKES.strip().splitlines())
def test_mistakes_are_told_in_one_line_and_nothing_is_written(
    mistake: str, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    argv, _, message = mistake.partition("=> ")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "noise.bin").write_bytes(bytes(range(256)))
    places = {"FILE": "walk.npz", "FOLDER": ".", "MISSING": "missing.csv", "NOISE": "noise.bin"}
    before = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert message in error_of(capsys, *(places.get(one, one) for one in argv.split()))
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


def test_outputs_are_checked_before_the_recording_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    for argv in (
        ("run", "missing.csv", "--filter", "tilt", "-o", "nowhere/out.csv"),
        ("compare", "missing.csv", "--csv", "nowhere/out.csv"),
        ("compare", "missing.csv", "--plot", "nowhere/out.png"),
    ):
        assert "there is no directory nowhere" in error_of(capsys, *argv)


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write anywhere")
def test_output_without_permission_is_refused(file: Path, tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "locked").mkdir(mode=0o500)
    out = tmp_path / "locked" / "out.csv"
    assert "permission denied" in error_of(capsys, "run", file, "--filter", "tilt", "-o", out)


@pytest.mark.parametrize(
    ("package", "argv", "extra"),
    [
        ("matplotlib", ["compare", "FILE", "--plot", "errors.png"], "ahrs-rs[plot]"),
        ("pyarrow", ["run", "FILE", "--filter", "tilt", "-o", "out.parquet"], "ahrs-rs[io]"),
        ("pyarrow", ["run", "table.csv", "--filter", "tilt"], "ahrs-rs[io]"),
    ],
    ids=["plot", "parquet output", "csv input"],
)
def test_missing_packages_are_named_with_how_to_install_them(
    package: str,
    argv: list[str],
    extra: str,
    file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
) -> None:
    monkeypatch.chdir(file.parent)
    Path("table.csv").write_text("t,gx,gy,gz\n0,0,0,0\n1,0,0,0\n")
    without(monkeypatch, package)
    message = error_of(capsys, *("walk.npz" if one == "FILE" else one for one in argv))
    assert f"needs {package}" in message or f"need {package}" in message
    assert message.endswith(f"pip install {extra}")
    assert not Path("out.parquet").exists()


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (OSError(28, "No space left on device", "out.csv"), "out.csv: No space left on device"),
        (OSError("something\nelse"), "something else"),
        (MemoryError(), "MemoryError"),
    ],
)
def test_errors_of_the_system_are_told_in_one_line(
    error: Exception, message: str, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr(compare_module, "choose_all", raising(error))
    assert error_of(capsys, "compare", "walk.npz") == message


def test_interrupt_ends_with_one_line_and_status_130(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr(compare_module, "choose_all", raising(KeyboardInterrupt()))
    assert main(["compare", "walk.npz"]) == 130
    assert capsys.readouterr().err == "ahrs-rs: error: interrupted\n"


def raising(error: BaseException) -> Callable[..., Any]:
    def function(*args: object) -> Any:
        raise error

    return function


def test_mistakes_in_the_program_itself_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare_module, "choose_all", raising(TypeError("a bug")))
    with pytest.raises(TypeError, match="a bug"):
        main(["compare", "walk.npz"])
