"""``ahrs-rs demo``: every filter on a simulated recording, without any file."""

from __future__ import annotations

import argparse
from pathlib import Path

from ahrs_rs import plots, simulate
from ahrs_rs._printable import printable
from ahrs_rs.cli import _common
from ahrs_rs.cli._common import Choice, CliError, Commands, Settings, Writers
from ahrs_rs.cli._compare import Comparison, table
from ahrs_rs.filters import FILTERS
from ahrs_rs.io import write_estimate

#: A day at 100 Hz has 8.6 million; far more do not fit into memory.
MOST_SAMPLES = 10_000_000

EPILOG = """\
Writes recording.npz (the sensor's readings and the true orientation), orientation.csv (the estimate of the
filter with the smallest error) and errors.png (errors of all filters over time; needs matplotlib).
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "demo",
        help="simulate a recording and compare all filters on it",
        description="Simulate a hand-held sensor with known orientation, and run every filter on it.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=demo)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("demo"),
        metavar="DIR",
        help="directory of the results, made if it is not there (default: %(default)s)",
    )
    numbers = (("duration", 60.0, "S", "length in s"), ("rate", 100.0, "HZ", "sampling rate in Hz"))
    for name, default, unit, text in numbers:
        parser.add_argument(
            f"--{name}",
            type=_common.positive,
            default=default,
            metavar=unit,
            help=f"{text} (default: %(default)g)",
        )
    parser.add_argument(
        "--seed", type=int, default=0, help="of the random motion and sensor errors (default: %(default)s)"
    )


def demo(args: argparse.Namespace) -> int:
    """The command."""
    files = [args.output / name for name in ("recording.npz", "orientation.csv", "errors.png")]
    recording_file, orientation_file, plot_file = files
    if args.duration * args.rate > MOST_SAMPLES:
        raise CliError(f"--duration: {args.duration:g} s at {args.rate:g} Hz are over {MOST_SAMPLES:,} samples")
    _prepare(args.output, files)
    try:
        plots.require_matplotlib()
        missing = ""
    except ImportError as error:
        missing = str(error)
    recording = simulate.demo(args.duration, args.rate, args.seed)
    settings = Settings()
    comparison = Comparison([Choice(cls, {}) for cls in FILTERS.values()], settings, plot=not missing)
    comparison.evaluate([("simulated recording", recording)], 1)
    if not comparison.results:
        raise CliError("--duration: the simulation has no sample that counts; make it longer")

    best = comparison.best()
    f = best.make(recording.rate, settings)
    est = f.run(recording)
    outputs: Writers = {
        recording_file: recording.save,
        orientation_file: lambda path: write_estimate(path, est.t, est.quat, est.gyr_bias, est.status),
    }
    if not missing:
        outputs[plot_file] = lambda path: plots.save(comparison.figure(), path)
    _common.write_all(outputs, folder=args.output)

    print(table(comparison.means(), 1))
    print()
    length = f"{len(recording)} samples at {recording.rate:g} Hz"
    print(f"wrote {printable(recording_file)}: {length} with the true orientation")
    print(f"wrote {printable(orientation_file)}: the estimate of {best.label}, which has the smallest total error")
    print(f"errors.png was not drawn: {missing}" if missing else f"wrote {printable(plot_file)}: the errors over time")
    return 0


def _prepare(directory: Path, files: list[Path]) -> None:
    """Check that the files can be written; the directory itself is made when there is something to write."""
    if directory.is_dir():
        for path in files:
            _common.check_output(path, "-o")
    elif directory.exists():
        raise CliError(f"-o: {directory} is not a directory")
    else:
        _common.check_output(directory, "-o")
