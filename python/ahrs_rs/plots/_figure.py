"""Figures and axes: made where none are given, and written in any format."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ahrs_rs import _atomic, _display
from ahrs_rs._optional import require
from ahrs_rs._typing import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

#: A line has at most about so many points.
POINTS = 20_000
#: Colours of x, y, z, and of w before them, of matplotlib's own cycle.
AXES, COLOURS = "xyz", ("C0", "C1", "C2")
GAP, REST, CLIPPED = "0.85", "#cfe8cf", "#c0392b"
#: An axes of a column is so high, and a column so wide, inches.
HEIGHT, WIDTH = 2.3, 9.0


def require_matplotlib() -> None:
    """Raise an ImportError that says what to install, where matplotlib is missing.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.plots.require_matplotlib()
    """
    require("matplotlib", "plot", "plots need")


def one(ax: Any, *, size: tuple[float, float] = (WIDTH, 3.4), projection: str | None = None) -> Axes:
    """The axes that were given, or those of a new figure of pyplot, which a notebook shows by itself."""
    require_matplotlib()
    from matplotlib.axes import Axes

    if ax is None:
        from matplotlib import pyplot

        figure = pyplot.figure(figsize=size, layout="constrained")
        made: Axes = figure.add_subplot(projection=projection)
        return made
    if not isinstance(ax, Axes):
        raise ValueError(f"ax: expected axes of matplotlib, got {type(ax).__name__}")
    return ax


def column(ax: Any, count: int) -> list[Axes]:
    """As many axes as were asked for: those that were given, or a column in a new figure with one time axis."""
    require_matplotlib()
    from matplotlib.axes import Axes

    if ax is None:
        from matplotlib import pyplot

        figure = pyplot.figure(figsize=(WIDTH, HEIGHT * count + 0.5), layout="constrained")
        return list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    given = [ax] if isinstance(ax, Axes) else list(np.ravel(ax)) if isinstance(ax, (list, tuple, np.ndarray)) else []
    if len(given) != count or not all(isinstance(each, Axes) for each in given):
        got = f"{len(given)} axes" if given else type(ax).__name__
        raise ValueError(f"ax: expected {count} axes of matplotlib, got {got}")
    return given


def as_array(axes: Sequence[Axes]) -> NDArray[Any]:
    """(n,) the axes, as matplotlib's own `subplots` gives them."""
    made = np.empty(len(axes), dtype=object)
    made[:] = axes
    return made


def line(ax: Axes, t: FloatArray, y: FloatArray, **style: Any) -> None:
    """A line (T,) over time, thinned to what can be seen, broken at gaps of the clock."""
    t, y = _display.broken(t, y, _display.gaps(t))
    t, y = _display.thinned(t, y, POINTS)
    if np.count_nonzero(~np.isnan(y)) == 1:
        style["marker"] = "o"  # a line of one point is nothing
    ax.plot(t, y, **{"linewidth": 1.0, **style})


def bands(ax: Axes, spans: Sequence[tuple[float, float]], label: str, colour: str) -> None:
    """Bands over the whole height of the axes; one entry in the legend."""
    if not spans:
        return
    ax.broken_barh(
        [(begin, end - begin) for begin, end in spans],
        (0.0, 1.0),
        transform=ax.get_xaxis_transform(),
        facecolor=colour,
        linewidth=0,
        zorder=0,
        label=label,
    )


def gap_bands(ax: Axes, t: FloatArray, missing: NDArray[np.bool_] | None = None) -> None:
    """Where the clock has a gap, or readings (T,) are missing for longer than that would take."""
    bands(ax, _display.gap_spans(t, missing), "gap", GAP)


def finish(ax: Axes, label: str, *, legend: bool = True) -> None:
    """Grid, label of the ordinate, legend beside the lines."""
    ax.set_ylabel(label)
    ax.grid(True, color="0.9", linewidth=0.6)
    ax.margins(x=0.01)
    if legend and ax.get_legend_handles_labels()[0]:
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize="small")


def time_axis(ax: Axes) -> None:
    """The label of the abscissa."""
    ax.set_xlabel("time [s]")


def check_ending(path: str | os.PathLike[str]) -> None:
    """Raise a ValueError where matplotlib has no format for the ending of the name.

    Parameters
    ----------
    path : str or path-like
        Of a picture.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.plots.check_ending("errors.png")
    """
    from matplotlib.backend_bases import FigureCanvasBase

    ending = Path(path).suffix.lower().removeprefix(".")
    known = sorted(FigureCanvasBase.get_supported_filetypes())
    if ending not in known:
        raise ValueError(f"path: expected a name that ends in {', '.join(known)}, got {Path(path).name!r}")


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write the figure in the format that the ending of the name tells; ValueError for another ending.

    Parameters
    ----------
    figure : Figure
        From `draw` or `errors`, or that of axes (``ax.figure``).
    path : str or path-like
        The ending tells the format.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> with TemporaryDirectory() as folder:
    ...     ar.plots.save(ar.plots.errors(rec, {"truth": rec.ref}), Path(folder, "errors.png"))
    ...     Path(folder, "errors.png").exists()
    True
    """
    check_ending(path)
    with _atomic.replacing(path) as beside, warnings.catch_warnings():
        # A letter of a name that the font lacks is drawn as a box.
        warnings.filterwarnings("ignore", r"Glyph .* missing from", UserWarning)
        figure.savefig(beside, dpi=130)
