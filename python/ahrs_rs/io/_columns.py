"""What a column of a table is: the quantity, axis and unit that its name tells.

A name is matched in lower case with every run of other characters as one underscore. The unit stands in
brackets, as in "Gyroscope X (deg/s)" or "gyr_x [rad/s]", or after the axis, as in acc_x_g.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ._units import UNITS, plain, unit_key

#: Quantity -> labels of its axes, "" for a quantity of one column.
AXES = {"t": ("",), "gyr": tuple("xyz"), "acc": tuple("xyz"), "mag": tuple("xyz"), "ref": tuple("wxyz")}
AXES |= {"temperature": ("",), "mask": ("",)}

_DEVICE = r"(?:(?:imu|sensor|marg)\d*_)?"
_TRUTH = r"(?P<truth>ref|reference|truth|true|gt|ground_?truth|opt|optical|vicon|mocap)"
_UNIT = r"(?:_(?P<unit>.+))?"
#: Quantity -> the names of one of its columns, without the axis and the unit.
_NAMES = {
    "gyr": _DEVICE + r"(?:gyr|gyros?|gyroscope|angular_?velocity|angular_?rate|rotation_?rate|ang_?vel|omega|g|w)_?",
    "acc": _DEVICE + r"(?:acc|accel|accelerometer|acceleration|specific_?force|a)_?",
    "mag": _DEVICE + r"(?:mag|magn|magneto|magnetometer|magnetic_?field|m)_?",
    "ref": rf"(?:(?:{_TRUTH}_)?(?:q|quat|quaternion|orientation|ori)_?|(?:ref|reference|truth)_)",
    "t": r"(?:t|times?|timestamps?|time_stamps?|elapsed|elapsed_time|time_elapsed|sample_?time)",
    "temperature": _DEVICE + r"(?:temp|temperature)",
    "mask": r"(?:mask|movement|moving)",
}
_MATCHERS = {
    quantity: re.compile(names + f"(?P<axis>{'|'.join(AXES[quantity])})" + _UNIT) for quantity, names in _NAMES.items()
}
_BRACKETS = re.compile(r"(?P<name>.*?)\s*[(\[](?P<unit>[^()\[\]]*)[)\]]\s*")


@dataclass(frozen=True, slots=True)
class Column:
    """One column that was understood, with the factor and offset to the unit of `Recording`."""

    index: int
    header: str
    quantity: str
    axis: int
    unit: str  # as written; "" if none
    factor: float | None  # None: the unit is unknown
    offset: float
    stated: bool  # the unit is stated, or the column is named as the truth
    bracketed: bool


def parse(index: int, header: str) -> Column | None:
    """What the column is, or None for a name that is none of ours."""
    text = plain(header)
    brackets = _BRACKETS.fullmatch(text)
    unit = brackets["unit"].strip() if brackets else ""
    name = re.sub(r"[^a-z0-9]+", "_", (brackets["name"] if brackets else text).lower()).strip("_")
    if name in UNITS["t"] and len(name) > 3:  # a name like "seconds" or "millis" is the unit of the time
        name, unit = "t", unit or name
    for quantity, matcher in _MATCHERS.items():
        match = matcher.fullmatch(name)
        if match is None:
            continue
        unit = unit or match["unit"] or ""
        factor, offset = UNITS[quantity].get(unit_key(unit), (None, 0.0)) if unit else (1.0, 0.0)
        return Column(
            index=index,
            header=header,
            quantity=quantity,
            axis=AXES[quantity].index(match["axis"]),
            unit=unit,
            factor=factor,
            offset=offset,
            stated=bool(unit or match.groupdict().get("truth")),
            bracketed=bool(brackets),
        )
    return None


def choose(headers: Sequence[str]) -> dict[str, list[Column]]:
    """For every quantity that is there, one column per axis.

    Where several columns fit, one that states its unit goes before one that does not, and a suffix that is no
    unit (acc_x_filtered) is left for the plain name.

    Raises
    ------
    ValueError
        A quantity with missing axes, two columns for one axis, or a unit that is not known.
    """
    columns = [column for i, header in enumerate(headers) if (column := parse(i, header)) is not None]
    chosen: dict[str, list[Column]] = {}
    for quantity, axes in AXES.items():
        found = [column for column in columns if column.quantity == quantity]
        if quantity in ("temperature", "mask"):  # temp_room, moving_average: something else, not an error
            found = [column for column in found if column.factor is not None or column.bracketed]
        if not found:
            continue
        per_axis = [_best([column for column in found if column.axis == axis]) for axis in range(len(axes))]
        missing = [axis for axis, column in zip(axes, per_axis, strict=True) if column is None]
        if missing:
            names = [column.header for column in found]
            raise ValueError(f"{quantity}: no column for {', '.join(missing)}, only {names}")
        chosen[quantity] = [column for column in per_axis if column is not None]
    return chosen


def _best(candidates: list[Column]) -> Column | None:
    usable = [column for column in candidates if column.factor is not None or column.bracketed]
    preferred = [column for column in usable if column.stated] or usable or candidates
    if len(preferred) > 1:
        first, second = preferred[0].header, preferred[1].header
        raise ValueError(f"columns {first!r} and {second!r} are the same quantity and axis")
    if preferred and preferred[0].factor is None:
        column = preferred[0]
        known = ", ".join(sorted(filter(None, UNITS[column.quantity])))
        raise ValueError(f"column {column.header!r}: unknown unit {column.unit!r}; known are {known}")
    return preferred[0] if preferred else None
