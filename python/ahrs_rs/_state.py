"""Snapshots of filters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self, TypeAlias, cast

from ahrs_rs import _stored

__all__ = ["State"]

Snapshot: TypeAlias = tuple[list[float], float | None, int]
"""A state on the native side: variables, last stamp in s, number of samples."""
Setting: TypeAlias = float | str | bool
Settings: TypeAlias = tuple[tuple[str, Setting], ...]

FORMAT = "ahrs_rs.state"
#: A measurement whose square overflows is missing, so that no filter holds a larger number, but for rounding.
ROOM = 1.001
_ROOM = {name: ROOM * math.sqrt(largest) for name, largest in _stored.LARGEST.items()}


@dataclass(frozen=True, slots=True)
class State:
    """Everything that the next sample depends on: what ``Filter.state()`` and ``Estimate.state`` give.

    It can be pickled, and goes through JSON by `to_json` and `from_json`; whatever way it comes, it is checked.
    A filter takes it back only where class, dtype, parameters, frame, declination and ``gyr_hold`` are the same.

    Parameters
    ----------
    filter : str
        Name of the filter's class.
    dtype : str
        ``"float32"`` or ``"float64"``.
    settings : tuple
        Parameters and settings by name.
    variables : tuple of float
        The filter's variables, last angular rate, output sign and alignment.
    last_t : float, optional
        Stamp of the last sample in s, where stamps were given.
    samples : int
        How many samples came since the start.
    version : int, optional
        Of the format; states of another one are refused.

    Raises
    ------
    ValueError
        A value of a wrong type, one whose square is not finite in the dtype, another version of the format.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> f = ar.Mahony(rate=100.0)
    >>> q = f.update([0.0, 0.0, 0.1], [0.0, 0.0, 9.81])
    >>> text = f.state().to_json()
    >>> ar.State.from_json(text) == f.state()
    True
    """

    VERSION: ClassVar[int] = 1
    """Of the format. It grows when the variables of any filter change their meaning, order or number."""

    filter: str
    dtype: str
    settings: Settings
    variables: tuple[float, ...]
    last_t: float | None
    samples: int
    version: int = VERSION

    def __post_init__(self) -> None:
        _stored.check_version(self.VERSION, self.version)
        if not isinstance(self.filter, str):
            raise ValueError(f"filter: expected the name of a filter, got {_stored.shown(self.filter)}")
        _stored.dtype(self.dtype)
        # What came through JSON has lists in place of tuples.
        object.__setattr__(self, "settings", _settings(self.settings))
        object.__setattr__(self, "variables", _stored.variables(self.variables, _ROOM[self.dtype]))
        object.__setattr__(self, "last_t", _stored.stamp(self.last_t))
        object.__setattr__(self, "samples", _stored.count("samples", self.samples))

    @classmethod
    def _of_native(cls, filter: str, dtype: str, settings: Settings, snapshot: Snapshot) -> Self:
        """The state that a filter itself gives: of the right types for sure, so that only its numbers are checked."""
        variables, last_t, samples = snapshot
        # No number is larger than their norm.
        right = math.hypot(*variables) <= _ROOM[dtype] and samples <= _stored.MOST_SAMPLES
        if not (right and (last_t is None or math.isfinite(last_t))):
            return cls(filter, dtype, settings, tuple(variables), last_t, samples)
        self, put = object.__new__(cls), object.__setattr__
        put(self, "filter", filter)
        put(self, "dtype", dtype)
        put(self, "settings", settings)
        put(self, "variables", tuple(variables))
        put(self, "last_t", last_t)
        put(self, "samples", samples)
        put(self, "version", cls.VERSION)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # By the constructor, so that an unpickled state is checked as any other one is.
        fields = (self.filter, self.dtype, self.settings, self.variables, self.last_t, self.samples, self.version)
        return type(self), fields

    def __setstate__(self, state: object) -> None:
        """What a pickle calls that was written before states had a version."""
        _stored.check_version(self.VERSION, None)

    def to_json(self) -> str:
        """The state as a line of JSON, from which `from_json` makes the same state, bit for bit.

        Returns
        -------
        str
            One line.
        """
        content = {
            "filter": self.filter,
            "dtype": self.dtype,
            "settings": dict(self.settings),
            "last_t": self.last_t,
            "samples": self.samples,
            "variables": self.variables,
        }
        return _stored.to_json(FORMAT, self.version, content)

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """The state that `to_json` wrote; ``ValueError`` where the text is none, or one of another version.

        Parameters
        ----------
        text : str or bytes
            What `to_json` gave.

        Returns
        -------
        State
            The same state.
        """
        names = ("filter", "dtype", "settings", "variables", "last_t", "samples")
        return cls(**_stored.from_json(text, FORMAT, cls.VERSION, names))

    def check(self, name: str, dtype: str, settings: Settings) -> None:
        """Raise a ``ValueError`` that says what differs, if the state is of another filter.

        Parameters
        ----------
        name : str
            Of the filter's class.
        dtype : str
            "float32" or "float64".
        settings : tuple
            Parameters and settings by name.
        """
        self.__post_init__()  # a field may have been set in spite of the class
        if self.filter != name:
            raise ValueError(f"state: expected a state of {name}, got one of {self.filter}")
        if self.dtype != dtype:
            raise ValueError(f"state: expected dtype {dtype}, got {self.dtype}")
        own, other = dict(settings), dict(self.settings)
        lacking = [key for key in own if key not in other]
        unknown = [key for key in other if key not in own]
        if lacking or unknown:
            parts = [f"none of {', '.join(lacking)}"] if lacking else []
            parts += [f"{', '.join(unknown)}, which it has not"] if unknown else []
            raise ValueError(f"state: expected the settings of this version of {name}, got {' and '.join(parts)}")
        different = [key for key in own if own[key] != other[key]]
        if different:
            wanted, came = (", ".join(f"{key}={one[key]!r}" for key in different) for one in (own, other))
            raise ValueError(f"state: expected {wanted}, got {came}")


def _settings(value: object) -> Settings:
    pairs = list(value.items()) if isinstance(value, Mapping) else value
    if isinstance(pairs, Sequence) and not isinstance(pairs, (str, bytes)):
        pairs = [tuple(pair) if isinstance(pair, (tuple, list)) else () for pair in pairs]
        if all(
            len(pair) == 2 and isinstance(pair[0], str) and isinstance(pair[1], (float, int, str)) for pair in pairs
        ):
            return cast(Settings, tuple(pairs))
    raise ValueError(f"settings: expected pairs of names and values, got {_stored.shown(value)}")
