"""Tables whose header names quantities and units: CSV and Parquet, by the same rules (see `_columns`)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _columns, _text, _units
from ._contents import FloatArray, Options, SensorData, one_line, require
from ._source import Source

SEPARATORS = (",", ";", "\t")


def sniff(source: Source) -> bool:
    """Whether the source can be a text table."""
    return _text.is_text(source.head)


def load(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a text table separated by ',', ';' or tab, with a decimal point and one header line."""
    lines = _text.head_lines(source)
    start = next((i for i, line in enumerate(lines) if line.strip()), None)
    if start is None:
        raise ValueError("has no header line")
    separator = max(SEPARATORS, key=lines[start].count)
    headers = _text.cells(lines[start], separator)
    headers[0] = headers[0].lstrip("#% ")  # numpy.savetxt marks its header as a comment
    chosen = _columns.choose(headers)
    _check(chosen, headers)
    names = {column.index: column.header for columns in chosen.values() for column in columns}
    first_row = next((line for line in lines[start + 1 :] if line.strip()), None)
    if first_row is None:
        raise ValueError("has a header, but no rows")
    width = _text.table_width(headers, _text.cells(first_row, separator))
    plain = frozenset(column.index for column in chosen.get("mask", ()))
    values, repairs = _text.read_columns(source, separator, start + 1, width, names, plain)
    return _raw(headers, chosen, values, repairs)


def sniff_parquet(source: Source) -> bool:
    """Whether the source is Parquet."""
    return source.head.startswith(b"PAR1")


def load_parquet(source: Source, options: Options) -> dict[str, SensorData]:
    """Read a Parquet file; a column of timestamps is the time since its first one."""
    pa, parquet = require("pyarrow"), require("pyarrow.parquet")
    try:
        with source.open() as stream, parquet.ParquetFile(stream) as file:
            headers = list(file.schema_arrow.names)
            chosen = _columns.choose(headers)
            _check(chosen, headers)
            table = file.read(columns=[column.header for columns in chosen.values() for column in columns])
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"is not a readable Parquet file: {one_line(error)}") from error
    columns = [column for group in chosen.values() for column in group]
    values = {column.index: _numbers(table[column.header].to_numpy(), column) for column in columns}
    return _raw(headers, chosen, values, [])


def _check(chosen: dict[str, list[_columns.Column]], headers: Sequence[str]) -> None:
    if not chosen.keys() & {"gyr", "acc", "mag"}:
        raise ValueError(f"has no column of a gyroscope, accelerometer or magnetometer (named like 'gyr_x [rad/s]'), only {_shown(headers)}")


def _shown(headers: Sequence[str]) -> str:
    """The headers for a message, not more than fit into a line."""
    text = ", ".join(map(repr, headers))
    return text if len(text) <= 200 else f"{text[:200]}... ({len(headers)} columns)"


def _numbers(array: NDArray[Any], column: _columns.Column) -> NDArray[Any]:
    if column.quantity == "t" and array.dtype.kind == "M":
        valid = array[~np.isnat(array)]
        array = (array - (valid[0] if len(valid) else array[0])) / np.timedelta64(1, "s")
    if column.quantity != "mask" and array.dtype.kind not in "fiu":
        raise ValueError(f"column {column.header!r}: expected numbers, got dtype {array.dtype}")
    return array


def _raw(
    headers: Sequence[str],
    chosen: dict[str, list[_columns.Column]],
    values: dict[int, Any],
    repairs: list[str],
) -> dict[str, SensorData]:
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}
    assumed: dict[str, str] = {}
    for quantity, columns in chosen.items():
        if quantity == "mask":
            arrays["mask"] = _mask(values[columns[0].index], columns[0].header)
            continue
        converted = [_convert(values[column.index], column) for column in columns]
        arrays[quantity] = np.column_stack(converted) if len(converted) > 1 else converted[0]
        if quantity in _units.ASSUMED:
            default = _units.ASSUMED[quantity]
            units[quantity] = ", ".join(dict.fromkeys(column.unit or default for column in columns))
            if not all(column.unit for column in columns):
                assumed[quantity] = default
    used = {column.index for columns in chosen.values() for column in columns}
    ignored = [header for index, header in enumerate(headers) if index not in used and header]
    meta = {"units": units, "assumed_units": assumed, "ignored_columns": ignored, "repairs": repairs}
    t = arrays.pop("t", None)
    return {"imu": SensorData({name: (t, values) for name, values in arrays.items()}, meta=meta)}


def _convert(values: Any, column: _columns.Column) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if column.factor is None or (column.factor == 1.0 and column.offset == 0.0):
        return array
    with np.errstate(over="ignore"):  # what becomes infinite is turned into NaN with the other infinite values
        converted: FloatArray = array * column.factor + column.offset
    return converted


def _mask(values: NDArray[Any], header: str) -> NDArray[np.bool_]:
    """Missing values do not count; all others must be true or false, 1 or 0."""
    array = np.array([False if value is None else value for value in values.tolist()])
    if array.dtype.kind == "f":
        array = np.nan_to_num(array)
    if array.dtype.kind != "b" and not (array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all()):
        raise ValueError(f"column {header!r}: expected true and false or 1 and 0")
    return array.astype(np.bool_)
