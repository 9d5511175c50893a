"""How the commands read recordings: their options, and what they tell of what was read."""

from __future__ import annotations

import argparse
import dataclasses
import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ahrs_rs import io
from ahrs_rs._check import hint
from ahrs_rs._recording import Recording
from ahrs_rs._warnings import DataWarning
from ahrs_rs.cli._common import CliError, finite, positive

#: Lists of `Recording.meta` that are told, and how a line about each of them begins.
TOLD = {"assumed": "assumed", "repairs": "repaired", "ignored": "ignored", "lost": "lost", "doubts": "doubt"}

#: How the line begins that points to `ahrs-rs check`.
HINT = "check"


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Options of how a file is read."""
    group = parser.add_argument_group("reading", "See `ahrs-rs formats` for what is read.")
    group.add_argument(
        "--format", metavar="NAME", help="of the file, see `ahrs-rs formats` (default: found from its content)"
    )
    group.add_argument(
        "--rate", type=positive, metavar="HZ", help="sampling rate, for a file without times, or in place of its times"
    )
    group.add_argument(
        "--columns",
        action="append",
        metavar="QUANTITY=NAME,NAME,...",
        help="of a table, as gyr=wx,wy,wz or t=millis; may be repeated; NAME,NAME,... names all columns of a table "
        "without a header",
    )
    group.add_argument(
        "--units",
        action="append",
        metavar="QUANTITY=UNIT,...",
        help="of a file, as acc=g,gyr=deg/s,t=ms; over what it states",
    )
    group.add_argument("--axes", metavar="X,Y,Z", help="which axes of the file x, y, z are, as x,-y,-z")
    group.add_argument("--separator", metavar="CHAR", help="of a text table (or tab, blanks; default: found)")
    group.add_argument(
        "--decimal", metavar="CHAR", choices=(".", ","), help="decimal sign of a text table (default: found)"
    )
    group.add_argument(
        "--skip-rows", type=_lines, metavar="N", help="lines above the header of a text table (default: found)"
    )
    group.add_argument(
        "--sensor", dest="of_sensor", metavar="NAME", help="of a file of several, see `ahrs-rs sensors FILE`"
    )
    group.add_argument("--timezone", metavar="NAME", help="of local times, as Europe/Berlin")
    group.add_argument(
        "--between", type=_interval, metavar="START:END", help="what was recorded between these times, s"
    )
    group.add_argument("--layout", type=Path, metavar="FILE", help="TOML file with these options")


def keywords(args: argparse.Namespace) -> dict[str, Any]:
    """The keywords of `io.read` that the options of `add_reading` say."""
    return {
        "format": args.format,
        "rate": args.rate,
        "columns": _columns(args.columns),
        "units": _units(args.units),
        "axes": args.axes,
        "separator": args.separator,
        "decimal": args.decimal,
        "skip_rows": args.skip_rows,
        "sensor": args.of_sensor,
        "timezone": args.timezone,
        "between": args.between,
        "layout": args.layout,
    }


def read(path: Path, args: argparse.Namespace) -> Recording:
    """The recording of a file; what it warns of is told by `told`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)
        return io.read(os.fspath(path), **keywords(args))


def read_doubtful(path: Path, args: argparse.Namespace) -> Recording:
    """The same, also where the readings are those of no inertial sensor."""
    with io.keeping_doubtful():
        return read(path, args)


def add_reference(parser: argparse.ArgumentParser) -> None:
    """Options of what the truth is."""
    group = parser.add_argument_group("reference")
    one = group.add_mutually_exclusive_group()
    one.add_argument(
        "--reference",
        type=Path,
        metavar="FILE",
        help="file with the true orientation, by another clock and at another rate; the clock is aligned",
    )
    one.add_argument(
        "--against-device", action="store_true", help="take the orientation that the device estimated for the truth"
    )


def with_reference(recording: Recording, args: argparse.Namespace) -> Recording:
    """The recording with the truth that the options of `add_reference` say."""
    if args.reference is not None:
        from ahrs_rs._reference import join_reference  # here: it is rarely asked for

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DataWarning)
            return join_reference(recording, os.fspath(args.reference))
    if args.against_device:
        quat = recording.device_quat
        if quat is None:
            raise CliError(f"--against-device: {recording.meta.get('path')} has no orientation of the device")
        meta = {**recording.meta, "ref_frame": recording.meta.get("device_frame", "of the device")}
        return dataclasses.replace(recording, ref=quat, mask=None, meta=meta)
    return recording


