"""Reading: which format a source has, what the user asked for, and what has to be told."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import PurePosixPath
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from ahrs_rs._axes import axes_matrix
from ahrs_rs._rate import nominal_rate
from ahrs_rs._recording import Recording
from ahrs_rs._warnings import DataWarning
from ahrs_rs.io._contents import TOLD, Options, SensorData, SensorInfo
from ahrs_rs.io._finish import finish
from ahrs_rs.io._layout import with_layout
from ahrs_rs.io._source import Source

if TYPE_CHECKING:
    from ahrs_rs.io._registry import Format

#: What `read` can be given as its path.
Readable = str | os.PathLike[str] | IO[bytes]


def read(
    path: Readable,
    *,
    columns: Mapping[str, str | Sequence[str]] | Sequence[str] | None = None,
    units: Mapping[str, str] | None = None,
    axes: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    skip_rows: int | None = None,
    sensor: str | None = None,
    timezone: str | None = None,
    between: tuple[float, float] | None = None,
    rate: float | None = None,
    format: str | None = None,
    layout: str | os.PathLike[str] | None = None,
) -> Recording:
    """Read a recording of any known format.

    Parameters
    ----------
    path : path-like or file object
        Of the file or folder, or a binary file object; "-" is the standard input. A .gz, and a .zip
        of one file or of a folder that a device writes, are read as what is in them.
    columns : mapping or sequence of str, optional
        Of a table: quantity -> name (names, in the order of the axes) of its columns, for what
        their names do not tell; or the names of all columns of a table without a header.
    units : mapping, optional
        Quantity ("t", "gyr", "acc", "mag", "temperature") -> its unit in the file, over what the
        file says.
    axes : str, optional
        Which of the file's axes x, y and z are, with their signs, as "x,-y,-z": see
        `Recording.remapped`.
    separator, decimal : str, optional
        Of a text table, such as ";" and ","; None finds them.
    skip_rows : int, optional
        Lines above the header of a text table; None finds it.
    sensor : str, optional
        Of a file of several: its name, see `sensors`.
    timezone : str, optional
        Of local times without one, as "Europe/Berlin"; None takes UTC.
    between : tuple, optional
        (start, end) in s, on the clock of the recording.
    rate : float, optional
        Sampling rate in Hz, in place of the times in the file, which then needs none.
    format : str, optional
        A name of `formats`; None finds it from the content, whatever the ending.
    layout : str or path-like, optional
        A TOML file with these options (all but path, between, layout); those that are given here go
        over it.

    Returns
    -------
    Recording
        In rad/s, m/s² and µT. NaN and empty cells stay NaN: missing data. `meta` says what was found (path, format,
        units, columns, axes), and lists what was assumed, repaired, ignored, lost.

    Raises
    ------
    FileNotFoundError
    IsADirectoryError
        A folder that is none of a known device.
    ValueError
        An empty or damaged file; an unknown format, unit or set of columns; several sensors; readings that no inertial
        sensor gives. One line, with the path and the option that settles it.
    ImportError
        The format needs a package that is not installed.

    Warns
    -----
    DataWarning
        One, with all that was assumed, repaired, ignored, lost.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.npz")
    ...     ar.simulate.demo(duration=5.0).save(path)
    ...     rec = ar.read(path)
    >>> len(rec), rec.rate
    (500, 100.0)
    """
    options = _options(layout, columns, units, axes, separator, decimal, skip_rows, sensor, timezone, rate)
    window = _window(between)
    source = _source(path, format)
    name, found = _load(source, format, options)
    try:
        main = formats()[name].main
        if options.sensor is None and main in found:
            for other in [one for one in found if one != main]:
                found[main].say("ignored", f"sensor {other}: read it by sensor={other!r}")
            found = {main: found[main]}
        if options.sensor is None and len(found) > 1:
            raise ValueError(f"has several sensors: give sensor= (--sensor), one of {_listed(found)}, or use read_all")
        chosen = _chosen(found, options.sensor)
        recording = _made(found[chosen], source, name, options, window)
    except ValueError as error:
        raise ValueError(f"{source.path}: {error}") from error
    _tell(recording)
    return recording


def from_frame(
    frame: Any,
    *,
    columns: Mapping[str, str | Sequence[str]] | None = None,
    units: Mapping[str, str] | None = None,
    axes: str | None = None,
    sensor: str | None = None,
    timezone: str | None = None,
    rate: float | None = None,
) -> Recording:
    """The recording in a data frame; see `Recording.from_frame`.

    Parameters
    ----------
    frame : object
        As of `Recording.from_frame`, like all others.
    columns : mapping, optional
        Names of columns.
    units : mapping, optional
        Units of quantities.
    axes : str, optional
        Order and signs of the axes, as "x,-y,-z".
    sensor : str, optional
        Which one, where there are several.
    timezone : str, optional
        Of times without one.
    rate : float, optional
        Nominal rate in Hz.

    Returns
    -------
    Recording
        What the columns tell.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> t = np.arange(50) / 100
    >>> ar.io.from_frame({"t (s)": t, **{f"gyr_{axis} (rad/s)": t for axis in "xyz"}})
    Recording(50 samples, 0.49 s, 100 Hz, gyr, 'data frame')
    """
    from ahrs_rs.io._frame import recording_of_frame

    options = _options(None, columns, units, axes, None, None, None, sensor, timezone, rate)
    recording = recording_of_frame(frame, options)
    _tell(recording, stacklevel=4)
    return recording


def read_all(
    path: Readable,
    *,
    columns: Mapping[str, str | Sequence[str]] | Sequence[str] | None = None,
    units: Mapping[str, str] | None = None,
    axes: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    skip_rows: int | None = None,
    timezone: str | None = None,
    between: tuple[float, float] | None = None,
    rate: float | None = None,
    format: str | None = None,
    layout: str | os.PathLike[str] | None = None,
) -> dict[str, Recording]:
    """Read all sensors of a file: sensor -> recording. Parameters, warnings and errors are those of `read`.

    Parameters
    ----------
    path : path-like or file object
        As of `read`, like all others.
    columns : mapping or sequence of str, optional
        Names of columns.
    units : mapping, optional
        Units of quantities.
    axes : str, optional
        Order and signs of the axes, as "x,-y,-z".
    separator : str, optional
        Between cells.
    decimal : str, optional
        The sign before decimals.
    skip_rows : int, optional
        Rows before the table.
    timezone : str, optional
        Of times without one.
    between : tuple, optional
        First and last time.
    rate : float, optional
        Nominal rate in Hz.
    format : str, optional
        Of `formats`.
    layout : str or path-like, optional
        A TOML file with such options.

    Returns
    -------
    dict
        The recordings by the names of their sensors.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.npz")
    ...     ar.simulate.demo(duration=5.0).save(path)
    ...     found = ar.read_all(path)
    >>> len(found)
    1
    """
    options = _options(layout, columns, units, axes, separator, decimal, skip_rows, None, timezone, rate)
    window = _window(between)
    source = _source(path, format)
    name, found = _load(source, format, options)
    recordings = {}
    for sensor, data in found.items():
        try:
            recordings[sensor] = _made(data, source, name, options, window, sensor)
        except ValueError as error:
            raise ValueError(f"{source.path}: sensor {sensor!r}: {error}") from error
    for recording in recordings.values():
        _tell(recording)
    return recordings


def sensors(path: Readable, *, format: str | None = None) -> list[SensorInfo]:
    """What is in a file: its sensors with their quantities, samples and rates, mostly without reading it whole.

    Parameters
    ----------
    path, format : path-like or file object
        As of `read`.

    Returns
    -------
    list of SensorInfo
        Their names are what ``read(..., sensor=)`` takes.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.npz")
    ...     ar.simulate.demo(duration=5.0).save(path)
    ...     found = ar.sensors(path)
    >>> found[0].samples["gyr"]
    500
    """
    source, options = _source(path, format), Options()
    name = _named(source, format)
    known = formats()[name]
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            if known.sensors is not None:
                return known.sensors(source, options)
            return [_counted(sensor, data) for sensor, data in known.load(source, options).items()]
    except ValueError as error:
        raise ValueError(f"{source.path}: {error}") from error


def formats() -> dict[str, Format]:
    """Name -> format, of all that are known, in the order in which they are looked for.

    Returns
    -------
    dict of str to Format
        Of all that are known, in the order in which they are looked for.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> "npz" in ar.io.formats()
    True
    """
    from ahrs_rs.io._registry import FORMATS  # here, so that the package is imported without its readers

    return FORMATS


def _options(layout: str | os.PathLike[str] | None, *given: Any) -> Options:
    options = Options(**dict(zip((field.name for field in fields(Options)), given, strict=True)))
    options = with_layout(options, layout)
    rate = options.rate
    if rate is not None and not (math.isfinite(rate) and rate > 0):
        raise ValueError(f"rate: expected a positive, finite number of Hz, got {rate!r}")
    if options.axes is not None:
        axes_matrix(options.axes)  # wrong ones are told before a file is read
    if options.timezone is not None:
        from ahrs_rs.io._moments import known_zone  # here: it is rarely asked for

        known_zone(options.timezone)
    return options


def _window(between: tuple[float, float] | None) -> tuple[float, float] | None:
    if between is None:
        return None
    if len(between) != 2 or not float(between[0]) <= float(between[1]):
        raise ValueError(f"between: expected (start, end) in s with start <= end, got {between!r}")
    return float(between[0]), float(between[1])


def _source(path: Readable, format: str | None) -> Source:
    source = Source.of(path)
    if not source.is_folder and not source.head:
        raise ValueError(f"{source.path}: is empty")
    alone = source.names[0] if source.is_zip and len(source.names) == 1 else ""
    if alone and not alone.endswith(".npy") and not any(one.sniff(source) for one in formats().values()):
        source = source.child(alone)
        if not source.head:
            raise ValueError(f"{source.path}: is empty")
    return source


def _load(source: Source, format: str | None, options: Options) -> tuple[str, dict[str, SensorData]]:
    name = _named(source, format)
    known = formats()[name]
    for field in fields(Options):
        taken = field.name in known.options or field.name in ("axes", "rate", "sensor", "units")
        if not taken and getattr(options, field.name) is not None:
            raise ValueError(f"{source.path}: {field.name}: expected None, as {known.title} has a layout of its own")
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # absurd numbers are refused by what they lead to
            found = known.load(source, options)
        if not found:
            raise ValueError("has no sensor")
        return name, found
    except ValueError as error:
        raise ValueError(f"{source.path}: {error}") from error


def _named(source: Source, format: str | None) -> str:
    """The name of the source's format."""
    from ahrs_rs.io._preamble import is_text  # here, so that the package is imported without it

    known = formats()
    if format is not None:
        if format not in known:
            raise ValueError(f"format: expected one of {', '.join(known)}, got {format!r}")
        return format
    text = not source.is_folder and not source.is_zip and is_text(source.head)
    name = next((name for name, one in known.items() if not (text and one.binary) and one.sniff(source)), None)
    ending = PurePosixPath(source.name).suffix.lower()
    claimed = next((name for name, one in known.items() if ending in one.endings), None)
    if claimed is not None and name in (None, "csv", "repoimu"):
        raise ValueError(f"{source.path}: is damaged: its first bytes are not those of a {ending} file")
    if name is None:
        if source.names or source.is_folder:
            inside = ", ".join(source.names[:6]) + (", ..." if len(source.names) > 6 else "")
            message = f"{source.path}: expected a file, got a directory of no known device (with {inside or 'no file'})"
            raise IsADirectoryError(message) if source.is_folder else ValueError(message)
        listed = ", ".join(f"{key} ({one.title})" for key, one in known.items())
        raise ValueError(f"{source.path}: is of no known format; known are {listed}")
    return name


