"""PX4 ULog, version 1, by its specification (docs.px4.io, "ULog File Format")."""

from __future__ import annotations

import struct
from collections.abc import Iterable

MAGIC = b"\x55\x4c\x6f\x67\x01\x12\x35"

#: Topic -> its fields as in PX4's message definitions, without padding.
TOPICS = {
    "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
    "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;",
    "sensor_gyro": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
    "float temperature;",
    "sensor_accel": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
    "float temperature;",
    "sensor_mag": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
    "float temperature;",
    "vehicle_magnetometer": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float[3] magnetometer_ga;",
    "vehicle_attitude": "uint64_t timestamp;float[4] q;",
}
#: Topic -> the struct code of one message.
_CODES = {
    "sensor_combined": "<Q3fIi3fI",
    "sensor_gyro": "<QQI4f",
    "sensor_accel": "<QQI4f",
    "sensor_mag": "<QQI4f",
    "vehicle_magnetometer": "<QQI3f",
    "vehicle_attitude": "<Q4f",
}


def message(kind: str, payload: bytes) -> bytes:
    """One message: length, type, payload."""
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def log(
    rows: Iterable[tuple[str, int, tuple[float, ...]]], start: int = 0, dropouts: Iterable[tuple[int, int]] = ()
) -> bytes:
    """A log of rows (topic, instance, values), in the order given.

    `dropouts` are (index of the row before which it stands, duration in ms).
    """
    rows = list(rows)
    out = [MAGIC, struct.pack("<BQ", 1, start), message("B", bytes(40))]
    used = list(dict.fromkeys((topic, instance) for topic, instance, _ in rows))
    for topic in dict.fromkeys(topic for topic, _ in used):
        out.append(message("F", f"{topic}:{TOPICS[topic]}".encode()))
    key = b"char[3] sys_name"
    out.append(message("I", bytes([len(key)]) + key + b"PX4"))
    ids = {}
    for number, (topic, instance) in enumerate(used):
        ids[topic, instance] = number
        out.append(message("A", struct.pack("<BH", instance, number) + topic.encode()))
    lost = dict(dropouts)
    for index, (topic, instance, values) in enumerate(rows):
        if index in lost:
            out.append(message("O", struct.pack("<H", lost[index])))
        payload = struct.pack("<H", ids[topic, instance]) + struct.pack(_CODES[topic], *values)
        out.append(message("D", payload))
    return b"".join(out)
