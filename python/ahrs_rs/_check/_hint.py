"""One line of other commands, where a recording cannot be what it is taken for."""

from __future__ import annotations

import warnings

import numpy as np

from ahrs_rs._check._axes import check_axes
from ahrs_rs._check._case import Case
from ahrs_rs._check._time import check_time
from ahrs_rs._check._units import check_units
from ahrs_rs._recording import Recording

#: Rows that are looked at, and at most so many seconds: a quarter of a second of work.
ROWS, SECONDS = 40000, 120.0


def hint(recording: Recording) -> str | None:
    """What is surely wrong with time, units or axes, in a line that points to the check; None where nothing is."""
    if len(recording) < 100:
        return None
    count = min(ROWS, max(int(SECONDS * recording.rate), 100))
    case = Case(recording[:count] if len(recording) > count else recording)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = [one for check in (check_time, check_units, check_axes) for one in check(case)]
    errors = [one for one in found if one.severity == "error"]
    if not errors:
        return None
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"{errors[0].message}{more}: see `ahrs-rs check`"
