"""A parameter of a filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ahrs_rs._validate import did_you_mean, number


@dataclass(frozen=True, slots=True)
class Param:
    """A parameter of a filter: where its constructor, stub, command line and docs come from.

    Parameters
    ----------
    name : str
        Of what is made.
    doc : str
        Meaning.
    unit : str
        SI unit, or empty.
    default : float, str or bool
        Value where none is given.
    range : tuple, optional
        Smallest and largest value of a number.
    options : tuple of str or tuple of bool, optional
        The values of a choice, or (False, True) of a switch.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.Madgwick.PARAMS["beta"].unit
    'rad/s'
    >>> ar.Madgwick.PARAMS["beta"].encode(0.5)
    0.5
    """

    name: str
    doc: str
    unit: str
    default: float | str | bool
    range: tuple[float, float] | None
    options: tuple[str, ...] | tuple[bool, ...] | None

    def encode(self, value: object) -> float:
        """The number by which the native side knows the value; ``ValueError`` where it is not allowed.

        Parameters
        ----------
        value : object
            A number, an option or a switch, as the parameter asks.

        Returns
        -------
        float
            A choice is its index, a switch 0 or 1.
        """
        if self.options is not None:
            kind = (bool, np.bool_) if isinstance(self.default, bool) else str
            if isinstance(value, kind) and value in self.options:
                return float(self.options.index(cast(Any, value)))
            wanted = f"one of {', '.join(map(repr, self.options))}"
            hint = did_you_mean(value, map(str, self.options))
            raise ValueError(f"{self.name}: expected {wanted}, got {value!r}{hint}")
        if type(value) is not float and np.ndim(cast(Any, value)) != 0:
            raise ValueError(f"{self.name}: expected a number, got {value!r}")
        value = number(self.name, value)
        low, high = self.range or (-np.inf, np.inf)
        if not low <= value <= high:
            unit = f" {self.unit}" if self.unit else ""
            raise ValueError(f"{self.name}: expected a number in [{low:g}, {high:g}]{unit}, got {value!r}")
        return value
