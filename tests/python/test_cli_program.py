"""Laws of the program as a whole."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import ahrs_rs as ar
from ahrs_rs.papers import Plot, Study, Table, _report
from commands import Capture, output_of, python, saved


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return saved(tmp_path / "walk.npz")


def test_version_and_help_succeed(capsys: Capture) -> None:
    version = output_of(capsys, "--version")
    assert re.fullmatch(rf"ahrs-rs {re.escape(ar.__version__)} \([a-z0-9]+\)\n", version)
    assert "compare" in output_of(capsys, "--help")
    for command in ("run", "compare", "filters", "simulate", "demo"):
        assert output_of(capsys, command, "--help").startswith(f"usage: ahrs-rs {command} ")


def test_module_is_run_as_the_program(tmp_path: Path) -> None:
    done = python("-m", "ahrs_rs", "demo", "-o", tmp_path, "--duration", "2", "--rate", "50")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "orientation.csv").exists()
    done = python("-m", "ahrs_rs", "run", tmp_path / "missing.npz", "--filter", "tilt")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr


def test_output_is_shown_in_an_encoding_without_its_characters() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = python("-m", "ahrs_rs", "filters", "GyroIntegration", env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii()


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX pipes")
def test_closed_pipe_ends_the_program_quietly() -> None:
    read_end, write_end = os.pipe()
    os.close(read_end)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "ahrs_rs", "filters"], stdout=write_end, stderr=subprocess.PIPE, check=False
        )
    finally:
        os.close(write_end)
    assert (done.returncode, done.stderr) == (141, b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_full_disk_behind_the_standard_output_is_told_once() -> None:
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "ahrs_rs", "filters"], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert (done.returncode, done.stderr) == (2, b"ahrs-rs: error: No space left on device\n")


@pytest.mark.skipif(os.name != "posix", reason="needs a POSIX terminal")
def test_progress_bar_is_shown_on_a_terminal_and_wiped_away(file: Path) -> None:
    import fcntl
    import struct
    import termios

    master, terminal = os.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    try:
        done = subprocess.run(
            [sys.executable, "-m", "ahrs_rs", "compare", str(file)],
            stdout=subprocess.PIPE,
            stderr=terminal,
            check=False,
        )
    finally:
        os.close(terminal)
    shown = os.read(master, 65536)
    os.close(master)
    assert done.returncode == 0
    assert f"0/{len(ar.FILTERS)}".encode() in shown
    assert shown.rstrip(b" \r").endswith(b"run/s]")
    assert b"\r" + b" " * 70 in shown


def test_importing_the_package_imports_nothing_heavy_and_no_command_line() -> None:
    heavy = ["matplotlib", "pandas", "polars", "scipy", "h5py", "pyarrow", "tqdm", "ahrs_rs.cli", "ahrs_rs.plots"]
    code = f"import sys, ahrs_rs; print([name for name in {heavy} if name in sys.modules])"
    done = python("-c", code)
    assert (done.stdout, done.stderr) == ("[]\n", "")


def test_listing_filters_imports_nothing_heavy() -> None:
    heavy = ["matplotlib", "pandas", "polars", "scipy", "h5py", "pyarrow", "tqdm"]
    code = (
        "import sys; from ahrs_rs.cli import main; main(['filters', '--json']);"
        f"print([name for name in {heavy} if name in sys.modules], file=sys.stderr)"
    )
    assert python("-c", code).stderr == "[]\n"


#: Names of files as somebody may give them: a formula, a tag, letters that fonts lack, a line end and a sequence that
#: moves a terminal's cursor, bytes that are no UTF-8.
NAMES = [
    "a$b$c_{x.npz",
    "$x.npz",
    "<script>&amp;.npz",
    "\u6e2c\u8a66.npz",
    "a\nb\x1b[31m.npz",
    os.fsdecode(b"w\xff.npz"),
]


@pytest.mark.skipif(os.name != "posix", reason="other systems have no such names")
@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_any_name_of_a_file_is_shown_drawn_and_written(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    saved(tmp_path / "plain.npz").rename(tmp_path / name)
    commands = [
        ("compare", name, "--filters", "tilt", "--plot", "errors.png", "--csv", "table.csv", "--per-file"),
        ("run", name, "--filter", "tilt", "-o", "out.csv"),
        ("tune", name, "--filter", "madgwick", "--param", "beta=0.1,0.2", "-o", "tuned.json"),
        ("run", name, "--filter", "tilt", "-o", name),
    ]
    for command in commands:
        done = python("-m", "ahrs_rs", *command)
        assert done.returncode == (2 if command[-1] == name else 0), done.stderr
        assert not done.stderr or done.returncode == 2
        assert done.stderr.count("\n") <= 1
        shown = done.stdout + done.stderr
        assert all(letter.isprintable() for letter in shown.replace("\n", ""))
    assert {"errors.png", "table.csv", "out.csv", "tuned.json"} <= {path.name for path in tmp_path.iterdir()}
    assert len((tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()) == 3


def test_what_a_report_shows_ends_no_element_of_its_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hostile = "</script><!--<script>$x$"
    study = Study("x", hostile, hostile, tables=[Table(hostile, [hostile], [[hostile]], note=hostile)], claims=[],
                  plots=[Plot(hostile, [{"name": hostile}], {})])  # fmt: skip
    monkeypatch.setattr(_report, "require_plotly", lambda: SimpleNamespace(get_plotlyjs=lambda: ""))
    _report.write_report([study], tmp_path, 0, [hostile])
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert hostile not in page
    assert page.count("<script") == page.count("</script>") == _report.PAGE.count("<script")
    begin = page.index('id="figures">') + len('id="figures">')
    assert json.loads(page[begin : page.index("</script>", begin)])[0]["title"] == hostile
