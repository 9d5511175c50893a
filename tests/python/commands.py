"""What the tests of the command line share: recordings on disk, and calls with what they print."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.cli import main

DATA = os.environ.get("AHRS_RS_DATA", "")
needs_data = pytest.mark.skipif(not DATA, reason="AHRS_RS_DATA is not set")

Capture = pytest.CaptureFixture[str]
EVERY_FILTER = pytest.mark.parametrize("cls", ar.FILTERS.values(), ids=ar.FILTERS)
HAS_PRESET = [(cls, preset) for cls in ar.FILTERS.values() for preset in cls.PRESETS]


def simulated(seed: int = 0) -> ar.Recording:
    """Some seconds of motion with truth; one row of the magnetometer in three is there."""
    recording = ar.simulate.demo(duration=6.0, rate=50.0, seed=seed)
    assert recording.mag is not None
    mag = recording.mag.copy()
    mag[np.arange(len(mag)) % 3 != 0] = np.nan
    return dataclasses.replace(recording, mag=mag)


def saved(path: Path, seed: int = 0, **changes: Any) -> Path:
    dataclasses.replace(simulated(seed), **changes).save(path)
    return path


def output_of(capsys: Capture, *argv: object) -> str:
    """What a command that succeeds prints."""
    status = main([str(one) for one in argv])
    captured = capsys.readouterr()
    assert captured.err == ""
    assert status == 0
    return captured.out


def error_of(capsys: Capture, *argv: object) -> str:
    """The one line that a command which fails prints, without its beginning."""
    status = main([str(one) for one in argv])
    captured = capsys.readouterr()
    assert status == 2
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("ahrs-rs: error: ")
    return captured.err.removeprefix("ahrs-rs: error: ").rstrip("\n")


def python(*args: object, **keywords: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *map(str, args)]
    return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False, **keywords)


def quat_of(path: Path) -> np.ndarray:
    with np.load(path) as arrays:
        quat: np.ndarray = arrays["quat"]
    return quat


def without(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """As if the package were not installed."""
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
