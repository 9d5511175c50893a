"""Checks of arguments, and the one form of their errors: ``name: expected …, got …``."""

from __future__ import annotations

import difflib
import operator
from collections.abc import Iterable
from typing import Any, cast


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """``" (did you mean beta?)"`` where one of the known names is close, whatever its case; else nothing."""
    by_name = {each.lower(): each for each in known}
    close = difflib.get_close_matches(name.lower(), by_name, n=1) if isinstance(name, str) else []
    return f" (did you mean {by_name[close[0]]}?)" if close else ""


def number(name: str, value: object) -> float:
    """The argument as a float; ``ValueError`` where it is no number."""
    if type(value) is float:
        return value
    if isinstance(value, (str, bytes, bool)):
        raise ValueError(f"{name}: expected a number, got {value!r}")
    try:
        return float(cast(Any, value))
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name}: expected a number, got {value!r}") from None


def choice(name: str, value: object, options: tuple[str, ...]) -> str:
    """The argument, one of the options; ``ValueError`` where it is none of them."""
    if not isinstance(value, str) or value not in options:
        wanted = ", ".join(map(repr, options))
        raise ValueError(f"{name}: expected one of {wanted}, got {value!r}{did_you_mean(value, options)}")
    return value


def thread_count(threads: int | None) -> int | None:
    """The number of threads; ``ValueError`` where it is none."""
    if threads is None:
        return None
    try:
        count = 0 if isinstance(threads, bool) else operator.index(threads)
    except TypeError:
        count = 0
    if count < 1:
        raise ValueError(f"threads: expected a positive whole number or None, got {threads!r}")
    return count
