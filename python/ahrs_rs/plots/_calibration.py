"""Calibrations: the ellipsoid before and after, positions, turns, and the Allan deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs._constants import GRAVITY
from ahrs_rs._printable import in_figure
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots import _figure
from ahrs_rs.plots._figure import COLOURS, as_array, finish, one

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ahrs_rs.calibration import Allan, EllipsoidFit, GyroscopeFit, Noise, PositionsFit, SensorNoise

#: Points of a cloud.
CLOUD = 5000
PLANES = ((0, 1), (0, 2), (1, 2))


def ellipsoid(fit: EllipsoidFit, readings: ArrayLike, *, title: str = "", ax: Any = None) -> NDArray[Any]:
    """The readings of a fit in three planes and their norms, before and after, over the sphere that they belong on.

    Parameters
    ----------
    fit : EllipsoidFit
        Of a magnetometer or an accelerometer.
    readings : array_like
        (T, 3) that it was fitted to, or others; rows with NaN are left out.
    title : str, optional
        Of a new figure.
    ax : sequence of Axes, optional
        Eight of them, (2, 4): by default on a new figure.

    Returns
    -------
    ndarray
        (2, 4) of axes: before and after; the planes xy, xz, yz and the norms.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        A wrong shape, or another number of axes.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal((2000, 3))
    >>> x = 48.0 * x / np.linalg.norm(x, axis=1, keepdims=True) + [12.0, -3.0, 5.0]
    >>> ar.plots.ellipsoid(ar.calibration.magnetometer(x), x).shape
    (2, 4)
    """
    array = _vectors("readings", readings)
    raw = array[~np.isnan(array).any(axis=1)]
    raw = raw[:: max(len(raw) // CLOUD, 1)]
    after = np.asarray(fit.calibration.apply(raw), dtype=np.float64)
    grid = _grid(ax, title)
    rows = (("before", raw, fit.deviation_before), ("after", after, fit.deviation_after))
    from matplotlib.patches import Circle

    for row, (label, points, deviation) in enumerate(rows):
        for number, (i, j) in enumerate(PLANES):
            axes = grid[row, number]
            axes.plot(points[:, i], points[:, j], ".", markersize=2, color=f"C{row}")
            axes.add_patch(Circle((0, 0), fit.norm, fill=False, color="0.4"))
            axes.set_aspect("equal", "datalim")
            axes.set_xlabel(f"{'xyz'[i]} {label}")
            axes.set_ylabel("xyz"[j])
            axes.grid(True, color="0.9")
        axes = grid[row, 3]
        axes.plot(np.linalg.norm(points, axis=1), ".", markersize=2, color=f"C{row}")
        axes.axhline(fit.norm, color="0.4")
        axes.set_title(f"norm {label}: ± {deviation:.2g} %", fontsize="medium")
        axes.set_xlabel("reading")
    return grid


def positions(
    fit: PositionsFit, readings: Sequence[ArrayLike], *, gravity: float = GRAVITY, ax: Axes | None = None
) -> Axes:
    """The norms of the positions that an accelerometer was held in, before and after, beside gravity.

    Parameters
    ----------
    fit : PositionsFit
        From `ahrs_rs.calibration.six_positions`.
    readings : sequence of array_like
        For each position its readings (n, 3), or their mean (3,), m/s².
    gravity : float, optional
        Of the place, m/s².
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With two points for each position.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        A wrong shape.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> held = [sign * 9.80665 * np.eye(3)[axis][None] + 0.1 for axis in range(3) for sign in (1, -1)]
    >>> len(ar.plots.positions(ar.calibration.six_positions(held), held).lines)
    3
    """
    rows = [_vectors("readings", np.atleast_2d(np.asarray(each, dtype=np.float64))) for each in readings]
    means = np.array([row[~np.isnan(row).any(axis=1)].mean(axis=0) for row in rows]).reshape(len(rows), 3)
    after = np.asarray(fit.calibration.apply(means), dtype=np.float64)
    ax = one(ax, size=(6.5, 3.4))
    number = np.arange(1, len(rows) + 1)
    for label, values, marker, colour in (("before", means, "o", "C0"), ("after", after, "s", "C1")):
        ax.plot(number, np.linalg.norm(values, axis=1), marker, color=colour, label=label)
    ax.axhline(gravity, color="0.4", linewidth=0.8, label="gravity")
    ax.set_xticks(number)
    ax.set_xlabel("position")
    finish(ax, "norm [m/s²]")
    return ax


def turns(fit: GyroscopeFit, *, ax: Axes | None = None) -> Axes:
    """What the calibrated turns of a gyroscope lack, in degrees, for each turn and axis.

    Parameters
    ----------
    fit : GyroscopeFit
        From `ahrs_rs.calibration.gyroscope`, or from a reference (then the RMS over its windows).
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With three bars for each turn.

    Raises
    ------
    ImportError
        Matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> fit = ar.calibration.gyroscope(np.full((500, 3), 0.01))
    >>> ar.plots.turns(fit).get_ylabel()
    'residual [°]'
    """
    residual = np.degrees(np.asarray(fit.residual, dtype=np.float64).reshape(-1, 3))
    ax = one(ax, size=(6.5, 3.4))
    number = np.arange(1, len(residual) + 1)
    for axis, (name, colour) in enumerate(zip(_figure.AXES, COLOURS, strict=True)):
        ax.bar(number + 0.27 * (axis - 1), residual[:, axis], width=0.25, color=colour, label=name)
    ax.axhline(0.0, color="0.4", linewidth=0.8)
    ax.set_xticks(number)
    ax.set_xlabel("turn")
    finish(ax, "residual [°]", legend=bool(len(residual)))
    if not len(residual):
        ax.text(0.5, 0.5, "no turns: bias alone", transform=ax.transAxes, ha="center", va="center", color="0.4")
    return ax


def allan(
    found: Allan | SensorNoise | Mapping[str, Allan], *, model: bool = True, title: str = "", ax: Axes | None = None
) -> Axes:
    """Allan deviations over the cluster time, with their confidence, and the fitted models (dashed).

    Parameters
    ----------
    found : Allan, SensorNoise or mapping
        One, those of the three axes of a sensor, or several by their labels.
    model : bool, optional
        Whether the models are drawn.
    title : str, optional
        Above the axes.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a line for each, on logarithmic axes.

    Raises
    ------
    ImportError
        Matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal(10000)
    >>> len(ar.plots.allan(ar.calibration.allan(x, 100.0)).lines)
    2
    """
    if isinstance(found, Mapping):
        curves = dict(found)
    elif hasattr(found, "axes"):
        curves = dict(zip(_figure.AXES, found.axes, strict=True))
    else:
        curves = {"": found}
    ax = one(ax, size=(5.4, 4.4))
    for number, (label, each) in enumerate(curves.items()):
        colour = f"C{number}"
        ax.fill_between(each.tau, each.low, each.high, color=colour, alpha=0.2, linewidth=0)
        ax.plot(each.tau, each.deviation, color=colour, label=in_figure(label) or None)
        if model:
            fitted = each.tau >= each.fitted_from
            ax.plot(each.tau[fitted], each.model(each.tau[fitted]), color=colour, linestyle="--", linewidth=0.8)
    ax.set_xscale("log")
    ax.set_yscale("log")
    if title:
        ax.set_title(in_figure(title), fontsize="medium")
    ax.set_xlabel("cluster time [s]")
    units = dict.fromkeys(each.unit for each in curves.values())
    ax.set_ylabel(f"Allan deviation [{', '.join(units)}]")
    ax.grid(True, which="major", color="0.8", linewidth=0.6)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(frameon=False)
    return ax


def noise(found: Noise, *, ax: Any = None) -> NDArray[Any]:
    """The Allan deviations of all sensors of a recording at rest, side by side.

    Parameters
    ----------
    found : Noise
        From `ahrs_rs.calibration.noise`.
    ax : Axes or sequence of Axes, optional
        As many as there are sensors; by default on a new figure.

    Returns
    -------
    ndarray
        (n,) of axes.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        Another number of axes.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=60.0, sensor=ar.simulate.SENSORS["mpu9250"])
    >>> len(ar.plots.noise(ar.calibration.noise(rec)))
    3
    """
    count = len(found.sensors)
    if ax is None:
        _figure.require_matplotlib()
        from matplotlib import pyplot

        figure = pyplot.figure(figsize=(4.6 * count + 0.4, 4.4), layout="constrained")
        panels = list(figure.subplots(1, count, squeeze=False)[0])
    else:
        panels = _figure.column(ax, count)
    for panel, (name, sensor) in zip(panels, found.sensors.items(), strict=True):
        allan(sensor, title=name, ax=panel)
    return as_array(panels)


def _grid(ax: Any, title: str) -> NDArray[Any]:
    if ax is not None:
        return as_array(_figure.column(ax, 8)).reshape(2, 4)
    _figure.require_matplotlib()
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(12, 7), layout="constrained")
    if title:
        figure.suptitle(in_figure(title))
    grid: NDArray[Any] = figure.subplots(2, 4)
    return grid


def _vectors(name: str, value: Any) -> FloatArray:
    array: FloatArray = np.asarray(value, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: expected shape (T, 3), got {array.shape}")
    return array
