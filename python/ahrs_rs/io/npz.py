"""numpy's .npz: arrays gyr, acc, mag and what else a recording has. Also what `Recording.save` writes."""

from __future__ import annotations

import json
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from ._common import Raw, one_line

#: Field of `Raw` -> names of the array, the first present one is taken.
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


def sniff(head: bytes) -> bool:
    """Whether a file with these first bytes is a zip archive, which an .npz is."""
    return head.startswith((b"PK\x03\x04", b"PK\x05\x06"))


def load(path: Path) -> Raw:
    """Read an .npz file, in rad/s, m/s², µT."""
    try:
        # numpy.load leaves a file open that it cannot read; one that is given to it is closed here.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            names = list(file.files)
            found: dict[str, Any] = {}
            for field, aliases in NAMES.items():
                name = next((alias for alias in aliases if alias in names), None)
                if name is not None:
                    found[field] = file[name]
    except (zipfile.BadZipFile, zlib.error, OSError, EOFError, KeyError, ValueError, RuntimeError) as error:
        # RuntimeError includes the NotImplementedError of an unknown compression or encryption.
        raise ValueError(f"is not a readable .npz file: {one_line(error)}") from error
    if "gyr" not in found:
        raise ValueError(f"has no array 'gyr', only {sorted(names)}")
    if "rate" in found:
        found["rate"] = _rate(found["rate"])
    found["meta"] = _meta(found["meta"]) if "meta" in found else {}
    return Raw(**found)


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
