"""Speed of reading a CSV file of a million rows beside pandas' C reader, of the import, and of a short run.

Both readers take the same ten columns (time, gyroscope, accelerometer, magnetometer) of a table of thirteen, and take
turns; the ratio is the median of the rounds. The command runs in a process of its own, as a user's does; with
``--base PYTHONPATH`` beside that of another checkout.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

import ahrs_rs as ar

ROWS, SHORT = 1_000_000, 4_000
ROUNDS = 5
HEADER = "t (s),gx (rad/s),gy (rad/s),gz (rad/s),ax (m/s2),ay (m/s2),az (m/s2),mx (uT),my (uT),mz (uT),battery,id,label"


def write(path: Path, rows: int) -> Path:
    """A table of some motion, with columns that nobody reads."""
    rng = np.random.default_rng(0)
    columns = [np.arange(rows) / 100.0, *rng.normal(0.0, 1.0, (3, rows)), *rng.normal(0.0, 0.2, (2, rows))]
    columns += [9.8 + rng.normal(0.0, 0.2, rows), *rng.normal(30.0, 1.0, (3, rows)), np.ones(rows), np.arange(rows)]
    frame = pd.DataFrame(dict(zip(HEADER.split(","), columns, strict=False)))
    frame["label"] = "walk"
    frame.to_csv(path, index=False, float_format="%.8f")
    return path


def elapsed(call: Callable[[], object]) -> float:
    """s of a call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def ours(path: Path) -> object:
    """All rows as a recording, rows made."""
    rec = ar.read(path)
    return rec.gyr, rec.acc, rec.mag


def theirs(path: Path) -> object:
    """The same columns as arrays, by pandas' C reader."""
    frame = pd.read_csv(path, usecols=HEADER.split(",")[:10], engine="c")
    return tuple(frame.iloc[:, k : k + 3].to_numpy() for k in (1, 4, 7)), frame.iloc[:, 0].to_numpy()


def process(code: list[str], path: str | None) -> float:
    """s of a Python process."""
    environment = dict(os.environ) if path is None else {**os.environ, "PYTHONPATH": path}
    return elapsed(lambda: subprocess.run([sys.executable, *code], check=True, env=environment, capture_output=True))


def main() -> int:
    """Print the numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", help="PYTHONPATH of another checkout, for the times of processes")
    args = parser.parse_args()
    warnings.simplefilter("ignore", ar.DataWarning)
    with tempfile.TemporaryDirectory() as folder:
        path = write(Path(folder) / "long.csv", ROWS)
        ours(path), theirs(path)
        times = [(elapsed(lambda: ours(path)), elapsed(lambda: theirs(path))) for _ in range(ROUNDS)]
        mine, other = (statistics.median(column) for column in zip(*times, strict=True))
        ratio = statistics.median(b / a for a, b in times)
        print(f"{ROWS:,} rows: ahrs_rs {mine:.3f} s, pandas {pd.__version__} {other:.3f} s, {ratio:.2f} times as fast")
        short = write(Path(folder) / "short.csv", SHORT)
        for title, code in {
            "import ahrs_rs": ["-c", "import ahrs_rs"],
            f"run of {SHORT:,} rows": ["-m", "ahrs_rs", "run", str(short), "--filter", "vqf"],
        }.items():
            rounds = [
                [process(code, one) for one in ([None] if args.base is None else [None, args.base])]
                for _ in range(2 * ROUNDS)
            ]
            medians = [statistics.median(column) for column in zip(*rounds, strict=True)]
            said = ", ".join(f"{one:.3f} s" for one in medians)
            said += f", {medians[1] / medians[0]:.2f} times as fast" if len(medians) > 1 else ""
            print(f"{title}: {said}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
