"""``ahrs-rs calibrate``: calibrations of a sensor's parts from recordings; and the option by which they are applied."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ahrs_rs import calibration, plots
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration import CalibrationError, CalibrationWarning
from ahrs_rs.cli import _calibrate_gyr, _calibrate_live, _calibrate_output, _calibrated, _common, _place, _reading
from ahrs_rs.cli._common import CliError, Commands
from ahrs_rs.cli._place import Place
from ahrs_rs.filters import FILTERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


EPILOG = """\
cal.json holds one or several sensors: calibrating another one adds it. `ahrs-rs run --calibration cal.json` applies it.

  ahrs-rs calibrate mag turned-in-all-directions.csv -o cal.json --plot
  ahrs-rs calibrate acc held-in-many-attitudes.csv -o cal.json
  ahrs-rs calibrate gyr turns.csv --turns x=360,y=360,z=360 -o cal.json
  ahrs-rs calibrate ferraris six-sides-and-turns.csv --turns x=360,y=360,z=360 --device imu-7
  cat /dev/ttyACM0 | ahrs-rs calibrate mag --live -o cal.json
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
    _place.add_option(mag, "the norm of its field is taken (the extra earth)")
    _calibrate_live.add_options(mag)
    acc = _sensor(sensors, "acc", "accelerometer: scale and offset; held still in many attitudes", accelerometer)
    _ellipsoid_options(acc, 6)
    acc.add_argument(
        "--method",
        choices=("rest", "robust", "positions"),
        default="rest",
        help="windows at rest, all readings with motion as outliers, or six (or more) positions that were held "
        "(default: %(default)s)",
    )
    _gravity_option(acc)
    gyr = _sensor(
        sensors, "gyr", "gyroscope: bias from rests, gain from known turns or a reference", _calibrate_gyr.gyroscope
    )
    how = gyr.add_mutually_exclusive_group()
    how.add_argument(
        "--turns",
        metavar="AXIS=DEG,...",
        help="the turns between the rests of the recording in their order, like x=360,y=-360,z=360",
    )
    how.add_argument("--reference", action="store_true", help="compare with the recording's reference orientation")
    text = "accelerometer and gyroscope together: laid on each of six sides, and turned about each axis"
    both = _sensor(sensors, "ferraris", text, _calibrate_gyr.ferraris)
    both.add_argument(
        "--turns",
        required=True,
        metavar="AXIS=DEG,...",
        help="the turns by known angles in their order, like x=360,y=360,z=360; other motions are passed over",
    )
    _gravity_option(both)
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
    raise CliError("expected a sensor: mag, acc, gyr, ferraris, mag-delay, or export (see ahrs-rs calibrate --help)")


def _sensor(
    sensors: Any, name: str, text: str, function: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = sensors.add_parser(name, help=text, description=text, allow_abbrev=False)
    parser.set_defaults(function=function, sensor=name)
    parser.add_argument(
        "files", type=Path, nargs="*" if name == "mag" else "+", metavar="FILE", help="recordings, taken together"
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="cal.json to write, or to add this sensor to")
    parser.add_argument(
        "--device", metavar="NAME", help="keep it by this name, too: `ahrs-rs run --calibration @NAME` finds it again"
    )
    parser.add_argument(
        "--date", metavar="DATE", help="of the calibration, like 2026-03-01 (default: that of the recording, or now)"
    )
    _source_options(parser)
    _reading.add_reading(parser)
    return parser


def _ellipsoid_options(parser: argparse.ArgumentParser, parameters: int) -> None:
    parser.add_argument(
        "--parameters",
        type=int,
        choices=(3, 4, 6, 9) if parameters == 9 else (6, 9),
        default=parameters,
        help="6: scale and offset of each axis; 9: a symmetric matrix"
        + ("; 4: an offset alone; 3: one of a sensor that turns about one axis" if parameters == 9 else "")
        + " (default: %(default)s)",
    )
    parser.add_argument(
        "--plot",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="FILE",
        help="draw the readings before and after (png, pdf, svg; default: beside the output)",
    )


def _gravity_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--gravity",
        type=_common.positive,
        metavar="G",
        help=f"local gravity, m/s² (default: that of --place, or {calibration.GRAVITY})",
    )
    _place.add_option(parser, "its gravity is taken")


def _source_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rust", type=Path, metavar="FILE", help="write constants in Rust, float32")
    parser.add_argument("--c-header", type=Path, metavar="FILE", help="write constants in C, float32")


def magnetometer(args: argparse.Namespace) -> int:
    """The command for magnetometers."""
    if args.live:
        return _calibrate_live.magnetometer(args)
    if not args.files:
        raise CliError("the following arguments are required: FILE (or --live)")

    def fit(mag: FloatArray, rate: float) -> calibration.EllipsoidFit:
        return calibration.magnetometer(mag, parameters=args.parameters, norm=args.norm)

    return _ellipsoid(args, fit)


def _take_place(args: argparse.Namespace, recording: Recording | None) -> None:
    """Norm and gravity of the place, where they are not given."""
    place = Place.of(args, recording)
    if args.sensor == "mag":
        field = place.field() if args.norm is None and args.parameters != 3 else None
        args.norm = args.norm if field is None else field.norm
    else:
        args.gravity = place.gravity(args.gravity)


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
    _calibrate_output.check_outputs(args)
    recordings = _calibrate_output.read(args)
    readings, rate = _joined(args.sensor, recordings)
    _take_place(args, recordings[0])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", CalibrationWarning)
        found = fit(readings, rate)
    print(f"{args.sensor}        {' '.join(map(printable, args.files))}")
    print(found.summary())
    for one in caught:
        print(f"note       {one.message}")
    _calibrate_output.print_told(recordings)
    _calibrate_output.write(
        args, found.calibration, lambda path: plots.save(figure(readings, found, args.sensor), path), recordings
    )
    return 0


def _positions(args: argparse.Namespace) -> int:
    _calibrate_output.check_outputs(args)
    if args.plot is not None:
        raise CliError("--plot: there is none of the method positions")
    held: list[FloatArray] = []
    recordings = _calibrate_output.read(args)
    _take_place(args, recordings[0])
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
    _calibrate_output.print_told(recordings)
    _calibrate_output.write(args, found.calibration, recordings=recordings)
    return 0


def magnetometer_delay(args: argparse.Namespace) -> int:
    """The command for the delay of a magnetometer: every file, and their mean by their standard errors."""
    found: list[calibration.MagDelay] = []
    lines: list[str] = []
    calibrations = _calibrated.given(args)
    for path, read in zip(args.files, _calibrate_output.read(args), strict=True):
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


def write_sources(args: argparse.Namespace) -> int:
    """The command that writes cal.json as source code."""
    if args.rust is None and args.c_header is None:
        raise CliError("expected --rust FILE or --c-header FILE")
    args.output = None
    _calibrate_output.check_outputs(args)
    _calibrate_output.write_all(_calibrate_output.sources(args, calibration.load(args.file)))
    return 0


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


def figure(readings: FloatArray, found: calibration.EllipsoidFit, sensor: str) -> Figure:
    """The readings in the three planes before and after, over the sphere, and their norms."""
    plots.require_matplotlib()
    from matplotlib.figure import Figure

    drawn = Figure(figsize=(12, 7), layout="constrained")
    plots.ellipsoid(found, readings, ax=drawn.subplots(2, 4))
    drawn.suptitle(f"{sensor}: {found.calibration.info['method']}")
    return drawn
