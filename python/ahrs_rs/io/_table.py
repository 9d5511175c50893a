"""Tables whose header names quantities and units: text and Parquet, by the same rules (see `_names`, `_columns`)."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs.io import _preamble, _text
from ahrs_rs.io._columns import Choice, choose
from ahrs_rs.io._contents import Options, SensorData, SensorInfo, one_line, require
from ahrs_rs.io._names import Column, quantity_of_name
from ahrs_rs.io._npz import before
from ahrs_rs.io._preamble import Layout
from ahrs_rs.io._profiles import Profile, adapter, profile_of
from ahrs_rs.io._rows import TableData, require_sensor, sensor_data
from ahrs_rs.io._source import Source

#: Under this key the metadata of a Parquet file has `Recording.meta` and the rate.
META = "ahrs_rs"
#: A number of so many digits is beyond what a float64 tells apart.
LONG_DIGITS = 16
#: What is longer is no name with a unit in brackets.
LONGEST_NAME = 200


def sniff(source: Source) -> bool:
    """Whether the source can be a text table."""
    return not source.is_folder and not source.is_zip and _preamble.is_text(source.head)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a text table with a header line, or with names that the user gives."""
    layout, choice, profile = _understood(source, options)
    rate_column = _named_column(layout.headers, profile.rate) if profile is not None else None
    mark = _named_column(layout.headers, profile.missing[0]) if profile is not None and profile.missing else None
    wanted = {column.index: column.header for column in choice.columns()}
    wanted |= {column.index: column.header for column in (rate_column, mark) if column is not None}
    text = _text_columns(choice, layout)
    whole = [
        column.index
        for clock in choice.clocks
        for column in clock.columns
        if column.index not in text and _are_long(layout, column.index)
    ]
    axes = [
        tuple(column.index for column in columns)
        for quantities in choice.sensors.values()
        for columns in quantities.values()
        if len(columns) > 1
    ]
    alone = [group for group in axes if all(sum(index in one for one in axes) == 1 for index in group)]
    values, repairs = _text.read_columns(source, layout, wanted, text=text, whole=whole, groups=alone)
    table = TableData(
        headers=layout.headers,
        values=values,
        choice=choice,
        options=options,
        profile=profile,
        repairs=repairs,
        rate=_stated_rate(layout.preamble),
        rate_column=rate_column,
        mark=mark,
    )
    return sensor_data(table)


def sensors(source: Source, options: Options) -> list[SensorInfo]:
    """The sensors of a text table, from its head."""
    _, choice, _ = _understood(source, options)
    if choice.instance is not None:
        return [SensorInfo(name, *_counts(data)) for name, data in load(source, options).items()]
    nothing: dict[str, int | None] = {}
    return [
        SensorInfo(name, nothing | dict.fromkeys(quantities), dict.fromkeys(quantities))
        for name, quantities in choice.sensors.items()
    ]


def _counts(data: SensorData) -> tuple[dict[str, int | None], dict[str, float | None]]:
    return {name: len(values) for name, (_, values) in data.streams.items()}, dict.fromkeys(data.streams)


def _understood(source: Source, options: Options) -> tuple[Layout, Choice, Profile | None]:
    layout = _preamble.layout_of(_preamble.head_lines(source), options)
    if not layout.rows and len(source.read(size=_preamble.HEAD_BYTES)) == _preamble.HEAD_BYTES:
        layout = _preamble.layout_of(_preamble.head_lines(source, _preamble.LONG_HEAD_BYTES), options)
    profile = profile_of(layout.headers)
    hint = quantity_of_name(PurePosixPath(source.name).stem)
    if (
        profile is not None
        and profile.title == "Sensor Logger"
        and hint == "acc"
        and "total" not in source.name.lower()
    ):
        hint = "linear_acceleration"
    choice = choose(layout.headers, options, units=layout.units, hint=hint, adapt=adapter(layout.headers, profile))
    require_sensor(choice, layout.headers)
    if not layout.rows:
        raise ValueError("has a header, but no rows")
    choice.clocks = [clock for clock in choice.clocks if not _is_date(layout, clock.columns[0].index)]
    return layout, choice, profile


def _named_column(headers: Sequence[str], name: str) -> Column | None:
    names = [header.strip().strip("\"'") for header in headers]
    return Column(names.index(name), name, "", 0, "") if name and name in names else None


def _text_columns(choice: Choice, layout: Layout) -> Collection[int]:
    """Columns that are to be kept as text: moments, names of sensors, true and false."""
    text = set()
    for clock in choice.clocks:
        for column in clock.columns:
            some = [row[column.index] for row in layout.rows if column.index < len(row) and row[column.index]]
            if some and not any(_preamble.is_number(cell) for cell in some):
                text.add(column.index)
    text |= {
        columns[0].index for quantities in choice.sensors.values() for q, columns in quantities.items() if q == "mask"
    }
    return text | ({choice.instance.index} if choice.instance is not None else set())


