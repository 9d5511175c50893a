"""The option by which commands are told where on earth a recording was made."""

from __future__ import annotations

import argparse
import dataclasses
import math
from dataclasses import dataclass
from typing import Any

from ahrs_rs import earth
from ahrs_rs._constants import GRAVITY
from ahrs_rs._recording import Recording
from ahrs_rs.cli._common import CliError, Settings


def place(text: str) -> tuple[float, float, float]:
    """LAT,LON or LAT,LON,ALT, for argparse."""
    try:
        numbers = [float(one) for one in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) == 2:
        numbers.append(0.0)
    if len(numbers) != 3:
        raise argparse.ArgumentTypeError(f"expected LAT,LON,ALT in °, °, m, got {text!r}")
    return numbers[0], numbers[1], numbers[2]


def add_option(parser: argparse.ArgumentParser, what: str) -> None:
    """The option, with what it is taken for."""
    parser.add_argument("--place", type=place, metavar="LAT,LON,ALT", help=f"where it was recorded (°, °, m): {what}")


@dataclass(frozen=True, slots=True)
class Place:
    """Where and when; without a place standard gravity, and nothing of the field."""

    where: tuple[float, float, float] | None
    date: Any = None

    @classmethod
    def of(cls, args: argparse.Namespace, recording: Recording | None = None) -> Place:
        """As the options say; the date is that of the recording where none is given."""
        if args.place is not None:
            latitude, longitude, altitude = args.place
            try:
                earth.gravity(latitude, altitude)
            except ValueError as error:
                raise CliError(f"--place: {error}") from None
            if abs(longitude) > 360.0:
                raise CliError(f"--place: longitude: expected one within ±360°, got {longitude!r}")
        date = args.date if args.date is not None else None if recording is None else recording.meta.get("start")
        return cls(args.place, date)

    def gravity(self, given: float | None) -> float:
        """The given one, or that of the place, m/s²."""
        if given is not None:
            return given
        return GRAVITY if self.where is None else earth.gravity(self.where[0], self.where[2])

    def field(self) -> earth.Field | None:
        """The magnetic field of the place, if there is one."""
        return None if self.where is None else earth.field(*self.where, self.date)

    def settings(self, settings: Settings) -> tuple[Settings, list[tuple[str, str]]]:
        """The settings with the declination of the place, and a line that says so."""
        field = None if settings.six_axes else self.field()
        if field is None:
            return settings, []
        if settings.declination:
            raise CliError("--place and --declination: expected one of them")
        told = (
            f"declination {math.degrees(field.declination):.2f}°, dip {math.degrees(field.dip):.1f}°, "
            f"{field.norm:.1f} µT ({field.model}, {self.date or 'today'})"
        )
        return dataclasses.replace(settings, declination=field.declination), [("field", told)]
