"""Estimates written to a file: CSV, Parquet or .npz by the ending of its name."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _atomic, metrics
from ._contents import require

Arrays = dict[str, NDArray[Any]]

#: Array -> names of its columns in CSV and Parquet.
COLUMNS = {
    "t": ("t",),
    "quat": ("qw", "qx", "qy", "qz"),
    "euler": ("roll", "pitch", "yaw"),
    "gyr_bias": ("bias_x", "bias_y", "bias_z"),
    "status": ("status",),
}


def write_estimate(
    path: str | os.PathLike[str],
    t: ArrayLike,
    quat: ArrayLike,
    gyr_bias: ArrayLike | None = None,
    status: ArrayLike | None = None,
    euler: ArrayLike | None = None,
) -> None:
    """Write the orientations of one recording.

    CSV and Parquet have the columns t [s], qw, qx, qy, qz, roll, pitch, yaw [rad], bias_x, bias_y, bias_z
    [rad/s] and status (a bit mask); .npz has the arrays t, quat, euler, gyr_bias and status. What is not
    given is not written, except Euler angles: they are computed. CSV holds the shortest text that gives the
    same number back.

    Parameters
    ----------
    path : the ending tells the format: .csv, .parquet or .npz.
    t : (T,) s.
    quat : (T, 4)
    gyr_bias : (T, 3) rad/s, or None.
    status : (T,) integers, or None.
    euler : (T, 3) rad, or None: computed from `quat`.

    Raises
    ------
    ValueError
        Another ending, or a wrong shape.
    OSError
        What was there is then as it was.
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise ValueError(f"path: expected a name that ends in {', '.join(WRITERS)}, got {path.name!r}")
    given = {"t": t, "quat": quat, "euler": euler, "gyr_bias": gyr_bias, "status": status}
    arrays = {name: np.asarray(value) for name, value in given.items() if value is not None}
    if arrays["quat"].ndim != 2:
        raise ValueError(f"quat: expected shape (T, 4), got {arrays['quat'].shape}")
    length = len(arrays["quat"])
    for name, array in arrays.items():
        columns = len(COLUMNS[name])
        expected = (length,) if columns == 1 else (length, columns)
        if array.shape != expected:
            raise ValueError(f"{name}: expected shape {expected}, got {array.shape}")
    if euler is None:
        arrays["euler"] = metrics.euler(arrays["quat"])
    writer(path, {name: arrays[name] for name in COLUMNS if name in arrays})


def _columns(arrays: Arrays) -> Arrays:
    return {
        column: array if array.ndim == 1 else array[:, i]
        for name, array in arrays.items()
        for i, column in enumerate(COLUMNS[name])
    }


def _write_csv(path: Path, arrays: Arrays) -> None:
    columns = _columns(arrays)
    with _atomic.text(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


def _write_parquet(path: Path, arrays: Arrays) -> None:
    pa, parquet = require("pyarrow"), require("pyarrow.parquet")
    columns = {name: np.ascontiguousarray(column) for name, column in _columns(arrays).items()}
    with _atomic.replacing(path) as beside:
        parquet.write_table(pa.table(columns), beside)


def _write_npz(path: Path, arrays: Arrays) -> None:
    contents: dict[str, Any] = dict(arrays)
    with _atomic.binary(path) as file:
        np.savez_compressed(file, **contents)


WRITERS: dict[str, Callable[[Path, Arrays], None]] = {
    ".csv": _write_csv,
    ".parquet": _write_parquet,
    ".npz": _write_npz,
}
