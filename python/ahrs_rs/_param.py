"""A parameter of a filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ahrs_rs._validate import did_you_mean, number


@dataclass(frozen=True, slots=True)
class Param:
    """A parameter of a filter: where its constructor, stub, command line and docs come from."""

    name: str
    doc: str
    """Meaning."""
    unit: str
    """SI unit, or empty."""
    default: float | str | bool
    range: tuple[float, float] | None
    """Smallest and largest value of a number."""
    options: tuple[str, ...] | tuple[bool, ...] | None
    """The values of a choice, or (False, True) of a switch."""

    def encode(self, value: object) -> float:
        """The number by which the native side knows the value; ``ValueError`` where it is not allowed."""
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
