"""One valid file or folder of every format: what tests damage, and what the table of formats is made from."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import numpy as np

from devices import cwa, dataflash, gopro, readings, texts, ulog, written

#: How the single file of a sample is called.
START = datetime(2026, 1, 2, 3, 4, 5)


def px4(folder: Path, n: int) -> Path:
    """A log at 250 Hz with a slower magnetometer and attitude; every tenth sample of the accelerometer is missing."""
    return _file(folder / "log.ulg", ulog.log(px4_rows(n), start=900_000))


def px4_rows(n: int) -> list[tuple[str, int, tuple[float, ...]]]:
    """The messages of that log."""
    gyr, acc, mag, q = readings.gyr(n), readings.acc(n), readings.mag(n) / 100.0, readings.quat(n)
    rows: list[tuple[str, int, tuple[float, ...]]] = []
    for k in range(n):
        t = 1_000_000 + 4000 * k
        relative = 2147483647 if k % 10 == 9 else 0
        rows.append(("sensor_combined", 0, (t, *gyr[k], 4000, relative, *acc[k], 4000)))
        if k % 5 == 0:
            rows.append(("vehicle_magnetometer", 0, (t + 300, t - 500, 1, *mag[k])))
        if k % 2 == 0:
            rows.append(("vehicle_attitude", 0, (t, *q[k])))
    return rows


def ardupilot(folder: Path, n: int) -> Path:
    """A log of two IMUs at 50 Hz, a magnetometer and the attitude."""
    return _file(folder / "log.bin", dataflash.log(ardupilot_rows(n)))


def ardupilot_rows(n: int) -> list[tuple[str, tuple[float, ...]]]:
    """The messages of that log."""
    gyr, acc, mag = readings.gyr(n), -readings.acc(n), np.rint(readings.mag(n) * 10).astype(int)
    rows: list[tuple[str, tuple[float, ...]]] = []
    for k in range(n):
        t = 1_000_000 + 20_000 * k
        for instance in (0, 1):
            rows.append(("IMU", (t, instance, *(gyr[k] + instance), *acc[k], 0, 0, 35.5, 1, 1, 1000, 1000)))
        if k % 2 == 0:
            rows.append(("MAG", (t + 500, 0, *mag[k], 10, 20, 30, 0, 0, 0, 1, t)))
        if k % 5 == 0:
            rows.append(("ATT", (t + 100, 0, 123, 0, -456, 0, 35999, 0, 0)))
    return rows


def axivity(folder: Path, n: int) -> Path:
    """An AX6 at 100 Hz."""
    return _file(folder / "device.cwa", cwa.log(axivity_values(n), 100.0, START))


def axivity_values(n: int) -> np.ndarray:
    """(n, 6) int16 as stored: ±2000 °/s and 4096 per g."""
    gyr = np.rint(np.degrees(readings.gyr(n)) * 32768 / 2000)
    return np.hstack([gyr, np.rint(readings.acc(n) / 9.80665 * 4096)]).astype(np.int16)


def video(folder: Path, n: int) -> Path:
    """A GoPro's metadata: gyroscope 200 Hz, accelerometer 100 Hz, a payload a second."""
    return _file(folder / "video.mp4", gopro.mp4(*video_payloads(n)))


def video_payloads(n: int, lost: tuple[int, ...] = ()) -> tuple[list[bytes], list[int]]:
    """The payloads of `n` rows of the gyroscope, and their durations in ms; some are lost."""
    gyr, acc = np.rint(readings.gyr(n) * 1000), np.rint(readings.acc(n)[::2] * 100)
    payloads, durations = [], []
    for number, first in enumerate(range(0, n, 200)):
        rate, force = gyr[first : first + 200], acc[first // 2 : first // 2 + 100]
        total = first + len(rate)
        if number not in lost:
            parts = [gopro.stream("ACCL", force, first // 2 + len(force), 100, "m/s²", "Accelerometer", "YxZ")]
            parts.append(gopro.stream("GYRO", rate, total, 1000, "rad/s", "Gyroscope", "YxZ"))
            payloads.append(gopro.payload(*parts))
            durations.append(len(rate) * 5)
    return payloads, durations


def ros1(folder: Path, n: int) -> Path:
    """A bag of ROS 1 with compressed chunks."""
    return written.ros(folder / "imu.bag", n, kind="ros1", compression="LZ4")


def ros2(folder: Path, n: int) -> Path:
    """A bag of ROS 2: a folder with SQLite."""
    return written.ros(folder / "bag", n, kind="sqlite3")


def mcap(folder: Path, n: int) -> Path:
    """The bare MCAP of a ROS 2 bag, with compressed chunks."""
    return next(written.ros(folder / "bag", n, kind="mcap", compression="STORAGE").glob("*.mcap"))


def _file(path: Path, content: bytes | str) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


#: Sample -> (format, package that writes or reads it, function of folder and number of rows).
SAMPLES: dict[str, tuple[str, str, Callable[[Path, int], Path]]] = {
    "PX4 ULog": ("px4", "pyulog", px4),
    "ArduPilot DataFlash": ("dataflash", "pymavlink", ardupilot),
    "ROS 1 bag": ("ros", "rosbags", ros1),
    "ROS 2 bag": ("ros", "rosbags", ros2),
    "MCAP": ("ros", "rosbags", mcap),
    "EuRoC/ASL folder": ("euroc", "pyarrow", lambda folder, n: texts.euroc(folder / "euroc", n)),
    "x-IMU3 folder": ("xio", "pyarrow", lambda folder, n: texts.ximu3(folder / "x-IMU3 01234567 (USB)", n)),
    "NGIMU folder": ("xio", "pyarrow", lambda folder, n: texts.ngimu(folder / "NGIMU", n)),
    "Xsens MT Manager": ("xsens", "pyarrow", lambda folder, n: _file(folder / "MT_00B42D4B.txt", texts.xsens(n))),
    "Movella DOT": ("dot", "pyarrow", lambda folder, n: _file(folder / "dot.csv", texts.dot(n))),
    "Shimmer": ("shimmer", "pyarrow", lambda folder, n: _file(folder / "shimmer.csv", texts.shimmer(n))),
    "APDM HDF5": ("apdm", "h5py", lambda folder, n: written.apdm(folder / "apdm.h5", n)),
    "APDM CSV": ("apdm-csv", "pyarrow", lambda folder, n: _file(folder / "apdm.csv", texts.apdm_format_7(n))),
    "Sensor Logger": ("sensorlogger", "pyarrow", lambda folder, n: texts.sensorlogger(folder / "walk", n)),
    "phyphox": ("phyphox", "pyarrow", lambda folder, n: texts.phyphox(folder / "phyphox", n)),
    "Axivity AX6": ("axivity", "cwa_reader_rs", axivity),
    "C3D": ("c3d", "ezc3d", lambda folder, n: written.c3d(folder / "walk.c3d", n - n % 10)),
    "GoPro": ("gopro", "telemetry_parser", video),
    "Gyroflow": ("gcsv", "pyarrow", lambda folder, n: _file(folder / "video.gcsv", texts.gcsv(n))),
    "telemachus": ("telemachus", "pyarrow", lambda folder, n: written.telemachus(folder / "trip.parquet", n)),
}
