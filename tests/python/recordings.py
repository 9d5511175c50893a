"""Recordings of random numbers, and files of them in the formats that `ahrs_rs.read` knows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ahrs_rs._recording import Recording


def recording(count: int = 50, seed: int = 0) -> Recording:
    """A recording with every array, of random numbers."""
    random = np.random.default_rng(seed)
    quat = random.standard_normal((count, 4))
    return Recording(
        t=np.cumsum(random.uniform(0.009, 0.011, count)),
        gyr=random.standard_normal((count, 3)),
        acc=10 * random.standard_normal((count, 3)),
        mag=40 * random.standard_normal((count, 3)),
        ref=quat / np.linalg.norm(quat, axis=1, keepdims=True),
        mask=random.random(count) < 0.5,
        temperature=random.uniform(20, 30, count),
        meta={"note": "random"},
    )


def write_text(path: Path, header: str, rows: np.ndarray | list[str], separator: str = ",") -> Path:
    lines = [row if isinstance(row, str) else separator.join(map(repr, row.tolist())) for row in rows]
    path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    return path


def write_broad(path: Path, source: Recording, **left_out: None) -> Path:
    arrays = {
        "imu_gyr": source.gyr,
        "imu_acc": source.acc,
        "imu_mag": source.mag,
        "opt_quat": source.ref,
        "movement": source.mask,
    }
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, array in (arrays | left_out).items():
            if array is not None:
                file[name] = array
        file.attrs["sampling_rate"] = 285.7142857142857
        file.attrs["info"] = "a trial"
    return path


REPOIMU_HEADERS = {
    "T-stick": (
        "Time (s);Vicon Orientation;;;;IMU Acceleration;;;IMU Gyroscope;;;IMU Magnetometer;;;",
        ";W;X;Y;Z;X;Y;Z;X;Y;Z;X;Y;Z;",
        "\n",
        "",
    ),
    "pendulum": (
        "Time;Vicon Orientation;;;;IMU Acceleration;;;IMU Gyroscope;;;IMU Magnetometer;;",
        "s;W;X;Y;Z;X;Y;Z;X;Y;Z;X;Y;Z",
        "\r\n",
        "",
    ),
    "rows with a separator at the end": (
        "Time (s);Vicon Orientation;;;;IMU Acceleration;;;IMU Gyroscope;;;IMU Magnetometer;;",
        ";W;X;Y;Z;X;Y;Z;X;Y;Z;X;Y;Z",
        "\n",
        ";",
    ),
}


def write_repoimu(path: Path, rows: list[list[str]], variant: str = "T-stick") -> Path:
    first, second, newline, tail = REPOIMU_HEADERS[variant]
    lines = [first, second, *(";".join(row) + tail for row in rows)]
    path.write_bytes((newline.join(lines) + newline).encode())
    return path


def repoimu_rows(source: Recording) -> list[list[str]]:
    assert source.ref is not None
    assert source.acc is not None
    assert source.mag is not None
    table = np.column_stack((source.t, source.ref, source.acc, source.gyr, source.mag))
    return [[repr(value) for value in row] for row in table.tolist()]
