"""Readings and stamps of other libraries as arrays: pandas, polars, Arrow, xarray, DLPack, dates and times."""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _plausible

#: Ticks of numpy's times in a second.
_TICKS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9, "ps": 1e12, "fs": 1e15, "as": 1e18}


def vectors(name: str, given: Any) -> Any:
    """What the native side can take of the readings of a sensor: arrays as they are, columns of libraries as arrays.

    Missing values (None, NA, null) become NaN. float32 stays so. What lies in memory as an array does is not copied.

    Raises
    ------
    ValueError
        Columns that are no numbers; it names the argument.
    """
    if given is None or type(given) is np.ndarray:
        return given
    library = _library(given)
    try:
        if library == "numpy" and hasattr(given, "filled"):
            return _unmasked(given)
        if library == "xarray":
            return _of_xarray(given)
        if library in ("pandas", "polars"):
            return _of_frame(given, library)
        if library == "pyarrow":
            return of_arrow(given)
        if hasattr(given, "__dlpack__") and not hasattr(given, "__array__"):
            return np.from_dlpack(given)
        return given
    except (TypeError, ValueError, NotImplementedError, BufferError, RuntimeError) as error:
        message = " ".join(str(error).split())
        raise ValueError(f"{name}: expected an array of real numbers, got {type(given).__name__}: {message}") from None


def stamps(given: ArrayLike | None, *, since: bool = False) -> Any:
    """Stamps as seconds: numbers as they are, dates since the first one, durations by their length.

    Parameters
    ----------
    given : (T,) or (N, T) numbers in s, numpy's datetime64 and timedelta64, `datetime` objects, or such a column of
        pandas, polars or Arrow; None stays None.
    since : dates are refused, as a state goes on from seconds that it knows.

    Raises
    ------
    ValueError
        Stamps whose type has no room for them (float32 since 1970), or integers that cannot be seconds.
    """
    if given is None or (type(given) is np.ndarray and given.dtype == np.float64):
        return given
    array = times(given)
    if array.dtype.kind in "Mm":
        if since and array.dtype.kind == "M":
            raise ValueError("t: expected seconds where a state is given, as it goes on from its own, got dates")
        return seconds(array)
    wrong = _plausible.doubtful_stamps(array)
    if wrong is not None:
        raise ValueError(f"t: {wrong}")
    return given if array.dtype.kind in "fiub" and _library(given) == "numpy" else array


def times(given: Any) -> NDArray[Any]:
    """A column of times as numpy has it: numbers, datetime64 (UTC), timedelta64, or whatever else it is."""
    library = _library(given)
    if library == "numpy" and hasattr(given, "filled"):
        given = _unmasked(given)
    elif library == "pyarrow":
        given = (
            given.to_numpy(zero_copy_only=False)
            if hasattr(given, "type") and not hasattr(given, "chunks")
            else given.to_numpy()
        )
    elif library == "polars":
        given = given.to_numpy()
    elif library == "pandas":
        given = _of_index(given)
    array = np.asarray(given)
    if array.dtype.kind == "O" and array.size:
        first = array.flat[0]
        if isinstance(first, datetime.datetime):
            array = np.array([_utc(one) for one in array.flat], dtype="datetime64[us]").reshape(array.shape)
        elif isinstance(first, datetime.timedelta):
            array = array.astype("timedelta64[us]")
        elif isinstance(first, (int, float)) or first is None:
            array = array.astype(np.float64)
    return array


def seconds(array: NDArray[Any]) -> NDArray[np.float64]:
    """datetime64 as seconds since the first one, timedelta64 as seconds; NaN where there is none (NaT)."""
    if array.dtype.kind == "M":
        known = array[~np.isnat(array)]
        array = array - (known.flat[0] if known.size else array.flat[0] if array.size else np.datetime64(0, "ns"))
    if np.datetime_data(array.dtype)[0] in ("h", "m", "D", "W"):
        array = array.astype("timedelta64[s]")
    # Whole ticks first: integers are exact, and one division rounds once.
    unit, multiple = np.datetime_data(array.dtype)
    count = array.astype(np.int64) * multiple
    found = count.astype(np.float64) / _TICKS[unit]
    found[np.isnat(array)] = np.nan
    return np.asarray(found, dtype=np.float64)


def _library(given: Any) -> str:
    return type(given).__module__.partition(".")[0]


def _unmasked(given: Any) -> NDArray[Any]:
    """numpy's masked array with NaN (NaT) in place of what is masked; its type stays where it has such a value."""
    if given.dtype.kind in "Mm":
        return np.asarray(given.filled(np.array("NaT", dtype=given.dtype)))
    if given.dtype.kind in "iub":  # of whole numbers none is missing
        given = given.astype(np.float64)
    return np.asarray(given.filled(np.nan))


