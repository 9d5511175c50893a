"""Where the parameters are looked for."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._filter import Filter
from ahrs_rs._param import Param
from ahrs_rs._sweep import require_class
from ahrs_rs._validate import did_you_mean

Value: TypeAlias = float | str | bool

#: A range whose ends differ by more than this factor is searched on a logarithmic scale.
DECADES = 100.0
#: Where the registry's range is only what is possible at all, the search goes so far around the default.
AROUND = 1000.0
#: More sets than that are a mistake.
MOST_SETS = 10_000_000


@dataclass(frozen=True, slots=True)
class Axis:
    """One parameter and where it is looked for.

    Parameters
    ----------
    name : str
        Of what is made.
    low : float
        Of a number; of a choice 0.
    high : float
        Of a number; of a choice the number of its options minus one.
    log : bool
        Whether the scale is logarithmic.
    options : tuple of float, str or bool, optional
        What there is to choose from.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> (beta,) = ar.tuning.space(ar.Madgwick, {"beta": (0.01, 1.0)})
    >>> beta.low, beta.high, beta.log
    (0.01, 1.0, False)
    """

    name: str
    low: float
    high: float
    log: bool
    options: tuple[Value, ...] | None = None

    @property
    def bounds(self) -> tuple[float, float]:
        """Of the coordinate."""
        return (math.log10(self.low), math.log10(self.high)) if self.log else (self.low, self.high)

    def value(self, coordinate: float) -> Value:
        """The parameter at a coordinate within the bounds.

        Parameters
        ----------
        coordinate : float
            Within `bounds`.

        Returns
        -------
        float, str or bool
            Of the parameter.
        """
        if self.options is not None:
            return self.options[round(coordinate)]
        first, last = self.bounds
        if not first < coordinate < last:  # the ends are exact, whatever a power of ten rounds to
            return self.low if coordinate <= first else self.high
        number = 10.0 ** float(coordinate) if self.log else float(coordinate)
        return min(max(number, self.low), self.high)

    def coordinate(self, value: Value) -> float | None:
        """Where a value lies, or None where it is outside.

        Parameters
        ----------
        value : float, str or bool
            Of the parameter.

        Returns
        -------
        float, optional
            None where it is outside.
        """
        if self.options is not None:
            return float(self.options.index(value)) if value in self.options else None
        if isinstance(value, (str, bool)) or not self.low <= value <= self.high:
            return None
        return math.log10(value) if self.log else value

    def points(self, count: int) -> list[Value]:
        """`count` values evenly spread over the scale, the ends among them, or all options.

        Parameters
        ----------
        count : int
            How many.

        Returns
        -------
        list of float, str or bool
            In increasing order.
        """
        if self.options is not None:
            return list(self.options)
        return [self.value(each) for each in np.linspace(*self.bounds, count)]


def space(filter: type[Filter], params: Sequence[str] | Mapping[str, Any] | None = None) -> list[Axis]:
    """The axes of a search.

    Parameters
    ----------
    filter : type
        The class, of ``ar.FILTERS``.
    params : sequence of str or mapping, optional
        The names of the parameters, or a dict from them to where they are looked for: a tuple (low,
        high), which is searched on a logarithmic scale where low is positive and high is more than
        100 times of it; a list of values; or None, for what the registry says. Without it, every
        number with a scale is searched.

    Returns
    -------
    list of Axis
        An axis for each parameter.

    Raises
    ------
    ValueError
        for a parameter that the filter does not have, a value out of its range, no scale, no parameter at all.

    Notes
    -----
    The registry's range of a number is where the filter works at all. Where it has a positive default, the search goes
    from a thousandth to a thousand times of that within the range, on a logarithmic scale; a number whose default is
    zero has no scale, and its range must be given. Of a choice all options are tried.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> [axis.name for axis in ar.tuning.space(ar.Mahony, ["kp", "ki"])]
    ['kp', 'ki']
    """
    filter = require_class(filter)
    if params is None:
        params = [name for name, param in filter.PARAMS.items() if _has_scale(param)]
    if isinstance(params, str):
        params = [params]
    wanted = dict(params) if isinstance(params, Mapping) else dict.fromkeys(params)
    if not wanted:
        raise ValueError(f"params: expected at least one parameter of {filter.NAME}, got none")
    unknown = [name for name in wanted if name not in filter.PARAMS]
    if unknown:
        known = ", ".join(filter.PARAMS) or "none"
        hint = did_you_mean(unknown[0], filter.PARAMS)
        raise ValueError(f"params: {filter.NAME} has no parameter {unknown[0]!r}{hint}; it has {known}")
    return [_axis(filter.PARAMS[name], where) for name, where in wanted.items()]


def combinations(axes: Sequence[Axis], points: int) -> list[dict[str, Value]]:
    """Every combination of `points` values of each number and all options, the last axis fastest."""
    sets = math.prod(points if axis.options is None else len(axis.options) for axis in axes)
    if sets > MOST_SETS:
        raise ValueError(f"points: {points} of each of {len(axes)} parameters make {sets} sets; take fewer, or evolve")
    values = [axis.points(points) for axis in axes]
    return [dict(zip([axis.name for axis in axes], each, strict=True)) for each in itertools.product(*values)]


def at(axes: Sequence[Axis], coordinates: NDArray[np.float64]) -> dict[str, Value]:
    """The parameters at a point of the space."""
    return {axis.name: axis.value(float(each)) for axis, each in zip(axes, coordinates, strict=True)}


def _has_scale(param: Param) -> bool:
    return param.options is None and float(param.default) > 0.0


def _axis(param: Param, where: Any) -> Axis:
    if isinstance(where, tuple):
        return _range(param, where)
    if where is not None:
        values = np.atleast_1d(np.asarray(where)).tolist()
        return _choice(param, values)
    if param.options is not None:
        return _choice(param, list(param.options))
    if not _has_scale(param):
        raise ValueError(f"params: {param.name} has the default 0 and so no scale; say where, as {param.name}=(0, 1)")
    default, (low, high) = float(param.default), param.range or (-math.inf, math.inf)
    low, high = max(low, default / AROUND), min(high, default * AROUND)
    return Axis(param.name, low, high, log=high > DECADES * low)


def _range(param: Param, where: tuple[Any, ...]) -> Axis:
    if param.options is not None or len(where) != 2:
        kind = "a number" if param.options is None else "a choice"
        raise ValueError(f"params: {param.name} is {kind}; expected (low, high) or a list of values, got {where!r}")
    low, high = param.encode(where[0]), param.encode(where[1])
    if not low < high:
        raise ValueError(f"params: expected low < high for {param.name}, got {where!r}")
    return Axis(param.name, low, high, log=low > 0.0 and high > DECADES * low)


def _choice(param: Param, values: list[Any]) -> Axis:
    if not values:
        raise ValueError(f"params: expected at least one value for {param.name}, got none")
    for value in values:
        param.encode(value)
    numbers = param.options is None
    options = tuple(float(value) if numbers else cast(Value, value) for value in values)
    return Axis(param.name, 0.0, float(len(options) - 1), log=False, options=options)
