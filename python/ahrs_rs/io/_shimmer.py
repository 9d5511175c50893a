"""Shimmer3 (ConsensysPRO, Consensys, Shimmer Connect): CSV with the names of the signals over a line of units.

"sep=,", then names such as Shimmer_5E90_Accel_LN_X_CAL, then units, each line ending in a separator; older ones have
the device, signal, CAL or RAW and unit in four lines. Only calibrated signals are taken. Times are ms of the device's
clock (32768 Hz: a "100 Hz" recording has 99.90 Hz).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs.io import _attitude
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import Table, cells, head_lines, is_number, is_text, read_table, separator_of
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import seconds, utc

#: Signal, as its name without device, axis and CAL in lower case -> stream. The order is that of preference.
SIGNALS = {
    "accel_ln": "acc",
    "accel_wr": "acc",
    "accel_mpu": "acc",
    "low_noise_accelerometer": "acc",
    "wide_range_accelerometer": "acc",
    "accelerometer": "acc",
    "accel": "acc",
    "gyro": "gyr",
    "gyroscope": "gyr",
    "mag": "mag",
    "magnetometer": "mag",
    "mag_wr": "mag",
    "mag_mpu": "mag",
    "wide_range_magnetometer": "mag",
}
#: Clocks, in the order of preference.
CLOCKS = (
    "timestamp_shimmer",
    "timestamp",
    "timestamp_unix",
    "timestamp_sync",
    "timestamp_syncunix",
    "system_timestamp",
)
QUATERNIONS = ("quat_mpu_9dof", "quat_madge_9dof", "quat_mpu_6dof", "quat_madge_6dof", "quaternion")
#: Unit, letters and digits only -> factor to SI.
UNITS = {
    "acc": {"ms2": 1.0, "msec2": 1.0, "msecs2": 1.0, "g": GRAVITY},
    "gyr": {"degs": np.pi / 180.0, "degsec": np.pi / 180.0, "degreess": np.pi / 180.0, "rads": 1.0},
    "mag": {"localflux": 1.0, "nounits": 1.0, "nounit": 1.0, "ut": 1.0, "gauss": 100.0, "mgauss": 0.1, "nt": 1e-3},
    "time": {"ms": 1e-3, "msecs": 1e-3, "mseconds": 1e-3, "s": 1.0, "us": 1e-6},
}
#: Units of a magnetometer that tell its direction only.
DIRECTIONS = ("localflux", "nounits", "nounit")
#: A low-noise accelerometer (±2 g) that reaches this part of 2 g has clipped, m/s².
CLIPPED = 0.98 * 2 * GRAVITY

_NAME = re.compile(
    r"(?P<device>shimmer_[0-9a-z]{1,12}?_|[^_]*?shimmer[^_]*_)?(?P<signal>.+?)(_(?P<axis>[xyzw]))?", re.I
)


@dataclass(slots=True)
class _Column:
    index: int
    name: str
    device: str
    signal: str
    axis: str
    form: str  # "cal", "raw", ""
    unit: str


def sniff(source: Source) -> bool:
    """Whether the first lines name signals of a Shimmer with CAL or RAW."""
    if not is_text(source.head):
        return False
    text = "\n".join(head_lines(source.head)[:6]).lower()
    return "shimmer" in text and re.search(r"(_|[\t,;\"])\s*(cal|raw|uncal)\b", text) is not None


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read all devices of the file."""
    content = source.read()
    lines = head_lines(content)
    start = 1 if lines[0].strip().strip('"').lower().startswith("sep=") else 0
    if start >= len(lines):
        raise ValueError("has no header")
    separator = separator_of(lines[start])
    first = next((i for i in range(start, len(lines)) if _is_row(cells(lines[i], separator))), None)
    if first is None or first == start:
        raise ValueError("has names of Shimmer's signals, but no rows of numbers below them")
    columns = _columns([cells(line, separator) for line in lines[start:first]])
    calibrated = [column for column in columns if column.form != "raw"]
    streams = {
        name: _streams([c for c in calibrated if c.device == name]) for name in dict.fromkeys(c.device for c in columns)
    }
    streams = {name: found for name, found in streams.items() if found}
    if not streams:
        raise ValueError(
            "has no calibrated acceleration, angular rate or field (CAL): export calibrated data from Consensys"
        )
    wanted = [column.index for found in streams.values() for group in found.values() for column in group]
    clocks = {name: _clock(calibrated, columns, name) for name in streams}
    wanted += [column.index for found in clocks.values() for column in found]
    names = [column.name for column in columns]
    table = read_table(content, first, names, wanted, separator)
    return {name.strip("_") or "imu": _sensor(table, found, clocks[name], columns) for name, found in streams.items()}


def _is_row(row: Sequence[str]) -> bool:
    numbers = [is_number(cell) for cell in row if cell]
    return len(numbers) > 1 and sum(numbers) > len(numbers) / 2


def _columns(header: list[list[str]]) -> list[_Column]:
    """What the header's one to four lines say of each column."""
    width = max(len(line) for line in header)
    found = []
    for index in range(width):
        parts = [line[index] if index < len(line) else "" for line in header]
        form, unit = "", ""
        names: list[str] = []
        for part in parts:
            key = part.lower()
            if key in ("cal", "raw", "uncal"):
                form = "raw" if key != "cal" else "cal"
            elif names and _unit_key(part) in _KNOWN_UNITS:
                unit = part
            elif part:
                names.append(part)
        name = re.sub(r"[^A-Za-z0-9]+", "_", "_".join(names)).strip("_")
        ending = re.search(r"_(cal|raw|uncal)$", name, re.I)
        if ending:
            form, name = ("cal" if ending[1].lower() == "cal" else "raw"), name[: ending.start()]
        match = _NAME.fullmatch(name)
        device, signal, axis = (
            (match["device"] or "", match["signal"], match["axis"] or "") if match else ("", name, "")
        )
        found.append(_Column(index, "_".join(names), device, signal.lower(), axis.lower(), form, unit))
    return found


