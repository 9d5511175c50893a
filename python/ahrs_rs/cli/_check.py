"""``ahrs-rs check``: what is wrong with recordings, from their readings alone."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ahrs_rs import _atomic
from ahrs_rs._check import Report, check, up_vector
from ahrs_rs._printable import printable
from ahrs_rs.cli import _common, _reading
from ahrs_rs.cli._common import CliError, Commands, Writers
from ahrs_rs.cli._place import place

EPILOG = """\
Each finding has a severity (ok, note, warning, error), a code, and how sure it is. Exit status: 0; 1 where there is an
error (with --strict: or a warning); 2 where a file could not be checked.

  ahrs-rs check walk.csv
  ahrs-rs check walk.csv --place 52.5,13.4,40 --date 2024.5 --up z
  ahrs-rs check walk.csv --fix right.parquet --html walk.html --json walk.json
"""
#: Exit status.
FOUND = 1


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "check",
        help="what is wrong with a recording: time, units, axes, signs, sensors",
        description="Find out what is wrong with recordings: time, units, axes, signs, and each of the sensors.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=run)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings (see `ahrs-rs formats`)")
    parser.add_argument("--place", type=place, metavar="LAT,LON,ALT", help="where it was recorded: °, °, m")
    parser.add_argument("--date", metavar="DATE", help="when: 2024-06-30, or 2024.5 (default: today)")
    parser.add_argument("--up", metavar="AXIS", help="which axis was up when the recording began, like z or -y")
    parser.add_argument("--strict", action="store_true", help="exit status 1 for warnings too")
    parser.add_argument("--brief", action="store_true", help="leave out what is right")
    parser.add_argument("--fix", type=Path, metavar="FILE", help="write the recording with what is sure put right")
    parser.add_argument(
        "--fix-notes", action="store_true", help="--fix also what filters cope with (see fixed(notes=))"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the findings")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write a page with plots (needs plotly)")
    _reading.add_reading(parser)
    _reading.add_reference(parser)


def run(args: argparse.Namespace) -> int:
    """The command."""
    outputs = {"--fix": args.fix, "--json": args.json, "--html": args.html}
    given = [option for option, path in outputs.items() if path is not None]
    if given and len(args.files) > 1:
        raise CliError(f"{given[0]}: expected one recording, got {len(args.files)}")
    if args.fix_notes and args.fix is None:
        raise CliError("--fix-notes: expected --fix, as it is about what is written")
    if args.fix is not None and args.fix.suffix.lower() not in (".npz", ".parquet", ".csv"):
        raise CliError(f"--fix: expected a name that ends in .npz, .parquet, .csv, got {args.fix.name!r}")
    if args.up is not None:
        up_vector(args.up)
    _common.check_outputs(outputs, args.files)
    gravest = 0
    for number, file in enumerate(args.files):
        recording = _reading.with_reference(_reading.read_doubtful(file, args), args)
        report = check(recording, place=args.place, date=args.date, up=args.up)
        if number:
            print()
        _tell(report, args.brief)
        for path in _written(report, args):
            print(f"{'wrote':<10} {printable(path)}")
        found = report.of("error") or (args.strict and report.of("warning"))
        gravest = max(gravest, FOUND if found else 0)
    return gravest


def _tell(report: Report, brief: bool) -> None:
    head = [(key, text) for key, text in _reading.head(report.recording) if key != _reading.HINT]
    lines = [f"{key:<10} {printable(text)}" for key, text in head]
    print("\n".join([*lines, "", *map(printable, report.table(everything=not brief).split("\n"))]))


def _written(report: Report, args: argparse.Namespace) -> list[Path]:
    writers: Writers = {}
    if args.fix is not None:
        fixed = report.fixed(notes=args.fix_notes)
        for text in fixed.meta.get("fixed", ["nothing: the recording is as it was"]):
            print(f"{'fixed':<10} {printable(text)}")
        writers[args.fix] = fixed.save
    if args.json is not None:
        text = json.dumps(report.to_dict(), ensure_ascii=False, indent=2, allow_nan=False)
        writers[args.json] = lambda path: _atomic.write_text(path, text + "\n")
    if args.html is not None:
        page = report.to_html()
        writers[args.html] = lambda path: _atomic.write_text(path, page)
    _common.write_all(writers)
    return list(writers)
