"""The phone app phyphox: a zip or folder with a CSV file an input, or one of these files.

Separated by comma, tab or semicolon, with a decimal point or comma, "Time (s)" and names with units. "Linear
Acceleration" is without gravity, "Acceleration" with it. Where inputs of different rates share a table, the shorter
columns end in NaN or in nothing.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._lines import NamedTable, cells, head_lines, header_of, is_number, is_text, read_named, separator_of
from ahrs_rs.io._source import Source
from ahrs_rs.io._stamps import utc

#: Stream -> what a name of its columns matches (several languages), and the unit. Tried in this order.
STREAMS: dict[str, tuple[re.Pattern[str], str]] = {
    "linear_acceleration": (
        re.compile(r"(linear|lineal|lin[ée]aire).*[xyz]\b|.*ohne g.*[xyz]\b|.*without g.*[xyz]\b", re.I),
        "m/s^2",
    ),
    "acc": (
        re.compile(r"(acc|accel|beschleunigung|acc[ée]l[ée]ration|aceleraci[oó]n|accelerazione).*[xyz]\b", re.I),
        "m/s^2",
    ),
    "gyr": (re.compile(r".*[xyz]\b", re.I), "rad/s"),
    "mag": (re.compile(r".*[xyz]\b", re.I), "uT"),
    "pressure": (re.compile(r".*", re.I), "hPa"),
}
FACTORS = {"pressure": 100.0}
#: The norm of a vector, beside its axes.
_NORM = re.compile(r"(absolut|absolute|total|betrag|valeur absolue|absoluto|assoluta)", re.I)
_TIME = re.compile(r"(time|zeit|temps|tiempo|tempo|t)\b.*\(s\)", re.I)


def sniff(source: Source) -> bool:
    """Whether a folder has phyphox's meta files, or the columns are called as it calls them."""
    if source.names:
        if "meta/device.csv" in source.names:
            return True
        return any(
            _is_table(header_of(source.read(name, 4096))) for name in source.names if name.lower().endswith(".csv")
        )
    return is_text(source.head) and _is_table(header_of(source.head))


def _is_table(names: list[str]) -> bool:
    """Whether the first column is a time in s, and all others are axes that the app records, or their norm."""
    if not names or not _TIME.fullmatch(names[0]):
        return False
    known = {column for columns in _streams(names).values() for column in columns}
    return bool(known) and all(name in known or not name or _NORM.match(name) for name in names[1:])


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read the phone's sensors."""
    files = [name for name in source.names if name.lower().endswith(".csv") and not name.startswith("meta/")]
    data = SensorData(
        streams={}, meta={"repairs": [], "units": {}, "columns": {}, "clock": "since the experiment started"}
    )
    data.meta["axes"] = "of the phone: x to the right, y to the top, z out of the screen"
    for file in files or [""]:
        names = header_of(source.read(file or None, 4096) if file else source.head)
        found = _streams(names) if names and _TIME.fullmatch(names[0]) else {}
        if not found:
            if any("(m/s^2)" in name or "(rad/s)" in name for name in names):
                data.say("ignored", f"{file or source.name}: {', '.join(names)}")
            continue
        try:
            table = read_named(source.read(file or None))
        except ValueError as error:
            if "no rows" in str(error) and file:
                continue
            raise ValueError(f"{file}: {error}" if file else str(error)) from error
        _add(table, found, names[0], file, data)
    if not data.streams:
        raise ValueError(
            f"has no acceleration, angular rate or field, only {', '.join(files or header_of(source.head))}"[:300]
        )
    if "acc" not in data.streams and "linear_acceleration" in data.streams:
        data.say(
            "doubts",
            "acceleration is there without gravity only (linear_acceleration): record Acceleration (with g) too",
        )
    data.meta |= _events(source)
    return {"phone": data}


def _streams(names: list[str]) -> dict[str, list[str]]:
    """Stream -> its columns."""
    found: dict[str, list[str]] = {}
    used: set[str] = set()
    for stream, (pattern, unit) in STREAMS.items():
        matching = [
            name for name in names if _unit(name) == unit and name not in used and pattern.fullmatch(_bare(name))
        ]
        if stream == "pressure":
            columns = matching[:1]
        else:
            columns = [name for axis in "xyz" for name in matching if _bare(name).lower().endswith(axis)]
        if len(columns) == (1 if stream == "pressure" else 3):
            found[stream] = columns
            used.update(columns)
    return found


def _bare(name: str) -> str:
    return name.rpartition("(")[0].strip()


def _unit(name: str) -> str:
    unit = name.rpartition("(")[2].rstrip(") ").replace("µ", "u").replace("μ", "u").replace("²", "^2")
    return unit.replace("m/s2", "m/s^2")


def _add(table: NamedTable, found: dict[str, list[str]], clock: str, file: str, data: SensorData) -> None:
    times = np.asarray(table.columns[clock], dtype=np.float64)
    kept: dict[bytes, NDArray[np.float64]] = {}
    for stream, columns in found.items():
        values = table.vectors(columns) * FACTORS.get(stream, 1.0)
        there = np.isfinite(times) & ~np.isnan(values.reshape(len(times), -1)).all(axis=1)
        t = kept.setdefault(there.tobytes(), times[there])
        if stream in data.streams:
            data.say("ignored", f"{file}: a second {stream}")
            continue
        data.streams[stream] = (t, values[there])
        data.meta["columns"][stream] = columns
        data.meta["units"][stream] = {"uT": "µT"}.get(_unit(columns[0]), _unit(columns[0]))
    data.meta["repairs"] += [f"{file}: {sentence}" if file else sentence for sentence in table.repairs]


def _events(source: Source) -> dict[str, Any]:
    """When the experiment started, from meta/time.csv: event, time in the experiment, time since 1970."""
    if "meta/time.csv" not in source.names:
        return {}
    lines = head_lines(source.read("meta/time.csv"))
    for line in lines:
        parts = [part.replace(",", ".") for part in cells(line, separator_of(lines[0]))]
        if parts[:1] == ["START"] and len(parts) > 2 and is_number(parts[1]) and is_number(parts[2]):
            start = utc(float(parts[2]) - float(parts[1]))
            return {"start": start} if start else {}
    return {}
