"""The options of a reader in a small TOML file that can be shared."""

from __future__ import annotations

import os
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ahrs_rs.io._contents import Options

#: Option -> the types that it has in TOML.
_TYPES: dict[str, tuple[type, ...]] = {
    "columns": (dict, list),
    "units": (dict,),
    "axes": (str,),
    "separator": (str,),
    "decimal": (str,),
    "skip_rows": (int,),
    "sensor": (str,),
    "timezone": (str,),
    "rate": (int, float),
}


def with_layout(options: Options, layout: str | os.PathLike[str] | None) -> Options:
    """The options of a layout file, over which go those that are given; quantity by quantity for columns and units.

    Raises
    ------
    FileNotFoundError
    ValueError
        No TOML, an option that there is not, or one of another type.
    """
    if layout is None:
        return options
    import tomllib  # here: it is rarely asked for

    path = Path(layout)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: no such file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: is not a TOML file: {' '.join(str(error).split())}") from error
    changes: dict[str, Any] = {}
    for name, value in table.items():
        if name not in _TYPES:
            raise ValueError(f"{path}: expected options among {', '.join(_TYPES)}, got {name!r}")
        if not isinstance(value, _TYPES[name]) or isinstance(value, bool):
            expected = " or ".join(one.__name__ for one in _TYPES[name])
            raise ValueError(f"{path}: {name}: expected {expected}, got {value!r}")
        changes[name] = value
    for field in fields(Options):
        given, stated = getattr(options, field.name), changes.get(field.name)
        if isinstance(given, dict) and isinstance(stated, dict):
            changes[field.name] = {**stated, **given}
        elif given is not None:
            changes[field.name] = given
    return replace(options, **changes)
