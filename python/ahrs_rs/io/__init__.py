"""Reading recordings, writing estimates.

A new format is one module with `sniff(first bytes)` and `load(path)`, and one line in `FORMATS`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..recording import Recording
from . import broad, npz, repoimu, table
from ._common import Raw, finish
from ._estimate import write_estimate

__all__ = ["FORMATS", "Format", "read", "write_estimate"]

#: How many first bytes tell the format.
SNIFF_BYTES = 4096


@dataclass(frozen=True, slots=True)
class Format:
    """A file format: what it is, how its first bytes tell it, how it is read, endings that only it has."""

    title: str
    sniff: Callable[[bytes], bool]
    load: Callable[[Path], Raw]
    endings: tuple[str, ...]


#: Name -> format; the first one whose `sniff` agrees is taken, so the general ones come last.
FORMATS: dict[str, Format] = {
    "broad": Format("BROAD trial (HDF5)", broad.sniff, broad.load, (".hdf5", ".h5")),
    "npz": Format("numpy arrays", npz.sniff, npz.load, (".npz",)),
    "parquet": Format("Parquet table", table.sniff_parquet, table.load_parquet, (".parquet", ".pq")),
    "repoimu": Format("RepoIMU recording (CSV)", repoimu.sniff, repoimu.load, ()),
    "csv": Format("text table", table.sniff, table.load, ()),
}


def read(path: str | os.PathLike[str], *, format: str | None = None, rate: float | None = None) -> Recording:
    """Read a recording of any known format.

    Parameters
    ----------
    path : of the file.
    format : a name of `FORMATS`; None finds it from the content, whatever the ending.
    rate : sampling rate in Hz, in place of the times in the file, which then needs none.

    Returns
    -------
    Recording
        In rad/s, m/s² and µT. NaN and empty cells stay NaN: missing data. Infinite values become NaN, a
        missing or decreasing time is mended, and meta["repairs"] tells every such change. meta["units"] holds
        the units that were found, meta["assumed_units"] those of a table that were not stated and taken as
        SI.

    Raises
    ------
    FileNotFoundError, IsADirectoryError
    ValueError
        An empty or damaged file, an unknown format, unit or set of columns; one line, with the path.
    ImportError
        The format needs a package that is not installed.
    """
    path = Path(path)
    if rate is not None and not (math.isfinite(rate) and rate > 0):
        raise ValueError(f"rate: expected a positive, finite number of Hz, got {rate!r}")
    if format is not None and format not in FORMATS:
        raise ValueError(f"format: expected one of {', '.join(FORMATS)}, got {format!r}")
    if path.is_dir():
        raise IsADirectoryError(f"{path}: expected a file, got a directory")
    try:
        with path.open("rb") as file:
            head = file.read(SNIFF_BYTES)
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: no such file") from None
    try:
        if not head:
            raise ValueError("is empty")
        name = format if format is not None else _find(path, head)
        raw = FORMATS[name].load(path)
        if rate is not None:
            raw.t, raw.rate = None, rate
        return finish(raw, path, name)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _find(path: Path, head: bytes) -> str:
    name = next((name for name, known in FORMATS.items() if known.sniff(head)), None)
    claimed = next((name for name, known in FORMATS.items() if path.suffix.lower() in known.endings), None)
    if claimed is not None and name in (None, "csv", "repoimu"):
        raise ValueError(f"is damaged: its first bytes are not those of a {path.suffix} file")
    if name is None:
        known = ", ".join(f"{key} ({known.title})" for key, known in FORMATS.items())
        raise ValueError(f"is of no known format; known are {known}")
    return name
