"""What the calibrations of all sensors share: their recordings, and the files that are written."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from ahrs_rs import _atomic, calibration, plots
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs.calibration import Calibration, Calibrations
from ahrs_rs.cli import _common, _reading
from ahrs_rs.cli._common import CliError, Writers


def sources(args: argparse.Namespace, calibrations: Calibrations) -> Writers:
    """What writes the source code that is asked for."""
    texts = [(args.rust, Calibrations.to_rust), (args.c_header, Calibrations.to_c)]
    return {path: partial(_atomic.write_text, content=text(calibrations)) for path, text in texts if path is not None}


def write(
    args: argparse.Namespace,
    found: Calibration | Calibrations,
    draw: Callable[[Path], object] | None = None,
    recordings: Sequence[Recording] = (),
) -> None:
    """Write what was found of a sensor, or of several, wherever it is asked for."""
    calibrations = found if isinstance(found, Calibrations) else Calibrations(**{args.sensor: found})
    outputs: Writers = {}
    if args.output is not None:
        outputs[args.output] = _joined_with(args.output, calibrations).save
    outputs |= sources(args, calibrations)
    if draw is not None and args.plot is not None:
        outputs[args.plot] = draw
    write_all(outputs)
    if args.device is not None:
        start = recordings[0].meta.get("start") if recordings else None
        path = calibration.store(calibrations, args.device, args.date or start)
        print(f"stored     {printable(path)}")


def write_all(outputs: Writers) -> None:
    """Write all files, or none, and say so."""
    _common.write_all(outputs)
    for path in outputs:
        print(f"wrote      {printable(path)}")


def check_outputs(args: argparse.Namespace) -> None:
    """Refuse outputs that could not be written, before anything is computed."""
    inputs = args.files if hasattr(args, "files") else [args.file]
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


def read(args: argparse.Namespace) -> list[Recording]:
    """The recordings of a command."""
    return [_reading.read(path, args) for path in args.files]


def _joined_with(path: Path, found: Calibrations) -> Calibrations:
    """The calibrations of a file, if it is there, with those that were found replaced or added."""
    before = calibration.load(path) if path.exists() else Calibrations()
    return dataclasses.replace(before, **dict(found))


def print_told(recordings: list[Recording]) -> None:
    """What has to be known of how they were read, each sentence once."""
    for key, text in dict.fromkeys(line for recording in recordings for line in _reading.told(recording)):
        print(f"{key:<10} {printable(text)}")
