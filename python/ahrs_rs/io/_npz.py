"""numpy's .npz: arrays gyr, acc, mag and what else a recording has. Also what `Recording.save` writes."""

from __future__ import annotations

import math
import zipfile
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from ahrs_rs import _json
from ahrs_rs._arrays import seconds
from ahrs_rs._stored import shown
from ahrs_rs.io._contents import TOLD, Options, SensorData, one_line
from ahrs_rs.io._source import Source

#: An array of more bytes than this is to be packed no better than so many times: readings have noise.
LARGE, MOST_PACKED = 2**28, 100

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
                    _check_size(file.zip, name)
                    found[field] = file[name]
            own = _streams(file)
    except Exception as error:  # a damaged archive or header makes zipfile, zlib and numpy raise nearly every class
        raise ValueError(f"is not a readable .npz file: {one_line(error)}") from error
    if not found.keys() & {"gyr", "acc", "mag"} and not own:
        raise ValueError(f"has no array 'gyr', 'acc' or 'mag', only {sorted(names)}")
    rate = _rate(found.pop("rate")) if "rate" in found else None
    meta = _meta(found.pop("meta")) if "meta" in found else {}
    t = _clock(found.pop("t"), meta) if "t" in found else None
    streams = {name: (t, values) for name, values in found.items()}
    return {"imu": SensorData(streams | own, rate=rate, meta=meta)}


def _streams(file: Any) -> dict[str, tuple[Any, Any]]:
    """The streams with clocks of their own that `Recording.save` wrote; those of one clock share its array."""
    found: dict[str, tuple[Any, Any]] = {}
    for key in file.files:
        kind, _, rest = key.partition(".")
        name, _, part = rest.rpartition(".")
        if kind == STREAM and part == "t" and f"{STREAM}.{name}.values" in file.files:
            _check_size(file.zip, key)
            _check_size(file.zip, f"{STREAM}.{name}.values")
            t = file[key]
            t = next((other for other, _ in found.values() if np.array_equal(other, t)), t)
            found[name] = (t, file[f"{STREAM}.{name}.values"])
    return found


def _check_size(archive: zipfile.ZipFile, name: str) -> None:
    """Raise a ``ValueError`` where an array is larger than what the archive holds of it, before room is made for it."""
    name = name if name in archive.namelist() else f"{name}.npy"
    with archive.open(name) as member:
        version = npy.read_magic(member)
        if version not in ((1, 0), (2, 0)):
            raise ValueError(f"{name}: expected version 1.0 or 2.0 of the format, got {version}")
        header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = header(member)
    size, held = math.prod(shape) * dtype.itemsize, archive.getinfo(name)
    if min(shape, default=0) < 0 or size > held.file_size:
        raise ValueError(f"{name}: shape {str(shape)[:60]} of {str(dtype)[:30]} is more than it holds")
    if size > LARGE and size > MOST_PACKED * held.compress_size:
        raise ValueError(f"{name}: {size:,} bytes are packed into {held.compress_size:,}, as no readings can be")


def _clock(t: NDArray[Any], meta: dict[str, Any]) -> NDArray[Any]:
    """Times in s, of dates since the first one."""
    if t.dtype.kind not in "fiuMm":
        raise ValueError(f"t: expected times, got dtype {str(t.dtype)[:60]}")
    if t.dtype.kind not in "Mm":
        return t
    known = t[~np.isnat(t)]
    if t.dtype.kind == "M" and known.size:
        meta["start"] = f"{np.datetime_as_string(known[0].astype('datetime64[us]'))}+00:00"
    return seconds(t)


def _rate(value: Any) -> float:
    if value.size != 1 or value.dtype.kind not in "fiu" or not value.item() > 0:
        raise ValueError(f"rate: expected one positive number of Hz, got {value.tolist()!r}")
    return float(value.item())


def _meta(value: Any) -> dict[str, Any]:
    try:
        meta = _json.parse(str(value))
    except ValueError:
        meta = None
    if not isinstance(meta, dict):
        raise ValueError("meta: expected a JSON object as text")
    for name in (*TOLD, "calibrated"):
        sentences = meta.get(name, [])
        if not isinstance(sentences, list) or not all(isinstance(one, str) for one in sentences):
            raise ValueError(f"meta: {name}: expected a list of texts, got {shown(sentences)}")
    for name in ("units", "assumed_units"):
        units = meta.get(name, {})
        if not isinstance(units, dict) or not all(isinstance(one, str) for one in units.values()):
            raise ValueError(f"meta: {name}: expected an object of texts, got {shown(units)}")
    return before(meta)


def before(meta: dict[str, Any]) -> dict[str, Any]:
    """The meta of a recording that was saved: what was told of the file that it came from is not told again."""
    if "path" in meta:
        meta["saved_from"] = meta["path"]
    told = {kind: meta.pop(kind) for kind in (*TOLD, "assumed_units") if meta.get(kind)}
    return {**meta, "told_before": told} if told else meta
