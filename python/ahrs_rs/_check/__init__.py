"""What a recording says of its own faults: see `check`."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ahrs_rs._check._acc import check_accelerometer
from ahrs_rs._check._axes import check_axes
from ahrs_rs._check._case import Case
from ahrs_rs._check._findings import SEVERITIES, Finding
from ahrs_rs._check._gyr import check_gyroscope
from ahrs_rs._check._hint import hint
from ahrs_rs._check._mag import check_magnetometer
from ahrs_rs._check._ranges import check_ranges
from ahrs_rs._check._ref import check_reference
from ahrs_rs._check._report import Report
from ahrs_rs._check._signs import check_signs, up_vector
from ahrs_rs._check._spectrum import check_spectrum
from ahrs_rs._check._time import check_time
from ahrs_rs._check._units import check_units
from ahrs_rs._recording import Recording

__all__ = ["Finding", "Report", "check", "hint", "up_vector"]

#: In this order: each takes what the ones before have put right.
CHECKS: tuple[Callable[[Case], Iterator[Finding]], ...] = (
    check_time,
    check_units,
    check_axes,
    check_signs,
    check_ranges,
    check_spectrum,
    check_gyroscope,
    check_accelerometer,
    check_magnetometer,
    check_reference,
)


def check(
    recording: Recording,
    *,
    place: tuple[float, float, float] | None = None,
    date: Any = None,
    up: str | None = None,
) -> Report:
    """Find out what is wrong with a recording, from its readings alone.

    Parameters
    ----------
    recording : Recording
        As `ahrs_rs.read` gives it; no sensor is needed, each is looked at where it is there.
    place : (float, float, float), optional
        Latitude (°), longitude (°) and altitude (m) where it was recorded: tells the dip and the norm of the field.
        Needs ``ahrs-rs[earth]`` for the model of the field; without it, its dip is taken as that of a dipole.
    date : date or float, optional
        Of the recording, for the field of that day: a date, or a year such as 2024.5; None takes today.
    up : str, optional
        Which axis of the sensor was up when the recording began, as "z" or "-y": tells the sign of the accelerometer.

    Returns
    -------
    Report
        Findings with a severity, the number that they rest on, how sure they are, what they mean for a filter, and what
        to do.

    Raises
    ------
    ValueError
        A place that is none, or an `up` that names no axis.

    Notes
    -----
    The axes are told by what turns: of all 48 signed permutations of the angular rate, each times a few units, the one
    that explains how gravity (over 2 s) and the field (over 1 s) move, where it is better than every other by five
    standard errors of the paired differences over all windows. Where none is, the finding says "cannot tell". The sign
    of gravity, and a rotation of all sensors together, no reading can tell.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=60.0)
    >>> wrong = rec.changed(lambda name, x: x * [1, 1, -1] if name == "gyr" else x)
    >>> finding = ar.check(wrong)["axes.gyr"]
    >>> finding.severity, finding.evidence["axes"]
    ('error', 'x, y, -z')
    >>> ar.check(ar.check(wrong).fixed()).severity in ("ok", "note")
    True
    """
    case = Case(recording, _checked_place(place), date, up)
    if up is not None:
        up_vector(up)
    found: list[Finding] = []
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for one in CHECKS:
            try:
                found.extend(one(case))
            except np.linalg.LinAlgError:  # readings beyond the range of squares: their units are told before
                name = one.__name__.removeprefix("check_")
                found.append(
                    Finding(f"{name}.numbers", "note", f"cannot tell more of {name}: its numbers are too large")
                )
    order = {severity: -number for number, severity in enumerate(SEVERITIES)}
    found.sort(key=lambda one: order[one.severity])
    return Report(recording, tuple(found), case)


def _checked_place(place: tuple[float, float, float] | None) -> tuple[float, float, float] | None:
    if place is None:
        return None
    numbers = tuple(float(one) for one in place)
    if len(numbers) != 3 or not all(np.isfinite(numbers)):
        raise ValueError(f"place: expected (latitude °, longitude °, altitude m), got {place!r}")
    if abs(numbers[0]) > 90.0 or abs(numbers[1]) > 360.0:
        raise ValueError(f"place: expected a latitude within ±90° and a longitude within ±360°, got {place!r}")
    return numbers[0], numbers[1], numbers[2]
