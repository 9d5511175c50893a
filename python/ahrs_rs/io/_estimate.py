"""Estimates written to a file, by the ending of its name."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _atomic, metrics
from ahrs_rs._constants import GRAVITY
from ahrs_rs._derived import DERIVED
from ahrs_rs._validate import did_you_mean
from ahrs_rs.io._contents import require
from ahrs_rs.io._ros_out import write_ros
from ahrs_rs.io._sto_out import write_sto
from ahrs_rs.io._tum import write_tum

if TYPE_CHECKING:
    from ahrs_rs._estimate import Estimate
    from ahrs_rs._recording import Recording

Arrays = dict[str, NDArray[Any]]

#: Array -> names of its columns in CSV and Parquet; others are numbered.
COLUMNS = {
    "t": ("t",),
    "quat": ("qw", "qx", "qy", "qz"),
    "euler": ("roll", "pitch", "yaw"),
    "euler_deg": ("roll_deg", "pitch_deg", "yaw_deg"),
    "gyr_bias": ("bias_x", "bias_y", "bias_z"),
    "gyr_bias_deg": ("bias_x_deg_s", "bias_y_deg_s", "bias_z_deg_s"),
    "status": ("status",),
    "linear_acceleration": ("lin_acc_x", "lin_acc_y", "lin_acc_z"),
    "linear_acceleration_sensor": ("lin_acc_sensor_x", "lin_acc_sensor_y", "lin_acc_sensor_z"),
    "gravity": ("gravity_x", "gravity_y", "gravity_z"),
    "turn_rate": ("turn_rate_x", "turn_rate_y", "turn_rate_z"),
    "turn_rate_deg_s": ("turn_rate_x_deg_s", "turn_rate_y_deg_s", "turn_rate_z_deg_s"),
    "rotation_vector": ("rotvec_x", "rotvec_y", "rotvec_z"),
}


@dataclass(frozen=True, slots=True)
class Writer:
    """How a kind of file is written.

    Parameters
    ----------
    title : what it is.
    write : of an estimate, with its recording where one is given, and angles in degrees where that is asked for.
    library, extra : what has to be installed.
    """

    title: str
    write: Callable[[Path, Estimate, Recording | None, bool], None]
    library: str = ""
    extra: str = ""

    def require(self) -> None:
        """ImportError where its library is not installed."""
        if self.library:
            require(self.library, self.extra)


def save_estimate(
    path: str | os.PathLike[str],
    est: Estimate,
    recording: Recording | None = None,
    *,
    degrees: bool = False,
    outputs: Sequence[str] = (),
    gravity: float = GRAVITY,
) -> None:
    """Write an estimate; see `Estimate.save`.

    Parameters
    ----------
    path : str or path-like
        The ending tells the format.
    est : Estimate
        What is written.
    recording : Recording, optional
        Of the same rows, for what is made of it.
    degrees : bool, optional
        Degrees in place of radians.
    outputs : sequence of str, optional
        What else follows from the attitudes, for CSV, Parquet and npz.
    gravity : float, optional
        Of the place, m/s².

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> est = ar.Madgwick(rate=100.0).run(ar.simulate.demo(duration=5.0))
    >>> with TemporaryDirectory() as folder:
    ...     ar.io.save_estimate(Path(folder, "walk.csv"), est)
    ...     len(Path(folder, "walk.csv").read_text().splitlines())
    501
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise ValueError(f"path: expected a name that ends in {', '.join(WRITERS)}, got {path.name!r}")
    if est.quat.ndim != 2:
        raise ValueError(
            f"estimate: expected one of one recording, got {est.quat.shape[0]} side by side: save each of them"
        )
    if recording is not None and len(recording) != len(est):
        raise ValueError(f"recording: expected the {len(est)} rows of the estimate, got {len(recording)}")
    more = derived_of(est, recording, degrees, outputs, gravity)
    if more and path.suffix.lower() not in _ARRAYS:
        raise ValueError(
            f"outputs: expected none in {path.suffix}, as only {', '.join(_ARRAYS)} hold them, got {outputs}"
        )
    if more or gravity != GRAVITY:
        arrays = arrays_of(est, recording, degrees, gravity)
        status = arrays.pop("status")
        _ARRAYS[path.suffix.lower()](path, arrays | more | {"status": status})
        return
    writer.write(path, est, recording, degrees)


def derived_of(
    est: Estimate, recording: Recording | None, degrees: bool, outputs: Sequence[str], gravity: float = GRAVITY
) -> Arrays:
    """What follows from the attitudes, by the names of `DERIVED`, with the unit in a name where it is degrees."""
    arrays: Arrays = {}
    for name in outputs:
        if name not in DERIVED:
            known = ", ".join(DERIVED)
            raise ValueError(f"outputs: expected some of {known}, got {name!r}{did_you_mean(name, DERIVED)}")
        sensor = DERIVED[name]
        if not sensor:
            if name == "gravity":
                arrays[name] = est.gravity(gravity)
            elif name == "rotation_vector":
                arrays[name] = est.rotation_vector()
            else:
                arrays[f"{name}_deg" if degrees else name] = getattr(est, name)(degrees)
            continue
        if recording is None:
            raise ValueError(f"recording: needed for the output {name}, got None")
        readings = recording.require(sensor)
        if name == "turn_rate":
            rate = est.turn_rate(readings)
            arrays["turn_rate_deg_s" if degrees else name] = np.rad2deg(rate) if degrees else rate
        else:
            frame = "sensor" if name.endswith("_sensor") else "earth"
            arrays[name] = est.linear_acceleration(readings, frame, gravity=gravity)
    return arrays


