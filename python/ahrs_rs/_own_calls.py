"""How a filter of a user's own is called: what it asks for, its parameters, and checks of what it gives."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ahrs_rs._param import Param
from ahrs_rs._typing import BoolArray, FloatArray
from ahrs_rs._validate import number

#: What a class or function may ask for by name; its other arguments are parameters.
ROWS = ("gyr", "acc", "mag", "dt")
DATA = ("gyr", "acc", "mag", "t", "rate", "recording")
#: What the constructors of all filters take, and hand on where a filter of one's own asks for it.
SETTINGS = ("rate", "frame", "declination", "gyr_hold", "repeated", "gyr_range")
#: The turns from each earth frame into east-north-up, as quaternions.
HALF = 0.5**0.5
TO_ENU = {"ENU": (1.0, 0.0, 0.0, 0.0), "NED": (0.0, HALF, HALF, 0.0), "NWU": (HALF, 0.0, 0.0, HALF)}
ORDERS = ("wxyz", "xyzw")
#: Quaternions of another norm are none.
NORMS = (0.5, 2.0)


def checked(name: str, quat: FloatArray, count: int, order: str) -> FloatArray:
    """Quaternions (T, 4), scalar-first and of unit norm; rows with NaN stay as they are."""
    if quat.shape != (count, 4):
        raise ValueError(f"{name}: expected quaternions of shape ({count}, 4), got {quat.shape}")
    norm = np.linalg.norm(quat, axis=1, keepdims=True)
    wrong = np.flatnonzero(~np.isnan(norm[:, 0]) & ~((norm[:, 0] >= NORMS[0]) & (norm[:, 0] <= NORMS[1])))
    if wrong.size:
        raise ValueError(f"{name}: expected quaternions of norm 1, got {norm[wrong[0], 0]:.3g} at row {wrong[0]}")
    unit: FloatArray = quat / norm
    return unit if order == "wxyz" else unit[:, [3, 0, 1, 2]]


def continuous(quat: FloatArray) -> FloatArray:
    """The same rotations with the sign that is nearer to the row before."""
    filled = quat.copy()
    known = np.flatnonzero(~np.isnan(quat).any(axis=1))
    if known.size:
        part = quat[known]
        flips = np.cumprod(np.where((part[1:] * part[:-1]).sum(axis=1) < 0, -1.0, 1.0))
        filled[known[1:]] = part[1:] * flips[:, None]
    return filled


def parameters(thing: Any) -> dict[str, Param]:
    """The arguments with a default, and what the attribute PARAMS says of them."""
    told: Mapping[str, Any] = getattr(thing, "PARAMS", {})
    found = {}
    needed = [
        name
        for name, one in arguments(thing).items()
        if one.default is one.empty and one.kind is one.POSITIONAL_OR_KEYWORD
    ]
    # A function whose names are all others is given what there is in order.
    in_order = not isinstance(thing, type) and len(needed) <= 4 and not any(name in DATA for name in needed)
    for name, argument in arguments(thing).items():
        if name in (*DATA, *SETTINGS) or argument.kind in (argument.VAR_KEYWORD, argument.VAR_POSITIONAL):
            continue
        if in_order and name in needed:
            continue
        where, default = told.get(name), argument.default
        if isinstance(where, Param):
            found[name] = where
        elif isinstance(default, bool):
            found[name] = Param(name, "", "", default, None, (False, True))
        elif isinstance(default, str):
            found[name] = Param(name, "", "", default, None, tuple(map(str, where or (default,))))
        elif isinstance(default, (int, float)):
            limits = None if where is None else (number(name, where[0]), number(name, where[1]))
            found[name] = Param(name, "", "", float(default), limits, None)
        elif default is argument.empty:
            raise TypeError(f"{name}: expected an argument with a default, which is a parameter, got one without")
    return found


def arguments(thing: Any) -> dict[str, inspect.Parameter]:
    return dict(inspect.signature(thing).parameters)


def names(thing: Any) -> tuple[str, ...]:
    return tuple(arguments(thing))


def by_name(function: Callable[..., Any], known: tuple[str, ...]) -> tuple[str, ...]:
    """The names that a function asks for, if it knows them all; else none: it is given everything in order."""
    wanted = [
        name
        for name, one in arguments(function).items()
        if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY) and one.default is one.empty
    ]
    return tuple(wanted) if wanted and all(name in known for name in wanted) else ()


def called(
    function: Callable[..., Any],
    given: Mapping[str, Any],
    order: tuple[str, ...],
    params: Mapping[str, Any] | None = None,
) -> Any:
    """A function with what it asks for by name; or, where its names are others, as many as it takes in order."""
    own = arguments(function)
    if all(name in given or name in (params or {}) for name in own):
        return function(**{name: {**given, **(params or {})}[name] for name in own})
    needed = [one for one in own.values() if one.default is one.empty and one.kind is one.POSITIONAL_OR_KEYWORD]
    return function(*(given[name] for name in order[: len(needed)]), **(params or {}))


def rows_of(rows: FloatArray | None, count: int) -> list[FloatArray | None]:
    if rows is None:
        return [None] * count
    there: BoolArray = np.asarray(~np.isnan(rows).any(axis=1))
    return [row if one else None for row, one in zip(rows, there, strict=True)]
