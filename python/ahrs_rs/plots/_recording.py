"""What sensors measured, over time and over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _clipping, _stillness, _welch
from ahrs_rs.plots import _figure
from ahrs_rs.plots._figure import COLOURS, as_array, bands, column, finish, gap_bands, line, one, time_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ahrs_rs._recording import Recording
    from ahrs_rs._streams import Stream

#: The sensors that are drawn, with the label of their axes.
SENSORS = {
    "gyr": "angular rate [rad/s]",
    "acc": "specific force [m/s²]",
    "mag": "magnetic field [µT]",
    "temperature": "temperature [°C]",
}
DENSITIES = {"gyr": "rad/s/√Hz", "acc": "m/s²/√Hz", "mag": "µT/√Hz"}


def sensor(recording: Recording, name: str = "gyr", *, marks: bool = True, ax: Axes | None = None) -> Axes:
    """What one sensor measured, at its own times.

    Parameters
    ----------
    recording : Recording
        With that sensor.
    name : str, optional
        "gyr", "acc", "mag" or "temperature".
    marks : bool, optional
        Whether rests (green) and gaps of its clock (grey) are shaded, and readings at the end of its range are marked.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each axis of the sensor.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        A sensor that the recording does not have.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ax = ar.plots.sensor(ar.simulate.demo(duration=5.0), "acc")
    >>> ax.get_ylabel()
    'specific force [m/s²]'
    """
    stream = _stream(recording, name)
    ax = one(ax)
    columns = stream.values if stream.values.ndim == 2 else stream.values[:, np.newaxis]
    names = _figure.AXES if columns.shape[1] == 3 else ("",)
    for label, each, colour in zip(names, columns.T, COLOURS, strict=False):
        line(ax, stream.t, each, label=label or None, color=colour)
    if marks:
        gap_bands(ax, stream.t, stream.missing)
        bands(ax, _rests(recording), "rest", _figure.REST)
        if columns.shape[1] == 3 and len(stream):
            clipped = _clipping.clipped(columns)
            if clipped.any():
                rows = np.flatnonzero(clipped)
                largest = columns[rows, np.argmax(np.abs(columns[rows]), axis=1)]
                ax.plot(stream.t[rows], largest, ".", color=_figure.CLIPPED, markersize=5, label="clipped", zorder=4)
    finish(ax, SENSORS[name])
    time_axis(ax)
    return ax


def recording(recording: Recording, *, marks: bool = True, ax: Any = None) -> NDArray[Any]:
    """The sensors of a recording, one below the other.

    Parameters
    ----------
    recording : Recording
        With any sensors.
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
        Matplotlib is not installed.
    ValueError
        No sensor that can be drawn, or another number of axes.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> len(ar.plots.recording(ar.simulate.demo(duration=5.0)))
    3
    """
    names = [name for name in SENSORS if name in recording.streams]
    if not names:
        raise ValueError(f"recording: expected one of {', '.join(SENSORS)}, got {' '.join(recording.streams)}")
    axes = column(ax, len(names))
    for each, name in zip(axes, names, strict=True):
        sensor(recording, name, marks=marks, ax=each)
        if each is not axes[-1]:
            each.set_xlabel("")
    return as_array(axes)


def spectrum(recording: Recording, name: str = "gyr", *, ax: Axes | None = None) -> Axes:
    """The spectral density of a sensor's axes up to the Nyquist rate, by Welch's method.

    Parameters
    ----------
    recording : Recording
        With that sensor, and some 512 readings of it without a gap.
    name : str, optional
        "gyr", "acc" or "mag".
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each axis; without any, and a text, where there are too few readings.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        A sensor that the recording does not have.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> len(ar.plots.spectrum(ar.simulate.demo(duration=30.0), "acc").lines)
    3
    """
    if name not in DENSITIES:
        raise ValueError(f"name: expected one of {', '.join(DENSITIES)}, got {name!r}")
    stream = _stream(recording, name).present()
    ax = one(ax)
    rate = stream.rate if len(stream) > 1 and stream.t[-1] > stream.t[0] else recording.rate
    for label, colour, values in zip(_figure.AXES, COLOURS, stream.values.T, strict=True):
        found = _welch.density(values[:, np.newaxis], rate)
        if found is not None:
            ax.plot(found[0][1:], np.sqrt(found[1][1:]), color=colour, label=label, linewidth=1.0)
    if ax.lines:
        ax.set_xscale("log")
        ax.set_yscale("log")
    else:
        ax.text(0.5, 0.5, "too few readings", transform=ax.transAxes, ha="center", va="center", color="0.4")
    finish(ax, f"{name} [{DENSITIES[name]}]")
    ax.set_xlabel("frequency [Hz]")
    return ax


def _stream(recording: Recording, name: str) -> Stream:
    if name not in SENSORS:
        raise ValueError(f"name: expected one of {', '.join(SENSORS)}, got {name!r}")
    stream = recording.streams.get(name)
    if stream is None:
        recording.require(name)  # its error says what there is
        raise ValueError(f"{name}: expected a sensor with readings")
    return stream


def _rests(recording: Recording) -> list[tuple[float, float]]:
    """Begin and end of each rest, s; none where it cannot be told."""
    gyr = recording.gyr
    half = max(1, round(0.5 * _stillness.WINDOW * recording.rate))
    if gyr is None or len(recording) < 2 * half + 1:
        return []
    t = recording.t
    phases = _stillness.find(t, gyr, recording.acc, half).phases
    return [(float(t[one.start]), float(t[one.stop - 1])) for one in phases]
