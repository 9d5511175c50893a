"""ROS 1 bags, ROS 2 bags and MCAP, through rosbags.

Every topic of sensor_msgs/Imu is a sensor: rad/s and specific force in m/s² (REP 145), in the frame of
header.frame_id. Times are those of the header, which is when the sample was taken; those of the bag are when it was
recorded. A topic of sensor_msgs/MagneticField (tesla) joins the IMU whose frame it has, or that shares its namespace;
FluidPressure and Temperature the same. An orientation with covariance -1 is none.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData, SensorInfo, require
from ahrs_rs.io._library import refuse, shortened, understood
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

ROS1, MCAP, SQLITE = b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n", b"SQLite format 3\0"
IMU, FIELD = "sensor_msgs/msg/Imu", "sensor_msgs/msg/MagneticField"
#: Message -> stream, attribute, factor to our unit.
COMPANIONS = {
    FIELD: ("mag", "magnetic_field", 1e6),
    "sensor_msgs/msg/FluidPressure": ("pressure", "fluid_pressure", 1.0),
    "sensor_msgs/msg/Temperature": ("temperature", "temperature", 1.0),
}
#: What holds orientations or motion, and is not taken: named, so that nobody misses it.
OTHERS = (
    "Odometry",
    "PoseStamped",
    "PoseWithCovarianceStamped",
    "TransformStamped",
    "QuaternionStamped",
    "Vector3Stamped",
)
#: Metadata of a ROS 2 bag's folder.
METADATA = "metadata.yaml"
WHAT = "ROS bag"
IDENTITY = (1.0, 0.0, 0.0, 0.0)


def sniff(source: Source) -> bool:
    """Whether a file is a bag or MCAP, or a folder has the metadata of a ROS 2 bag."""
    if source.names:
        return METADATA in source.names and any(
            name.endswith((".db3", ".mcap", ".db3.zstd", ".mcap.zstd")) for name in source.names
        )
    return source.head.startswith((ROS1, MCAP)) or (
        source.head.startswith(SQLITE) and source.name.lower().endswith(".db3")
    )


@contextlib.contextmanager
def _opened(source: Source) -> Iterator[Any]:
    """The bag, with the definitions of ROS 2 where it has none of its own."""
    highlevel = require("rosbags.highlevel", extra="ros")
    typesys = require("rosbags.typesys", extra="ros")
    with source.folder() if source.names else _named_file(source) as path, understood(WHAT):
        store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        with highlevel.AnyReader([path], default_typestore=store) as bag:
            yield bag


@contextlib.contextmanager
def _named_file(source: Source) -> Iterator[Path]:
    """The file under a name that ends as rosbags expects."""
    ending = ".bag" if source.head.startswith(ROS1) else ".mcap" if source.head.startswith(MCAP) else ".db3"
    with source.file() as path:
        if path.suffix == ending:
            yield path
        else:
            with Source(f"bag{ending}", content=path.read_bytes()).file() as renamed:
                yield renamed


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read all IMU topics of a bag, or the one that is asked for."""
    with _opened(source) as bag:
        topics = _topics(bag)
        imus = [topic for topic, kind in topics.items() if kind == IMU]
        wanted = {topic: kind for topic, kind in topics.items() if _is_wanted(topic, kind, options.sensor, imus)}
        read = {topic: _read(bag, topic, kind) for topic, kind in wanted.items()}
        found = {topic: messages for topic, messages in read.items() if messages is not None}
        sensors = _joined(found, topics, options.sensor)
        if not sensors:
            listed = ", ".join(f"{one.topic} ({one.msgtype})" for one in bag.connections)
            raise refuse(f"has no messages of sensor_msgs/Imu and MagneticField, only {shortened(listed)}")
        others = sorted({f"{one.topic} ({one.msgtype})" for one in bag.connections if one.msgtype.endswith(OTHERS)})
        for data in sensors.values():
            if others:
                data.say("ignored", f"topics {', '.join(others)}")
    return sensors


