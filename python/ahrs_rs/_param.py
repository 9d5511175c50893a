"""A parameter of a filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np


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
            raise ValueError(f"{self.name} must be one of {', '.join(map(repr, self.options))}, got {value!r}")
        if type(value) is float:
            number = value
        elif isinstance(value, (str, bytes, bool)) or np.ndim(cast(Any, value)) != 0:
            raise ValueError(f"{self.name} must be a number, got {value!r}")
        else:
            try:
                number = float(cast(Any, value))
            except (TypeError, ValueError, OverflowError):
                raise ValueError(f"{self.name} must be a number, got {value!r}") from None
        low, high = self.range or (-np.inf, np.inf)
        if not low <= number <= high:
            raise ValueError(f"{self.name} must be in [{low:g}, {high:g}] {self.unit}, got {number!r}")
        return number
