"""PX4's ULog, through pyulog.

`sensor_combined` (gyroscope and accelerometer in the vehicle's frame, front-right-down) with the magnetometer of
vehicle_magnetometer and the attitude of vehicle_attitude (to north-east-down) is what is read; the single sensors
(sensor_gyro, sensor_accel, sensor_mag with their instances) are read by ``sensor="sensor_0"``, "sensor_1", ... Times
are µs since the board started, those of the sample where the topic has them.
"""

from __future__ import annotations

import io
import mmap
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData, SensorInfo, require
from ahrs_rs.io._library import quiet, refuse, understood
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

MAGIC = b"\x55\x4c\x6f\x67\x01\x12\x35"
#: Topics that are loaded; all others are passed over.
COMBINED = ("sensor_combined", "vehicle_magnetometer", "vehicle_attitude", "vehicle_air_data", "vehicle_local_position")
SINGLE = {"gyr": "sensor_gyro", "acc": "sensor_accel", "mag": "sensor_mag"}
#: What sensor_combined says where the accelerometer has no new sample.
NO_SAMPLE = 2147483647
GAUSS = 100.0  # µT
AXES, FRAME = "front-right-down", "NED"
#: Bytes before each message, and so many messages may be read anew after damage.
HEADER, ROUNDS = 3, 100_000
#: How the sensor is called that most logs have.
MAIN = "sensor_combined"


def sniff(source: Source) -> bool:
    """Whether the file begins as ULog does."""
    return source.head.startswith(MAGIC)


class _CirclesError(Exception):
    """No ValueError, which pyulog would pass over."""