def _of_frame(given: Any, library: str) -> Any:
    """A DataFrame or Series as an array of floats; as it is where numpy sees numbers in it."""
    if library == "polars":
        if getattr(given, "dtype", None) is not None and given.dtype.base_type().__name__ == "List":
            lengths = given.list.len()
            if given.null_count() == 0 and lengths.n_unique() == 1 and lengths[0] > 0:
                flat = given.explode().to_numpy()
                if flat.dtype.kind in "fiu":
                    return flat.reshape(len(given), -1)
            return _stacked(given.to_list())
        return given
    kinds = [given.dtype] if getattr(given, "ndim", 2) == 1 else list(given.dtypes)
    if all(isinstance(kind, np.dtype) and kind.kind in "fiub" for kind in kinds):
        return given
    if len(kinds) == 1 and given.ndim == 1 and str(kinds[0]).startswith(("list", "large_list", "fixed_size_list")):
        return of_arrow(given.array.__arrow_array__())
    if len(kinds) == 1 and (str(kinds[0]).startswith("list") or kinds[0] == np.dtype(object)) and given.ndim == 1:
        return _stacked(given.tolist())
    narrow = all(str(kind).lower().startswith(("float32", "float[")) for kind in kinds)
    return given.to_numpy(dtype=np.float32 if narrow else np.float64, na_value=np.nan)


def of_arrow(given: Any) -> Any:
    """A column or table of Arrow as an array: (n,), or (n, k) of lists of fixed size, tensors and tables."""
    if hasattr(given, "columns"):  # Table, RecordBatch
        return np.column_stack([of_arrow(column) for column in given.columns])
    if hasattr(given, "combine_chunks"):
        given = given.chunk(0) if given.num_chunks == 1 else given.combine_chunks()
        if hasattr(given, "chunks"):  # of no chunk at all
            given = given.chunk(0)
    if hasattr(given, "to_numpy_ndarray"):
        return given.to_numpy_ndarray()
    kind = str(given.type)
    if kind.startswith("fixed_size_list"):
        width = given.type.list_size
        flat = np.asarray(given.flatten().to_numpy(zero_copy_only=False), dtype=_float_of(str(given.type.value_type)))
        if not given.null_count:
            return flat.reshape(-1, width)
        rows = np.full((len(given), width), np.nan, dtype=flat.dtype)
        rows[np.asarray(given.is_valid())] = flat.reshape(-1, width)
        return rows
    if kind.startswith(("list", "large_list")):
        lengths = given.value_lengths().to_numpy(zero_copy_only=False)
        if len(given) and not given.null_count and (lengths == lengths[0]).all() and lengths[0] > 0:
            flat = given.flatten().to_numpy(zero_copy_only=False)
            return np.asarray(flat, dtype=_float_of(str(given.type.value_type))).reshape(len(given), -1)
        return _stacked(given.to_pylist())
    return given.to_numpy(zero_copy_only=False)


def _of_xarray(given: Any) -> Any:
    """A DataArray with the dimension of the axes last, which is the one with three coordinates."""
    if not hasattr(given, "dims") or not hasattr(given, "values"):
        raise TypeError("expected a DataArray: ar.Recording.from_frame takes a Dataset")
    if given.ndim >= 2 and given.shape[-1] != 3:
        of_axes = [name for name, size in given.sizes.items() if size == 3]
        if len(of_axes) == 1:
            given = given.transpose(..., of_axes[0])
    return given.values


def _float_of(value_type: str) -> type[np.floating[Any]]:
    return np.float32 if value_type == "float" else np.float64


def _stacked(rows: list[Any]) -> NDArray[np.float64]:
    """Rows of equal length, None being a row of NaN."""
    widths = {len(row) for row in rows if row is not None}
    if len(widths) > 1:
        raise ValueError(f"rows of {sorted(widths)} values")
    width = widths.pop() if widths else 3
    return np.array([[np.nan] * width if row is None else list(row) for row in rows], dtype=np.float64).reshape(
        -1, width
    )


def _of_index(given: Any) -> Any:
    """A Series or Index of pandas as numpy has it."""
    kind = str(given.dtype)
    if kind.startswith(("datetime64", "timestamp", "period")):
        if kind.startswith("period"):
            given = given.to_timestamp()
        return given.to_numpy(dtype="datetime64[ns]")  # of a zone: in UTC
    if kind.startswith(("timedelta64", "duration")):
        return given.to_numpy(dtype="timedelta64[ns]")
    if isinstance(given.dtype, np.dtype):
        return given.to_numpy()
    return given.to_numpy(dtype=np.float64, na_value=np.nan)


def _utc(moment: datetime.datetime) -> datetime.datetime:
    return moment if moment.tzinfo is None else moment.astimezone(datetime.UTC).replace(tzinfo=None)
