"""Files that are written by the formats' own libraries, which the caller has to have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from devices import readings

START = 1_700_000_000_000_000_005


def ros(
    path: Path,
    n: int,
    *,
    kind: str,
    orientation: float = 0.0,
    namespaces: tuple[str, ...] = ("/imu",),
    field: bool = True,
    stamped: bool = True,
    compression: str = "",
) -> Path:
    """A bag of Imu and MagneticField by rosbags: `kind` is "ros1", "sqlite3" or "mcap" (the two of ROS 2 are folders).

    `compression` is LZ4 or BZ2 of ROS 1, FILE, MESSAGE or STORAGE of ROS 2. Messages are recorded 100 ms after their
    header's stamp. `orientation` is the first number of its covariance.
    """
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)
    types = store.types
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer: Any = Writer1(path) if kind == "ros1" else Writer2(path, version=9, storage_plugin=plugin)
    if compression and kind == "ros1":
        writer.set_compression(Writer1.CompressionFormat[compression])
    elif compression:
        writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
    serialize = store.serialize_ros1 if kind == "ros1" else store.serialize_cdr
    gyr, acc, mag, q = readings.gyr(n), readings.acc(n), readings.mag(n) * 1e-6, readings.quat(n)
    with writer:
        for number, namespace in enumerate(namespaces):
            frame = f"imu{number}_link"
            imu = writer.add_connection(f"{namespace}/data", "sensor_msgs/msg/Imu", typestore=store)
            fields = writer.add_connection(f"{namespace}/mag", "sensor_msgs/msg/MagneticField", typestore=store)
            for k in range(n):
                ns = START + 10_000_000 * k if stamped else 0
                header = _header(types, kind, ns, frame, k)
                covariance = np.array([orientation, *[0.0] * 8])
                vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
                message = types["sensor_msgs/msg/Imu"](
                    header=header,
                    orientation=quaternion(x=q[k, 1], y=q[k, 2], z=q[k, 3], w=q[k, 0]),
                    orientation_covariance=covariance,
                    angular_velocity=vector(*(gyr[k] * (number + 1))),
                    angular_velocity_covariance=np.zeros(9),
                    linear_acceleration=vector(*acc[k]),
                    linear_acceleration_covariance=np.zeros(9),
                )
                recorded = START + 10_000_000 * k + 100_000_000
                writer.write(imu, recorded, serialize(message, "sensor_msgs/msg/Imu"))
                if field and k % 2 == 0:
                    reading = types["sensor_msgs/msg/MagneticField"](
                        header=header, magnetic_field=vector(*mag[k]), magnetic_field_covariance=np.zeros(9)
                    )
                    writer.write(fields, recorded, serialize(reading, "sensor_msgs/msg/MagneticField"))
    return path


def _header(types: Any, kind: str, ns: int, frame: str, sequence: int) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
    more = {"seq": sequence} if kind == "ros1" else {}
    return types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **more)


def c3d(
    path: Path,
    n: int,
    *,
    units: tuple[str, str, str] = ("g", "deg/s", "uT"),
    labels: str = "{}{}",
    sensors: tuple[str, ...] = ("",),
    a_frame: int = 10,
) -> Path:
    """Analog channels over points at 100 Hz, `a_frame` samples each, by ezc3d, which stores float32.

    `n` is a multiple of `a_frame`.
    """
    import ezc3d

    names, held, stated = [], [], []
    factors = (1 / 9.80665, 180 / np.pi, 1.0)
    groups = zip(
        ("Acc", "Gyr", "Mag"), units, factors, (readings.acc(n), readings.gyr(n), readings.mag(n)), strict=True
    )
    for name, unit, factor, values in groups:
        for sensor in sensors:
            names += [labels.format(name, axis, sensor=sensor) for axis in "XYZ"]
            held.append(values.T * factor)
            stated += [unit] * 3
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100]
    file["parameters"]["ANALOG"]["RATE"]["value"] = [100 * a_frame]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = names
    file["parameters"]["ANALOG"]["UNITS"]["value"] = stated
    file["data"]["points"] = np.zeros((4, 1, n // a_frame))
    file["data"]["points"][3] = 1.0
    file["parameters"]["POINT"]["LABELS"]["value"] = ["M1"]
    file["data"]["analogs"] = np.vstack(held)[None]
    file.write(str(path))
    return path


def apdm(path: Path, n: int, *, old: bool = False) -> Path:
    """APDM's HDF5 of two sensors by h5py: version 5, or the older layout."""
    import h5py

    stamps = np.uint64(1_550_879_504_438_281) + np.arange(n, dtype=np.uint64) * np.uint64(7812)
    with h5py.File(path, "w") as file:
        file.attrs["FileFormatVersion"] = 3 if old else 5
        for number, label in (("5718", "Lumbar"), ("5778", "Chest")):
            if old:
                group = file.create_group(f"SI-00{number}")
                group["Time"] = stamps
                held, names = group.create_group("Calibrated"), ("Accelerometers", "Gyroscopes", "Magnetometers")
                group["Orientation"] = readings.quat(n)
            else:
                held, names = file.create_group(f"Sensors/{number}"), ("Accelerometer", "Gyroscope", "Magnetometer")
                held["Time"] = stamps
                configuration = held.create_group("Configuration")
                configuration.attrs["Label 0"] = np.bytes_(label)
                file[f"Processed/{number}/Orientation"] = readings.quat(n)
            for name, values in zip(names, (readings.acc(n), readings.gyr(n), readings.mag(n)), strict=True):
                held[name] = values
    return path


def telemachus(path: Path, n: int, *, gravity: bool = True) -> Path:
    """telemachus's columns at 100 Hz, by pyarrow."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    stamps = pa.array(1_767_225_600_000_000 + 10_000 * np.arange(n), pa.timestamp("us", tz="UTC"))
    acc = readings.acc(n) - (0.0 if gravity else np.array([0.0, 0.0, 9.80665]))
    columns: dict[str, Any] = {"ts": stamps, "lat": np.full(n, 45.0), "lon": np.full(n, 3.0), "speed_mps": np.ones(n)}
    for index, axis in enumerate("xyz"):
        columns |= {
            f"a{axis}_mps2": acc[:, index],
            f"g{axis}_rad_s": readings.gyr(n)[:, index],
            f"m{axis}_uT": readings.mag(n)[:, index],
        }
    pq.write_table(pa.table(columns), path)
    return path
