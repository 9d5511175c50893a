"""``ahrs-rs noise``: the noise of a sensor at rest, and filter parameters from it."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

import numpy as np

from ahrs_rs import _atomic, plots
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs.calibration import Coefficient, Noise, Rest, find_rest, noise
from ahrs_rs.cli import _common, _reading
from ahrs_rs.cli._common import CliError, Commands, Writers

EPILOG = """\
Coefficients as of IEEE Std 952, by a fit of the overlapping Allan deviation, with half of their 95 % interval.
One that the rest is too short for, or that other noises hide, is shown by its upper bound, as "< 2e-05". An hour at
rest shows most.

  ahrs-rs noise still.csv --plot allan.png -o noise.json
  ahrs-rs noise walk.csv --static 0:12.5
"""

#: How the columns of the table are named.
COLUMNS = {
    "random_walk": "random walk",
    "bias_instability": "bias instab.",
    "rate_random_walk": "rate r. walk",
    "quantisation": "quantisation",
}


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "noise",
        help="the noise of a sensor at rest, and parameters of filters from it",
        description="Analyse the noise of a sensor at rest: variances, Allan deviation, parameters of MEKF and EKF.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=noise_command)
    parser.add_argument("file", type=Path, metavar="FILE", help="recording (csv, parquet, npz, hdf5)")
    parser.add_argument(
        "--static",
        type=_interval,
        metavar="START:END",
        help="when the sensor rests, s from the first sample; either may be left out (default: found by themselves)",
    )
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write everything (.json)")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the Allan deviations (needs matplotlib)")
    _reading.add_reading(parser)


def noise_command(args: argparse.Namespace) -> int:
    """The command."""
    if args.output is not None and args.output.suffix.lower() != ".json":
        raise CliError(f"-o: expected a name that ends in .json, got {args.output.name!r}")
    if args.plot is not None:
        plots.require_matplotlib()
        try:
            plots.check_ending(args.plot)
        except ValueError as error:
            raise CliError(f"--plot: {error}") from None
    _common.check_outputs({"-o": args.output, "--plot": args.plot}, [args.file])
    recording = _reading.read(args.file, args)
    rest = find_rest(recording) if args.static is None else _given(recording, *args.static)
    result = noise(recording, rest)
    lines = [*_head(recording, result), "", *_table(result), "", *_parameters(result)]
    outputs: Writers = {}
    if args.output is not None:
        text = json.dumps(result.to_dict(), ensure_ascii=False, indent=2, allow_nan=False)
        outputs[args.output] = lambda path: _atomic.write_text(path, text + "\n")
    if args.plot is not None:
        outputs[args.plot] = lambda path: plots.save(result.figure(), path)
    _common.write_all(outputs)
    lines += [f"{'wrote':<10} {printable(path)}" for path in outputs]
    print("\n".join(lines))
    return 0


def _interval(text: str) -> tuple[float, float]:
    start, colon, end = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"expected START:END in s, got {text!r}")
    first = _common.finite(start) if start.strip() else -math.inf
    last = _common.finite(end) if end.strip() else math.inf
    if not first < last:
        raise argparse.ArgumentTypeError(f"expected START before END, got {text!r}")
    return first, last


def _given(recording: Recording, start: float, end: float) -> Rest:
    t = recording.t - recording.t[0]
    mask = (t >= start) & (t <= end)
    chosen = np.flatnonzero(mask)
    if not chosen.size:
        raise CliError(f"--static: the recording has no sample there; it is {recording.duration:.6g} s long")
    return Rest(mask, (slice(int(chosen[0]), int(chosen[-1]) + 1),), recording.t)


def _head(recording: Recording, result: Noise) -> list[str]:
    rest, count = result.rest, len(result.rest.phases)
    longest = rest.t[rest.longest.stop - 1] - rest.t[rest.longest.start]
    phases = f"{rest.duration:.6g} s" + (f" in {count} phases, the longest {longest:.4g} s" if count > 1 else "")
    biases = zip(result.bias.value, result.bias.standard_error, strict=True)
    bias = " ".join(f"{value:.4g}±{error:.2g}" for value, error in biases)
    lines = [
        *_reading.head(recording, list(result.sensors)),
        ("rest", phases),
        ("gyr bias", f"{bias} rad/s"),
    ]
    return [f"{key:<10} {text}" for key, text in lines]


def _table(result: Noise) -> list[str]:
    cells = []
    for name, sensor in result.sensors.items():
        first = sensor.axes[0].coefficients
        units = [first[column].unit for column in COLUMNS]
        cells.append([f"{name} at {sensor.rate:.4g} Hz", "sample", *COLUMNS.values()])
        cells.append(["", sensor.unit, *units])
        for axis, deviation, one in zip("xyz", sensor.deviation, sensor.axes, strict=True):
            cells.append([axis, f"{deviation:.3g}", *(_shown(one.coefficients[column]) for column in COLUMNS)])
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = []
    for row in cells:
        texts = [text.rjust(width) for text, width in zip(row, widths, strict=True)]
        lines.append("  ".join([row[0].ljust(widths[0]), *texts[1:]]))
    return lines


def _shown(coefficient: Coefficient) -> str:
    if not coefficient.known:
        return f"< {coefficient.high:.2g}"
    return f"{coefficient.value:.3g} ±{100.0 * (coefficient.high - coefficient.low) / (2.0 * coefficient.value):.0f}%"


def _parameters(result: Noise) -> list[str]:
    lines = []
    for name, values in (("MEKF", result.mekf_parameters()), ("EKF", result.ekf_parameters())):
        text = " ".join(f"{key}={_common.shown(value)}" for key, value in values.items())
        lines.append(f"{name:<10} {text}")
    return lines
