"""``ahrs-rs calibrate mag --live``: readings from lines of the standard input, with the covered directions drawn."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import TextIO

from ahrs_rs._printable import printable
from ahrs_rs.calibration import LiveMagnetometer
from ahrs_rs.cli import _calibrate_output, _common
from ahrs_rs.cli._common import CliError
from ahrs_rs.cli._place import Place
from ahrs_rs.cli._signals import stoppable

#: The picture is drawn so often, s; and without a terminal a line of it is told so often.
DRAWN, TOLD = 0.1, 5.0
#: What stands between the numbers of a line.
BETWEEN = re.compile(r"[,;\s]+")
#: One that is no number is told with so much of it.
SHOWN = 60


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options of a live calibration."""
    parser.add_argument(
        "--live",
        action="store_true",
        help="readings come as lines of the standard input, like 12.3, -4.5, 40.1; Ctrl-C or the end of input ends it; "
        "longer lines need --columns mag=8,9,10, counted from 1",
    )
    parser.add_argument(
        "--coverage", type=_common.positive, metavar="SHARE", help="end a live calibration here, like 0.9"
    )


def magnetometer(args: argparse.Namespace) -> int:
    """The command: it reads until the end, and writes what the command for recordings writes."""
    if args.files:
        raise CliError(f"--live: expected no FILE beside it, got {printable(args.files[0])}")
    if args.plot is not None:
        raise CliError("--plot: there is none of a live calibration")
    if args.coverage is not None and args.coverage > 1.0:
        raise CliError(f"--coverage: expected a share of at most 1, got {args.coverage:g}")
    columns = _columns(args.columns)
    _calibrate_output.check_outputs(args)
    field = Place.of(args).field() if args.norm is None and args.parameters != 3 else None
    args.norm = args.norm if field is None else field.norm
    live = LiveMagnetometer(parameters=args.parameters, norm=args.norm)
    passed = _read(live, sys.stdin, columns, args.coverage or 2.0, _Picture(sys.stderr))
    found = live.fit()
    print(f"mag        {len(live)} readings of the standard input")
    if passed:
        print(f"note       {passed} lines without three numbers were passed over")
    print(found.summary())
    print(live.map())
    _calibrate_output.write(args, found.calibration)
    return 0


def _columns(given: Sequence[str] | None) -> tuple[int, int, int] | None:
    """Where a line has the reading, counted from 0; None of lines of three numbers."""
    if not given:
        return None
    try:
        (text,) = given
        quantity, _, numbers = text.partition("=")
        x, y, z = (int(one) for one in numbers.split(","))
        if quantity.strip() != "mag" or min(x, y, z) < 1:
            raise ValueError
    except ValueError:
        shown = " ".join(given)
        raise CliError(f"--columns: expected mag=8,9,10 with --live, counted from 1, got {shown!r}") from None
    return x - 1, y - 1, z - 1


def _read(
    live: LiveMagnetometer,
    lines: Iterable[str],
    columns: tuple[int, int, int] | None,
    enough: float,
    picture: _Picture,
) -> int:
    """Take readings until the end, Ctrl-C, or enough coverage; the lines that were passed over."""
    passed = 0
    with stoppable():
        for reading in _readings(lines, columns):
            if reading is None:
                passed += 1
                continue
            live.add(reading)
            if picture.due() and picture.show(live) >= enough:
                break
    picture.end()
    if not len(live):
        raise CliError(f"--live: expected lines of three numbers on the standard input, got {passed} without")
    return passed


def _readings(
    lines: Iterable[str], columns: tuple[int, int, int] | None
) -> Iterator[tuple[float, float, float] | None]:
    """The reading of each line that is not empty; None of one that has none."""
    for line in lines:
        words = BETWEEN.split(line.strip().strip(",;"))
        if words == [""]:
            continue
        if columns is not None:
            words = [words[k] for k in columns if k < len(words)]
        try:
            x, y, z = map(float, words)
        except ValueError:
            yield None
            continue
        yield (x, y, z) if abs(x) + abs(y) + abs(z) < float("inf") else None


class _Picture:
    """The covered directions, drawn over and over in a terminal, or a line of them now and then."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.terminal = stream.isatty()
        self.lines = 0
        self.next = time.monotonic() + (0.0 if self.terminal else TOLD)

    def due(self) -> bool:
        """Whether it is time to draw."""
        return time.monotonic() >= self.next

    def show(self, live: LiveMagnetometer) -> float:
        """Draw what has been covered, and return the share."""
        self.next = time.monotonic() + (DRAWN if self.terminal else TOLD)
        share = live.coverage
        text = f"{len(live)} readings, {share:.0%} of the directions"
        if self.terminal:
            centre = ", ".join(f"{one:.1f}" for one in live.centre)
            text = f"{live.map()}\n{text}, centre ({centre})"
            if self.lines:
                self.stream.write(f"\x1b[{self.lines}F\x1b[J")
            self.lines = text.count("\n") + 1
        self.stream.write(text + "\n")
        self.stream.flush()
        return share

    def end(self) -> None:
        """Take the picture away: the result has its own."""
        if self.lines:
            self.stream.write(f"\x1b[{self.lines}F\x1b[J")
            self.stream.flush()
