"""``ahrs-rs sensors``: what is in a file."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

from ahrs_rs import io
from ahrs_rs.cli._common import Commands


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "sensors",
        help="list the sensors of a file, with quantities, samples and rates",
        description="List the sensors of files or of devices' folders, mostly without reading them whole.",
        allow_abbrev=False,
    )
    parser.set_defaults(function=sensors)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings")
    parser.add_argument("--format", metavar="NAME", help="see `ahrs-rs formats` (default: found from the content)")
    parser.add_argument("--json", action="store_true", help="as JSON")


def sensors(args: argparse.Namespace) -> int:
    """The command."""
    found = {str(path): io.sensors(os.fspath(path), format=args.format) for path in args.files}
    if args.json:
        listed = {
            path: [{"name": one.name, "samples": dict(one.samples), "rates": dict(one.rates)} for one in each]
            for path, each in found.items()
        }
        print(json.dumps(listed, ensure_ascii=False, indent=2))
        return 0
    for path, each in found.items():
        print(path)
        for one in each:
            print(f"  {one}")
    return 0
