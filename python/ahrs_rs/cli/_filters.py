"""``ahrs-rs filters``: what the filter classes say of themselves."""

from __future__ import annotations

import argparse
import json
import math
import shutil
import textwrap
from typing import Any

from ahrs_rs._filter import Filter
from ahrs_rs._param import Param
from ahrs_rs.cli import _common
from ahrs_rs.cli._common import Commands
from ahrs_rs.filters import FILTERS


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "filters",
        help="list the filters, or describe one with its parameters",
        description="List the filters, or describe one with parameters, units, ranges, presets, source.",
        allow_abbrev=False,
    )
    parser.set_defaults(function=filters)
    parser.add_argument("name", nargs="?", metavar="NAME", help="of a filter, in any case (default: all in short)")
    parser.add_argument("--json", action="store_true", help="everything, for programs")


def filters(args: argparse.Namespace) -> int:
    """The command."""
    chosen = None if args.name is None else _common.find_filter(args.name)
    if args.json:
        data = [describe(cls) for cls in FILTERS.values()] if chosen is None else describe(chosen)
        print(json.dumps(data, ensure_ascii=False, indent=2, allow_nan=False))
    elif chosen is not None:
        print(_long_text(chosen))
    else:
        print("\n".join(_short_text(cls) for cls in FILTERS.values()))
        print("\nParameters, presets and source of one: ahrs-rs filters NAME")
    return 0


def describe(cls: type[Filter]) -> dict[str, Any]:
    """The metadata of a filter class as JSON knows it; a bound that is infinite is null."""
    return {
        "name": cls.NAME,
        "doc": _doc(cls),
        "source": cls.SOURCE,
        "sensors": _sensors(cls),
        "streaming": cls.STREAMING,
        "feedback": cls.FEEDBACK,
        "equivariance": cls.EQUIVARIANCE,
        "params": [_param(param) for param in cls.PARAMS.values()],
        "presets": {name: dict(values) for name, values in cls.PRESETS.items()},
        "outputs": dict(cls.OUTPUTS),
    }


def _param(param: Param) -> dict[str, Any]:
    return {
        "name": param.name,
        "doc": param.doc,
        "unit": param.unit,
        "default": param.default,
        "range": param.range and [bound if math.isfinite(bound) else None for bound in param.range],
        "options": param.options and list(param.options),
    }


def _doc(cls: type[Filter]) -> str:
    """What the filter does: the first paragraph of the class's docstring."""
    return " ".join((cls.__doc__ or "").partition("\n\n")[0].split())


def _sensors(cls: type[Filter]) -> str:
    return "9D" if cls.MAGNETOMETER else "6D"


def _short_text(cls: type[Filter]) -> str:
    width = max(map(len, FILTERS)) + 2
    kind = _sensors(cls) + ("" if cls.STREAMING else ", offline")
    names = " ".join(f"{name}={_common.shown(param.default)}" for name, param in cls.PARAMS.items())
    margin = " " * width
    lines = [_wrap(_doc(cls), f"{cls.NAME:<{width}}", margin), _wrap(f"{kind}. {names}".rstrip(". "), margin)]
    return "\n".join(lines)


def _long_text(cls: type[Filter]) -> str:
    sensors = (
        "gyroscope, accelerometer, magnetometer (9D; 6D without it)"
        if cls.MAGNETOMETER
        else "gyroscope, accelerometer (6D; a magnetometer gives the initial heading)"
    )
    lines = [cls.NAME, "", _wrap(_doc(cls)), ""]
    lines.append(_wrap(cls.SOURCE, "source     ", " " * 11))
    lines.append(_wrap(sensors, "sensors    ", " " * 11))
    streaming = "sample by sample or whole recordings" if cls.STREAMING else "whole recordings only"
    lines.append(f"computes   {streaming}")
    lines.append(_wrap(_mounting(cls), "mounting   ", " " * 11))
    lines += ["", "parameters" if cls.PARAMS else "no parameters"]
    for param in cls.PARAMS.values():
        lines += [
            "",
            f"  {param.name} = {_common.shown(param.default)} {param.unit}".rstrip(),
            _wrap(param.doc, " " * 6),
        ]
        lines.append(_wrap(_allowed(param), " " * 6))
    if cls.PRESETS:
        lines += ["", "presets"]
        for name, values in cls.PRESETS.items():
            text = " ".join(f"{key}={_common.shown(value)}" for key, value in values.items())
            lines.append(_wrap(text, f"  {name:<14} ", " " * 17))
    if cls.OUTPUTS:
        lines += ["", "further outputs (of Filter.run in Python)"]
        lines += [_wrap(doc, f"  {name:<14} ", " " * 17) for name, doc in cls.OUTPUTS.items()]
    return "\n".join(lines)


def _mounting(cls: type[Filter]) -> str:
    laws = {
        "exact": "the choice of the sensor's axes does not change the estimate",
        "heading": "the choice of the sensor's axes changes the estimate by a constant heading only",
    }
    reason = cls.EQUIVARIANCE.removeprefix("no: ")
    return laws.get(cls.EQUIVARIANCE, f"the choice of the sensor's axes changes the estimate: {reason}")


def _allowed(param: Param) -> str:
    if param.options is not None:
        return f"one of {', '.join(map(str, param.options))}"
    low, high = param.range or (-math.inf, math.inf)
    return f"from {low:g} to {high:g} {param.unit}".rstrip()


def _wrap(text: str, first: str = "", others: str | None = None) -> str:
    """The text in lines that a terminal shows, never longer than 100 characters."""
    width = min(shutil.get_terminal_size((100, 24)).columns, 100)
    margin = first if others is None else others
    return textwrap.fill(text, max(width, 40), initial_indent=first, subsequent_indent=margin, break_on_hyphens=False)
