"""What `make attack` ends: every command that writes, what it reads, and what its files may be after."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import ahrs_rs as ar
from ahrs_rs.calibration import Calibration

PROGRAM = [sys.executable, "-m", "ahrs_rs"]

#: What stands in an output before the command is run.
OLD = b"what was there before\n"


@dataclass(frozen=True)
class Command:
    """A command with its outputs, in a folder of its own."""

    name: str
    argv: tuple[str, ...]
    outputs: tuple[str, ...]
    """The files that it writes, from the folder."""
    before: Mapping[str, bytes] = field(default_factory=dict)
    """What stands in an output before, where `OLD` would be refused."""
    journal: str | None = None
    """A checkpoint, which grows and is not replaced."""

    def prepare(self, folder: Path) -> None:
        """The folder as it is before the command."""
        for file in folder.rglob("*.part*"):
            file.unlink()
        for name in self.outputs:
            path = folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(self.before.get(name, OLD))

    def start(self, folder: Path) -> subprocess.Popen[bytes]:
        """The process in the folder."""
        return subprocess.Popen(
            [*PROGRAM, *self.argv], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )

    def run(self, folder: Path) -> tuple[float, dict[str, bytes]]:
        """The time of an undisturbed run in s, and what it writes."""
        self.prepare(folder)
        begin = time.monotonic()
        done = subprocess.run([*PROGRAM, *self.argv], cwd=folder, capture_output=True, text=True, check=False)
        seconds = time.monotonic() - begin
        if done.returncode:
            raise RuntimeError(f"{self.name}: {done.stderr}")
        return seconds, {name: (folder / name).read_bytes() for name in self.outputs}

    def wrong(self, folder: Path, new: Mapping[str, bytes]) -> list[str]:
        """The outputs that are neither as before nor whole."""
        found = []
        for name in self.outputs:
            content = (folder / name).read_bytes() if (folder / name).exists() else b""
            if content != self.before.get(name, OLD) and not whole(name, content, new[name]):
                found.append(name)
        return found


def whole(name: str, content: bytes, expected: bytes) -> bool:
    """Whether it is what the command writes; times of this machine may differ."""
    if content == expected:
        return True
    if name.endswith(".html"):
        return content.startswith(b"<!DOCTYPE html>") and content.endswith(b"</html>\n")
    if name.endswith(".csv"):  # a table with times in it
        lines, wanted = content.splitlines(), expected.splitlines()
        same = len(lines) == len(wanted) and lines[0] == wanted[0]
        return same and content.endswith(b"\n") and [x.count(b",") for x in lines] == [x.count(b",") for x in wanted]
    return False


def recordings(folder: Path, minutes: float) -> None:
    """The files that the commands read: a walk, a sensor at rest, one that is turned in all directions."""
    folder.mkdir(parents=True, exist_ok=True)
    walk = ar.simulate.demo(60.0 * minutes, 200.0, 1)
    walk.save(folder / "walk.npz")
    rng = np.random.default_rng(0)
    count = int(12_000 * minutes)
    t = np.arange(count) / 200.0
    still = ar.Recording(
        t=t,
        gyr=rng.normal(0.0, 0.002, (count, 3)),
        acc=np.array([0.0, 0.0, 9.80665]) + rng.normal(0.0, 0.02, (count, 3)),
        mag=np.array([0.0, 20.0, -45.0]) + rng.normal(0.0, 0.3, (count, 3)),
    )
    still.save(folder / "still.npz")
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    mag = 50.0 * directions + [10.0, -20.0, 5.0] + rng.normal(0.0, 0.2, (count, 3))
    ar.Recording(t=t, gyr=np.zeros((count, 3)), mag=mag).save(folder / "turned.npz")
    short = walk[:12_000]
    columns = [short.t, *short.gyr.T, *short.acc.T]  # type: ignore[union-attr]
    header = "time (s),gyr_x (rad/s),gyr_y (rad/s),gyr_z (rad/s),acc_x (m/s2),acc_y (m/s2),acc_z (m/s2)"
    np.savetxt(folder / "walk.csv", np.column_stack(columns), delimiter=",", header=header, comments="")


def calibration_of_others() -> bytes:
    """A cal.json with another sensor in it, which must not be lost."""
    path = Path(os.environ.get("TMPDIR", "/tmp")) / f"ahrs-rs-attack-{os.getpid()}.json"
    try:
        Calibration(np.diag([1.01, 0.99, 1.0]), [0.1, 0.2, 0.3]).save(path, "acc")
        return path.read_bytes()
    finally:
        path.unlink(missing_ok=True)


def commands(data: Path) -> list[Command]:
    """Every command that writes."""
    walk, still, turned, table = (str(data / name) for name in ("walk.npz", "still.npz", "turned.npz", "walk.csv"))
    tune = ("tune", walk, "--filter", "madgwick", "--param", "beta=0.001:10", "--points", "400")
    return [
        Command("run (csv)", ("run", walk, "--filter", "vqf", "-o", "out.csv"), ("out.csv",)),
        Command("run (parquet)", ("run", table, "--filter", "vqf", "-o", "out.parquet"), ("out.parquet",)),
        Command("run (npz)", ("run", walk, "--filter", "SelfCalSmoother", "-o", "out.npz"), ("out.npz",)),
        Command("simulate", ("simulate", "--scenario", "walking", "--duration", "300", "-o", "sim.npz"), ("sim.npz",)),
        Command(
            "calibrate",
            ("calibrate", "mag", turned, "-o", "cal.json", "--rust", "cal.rs", "--c-header", "cal.h", "--plot"),
            ("cal.json", "cal.rs", "cal.h", "cal.png"),
            {"cal.json": calibration_of_others()},
        ),
        Command("noise", ("noise", still, "-o", "noise.json", "--plot", "noise.png"), ("noise.json", "noise.png")),
        Command(
            "compare",
            ("compare", walk, "--filters", "vqf,mekf,madgwick", "--csv", "table.csv", "--plot", "errors.png"),
            ("table.csv", "errors.png"),
        ),
        Command("demo", ("demo", "-o", "demo"), ("demo/recording.npz", "demo/orientation.csv", "demo/errors.png")),
        Command(
            "tune", (*tune, "--checkpoint", "part.jsonl", "-o", "tuned.json"), ("tuned.json",), journal="part.jsonl"
        ),
        Command(
            "papers",
            ("papers", "cocoli2023", "--out", "report"),
            ("report/report.html", *(f"report/{name}.csv" for name in PAPER_TABLES)),
        ),
    ]


PAPER_TABLES = ("claims", *(f"cocoli2023_{number}" for number in range(1, 5)))


def fresh(folder: Path) -> Path:
    """An empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def lines_of(path: Path) -> int:
    """How many whole lines a journal has."""
    return path.read_bytes().count(b"\n") if path.exists() else 0


def is_json(line: bytes) -> bool:
    """Whether a line of a journal is whole."""
    try:
        json.loads(line)
    except ValueError:
        return False
    return True
