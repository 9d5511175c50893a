"""The earth at a place: its magnetic field (World Magnetic Model) and its gravity (WGS 84).

>>> import numpy as np
>>> import ahrs_rs as ar
>>> berlin = (52.52, 13.40, 34.0)
>>> field = ar.earth.field(*berlin, 2025.5)
>>> round(float(np.degrees(field.declination)), 1), round(field.norm, 1)
(5.0, 50.0)
>>> round(ar.earth.gravity(52.52, 34.0), 4)
9.8128
>>> f = ar.VQF(rate=100.0, declination=ar.earth.declination(*berlin, 2025.5))

Latitudes and longitudes are in degrees, as maps have them; altitudes are in metres, above mean sea level or the
ellipsoid (which makes no difference here); everything else is in this package's units, rad and µT. The model of the
field is that of the package ``pygeomag`` (``pip install ahrs-rs[earth]``), good to about 0.15 µT, or half a degree of
declination, outdoors and away from iron; gravity needs no package.
"""

from __future__ import annotations

import datetime
import functools
import importlib
import math
from dataclasses import dataclass
from typing import Any

__all__ = ["Field", "declination", "field", "gravity"]

#: WGS 84: gravity at the equator, Somigliana's constant, squared eccentricity, semi-major axis, flattening, and the
#: ratio of centrifugal force and gravity at the equator (NIMA TR8350.2, chapter 4).
EQUATOR, SOMIGLIANA, ECCENTRICITY = 9.7803253359, 0.00193185265241, 0.00669437999013
MAJOR, FLATTENING, RATIO = 6378137.0, 1.0 / 298.257223563, 0.00344978650684
#: Years of the models, and the altitudes that they are made for, m.
YEARS, ALTITUDES = (2010.0, 2030.0), (-1000.0, 850e3)
#: nT in a µT.
NANO = 1e-3


@dataclass(frozen=True, slots=True)
class Field:
    """The magnetic field at a place and date."""

    east: float
    """µT"""
    north: float
    """µT"""
    up: float
    """µT; negative in the north, where the field points into the earth."""
    model: str
    """Its name, such as "WMM-2025"."""

    @property
    def norm(self) -> float:
        """µT"""
        return math.hypot(self.east, self.north, self.up)

    @property
    def horizontal(self) -> float:
        """µT; below 2 µT a compass tells nothing."""
        return math.hypot(self.east, self.north)

    @property
    def declination(self) -> float:
        """rad, positive where magnetic north is east of true north: as the filters' `declination`."""
        return math.atan2(self.east, self.north)

    @property
    def dip(self) -> float:
        """rad, positive where the field points into the earth."""
        return math.atan2(-self.up, self.horizontal)


def field(latitude: float, longitude: float, altitude: float = 0.0, date: Any = None) -> Field:
    """The magnetic field.

    Parameters
    ----------
    latitude, longitude : °, north and east positive.
    altitude : m (not km).
    date : a `datetime.date` (or datetime), a text such as "2024-06-30", or a year such as 2024.5; None takes today.

    Returns
    -------
    Field
        In µT and rad.

    Raises
    ------
    ImportError
        ``pygeomag`` is not installed.
    ValueError
        A place that is none, or a year without a model: there are 2010 to 2030.
    """
    check_place(latitude, longitude, altitude)
    year = decimal_year(date)
    if not YEARS[0] <= year < YEARS[1]:
        raise ValueError(
            f"date: expected one from {YEARS[0]:.0f} to {YEARS[1]:.0f}, for which there are models, got {year:.4g}"
        )
    # Longitudes of the model are within ±180°; its altitudes are in km, its field in nT.
    east_of = (float(longitude) + 180.0) % 360.0 - 180.0
    model = _model(int(year) // 5 * 5)
    found = model.calculate(glat=float(latitude), glon=east_of, alt=1e-3 * float(altitude), time=year)
    return Field(NANO * float(found.y), NANO * float(found.x), -NANO * float(found.z), str(model.model))


def declination(latitude: float, longitude: float, altitude: float = 0.0, date: Any = None) -> float:
    """By how much magnetic north is east of true north, rad: what the filters take as `declination`.

    Parameters, returns and errors are those of `field`.
    """
    return field(latitude, longitude, altitude, date).declination


def gravity(latitude: float, altitude: float = 0.0) -> float:
    """Normal gravity of WGS 84, m/s²: what an accelerometer at rest reads there, within about 0.001 m/s².

    Parameters
    ----------
    latitude : °
    altitude : m

    Raises
    ------
    ValueError
        A place that is none.
    """
    check_place(latitude, 0.0, altitude)
    sine2 = math.sin(math.radians(latitude)) ** 2
    level = EQUATOR * (1.0 + SOMIGLIANA * sine2) / math.sqrt(1.0 - ECCENTRICITY * sine2)
    high = altitude / MAJOR
    return level * (1.0 - 2.0 * (1.0 + FLATTENING + RATIO - 2.0 * FLATTENING * sine2) * high + 3.0 * high * high)


def decimal_year(date: Any) -> float:
    """A date as a year with its part; ValueError for what is none."""
    if date is None:
        date = datetime.datetime.now(datetime.UTC)
    if isinstance(date, str):
        text = date.strip()
        try:
            return float(text)
        except ValueError:
            pass
        try:
            date = datetime.datetime.fromisoformat(text)
        except ValueError:
            raise ValueError(f"date: expected one like 2024-06-30 or 2024.5, got {text!r}") from None
    if isinstance(date, datetime.date):
        days = date.timetuple().tm_yday - 1
        hours = date.hour if isinstance(date, datetime.datetime) else 0
        length = 366.0 if (date.year % 4 == 0 and date.year % 100 != 0) or date.year % 400 == 0 else 365.0
        return date.year + (days + hours / 24.0) / length
    year = float(date)
    if not math.isfinite(year):
        raise ValueError(f"date: expected a date or a year, got {date!r}")
    return year


def check_place(latitude: float, longitude: float, altitude: float) -> None:
    """ValueError where this is no place on earth."""
    if not abs(latitude) <= 90.0:
        raise ValueError(f"latitude: expected one within ±90°, got {latitude!r}")
    if not abs(longitude) <= 360.0:
        raise ValueError(f"longitude: expected one within ±360°, got {longitude!r}")
    if not ALTITUDES[0] <= altitude <= ALTITUDES[1]:
        low, high = (f"{one:.0f}" for one in ALTITUDES)
        raise ValueError(f"altitude: expected one from {low} to {high} m, got {altitude!r}")


@functools.cache
def _model(epoch: int) -> Any:
    try:
        library = importlib.import_module("pygeomag")
    except ModuleNotFoundError as error:
        if error.name != "pygeomag":
            raise
        raise ImportError("the earth's magnetic field needs pygeomag: pip install ahrs-rs[earth]") from error
    return library.GeoMag(base_year=epoch)
