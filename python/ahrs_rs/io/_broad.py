"""BROAD, the Berlin Robust Orientation Estimation Assessment Dataset: HDF5 with optical truth.

Laidig, Caruso, Cereatti, Seel, Data 6(7):72, 2021. Units are ours already; the truth is sensor to ENU,
scalar-first.
"""

from __future__ import annotations

from typing import Any

from ahrs_rs.io import _hdf5
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._source import Source

#: Stream -> data set of the file.
DATASETS = {"gyr": "imu_gyr", "acc": "imu_acc", "mag": "imu_mag", "ref": "opt_quat", "mask": "movement"}


def sniff(source: Source) -> bool:
    """Whether the source is HDF5."""
    return source.head.startswith(b"\x89HDF\r\n\x1a\n")


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a BROAD trial."""
    with _hdf5.opened(source) as file:
        if DATASETS["gyr"] not in file:
            names = ", ".join(map(repr, sorted(file)))
            raise ValueError(f"is not a BROAD trial: no data set 'imu_gyr' among {names[:200]}")
        if "sampling_rate" not in file.attrs:
            raise ValueError("is not a BROAD trial: no attribute 'sampling_rate'")
        streams: dict[str, Any] = {
            name: (None, _hdf5.array(file[key])) for name, key in DATASETS.items() if key in file
        }
        meta: dict[str, Any] = {"units": {"gyr": "rad/s", "acc": "m/s²", "mag": "µT"}, "ref_frame": "ENU"}
        if "info" in file.attrs:
            meta["info"] = str(file.attrs["info"])
        return {"imu": SensorData(streams, rate=float(file.attrs["sampling_rate"]), meta=meta)}
