"""``ahrs-rs view``: recordings as one page that plays them."""

from __future__ import annotations

import argparse
from functools import reduce
from operator import add
from pathlib import Path

from ahrs_rs import _atomic
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs._view import View, require_plotly, view
from ahrs_rs.cli import _calibrated, _common, _reading
from ahrs_rs.cli._common import Choice, CliError, Commands, Settings

EPILOG = """\
The page is one file, and needs no network: the board in space, played, slowed and scrubbed, with angles and status in
plots below. The first filter is the board, the others and the reference are outlines about it.

  ahrs-rs view walk.csv --filter vqf -o walk.html
  ahrs-rs view trial1.hdf5 trial2.hdf5 --filter vqf,madgwick -o trials.html
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "view",
        help="a page that plays recordings in 3D",
        description="Run filters on recordings, and write one page that plays them.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=run)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings (see `ahrs-rs formats`)")
    parser.add_argument("--filter", required=True, metavar="NAMES", help="in any case, like vqf,madgwick")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("view.html"), metavar="FILE", help="the page (default: %(default)s)"
    )
    _reading.add_reference(parser)
    _reading.add_reading(parser)
    _calibrated.add_option(parser)
    _common.add_settings(parser)


def run(args: argparse.Namespace) -> int:
    """The command."""
    names = [name.strip() for name in args.filter.split(",") if name.strip()]
    if not names:
        raise CliError("--filter: expected names like vqf,madgwick")
    choices = [Choice(_common.find_filter(name), {}) for name in dict.fromkeys(names)]
    if args.output.suffix.lower() not in (".html", ".htm"):
        raise CliError(f"-o: expected a name that ends in .html, got {args.output.name!r}")
    _common.check_output(args.output, "-o", args.files)
    require_plotly()
    settings, calibrations = Settings.of(args), _calibrated.given(args)
    views, lines = [], []
    for file in args.files:
        recording = _reading.with_reference(_reading.read(file, args), args)
        recording, said = _calibrated.applied(calibrations, recording)
        lines += [("note", note) for note in said] + _reading.told(recording)
        views.append(_view(choices, recording, settings))
    page = reduce(add, views).to_html()
    _atomic.write_text(args.output, page)
    for key, text in [*dict.fromkeys(lines), ("wrote", f"{args.output} ({len(page.encode()) / 1e6:.1f} MB)")]:
        print(f"{key:<10} {printable(text)}")
    return 0


def _view(choices: list[Choice], recording: Recording, settings: Settings) -> View:
    used = _common.measurements(recording, settings)
    frame = _common.score_frame(recording, settings)
    estimates = {choice.cls.NAME: choice.make(recording.rate, settings, frame).run(used) for choice in choices}
    return view(recording, estimates)