def _topics(bag: Any) -> dict[str, str]:
    """Topic -> its message, of those that are read."""
    return {one.topic: one.msgtype for one in bag.connections if one.msgtype == IMU or one.msgtype in COMPANIONS}


def _is_wanted(topic: str, kind: str, sensor: str | None, imus: list[str]) -> bool:
    return sensor is None or sensor not in imus or kind != IMU or topic == sensor


class _Messages:
    """What the messages of a topic hold, row by row."""

    def __init__(self) -> None:
        self.stamps: list[int] = []
        self.recorded: list[int] = []
        self.rows: list[tuple[float, ...]] = []
        self.frame = ""
        self.without: set[str] = set()
        self.unturned = False
        self.stated = 0

    def arrays(self) -> tuple[Any, Any]:
        """Stamps (ns) and rows."""
        stamps = np.array(self.stamps, dtype=np.int64)
        rows = np.array(self.rows, dtype=np.float64)
        return stamps, rows


def _read(bag: Any, topic: str, kind: str) -> _Messages | None:
    out = _Messages()
    connections = [one for one in bag.connections if one.topic == topic and one.msgtype == kind]
    out.stated = sum(one.msgcount for one in connections)
    for connection, recorded, raw in bag.messages(connections):
        message = bag.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        out.stamps.append(int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec))
        out.recorded.append(int(recorded))
        if not out.frame:
            out.frame = str(message.header.frame_id)
        out.rows.append(_imu_row(message, out) if kind == IMU else _row(message, kind))
    return out if out.rows else None


def _imu_row(message: Any, out: _Messages) -> tuple[float, ...]:
    w, a, q = message.angular_velocity, message.linear_acceleration, message.orientation
    for name, covariance in (
        ("gyr", message.angular_velocity_covariance),
        ("acc", message.linear_acceleration_covariance),
        ("device_quat", message.orientation_covariance),
    ):
        if covariance[0] == -1.0:
            out.without.add(name)
    return (w.x, w.y, w.z, a.x, a.y, a.z, q.w, q.x, q.y, q.z)


def _row(message: Any, kind: str) -> tuple[float, ...]:
    value = getattr(message, COMPANIONS[kind][1])
    return (value.x, value.y, value.z) if kind == FIELD else (float(value),)


def _joined(found: dict[str, _Messages], topics: dict[str, str], sensor: str | None) -> dict[str, SensorData]:
    """Sensors with what belongs to them; magnetometers that belong to none are sensors of their own."""
    imus = {topic: messages for topic, messages in found.items() if topics[topic] == IMU}
    owners: dict[str, list[str]] = {topic: [] for topic in imus}
    alone: dict[str, list[str]] = {}
    for topic in found:
        if topics[topic] == IMU:
            continue
        alike = [one for one in found if topics[one] == topics[topic]]
        free = [
            one for one in _owners(topic, found[topic], imus, alike) if _is_free(topics[topic], owners[one], topics)
        ]
        for owner in free:
            owners[owner].append(topic)
        if not free and topics[topic] == FIELD:
            alone[topic] = []
    parts = owners | alone
    if sensor in parts:
        parts = {sensor: parts[sensor]}
    return {topic: _data(topic, others, found, topics) for topic, others in parts.items()}


def _is_free(kind: str, taken: list[str], topics: dict[str, str]) -> bool:
    """Whether an IMU has no topic of this kind yet."""
    return kind not in {topics[one] for one in taken}


def _owners(topic: str, messages: _Messages, imus: dict[str, _Messages], alike: list[str]) -> list[str]:
    """The IMUs that a topic belongs to: of the same frame, else of the same namespace, else the only one.

    Raw and filtered readings of one device are two topics with one magnetometer.
    """
    same = [one for one, other in imus.items() if other.frame == messages.frame and messages.frame]
    space = topic.rpartition("/")[0]
    near = [one for one in imus if space and one.rpartition("/")[0] == space]
    return same or near or (list(imus) if len(imus) == 1 and len(alike) == 1 else [])


