"""One recording of an inertial sensor: what `ahrs_rs.read` returns and every filter can be given."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _arrays, _axes, _html, _quat
from ahrs_rs._rate import nominal_rate
from ahrs_rs._streams import Stream, make_stream
from ahrs_rs._typing import FloatArray

__all__ = ["Recording", "Stream", "nominal_rate"]


#: The arrays of a recording, in the order shown and saved, with their columns (0: one-dimensional).
_COLUMNS = {"t": 0, "gyr": 3, "acc": 3, "mag": 3, "ref": 4, "mask": 0, "temperature": 0}
#: Whose clock is that of the rows: the first of these that is there.
_CLOCKS = ("gyr", "acc", "mag", "ref", "temperature")
#: What reads data frames and saves recordings: `ahrs_rs.io`, which imports this module, puts it here.
FORMATS: dict[str, Callable[..., Any]] = {}
#: The names of sensors, for messages.
_SENSORS = {
    "gyr": "gyroscope",
    "acc": "accelerometer",
    "mag": "magnetometer",
    "ref": "reference",
    "temperature": "thermometer",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """Samples of one sensor over time, in SI units, with the truth where it is known.

    The rows (`t`, `gyr`, `acc`, `mag`, ...) stand on the stamps of the gyroscope, and are what filters take. Beneath
    them are `streams`: what each sensor measured, at its own times. A recording from arrays of one length has the same
    stamps for all; `from_streams` takes sensors with clocks of their own, whose rows are made on first use.

    Parameters
    ----------
    t : ndarray
        (T,) s, finite and not decreasing.
    gyr : ndarray, optional
        (T, 3) angular rate in the sensor frame, rad/s, or None.
    acc : ndarray, optional
        (T, 3) specific force in the sensor frame, m/s², or None.
    mag : ndarray, optional
        (T, 3) magnetic field in the sensor frame, µT, or None.
    ref : ndarray, optional
        (T, 4) true orientation, scalar-first, sensor to earth, or None.
    mask : ndarray, optional
        (T,) bool, the samples that count in a score, or None for all of them.
    temperature : ndarray, optional
        (T,) of the sensor, °C, or None.
    rate : float, optional
        Hz; NaN (the default) takes the rate of `t` over its parts without a gap.
    meta : dict, optional
        What else is known: path, format, units found, repairs made.
    others : dict, optional
        Further streams by their names, such as ``device_quat``, ``heading``, ``velocity``,
        ``pressure``.

    Raises
    ------
    ValueError
        A wrong shape, length or dtype, a decreasing `t`, a rate that is not positive, or no sensor at all.

    Notes
    -----
    All arrays are float64, whatever the file stored, except `mask`. NaN means "no measurement".

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> rec = ar.Recording(t=np.arange(50) / 100, gyr=np.zeros((50, 3)), acc=np.tile([0.0, 0.0, 9.81], (50, 1)))
    >>> rec
    Recording(50 samples, 0.49 s, 100 Hz, gyr acc)
    >>> ar.Madgwick().run(rec).quat[-1]
    array([1., 0., 0., 0.])
    """

    t: FloatArray
    gyr: FloatArray | None = None
    acc: FloatArray | None = None
    mag: FloatArray | None = None
    ref: FloatArray | None = None
    mask: NDArray[np.bool_] | None = None
    temperature: FloatArray | None = None
    rate: float = math.nan
    meta: dict[str, Any] = field(default_factory=dict)
    others: dict[str, Stream] = field(default_factory=dict)
    _own: dict[str, Stream] | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        put = object.__setattr__
        length = None
        for name, columns in _COLUMNS.items():
            value = getattr(self, name)
            if value is None and name != "t":
                continue
            array = _mask(value) if name == "mask" else _float_array(name, value)
            length = len(array) if length is None and array.ndim else length
            expected = (length,) if columns == 0 else (length, columns)
            if array.shape != expected:
                shown = str(expected).replace("None", "T")
                raise ValueError(f"{name}: expected shape {shown}, got {array.shape}")
            put(self, name, array)
        if all(getattr(self, name) is None for name in _CLOCKS) and not self.others:
            raise ValueError("gyr: expected at least one sensor, got none")
        _check_times(self.t)
        for name in self.others:
            if name in _COLUMNS:
                raise ValueError(
                    f"others: expected names of further streams, got {name!r}, which has an argument of its own"
                )
        put(self, "others", dict(self.others))
        put(self, "_own", None)
        put(self, "rate", _checked_rate(self.rate, self.t))

    # -- streams -------------------------------------------------------------------------------------------------------

    @classmethod
    def from_streams(
        cls,
        *,
        rate: float | None = None,
        meta: Mapping[str, Any] | None = None,
        **streams: tuple[ArrayLike, ArrayLike] | Stream,
    ) -> Self:
        """A recording of sensors with clocks of their own.

        Parameters
        ----------
        rate : float, optional
            Hz of the rows; None takes that of the clock.
        meta : mapping, optional
            What else is known.
        **streams : tuple or Stream
            ``(t, values)`` or `Stream` by name: ``gyr``, ``acc``, ``mag``, ``ref``, ``mask``,
            ``temperature`` as the arguments of `Recording`, and any further ones, which are kept. All
            times are on one time base, s.

        Returns
        -------
        Recording
            Its rows stand on the stamps of the gyroscope (without one: of the first sensor), made by `aligned` on first
            use.

        Raises
        ------
        ValueError
            Shapes that do not fit, times that decrease, or no sensor.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> field = [[20.0, 0.0, -40.0], [20.0, 0.0, -40.0]]
        >>> rec = ar.Recording.from_streams(gyr=(np.arange(6) / 100, np.zeros((6, 3))), mag=([0.005, 0.035], field))
        >>> rec.mag[:, 0]
        array([nan, 20., nan, nan, 20., nan])
        """
        own = {}
        for name, given in streams.items():
            stream = given if isinstance(given, Stream) else make_stream(name, *_pair(name, given))
            if name == "mask":
                stream = Stream(stream.t, _mask(stream.values))
            columns = _COLUMNS.get(name)
            if columns is not None and stream.values.shape[1:] != ((columns,) if columns else ()):
                shape = f"(n, {columns})" if columns else "(n,)"
                raise ValueError(f"{name}: expected values of shape {shape}, got {stream.values.shape}")
            own[name] = stream
        base = next((name for name in _CLOCKS if name in own), next(iter(own), None))
        if base is None:
            raise ValueError("streams: expected at least one sensor, got none")
        clock = own[base].t
        given_rate = math.nan if rate is None else rate
        self = object.__new__(cls)
        put = object.__setattr__
        put(self, "_own", own)
        put(self, "others", {name: one for name, one in own.items() if name not in _COLUMNS})
        put(self, "meta", dict(meta or {}))
        put(self, "t", clock)
        put(self, "rate", _checked_rate(given_rate, clock))
        return self

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        columns: Mapping[str, str | Sequence[str]] | None = None,
        units: Mapping[str, str] | None = None,
        axes: str | None = None,
        sensor: str | None = None,
        timezone: str | None = None,
        rate: float | None = None,
    ) -> Recording:
        """The recording in a data frame, whose columns are understood as those of a file.

        Parameters
        ----------
        frame : object
            DataFrame of pandas (NumPy, nullable and Arrow dtypes) or polars, Table of pyarrow, or a
            dict of arrays. A time is a column of numbers, dates or durations, or the index of pandas.
            Columns of vectors are taken too.
        columns, units, axes, sensor, timezone, rate : mapping, optional
            As of `ahrs_rs.read`.

        Returns
        -------
        Recording
            What the columns tell.

        Raises
        ------
        ValueError
            Columns that cannot be understood, units that cannot be, several sensors.
        TypeError
            Something that is no data frame.

        Warns
        -----
        DataWarning
            One, with all that was assumed, repaired, ignored.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> t = np.arange(50) / 100
        >>> ar.Recording.from_frame({"t (s)": t, **{f"gyr_{axis} (deg/s)": 90.0 * t for axis in "xyz"}})
        Recording(50 samples, 0.49 s, 100 Hz, gyr, 'data frame')
        """
        found: Recording = FORMATS["from_frame"](
            frame, columns=columns, units=units, axes=axes, sensor=sensor, timezone=timezone, rate=rate
        )
        return found

    def __getattr__(self, name: str) -> Any:
        # Reached only where a slot is still empty: the rows of `from_streams`, on first use.
        if name not in _COLUMNS:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        own = object.__getattribute__(self, "_own")
        stream = own.get(name)
        value = None if stream is None else _row(name, stream, self.t, interpolate=False)
        object.__setattr__(self, name, value)
        return value

    @property
    def streams(self) -> Mapping[str, Stream]:
        """What each sensor measured at its own times, by name; rows in which nothing was measured are not in it."""
        if self._own is not None:
            return MappingProxyType(self._own)
        rows = {
            name: Stream(self.t, array) if name in ("gyr", "mask") else Stream(self.t, array).present()
            for name, array in self._arrays().items()
            if name != "t"
        }
        return MappingProxyType({**rows, **self.others})

    @property
    def has_own_clocks(self) -> bool:
        """Whether sensors have stamps of their own, from which the rows are made."""
        return self._own is not None

    @property
    def device_quat(self) -> FloatArray | None:
        """(T, 4) orientation as the device itself estimated it, scalar-first, sensor to its earth frame, or None.

        It is no truth. ``meta["device_frame"]`` names its earth frame where it is known.
        """
        stream = self.others.get("device_quat")
        return None if stream is None else stream.turning(self.t)

    def aligned(self, rate: float | None = None, interpolate: bool = False) -> Self:
        """The recording in rows of one clock.

        Parameters
        ----------
        rate : float, optional
            None takes the stamps of the gyroscope; a number of Hz regular ones from its first stamp on,
            with the mean of the angular rate over each step.
        interpolate : bool, optional
            False puts a reading of the accelerometer or the magnetometer on the first stamp at or after
            its own and NaN elsewhere: nothing is known before it was measured. True gives the line
            between readings.

        Returns
        -------
        Recording
            With rows only. The reference is interpolated along the shortest rotation (slerp) and `temperature` along
            lines, and nothing is interpolated over a gap (2.5 usual steps of the stream, or missing rows).
        """
        own = self.streams
        clock, nominal = self.t, self.rate
        if rate is not None:
            nominal = _checked_rate(rate, clock)
            if len(clock):
                clock = clock[0] + np.arange(math.floor((clock[-1] - clock[0]) * nominal + 1e-9) + 1) / nominal
        rows: dict[str, Any] = {name: _row(name, own[name], clock, interpolate) for name in _COLUMNS if name in own}
        others = {name: one for name, one in own.items() if name not in _COLUMNS}
        return type(self)(t=clock, rate=nominal, meta=dict(self.meta), others=others, **rows)

    def remapped(self, axes: str) -> Self:
        """The recording in a sensor frame whose axes are others.

        Parameters
        ----------
        axes : str
            Which of the old axes the new x, y and z are, with their signs: ``"x,-y,-z"`` turns
            front-right-down into front-left-up.

        Returns
        -------
        Recording
            Vectors of the sensor frame are turned, orientations (`ref`, `device_quat`) too; ``meta["remapped"]`` says
            so.

        Raises
        ------
        ValueError
            Not three different axes, or a mirror image of them.
        """
        matrix = _axes.axes_matrix(axes)
        back = _quat.conjugate(_quat.of_matrix(matrix))

        def turned(name: str, values: NDArray[Any]) -> NDArray[Any]:
            if _axes.is_sensor_vector(name) and values.ndim == 2 and values.shape[1] == 3:
                return np.asarray(values @ matrix.T)
            if name in _axes.ORIENTATIONS:
                return _quat.multiply(values, back)
            return values

        made = self.changed(turned)
        made.meta["remapped"] = ", ".join([*filter(None, [self.meta.get("remapped")]), axes])
        return made

    def between(self, start: float, end: float) -> Self:
        """What was measured at start <= t <= end (s), as views; NaN in `start` or `end` is an error.

        Parameters
        ----------
        start : float
            First stamp in s.
        end : float
            Last stamp in s.

        Returns
        -------
        Recording
            Views of the same arrays.
        """
        if not start <= end:
            raise ValueError(f"between: expected start <= end in s, got {start!r} and {end!r}")
        if self._own is None:
            part = slice(int(np.searchsorted(self.t, start)), int(np.searchsorted(self.t, end, side="right")))
            return self[part]
        own = {name: stream.between(start, end) for name, stream in self._own.items()}
        return type(self).from_streams(rate=self.rate, meta=self.meta, **own)

    def changed(self, change: Callable[[str, NDArray[Any]], NDArray[Any]]) -> Self:
        """The recording with ``change(name, values)`` in place of the values of each stream (of each row array).

        Parameters
        ----------
        change : callable
            Called with the name of a stream and its values; gives the new values.

        Returns
        -------
        Recording
            Of the same stamps.
        """
        if self._own is not None:
            own = {name: Stream(one.t, change(name, one.values)) for name, one in self._own.items()}
            return type(self).from_streams(rate=self.rate, meta=self.meta, **own)
        rows: dict[str, Any] = {
            name: array if name == "t" else change(name, array) for name, array in self._arrays().items()
        }
        others = {name: Stream(one.t, change(name, one.values)) for name, one in self.others.items()}
        return type(self)(**rows, rate=self.rate, meta=dict(self.meta), others=others)

    def require(self, name: str) -> FloatArray:
        """The rows of a sensor; ValueError where the recording has none of it.

        Parameters
        ----------
        name : str
            "gyr", "acc", "mag" or another array.

        Returns
        -------
        ndarray
            The rows.
        """
        value: FloatArray | None = getattr(self, name)
        if value is None:
            has = " ".join(one for one in self.streams if one not in ("mask", "t")) or "nothing"
            raise ValueError(f"{name}: expected a {_SENSORS.get(name, name)}, the recording has {has}")
        return value

    # -- as a sequence of rows -----------------------------------------------------------------------------------------

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.t)

    def __getitem__(self, key: slice) -> Self:
        """The rows of a slice without a step, as views; `rate` and `meta` stay."""
        if not isinstance(key, slice):
            raise TypeError(f"a recording is cut by a slice, like recording[10:20], not by {key!r}")
        if key.step not in (None, 1):
            raise ValueError(f"step: a slice of a recording has step 1, got {key.step}")
        arrays = {name: value[key] for name, value in self._arrays().items()}
        t = arrays["t"]
        ends = (float(t[0]), float(t[-1])) if len(t) else (math.inf, math.inf)
        others = {name: one.between(*ends) for name, one in self.others.items()}
        return type(self)(**arrays, rate=self.rate, meta=dict(self.meta), others=others)

    def __repr__(self) -> str:
        names = " ".join(name for name in [*_COLUMNS, *self.others] if name != "t" and self._has(name))
        source = f", {Path(str(self.meta['path'])).name!r}" if "path" in self.meta else ""
        return f"Recording({len(self)} samples, {self.duration:.6g} s, {self.rate:.6g} Hz, {names}{source})"

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = []
        if "path" in self.meta:
            rows.append(("file", Path(str(self.meta["path"])).name))
        rows.append(("rows", f"{len(self)}, {_html.number(self.duration, 's')}, {_html.number(self.rate, 'Hz')}"))
        for name, stream in self.streams.items():
            what = _SENSORS.get(name, name)
            if name == "mask":
                rows.append(("scored", f"{int(np.count_nonzero(stream.values))} rows"))
                continue
            count = len(stream)
            missing = int(np.count_nonzero(stream.missing)) if count else 0
            text = f"{count - missing} readings" + (f", {missing} rows missing" if missing else "")
            if self.has_own_clocks and count > 2 and stream.t[-1] > stream.t[0]:
                text += f", {_html.number(stream.rate, 'Hz')}"
            rows.append((what, text))
        for kind in ("assumed", "repairs", "lost", "doubts"):
            rows += [(kind, text) for text in self.meta.get(kind, ())]
        return _html.summary("Recording", rows)

    def plot(self, *, marks: bool = True, ax: Any = None) -> NDArray[Any]:
        """Draw what each sensor measured, one below the other.

        Parameters
        ----------
        marks : bool, optional
            Whether rests (green) and gaps (grey) are shaded, and clipped readings are marked.
        ax : Axes or sequence of Axes, optional
            As many as there are sensors; by default on a new figure.

        Returns
        -------
        ndarray
            (n,) of axes, from top to bottom.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        ValueError
            No sensor that can be drawn, or another number of axes.

        See Also
        --------
        ahrs_rs.plots.sensor : One of them.
        ahrs_rs.plots.spectrum : Its spectrum.
        """
        from ahrs_rs import plots  # for drawing only

        return plots.recording(self, marks=marks, ax=ax)

    def _has(self, name: str) -> bool:
        if name in self.others:
            return True
        return name in self._own if self._own is not None else getattr(self, name) is not None

    @property
    def duration(self) -> float:
        """Time from the first to the last row, s."""
        return float(self.t[-1] - self.t[0]) if len(self) else 0.0

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file which `ahrs_rs.read` gives back.

        Parameters
        ----------
        path : str or path-like
            The ending tells the format. .npz is exact, with the streams of sensors that have clocks of
            their own, rate and meta (values that JSON does not know are written as text). .parquet and
            .csv hold the rows, with units in the names of the columns; .parquet also rate and meta.

        Raises
        ------
        ValueError
            Another ending.
        """
        FORMATS["save"](self, Path(path))

    def _arrays(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _COLUMNS if getattr(self, name) is not None}