def _unit_key(unit: str) -> str:
    return re.sub(r"[^a-z0-9]", "", unit.lower().replace("µ", "u").replace("²", "2"))


_KNOWN_UNITS = {name for group in UNITS.values() for name in group} | {
    *(
        "u",
        "kpa",
        "degreescelsius",
        "degc",
        "mv",
        "kohms",
        "celcius",
        "unitless",
        "noscale",
        "kohm",
        "usiemens",
        "percent",
    ),
}


def _streams(columns: list[_Column]) -> dict[str, list[_Column]]:
    """Stream -> its three columns (four of an orientation); a second accelerometer is acc_<its name>."""
    found: dict[str, list[_Column]] = {}
    for signal, stream in SIGNALS.items():
        group = [c for axis in "xyz" for c in columns if c.signal == signal and c.axis == axis]
        if len(group) == 3:
            found[stream if stream not in found else f"{stream}_{signal}"] = group
    for signal in QUATERNIONS if found else ():
        group = [c for axis in "wxyz" for c in columns if c.signal == signal and c.axis == axis]
        if len(group) == 4 and "device_quat" not in found:
            found["device_quat"] = group
    return found


def _clock(calibrated: list[_Column], columns: list[_Column], device: str) -> list[_Column]:
    """The device's clock, in calibrated units, and the one since 1970 where there is one."""
    own = [c for c in calibrated if c.device == device] + [c for c in calibrated if c.device != device]
    ordered = [c for name in CLOCKS for c in own if c.signal == name and c.unit.lower() != "no_units"]
    if not ordered:
        raw = [c.name for c in columns if c.signal.startswith("timestamp")]
        raise ValueError(f"has no calibrated time stamp, only {raw}: export it from Consensys with calibrated time")
    unix = [c for c in ordered[1:] if "unix" in c.signal]
    return [ordered[0], *unix[:1]]


def _sensor(table: Table, found: dict[str, list[_Column]], clock: list[_Column], columns: list[_Column]) -> SensorData:
    data = SensorData(streams={}, meta={"repairs": list(table.repairs), "units": {}, "columns": {}})
    t = _times(table, clock, data)
    for stream, group in found.items():
        values = table.vectors([column.index for column in group])
        data.meta["columns"][stream] = [column.name for column in group]
        if stream == "device_quat":
            data.streams[stream] = (t, _attitude.recorded(values))
            data.meta["device_frame"] = "z up"
            continue
        quantity, unit = stream.partition("_")[0], group[0].unit
        if len({_unit_key(column.unit) for column in group}) > 1:
            raise ValueError(f"columns {[c.name for c in group]}: units differ among axes, {[c.unit for c in group]}")
        factor = UNITS[quantity].get(_unit_key(unit))
        if factor is None:
            known = ", ".join(UNITS[quantity])
            raise ValueError(f"column {group[0].name!r}: unknown unit {unit!r}; known are {known}")
        data.meta["units"][stream] = "normalised" if _unit_key(unit) in DIRECTIONS and quantity == "mag" else unit
        data.streams[stream] = (t, values * factor)
    _choose_accelerometer(data)
    raw = sorted({column.signal for column in columns if column.form == "raw" and column.signal in SIGNALS})
    if raw:
        data.say("ignored", f"uncalibrated signals: {', '.join(raw)}")
    return data


def _times(table: Table, clock: list[_Column], data: SensorData) -> FloatArray:
    first = clock[0]
    unit = UNITS["time"].get(_unit_key(first.unit), 1e-3)
    if not first.unit:
        data.say("assumed", f"{first.name} is in ms")
    times, origin = seconds({"t": table.columns[first.index]}, unit)
    data.meta["clock"] = f"{first.name}, of the device"
    since_1970 = utc(origin)
    if since_1970 is None and len(clock) > 1:
        unix = np.asarray(table.columns[clock[1].index], dtype=np.float64)
        known = np.flatnonzero(np.isfinite(unix) & np.isfinite(times["t"]))
        if known.size:
            since_1970 = utc(unix[known[0]] * 1e-3 - times["t"][known[0]])
    if since_1970:
        data.meta["start"] = since_1970
    return times["t"]


def _choose_accelerometer(data: SensorData) -> None:
    """The low-noise accelerometer, or the wide-range one where that has clipped."""
    second = next((name for name in data.streams if name.startswith("acc_")), None)
    if second is None:
        return
    low = data.streams["acc"][1]
    if np.nanmax(np.abs(low), initial=0.0) >= CLIPPED and "wr" in second.replace("wide_range", "wr"):
        data.streams["acc_low_noise"], data.streams["acc"] = data.streams["acc"], data.streams.pop(second)
        for kept in ("columns", "units"):
            data.meta[kept]["acc_low_noise"], data.meta[kept]["acc"] = (
                data.meta[kept]["acc"],
                data.meta[kept].pop(second),
            )
        data.say(
            "assumed",
            "of two accelerometers acc is the wide-range one, as the low-noise one (acc_low_noise) has clipped",
        )
    else:
        data.say(
            "assumed",
            f"of two accelerometers acc is {data.meta['columns']['acc'][0]} ...; the other is the stream {second}",
        )