def arrays_of(est: Estimate, recording: Recording | None, degrees: bool, gravity: float = GRAVITY) -> Arrays:
    """What is written of an estimate, in the order of the columns."""
    arrays: Arrays = {"t": est.t, "quat": est.quat, "euler_deg" if degrees else "euler": est.euler(degrees)}
    if est.gyr_bias is not None:
        arrays["gyr_bias_deg" if degrees else "gyr_bias"] = np.rad2deg(est.gyr_bias) if degrees else est.gyr_bias
    if recording is not None and recording.acc is not None:
        arrays["linear_acceleration"] = est.linear_acceleration(recording.acc, gravity=gravity)
    arrays |= est.extra
    arrays["status"] = est.status
    return arrays


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
    same number back. `Estimate.save` writes more, and in more formats.

    Parameters
    ----------
    path : str or path-like
        The ending tells the format: .csv, .parquet or .npz.
    t : array_like
        (T,) s.
    quat : array_like
        (T, 4).
    gyr_bias : array_like, optional
        (T, 3) rad/s, or None.
    status : array_like, optional
        (T,) integers, or None.
    euler : array_like, optional
        (T, 3) rad, or None: computed from `quat`.

    Raises
    ------
    ValueError
        Another ending, or a wrong shape.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "truth.csv")
    ...     ar.write_estimate(path, rec.t, rec.ref)
    ...     path.read_text().splitlines()[0]
    't,qw,qx,qy,qz,roll,pitch,yaw'
    """
    path = Path(path)
    writer = _ARRAYS.get(path.suffix.lower())
    if writer is None:
        raise ValueError(f"path: expected a name that ends in {', '.join(_ARRAYS)}, got {path.name!r}")
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


def columns_of(arrays: Mapping[str, NDArray[Any]]) -> Arrays:
    """The arrays column by column: those of more than one dimension are numbered, as covariance_0_1."""
    columns: Arrays = {}
    for name, array in arrays.items():
        known = COLUMNS.get(name)
        for k, index in enumerate(np.ndindex(*array.shape[1:])):
            columns[known[k] if known else "_".join([name, *map(str, index)])] = array[(slice(None), *index)]
    return columns


def write_columns_csv(path: Path, columns: Mapping[str, NDArray[Any]]) -> None:
    """A CSV file, with the shortest text that gives each number back; NaN is an empty cell."""
    cells = [column.tolist() for column in columns.values()]
    for column, array in zip(cells, columns.values(), strict=True):
        if array.dtype.kind == "f":
            for k in np.flatnonzero(np.isnan(array)):
                column[k] = ""
    with _atomic.text(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*cells, strict=True))


def write_columns_parquet(
    path: Path, columns: Mapping[str, NDArray[Any]], meta: Mapping[str, str] | None = None
) -> None:
    """A Parquet file, with texts in its metadata where there are any."""
    pa, parquet = require("pyarrow"), require("pyarrow.parquet")
    table = pa.table({name: np.ascontiguousarray(column) for name, column in columns.items()})
    with _atomic.replacing(path) as beside:
        parquet.write_table(table.replace_schema_metadata(dict(meta)) if meta else table, beside)


def _csv(path: Path, arrays: Arrays) -> None:
    write_columns_csv(path, columns_of(arrays))


def _parquet(path: Path, arrays: Arrays) -> None:
    write_columns_parquet(path, columns_of(arrays))


def _npz(path: Path, arrays: Arrays) -> None:
    contents: dict[str, Any] = dict(arrays)
    with _atomic.binary(path) as file:
        np.savez_compressed(file, **contents)


_ARRAYS: dict[str, Callable[[Path, Arrays], None]] = {".csv": _csv, ".parquet": _parquet, ".npz": _npz}


def _of_arrays(write: Callable[[Path, Arrays], None]) -> Callable[[Path, Estimate, Recording | None, bool], None]:
    def written(path: Path, est: Estimate, recording: Recording | None, degrees: bool) -> None:
        write(path, arrays_of(est, recording, degrees))

    return written


def _sto(path: Path, est: Estimate, recording: Recording | None, degrees: bool) -> None:
    write_sto(path, {path.stem: est})


def _tum(path: Path, est: Estimate, recording: Recording | None, degrees: bool) -> None:
    write_tum(path, est.t, est.quat)


def _ros(path: Path, est: Estimate, recording: Recording | None, degrees: bool) -> None:
    write_ros(path, est, recording)


#: Ending -> how a file with it is written.
WRITERS: dict[str, Writer] = {
    ".csv": Writer("CSV table", _of_arrays(_csv)),
    ".parquet": Writer("Parquet table", _of_arrays(_parquet), "pyarrow", "io"),
    ".npz": Writer("numpy arrays", _of_arrays(_npz)),
    ".sto": Writer("OpenSim orientations", _sto),
    ".tum": Writer("TUM trajectory", _tum),
    ".mcap": Writer("ROS 2 messages in an MCAP file", _ros, "rosbags", "ros"),
    ".ros2": Writer("ROS 2 bag (a folder)", _ros, "rosbags", "ros"),
}


def writers() -> dict[str, Writer]:
    """Ending of a file's name -> how an estimate is written to it.

    Returns
    -------
    dict of str to callable
        By the endings of names.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ".csv" in ar.io.writers()
    True
    """
    return dict(WRITERS)
