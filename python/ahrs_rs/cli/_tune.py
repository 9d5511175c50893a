"""``ahrs-rs tune``: the parameters of a filter with the smallest error on recordings with a reference."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ahrs_rs import tuning
from ahrs_rs._filter import Filter
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs.cli import _common, _reading
from ahrs_rs.cli._common import CliError, Commands, Settings
from ahrs_rs.tuning import Scores, Tuned

METRICS = ("total", "heading", "inclination")

EPILOG = """\
The error is the mean over the recordings of the root mean square in degrees, over the samples that have a reference and
count (mask). With --test the parameters are chosen on some of the recordings and judged on the others.

  ahrs-rs tune trials/*.hdf5 --filter madgwick --param beta --test 0.5 -o tuned.json
  ahrs-rs tune walk.csv --filter mahony --param kp=0.01:10 --param ki=0:1 --method evolve
  ahrs-rs tune walk.csv --filter madgwick --param beta --param gradient --checkpoint part.jsonl
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "tune",
        help="find the parameters of a filter with the smallest error",
        description="Search for the parameters of a filter with the smallest error on recordings with a reference.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=tune)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings (csv, parquet, npz, hdf5)")
    parser.add_argument("--filter", required=True, metavar="NAME", help="in any case, like madgwick")
    parser.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NAME[=WHERE]",
        help="a parameter to be searched, within LOW:HIGH or among A,B,C (default: around its default); may be "
        "repeated (default: every number of the filter)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter that is held at a value; may be repeated",
    )
    parser.add_argument(
        "--method",
        choices=("grid", "evolve"),
        default="grid",
        help="every combination, or a genetic search (default: %(default)s)",
    )
    parser.add_argument(
        "--metric", choices=METRICS, default="total", help="the error that is made small (default: %(default)s)"
    )
    parser.add_argument(
        "--test", type=_part, metavar="PART", help="which part of the files is kept for judging, as 0.3 (default: none)"
    )
    numbers = (
        ("points", 21, "grid: so many values of each number"),
        ("population", 15, "evolve: so many sets for each parameter"),
        ("generations", 50, "evolve: at most so many"),
    )
    for name, default, text in numbers:
        parser.add_argument(f"--{name}", type=_count, default=default, metavar="N", help=f"{text} (default: {default})")
    parser.add_argument(
        "--seed", type=whole_number, default=0, metavar="N", help="of the search and the files kept (default: 0)"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write what was found (json)")
    parser.add_argument(
        "--checkpoint",
        type=Path,
        metavar="FILE",
        help="keep what is computed there: the same command goes on from it after an interruption",
    )
    _reading.add_reading(parser)
    _common.add_settings(parser)


def tune(args: argparse.Namespace) -> int:
    """The command."""
    settings = Settings.of(args)
    cls = _common.find_filter(args.filter)
    fixed = _common.choose(cls, None, _common.assignments(args.set)).params
    params = _params(cls, args.param)
    both = [name for name in params or {} if name in fixed]
    if both:
        raise CliError(f"--param and --set: expected {both[0]} in one of them, got it in both")
    _check_outputs(args)
    recordings = [_recording(path, args, settings) for path in args.files]
    frames = sorted({_common.score_frame(recording, settings) for recording in recordings})
    if len(frames) > 1:
        raise CliError(f"expected references in one earth frame, got {' and '.join(frames)}")
    search: Any = tuning.grid if args.method == "grid" else tuning.evolve
    own: dict[str, Any] = (
        {"points": args.points}
        if args.method == "grid"
        else {"population": args.population, "generations": args.generations}
    )
    tuned: Tuned = search(
        cls,
        params,
        recordings,
        metric=args.metric,
        fixed=fixed,
        test=args.test,
        seed=args.seed,
        checkpoint=args.checkpoint,
        progress=True,
        frame=frames[0],
        declination=settings.declination,
        gyr_hold=settings.gyr_hold,
        **own,
    )
    if args.output is not None:
        tuned.save(args.output, [str(path) for path in args.files])
    _print(args, tuned, [line for recording in recordings for line in _reading.told(recording)])
    return 0


def _print(args: argparse.Namespace, tuned: Tuned, told: list[tuple[str, str]]) -> None:
    found = " ".join(f"{name}={_common.shown(value)}" for name, value in tuned.params.items())
    lines = [
        ("filter", tuned.filter),
        ("method", f"{tuned.method}, {tuned.evaluated} parameter sets"),
        ("found", found),
        ("train", _scores(args.metric, tuned.train)),
    ]
    if tuned.test is not None:
        lines.append(("test", _scores(args.metric, tuned.test)))
    lines.append(("use", " ".join(f"--set {name}={value}" for name, value in tuned.params.items())))
    if args.output is not None:
        lines.append(("wrote", str(args.output)))
    for key, text in [*lines, *dict.fromkeys(told)]:
        print(f"{key:<10} {printable(text)}")


def _scores(metric: str, scores: Scores) -> str:
    count = len(scores.recordings)
    over = f"mean over {count} files" if count > 1 else "one file"
    return f"{metric} RMSE {scores.mean:.3f}° ({over}; with the defaults {scores.default_mean:.3f}°)"


def _recording(path: Path, args: argparse.Namespace, settings: Settings) -> Recording:
    if not path.exists():
        raise CliError(f"{path}: no such file")
    recording = _reading.read(path, args)
    if not _common.scored(recording):
        raise CliError(f"{path}: no reference at any sample that counts")
    return _common.measurements(recording, settings)


def _check_outputs(args: argparse.Namespace) -> None:
    _common.check_outputs({"-o": args.output, "--checkpoint": args.checkpoint}, args.files)


def _params(cls: type[Filter], texts: Sequence[str]) -> dict[str, Any] | None:
    """What the options ``--param`` say; None where there is none of them."""
    wanted: dict[str, Any] = {}
    for text in texts:
        name, sign, where = (part.strip() for part in text.partition("="))
        if name not in cls.PARAMS:
            raise _common.unknown_parameter(f"{cls.NAME} has", name, cls.PARAMS)
        if sign and not where:
            raise CliError(f"--param: expected NAME, NAME=LOW:HIGH or NAME=A,B, got {text!r}")
        wanted[name] = _where(cls, name, where) if sign else None
    return wanted or None


def _where(cls: type[Filter], name: str, text: str) -> tuple[Any, ...] | list[Any]:
    separator = ":" if ":" in text else ","
    texts = [part.strip() for part in text.split(separator)]
    values = [_common.choose(cls, None, {name: part}).params[name] for part in texts]
    return tuple(values) if separator == ":" else values


def _part(text: str) -> float:
    part = _common.positive(text)
    if part >= 1.0:
        raise argparse.ArgumentTypeError(f"expected a part between 0 and 1, got {text!r}")
    return part


def _count(text: str) -> int:
    count = whole_number(text)
    if count < 1:
        raise argparse.ArgumentTypeError(f"expected a positive whole number, got {text!r}")
    return count


def whole_number(text: str) -> int:
    """A whole number that is not negative, for argparse."""
    try:
        seed = int(text)
    except ValueError:
        seed = -1
    if seed < 0:
        raise argparse.ArgumentTypeError(f"expected a whole number that is not negative, got {text!r}")
    return seed
