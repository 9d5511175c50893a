"""Errors over many recordings: boxes, and each recording over time with their mean and spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import metrics
from ahrs_rs._printable import in_figure
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots._errors import ERRORS, ErrorPanel
from ahrs_rs.plots._figure import finish, one, require_matplotlib, time_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Bins of time over which recordings are averaged.
BINS = 250


def boxes(errors: Mapping[str, ArrayLike], *, label: str = "error [°]", ax: Axes | None = None) -> Axes:
    """Box plots of errors: median, quartiles, whiskers by `ahrs_rs.metrics.box`, and every value beyond them.

    Parameters
    ----------
    errors : mapping
        Label -> errors (n,), as those of a filter on each recording; NaN does not count.
    label : str, optional
        Of the ordinate.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a box for each label; a label without a value has none.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        Nothing to draw, or a wrong shape.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ax = ar.plots.boxes({"VQF": [1.0, 2.0, 3.0, 9.0], "Mahony": [4.0, 5.0, 5.5]})
    >>> [tick.get_text() for tick in ax.get_xticklabels()]
    ['VQF', 'Mahony']
    """
    if not errors:
        raise ValueError("errors: expected at least one label, got none")
    ax = one(ax, size=(1.6 + 0.7 * len(errors), 4.0))
    stats = []
    for name, given in errors.items():
        values = _values(name, given)
        values = values[~np.isnan(values)]
        numbers: dict[str, object] = {"label": in_figure(name)}
        if values.size:
            box = metrics.box(values)
            beyond = values[(values < box.low) | (values > box.high)]
            numbers |= {"med": box.median, "q1": box.q1, "q3": box.q3, "whislo": box.low, "whishi": box.high}
            numbers |= {"fliers": beyond, "mean": float(values.mean())}
        else:
            numbers |= dict.fromkeys(("med", "q1", "q3", "whislo", "whishi", "mean"), np.nan) | {"fliers": []}
        stats.append(numbers)
    ax.bxp(stats, showmeans=True, flierprops={"marker": ".", "markersize": 5})
    ax.set_xlim(0.4, len(stats) + 0.6)
    if len(stats) > 4:
        ax.tick_params("x", rotation=60)
    finish(ax, label, legend=False)
    return ax


def error_times(
    errors: Mapping[str, Sequence[ArrayLike]],
    t: Sequence[ArrayLike],
    *,
    label: str = "error [°]",
    ax: Axes | None = None,
) -> Axes:
    """Errors of many recordings over the time from their starts: each a thin line, their mean a thick one in a band.

    The band is one standard deviation over the recordings on either side. Each line has the root mean squares of 250
    parts of the longest recording.

    Parameters
    ----------
    errors : mapping
        Label -> for each recording its errors (T,); NaN does not count.
    t : sequence of array_like
        For each recording its stamps (T,), s.
    label : str, optional
        Of the ordinate.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        With a thin line for every recording of every label, and a thick one for every label.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        Nothing to draw, or shapes that do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> t = np.arange(100) / 10
    >>> len(ar.plots.error_times({"VQF": [np.sin(t), np.cos(t)]}, [t, t]).lines)
    3
    """
    if not errors:
        raise ValueError("errors: expected at least one label, got none")
    stamps = [_values("t", each) for each in t]
    stamps = [each - each[0] if each.size else each for each in stamps]
    longest = max((float(each[-1]) for each in stamps if each.size), default=0.0)
    bins = np.linspace(0.0, longest, BINS + 1)
    middles = 0.5 * (bins[:-1] + bins[1:])
    ax = one(ax)
    for number, (name, several) in enumerate(errors.items()):
        if len(several) != len(stamps):
            raise ValueError(f"errors: expected {len(stamps)} recordings of {name}, got {len(several)}")
        curves = []
        for index, (at, given) in enumerate(zip(stamps, several, strict=True)):
            values = _values(name, given)
            if len(values) != len(at):
                raise ValueError(f"errors: expected shape {at.shape} of {name}, recording {index}, got {values.shape}")
            curves.append(_binned(at, values, bins))
        _mean_and_each(ax, middles, np.array(curves).reshape(len(curves), BINS), in_figure(name), f"C{number % 10}")
    finish(ax, label)
    time_axis(ax)
    return ax


def draw_many(
    panels: Sequence[ErrorPanel], labels: Sequence[str], scores: Mapping[str, Mapping[str, Sequence[float]]]
) -> Figure:
    """Errors of estimates of many recordings: over time on the left, as boxes of each recording's RMSE on the right.

    Parameters
    ----------
    panels : sequence of ErrorPanel
        One for each recording.
    labels : sequence of str
        Of the curves, in the order of the legend.
    scores : mapping
        Label -> name of the error ("total", "heading", "inclination") -> RMSE of each recording, degrees.

    Returns
    -------
    Figure
        A row for each kind of error.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        No panels or no labels.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> panels = [ar.plots.ErrorPanel(ar.simulate.demo(duration=5.0, seed=seed), "") for seed in (0, 1)]
    >>> for panel in panels:
    ...     panel.add("still", [[1.0, 0.0, 0.0, 0.0]] * panel.samples)
    >>> scores = {"still": dict.fromkeys(["total", "heading", "inclination"], [30.0, 40.0])}
    >>> len(ar.plots.draw_many(panels, ["still"], scores).axes)
    6
    """
    if not panels or not labels:
        raise ValueError(f"expected panels and labels, got {len(panels)} panels and {len(labels)} labels")
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0 + 0.35 * len(labels), 10.0), layout="constrained")
    grid = figure.subplots(len(ERRORS), 2, squeeze=False, width_ratios=(2.0, 1.0 + 0.05 * len(labels)))
    for row, name in enumerate(ERRORS):
        left, right = grid[row]
        if row:
            left.sharex(grid[0, 0])
        error_times(
            {label: [panel.curves[label][name] for panel in panels] for label in labels},
            [panel.t for panel in panels],
            label=f"{name} error [°]",
            ax=left,
        )
        boxes({label: scores[label][name] for label in labels}, label=f"{name} RMSE [°]", ax=right)
        left.set_yscale("log")
        left.set_xlabel("time [s]" if row == len(ERRORS) - 1 else "")
        if row or len(labels) == 1:
            left.get_legend().remove()
        right.tick_params("x", labelbottom=row == len(ERRORS) - 1)
    figure.suptitle(f"{len(panels)} recordings: each a thin line, their mean a thick one, ± one standard deviation")
    return figure


def _mean_and_each(ax: Axes, t: FloatArray, curves: FloatArray, name: str, colour: str) -> None:
    thin = min(0.45, 3.0 / max(len(curves), 1) + 0.1)
    for curve in curves:
        marker = "." if np.count_nonzero(~np.isnan(curve)) == 1 else None
        ax.plot(t, curve, color=colour, linewidth=0.5, alpha=thin, marker=marker)
    known = ~np.isnan(curves)
    count = known.sum(axis=0)
    mean = np.full(len(t), np.nan)
    np.divide(np.where(known, curves, 0.0).sum(axis=0), count, out=mean, where=count > 0)
    squares = np.where(known, curves - mean, 0.0) ** 2
    spread = np.full(len(t), np.nan)
    np.divide(squares.sum(axis=0), count - 1, out=spread, where=count > 1)
    spread = np.sqrt(spread)
    ax.fill_between(t, np.maximum(mean - spread, 0.0), mean + spread, color=colour, alpha=0.15, linewidth=0)
    ax.plot(t, mean, color=colour, linewidth=2.0, label=name)


def _binned(t: FloatArray, values: FloatArray, bins: FloatArray) -> FloatArray:
    """(B,) root mean square of the values within each bin; between values that are farther apart, the line."""
    index = np.clip(np.searchsorted(bins, t, side="right") - 1, 0, len(bins) - 2)
    known = ~np.isnan(values)
    count = np.bincount(index[known], minlength=len(bins) - 1)
    squares = np.bincount(index[known], weights=values[known] ** 2, minlength=len(bins) - 1)
    mean = np.full(len(bins) - 1, np.nan)
    np.divide(squares, count, out=mean, where=count > 0)
    found: FloatArray = np.sqrt(mean)
    # A recording with fewer samples than bins leaves some without one: no gap, where a sample is on either side.
    hit = np.bincount(index, minlength=len(bins) - 1) > 0
    if len(t) > 1:
        middles = 0.5 * (bins[:-1] + bins[1:])
        inside = ~hit & (middles > t[0]) & (middles < t[-1])
        found[inside] = np.interp(middles[inside], t, values)  # NaN beside a NaN
    return found


def _values(name: str, given: ArrayLike) -> FloatArray:
    values: FloatArray = np.asarray(given, dtype=np.float64)
    if values.ndim != 1:
        raise ValueError(f"{name}: expected shape (n,), got {values.shape}")
    return values
