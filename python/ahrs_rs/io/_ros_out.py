"""Estimates as messages of ROS 2: sensor_msgs/Imu and geometry_msgs/QuaternionStamped, in a bag or an MCAP file."""

from __future__ import annotations

import datetime
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ahrs_rs import _atomic
from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import require

if TYPE_CHECKING:
    from ahrs_rs._estimate import Estimate
    from ahrs_rs._recording import Recording

#: Topics of the messages, and the frame of the sensor.
IMU, ORIENTATION, FRAME = "/imu/data", "/imu/orientation", "imu_link"
#: The format of bags since ROS 2 Iron.
BAG_VERSION = 9


def write_ros(path: Path, est: Estimate, recording: Recording | None) -> None:
    """Write an estimate as a bag (a folder, .ros2) or an MCAP file (.mcap).

    QuaternionStamped on /imu/orientation; with a recording that has a gyroscope and an accelerometer also Imu on
    /imu/data: its readings, the orientation, and the covariance of that about the fixed axes of the earth frame where
    the estimate has one (else zeros: unknown). Rows in which a sensor is missing have no Imu. Stamps are those of the
    recording, since 1970 where it knows its start.

    Raises
    ------
    FileExistsError
        A bag's folder that is there.
    """
    rosbag2 = require("rosbags.rosbag2", "ros")
    bag = path.suffix.lower() != ".mcap"
    if bag and path.exists():
        raise FileExistsError(f"{path}: expected a new folder, as a bag is not written over")
    plugin = rosbag2.StoragePlugin.SQLITE3 if bag else rosbag2.StoragePlugin.MCAP
    with tempfile.TemporaryDirectory(prefix="ahrs_rs_") as folder:
        made = Path(folder) / path.stem
        with rosbag2.Writer(made, version=BAG_VERSION, storage_plugin=plugin) as writer:
            _write(writer, est, recording)
        if not bag:
            (content,) = made.glob("*.mcap")
            with _atomic.replacing(path) as beside:
                shutil.copyfile(content, beside)
            return
        beside = path.with_name(f".{path.stem}.{os.urandom(6).hex()}.part")
        try:
            shutil.copytree(made, beside)
            beside.rename(path)
        finally:
            shutil.rmtree(beside, ignore_errors=True)


def _write(writer: Any, est: Estimate, recording: Recording | None) -> None:
    typesys = require("rosbags.typesys", "ros")
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    types = store.types
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    stamped, imu = types["geometry_msgs/msg/QuaternionStamped"], types["sensor_msgs/msg/Imu"]
    stamps = _nanoseconds(np.asarray(est.t, dtype=np.float64), recording)
    quats = np.asarray(est.quat, dtype=np.float64).tolist()
    orientation = writer.add_connection(ORIENTATION, stamped.__msgtype__, typestore=store)
    readings = _readings(recording)
    data = writer.add_connection(IMU, imu.__msgtype__, typestore=store) if readings is not None else None
    covariances = _earth_covariances(est)
    unknown = np.zeros(9)
    for k, stamp in enumerate(stamps.tolist()):
        w, x, y, z = quats[k]
        head = header(stamp=time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id=FRAME)
        quat = quaternion(x=x, y=y, z=z, w=w)
        message = stamped(header=head, quaternion=quat)
        writer.write(orientation, stamp, store.serialize_cdr(message, stamped.__msgtype__))
        if readings is None or data is None or np.isnan(readings[k]).any():
            continue
        row = readings[k].tolist()
        message = imu(
            header=head,
            orientation=quat,
            orientation_covariance=unknown if covariances is None else covariances[k],
            angular_velocity=vector(x=row[0], y=row[1], z=row[2]),
            angular_velocity_covariance=unknown,
            linear_acceleration=vector(x=row[3], y=row[4], z=row[5]),
            linear_acceleration_covariance=unknown,
        )
        writer.write(data, stamp, store.serialize_cdr(message, imu.__msgtype__))


def _readings(recording: Recording | None) -> FloatArray | None:
    if recording is None or recording.gyr is None or recording.acc is None:
        return None
    return np.hstack([recording.gyr, recording.acc])


def _earth_covariances(est: Estimate) -> FloatArray | None:
    """(T, 9) of the attitude error about the axes of the earth frame, rad²."""
    if est.covariance is None:
        return None
    rotations = np.asarray(est.matrix(), dtype=np.float64)
    turned = rotations @ np.asarray(est.covariance, dtype=np.float64) @ np.swapaxes(rotations, -1, -2)
    return turned.reshape(-1, 9)


def _nanoseconds(t: FloatArray, recording: Recording | None) -> Any:
    """Stamps in whole nanoseconds; none is before 1970."""
    start = 0
    if recording is not None and recording.meta.get("start"):
        moment = datetime.datetime.fromisoformat(str(recording.meta["start"]))
        moment = moment if moment.tzinfo is not None else moment.replace(tzinfo=datetime.UTC)
        since = moment - datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
        start = (since.days * 86400 + since.seconds) * 10**9 + since.microseconds * 1000
    stamps = np.round(t * 1e9).astype(np.int64) + start
    return stamps - min(int(stamps.min(initial=0)), 0)
