"""The earth's field and gravity against published values."""

from __future__ import annotations

import datetime

import numpy as np
import pytest

import ahrs_rs as ar
from commands import without

#: The test values of the World Magnetic Models (NOAA/NCEI): year, km, latitude, longitude, then north, east, and
#: down in nT, norm in nT, dip and declination in degrees.
PUBLISHED = [
    (2025.0, 0.0, 80.0, 0.0, 6521.6, 145.9, 54791.5, 55178.5, 83.21, 1.28),
    (2025.0, 0.0, 0.0, 120.0, 39677.8, -109.6, -10580.2, 41064.3, -14.93, -0.16),
    (2025.0, 0.0, -80.0, 240.0, 6117.5, 15751.9, -52022.5, 54698.2, -72.00, 68.78),
    (2025.0, 100.0, 80.0, 0.0, 6216.0, 92.4, 52598.8, 52964.9, 83.26, 0.85),
    (2027.5, 100.0, -80.0, 240.0, 5984.0, 14760.1, -49317.7, 51825.7, -72.10, 67.93),
    (2020.0, 0.0, 80.0, 0.0, 6570.4, -146.3, 54606.0, 55000.1, 83.14, -1.28),
]


@pytest.fixture(autouse=True)
def _needs_the_library(request: pytest.FixtureRequest) -> None:
    if "field" in request.node.name:
        pytest.importorskip("pygeomag")


@pytest.mark.parametrize("row", PUBLISHED, ids=lambda row: f"{row[0]} {row[1]:.0f} km {row[2]:.0f} {row[3]:.0f}")
def test_the_field_is_the_published_one_in_microtesla_and_metres(row: tuple[float, ...]) -> None:
    year, height, latitude, longitude, north, east, down, norm, dip, declination = row
    found = ar.earth.field(latitude, longitude, 1e3 * height, year)
    # Published to 0.1 nT and 0.01°.
    assert (1e3 * found.north, 1e3 * found.east, -1e3 * found.up) == pytest.approx((north, east, down), abs=0.06)
    assert 1e3 * found.norm == pytest.approx(norm, abs=0.06)
    assert np.degrees((found.dip, found.declination)) == pytest.approx((dip, declination), abs=0.006)
    assert ar.earth.declination(latitude, longitude - 360.0, 1e3 * height, year) == pytest.approx(found.declination)


def test_the_field_of_a_date_is_that_of_its_part_of_the_year() -> None:
    of_year = ar.earth.field(52.0, 13.0, 0.0, 2024.5)
    assert of_year.model == "WMM-2020"
    for date in (datetime.date(2024, 7, 2), "2024-07-02", "2024.5", datetime.datetime(2024, 7, 2)):
        assert ar.earth.field(52.0, 13.0, 0.0, date) == of_year
    assert ar.earth.field(52.0, 13.0).norm == pytest.approx(of_year.norm, rel=0.01)  # today


@pytest.mark.parametrize(
    ("latitude", "published"),
    # NIMA TR8350.2, table 3.4: at the equator and at the poles; 45° by its formula, to 1e-9.
    [(0.0, 9.7803253359), (90.0, 9.8321849379), (-90.0, 9.8321849379), (45.0, 9.8061977694)],
)
def test_gravity_is_that_of_wgs_84(latitude: float, published: float) -> None:
    assert ar.earth.gravity(latitude) == pytest.approx(published, abs=2e-9)


def test_gravity_falls_by_three_micrometres_per_second_squared_in_a_metre() -> None:
    assert ar.earth.gravity(45.0) - ar.earth.gravity(45.0, 1000.0) == pytest.approx(3.086e-3, rel=2e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((91.0, 0.0), "latitude: expected one within ±90°"),
        ((0.0, 400.0), "longitude: expected one within ±360°"),
        ((0.0, 0.0, 1e6), "altitude: expected one from -1000 to 850000 m"),
        ((0.0, 0.0, 0.0, 1999.0), "date: expected one from 2010 to 2030"),
        ((0.0, 0.0, 0.0, "yesterday"), "date: expected one like 2024-06-30"),
        ((float("nan"), 0.0), "latitude: expected"),
    ],
)
def test_no_field_of_what_is_no_place_or_date(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ar.earth.field(*arguments)


def test_without_the_library_gravity_is_there_and_the_rest_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    without(monkeypatch, "pygeomag")
    ar.earth._model.cache_clear()
    with pytest.raises(ImportError, match=r"pip install ahrs-rs\[earth\]"):
        ar.earth.field(50.0, 10.0, 0.0, 2025.0)
    assert ar.earth.gravity(50.0) > 9.8