def _chosen(found: Mapping[str, Any], sensor: str | None) -> str:
    if sensor is None:
        return next(iter(found))
    if sensor not in found:
        raise ValueError(f"sensor: expected one of {_listed(found)}, got {sensor!r}")
    return sensor


def _listed(found: Mapping[str, Any]) -> str:
    return ", ".join(map(repr, found))


def _made(
    data: SensorData,
    source: Source,
    format: str,
    options: Options,
    window: tuple[float, float] | None,
    sensor: str | None = None,
) -> Recording:
    known = formats()[format]
    applied = replace(options, rate=None) if "rate" in known.options else options
    recording = finish(data, source.path, format, applied, convert="units" not in known.options)
    if sensor is not None or options.sensor is not None:
        recording.meta["sensor"] = sensor if sensor is not None else options.sensor
    if options.axes is not None:
        recording = recording.remapped(options.axes)
    return recording if window is None else recording.between(*window)


def told(recording: Recording) -> list[str]:
    """What has to be known of how a recording was read, sentence by sentence."""
    sentences = []
    assumed = recording.meta.get("assumed_units")
    if assumed:
        units = ", ".join(f"{quantity} in {unit}" for quantity, unit in assumed.items())
        sentences.append(f"no unit is stated, taken as {units}")
    for kind in TOLD:
        sentences += recording.meta.get(kind, ())
    return sentences


def _tell(recording: Recording, stacklevel: int = 3) -> None:
    sentences = told(recording)
    if sentences:
        warnings.warn(f"{recording.meta['path']}: {'; '.join(sentences)}", DataWarning, stacklevel=stacklevel)


def _counted(name: str, data: SensorData) -> SensorInfo:
    rates: dict[str, float | None] = {}
    for stream, (t, _) in data.streams.items():
        try:
            rates[stream] = data.rate if t is None else nominal_rate(t)
        except ValueError:
            rates[stream] = None
    return SensorInfo(name, {stream: len(values) for stream, (_, values) in data.streams.items()}, rates)
