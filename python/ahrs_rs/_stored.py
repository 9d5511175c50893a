"""Snapshots that are stored: checked whatever way they come back, and with a version."""

from __future__ import annotations

import json
import math
import operator
from collections.abc import Mapping
from typing import Any, cast

from ahrs_rs import _json

#: The largest number of each dtype.
LARGEST = {"float32": 3.4028234663852886e38, "float64": 1.7976931348623157e308}
#: The native side counts samples in 64 bits.
MOST_SAMPLES = 2**63 - 1


def check_version(expected: int, came: object) -> None:
    """``ValueError`` for a snapshot of another version of its format; None is one that has none."""
    if came == expected and not isinstance(came, bool):
        return
    what = "none: it is of an earlier version of ahrs_rs" if came is None else shown(came)
    raise ValueError(f"state: expected version {expected} of the format, got {what}")


def to_json(format: str, version: int, content: Mapping[str, Any]) -> str:
    """A snapshot as a line of JSON; numbers are read back bit for bit."""
    return json.dumps({"format": format, "version": version, **content}, allow_nan=False)


def from_json(text: str | bytes, format: str, version: int, names: tuple[str, ...]) -> dict[str, Any]:
    """The fields of a snapshot that `to_json` wrote; ``ValueError`` where it is no such text."""
    try:
        content = _json.parse(text)
    except ValueError as error:
        raise ValueError(f"text: expected a state as JSON, got what {error}") from None
    if not isinstance(content, dict) or content.get("format") != format:
        raise ValueError(f'text: expected a state as JSON with "format": "{format}", got {shown(content)}')
    check_version(version, content.get("version"))
    missing = [name for name in names if name not in content]
    if missing:
        raise ValueError(f"text: expected a state with {', '.join(names)}, got none of {', '.join(missing)}")
    return {name: content[name] for name in names}


def dtype(value: object) -> str:
    """The name of a dtype that filters compute in."""
    if not (isinstance(value, str) and value in LARGEST):
        raise ValueError(f"dtype: expected one of {', '.join(LARGEST)}, got {shown(value)}")
    return value


def variables(values: object, largest: float) -> tuple[float, ...]:
    """Numbers that are no larger."""
    if isinstance(values, tuple) and set(map(type, values)) <= {float}:
        numbers = values
    else:
        try:
            numbers = tuple(number(value) for value in cast(Any, values))
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"variables: expected numbers, got {shown(values)}") from None
    # There are a thousand of some filters, and a check at every run: so no loop of Python's for those that are right.
    if not (all(map(math.isfinite, numbers)) and max(map(abs, numbers), default=0.0) <= largest):
        bad = next(value for value in numbers if not abs(value) <= largest)
        raise ValueError(f"variables: expected numbers up to {largest:.3g}, got {bad}")
    return numbers


def stamp(value: object) -> float | None:
    """A stamp in s, or None."""
    if value is None:
        return None
    try:
        seconds = number(value)
    except (TypeError, ValueError, OverflowError):
        seconds = math.nan
    if not math.isfinite(seconds):
        raise ValueError(f"last_t: expected a finite stamp or None, got {shown(value)}")
    return seconds


def count(name: str, value: object) -> int:
    """A whole number that is not negative."""
    try:
        whole = -1 if isinstance(value, bool) else operator.index(cast(Any, value))
    except TypeError:
        whole = -1
    if not 0 <= whole <= MOST_SAMPLES:
        raise ValueError(f"{name}: expected a whole number that is not negative, got {shown(value)}")
    return whole


def number(value: object) -> float:
    """The value as a float, where it is a number and no text of one."""
    if isinstance(value, (str, bytes, bool)):
        raise TypeError
    return float(cast(Any, value))


def shown(value: object) -> str:
    """The value for a message, not more than fits into a line."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."
