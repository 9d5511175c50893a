"""numpy's .npz: arrays gyr, acc, mag and what else a recording has. Also what `Recording.save` writes."""

from __future__ import annotations

import json
import zipfile
import zlib
from typing import Any

import numpy as np

from .._arrays import seconds
from ._contents import TOLD, Options, SensorData, one_line
from ._source import Source

#: How the arrays of streams with clocks of their own begin.
STREAM = "stream"

#: What is in it -> names of the array, the first present one is taken.
NAMES = {
    "t": ("t", "time"),
    "rate": ("rate", "sampling_rate"),
    "gyr": ("gyr", "imu_gyr"),
    "acc": ("acc", "imu_acc"),
    "mag": ("mag", "imu_mag"),
    "ref": ("ref", "opt_quat"),
    "mask": ("mask", "movement"),
    "temperature": ("temperature",),
    "meta": ("meta",),
}


def sniff(source: Source) -> bool:
    """Whether the source is a zip archive of arrays, or one that says by its name that it is."""
    if source.name.lower().endswith(".npz"):
        return source.is_zip
    return source.is_zip and bool(source.names) and all(name.endswith(".npy") for name in source.names)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read an .npz file, in rad/s, m/s², µT."""
    try:
        # numpy.load leaves a file open that it cannot read; one that is given to it is closed here.
        with source.open() as stream, np.load(stream, allow_pickle=False) as file:
            names = list(file.files)
            found: dict[str, Any] = {}
            for field, aliases in NAMES.items():
                name = next((alias for alias in aliases if alias in names), None)
                if name is not None:
                    found[field] = file[name]
            own = _streams(file)
    except (zipfile.BadZipFile, zlib.error, OSError, EOFError, KeyError, ValueError, RuntimeError) as error:
        # RuntimeError includes the NotImplementedError of an unknown compression or encryption.
        raise ValueError(f"is not a readable .npz file: {one_line(error)}") from error
    if not found.keys() & {"gyr", "acc", "mag"} and not own:
        raise ValueError(f"has no array 'gyr', 'acc' or 'mag', only {sorted(names)}")
    rate = _rate(found.pop("rate")) if "rate" in found else None
    meta = _meta(found.pop("meta")) if "meta" in found else {}
    t = found.pop("t", None)
    if t is not None and t.dtype.kind in "Mm":
        t = seconds(t)
    streams = {name: (t, values) for name, values in found.items()}
    return {"imu": SensorData(streams | own, rate=rate, meta=meta)}


def _streams(file: Any) -> dict[str, tuple[Any, Any]]:
    """The streams with clocks of their own that `Recording.save` wrote; those of one clock share its array."""
    found: dict[str, tuple[Any, Any]] = {}
    for key in file.files:
        kind, _, rest = key.partition(".")
        name, _, part = rest.rpartition(".")
        if kind == STREAM and part == "t" and f"{STREAM}.{name}.values" in file.files:
            t = file[key]
            t = next((other for other, _ in found.values() if np.array_equal(other, t)), t)
            found[name] = (t, file[f"{STREAM}.{name}.values"])
    return found


def _rate(value: Any) -> float:
    if value.size != 1 or value.dtype.kind not in "fiu" or not value.item() > 0:
        raise ValueError(f"rate: expected one positive number of Hz, got {value.tolist()!r}")
    return float(value.item())


def _meta(value: Any) -> dict[str, Any]:
    try:
        meta = json.loads(str(value))
    except ValueError:
        meta = None
    if not isinstance(meta, dict):
        raise ValueError("meta: expected a JSON object as text")
    return before(meta)


def before(meta: dict[str, Any]) -> dict[str, Any]:
    """The meta of a recording that was saved: what was told of the file that it came from is not told again."""
    if "path" in meta:
        meta["saved_from"] = meta["path"]
    told = {kind: meta.pop(kind) for kind in (*TOLD, "assumed_units") if meta.get(kind)}
    return {**meta, "told_before": told} if told else meta
