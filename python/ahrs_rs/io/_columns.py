"""Which columns of a table are taken: of each sensor and quantity one for every axis; and clocks to choose from."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ahrs_rs.io._contents import Options
from ahrs_rs.io._names import AXES, BARE, PROCESSED, Column, parse, split
from ahrs_rs.io._units import ASSUMED, SIZELESS, UNITS, conversion, is_unit, unit_key

#: Names of a column that says which of several sensors a row is of.
INSTANCES = frozenset(
    [
        "i",
        "instance",
        "imu",
        "imu_id",
        "sensor",
        "sensor_id",
        "sensorid",
        "sensor_name",
        "device",
        "device_id",
        "deviceid",
        "device_name",
        "devicename",
        "imu_no",
        "imu_index",
        "sensor_index",
        "sensor_no",
        "node",
        "node_id",
        "mac",
        "address",
    ]
)
#: Quantities of which at least one is needed.
SENSORS = ("gyr", "acc", "mag")

Group = tuple[str, str, tuple[str, ...], bool]


@dataclass(frozen=True, slots=True)
class Clock:
    """Columns that may be the time: one, or seconds with a fraction beside."""

    columns: tuple[Column, ...]

    @property
    def name(self) -> str:
        """As it is called in messages."""
        return " + ".join(column.header for column in self.columns)

    @property
    def words(self) -> tuple[str, ...]:
        """The words of its name."""
        return self.columns[0].kind


@dataclass(slots=True)
class Choice:
    """What was found in the header of a table."""

    sensors: dict[str, dict[str, list[Column]]] = field(default_factory=dict)
    """Sensor -> quantity -> columns in the order of the axes."""
    clocks: list[Clock] = field(default_factory=list)
    instance: Column | None = None
    """The column that says which sensor a row is of, if there is one."""
    passed: list[str] = field(default_factory=list)
    """Sentences about complete readings that were not taken."""

    def columns(self) -> list[Column]:
        """All that are to be read, each once."""
        found = {
            column.index: column
            for quantities in self.sensors.values()
            for columns in quantities.values()
            for column in columns
        }
        found |= {column.index: column for clock in self.clocks for column in clock.columns}
        if self.instance is not None:
            found[self.instance.index] = self.instance
        return list(found.values())


def choose(
    headers: Sequence[str],
    options: Options,
    *,
    units: Sequence[str] = (),
    hint: str = "",
    adapt: Callable[[Column], Column] | None = None,
) -> Choice:
    """The columns of each quantity.

    Parameters
    ----------
    headers : names of the columns.
    options : `columns` are taken as they say, `units` go over all others.
    units : those of a line below the header, one a column; empty ones say nothing.
    hint : the quantity of columns that are named by their axes alone.
    adapt : what is known of this program's columns beside their names (`_profiles`).

    Raises
    ------
    ValueError
        A quantity with missing axes, several columns for one axis, several readings between which nothing decides,
        mixed units, or a unit that is not known.
    """
    given = _given(headers, options)
    taken = {column.index for columns in given.values() for column in columns}
    columns = []
    for index, header in enumerate(headers):
        column = None if index in taken else parse(index, header, hint=hint)
        if column is None or column.quantity in given:
            continue
        columns.append(column)
    columns = [_with_unit(column, units) for column in columns]
    if adapt is not None:
        columns = [adapt(column) for column in columns]
    stated = dict(options.units or {})
    for quantity in stated:
        conversion(quantity, stated[quantity])
    columns = [_stated(column, stated) for column in columns]
    given = {quantity: [_stated(_with_unit(one, units), stated) for one in group] for quantity, group in given.items()}

    made = Choice()
    readings = _owned([column for column in columns if column.quantity != "t"])
    _choose_sensors(made, readings, given)
    times = given.get("t") or [column for column in columns if column.quantity == "t"]
    made.clocks = _clocks(times) if "t" not in given else [Clock(tuple(times))] if times else []
    made.instance = next(
        (Column(i, one, "instance", 0, "") for i, one in enumerate(headers) if _is_instance(one)), None
    )
    return made


def _is_instance(header: str) -> bool:
    return re.sub(r"[^a-z0-9]+", "_", header.strip().lower()).strip("_") in INSTANCES


# -- what the user named -----------------------------------------------------------------------------------------------


def _given(headers: Sequence[str], options: Options) -> dict[str, list[Column]]:
    """Quantity -> the columns that the user named for it; empty: none are to be taken."""
    if not isinstance(options.columns, Mapping):
        return {}
    found: dict[str, list[Column]] = {}
    for quantity, names in options.columns.items():
        one = [names] if isinstance(names, (str, int)) else list(names)
        if quantity in AXES and one and len(one) != len(AXES[quantity]) and not (quantity == "t" and len(one) == 2):
            raise ValueError(f"columns: {quantity}: expected {len(AXES[quantity])} names, got {one}")
        found[quantity] = [_named(headers, quantity, axis, name) for axis, name in enumerate(one)]
    return found


def _named(headers: Sequence[str], quantity: str, axis: int, name: Any) -> Column:
    index = _index(headers, name)
    if index is None:
        raise ValueError(f"columns: {quantity}: has no column {name!r}, only {shown(headers)}")
    known = parse(index, headers[index])
    same = known is not None and known.quantity == quantity
    unit = known.unit if known is not None and same else split(headers[index])[1]
    kind = known.kind if known is not None and same else ()
    bracketed = bool(unit) and (quantity not in UNITS or is_unit(quantity, unit))
    return Column(index, headers[index], quantity, axis, unit if bracketed else "", kind=kind, bracketed=bracketed)


def _index(headers: Sequence[str], name: Any) -> int | None:
    if isinstance(name, int) and not isinstance(name, bool):
        return name if 0 <= name < len(headers) else None
    plain = [header.strip() for header in headers]
    if name in plain:
        return plain.index(name)
    folded = [header.casefold() for header in plain]
    alike = [i for i, header in enumerate(folded) if header == str(name).strip().casefold()]
    return alike[0] if len(alike) == 1 else None


def _with_unit(column: Column, units: Sequence[str]) -> Column:
    """With the unit of the line below the header, where its name has none."""
    unit = units[column.index].strip().strip("[](){}") if column.index < len(units) else ""
    return column if column.unit or not unit else replace(column, unit=unit, bracketed=True)


def _stated(column: Column, units: Mapping[str, str]) -> Column:
    """With the unit that the user states."""
    unit = units.get(column.quantity)
    return column if unit is None else replace(column, unit=unit, bracketed=True)


# -- sensors and their readings ----------------------------------------------------------------------------------------


def _choose_sensors(made: Choice, columns: list[Column], given: dict[str, list[Column]]) -> None:
    groups: dict[Group, dict[int, list[Column]]] = {}
    for column in columns:
        groups.setdefault(column.group, {}).setdefault(column.axis, []).append(column)
    owners = _owners(groups) if not any(given.get(quantity) for quantity in SENSORS) else [""]
    for owner in owners:
        alone = len(owners) == 1
        quantities = {quantity: list(group) for quantity, group in given.items() if group and quantity != "t"}
        for quantity in AXES:
            if quantity == "t" or quantity in given:
                continue
            own = [g for g in groups if g[0] == quantity and (alone or g[1] in (owner, ""))]
            if not alone and any(g[1] for g in own):
                own = [g for g in own if g[1]]
            found = _best(quantity, [groups[group] for group in own], made.passed)
            if found:
                quantities[quantity] = found
        if quantities:
            made.sensors[owner or "imu"] = quantities


def _owned(columns: list[Column]) -> list[Column]:
    """The columns, of which the words behind the axis name the sensor where several quantities have the same ones.

    acc_x_dashboard, gyro_x_dashboard, acc_x_wheel, gyro_x_wheel are two sensors; acc_x_filtered is none of its own.
    """
    of: dict[tuple[str, ...], set[str]] = {}
    for column in columns:
        if column.quantity in SENSORS and column.kind and not column.owner and not PROCESSED & set(column.kind):
            of.setdefault(column.kind, set()).add(column.quantity)
    places = {kind for kind, quantities in of.items() if len(quantities) > 1}
    if len(places) < 2:
        return columns
    return [
        replace(column, owner="_".join(column.kind), kind=()) if column.kind in places and not column.owner else column
        for column in columns
    ]


def _owners(groups: Mapping[Group, Mapping[int, Sequence[Column]]]) -> list[str]:
    """The owners of a table of several sensors side by side, or one empty name."""
    of: dict[str, dict[tuple[str, ...], list[str]]] = {quantity: {} for quantity in SENSORS}
    for (quantity, owner, kind, _), axes in groups.items():
        if quantity in of and len(axes) == len(AXES[quantity]):
            of[quantity].setdefault(kind, []).append(owner)
    several = [owners for kinds in of.values() for owners in kinds.values() if len(set(owners)) > 1]
    if not several:
        return [""]
    return list(dict.fromkeys(owner for owners in several for owner in owners))


def _best(quantity: str, groups: list[dict[int, list[Column]]], passed: list[str]) -> list[Column]:
    """The reading that is taken: one that states its unit before others, the plain one before filtered and raw ones."""
    axes = AXES[quantity]
    single = len(axes) == 1
    complete = []
    lacking: list[tuple[dict[int, list[Column]], str]] = []
    for group in groups:
        double = next((columns for columns in group.values() if len(columns) > 1), None)
        missing = [axes[axis] for axis in range(len(axes)) if axis not in group]
        if double is not None:
            first, second = double[0].header, double[1].header
            raise ValueError(f"columns {first!r} and {second!r} are the same quantity and axis{_option(quantity)}")
        if missing:
            columns_of = [column for columns in group.values() for column in columns]
            if BARE in columns_of[0].kind:
                continue
            names = [column.header for column in columns_of]
            lacking.append((group, f"{quantity}: no column for {', '.join(missing)}, only {names}"))
            continue
        complete.append([group[axis][0] for axis in range(len(axes))])
    if not complete:
        if lacking and not single and quantity in (*SENSORS, "ref"):
            raise ValueError(lacking[0][1])
        return []
    known = [columns for columns in complete if all(column.known for column in columns)]
    if not known:
        _refuse_units(complete[0], quantity)
        if single:
            return []
    ranked = sorted(known or complete, key=_rank)
    best = ranked[0]
    _check_units(best)
    if len(ranked) > 1:
        if _rank(ranked[1]) == _rank(best):
            one, other = best[0].header, ranked[1][0].header
            if quantity in SENSORS:
                raise ValueError(f"columns {one!r} and {other!r} are the same quantity and axis{_option(quantity)}")
            return []
        for columns in ranked[1:]:
            listed = ", ".join(column.header for column in columns)
            passed.append(f"{quantity}: {listed} not taken, but {best[0].header} and its axes")
    return best


def _option(quantity: str) -> str:
    if quantity == "t":
        return ": name one by columns={'t': ...} (--columns t=...)"
    return f": name one of each axis by columns={{{quantity!r}: [...]}} (--columns {quantity}=...)"


def _rank(columns: list[Column]) -> tuple[int, int, int]:
    stated = all(column.unit for column in columns)
    return (0 if stated else 1, columns[0].lateness, len(columns[0].kind))


def _refuse_units(columns: list[Column], quantity: str) -> None:
    """The error for a unit that is not known; of one column, as a temperature, it may be a mere suffix: no error."""
    column = next(column for column in columns if not column.known)
    if len(AXES[quantity]) == 1 and not column.bracketed:
        return
    known = ", ".join(sorted(filter(None, UNITS[quantity])))
    remedy = f"; state it by units={{{quantity!r}: ...}} (--units {quantity}=...)"
    raise ValueError(f"column {column.header!r}: unknown unit {column.unit!r}; known are {known}{remedy}")


def _check_units(columns: list[Column]) -> None:
    """One unit for all axes, and one that tells the size of a reading."""
    quantity = columns[0].quantity
    units = {unit_key(column.unit): column for column in columns}
    if len({conversion(quantity, column.unit) if column.unit else None for column in columns}) > 1:
        shown_units = ", ".join(f"{column.header!r} in {column.unit or 'none'}" for column in units.values())
        raise ValueError(f"{quantity}: expected one unit for all axes, got {shown_units}")


def is_sizeless(column: Column) -> bool:
    """Whether its unit says nothing about the size of a reading."""
    return unit_key(column.unit) in SIZELESS


# -- clocks ------------------------------------------------------------------------------------------------------------


def _clocks(columns: list[Column]) -> list[Clock]:
    """The clocks, those that are likelier that of the sensor first."""
    coarse = [column for column in columns if is_unit("t", column.unit) and _size(column) == 1.0]
    fine = [column for column in columns if column.unit and column.known and _size(column) < 1.0]
    found = []
    paired: set[int] = set()
    for whole in coarse:
        part = next((one for one in fine if one.kind == whole.kind and _stem(one) == _stem(whole)), None)
        if part is not None:
            found.append(Clock((whole, part)))
            paired |= {whole.index, part.index}
    found += [Clock((column,)) for column in columns if column.index not in paired]
    return sorted(found, key=_preference)


def _size(column: Column) -> float:
    return conversion("t", column.unit)[0]


def _stem(column: Column) -> str:
    """The name without the unit: header.stamp of header.stamp.secs."""
    words = split(column.header)[0]
    return " ".join(words[:-1] if words and is_unit("t", words[-1]) else words)


def _preference(clock: Clock) -> tuple[int, int, int]:
    """A sensor's or a message's own stamps before those of a receiver, a stated unit before none, T last."""
    words = set(clock.words)
    if clock.columns[0].header.strip() == "T":
        place = 9
    elif words & {"header", "sensor", "sample", "boot", "reboot", "chip"}:
        place = 0
    elif words & {
        "date",
        "rtc",
        "local",
        "logging",
        "publish",
        "receive",
        "received",
        "log",
        "host",
        "server",
        "arrival",
    }:
        place = 5
    elif words & {"epoch", "unix", "utc", "datetime", "system", "tow"}:
        place = 4
    else:
        place = 2
    unit = 0 if all(column.unit and column.known for column in clock.columns) else 1
    return place if place in (0, 9) else 1 + unit * 10 + place, -len(clock.columns), clock.columns[0].index


def assumed_unit(quantity: str) -> str:
    """The unit that is assumed where a name tells none; "" where there is none."""
    return ASSUMED.get(quantity, "")


def shown(headers: Sequence[str]) -> str:
    """The headers for a message, not more than fit into a line."""
    text = ", ".join(repr(header[:40]) for header in headers[:40])
    return text if len(text) <= 200 and len(headers) <= 40 else f"{text[:200]}... ({len(headers)} columns)"
