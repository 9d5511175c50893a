"""Figures that are described as plotly takes them (of a check, or of a study), drawn by matplotlib."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._printable import in_figure
from ahrs_rs._typing import FloatArray
from ahrs_rs.plots import _figure
from ahrs_rs.plots._figure import as_array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Described = Mapping[str, Any]


def evidence(figures: Sequence[Described], *, ax: Any = None) -> NDArray[Any]:
    """Draw figures that are described by traces and a layout: lines, points and clouds in space.

    Parameters
    ----------
    figures : sequence of mapping
        With ``title``, ``data`` (traces of the types scatter and scatter3d) and ``layout``; a trace with an ordinate
        of its own gets axes of its own.
    ax : Axes or sequence of Axes, optional
        One for each figure or ordinate; clouds take axes with a 3D projection. By default on a new figure.

    Returns
    -------
    ndarray
        (n,) of axes.

    Raises
    ------
    ImportError
        Matplotlib is not installed.
    ValueError
        Nothing to draw, or another number of axes.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> line = {"type": "scatter", "mode": "lines", "name": "a", "x": [0, 1], "y": [1, 2]}
    >>> len(ar.plots.evidence([{"title": "A line", "data": [line], "layout": {}}]))
    1
    """
    panels = [panel for figure in figures for panel in _panels(figure)]
    if not panels:
        raise ValueError("figures: expected at least one, got none")
    axes = _made([solid for _, _, _, solid in panels]) if ax is None else _figure.column(ax, len(panels))
    for each, (title, traces, layout, solid) in zip(axes, panels, strict=True):
        if solid and getattr(each, "name", "") != "3d":
            raise ValueError("ax: expected axes with a 3D projection for a cloud, got others")
        for trace in traces:
            _draw(each, trace)
        _lay_out(each, title, traces, layout)
    return as_array(axes)


def _panels(figure: Described) -> list[tuple[str, list[Described], Described, bool]]:
    """Title, traces, layout, and whether it is one in space, of each ordinate of a figure."""
    by_ordinate: dict[str, list[Described]] = {}
    for trace in figure["data"]:
        by_ordinate.setdefault(trace.get("yaxis", "y"), []).append(trace)
    found: list[tuple[str, list[Described], Described, bool]] = []
    for name, traces in by_ordinate.items():
        layout = dict(figure.get("layout", {}))
        layout["yaxis"] = layout.get(name.replace("y", "yaxis", 1), {})
        found.append((str(figure.get("title", "")), traces, layout, traces[0].get("type") == "scatter3d"))
    return found


def _made(solid: Sequence[bool]) -> list[Axes]:
    _figure.require_matplotlib()
    from matplotlib import pyplot

    columns = min(2, len(solid))
    rows = math.ceil(len(solid) / columns)
    figure = pyplot.figure(figsize=(6.0 * columns, 3.2 * rows), layout="constrained")
    return [
        figure.add_subplot(rows, columns, number + 1, projection="3d" if each else None)
        for number, each in enumerate(solid)
    ]


def _draw(ax: Axes, trace: Described) -> None:
    marker = trace.get("marker", {})
    points = "markers" in trace.get("mode", "lines")
    colour = marker.get("color")
    style: dict[str, Any] = {"label": in_figure(trace.get("name", "")), "markersize": 0.6 * marker.get("size", 4)}
    if isinstance(colour, str):
        # What browsers take and matplotlib does not: three digits are fine, names are the same.
        style["color"] = colour
    coordinates = [_numbers(trace[axis]) for axis in "xyz" if axis in trace]
    ax.plot(*coordinates, "o" if points else "-", **style)


def _lay_out(ax: Axes, title: str, traces: Sequence[Described], layout: Described) -> None:
    ax.set_title(in_figure(title), fontsize="medium")
    for axis, set_label, set_scale in (
        ("xaxis", ax.set_xlabel, ax.set_xscale),
        ("yaxis", ax.set_ylabel, ax.set_yscale),
    ):
        about = layout.get(axis, {})
        set_label(in_figure(re.sub(r"<[^>]*>", "", about.get("title", {}).get("text", ""))))
        if about.get("type") == "log":
            set_scale("log")
    if "range" in layout.get("yaxis", {}):
        ax.set_ylim(*layout["yaxis"]["range"])
    ax.grid(True, color="0.9", linewidth=0.6)
    if len(traces) > 1:
        ax.legend(frameon=False, fontsize="x-small")


def _numbers(values: Sequence[float | None]) -> FloatArray:
    return np.array([math.nan if value is None else value for value in values], dtype=np.float64)
