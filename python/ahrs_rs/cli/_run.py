"""``ahrs-rs run``: one recording through one filter."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _quat, metrics
from ahrs_rs._constants import GRAVITY
from ahrs_rs._derived import DERIVED
from ahrs_rs._estimate import Estimate
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs._status import Status
from ahrs_rs.cli import _calibrated, _common, _place, _reading
from ahrs_rs.cli._common import Aligner, Choice, CliError, Commands, Settings
from ahrs_rs.cli._place import Place
from ahrs_rs.filters import FILTERS
from ahrs_rs.io import writers

#: Endings of files whose messages hold the readings too.
MESSAGES = (".mcap", ".ros2")

EPILOG = """\
A table has time, quaternion (scalar-first, sensor to earth), roll, pitch, yaw (rad), gyroscope bias
(rad/s) where the filter estimates one, and status bits. See `ahrs-rs filters` for filters and parameters.

  ahrs-rs run walk.csv --filter madgwick --set beta=0.08 -o walk.parquet
  ahrs-rs run walk.csv --filter vqf --calibration cal.json
  ahrs-rs run log.csv --filter vqf --units acc=g,gyr=deg/s,t=ms --axes x,-y,-z -o log.mcap
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
    endings = ", ".join(writers())
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=f"write the orientations ({endings}); without it: summary only",
    )
    parser.add_argument(
        "--outputs",
        metavar="NAMES",
        help="to be written too: of the filter, like covariance,nis (see `ahrs-rs filters NAME`), or of "
        + ", ".join(DERIVED),
    )
    parser.add_argument(
        "--gravity",
        type=_common.positive,
        metavar="G",
        help=f"of the place, for gravity and accelerations, m/s² (default: that of --place, or {GRAVITY})",
    )
    _place.add_option(parser, "its declination and gravity are taken (the extra earth)")
    parser.add_argument(
        "--date", metavar="DATE", help="of the field, like 2024-06-30 (default: the recording's, or today)"
    )
    parser.add_argument(
        "--linear-acceleration", action="store_true", help="write the acceleration in the earth frame too, m/s²"
    )
    parser.add_argument("--degrees", action="store_true", help="write angles in degrees, and say so in their names")
    _add_start(parser)
    _common.add_align(parser)
    _reading.add_reference(parser)
    _reading.add_reading(parser)
    _calibrated.add_option(parser)
    _common.add_settings(parser)


def run(args: argparse.Namespace) -> int:
    """The command."""
    settings, aligner = Settings.of(args), Aligner.of(args)
    choice = _common.choose(_common.find_filter(args.filter), args.preset, _common.assignments(args.set))
    outputs, derived = _outputs(args, choice)
    if args.output is not None:
        _check_output(args.output, args.file)
    elif outputs or derived or args.degrees or args.linear_acceleration:
        raise CliError("--outputs, --degrees, --linear-acceleration: expected -o, as they are about what is written")
    calibrations = _calibrated.given(args)
    recording = _reading.with_reference(_reading.read(args.file, args), args)
    recording, said = _calibrated.applied(calibrations, recording)
    start, place = _Start.of(args), Place.of(args, recording)
    settings, told = place.settings(settings)
    est = _estimate(choice, recording, settings, start, outputs=outputs)
    lines = _summary(choice, recording, settings, aligner, est, start) + told
    lines += [("note", note) for note in said]
    if args.output is not None:
        needed = args.linear_acceleration or args.output.suffix.lower() in MESSAGES or any(map(DERIVED.get, derived))
        beside = recording if needed else None
        est.save(
            args.output, recording=beside, degrees=args.degrees, outputs=derived, gravity=place.gravity(args.gravity)
        )
        lines.append(("wrote", str(args.output)))
    for key, text in lines:
        print(f"{key:<10} {printable(text)}")
    return 0


def _check_output(path: Path, source: Path) -> None:
    if path.suffix.lower() not in writers():
        raise CliError(f"-o: expected a name that ends in {', '.join(writers())}, got {path.name!r}")
    _common.check_output(path, "-o", [source])
    writers()[path.suffix.lower()].require()


