"""Units: by the size of the readings. Whether the gyroscope is in deg/s is told by what turns: see `_axes`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _plausible
from ahrs_rs._check import _changes
from ahrs_rs._check._case import BLOCK, Case
from ahrs_rs._check._findings import Finding
from ahrs_rs._constants import GRAVITY
from ahrs_rs._rate import median

FloatArray = NDArray[np.float64]

#: The specific force of a carried sensor over half a second is within these parts of gravity, in the median.
GRAVITY_LIKE = (0.8, 1.25)
#: Sizes of a count for common ranges: counts per g.
COUNTS = (16384.0, 8192.0, 4096.0, 2048.0, 1024.0, 256.0)
ACC_UNITS = {"g": GRAVITY, "mg": 1e-3 * GRAVITY}
#: The norm of the field, µT: on earth 22 to 67, in houses more.
EARTH = (15.0, 90.0)
MAG_UNITS = {"T": 1e6, "mT": 1e3, "gauss": 100.0, "mG": 0.1, "nT": 1e-3}
#: Quarter of the norms over cells below this: gravity may be off, m/s². A gyroscope at rest varies by less, rad/s.
WEIGHTLESS, QUIET = 1.0, 0.03


def check_units(case: Case) -> Iterator[Finding]:
    """Findings about the unit of each sensor; factors that are sure go into the case."""
    if "gyr" in case.has:
        yield from _gyroscope(case)
    if "acc" in case.has:
        yield from _accelerometer(case)
    if "mag" in case.has:
        yield from _magnetometer(case)


def _whole(rows: FloatArray) -> bool:
    """Whether the readings are whole numbers, as counts are."""
    some = rows[:: max(len(rows) // 2000, 1)]
    some = some[np.isfinite(some).all(axis=1)]
    return bool(len(some) and (some == np.round(some)).all() and np.abs(some).max() > 20.0)


def _gyroscope(case: Case) -> Iterator[Finding]:
    rows = case.rows("gyr")
    assert rows is not None
    wrong = _plausible.doubt("gyr", rows)
    if wrong is None:
        return
    if _whole(rows):
        yield Finding(
            "gyr.unit",
            "error",
            f"{wrong}: whole numbers, the counts of the sensor",
            None,
            "",
            0.9,
            "the sensor seems to spin",
            "multiply by the size of a count (data sheet)",
        )
        return
    unit = _plausible.likely_unit("gyr", rows)
    factor = np.pi / 180.0 * (1.0 if unit == "deg/s" else 1e-3)
    case.factors["gyr"] = factor
    yield Finding(
        "gyr.unit",
        "error",
        f"{wrong}; it looks like {unit}",
        None,
        "",
        0.97,
        "the sensor seems to turn 57 times as far as it does",
        f"units={{'gyr': '{unit}'}} (--units gyr={unit})",
        {"unit": unit, "factor": factor},
        _changes.scaled("gyr.unit", "gyr", factor, f"gyr from {unit} into rad/s"),
    )


def _accelerometer(case: Case) -> Iterator[Finding]:
    rows = case.rows("acc")
    assert rows is not None
    cells = case.cells("acc")
    known = cells.share > 0.05
    norms = np.linalg.norm(cells.mean[known], axis=1)
    if norms.size < 4:
        yield Finding("acc.unit", "note", "cannot tell: too few readings of the accelerometer")
        return
    resting = _at_rest(case)
    chosen = norms if resting is None else resting
    middle = median(chosen)
    spread = median(np.abs(chosen - middle)) / max(middle, 1e-12)
    factor, unit = 1.0, ""
    for name, size in ACC_UNITS.items():
        if GRAVITY_LIKE[0] <= middle * size / GRAVITY <= GRAVITY_LIKE[1] and spread < 0.15:
            factor, unit = size, name
    if not unit and _whole(rows) and middle > 60.0:
        for count in COUNTS:
            if abs(middle / count - 1.0) < 0.05:
                factor, unit = GRAVITY / count, f"counts of 1/{count:.0f} g"
        unit = unit or "counts"
    if unit and factor != 1.0 and not _weightless(case, norms):
        case.factors["acc"] = factor
        plain = unit in ACC_UNITS
        yield Finding(
            "acc.unit",
            "error",
            f"a median norm of {middle:.4g} is that of {unit}, not of m/s²",
            middle,
            "",
            0.97,
            "filters that weigh the accelerometer by its norm take it for free fall or for a blow",
            f"units={{'acc': '{unit}'}} (--units acc={unit})" if plain else "multiply by the size of a count",
            {"unit": unit, "factor": factor},
            _changes.scaled("acc.unit", "acc", factor, f"acc from {unit} into m/s²"),
        )
        return
    if _weightless(case, norms):
        yield Finding(
            "acc.gravity_removed",
            "error",
            f"the norm is {middle:.3g} m/s² (median) and near zero at rest: gravity is taken off",
            middle,
            "m/s²",
            0.95,
            "without gravity no filter can tell up: inclination drifts",
            "record the acceleration with gravity (Android TYPE_ACCELEROMETER, iOS raw acceleration)",
        )
    elif unit or not 0.4 * GRAVITY <= middle <= 2.5 * GRAVITY:
        yield Finding(
            "acc.unit",
            "error" if middle > 60.0 or middle < 0.3 else "warning",
            f"a median norm of {middle:.4g} m/s² is that of no accelerometer that is carried on earth",
            middle,
            "m/s²",
            0.8,
            "up cannot be told from it",
            "give its unit: units={'acc': ...} (--units acc=...)",
        )
    else:
        yield Finding("acc.unit", "ok", f"m/s²: the norm is {middle:.4g} (median)", middle, "m/s²", 0.99)


def _at_rest(case: Case) -> FloatArray | None:
    """Norms over the cells in which the gyroscope is quiet; None where there are few, or where they are near zero."""
    if "gyr" not in case.has:
        return None
    gyr, acc = case.cells("gyr"), case.cells("acc")
    count = min(len(gyr.t), len(acc.t))
    quiet = (np.linalg.norm(gyr.std[:count], axis=1) < QUIET) & (acc.share[:count] > 0.05)
    norms = np.linalg.norm(acc.mean[:count][quiet], axis=1)
    everywhere = np.linalg.norm(acc.mean[acc.share > 0.05], axis=1)
    return norms if norms.size >= 4 and median(norms) > 0.3 * median(everywhere) else None


def _weightless(case: Case, norms: FloatArray) -> bool:
    """Whether the norm is near zero where the gyroscope rests, or nearly always."""
    if float(np.quantile(norms, 0.25)) > WEIGHTLESS:
        return False
    if "gyr" not in case.has:
        return float(np.quantile(norms, 0.5)) < 0.3
    gyr = case.cells("gyr")
    acc = case.cells("acc")
    count = min(len(gyr.t), len(acc.t))
    quiet = np.linalg.norm(gyr.std[:count], axis=1)
    rests = (quiet < QUIET) & (acc.share[:count] > 0.05)
    whole = np.linalg.norm(acc.mean[:count], axis=1) / case.factors["acc"]
    if np.count_nonzero(rests) >= 4:
        return float(np.median(whole[rests])) < 0.35 and float(np.quantile(norms, 0.9)) > 2.0 * float(
            np.median(whole[rests])
        )
    # Averages over two seconds are those of gravity, whatever moves.
    return float(np.quantile(norms, 0.5)) < 0.6 and float(np.std(norms)) > 0.3 * float(np.mean(norms))


def _magnetometer(case: Case) -> Iterator[Finding]:
    rows = case.rows("mag")
    assert rows is not None
    norms = _some_norms(rows)
    middle = median(norms)
    if EARTH[0] <= middle <= EARTH[1]:
        yield Finding("mag.unit", "ok", f"µT: the norm is {middle:.4g} (median)", middle, "µT", 0.9)
        return
    meaning = "filters use its direction; those that know the field's norm or noise in µT are misled"
    if _plausible.is_normalised(rows):
        yield Finding(
            "mag.unit",
            "note",
            f"the norm is {middle:.3g}: in units of the local field",
            middle,
            "",
            0.9,
            meaning,
            "fine as it is for filters; a noise in µT has to be given in this unit",
            {"unit": "normalised"},
        )
        return
    units = [name for name, size in MAG_UNITS.items() if EARTH[0] <= middle * size <= EARTH[1]]
    if len(units) == 1 and not (_whole(rows) and units[0] == "mG"):
        factor = MAG_UNITS[units[0]]
        case.factors["mag"] = factor
        yield Finding(
            "mag.unit",
            "warning",
            f"a median norm of {middle:.4g} µT is not the earth's; it looks like {units[0]}",
            middle,
            "µT",
            0.85,
            meaning,
            f"units={{'mag': '{units[0]}'}} (--units mag={units[0]})",
            {"unit": units[0], "factor": factor},
            _changes.scaled("mag.unit", "mag", factor, f"mag from {units[0]} into µT"),
        )
        return
    counts = ": counts of the sensor?" if _whole(rows) else ""
    yield Finding(
        "mag.unit",
        "warning" if not 5.0 <= middle <= 250.0 else "note",
        f"a median norm of {middle:.4g} µT is not the earth's (22 to 67){counts}",
        middle,
        "µT",
        0.7,
        meaning,
        "calibrate it, or give its unit",
    )


def _some_norms(rows: FloatArray) -> FloatArray:
    """Norms of some of the readings, evenly over all; of all where most rows have none."""
    some = rows[:: max(len(rows) // BLOCK, 1)]
    norms = np.sqrt(np.einsum("ij,ij->i", some, some))
    known: FloatArray = norms[np.isfinite(norms)]
    if known.size > 50 or len(some) == len(rows):
        return known if known.size else np.ones(1)
    norms = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    every: FloatArray = norms[np.isfinite(norms)]
    return every
