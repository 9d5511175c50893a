"""ArduPilot's DataFlash log (.bin), through pymavlink.

pymavlink is under the LGPL: it is imported here, when such a log is read, and nowhere else. It finds the messages and
tells their formats; their numbers are taken from the file's bytes all at once. IMU messages rad/s and m/s², MAG
milligauss with the offsets applied, all in the vehicle's frame (front-right-down); ATT to north-east-down. TimeUS is
µs since the board started.
"""

from __future__ import annotations

import contextlib
import mmap
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData, SensorInfo, require
from ahrs_rs.io._library import quiet_native, refuse, understood
from ahrs_rs.io._source import Source

HEAD = b"\xa3\x95\x80"
AXES, FRAME = "front-right-down", "NED"
MILLIGAUSS = 0.1  # µT
GYR, ACC, MAG = ("GyrX", "GyrY", "GyrZ"), ("AccX", "AccY", "AccZ"), ("MagX", "MagY", "MagZ")
#: Messages of whole sensors, and of the raw samples at the sensor's rate (their time is SampleUS).
WHOLE, RAW = re.compile(r"IMU[23]?"), ("GYR", "ACC")


def sniff(source: Source) -> bool:
    """Whether the file begins with a DataFlash format message."""
    return source.head.startswith(HEAD)


class _Log:
    """Messages of a log as tables: name -> one array a column."""

    def __init__(self, path: str) -> None:
        reader = require("pymavlink.DFReader", extra="mavlink")
        # Without its search for the time of day, which goes through all messages where there is no GPS.
        indexed: Any = type("Indexed", (reader.DFReader_binary,), {"init_clock": lambda log: None})
        self._log = indexed.__new__(indexed)
        try:
            with quiet_native() as printed:
                self._log.__init__(path)
        except BaseException:
            self.close()
            raise
        self.damaged = any(word in printed.getvalue() for word in ("bad header", "unknown msg", "corrupt"))
        self._formats = {form.name: form for form in self._log.formats.values()}
        self.size = self._log.data_len

    def close(self) -> None:
        """Close the file, also where the library had opened it and then failed."""
        for name in ("filehandle", "data_map"):
            with contextlib.suppress(BufferError):  # a library that failed half-way may still look into the map
                if hasattr(self._log, name):
                    getattr(self._log, name).close()

    @property
    def cut(self) -> bool:
        """Whether the log ends within a message."""
        lengths = {form.type: form.len for form in self._formats.values()}
        ends = [found[-1] + lengths.get(kind, 0) for kind, found in enumerate(self._log.offsets) if len(found)]
        end = max(ends, default=0)
        return end > self.size or bytes(self._log.data_map[end : end + 2]) == HEAD[:2]

    def __contains__(self, name: str) -> bool:
        return name in self._formats and bool(self._log.counts[self._formats[name].type])

    def count(self, name: str) -> int:
        """How many messages of this name there are."""
        return int(self._log.counts[self._formats[name].type])

    def names(self) -> list[str]:
        """The messages that there are."""
        return [name for name in self._formats if name in self]

    def table(self, name: str) -> dict[str, NDArray[Any]]:
        """The columns of a message, with the factors of its format letters."""
        form = self._formats[name]
        offsets = np.array(self._log.offsets[form.type], dtype=np.int64)
        fields = np.dtype([(str(i), code) for i, code in enumerate(_codes(form))], align=False)
        offsets = offsets[offsets + 3 + fields.itemsize <= self.size]
        content = self._log.data_map
        held = (
            np.frombuffer(content, dtype=np.uint8)
            if isinstance(content, mmap.mmap)
            else np.frombuffer(bytes(content), np.uint8)
        )
        rows = (
            held[offsets[:, None] + (3 + np.arange(fields.itemsize))].view(fields)[:, 0]
            if len(offsets)
            else np.zeros(0, fields)
        )
        del held
        out: dict[str, NDArray[Any]] = {}
        for index, column in enumerate(form.columns):
            scale = form.msg_mults[index]
            values = rows[str(index)]
            out[column] = values if scale is None else values.astype(np.float64) * scale
        return out


def _codes(form: Any) -> list[str]:
    """numpy's type of each field."""
    codes = re.findall(r"\d*[a-zA-Z?]", form.msg_struct)
    if len(codes) != len(form.columns):
        raise refuse(f"is damaged: message {form.name} has {len(codes)} fields and {len(form.columns)} names")
    return [f"S{code[:-1]}" if code.endswith("s") else "<" + _NUMPY[code] for code in codes]


