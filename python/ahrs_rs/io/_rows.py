"""The rows of a table become the streams of its sensors: units, clocks, orientations, what was not taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _plausible
from ahrs_rs._arrays import seconds as seconds_of_dates
from ahrs_rs._constants import GRAVITY
from ahrs_rs._rate import nominal_rate
from ahrs_rs._typing import FloatArray
from ahrs_rs.io._columns import SENSORS, Choice, Clock, assumed_unit, is_sizeless, shown
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._moments import seconds_of_text
from ahrs_rs.io._names import Column, looks_like_sensor, quantity_of_name
from ahrs_rs.io._profiles import Profile
from ahrs_rs.io._stamps import EPOCH, seconds, unwrapped, utc, wrap_of
from ahrs_rs.io._units import ASSUMED, conversion, unit_key

#: A column that tells sensors apart has no more different values than this.
MOST_SENSORS = 64


@dataclass(slots=True)
class TableData:
    """A table that was read, and what was understood of it."""

    headers: Sequence[str]
    values: dict[int, NDArray[Any]]
    choice: Choice
    options: Options
    profile: Profile | None = None
    repairs: list[str] = field(default_factory=list)
    rate: float | None = None
    """As the lines above the header state it, Hz."""
    rate_column: Column | None = None
    mark: Column | None = None


@dataclass(slots=True)
class _Time:
    """A clock that was tried."""

    clock: Clock
    t: FloatArray
    start: str | None
    assumed: list[str]
    wrong: str = ""
    """Why it can be none of an inertial sensor: "rate", "order" or "text"."""
    error: ValueError | None = None


def require_sensor(choice: Choice, headers: Sequence[str]) -> None:
    """ValueError where a table has no column of a sensor or an orientation."""
    wanted = {*SENSORS, "linear_acceleration", "device_quat", "ref"}
    if not any(quantities.keys() & wanted for quantities in choice.sensors.values()):
        raise ValueError(
            "has no column of a gyroscope, accelerometer or magnetometer (named like 'gyr_x [rad/s]'), only "
            f"{shown(headers)}; name them by columns={{'gyr': [...], 'acc': [...]}} (--columns gyr=...)"
        )


def sensor_data(table: TableData) -> dict[str, SensorData]:
    """What a table holds of each sensor.

    Raises
    ------
    ValueError
        Columns that are no numbers; no time that can be one.
    """
    parts = _instances(table)
    found: dict[str, SensorData] = {}
    for instance, rows in parts.items():
        for name, quantities in table.choice.sensors.items():
            shared = len(table.choice.sensors) == 1
            key = instance if shared and instance else f"{instance} {name}".strip()
            if table.options.sensor is not None and key != table.options.sensor:
                found.setdefault(key, SensorData({}))
                continue
            found[key] = _of_sensor(table, quantities, rows)
    return found


def _instances(table: TableData) -> dict[str, NDArray[np.intp] | None]:
    """Sensor -> its rows, where a column says of which one each row is; one empty name for all rows."""
    column = table.choice.instance
    if column is None or column.index not in table.values:
        return {"": None}
    cells = table.values[column.index]
    names, index = np.unique(np.array([_label(cell) for cell in cells]), return_inverse=True)
    counts = np.bincount(index)
    if not 1 < len(names) <= MOST_SENSORS or counts.min() < 2:
        return {"": None}
    return {str(name): np.flatnonzero(index == k) for k, name in enumerate(names)}


def _label(cell: Any) -> str:
    text = cell.decode("latin-1").strip().strip('"') if isinstance(cell, bytes) else str(cell)
    return text.removesuffix(".0")


#: Stamps that tell whether a clock can be that of a sensor.
SOME = 1 << 16
#: Quantities that nothing is computed from: their units need no word.
UNUSED = ("temperature", "pressure")


def _of_sensor(table: TableData, quantities: dict[str, list[Column]], rows: NDArray[np.intp] | None) -> SensorData:
    data = SensorData({}, meta={"repairs": list(table.repairs)})
    units: dict[str, str] = {}
    assumed: dict[str, str] = {}
    columns: dict[str, list[str]] = {}
    arrays: dict[str, NDArray[Any]] = {}
    for quantity, group in quantities.items():
        arrays[quantity] = _values(table, quantity, group, rows)
        columns[quantity] = [table.headers[column.index] for column in group]
        default = assumed_unit(quantity)
        if default:
            units[quantity] = ", ".join(dict.fromkeys(column.unit or default for column in group))
            if is_sizeless(group[0]):
                units[quantity] = "normalised" if unit_key(group[0].unit) not in ("raw", "counts", "lsb") else "raw"
            if not all(column.unit for column in group) and quantity not in UNUSED:
                assumed[quantity] = default
    _force_by_its_size(arrays, data)
    clocks, own = _clock(table, rows, len(next(iter(arrays.values()))), data, quantities)
    if clocks is not None:
        columns["t"] = [table.headers[column.index] for column in clocks.clock.columns]
        numbers = all(table.values[column.index].dtype.kind in "fiu" for column in clocks.clock.columns)
        stated = all(column.unit for column in clocks.clock.columns) or clocks.start is not None or not numbers
        units["t"] = ", ".join(column.unit or "s" for column in clocks.clock.columns) if clocks.t.size else "s"
        if not stated:
            assumed["t"] = "s"
        if clocks.start is not None:
            data.meta["start"] = clocks.start
        for sentence in clocks.assumed:
            data.say("assumed", sentence)
    t = None if clocks is None else clocks.t
    for quantity, array in arrays.items():
        data.streams[quantity] = own.get(quantity, (t, None))[0], array
    order = ["t", *ASSUMED]
    data.meta |= {
        "units": {name: units[name] for name in order if name in units},
        "assumed_units": {name: assumed[name] for name in order if name in assumed},
        "columns": columns,
    }
    _tell(table, data, quantities)
    return data


def _values(table: TableData, quantity: str, group: Sequence[Column], rows: NDArray[np.intp] | None) -> NDArray[Any]:
    if quantity == "mask":
        mask = _mask(table.values[group[0].index], group[0].header)
        return mask if rows is None else mask[rows]
    block = _block([table.values[column.index] for column in group]) if rows is None else None
    if block is not None:
        array: NDArray[Any] = _converted(block, group[0])
    else:
        parts = [_numbers(table.values[column.index], column, rows) for column in group]
        array = np.column_stack(parts) if len(parts) > 1 else parts[0]
    if table.profile is not None and table.mark is not None and table.profile.missing is not None:
        _, value, of = table.profile.missing
        if of == quantity:
            marks = table.values[table.mark.index]
            array[(marks if rows is None else marks[rows]) == value] = np.nan
    return array


def _numbers(values: NDArray[Any], column: Column, rows: NDArray[np.intp] | None) -> FloatArray:
    if values.dtype.kind == "O":
        try:
            values = np.array([np.nan if cell is None else cell for cell in values], dtype=np.float64)
        except (TypeError, ValueError):
            raise ValueError(f"column {column.header!r}: expected numbers, got text") from None
    if values.dtype.kind not in "fiub":
        raise ValueError(f"column {column.header!r}: expected numbers, got dtype {values.dtype}")
    return _converted(np.asarray(values if rows is None else values[rows], dtype=np.float64), column)


def _block(columns: Sequence[NDArray[Any]]) -> NDArray[Any] | None:
    """The array of which these are the columns, in this order, if there is one: readers make them so."""
    base = columns[0].base
    if not isinstance(base, np.ndarray) or base.dtype != np.float64 or base.shape != (len(columns[0]), len(columns)):
        return None
    same = all(
        column.base is base and column.ctypes.data == base.ctypes.data + k * base.strides[1]
        for k, column in enumerate(columns)
    )
    return base if same and base.flags.c_contiguous else None


def _converted(array: FloatArray, column: Column) -> FloatArray:
    """Readings in our unit."""
    if not column.unit or column.quantity not in ASSUMED:
        return array
    factor, offset = conversion(column.quantity, column.unit)
    if factor == 1.0 and offset == 0.0:
        return array
    with np.errstate(over="ignore"):  # what becomes infinite is turned into NaN with the other infinite values
        converted: FloatArray = array * factor + offset
    return converted


def _mask(values: NDArray[Any], header: str) -> NDArray[np.bool_]:
    """Missing values do not count; all others must be true or false, 1 or 0."""
    if values.dtype.kind == "O":
        words = {
            b"": 0,
            b"0": 0,
            b"1": 1,
            b"true": 1,
            b"false": 0,
            b"0.0": 0,
            b"1.0": 1,
            b"nan": 0,
            b"none": 0,
            b"na": 0,
            b"null": 0,
        }
        texts = [
            cell.strip().lower() if isinstance(cell, bytes) else b"%d" % bool(cell) if cell is not None else b""
            for cell in values
        ]
        if any(text not in words for text in texts):
            raise ValueError(f"column {header!r}: expected true and false or 1 and 0")
        return np.array([words[text] for text in texts], dtype=np.bool_)
    array = np.nan_to_num(values) if values.dtype.kind == "f" else values
    if array.dtype.kind != "b" and not (array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all()):
        raise ValueError(f"column {header!r}: expected true and false or 1 and 0")
    return array.astype(np.bool_)


def _force_by_its_size(arrays: dict[str, NDArray[Any]], data: SensorData) -> None:
    """A linear acceleration, where there is no other one, is a specific force if it is as large as gravity."""
    if "acc" in arrays or "linear_acceleration" not in arrays:
        return
    force = arrays["linear_acceleration"]
    norms = np.linalg.norm(force, axis=1)
    known = norms[np.isfinite(norms)]
    if known.size and abs(float(np.median(known)) - GRAVITY) < 0.2 * GRAVITY:
        arrays["acc"] = arrays.pop("linear_acceleration")
        data.say("assumed", "acc: a linear acceleration with a median norm near 9.8 m/s² is taken as holding gravity")


# -- clocks ------------------------------------------------------------------------------------------------------------


def _clock(
    table: TableData,
    rows: NDArray[np.intp] | None,
    count: int,
    data: SensorData,
    quantities: dict[str, list[Column]],
) -> tuple[_Time | None, dict[str, tuple[FloatArray, None]]]:
    """The clock of the rows, and those of single sensors."""
    if table.options.rate is not None:
        return None, {}
    tried = [_tried(table, clock, rows) for clock in table.choice.clocks]
    own = _own_clocks(tried, quantities)
    general = [one for one in tried if all(one.clock is not other.clock for other in own.values())] or tried
    chosen = next((one for one in general if not one.wrong), general[0] if general else None)
    if (chosen is None or chosen.wrong in ("rate", "text")) and (rate := _rate_beside(table, rows)) is not None:
        data.rate = rate
        reason = "no time" if chosen is None else f"no time that tells samples apart ({chosen.clock.name!r})"
        data.say("assumed", f"t: has {reason}; {rate:g} Hz as the file states")
        return None, {}
    if chosen is not None and chosen.error is not None:
        raise chosen.error
    if chosen is not None:
        left = [one.clock.name for one in general if one is not chosen]
        if left:
            data.say("ignored", f"t is {chosen.clock.name!r}; other clocks left out: {', '.join(map(repr, left))}")
    return chosen, {quantity: (one.t, None) for quantity, one in own.items()}


def _rate_beside(table: TableData, rows: NDArray[np.intp] | None) -> float | None:
    """A rate that a column or the preamble states, Hz."""
    if table.rate_column is not None:
        rates = np.asarray(table.values[table.rate_column.index], dtype=np.float64)
        rates = rates if rows is None else rates[rows]
        middle = float(np.nanmedian(rates)) if np.isfinite(rates).any() else 0.0
        return middle if middle > 0.0 else table.rate
    return table.rate


def _own_clocks(tried: Sequence[_Time], quantities: dict[str, list[Column]]) -> dict[str, _Time]:
    """Clocks that are named after a sensor, as accelerometer_timestamp."""
    found: dict[str, _Time] = {}
    for one in tried:
        quantity = quantity_of_name(" ".join(one.clock.words))
        if quantity in quantities and not one.wrong:
            found.setdefault(quantity, one)
    return found if len(found) < len(tried) or len(found) > 1 else {}


def _tried(table: TableData, clock: Clock, rows: NDArray[np.intp] | None) -> _Time:
    parts = [table.values[column.index] for column in clock.columns]
    parts = parts if rows is None else [part[rows] for part in parts]
    assumed: list[str] = []
    try:
        if len(parts) == 2:
            t, start = _two_parts(clock, parts)
        else:
            t, start = _one_part(clock.columns[0], parts[0], table.options.timezone, assumed)
    except ValueError as error:
        return _Time(clock, np.full(len(parts[0]), np.nan), None, [], "text", error)
    return _Time(clock, t, start, assumed, _wrong(t, clock))


def _one_part(
    column: Column, values: NDArray[Any], zone: str | None, assumed: list[str]
) -> tuple[FloatArray, str | None]:
    if values.dtype.kind == "O":
        return seconds_of_text(values, zone, column.header, assumed)
    if values.dtype.kind in "Mm":
        known = values[~np.isnat(values)]
        start = (
            np.datetime_as_string(known[0].astype("datetime64[us]"))
            if values.dtype.kind == "M" and known.size
            else None
        )
        return seconds_of_dates(values), None if start is None else str(start) + "+00:00"
    if values.dtype.kind not in "fiu":
        raise ValueError(f"column {column.header!r}: expected numbers or times, got dtype {values.dtype}")
    unit = conversion("t", column.unit)[0] if column.unit and column.known else 1.0
    if column.unit and not column.known and column.bracketed and not _is_zone(column.unit):
        raise ValueError(f"column {column.header!r}: unknown unit {column.unit!r}; known are s, ms, us, ns")
    if values.dtype == np.float32 and (wrong := _plausible.doubtful_stamps(values)):
        raise ValueError(f"t: {wrong}")
    bits = wrap_of(values)
    if bits:
        assumed.append(f"{column.header!r} starts again after {bits} bits, which was undone")
        return unwrapped(values, bits) * unit, None
    times, origin = seconds({"t": values}, unit)
    return times["t"], utc(origin) if origin else None


def _is_zone(unit: str) -> bool:
    return unit.lstrip("+-").replace(":", "").isdigit() or unit.lower() in ("txt", "utc", "gmt", "local")


def _two_parts(clock: Clock, parts: Sequence[NDArray[Any]]) -> tuple[FloatArray, str | None]:
    """Whole seconds with a fraction beside."""
    whole, fraction = (np.asarray(part, dtype=np.float64) for part in parts)
    first = float(np.nanmin(whole)) if np.isfinite(whole).any() else 0.0
    origin = first if first > EPOCH else 0.0
    fine = conversion("t", clock.columns[1].unit)[0]
    return (whole - origin) + fraction * fine, utc(origin) if origin else None


def _wrong(t: FloatArray, clock: Clock) -> str:
    """Why a clock can be none of an inertial sensor: "rate", "order" or ""."""
    known = t if np.isfinite(t.sum()) else t[np.isfinite(t)]
    if known.size < 2:
        return "rate" if len(t) > 1 else ""
    falls = np.count_nonzero(known[1:] < known[:-1])
    if falls > 0.3 * (known.size - 1):
        return "order"
    try:
        rate = nominal_rate(np.sort(known) if falls else known[:SOME] if known[:SOME][-1] > known[0] else known)
    except ValueError:
        return "rate"
    return "rate" if len(t) > 2 and _plausible.doubtful_rate(rate) else ""


def _tell(table: TableData, data: SensorData, quantities: dict[str, list[Column]]) -> None:
    """What was not taken, and what the program is known for."""
    # Columns of other sensors of the table are not left out: they are read by the names of those.
    used = {
        column.index
        for one in (quantities, *table.choice.sensors.values())
        for group in one.values()
        for column in group
    }
    clock_names = set(data.meta["columns"].get("t", ()))
    ignored = [
        header
        for index, header in enumerate(table.headers)
        if index not in used and header.strip() and header not in clock_names
    ]
    data.meta["ignored_columns"] = ignored
    sensors = [header for header in ignored if looks_like_sensor(header)]
    if sensors:
        data.say("ignored", f"columns that look like a sensor: {shown(sensors)}")
    if table.profile is not None:
        data.meta["program"] = table.profile.title
        if table.profile.axes:
            data.meta["axes"] = table.profile.axes