def told(recording: Recording) -> list[tuple[str, str]]:
    """What has to be known of how a recording was read: (key, text) of each line."""
    lines = [(key, sentence) for kind, key in TOLD.items() for sentence in recording.meta.get(kind, ())]
    assumed = recording.meta.get("assumed_units")
    if assumed:
        units = ", ".join(f"{quantity} in {unit}" for quantity, unit in assumed.items())
        lines.insert(0, ("assumed", f"no unit is stated, taken as {units}"))
    pointed = hint(recording)
    return lines if pointed is None else [*lines, (HINT, pointed)]


def head(recording: Recording, sensors: Sequence[str] | None = None) -> list[tuple[str, str]]:
    """What was read: (key, text) of each line."""
    meta = recording.meta
    shown = sensors or [name for name in ("gyr", "acc", "mag", "ref") if name in recording.streams]
    others = [] if sensors else list(recording.others)
    lines = [
        ("recording", f"{meta.get('path', '')} ({meta.get('format', '')}: {' '.join([*shown, *others])})"),
        ("samples", f"{len(recording)} in {recording.duration:.6g} s, {recording.rate:.6g} Hz"),
    ]
    if meta.get("program"):
        lines.append(("program", str(meta["program"])))
    columns, units = meta.get("columns", {}), meta.get("units", {})
    for name, names in columns.items():
        unit = f" in {units[name]}" if name in units else ""
        lines.append(("read", f"{name} from {', '.join(names)}{unit}"))
    if not columns and units:
        lines.append(("read", ", ".join(f"{name} in {unit}" for name, unit in units.items())))
    own = {
        name: stream.rate
        for name, stream in recording.streams.items()
        if len(stream) > 2 and stream.t[-1] > stream.t[0]
    }
    reference = meta.get("reference")
    if isinstance(reference, dict):
        rms = f", {reference['rms_deg']:.2f}° left" if "rms_deg" in reference else ""
        lines.append(("reference", f"{reference['path']}, its clock moved by {reference['offset']:.4f} s{rms}"))
    if recording.has_own_clocks:
        lines.append(("clocks", ", ".join(f"{name} {rate:.6g} Hz" for name, rate in own.items())))
    if meta.get("axes"):
        lines.append(("axes", str(meta["axes"]) + (f", remapped {meta['remapped']}" if meta.get("remapped") else "")))
    return lines + told(recording)


def _columns(texts: Sequence[str] | None) -> dict[str, Any] | list[str] | None:
    if not texts:
        return None
    named: dict[str, Any] = {}
    for text in texts:
        quantity, sign, names = text.partition("=")
        if not sign:
            if len(texts) > 1:
                raise CliError(f"--columns: expected QUANTITY=NAME,..., got {text!r}")
            return [name.strip() for name in text.split(",")]
        parts = [name.strip() for name in names.split(",") if name.strip()]
        named[quantity.strip()] = parts[0] if len(parts) == 1 else parts
    return named


def _units(texts: Sequence[str] | None) -> dict[str, str] | None:
    if not texts:
        return None
    named = {}
    for pair in ",".join(texts).split(","):
        quantity, sign, unit = (part.strip() for part in pair.partition("="))
        if not (quantity and sign and unit):
            raise CliError(f"--units: expected QUANTITY=UNIT, got {pair!r}")
        named[quantity] = unit
    return named


def _interval(text: str) -> tuple[float, float]:
    start, colon, end = text.partition(":")
    if not colon:
        raise argparse.ArgumentTypeError(f"expected START:END in s, got {text!r}")
    first = finite(start) if start.strip() else float("-inf")
    last = finite(end) if end.strip() else float("inf")
    if not first < last:
        raise argparse.ArgumentTypeError(f"expected START before END, got {text!r}")
    return first, last


def _lines(text: str) -> int:
    try:
        count = int(text)
    except ValueError:
        count = -1
    if count < 0:
        raise argparse.ArgumentTypeError(f"expected a number of lines, got {text!r}")
    return count
