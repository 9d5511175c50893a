"""Recordings written to a file which `read` gives back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _atomic
from ahrs_rs.io._estimate import write_columns_csv, write_columns_parquet
from ahrs_rs.io._names import AXES
from ahrs_rs.io._npz import STREAM
from ahrs_rs.io._table import META

if TYPE_CHECKING:
    from ahrs_rs._recording import Recording

#: Arrays of rows.
ROWS = ("t", "gyr", "acc", "mag", "ref", "mask", "temperature")
#: Quantity -> its unit in the names of columns.
UNITS = {"t": "s", "gyr": "rad/s", "acc": "m/s2", "mag": "uT", "temperature": "degC"}


def save_recording(recording: Recording, path: Path) -> None:
    """Write a recording, by the ending of the name; see `Recording.save`.

    Parameters
    ----------
    recording : Recording
        What is written.
    path : path-like
        The ending tells the format: .npz, .parquet or .csv.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> with TemporaryDirectory() as folder:
    ...     ar.io.save_recording(rec, Path(folder, "walk.npz"))
    ...     len(ar.read(Path(folder, "walk.npz")))
    500
    """
    ending = path.suffix.lower()
    if ending == ".npz":
        _npz(recording, path)
    elif ending == ".csv":
        write_columns_csv(path, _columns(recording))
    elif ending == ".parquet":
        write_columns_parquet(path, _columns(recording), {META: _meta(recording)})
    else:
        raise ValueError(f"path: expected a name that ends in .npz, .parquet or .csv, got {path.name!r}")


def _meta(recording: Recording) -> str:
    return json.dumps({**recording.meta, "rate": recording.rate}, default=str)


def _npz(recording: Recording, path: Path) -> None:
    arrays: dict[str, NDArray[Any]] = {}
    streams = recording.streams if recording.has_own_clocks else recording.others
    if not recording.has_own_clocks:
        arrays = {name: array for name in ROWS if (array := getattr(recording, name)) is not None}
    for name, stream in streams.items():
        arrays[f"{STREAM}.{name}.t"], arrays[f"{STREAM}.{name}.values"] = stream.t, stream.values
    meta = np.array(json.dumps(recording.meta, default=str))
    with _atomic.binary(path) as file:
        np.savez_compressed(file, rate=np.float64(recording.rate), meta=meta, **arrays)  # type: ignore[arg-type]


def _columns(recording: Recording) -> dict[str, NDArray[Any]]:
    """The rows, with units in the names."""
    units = dict(UNITS)
    if str(recording.meta.get("units", {}).get("mag", "")).startswith("normalised"):
        units["mag"] = "normalised"
    columns: dict[str, NDArray[Any]] = {f"t [{units['t']}]": recording.t}
    for name in ROWS[1:]:
        array = getattr(recording, name)
        if array is None:
            continue
        unit = f" [{units[name]}]" if name in units else ""
        labels = [f"{name}_q{axis}" if name == "ref" else f"{name}_{axis}" for axis in AXES[name] if axis] or [name]
        parts = [array] if array.ndim == 1 else list(array.T)
        for label, part in zip(labels, parts, strict=True):
            columns[label + unit] = part.astype(np.uint8) if part.dtype.kind == "b" else part
    quat = recording.device_quat
    if quat is not None:
        columns |= {f"quat_{axis}": part for axis, part in zip("wxyz", quat.T, strict=True)}
    return columns
