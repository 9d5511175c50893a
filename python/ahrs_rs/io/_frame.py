"""Data frames as recordings: pandas, polars, pyarrow, or any mapping of columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._arrays import times, vectors
from ahrs_rs._recording import Recording
from ahrs_rs.io._contents import Options
from ahrs_rs.io._finish import finish
from ahrs_rs.io._rows import TableData, sensor_data
from ahrs_rs.io._table import shown_name, understood_names

#: The name that an index without one gets: that of a time.
INDEX = "timestamp (index)"


def recording_of_frame(frame: Any, options: Options) -> Recording:
    """A recording of the columns of a data frame, understood as those of a table.

    Raises
    ------
    ValueError
        Columns that cannot be understood; several sensors without `sensor`.
    TypeError
        Something that is no data frame.
    """
    columns = _columns(frame)
    choice, profile, headers = understood_names([(name, _width(one)) for name, one in columns.items()], options)
    cache: dict[str, NDArray[Any]] = {}
    values = {}
    for column in choice.columns():
        name, _, index = headers[column.index].partition("\0")
        if name not in cache:
            cache[name] = _array(name, columns[name], column.quantity)
        values[column.index] = cache[name][:, int(index)] if index else cache[name]
    spoken = [shown_name(header) for header in headers]
    found = sensor_data(TableData(spoken, values, choice, options, profile))
    if options.sensor is None and len(found) > 1:
        raise ValueError(f"has several sensors: give sensor=, one of {', '.join(map(repr, found))}")
    name = options.sensor if options.sensor is not None else next(iter(found))
    if name not in found:
        raise ValueError(f"sensor: expected one of {', '.join(map(repr, found))}, got {name!r}")
    recording = finish(found[name], "data frame", "frame", options, convert=False)
    return recording if options.axes is None else recording.remapped(options.axes)


def _columns(frame: Any) -> dict[str, Any]:
    """Name -> column, with the index of pandas where it is a time or has a name."""
    library = type(frame).__module__.partition(".")[0]
    if library == "pandas" and hasattr(frame, "columns"):
        columns = {str(name): frame.iloc[:, k] for k, name in enumerate(frame.columns)}
        index = frame.index
        if getattr(index, "nlevels", 1) == 1 and (
            index.name is not None or str(index.dtype)[:4] in ("date", "time", "dura")
        ):
            columns.setdefault(str(index.name) if index.name is not None else INDEX, index)
        return columns
    if library == "polars" and hasattr(frame, "collect"):  # a LazyFrame
        frame = frame.collect()
    if library == "polars" and hasattr(frame, "get_columns"):
        return {column.name: column for column in frame.get_columns()}
    if library == "pyarrow" and hasattr(frame, "column_names"):
        return {name: frame.column(k) for k, name in enumerate(frame.column_names)}
    if library == "xarray" and hasattr(frame, "data_vars"):
        return _of_dataset(frame)
    if isinstance(frame, Mapping):
        return {str(name): np.asarray(column) for name, column in frame.items()}
    raise TypeError(
        "frame: expected a data frame of pandas, polars, pyarrow or xarray, or a dict of columns, got "
        f"{type(frame).__name__}"
    )


def _of_dataset(dataset: Any) -> dict[str, Any]:
    """The variables of a Dataset of xarray over its first dimension, and the coordinates of that."""
    every = {str(name): one for name, one in dataset.data_vars.items()}
    if not every:
        raise ValueError("frame: expected a Dataset with variables, got an empty one")
    rows = next((one.dims[0] for one in every.values() if one.ndim == 1), None)
    if rows is None:
        # Of vectors alone: the dimension with coordinates that are no axes.
        shared = set.intersection(*(set(one.dims) for one in every.values()))
        rows = next((one for one in next(iter(every.values())).dims if one in shared and dataset.sizes[one] != 3), None)
    if rows is None:
        raise ValueError(f"frame: expected variables over one dimension of samples, got {dict(dataset.sizes)}")
    columns = {name: np.asarray(one) for name, one in dataset.coords.items() if one.dims == (rows,)}
    columns = {str(name): one for name, one in columns.items()}
    for name, one in every.items():
        if rows in one.dims and one.ndim <= 2:
            columns[name] = one.transpose(rows, ...).values
    return columns


def _width(column: Any) -> int:
    """How many values a row has."""
    if isinstance(column, np.ndarray):
        return column.shape[1] if column.ndim == 2 else 1
    kind = str(getattr(column, "dtype", getattr(column, "type", "")))
    if kind.startswith(
        ("Array", "List", "fixed_size_list", "list", "large_list", "extension<arrow.fixed_shape_tensor")
    ) or (kind == "object" and len(column) and isinstance(_first(column), (list, tuple, np.ndarray))):
        return int(np.shape(vectors("column", column.head(1) if hasattr(column, "head") else column.slice(0, 1)))[-1])
    return 1


def _first(column: Any) -> Any:
    return column.iloc[0] if hasattr(column, "iloc") else column[0]


def _array(name: str, column: Any, quantity: str) -> NDArray[Any]:
    if quantity == "t":
        array = times(column)
        if array.dtype.kind in "OUS":
            return np.array([b"" if cell is None else str(cell).encode() for cell in array], dtype=object)
        return array
    kind = str(getattr(column, "dtype", getattr(column, "type", "")))
    if quantity in ("instance", "mask") or kind in ("object", "str", "string", "String", "large_string"):
        array = np.asarray(column)
        if array.dtype.kind in "OUS" and quantity in ("instance", "mask"):
            return np.array([b"" if cell is None else str(cell).encode() for cell in array], dtype=object)
        if array.dtype.kind in "iufb":
            return array
        raise ValueError(f"column {name!r}: expected numbers, got text")
    return np.asarray(vectors(f"column {name!r}", column))
