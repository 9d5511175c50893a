"""The public objects of the package, as numpydoc's validator and the doctests take them."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from typing import Any

import ahrs_rs as ar

#: Classes without underscore that stand in private files only.
PRIVATE = ("Table", "Engine")
#: The documented namespaces with an API; `cli` is a program.
NAMESPACES = (
    "attitude",
    "calibration",
    "chain",
    "filters",
    "io",
    "metrics",
    "papers",
    "plots",
    "rotation",
    "signal",
    "simulate",
    "tuning",
)


def public() -> dict[str, Any]:
    """The public classes and functions by the name under which they are found, each once."""
    found: dict[str, Any] = {}
    seen: set[int] = set()
    for module in (ar, *(importlib.import_module(f"ahrs_rs.{name}") for name in NAMESPACES)):
        for name in module.__all__:
            value = getattr(module, name)
            if (inspect.isclass(value) or inspect.isfunction(value)) and id(value) not in seen:
                seen.add(id(value))
                found[f"{module.__name__}.{name}"] = value
    return found


def members(name: str, cls: type) -> Iterator[tuple[str, Any]]:
    """The public methods and properties of a class, by name; not those that another public class has declared."""
    bases = [base for base in cls.__mro__ if base.__module__.startswith("ahrs_rs")]
    inherited = {key for base in bases[1:] if not base.__name__.startswith("_") for key in vars(base)}
    if not (issubclass(cls, ar.Filter) and cls is not ar.Filter):
        inherited -= {key for base in bases if base.__name__ in PRIVATE for key in vars(base)}
    for key in dict.fromkeys(key for base in bases for key in vars(base)):
        if key in inherited:
            continue
        value = inspect.getattr_static(cls, key)
        plain = value.__func__ if isinstance(value, (classmethod, staticmethod)) else value
        if not key.startswith("_") and (inspect.isfunction(plain) or isinstance(plain, property)):
            yield f"{name}.{key}", value