def _data(topic: str, others: list[str], found: dict[str, _Messages], topics: dict[str, str]) -> SensorData:
    data = SensorData(streams={}, meta={"units": {}, "columns": {}})
    stamps: dict[str, Any] = {}
    values: dict[str, Any] = {}
    for one in [topic, *others]:
        messages = found[one]
        ns, rows = messages.arrays()
        if not ns.any():
            ns = np.array(messages.recorded, dtype=np.int64)
            data.say("assumed", f"{one}: header.stamp is empty, so times are those of the recording")
        parts = _imu_parts(messages, rows) if topics[one] == IMU else _companion(topics[one], rows)
        if messages.stated > len(ns):
            data.say("lost", f"{one}: {messages.stated - len(ns)} of {messages.stated} messages that the index counts")
        if messages.unturned:
            data.say("ignored", f"{one}: orientation, which is the identity in all messages")
        for stream, part in parts.items():
            stamps[stream], values[stream] = ns, part
            data.meta["columns"][stream] = [one]
    times, origin = seconds(stamps, 1e-9)
    shared = {id(ns): times[stream] for stream, ns in reversed(stamps.items())}
    data.streams = {stream: (shared[id(stamps[stream])], values[stream]) for stream in values}
    units = {"gyr": "rad/s", "acc": "m/s²", "mag": "tesla", "pressure": "Pa", "temperature": "°C"}
    data.meta["units"] = {stream: unit for stream, unit in units.items() if stream in values}
    data.meta["clock"] = "header.stamp"
    data.meta["axes"] = f"of the frame {found[topic].frame!r}" if found[topic].frame else "of a frame without a name"
    start = utc(origin)
    if start:
        data.meta["start"] = start
    if "device_quat" in values:
        data.meta["device_frame"] = "ENU"
    return data


def _imu_parts(messages: _Messages, rows: Any) -> dict[str, Any]:
    parts = {"gyr": rows[:, :3], "acc": rows[:, 3:6], "device_quat": _attitude.recorded(rows[:, 6:])}
    if np.isnan(parts["device_quat"]).all():
        del parts["device_quat"]
    elif (
        "device_quat" not in messages.without and len(rows) > 1 and (rows[:, 6:] == IDENTITY).all()
    ):  # a driver that fills in no orientation
        messages.without.add("device_quat")
        messages.unturned = True
    return {stream: part for stream, part in parts.items() if stream not in messages.without}


def _companion(kind: str, rows: Any) -> dict[str, Any]:
    stream, _, factor = COMPANIONS[kind]
    return {stream: (rows if rows.shape[1] > 1 else rows[:, 0]) * factor}


def sensors(source: Source, options: Options) -> list[SensorInfo]:
    """The IMU topics of a bag (without one: its magnetometers), from its index.

    What else belongs to a sensor is known from the messages only, unless there is one IMU.
    """
    with _opened(source) as bag:
        duration = bag.duration / 1e9
        kinds = _topics(bag)
        counts = {topic: sum(one.msgcount for one in bag.connections if one.topic == topic) for topic in kinds}
        imus = [topic for topic, kind in kinds.items() if kind == IMU]
        streams: dict[str, dict[str, int | None]] = {
            topic: dict.fromkeys(("gyr", "acc"), counts[topic]) for topic in imus
        }
        for topic, kind in kinds.items():
            stream = COMPANIONS[kind][0] if kind != IMU else ""
            if stream and len(imus) == 1:
                streams[imus[0]].setdefault(stream, counts[topic])
            elif kind == FIELD:
                streams[topic] = {"mag": counts[topic]}
        return [SensorInfo(topic, samples, {one: _rate(count, duration) for one, count in samples.items()})
                for topic, samples in streams.items()]  # fmt: skip


def _rate(count: int | None, duration: float) -> float | None:
    return (count - 1) / duration if count is not None and count > 1 and duration > 0 else None
