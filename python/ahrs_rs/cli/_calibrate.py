"""``ahrs-rs calibrate``: calibrations of a sensor's parts from recordings; and the option by which they are applied."""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import math
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ahrs_rs import _atomic, calibration, plots
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration import Calibration, CalibrationError, Calibrations, CalibrationWarning
from ahrs_rs.cli import _calibrated, _common, _reading
from ahrs_rs.cli._common import CliError, Commands, Writers
from ahrs_rs.filters import FILTERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


EPILOG = """\
cal.json holds one or several sensors: calibrating another one adds it. `ahrs-rs run --calibration cal.json` applies it.

  ahrs-rs calibrate mag turned-in-all-directions.csv -o cal.json --plot
  ahrs-rs calibrate acc held-in-many-attitudes.csv -o cal.json
  ahrs-rs calibrate gyr turns.csv --turns x=360,y=360,z=360 -o cal.json
  ahrs-rs calibrate mag-delay turned-quickly-to-and-fro.csv
  ahrs-rs calibrate export cal.json --rust calibration.rs --c-header calibration.h
"""


def add_parser(commands: Commands) -> None:
    """The parsers of this command and of what it calibrates."""
    parser = commands.add_parser(
        "calibrate",
        help="calibrate magnetometer, accelerometer or gyroscope from a recording",
        description="Calibrate a sensor: y = S (x - b).",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=_no_sensor)
    sensors = parser.add_subparsers(title="sensors", metavar="SENSOR")
    mag = _sensor(sensors, "mag", "magnetometer: hard iron, scale, soft iron; turned in all directions", magnetometer)
    _ellipsoid_options(mag, 9)
    mag.add_argument(
        "--norm", type=_common.positive, metavar="UT", help="of the local field, µT (default: estimated, det S = 1)"
    )
    acc = _sensor(sensors, "acc", "accelerometer: scale and offset; held still in many attitudes", accelerometer)
    _ellipsoid_options(acc, 6)
    acc.add_argument(
        "--method",
        choices=("rest", "robust", "positions"),
        default="rest",
        help="windows at rest, all readings with motion as outliers, or six (or more) positions that were held "
        "(default: %(default)s)",
    )
    acc.add_argument(
        "--gravity",
        type=_common.positive,
        default=calibration.GRAVITY,
        metavar="G",
        help="local gravity, m/s² (default: %(default)s)",
    )
    gyr = _sensor(sensors, "gyr", "gyroscope: bias from rests, gain from known turns or a reference", gyroscope)
    how = gyr.add_mutually_exclusive_group()
    how.add_argument(
        "--turns",
        metavar="AXIS=DEG,...",
        help="the turns between the rests of the recording in their order, like x=360,y=-360,z=360",
    )
    how.add_argument("--reference", action="store_true", help="compare with the recording's reference orientation")
    text = "how late the magnetometer is behind the gyroscope; turned quickly to and fro"
    late = sensors.add_parser("mag-delay", help=text, description=text, allow_abbrev=False)
    late.set_defaults(function=magnetometer_delay)
    late.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings of one sensor, each on its own")
    late.add_argument(
        "--window", type=_common.positive, default=1.0, metavar="S", help="over which the field may have any slope, s"
    )
    _reading.add_reading(late)
    _calibrated.add_option(late)
    export = sensors.add_parser("export", help="cal.json as source code for firmware", allow_abbrev=False)
    export.set_defaults(function=write_sources)
    export.add_argument("file", type=Path, metavar="FILE", help="cal.json")
    _source_options(export)


def _no_sensor(args: argparse.Namespace) -> int:
    raise CliError("expected a sensor: mag, acc, gyr, mag-delay, or export (see ahrs-rs calibrate --help)")


