"""Calibrations kept by device and date, and found again."""

from __future__ import annotations

import datetime
import os
import re
import sys
from pathlib import Path

from ahrs_rs._validate import choice, did_you_mean
from ahrs_rs.calibration._calibrations import Calibrations, load
from ahrs_rs.calibration._model import SensorCalibration

__all__ = ["devices", "find", "store", "stored"]

#: The folder of the store, where it is not given.
VARIABLE = "AHRS_RS_CALIBRATIONS"
#: What a folder of every system may be called.
DEVICE = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._+-]{0,99}")
#: The names of files sort as their dates do; UTC.
STAMP = "%Y-%m-%dT%H%M%SZ"
WHICH = ("before", "after", "closest")

Moment = datetime.datetime | datetime.date | str


def store(
    calibrations: Calibrations,
    device: str,
    date: Moment | None = None,
    *,
    folder: str | os.PathLike[str] | None = None,
) -> Path:
    """Keep the calibrations of a device, as of a date.

    Parameters
    ----------
    calibrations : Calibrations
        Of one or several of its sensors.
    device : str
        Its name, as its serial number: letters, digits, space and ``._+-``.
    date : datetime, date or str, optional
        When it was calibrated; a time without a zone is UTC. None is now. Calibrations of the same
        device and second are joined, sensor by sensor.
    folder : path-like, optional
        Of the store. None is the environment's ``AHRS_RS_CALIBRATIONS``, else the folder that the
        system has for data of a user's programs.

    Returns
    -------
    pathlib.Path
        The cal.json that was written.

    Raises
    ------
    ValueError
        A name that no folder can have, a date that is none, or no sensor at all.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from tempfile import TemporaryDirectory
    >>> cal = ar.calibration.Calibrations(mag=ar.calibration.Calibration.identity())
    >>> with TemporaryDirectory() as place:
    ...     path = ar.calibration.store(cal, "imu-7", "2026-03-01", folder=place)
    >>> path.name
    '2026-03-01T000000Z.json'
    """
    if not isinstance(calibrations, Calibrations):
        raise ValueError(f"calibrations: expected Calibrations, got {type(calibrations).__name__}")
    moment = _moment("date", date)
    path = _folder(folder) / _named(device) / f"{moment.strftime(STAMP)}.json"
    if path.exists():
        before = dict(load(path))
        calibrations = Calibrations(**(before | dict(calibrations)))
    path.parent.mkdir(parents=True, exist_ok=True)
    calibrations.save(path)
    return path


def find(
    device: str,
    date: Moment | None = None,
    *,
    which: str = "before",
    folder: str | os.PathLike[str] | None = None,
) -> Calibrations:
    """The calibrations of a device that hold at a date: of each sensor its own newest one.

    Parameters
    ----------
    device : str
        As it was stored.
    date : datetime, date or str, optional
        Of the recording. A date without a time is its end, so that what was stored on that day
        counts as before. None is now.
    which : str, optional
        Of each sensor the last one "before" the date, the first one "after" it, or the "closest".
    folder : path-like, optional
        As of `store`.

    Returns
    -------
    Calibrations
        Of all sensors that have one.

    Raises
    ------
    ValueError
        The device has none that fits; the message says which there are.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from tempfile import TemporaryDirectory
    >>> cal = ar.calibration.Calibrations(mag=ar.calibration.Calibration.identity())
    >>> with TemporaryDirectory() as place:
    ...     path = ar.calibration.store(cal, "imu-7", "2026-03-01", folder=place)
    ...     found = ar.calibration.find("imu-7", "2026-04-01", folder=place)
    >>> [sensor for sensor, _ in found]
    ['mag']
    """
    choice("which", which, WHICH)
    moment = _moment("date", date, end=True)
    dated = stored(device, folder=folder)
    if not dated:
        known = devices(folder=folder)
        listed = ", ".join(known) or "none"
        raise ValueError(
            f"device: expected one with calibrations, got {device!r}{did_you_mean(device, known)}: {listed}"
        )
    chosen: dict[str, SensorCalibration] = {}
    ordered = sorted(dated.items(), key=lambda item: abs(item[0] - moment))
    for when, path in ordered:
        if (which == "before" and when > moment) or (which == "after" and when < moment):
            continue
        for sensor, one in load(path):
            chosen.setdefault(sensor, one)
    if not chosen:
        listed = ", ".join(f"{when:%Y-%m-%d}" for when in dated)
        raise ValueError(
            f"date: expected one {which} which {device} was calibrated, got {moment:%Y-%m-%d}: {listed}"
            if which == "after"
            else f"date: expected one after a calibration of {device}, got {moment:%Y-%m-%d}: {listed}"
        )
    return Calibrations(**chosen)


def stored(device: str, *, folder: str | os.PathLike[str] | None = None) -> dict[datetime.datetime, Path]:
    """The files of a device by their dates, oldest first.

    Parameters
    ----------
    device : str
        As it was stored.
    folder : path-like, optional
        As of `store`.

    Returns
    -------
    dict
        UTC date -> path; empty of a device that has none.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     found = ar.calibration.stored("imu-7", folder=place)
    >>> found
    {}
    """
    place, found = _folder(folder) / _named(device), {}
    for path in sorted(place.glob("*.json")) if place.is_dir() else []:
        try:
            when = datetime.datetime.strptime(path.stem, STAMP)
        except ValueError:
            continue  # somebody else's file
        found[when.replace(tzinfo=datetime.UTC)] = path
    return found


def devices(*, folder: str | os.PathLike[str] | None = None) -> tuple[str, ...]:
    """The devices that have calibrations.

    Parameters
    ----------
    folder : path-like, optional
        As of `store`.

    Returns
    -------
    tuple of str
        Their names, in order.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as place:
    ...     found = ar.calibration.devices(folder=place)
    >>> found
    ()
    """
    place = _folder(folder)
    names = sorted(one.name for one in place.iterdir() if one.is_dir()) if place.is_dir() else []
    return tuple(name for name in names if DEVICE.fullmatch(name) and stored(name, folder=place))


def _named(device: str) -> str:
    if not isinstance(device, str) or not DEVICE.fullmatch(device) or device.endswith((".", " ")):
        raise ValueError(f"device: expected a name of letters, digits, space and ._+-, got {device!r}")
    return device


def _folder(folder: str | os.PathLike[str] | None) -> Path:
    if folder is not None:
        return Path(folder)
    if given := os.environ.get(VARIABLE):
        return Path(given)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Application Support"
    else:
        base = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return base / "ahrs_rs" / "calibrations"


def _moment(name: str, value: Moment | None, *, end: bool = False) -> datetime.datetime:
    """UTC to the second; of a date its start, or its end."""
    given = value
    if value is None:
        value = datetime.datetime.now(datetime.UTC)
    if isinstance(value, str):
        try:
            value = (
                datetime.date.fromisoformat(value)
                if len(value) == len("2026-01-01")
                else datetime.datetime.fromisoformat(value)
            )
        except ValueError:
            raise ValueError(f"{name}: expected a date like 2026-03-01 or 2026-03-01T12:00, got {given!r}") from None
    if not isinstance(value, datetime.date):
        raise ValueError(f"{name}: expected a date, got {given!r}")
    if not isinstance(value, datetime.datetime):
        value = datetime.datetime.combine(value, datetime.time(23, 59, 59) if end else datetime.time())
    if value.tzinfo is None:
        value = value.replace(tzinfo=datetime.UTC)
    return value.astimezone(datetime.UTC).replace(microsecond=0)
