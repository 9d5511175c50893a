"""RepoIMU: CSV with ';' and two header lines, Vicon truth (Szczęsna et al., ICCVG 2016).

The files differ: "Time (s)" above an empty cell or "Time" above "s", separators at the end of the header
lines or not, LF or CRLF, three-digit exponents. Groups are found by their names in the first header line.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._preamble import Layout, cells, head_lines, table_width
from ahrs_rs.io._source import Source
from ahrs_rs.io._text import read_columns

SEPARATOR = ";"

#: Stream -> name of the group in the first header line, labels of its columns in the second.
GROUPS = {
    "t": ("time", ("",)),
    "ref": ("vicon orientation", ("w", "x", "y", "z")),
    "acc": ("imu acceleration", ("x", "y", "z")),
    "gyr": ("imu gyroscope", ("x", "y", "z")),
    "mag": ("imu magnetometer", ("x", "y", "z")),
}

#: So many rows or more with exactly the same truth (0.2 s): the motion capture had lost the markers and held
#: its value. A tracked sensor at rest does not repeat five digits of four noisy components so often.
HELD_ROWS = 20


def sniff(source: Source) -> bool:
    """Whether the first line names the groups of RepoIMU."""
    head = source.head
    first = head.splitlines()[0].lower() if head else b""
    return b"vicon orientation;" in first and b"imu gyroscope;" in first


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a RepoIMU recording; where the truth is held in some rows, `mask` leaves them out."""
    lines = head_lines(source)
    if len(lines) < 3 or not lines[2]:
        raise ValueError("has a header, but no rows")
    header, labels, first_row = (cells(line, SEPARATOR) for line in lines[:3])
    labels += [""] * (len(header) - len(labels))
    indices = {field: _group(header, labels, *group) for field, group in GROUPS.items()}
    names = {i: f"{header[group[0]]} {labels[i]}".strip() for group in indices.values() for i in group}
    width = table_width(labels, first_row)
    columns, repairs = read_columns(source, Layout(SEPARATOR, ".", start=2, width=width), names)
    arrays: dict[str, Any] = {
        field: np.column_stack([columns[i] for i in group]) if len(group) > 1 else columns[group[0]]
        for field, group in indices.items()
    }
    held = _held(arrays["ref"])
    if held.any():
        arrays["mask"] = ~held
        repairs.append(f"mask: {int(held.sum())} rows with a held truth do not count")
    units = {"t": "s", "gyr": "rad/s", "acc": "m/s²", "mag": "normalised"}
    meta = {"units": units, "ref_frame": "Vicon, not aligned with sensor and north", "repairs": repairs}
    t = arrays.pop("t")
    return {"imu": SensorData({name: (t, values) for name, values in arrays.items()}, meta=meta)}


def _group(header: list[str], labels: list[str], group: str, expected: tuple[str, ...]) -> list[int]:
    names = [name.lower().partition("(")[0].strip() for name in header]
    if group not in names:
        found_names = [name for name in names if name]
        raise ValueError(f"is not a RepoIMU recording: no column group {group!r} among {found_names}")
    start = names.index(group)
    found = tuple(label.lower() for label in labels[start : start + len(expected)])
    if len(expected) > 1 and found != expected:
        raise ValueError(f"is not a RepoIMU recording: expected {expected} below {group!r}, got {found}")
    return list(range(start, start + len(expected)))


def _held(ref: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Rows in runs of at least `HELD_ROWS` equal quaternions, all but the first row of each run."""
    equal = np.concatenate(([False], (ref[1:] == ref[:-1]).all(axis=1), [False]))
    edges = np.flatnonzero(np.diff(equal.astype(np.int8)))
    held = np.zeros(len(ref), dtype=np.bool_)
    for start, stop in zip(edges[::2] + 1, edges[1::2] + 1, strict=True):
        if stop - start >= HELD_ROWS - 1:
            held[start:stop] = True
    return held