def _row(name: str, stream: Stream, clock: FloatArray, interpolate: bool) -> NDArray[Any]:
    """The readings of a sensor on the stamps of the rows."""
    if name == "ref":
        return stream.turning(clock)
    if name == "mask":
        return stream.held(clock)
    if name == "temperature":
        return stream.linear(clock)
    if name == "gyr":
        return stream.averaged(clock)
    return stream.linear(clock) if interpolate else stream.arriving(clock)


def _pair(name: str, given: Any) -> tuple[Any, Any]:
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise ValueError(f"{name}: expected (t, values), got {type(given).__name__}")
    return given[0], given[1]


def _check_times(t: FloatArray) -> None:
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise ValueError(f"t: expected finite times, got {t[bad[0]]} at index {bad[0]}")
    bad = np.flatnonzero(t[1:] < t[:-1])
    if bad.size:
        raise ValueError(f"t: expected times that do not decrease, got a decrease at index {bad[0] + 1}")


def _checked_rate(given: float, t: FloatArray) -> float:
    rate = float(given)
    made = nominal_rate(t) if math.isnan(rate) else rate
    if not (math.isfinite(made) and made > 0):
        raise ValueError(f"rate: expected a positive number of Hz, got {rate}")
    return made


def _float_array(name: str, value: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(_arrays.vectors(name, value))
        if array.dtype.kind not in "fiu":
            raise TypeError(f"dtype {array.dtype}")
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError) as error:
        if str(error).startswith(f"{name}: "):
            raise
        raise ValueError(f"{name}: expected an array of real numbers, got {error}") from None


def _mask(value: ArrayLike) -> NDArray[np.bool_]:
    array = np.asarray(value)
    if array.dtype.kind != "b" and not (array.dtype.kind in "iuf" and np.isin(array, (0, 1)).all()):
        raise ValueError(f"mask: expected an array of bool (or of 0 and 1), got dtype {array.dtype}")
    return array.astype(np.bool_, copy=False)
