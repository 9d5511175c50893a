"""Times that are written as text: dates with times in ISO 8601 and its relatives, times of a day."""

from __future__ import annotations

import datetime
import re
import zoneinfo
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray

_DATE = r"(?P<date>\d{4}[-/.]?\d{2}[-/.]?\d{2}|\d{1,2}[-/.]\d{1,2}[-/.]\d{4})"
_TIME = r"(?P<time>\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d+)?)?)"
_ZONE = r"\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?\d{2})?"
_MOMENT = re.compile(rf"(?:{_DATE}[T _]*)?{_TIME}{_ZONE}")


def seconds_of_text(
    cells: NDArray[Any], zone: str | None, name: str, assumed: list[str]
) -> tuple[FloatArray, str | None]:
    """Moments as seconds since the first one, NaN where a cell is empty.

    Parameters
    ----------
    cells : (n,) bytes.
    zone : of times without one; None leaves it open.
    name : of the column, for messages.
    assumed : a sentence is added where the order of day and month is not told.

    Returns
    -------
    t : (n,) s.
    start : the first one in ISO 8601 (+00:00: in UTC; nothing: of an unknown zone); None of times of a day.

    Raises
    ------
    ValueError
        A cell that is no moment, or a zone that there is not.
    """
    texts = [bytes(cell).decode("latin-1").strip().strip('"') for cell in cells]
    first = next((text for text in texts if text), "")
    match = _MOMENT.fullmatch(first)
    if match is None:
        raise ValueError(f"column {name!r}: expected numbers or times like 2026-01-31T10:00:00.5, got {first!r}")
    if match["date"] is None:
        return _of_day(texts, name), None
    moments = _iso(texts) if match["zone"] in (None, "Z") else None
    if moments is None:
        swapped = bool(re.match(r"\d{1,2}[-/.]", match["date"]))
        moments = np.array([_moment(text, name) for text in texts], dtype="datetime64[ns]")
        if swapped:
            assumed.append(f"t: {name!r} read as day/month/year")
    if match["zone"] is None:
        moments = _from_zone(moments, zone)
    known = moments[~np.isnat(moments)]
    start = known[0]
    t = (moments - start).astype(np.int64) / 1e9
    t[np.isnat(moments)] = np.nan
    known_zone = match["zone"] is not None or zone is not None
    return t, str(np.datetime_as_string(start.astype("datetime64[us]"))) + ("+00:00" if known_zone else "")


def _iso(texts: list[str]) -> NDArray[np.datetime64] | None:
    """ISO 8601 by numpy, which is fast; None where it cannot."""
    try:
        return np.array([text.removesuffix("Z").replace(",", ".") or "NaT" for text in texts], dtype="datetime64[ns]")
    except ValueError:
        return None


def _moment(text: str, name: str) -> np.datetime64:
    if not text:
        return np.datetime64("NaT", "ns")
    match = _MOMENT.fullmatch(text)
    if match is None or match["date"] is None:
        raise ValueError(f"column {name!r}: expected times like 2026-01-31T10:00:00.5, got {text!r}")
    digits = re.split(r"[-/.]", match["date"])
    if len(digits) == 1:
        digits = [digits[0][:4], digits[0][4:6], digits[0][6:]]
    year, month, day = digits if len(digits[0]) == 4 else digits[::-1]
    if int(month) > 12:
        month, day = day, month
    try:
        moment = np.datetime64(f"{year}-{int(month):02}-{int(day):02}T00:00:00", "ns") + _time(match["time"])
    except ValueError:
        raise ValueError(f"column {name!r}: {text!r} is no moment") from None
    zone = match["zone"]
    if zone and zone[0] in "+-":
        offset = np.timedelta64(int(zone[1:3]) * 60 + int(zone[-2:]), "m")
        moment = moment - offset if zone[0] == "+" else moment + offset
    return moment


def _time(text: str) -> np.timedelta64:
    hours, minutes, *rest = re.split("[:]", text, maxsplit=2)
    seconds, _, fraction = re.sub("[,:]", ".", rest[0] if rest else "0").partition(".")
    whole = int(hours) * 3600 + int(minutes) * 60 + int(seconds)
    return np.timedelta64(whole * 10**9 + int(fraction[:9].ljust(9, "0") or 0), "ns")


def _of_day(texts: list[str], name: str) -> FloatArray:
    """Times of a day: a fall of more than half a day is midnight."""
    found = np.full(len(texts), np.nan)
    for k, text in enumerate(texts):
        if text:
            match = _MOMENT.fullmatch(text)
            if match is None:
                raise ValueError(f"column {name!r}: expected times like 10:00:00.5, got {text!r}")
            found[k] = _time(match["time"]).astype(np.int64) / 1e9
    known = np.isfinite(found)
    days = np.concatenate([[0], np.cumsum(np.diff(found[known]) < -43200.0)])
    found[known] += days * 86400.0 - found[known][0]
    return found


def known_zone(zone: str) -> zoneinfo.ZoneInfo:
    """The time zone of a name; ValueError where there is none."""
    try:
        return zoneinfo.ZoneInfo(zone)
    except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError, TypeError):
        raise ValueError(f"timezone: expected a name like Europe/Berlin, got {zone!r}") from None


def _from_zone(moments: NDArray[np.datetime64], zone: str | None) -> NDArray[np.datetime64]:
    """Local times as UTC; of an hour that comes twice in autumn, the first one."""
    if zone is None:
        return moments
    info = known_zone(zone)
    hours = moments.astype("datetime64[h]")
    offsets = {}
    for hour in np.unique(hours[~np.isnat(hours)]):
        local = hour.astype("datetime64[s]").astype(datetime.datetime).replace(tzinfo=info)
        offsets[hour] = np.timedelta64(int((local.utcoffset() or datetime.timedelta()).total_seconds()), "s")
    shift = np.array([offsets.get(hour, np.timedelta64(0, "s")) for hour in hours], dtype="timedelta64[s]")
    return np.asarray(moments - shift)