def _outputs(args: argparse.Namespace, choice: Choice) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The outputs that are asked for: of the filter, and what follows from the attitudes."""
    every = tuple(name.strip() for name in (args.outputs or "").split(",") if name.strip())
    derived = tuple(name for name in every if name in DERIVED)
    names = tuple(name for name in every if name not in DERIVED)
    for name in names:
        if name not in choice.cls.OUTPUTS:
            known = ", ".join((*choice.cls.OUTPUTS, *DERIVED))
            raise CliError(f"--outputs: {choice.cls.NAME} has no output {name!r}; there are {known}")
    uncertain = [name for name in derived if name.endswith("_std")]
    if uncertain and "covariance" not in names:
        if "covariance" not in choice.cls.OUTPUTS:
            raise CliError(f"--outputs: {uncertain[0]}: expected a filter with a covariance, got {choice.cls.NAME}")
        names = (*names, "covariance")
    return names, derived


def _add_start(parser: argparse.ArgumentParser) -> None:
    """Options of the attitude at the start."""
    group = parser.add_argument_group("start")
    group.add_argument(
        "--heading",
        type=_common.finite,
        metavar="DEG",
        help="yaw of the start in the earth frame (default: from the magnetometer, or 0)",
    )
    group.add_argument("--q0", metavar="W,X,Y,Z", help="attitude of the start, sensor to earth frame, scalar-first")


@dataclass(frozen=True, slots=True)
class _Start:
    """The attitude that the user gives for the start."""

    heading: float | None = None
    """rad"""
    q0: tuple[float, ...] | None = None

    @classmethod
    def of(cls, args: argparse.Namespace) -> _Start:
        """As the arguments of `_add_start` say."""
        if args.heading is not None and args.q0 is not None:
            raise CliError("--heading and --q0: expected one of them")
        if args.q0 is None:
            return cls(None if args.heading is None else math.radians(args.heading))
        try:
            numbers = tuple(float(part) for part in args.q0.split(","))
        except ValueError:
            numbers = ()
        norm = math.hypot(*numbers)
        if len(numbers) != 4 or not (math.isfinite(norm) and norm > 0.0):
            raise CliError(f"--q0: expected four numbers W,X,Y,Z, got {args.q0!r}")
        return cls(None, tuple(number / norm for number in numbers))

    def quaternion(self, recording: Recording, frame: str) -> NDArray[np.float64] | None:
        """The quaternion of the start in an earth frame; None where the filter finds it."""
        if self.q0 is not None:
            return np.array(self.q0)
        if self.heading is None:
            return None
        acc = recording.require("acc")
        first = np.flatnonzero(~np.isnan(acc).any(axis=1))[:1]
        if not first.size:
            raise CliError(
                "--heading: expected an accelerometer with readings, which give the inclination of the start"
            )
        # The inclination by the first reading, turned about the vertical.
        tilt = FILTERS["Tilt"](rate=1.0, frame=frame).run(None, acc[first])
        turn = self.heading - float(tilt.euler()[0, 2])
        about: NDArray[np.float64] = np.array([math.cos(0.5 * turn), 0.0, 0.0, math.sin(0.5 * turn)])
        return _quat.multiply(about, np.asarray(tilt.quat[0], dtype=np.float64))


def _estimate(
    choice: Choice,
    recording: Recording,
    settings: Settings,
    start: _Start,
    frame: str | None = None,
    outputs: tuple[str, ...] = (),
) -> Estimate:
    f = choice.make(recording.rate, settings, frame)
    q0 = start.quaternion(recording, frame or settings.frame)
    return f.run(_common.measurements(recording, settings), q0=q0, outputs=outputs)


def _summary(
    choice: Choice, recording: Recording, settings: Settings, aligner: Aligner, est: Estimate, start: _Start
) -> list[tuple[str, str]]:
    lines = [
        *_reading.head(recording),
        *([("calibrated", " ".join(recording.meta["calibrated"]))] if recording.meta.get("calibrated") else []),
        ("filter", _description(choice, recording, settings)),
        ("status", _status_counts(est.status)),
        *_longest_step(est),
    ]
    count = _common.scored(recording)
    if recording.ref is not None and count:
        frame = _common.score_frame(recording, settings)
        if frame != settings.frame:
            est = _estimate(choice, recording, settings, start, frame)
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


def _longest_step(est: Estimate) -> list[tuple[str, str]]:
    """Where the clock leapt: its longest step and when."""
    if not np.any(est.status & Status.GAP):
        return []
    steps = np.diff(est.t)
    longest = int(np.argmax(steps))
    after = est.t[longest] - est.t[0]
    return [("gap", f"the longest step of the clock is {steps[longest]:.6g} s, after {after:.6g} s")]


def _status_counts(status: NDArray[np.uint16]) -> str:
    """How many samples have which bits set, like "MAG_MISSING 20 (0.3 %)"."""
    counts = {flag.name or "": int(np.count_nonzero(status & flag.value)) for flag in Status}
    parts = [f"{name} {count} ({100 * count / len(status):.3g} %)" for name, count in counts.items() if count]
    return ", ".join(parts) or "no flag at any sample"
