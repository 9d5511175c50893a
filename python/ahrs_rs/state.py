"""Snapshots of filters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

Snapshot: TypeAlias = tuple[list[float], float | None, int]
"""A state on the native side: variables, last stamp in s, number of samples."""


@dataclass(frozen=True, slots=True)
class State:
    """Everything that the next sample depends on: what ``Filter.state()`` and ``Estimate.state`` give.

    It can be pickled. A filter takes it back only where class, dtype, parameters, frame, declination and
    ``gyr_hold`` are the same.
    """

    filter: str
    """Name of the filter's class."""
    dtype: str
    """``"float32"`` or ``"float64"``."""
    settings: tuple[tuple[str, float | str | bool], ...]
    """Parameters and settings by name."""
    variables: tuple[float, ...]
    """The filter's variables, last angular rate, output sign and alignment."""
    last_t: float | None
    """Stamp of the last sample in s, where stamps were given."""
    samples: int
    """How many samples came since the start."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.variables)):
            raise ValueError("variables: expected finite numbers, got one that is not")
        if self.samples < 0:
            raise ValueError(f"samples: expected a number that is not negative, got {self.samples}")
        if self.last_t is not None and not math.isfinite(self.last_t):
            raise ValueError(f"last_t: expected a finite stamp or None, got {self.last_t}")

    def check(self, name: str, dtype: str, settings: tuple[tuple[str, float | str | bool], ...]) -> None:
        """Raise a ``ValueError`` that says what differs, if the state is of another filter."""
        if self.filter != name:
            raise ValueError(f"state: expected a state of {name}, got one of {self.filter}")
        if self.dtype != dtype:
            raise ValueError(f"state: expected dtype {dtype}, got {self.dtype}")
        if self.settings != settings:
            own = dict(settings)
            other = [f"{key}={value!r}" for key, value in self.settings if own.get(key) != value]
            expected = [f"{key}={own.get(key)!r}" for key, value in self.settings if own.get(key) != value]
            raise ValueError(f"state: expected {', '.join(expected)}, got {', '.join(other)}")