def _is_date(layout: Layout, index: int) -> bool:
    """Whether a column holds dates without a time."""
    some = [row[index] for row in layout.rows if index < len(row) and row[index]]
    return bool(some) and all(re.fullmatch(r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}", cell) for cell in some)


def _are_long(layout: Layout, index: int) -> bool:
    some = [row[index] for row in layout.rows if index < len(row) and row[index]]
    return bool(some) and all(re.fullmatch(r"\d+", cell) for cell in some) and max(map(len, some)) >= LONG_DIGITS


def _stated_rate(preamble: Sequence[str]) -> float | None:
    """A rate that the lines above the header state, Hz."""
    for line in preamble:
        match = re.search(
            r"(?i)(?:sampl\w*|update|output|data)[\s_]*(?:rate|freq\w*)[^\d\n]{0,20}(\d+(?:\.\d+)?)\s*(?:hz|,|;|$)",
            line[:500],
        )
        if match is not None and float(match[1]) > 0:
            return float(match[1])
    return None


# -- Parquet -----------------------------------------------------------------------------------------------------------


def sniff_parquet(source: Source) -> bool:
    """Whether the source is Parquet."""
    return source.head.startswith(b"PAR1")


def load_parquet(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a Parquet file; columns of vectors stand for their axes, a time index of pandas for the time."""
    pa, parquet = require("pyarrow"), require("pyarrow.parquet")
    for name in ("separator", "decimal", "skip_rows"):
        if getattr(options, name) is not None:
            raise ValueError(f"{name}: expected None, as a Parquet table has no text")
    try:
        with source.open() as stream, parquet.ParquetFile(stream) as file:
            schema = file.schema_arrow
            choice, profile, headers = understood_names([(field.name, _width(field.type)) for field in schema], options)
            rate_column = _named_column(headers, profile.rate) if profile is not None else None
            mark = _named_column(headers, profile.missing[0]) if profile is not None and profile.missing else None
            wanted = [*choice.columns(), *(one for one in (rate_column, mark) if one is not None)]
            names = list(dict.fromkeys(headers[column.index].partition("\0")[0] for column in wanted))
            arrow = file.read(columns=names)
            saved = _saved_meta(schema.metadata or {})
            values = {column.index: _column_of(arrow, headers[column.index]) for column in wanted}
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"is not a readable Parquet file: {one_line(error)}") from error
    table = TableData(
        headers=[shown_name(header) for header in headers],
        values=values,
        choice=choice,
        options=options,
        profile=profile,
        rate_column=rate_column,
        mark=mark,
    )
    found = sensor_data(table)
    if saved:  # what Recording.save wrote has one sensor
        data = next(iter(found.values()))
        data.rate = saved.pop("rate", None)
        data.meta = {**saved, **data.meta}
    return found


def _saved_meta(metadata: Mapping[bytes, bytes]) -> dict[str, Any]:
    """The rate and the meta that `Recording.save` put into a Parquet file."""
    try:
        saved = json.loads(metadata.get(META.encode(), b"null"))
    except ValueError:
        return {}
    return before(saved) if isinstance(saved, dict) else {}


def understood_names(columns: Sequence[tuple[str, int]], options: Options) -> tuple[Choice, Profile | None, list[str]]:
    """The columns of a table without text: (name, width), with a width beyond 1 for vectors.

    A vector ``gyr [rad/s]`` counts as columns ``gyr [rad/s] x`` and so on, under the name ``NAME\\0INDEX``.
    """
    headers: list[str] = []
    spoken: list[str] = []
    for name, width in columns:
        if width <= 1:
            headers.append(name)
            spoken.append("timestamp" if name == "__index_level_0__" else name)
            continue
        labels = "xyz" if width == 3 else "wxyz" if width == 4 else ""
        for k in range(width):
            headers.append(f"{name}\0{k}")
            bracket = re.fullmatch(r"(.*?)(\s*[(\[][^()\[\]]*[)\]])", name) if len(name) <= LONGEST_NAME else None
            axis = labels[k] if labels else str(k)
            spoken.append(f"{bracket[1]}_{axis}{bracket[2]}" if bracket else f"{name}_{axis}")
    options = replace(options, columns=_spread(options.columns, columns))
    profile = profile_of(spoken)
    choice = choose(spoken, options, adapt=adapter(spoken, profile))
    require_sensor(choice, [name for name, _ in columns])
    return choice, profile, headers


def _spread(asked: Any, columns: Sequence[tuple[str, int]]) -> Any:
    """The name of a vector that the user gives, as those of its columns."""
    widths = {name: width for name, width in columns if width > 1}
    if not isinstance(asked, Mapping):
        if asked is not None:
            raise ValueError("columns: expected a mapping, as the table has names of its own")
        return None
    labels = {3: "xyz", 4: "wxyz"}
    return {
        quantity: [f"{names}_{axis}" for axis in labels[widths[names]]]
        if isinstance(names, str) and widths.get(names) in labels
        else names
        for quantity, names in asked.items()
    }


def shown_name(header: str) -> str:
    """The name of a column for messages."""
    name, _, index = header.partition("\0")
    return f"{name}[{index}]" if index else name


def _width(kind: Any) -> int:
    """How many values a row of a column of Arrow has; lists of any length count as vectors of three."""
    size = getattr(kind, "list_size", None)
    if size is not None and size > 0:
        return int(size)
    storage = getattr(kind, "storage_type", None)
    if storage is not None:
        return _width(storage)
    return 3 if str(kind).startswith(("list<", "large_list<")) else 1


def _column_of(table: Any, header: str) -> NDArray[Any]:
    from ahrs_rs._arrays import of_arrow

    name, _, index = header.partition("\0")
    column = table[name]
    kind = str(column.type)
    if kind.startswith(("string", "large_string", "binary")):
        return np.array([b"" if cell is None else str(cell).encode() for cell in column.to_pylist()], dtype=object)
    array = of_arrow(column)
    return np.asarray(array[:, int(index)] if index else array)