_NUMPY = {
    "b": "i1",
    "B": "u1",
    "h": "i2",
    "H": "u2",
    "i": "i4",
    "I": "u4",
    "q": "i8",
    "Q": "u8",
    "f": "f4",
    "d": "f8",
    "e": "f2",
}


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read all inertial sensors of a log, or the one that is asked for."""
    with source.file() as path, understood("DataFlash log"):
        log = _Log(str(path))
        try:
            sensors = _sensors(log, options.sensor)
            damaged, cut = log.damaged, log.cut
        finally:
            log.close()
    for data in sensors.values():
        if damaged:
            data.say("lost", "the log is damaged in places; what lies between them was read")
        if cut:
            data.say("lost", "the log is cut off within a message; what came before was read")
    return sensors


def _sensors(log: _Log, wanted: str | None) -> dict[str, SensorData]:
    sensors: dict[str, SensorData] = {}
    shared = _shared(log)
    for name in filter(WHOLE.fullmatch, log.names()):
        table = log.table(name)
        for label, rows in _instances(name, table):
            sensors[label] = _imu({column: values[rows] for column, values in table.items()}, name, shared)
    raw = {name: log.table(name) for name in RAW if name in log}
    for instance in sorted({int(one) for table in raw.values() for one in np.unique(table.get("I", 0))}):
        sensors[f"RAW{instance}"] = _raw(raw, instance, shared)
    if not sensors and shared:
        sensors["MAG"] = SensorData(dict(shared))
    if not sensors:
        raise refuse(f"is a DataFlash log without IMU, GYR, ACC and MAG messages, only {', '.join(log.names())}"[:300])
    for data in sensors.values():
        data.meta |= {"axes": AXES, "clock": "since the board started"}
        if "device_quat" in data.streams:
            data.meta["device_frame"] = FRAME
        if "ISBH" in log:
            data.say("ignored", "the batches of raw samples in ISBH and ISBD")
    return {wanted: sensors[wanted]} if wanted in sensors else sensors


def _instances(name: str, table: dict[str, NDArray[Any]]) -> list[tuple[str, Any]]:
    """(sensor's name, its rows) of the instances within a message; older logs have IMU, IMU2, IMU3 instead."""
    instance = table.get("I")
    if instance is None:
        return [(f"IMU{max(int(name[3:] or 1), 1) - 1}", slice(None))]
    return [(f"IMU{int(one)}", instance == one) for one in np.unique(instance)]


def _times(table: dict[str, NDArray[Any]]) -> FloatArray:
    for name, unit in (("SampleUS", 1e-6), ("TimeUS", 1e-6), ("TimeMS", 1e-3)):
        if name in table:
            return np.asarray(table[name], dtype=np.float64) * unit
    raise refuse("has messages without TimeUS and TimeMS")


def _vectors(table: dict[str, NDArray[Any]], names: tuple[str, ...]) -> FloatArray:
    return np.column_stack([np.asarray(table[name], dtype=np.float64) for name in names])


def _imu(table: dict[str, NDArray[Any]], name: str, shared: dict[str, tuple[Any, Any]]) -> SensorData:
    t = _times(table)
    streams: dict[str, tuple[Any, Any]] = {"gyr": (t, _vectors(table, GYR)), "acc": (t, _vectors(table, ACC))}
    if "T" in table:
        streams["temperature"] = (t, np.asarray(table["T"], dtype=np.float64))
    units = {"gyr": "rad/s", "acc": "m/s²"} | ({"mag": "milligauss"} if "mag" in shared else {})
    columns = {"gyr": [f"{name}.{axis}" for axis in GYR], "acc": [f"{name}.{axis}" for axis in ACC]}
    return SensorData(streams | shared, meta={"units": units, "columns": columns})


def _raw(raw: dict[str, dict[str, NDArray[Any]]], instance: int, shared: dict[str, tuple[Any, Any]]) -> SensorData:
    streams: dict[str, tuple[Any, Any]] = {}
    for stream, name, axes in (("gyr", "GYR", GYR), ("acc", "ACC", ACC)):
        if name in raw:
            rows = raw[name].get("I", np.zeros(len(raw[name][axes[0]]))) == instance
            table = {column: values[rows] for column, values in raw[name].items()}
            if rows.any():
                streams[stream] = (_times(table), _vectors(table, axes))
    units = {"gyr": "rad/s", "acc": "m/s²"} | ({"mag": "milligauss"} if "mag" in shared else {})
    return SensorData(streams | shared, meta={"units": units, "columns": {"gyr": ["GYR"], "acc": ["ACC"]}})


def _shared(log: _Log) -> dict[str, tuple[Any, Any]]:
    """What belongs to the vehicle: the fields of its magnetometers, its attitude, its barometer, its velocity."""
    streams: dict[str, tuple[Any, Any]] = {}
    for name in ("MAG", "MAG2", "MAG3"):
        if name in log:
            table = log.table(name)
            parts = (
                [(int(one), table["I"] == one) for one in np.unique(table["I"])] if "I" in table else [(0, slice(None))]
            )
            for one, rows in parts:
                stream = "mag" if "mag" not in streams else f"mag_{one or name[3:]}"
                part = {column: values[rows] for column, values in table.items()}
                streams[stream] = (_times(part), _vectors(part, MAG) * MILLIGAUSS)
    if "ATT" in log:
        table = log.table("ATT")
        roll, pitch, yaw = (np.radians(np.asarray(table[name], dtype=np.float64)) for name in ("Roll", "Pitch", "Yaw"))
        streams["device_quat"] = (_times(table), _attitude.from_euler(roll, pitch, yaw))
    if "BARO" in log:
        table = log.table("BARO")
        rows = table["I"] == table["I"].min() if "I" in table and len(table["I"]) else slice(None)
        part = {column: values[rows] for column, values in table.items()}
        if "Press" in part:
            streams["pressure"] = (_times(part), np.asarray(part["Press"], dtype=np.float64))
    if "XKF1" in log and {"VN", "VE", "VD"} <= set(table := log.table("XKF1")):
        rows = table["C"] == 0 if "C" in table else slice(None)
        part = {column: values[rows] for column, values in table.items()}
        streams["velocity"] = (_times(part), _vectors(part, ("VN", "VE", "VD")))
    return streams


def sensors(source: Source, options: Options) -> list[SensorInfo]:
    """The inertial sensors of a log, from the index of its messages."""
    with source.file() as path, understood("DataFlash log"):
        log = _Log(str(path))
        try:
            found = _sensors(log, None)
        finally:
            log.close()
    infos = []
    for name, data in found.items():
        samples = {stream: len(values) for stream, (_, values) in data.streams.items()}
        rates = {stream: _rate(t) for stream, (t, _) in data.streams.items()}
        infos.append(SensorInfo(name, samples, rates))
    return infos


def _rate(t: FloatArray) -> float | None:
    return float((len(t) - 1) / (t[-1] - t[0])) if len(t) > 1 and t[-1] > t[0] else None
