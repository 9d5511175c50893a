"""Figures of orientation errors over time.

No window is opened and no backend is chosen: the functions return a ``matplotlib.figure.Figure``, which `save` writes
anywhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import metrics
from ahrs_rs._printable import in_figure
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots._figure import require_matplotlib

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ahrs_rs._recording import Recording

#: The rows of the figure: name -> the error in degrees.
ERRORS = {
    "total": metrics.total_error,
    "heading": metrics.heading_error,
    "inclination": metrics.inclination_error,
}

#: A curve has at most so many points; each is the root mean square of the samples that it stands for.
POINTS = 250

#: Errors below this are drawn at it, °: nothing smaller can be told from zero in such a figure.
FLOOR = 0.01

COLOURS = 10
STYLES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1, 1)))


class ErrorPanel:
    """Errors of several estimates of one recording, thinned for drawing.

    Parameters
    ----------
    recording : Recording
        With `ref`; its `mask` tells the samples that are not shaded.
    title : str
        What stands above the panel.

    Raises
    ------
    ValueError
        The recording has no reference or no samples.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> panel = ar.plots.ErrorPanel(rec, "walk")
    >>> panel.add("truth", rec.ref)
    >>> list(panel.curves)
    ['truth']
    """

    def __init__(self, recording: Recording, title: str) -> None:
        if recording.ref is None:
            raise ValueError("recording: expected one with a reference, got ref None")
        if not len(recording):
            raise ValueError("recording: expected at least one sample, got none")
        self.title = title
        self.samples = len(recording)
        self.curves: dict[str, dict[str, FloatArray]] = {}
        self._ref: FloatArray | None = recording.ref
        count = len(recording)
        edges = np.linspace(0, count, min(count, POINTS) + 1).astype(np.intp)
        self._starts = edges[:-1]
        self._ends = edges[1:]
        #: (P,) middle of the samples of each point, s from the first sample
        self.t: FloatArray = 0.5 * (recording.t[self._starts] + recording.t[self._ends - 1]) - recording.t[0]
        mask = np.ones(count, dtype=np.bool_) if recording.mask is None else recording.mask
        #: (P,) whether any sample of the point counts
        self.counts: NDArray[np.bool_] = np.logical_or.reduceat(mask, self._starts)

    @property
    def step(self) -> float:
        """Mean time between two points, s."""
        return float(self.t[-1] - self.t[0]) / max(len(self.t) - 1, 1)

    def add(self, label: str, quat: ArrayLike, ref: ArrayLike | None = None) -> None:
        """Errors of the orientations (T, 4) against another reference (T, 4) where one is given.

        Parameters
        ----------
        label : str
            Of the curve.
        quat : array_like
            (T, 4) the estimate.
        ref : array_like, optional
            (T, 4) another reference; by default that of the recording.
        """
        truth = self._ref if ref is None else ref
        if truth is None:
            raise ValueError("ref: expected a reference, as the panel is finished, got None")
        self.curves[label] = {name: self._thinned(error(quat, truth, degrees=True)) for name, error in ERRORS.items()}

    def finish(self) -> None:
        """Let the reference go: no more estimates come, and hundreds of panels are to take no memory."""
        self._ref = None

    def _thinned(self, error: FloatArray) -> FloatArray:
        known = ~np.isnan(error)
        squares = np.add.reduceat(np.where(known, error, 0.0) ** 2, self._starts)
        counts = np.add.reduceat(known.astype(np.float64), self._starts)
        mean = np.full(len(counts), np.nan)
        np.divide(squares, counts, out=mean, where=counts > 0)
        thinned: FloatArray = np.sqrt(mean)
        return thinned


def errors(recording: Recording, quats: Mapping[str, ArrayLike], title: str = "") -> Figure:
    """Total, heading and inclination errors over time, one curve per estimate.

    Parameters
    ----------
    recording : Recording
        With `ref`.
    quats : mapping
        Label -> orientations (T, 4), in the earth frame of the reference.
    title : str, optional
        Of the figure.

    Returns
    -------
    Figure
        Three rows of axes.

    Raises
    ------
    ImportError
        matplotlib is not installed.
    ValueError
        No reference, no estimate, or a wrong shape.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> len(ar.plots.errors(rec, {"truth": rec.ref}).axes)
    3
    """
    panel = ErrorPanel(recording, title)
    for label, quat in quats.items():
        panel.add(label, quat)
    return draw([panel], list(quats))


def draw(panels: Sequence[ErrorPanel], labels: Sequence[str]) -> Figure:
    """A figure with a column of axes for every panel and the curves of `labels` in their order.

    Parameters
    ----------
    panels : sequence of ErrorPanel
        From top to bottom.
    labels : sequence of str
        Of the curves, in the order of the legend.

    Returns
    -------
    Figure
        A panel below the other.

    Raises
    ------
    ImportError
        matplotlib is not installed.
    ValueError
        No panels or no labels.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> panel = ar.plots.ErrorPanel(rec, "walk")
    >>> panel.add("truth", rec.ref)
    >>> len(ar.plots.draw([panel], ["truth"]).axes)
    3
    """
    if not panels or not labels:
        raise ValueError(f"expected panels and labels, got {len(panels)} panels and {len(labels)} labels")
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.6 + 6.2 * len(panels) ** 0.75, 8.4), layout="constrained")
    grid = figure.subplots(len(ERRORS), len(panels), sharex="col", sharey=True, squeeze=False)
    for column, panel in enumerate(panels):
        for row, name in enumerate(ERRORS):
            _draw_axes(grid[row, column], panel, name, labels)
        grid[0, column].set_title(in_figure(panel.title), fontsize="medium")
        step = "" if panel.samples == len(panel.t) else f" (a point: RMS of {panel.step:.2g} s)"
        grid[-1, column].set_xlabel(f"time [s]{step}")
    for row, name in enumerate(ERRORS):
        grid[row, 0].set_ylabel(f"{name} error [°]")
    _scale(grid[0, 0], panels, labels)
    handles, names = grid[0, 0].get_legend_handles_labels()
    shade = grid[0, 0].fill_between([], [], [], color="0.9", label="not scored")
    if any(not panel.counts.all() for panel in panels):
        handles, names = [*handles, shade], [*names, "not scored"]
    figure.legend(handles, names, loc="outside right upper", frameon=False)
    return figure


def _draw_axes(axes: Axes, panel: ErrorPanel, name: str, labels: Sequence[str]) -> None:
    axes.fill_between(
        panel.t,
        0.0,
        1.0,
        where=(~panel.counts).tolist(),
        step="mid",
        transform=axes.get_xaxis_transform(),
        color="0.9",
        linewidth=0,
    )
    for index, label in enumerate(labels):
        axes.plot(
            panel.t,
            np.maximum(panel.curves[label][name], FLOOR),
            color=f"C{index % COLOURS}",
            linestyle=STYLES[index // COLOURS % len(STYLES)],
            linewidth=1.2,
            label=in_figure(label),
            zorder=3 + 1 / (1 + index),  # the first ones, which matter most, lie above
        )
    axes.grid(True, which="major", color="0.8", linewidth=0.6)
    axes.margins(x=0.01)


def _scale(axes: Axes, panels: Sequence[ErrorPanel], labels: Sequence[str]) -> None:
    """A logarithmic axis with plain numbers, for all axes (they share it)."""
    values = np.concatenate([panel.curves[label][name] for panel in panels for label in labels for name in ERRORS])
    values = np.maximum(values[~np.isnan(values)], FLOOR)
    # A curve that touches zero for a moment shall not take half of the figure.
    low = np.percentile(values, 1) if values.size else 1.0
    high = values.max() if values.size else 1.0
    axes.set_yscale("log")
    axes.set_ylim(0.7 * low, min(1.5 * high, 200.0))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
