"""Laws of the program as a whole."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import ahrs_rs as ar
from commands import Capture, output_of, python, saved


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return saved(tmp_path / "walk.npz")


def test_version_and_help_succeed(capsys: Capture) -> None:
    assert output_of(capsys, "--version") == f"ahrs-rs {ar.__version__}\n"
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
