"""numpy's .npz: arrays gyr, acc, mag and what else a recording has. Also what `Recording.save` writes."""

from __future__ import annotations

import json
import zipfile
import zlib
from typing import Any

import numpy as np

from ._contents import Options, SensorData, one_line
from ._source import Source

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
    except (zipfile.BadZipFile, zlib.error, OSError, EOFError, KeyError, ValueError, RuntimeError) as error:
        # RuntimeError includes the NotImplementedError of an unknown compression or encryption.
        raise ValueError(f"is not a readable .npz file: {one_line(error)}") from error
    if not found.keys() & {"gyr", "acc", "mag"}:
        raise ValueError(f"has no array 'gyr', 'acc' or 'mag', only {sorted(names)}")
    rate = _rate(found.pop("rate")) if "rate" in found else None
    meta = _meta(found.pop("meta")) if "meta" in found else {}
    t = found.pop("t", None)
    return {"imu": SensorData({name: (t, values) for name, values in found.items()}, rate=rate, meta=meta)}


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
    if "path" in meta:
        meta["saved_from"] = meta["path"]
    return meta