def _sensor(
    sensors: Any, name: str, text: str, function: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = sensors.add_parser(name, help=text, description=text, allow_abbrev=False)
    parser.set_defaults(function=function, sensor=name)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings, taken together")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="cal.json to write, or to add this sensor to")
    _source_options(parser)
    _reading.add_reading(parser)
    return parser


def _ellipsoid_options(parser: argparse.ArgumentParser, parameters: int) -> None:
    parser.add_argument(
        "--parameters",
        type=int,
        choices=(6, 9),
        default=parameters,
        help="6: scale and offset of each axis; 9: a symmetric matrix (default: %(default)s)",
    )
    parser.add_argument(
        "--plot",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="FILE",
        help="draw the readings before and after (png, pdf, svg; default: beside the output)",
    )


def _source_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rust", type=Path, metavar="FILE", help="write constants in Rust, float32")
    parser.add_argument("--c-header", type=Path, metavar="FILE", help="write constants in C, float32")


def magnetometer(args: argparse.Namespace) -> int:
    """The command for magnetometers."""
    return _ellipsoid(args, lambda mag, _: calibration.magnetometer(mag, parameters=args.parameters, norm=args.norm))


def accelerometer(args: argparse.Namespace) -> int:
    """The command for accelerometers."""
    if args.method == "positions":
        return _positions(args)
    return _ellipsoid(
        args,
        lambda acc, rate: calibration.accelerometer(
            acc, rate=rate, select=args.method, parameters=args.parameters, gravity=args.gravity
        ),
    )


def _ellipsoid(args: argparse.Namespace, fit: Callable[[FloatArray, float], calibration.EllipsoidFit]) -> int:
    if args.plot == Path():
        args.plot = (args.output or Path("calibration.png")).with_suffix(".png")
    _check_outputs(args)
    recordings = _read(args)
    readings, rate = _joined(args.sensor, recordings)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", CalibrationWarning)
        found = fit(readings, rate)
    print(f"{args.sensor}        {' '.join(map(printable, args.files))}")
    print(found.summary())
    for one in caught:
        print(f"note       {one.message}")
    _print_told(recordings)
    _write(args, found.calibration, lambda path: plots.save(figure(readings, found, args.sensor), path))
    return 0


def _positions(args: argparse.Namespace) -> int:
    _check_outputs(args)
    if args.plot is not None:
        raise CliError("--plot: there is none of the method positions")
    held: list[FloatArray] = []
    recordings = _read(args)
    for recording in recordings:
        acc, rate = _joined("acc", [recording])
        held += [acc[part] for part in calibration.held_attitudes(acc, rate)]
    found = calibration.six_positions(held, gravity=args.gravity)
    std = np.full(6, np.nan) if found.covariance is None else np.sqrt(np.diag(found.covariance))
    print(f"positions  {len(held)} held for a second or more")
    for k, axis in enumerate("xyz"):
        print(
            f"{axis}          gain {found.gain[k]:.6g} ± {std[k]:.2g}, bias {found.bias[k]:.6g} ± {std[3 + k]:.2g} m/s²"
        )
    print(f"residual   {np.abs(found.residual).max():.3g} m/s² at most")
    _print_told(recordings)
    _write(args, found.calibration)
    return 0


def gyroscope(args: argparse.Namespace) -> int:
    """The command for gyroscopes."""
    _check_outputs(args)
    if len(args.files) != 1:
        raise CliError(f"expected one recording of a gyroscope, got {len(args.files)}")
    (recording,) = _read(args)
    if args.reference:
        if recording.ref is None:
            raise CliError(f"--reference: {args.files[0]} has no reference")
        found = calibration.gyroscope_from_reference(recording.require("gyr"), recording.ref, t=recording.t)
    else:
        turns = _turns(args.turns) if args.turns else []
        rests = calibration.gyroscope_rests(recording.require("gyr"), recording.rate)
        gyr = recording.require("gyr")
        rest = np.concatenate([gyr[part] for part in rests])
        found = calibration.gyroscope(rest, _cut(recording, rests, turns))
    print(f"gyr        {printable(args.files[0])}")
    for k, axis in enumerate("xyz"):
        gain = f"gain {found.gain[k, k]:.6g} ± {found.gain_std[k, k]:.2g}, " if args.turns or args.reference else ""
        print(f"{axis}          {gain}bias {found.bias[k]:.6g} ± {found.bias_std[k]:.2g} rad/s")
    _print_told([recording])
    _write(args, found.calibration)
    return 0


def magnetometer_delay(args: argparse.Namespace) -> int:
    """The command for the delay of a magnetometer: every file, and their mean by their standard errors."""
    found: list[calibration.MagDelay] = []
    lines: list[str] = []
    calibrations = _calibrated.given(args)
    for path, read in zip(args.files, _read(args), strict=True):
        recording, said = _calibrated.applied(calibrations, read)
        lines += [f"mag-delay  {printable(path)}", *(f"{key:<10} {text}" for key, text in _reading.told(recording))]
        lines += [f"note       {note}" for note in said]
        try:
            one = calibration.mag_delay(recording, window=args.window)
        except CalibrationError as error:
            if len(args.files) == 1:
                raise
            lines.append(f"left out   {error}")
            continue
        found.append(one)
        lines.append(one.summary())
    if not found:
        raise CliError("none of the recordings determines the delay")
    weight = np.array([one.standard_error**-2 for one in found])
    delay = float(weight @ [one.delay for one in found] / weight.sum())
    if len(found) > 1:
        lines.append(f"together   {1e3 * delay:.2f} ± {1e3 / math.sqrt(weight.sum()):.2f} ms")
    if delay > 0.0:
        names = ", ".join(name for name, cls in FILTERS.items() if "mag_delay" in cls.PARAMS)
        lines.append(f"use        --set mag_delay={delay:.4f} ({names})")
    print("\n".join(lines))
    return 0


def _turns(text: str) -> list[tuple[str, float]]:
    turns = []
    for one in text.split(","):
        axis, _, angle = (part.strip() for part in one.partition("="))
        try:
            turns.append((axis, math.radians(float(angle))))
        except ValueError:
            axis = ""
        if axis not in tuple("xyz"):
            raise CliError(f"--turns: expected AXIS=DEG like x=360, got {one!r}")
    return turns


def _cut(recording: Recording, rests: list[slice], turns: list[tuple[str, float]]) -> list[calibration.Turn]:
    """What is between the rests, where it is one of the turns that are known."""
    if not turns:
        return []
    gyr = recording.require("gyr")
    bias = np.nanmean(np.concatenate([gyr[part] for part in rests]), axis=0)
    between = []
    for before, after in itertools.pairwise(rests):
        part = slice((before.start + before.stop) // 2, (after.start + after.stop) // 2)
        angle = np.nansum((gyr[part] - bias)[1:] * np.diff(recording.t[part])[:, None], axis=0)
        if np.linalg.norm(angle) > 0.5:
            between.append(part)
    if len(between) != len(turns):
        raise CliError(f"--turns: the recording has {len(between)} turns between its rests, got {len(turns)}")
    return [
        calibration.Turn(gyr[part], axis, angle, t=recording.t[part])
        for part, (axis, angle) in zip(between, turns, strict=True)
    ]


def write_sources(args: argparse.Namespace) -> int:
    """The command that writes cal.json as source code."""
    if args.rust is None and args.c_header is None:
        raise CliError("expected --rust FILE or --c-header FILE")
    args.output = None
    _check_outputs(args)
    _write_all(_sources(args, calibration.load(args.file)))
    return 0


def _sources(args: argparse.Namespace, calibrations: Calibrations) -> Writers:
    """What writes the source code that is asked for."""
    texts = [(args.rust, Calibrations.to_rust), (args.c_header, Calibrations.to_c)]
    return {path: partial(_atomic.write_text, content=text(calibrations)) for path, text in texts if path is not None}


def _write(args: argparse.Namespace, found: Calibration, draw: Callable[[Path], object] | None = None) -> None:
    outputs: Writers = {}
    if args.output is not None:
        outputs[args.output] = _joined_with(args.output, args.sensor, found).save
    outputs |= _sources(args, Calibrations(**{args.sensor: found}))
    if draw is not None and args.plot is not None:
        outputs[args.plot] = draw
    _write_all(outputs)


def _write_all(outputs: Writers) -> None:
    _common.write_all(outputs)
    for path in outputs:
        print(f"wrote      {printable(path)}")


def _check_outputs(args: argparse.Namespace) -> None:
    inputs = getattr(args, "files", None) or [args.file]
    outputs = {"-o": args.output, "--rust": args.rust, "--c-header": args.c_header}
    _common.check_outputs(outputs | {"--plot": getattr(args, "plot", None)}, inputs)
    if args.output is not None:
        if args.output.suffix.lower() != ".json":
            raise CliError(f"-o: expected a name that ends in .json, got {args.output.name!r}")
        if args.output.exists():
            calibration.load(args.output)  # what is no calibration is not written over
    if getattr(args, "plot", None) is not None:
        plots.require_matplotlib()
        try:
            plots.check_ending(args.plot)
        except ValueError as error:
            raise CliError(f"--plot: {str(error).removeprefix('path: ')}") from None


def _read(args: argparse.Namespace) -> list[Recording]:
    return [_reading.read(path, args) for path in args.files]


def _joined_with(path: Path, sensor: str, found: Calibration) -> Calibrations:
    """The calibrations of a file, if it is there, with that of one sensor replaced or added."""
    before = calibration.load(path) if path.exists() else Calibrations()
    changes: dict[str, Any] = {sensor: found}
    return dataclasses.replace(before, **changes)


def _joined(sensor: str, recordings: list[Recording]) -> tuple[FloatArray, float]:
    """The readings of a sensor, as it gave them, and its rate in Hz."""
    parts = []
    for recording in recordings:
        if sensor not in recording.streams:
            raise CliError(f"{recording.meta.get('path')}: has no {sensor}")
        parts.append(recording.streams[sensor])
    first = parts[0]
    rate = first.rate if len(first) > 1 and first.t[-1] > first.t[0] else recordings[0].rate
    return np.concatenate([part.values for part in parts]), rate


def _print_told(recordings: list[Recording]) -> None:
    """What has to be known of how they were read, each sentence once."""
    for key, text in dict.fromkeys(line for recording in recordings for line in _reading.told(recording)):
        print(f"{key:<10} {printable(text)}")


def figure(readings: FloatArray, found: calibration.EllipsoidFit, sensor: str) -> Figure:
    """The readings in the three planes before and after, over the sphere, and their norms."""
    plots.require_matplotlib()
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(12, 7), layout="constrained")
    plots.ellipsoid(found, readings, ax=drawn.subplots(2, 4))
    drawn.suptitle(f"{sensor}: {found.calibration.info['method']}")
    return drawn
