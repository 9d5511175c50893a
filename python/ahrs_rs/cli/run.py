"""``ahrs-rs run``: one recording through one filter."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import metrics
from ahrs_rs._printable import printable
from ahrs_rs.cli import _common, _reading, calibrate
from ahrs_rs.cli._common import Aligner, Choice, CliError, Commands, Settings
from ahrs_rs.estimate import Estimate
from ahrs_rs.io import write_estimate
from ahrs_rs.io._contents import require
from ahrs_rs.io._estimate import WRITERS
from ahrs_rs.recording import Recording
from ahrs_rs.status import Status

EPILOG = """\
The output has time, quaternion (scalar-first, sensor to earth), roll, pitch, yaw (rad), gyroscope bias
(rad/s) where the filter estimates one, and status bits. See `ahrs-rs filters` for filters and parameters.

  ahrs-rs run walk.csv --filter madgwick --set beta=0.08 -o walk.parquet
  ahrs-rs run walk.csv --filter vqf --calibration cal.json
  ahrs-rs run walk.csv --filter mahony --preset cocoli2023 --frame NED --declination 4.5
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "run",
        help="estimate the orientations of one recording",
        description="Estimate the orientations of one recording, print a summary, and write them to a file.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=run)
    parser.add_argument("file", type=Path, metavar="FILE", help="recording (csv, parquet, npz, hdf5)")
    parser.add_argument("--filter", required=True, metavar="NAME", help="in any case, like madgwick")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the filter; may be repeated",
    )
    parser.add_argument("--preset", metavar="NAME", help="the parameters of a paper; --set goes over them")
    endings = ", ".join(WRITERS)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"write the orientations ({endings}); without it: summary only",
    )
    _common.add_align(parser)
    _reading.add_reading(parser)
    calibrate.add_option(parser)
    _common.add_settings(parser)


def run(args: argparse.Namespace) -> int:
    """The command."""
    settings, aligner = Settings.of(args), Aligner.of(args)
    choice = _common.choose(_common.find_filter(args.filter), args.preset, _common.assignments(args.set))
    if args.output is not None:
        _check_output(args.output, args.file)
    calibrations = calibrate.given(args)
    recording = _reading.read(args.file, args)
    recording, said = calibrate.applied(calibrations, recording)
    est = _estimate(choice, recording, settings)
    lines = _summary(choice, recording, settings, aligner, est)
    lines += [("note", note) for note in said]
    if args.output is not None:
        write_estimate(args.output, est.t, est.quat, est.gyr_bias, est.status)
        lines.append(("wrote", str(args.output)))
    for key, text in lines:
        print(f"{key:<10} {printable(text)}")
    return 0


def _check_output(path: Path, source: Path) -> None:
    if path.suffix.lower() not in WRITERS:
        raise CliError(f"-o: expected a name that ends in {', '.join(WRITERS)}, got {path.name!r}")
    _common.check_output(path, "-o", [source])
    if path.suffix.lower() == ".parquet":
        require("pyarrow")


def _estimate(choice: Choice, recording: Recording, settings: Settings, frame: str | None = None) -> Estimate:
    f = choice.make(recording.rate, settings, frame)
    return f.run(_common.measurements(recording, settings))


def _summary(
    choice: Choice, recording: Recording, settings: Settings, aligner: Aligner, est: Estimate
) -> list[tuple[str, str]]:
    lines = [
        *_reading.head(recording),
        *([("calibrated", " ".join(recording.meta["calibrated"]))] if recording.meta.get("calibrated") else []),
        ("filter", _description(choice, recording, settings)),
        ("status", _status_counts(est.status)),
    ]
    count = _common.scored(recording)
    if recording.ref is not None and count:
        frame = _common.score_frame(recording, settings)
        if frame != settings.frame:
            est = _estimate(choice, recording, settings, frame)
        quat, ref, said = aligner.pair(est.quat, recording)
        errors = metrics.score(quat, ref, recording.mask)
        parts = f"total {errors.total:.2f}°, heading {errors.heading:.2f}°, inclination {errors.inclination:.2f}°"
        how = f"in {frame}, aligned" if aligner else f"in {frame}"
        lines.append(("RMSE", f"{parts} (over {count} samples with a reference, {how})"))
        lines += [("note", note) for note in said]
    lines += [("note", note) for note in _common.notes(recording, settings, aligner)]
    return lines


def _description(choice: Choice, recording: Recording, settings: Settings) -> str:
    f = choice.make(recording.rate, settings)
    params = " ".join(f"{name}={_common.shown(value)}" for name, value in f.params.items())
    used = _common.measurements(recording, settings)
    given = [name for name in ("gyr", "acc", "mag") if getattr(used, name) is not None]
    return f"{f'{f.NAME} {params}'.rstrip()}, from {' '.join(given)}, in {f.frame}"


def _status_counts(status: NDArray[np.uint16]) -> str:
    """How many samples have which bits set, like "MAG_MISSING 20 (0.3 %)"."""
    counts = {flag.name or "": int(np.count_nonzero(status & flag.value)) for flag in Status}
    parts = [f"{name} {count} ({100 * count / len(status):.3g} %)" for name, count in counts.items() if count]
    return ", ".join(parts) or "no flag at any sample"
