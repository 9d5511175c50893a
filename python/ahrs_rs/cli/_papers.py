"""``ahrs-rs papers``: the five papers reproduced."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ahrs_rs import io
from ahrs_rs._printable import printable
from ahrs_rs._progress import progress_bar
from ahrs_rs.cli._common import CliError, Commands
from ahrs_rs.cli._tune import whole_number
from ahrs_rs.papers import STUDIES, claims, plain, require_plotly, study, write_report

EPILOG = """\
Without names all five are run. Real recordings are those of BROAD, files *.hdf5 in DIR/broad or DIR itself.

  ahrs-rs papers --data recordings --out report
  ahrs-rs papers cirillo2014 ludwig2018
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "papers",
        help="reproduce the papers of the filters: tables beside the published ones, and which claims hold",
        description="Run the experiments of five papers on simulated and on real recordings, and judge their claims.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=papers)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(STUDIES)} (default: all)")
    parser.add_argument(
        "--data",
        type=Path,
        metavar="DIR",
        help="real recordings with a reference (default: the environment's AHRS_RS_DATA; without it: none)",
    )
    parser.add_argument("--seed", type=whole_number, default=0, metavar="N", help="of the simulations (default: 0)")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="write report.html and the tables as CSV files (needs plotly)"
    )


def papers(args: argparse.Namespace) -> int:
    """The command."""
    unknown = [name for name in args.names if name not in STUDIES]
    if unknown:
        raise CliError(f"unknown paper {unknown[0]!r}; there are {', '.join(STUDIES)}")
    if args.out is not None:
        _check_directory(args.out)
        require_plotly()
    files = find_recordings(args.data)
    recordings = [io.read(file) for file in files]
    names = list(dict.fromkeys(args.names)) or list(STUDIES)
    studies = [study(name, recordings, args.seed) for name in progress_bar(names, len(names), unit="paper")]
    for one in studies:
        print(f"{one.name}: {one.title}\n")
        for table in one.tables:
            print(plain(table) + "\n")
    print(plain(claims(studies)))
    if not recordings:
        print("\nno real recordings: set AHRS_RS_DATA, or give --data")
    if args.out is not None:
        written = write_report(studies, args.out, args.seed, [file.name for file in files])
        print(f"\nwrote {printable(written[0])} and {len(written) - 1} tables beside it")
    return 0


def find_recordings(folder: Path | None) -> list[Path]:
    """The files of the real recordings; none where no folder is given or set."""
    given = folder or (Path(os.environ["AHRS_RS_DATA"]) if os.environ.get("AHRS_RS_DATA") else None)
    if given is None:
        return []
    if not given.is_dir():
        raise CliError(f"--data: {given} is not a directory")
    files = sorted((given / "broad").glob("*.hdf5")) or sorted(given.glob("*.hdf5"))
    if not files:
        raise CliError(f"--data: {given} has no recording of BROAD (*.hdf5, or broad/*.hdf5)")
    return files


def _check_directory(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise CliError(f"--out: {path} is not a directory")
    if not path.parent.is_dir() and not path.is_dir():
        raise CliError(f"--out: {path}: there is no directory {path.parent}")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise CliError(f"--out: {path} cannot be written: permission denied")
