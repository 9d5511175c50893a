"""``ahrs-rs formats``: what is read and written."""

from __future__ import annotations

import argparse
import importlib.util
import json

from ahrs_rs import io
from ahrs_rs.cli._common import Commands


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "formats",
        help="list the formats that are read and written",
        description="List the formats that are read and written, with the libraries and extras that they need.",
        allow_abbrev=False,
    )
    parser.set_defaults(function=formats)
    parser.add_argument("--json", action="store_true", help="as JSON")


def formats(args: argparse.Namespace) -> int:
    """The command."""
    read, written = io.formats(), io.writers()
    if args.json:
        listed = {
            "read": {
                name: {
                    "title": one.title,
                    "endings": list(one.endings),
                    "library": one.library,
                    "extra": one.extra,
                    "options": sorted(one.options),
                    "note": one.note,
                }
                for name, one in read.items()
            },
            "written": {
                ending: {"title": one.title, "library": one.library, "extra": one.extra}
                for ending, one in written.items()
            },
        }
        print(json.dumps(listed, ensure_ascii=False, indent=2))
        return 0
    width = max(map(len, [*read, *written])) + 2
    print("read")
    for name, one in read.items():
        print(f"  {name:<{width}}{one.title}{_needs(one.library, one.extra)}")
        if one.note:
            print(f"  {'':<{width}}{one.note}")
    print("written")
    for ending, each in written.items():
        print(f"  {ending:<{width}}{each.title}{_needs(each.library, each.extra)}")
    return 0


def _needs(library: str, extra: str) -> str:
    """What has to be installed, where it is not."""
    if not library or importlib.util.find_spec(library.replace("-", "_").partition(" ")[0]) is not None:
        return f" ({library})" if library and extra else ""
    return f" (needs {library}: pip install ahrs-rs[{extra}])"
