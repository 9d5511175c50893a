"""A signal ends a command soon, with one line, and as if nothing had been."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ahrs_rs.cli import _signals, main
from commands import saved

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "ended by SIGTERM", signal.SIGHUP: "ended by SIGHUP"}
EVERY_SIGNAL = pytest.mark.parametrize("number", WORDS, ids=lambda number: number.name)

#: The command with something slow in place of what it does: {slow}, once all is ready for the signal.
PROGRAM = """
import sys, time
from pathlib import Path
import ahrs_rs.cli._run as run
from ahrs_rs import _atomic
from ahrs_rs.cli import main

def slow(args):
    with _atomic.text("out.csv") as file:
        file.write("half")
        file.flush()
        Path("ready").touch()
        {slow}
    return 0

run.run = slow
sys.argv = ["ahrs-rs", "run", "walk.npz", "--filter", "tilt"]
raise SystemExit(main())
"""
#: Python that looks for signals, and a call that does not: a lock of C that nobody opens.
PYTHON = "while True: time.sleep(0.01)"
NATIVE = "import ctypes; ctypes.CDLL(None).sleep(60)"


def ended(slow: str, number: signal.Signals, folder: Path) -> tuple[int, str]:
    """Exit status and standard error of the command after the signal."""
    (folder / "out.csv").write_text("old")
    command = [sys.executable, "-c", PROGRAM.replace("{slow}", slow)]
    with subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        while process.poll() is None and not (folder / "ready").exists():
            time.sleep(0.001)
        process.send_signal(number)
        _, told = process.communicate(timeout=30)
    return process.returncode, told


@pytest.mark.parametrize("slow", [PYTHON, NATIVE], ids=["python", "native"])
@EVERY_SIGNAL
def test_a_signal_ends_the_command_with_one_line_and_leaves_what_was_there(
    slow: str, number: signal.Signals, tmp_path: Path
) -> None:
    assert ended(slow, number, tmp_path) == (128 + number, f"ahrs-rs: error: {WORDS[number]}\n")
    assert (tmp_path / "out.csv").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.csv", "ready"]


def test_what_is_ignored_stays_so(tmp_path: Path) -> None:
    """As under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        status, told = ended(PYTHON.replace("while True", "for _ in range(20)"), signal.SIGHUP, tmp_path)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert "ended by" not in told
    assert status == 0
    assert (tmp_path / "out.csv").read_text() == "half"


def test_a_command_within_another_program_gives_its_handlers_back(tmp_path: Path) -> None:
    file = saved(tmp_path / "walk.npz")
    handlers = [signal.getsignal(number) for number in WORDS]
    assert main(["run", str(file), "--filter", "tilt"]) == 0
    assert [signal.getsignal(number) for number in WORDS] == handlers
    assert signal.set_wakeup_fd(-1) == -1


def test_the_handlers_of_another_program_are_left_alone(tmp_path: Path) -> None:
    came: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: came.append(number))
    try:
        with _signals.interruptible():
            signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert came == [signal.SIGTERM]