class _Watched(io.BytesIO):
    """A file that remembers whether it ended within what was asked for, and ends a reader that goes round in circles.

    pyulog passes over the first in silence. At some damage it seeks back for ever; it reads 3 bytes for each
    message, and such reads that get no further are counted.
    """

    cut = False
    _last = _furthest = _idle = 0

    def read(self, size: int | None = -1, /) -> bytes:
        at, data = self.tell(), super().read(size)
        if size == HEADER:
            self._idle = 0 if at > self._furthest else self._idle + 1
            self._furthest = max(self._furthest, at)
            if self._idle > ROUNDS:
                raise _CirclesError
        if size is not None and 0 <= size != len(data) and (data or self._last == HEADER):
            self.cut = self.cut or not (size == HEADER and not data)
        self._last = size or 0
        return data


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a log: sensor_combined, and all single sensors, or the one that is asked for."""
    pyulog = require("pyulog", extra="px4")
    file = _Watched(source.read())
    topics = [*COMBINED, *SINGLE.values()]
    with understood("ULog file"), quiet() as printed:
        try:
            log = pyulog.ULog(file, topics)
        except _CirclesError:
            raise refuse("is a damaged ULog file: pyulog does not get past the damage") from None
        found = {(one.name, one.multi_id): one.data for one in log.data_list}
        sensors = _sensors(found)
        if not sensors:
            raise refuse("is a ULog without sensor_combined, sensor_gyro, sensor_accel and sensor_mag")
        for data in sensors.values():
            data.meta["info"] = {
                key: str(value) for key, value in log.msg_info_dict.items() if key.startswith(("ver_", "sys_"))
            }
            if log.dropouts:
                lost = sum(one.duration for one in log.dropouts) / 1e3
                data.say(
                    "lost", f"{len(log.dropouts)} drop-outs of the logger, {lost:g} s in all; they are gaps in time"
                )
            if log.file_corruption or "corrupt" in printed.getvalue():
                data.say("lost", "the file is damaged in places; what lies between them was read")
            if file.cut:
                data.say("lost", "the file is cut off; what came before was read")
    return sensors


def _sensors(found: dict[tuple[str, int], dict[str, NDArray[Any]]]) -> dict[str, SensorData]:
    sensors = {}
    if (MAIN, 0) in found:
        sensors[MAIN] = _combined(found)
    instances = sorted({instance for topic, instance in found if topic in SINGLE.values()})
    for instance in instances:
        sensors[f"sensor_{instance}"] = _single(found, instance)
    return {name: data for name, data in sensors.items() if data.streams}


def _combined(found: dict[tuple[str, int], dict[str, NDArray[Any]]]) -> SensorData:
    topic = found[MAIN, 0]
    stamps: dict[str, NDArray[Any]] = {"gyr": topic["timestamp"]}
    values: dict[str, Any] = {"gyr": _vector(topic, "gyro_rad")}
    columns = {"gyr": [f"{MAIN}.gyro_rad"]}
    stamps["acc"], values["acc"], missing = _relative(topic, "accelerometer", "accelerometer_m_s2")
    columns["acc"] = [f"{MAIN}.accelerometer_m_s2"]
    if "magnetometer_ga[0]" in topic:  # before PX4 1.7: in the same topic
        stamps["mag"], gauss, _ = _relative(topic, "magnetometer", "magnetometer_ga")
        values["mag"], columns["mag"] = gauss * GAUSS, [f"{MAIN}.magnetometer_ga"]
    elif ("vehicle_magnetometer", 0) in found:
        field = found["vehicle_magnetometer", 0]
        stamps["mag"], values["mag"] = _sampled(field), _vector(field, "magnetometer_ga") * GAUSS
        columns["mag"] = ["vehicle_magnetometer.magnetometer_ga"]
    if ("vehicle_attitude", 0) in found:
        attitude = found["vehicle_attitude", 0]
        stamps["device_quat"] = _sampled(attitude)
        values["device_quat"] = _attitude.recorded(_vector(attitude, "q", 4))
    if ("vehicle_air_data", 0) in found and "baro_pressure_pa" in found["vehicle_air_data", 0]:
        air = found["vehicle_air_data", 0]
        stamps["pressure"], values["pressure"] = _sampled(air), air["baro_pressure_pa"].astype(np.float64)
    if ("vehicle_local_position", 0) in found:
        position = found["vehicle_local_position", 0]
        stamps["velocity"] = stamps["heading"] = _sampled(position)
        values["velocity"] = np.column_stack([position[name].astype(np.float64) for name in ("vx", "vy", "vz")])
        if "heading" in position:
            values["heading"] = position["heading"].astype(np.float64)
        else:
            del stamps["heading"]
    data = _data(stamps, values, columns)
    if missing:
        data.meta["missing"] = {"acc": missing}
    if "device_quat" in values:
        data.meta["device_frame"] = FRAME
    return data


def _relative(topic: dict[str, NDArray[Any]], sensor: str, name: str) -> tuple[NDArray[Any], FloatArray, int]:
    """Stamps and values of a sensor within sensor_combined, and how many rows have no sample of it (NaN)."""
    values, stamps = _vector(topic, name), topic["timestamp"]
    relative = topic.get(f"{sensor}_timestamp_relative")
    if relative is None:
        return stamps, values, 0
    missing = relative == NO_SAMPLE
    values[missing] = np.nan
    offset = np.where(missing, 0, relative).astype(np.int64)
    return (stamps.astype(np.int64) + offset if offset.any() else stamps), values, int(missing.sum())


def _single(found: dict[tuple[str, int], dict[str, NDArray[Any]]], instance: int) -> SensorData:
    stamps, values, columns = {}, {}, {}
    for stream, name in SINGLE.items():
        if (name, instance) in found:
            topic = found[name, instance]
            scale = GAUSS if stream == "mag" else 1.0
            stamps[stream] = _sampled(topic)
            values[stream] = np.column_stack([topic[axis].astype(np.float64) for axis in "xyz"]) * scale
            columns[stream] = [f"{name}[{instance}]"]
    if "gyr" in values and "temperature" in found["sensor_gyro", instance]:
        stamps["temperature"] = stamps["gyr"]
        values["temperature"] = found["sensor_gyro", instance]["temperature"].astype(np.float64)
    data = _data(stamps, values, columns)
    data.meta["calibrated"] = False
    return data


def _data(stamps: dict[str, NDArray[Any]], values: dict[str, Any], columns: dict[str, list[str]]) -> SensorData:
    times, origin = seconds(stamps, 1e-6)
    shared = {
        id(stamp): times[name] for name, stamp in reversed(stamps.items())
    }  # streams of one clock share its array
    units = {"gyr": "rad/s", "acc": "m/s²", "mag": "gauss"}
    meta: dict[str, Any] = {
        "units": {name: unit for name, unit in units.items() if name in values},
        "columns": columns,
        "axes": AXES,
        "clock": "since the board started",
    }
    since_1970 = utc(origin)
    if since_1970:
        meta["start"], meta["clock"] = since_1970, "since 1970 (a simulation)"
    return SensorData({name: (shared[id(stamps[name])], values[name]) for name in values}, meta=meta)


def _vector(topic: dict[str, NDArray[Any]], name: str, size: int = 3) -> FloatArray:
    return np.column_stack([topic[f"{name}[{index}]"].astype(np.float64) for index in range(size)])


def _sampled(topic: dict[str, NDArray[Any]]) -> NDArray[Any]:
    """When the sample was taken, where the topic has it, or when it was published."""
    sampled = topic.get("timestamp_sample")
    return sampled if sampled is not None and (sampled > 0).all() else topic["timestamp"]


def sensors(source: Source, options: Options) -> list[SensorInfo]:
    """The sensors of a log, by a walk over its messages that reads no more of each than its head."""
    with source.file() as path:
        counted = _counted(path)
    if counted is None:  # damaged: what can be read tells
        return [_described(name, data) for name, data in load(source, options).items()]
    infos = []
    if (MAIN, 0) in counted:
        streams = {
            "gyr": (MAIN, 0),
            "acc": (MAIN, 0),
            "mag": ("vehicle_magnetometer", 0),
            "device_quat": ("vehicle_attitude", 0),
        }
        infos.append(_listed(MAIN, {name: counted[topic] for name, topic in streams.items() if topic in counted}))
    for instance in sorted({instance for topic, instance in counted if topic in SINGLE.values()}):
        parts = {name: counted[topic, instance] for name, topic in SINGLE.items() if (topic, instance) in counted}
        infos.append(_listed(f"sensor_{instance}", parts))
    if not infos:
        raise ValueError("is a ULog without sensor_combined, sensor_gyro, sensor_accel and sensor_mag")
    return infos


def _counted(path: Path) -> dict[tuple[str, int], tuple[int, int, int]] | None:
    """(topic, instance) -> messages, first and last stamp (µs); None of a log that is damaged."""
    ids: dict[int, tuple[str, int]] = {}
    counts: dict[int, list[int]] = {}
    wanted = {*COMBINED, *SINGLE.values()}
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        at, size = 16, len(content)
        while at + HEADER <= size:
            length, kind = _HEAD.unpack_from(content, at)
            start, at = at + HEADER, at + HEADER + length
            if not length or kind not in _KINDS:
                return None
            if at > size:
                break
            if kind == _DATA and length >= 10:
                number, stamp = _STAMPED.unpack_from(content, start)
                held = counts.get(number)
                if held is not None:
                    held[0] += 1
                    held[2] = stamp
                    if held[0] == 1:
                        held[1] = stamp
            elif kind == _ADDED:
                instance, number = _ADD.unpack_from(content, start)
                name = content[start + 3 : at].decode(errors="replace")
                if name in wanted:
                    ids[number], counts[number] = (name, instance), [0, 0, 0]
    return {ids[number]: (held[0], held[1], held[2]) for number, held in counts.items() if held[0]}


_HEAD, _STAMPED, _ADD = struct.Struct("<HB"), struct.Struct("<HQ"), struct.Struct("<BH")
_DATA, _ADDED, _KINDS = ord("D"), ord("A"), frozenset(b"FDIMPQARSOLCB")


def _listed(name: str, parts: dict[str, tuple[int, int, int]]) -> SensorInfo:
    samples = {stream: count for stream, (count, _, _) in parts.items()}
    rates = {
        stream: (count - 1) * 1e6 / (last - first) if last > first else None
        for stream, (count, first, last) in parts.items()
    }
    return SensorInfo(name, samples, rates)


def _described(name: str, data: SensorData) -> SensorInfo:
    spans = {stream: (len(t), float(t[0]), float(t[-1])) for stream, (t, _) in data.streams.items() if len(t)}
    rates = {stream: (n - 1) / (last - first) if last > first else None for stream, (n, first, last) in spans.items()}
    return SensorInfo(name, {stream: n for stream, (n, _, _) in spans.items()}, rates)
