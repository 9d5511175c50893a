"""Trajectories as text of the TUM benchmark: a line of ``t x y z qx qy qz qw`` for each pose."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _atomic
from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

_LINE = re.compile(rb"\s*[-+.\deE]+(?:[ \t]+[-+.\deE]+){7}\s*")


def write_tum(path: Path, t: NDArray[Any], quat: NDArray[Any]) -> None:
    """Write orientations as a trajectory whose positions are zero, scalar-last as the format has it."""
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    for stamp, (w, x, y, z) in zip(t.tolist(), quat.tolist(), strict=True):
        lines.append(f"{stamp!r} 0 0 0 {x!r} {y!r} {z!r} {w!r}")
    _atomic.write_text(path, "\n".join(lines) + "\n")


def sniff(source: Source) -> bool:
    """Whether the lines have eight numbers, the last four of which are a unit quaternion."""
    lines = [line for line in source.head.splitlines()[:-1] if line.strip() and not line.lstrip().startswith(b"#")]
    if not lines or not all(_LINE.fullmatch(line) for line in lines):
        return False
    try:
        rows = np.array([line.split() for line in lines], dtype=np.float64)
    except ValueError:
        return False
    return bool((np.abs(np.linalg.norm(rows[:, 4:], axis=1) - 1.0) < 0.01).all())


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a trajectory: its orientations are a truth."""
    rows: FloatArray
    try:
        lines = [
            line.split() for line in source.read().splitlines() if line.strip() and not line.lstrip().startswith(b"#")
        ]
        rows = np.array(lines, dtype=np.float64).reshape(len(lines), 8)
    except ValueError as error:
        raise ValueError(f"is not a TUM trajectory: {error}") from error
    times, origin = seconds({"t": rows[:, 0]}, 1.0)
    meta = {"start": utc(origin)} if origin and utc(origin) else {}
    streams = {"ref": (times["t"], rows[:, [7, 4, 5, 6]])}
    if rows[:, 1:4].any():
        streams["position"] = (times["t"], rows[:, 1:4])
    return {"trajectory": SensorData(streams, meta={**meta, "units": {"t": "s"}, "ref_frame": "of the trajectory"})}
