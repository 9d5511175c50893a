"""BROAD, the Berlin Robust Orientation Estimation Assessment Dataset: HDF5 with optical truth.

Laidig, Caruso, Cereatti, Seel, Data 6(7):72, 2021. Units are ours already; the truth is sensor to ENU,
scalar-first.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ._common import Raw, one_line, require

#: Field of `Raw` -> data set of the file.
DATASETS = {"gyr": "imu_gyr", "acc": "imu_acc", "mag": "imu_mag", "ref": "opt_quat", "mask": "movement"}


def sniff(head: bytes) -> bool:
    """Whether a file with these first bytes is HDF5."""
    return head.startswith(b"\x89HDF\r\n\x1a\n")


def load(path: Path) -> Raw:
    """Read a BROAD trial."""
    h5py = require("h5py")
    try:
        with h5py.File(path, "r") as file:
            if DATASETS["gyr"] not in file:
                raise ValueError(f"is not a BROAD trial: no data set 'imu_gyr' among {sorted(file)}")
            if "sampling_rate" not in file.attrs:
                raise ValueError("is not a BROAD trial: no attribute 'sampling_rate'")
            arrays: dict[str, Any] = {name: file[key][()] for name, key in DATASETS.items() if key in file}
            meta: dict[str, Any] = {"units": {"gyr": "rad/s", "acc": "m/s²", "mag": "µT"}, "ref_frame": "ENU"}
            if "info" in file.attrs:
                meta["info"] = str(file.attrs["info"])
            return Raw(**arrays, rate=float(file.attrs["sampling_rate"]), meta=meta)
    except (OSError, RuntimeError, TypeError, KeyError) as error:
        raise ValueError(f"is not a readable HDF5 file: {one_line(error)}") from error
