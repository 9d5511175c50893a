"""What a study gives: tables, plots and claims."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs.metrics import Box

Cell: TypeAlias = str | float | None

#: A line of a plot has at most so many points: what a screen can show, and a file that opens quickly.
POINTS = 1500


@dataclass(frozen=True, slots=True)
class Table:
    """Numbers, with the published ones beside ours.

    Parameters
    ----------
    title : str
        Of the table.
    columns : sequence of str
        Their names.
    rows : sequence of sequence of object
        Their cells; None: not known.
    note : str, optional
        What stands below.
    form : str, optional
        How numbers are shown; CSV files have all digits.
    measured : bool, optional
        Whether it holds times, which no two runs have in common.
    local : sequence of str, optional
        Columns that say something of this machine only; tracked documents leave them out.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.Table("Errors", ["filter", "deg"], [["VQF", 1.5]]).shown()
    (['filter', 'deg'], [['VQF', '1.50']])
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""
    form: str = ".2f"
    measured: bool = False
    local: Sequence[str] = ()

    def shown(self, *, portable: bool = False) -> tuple[list[str], list[list[str]]]:
        """Columns and rows as text; `portable` leaves out what is of this machine only.

        Parameters
        ----------
        portable : bool, optional
            Leave out what is of this machine only.

        Returns
        -------
        tuple
            Names of the columns, and the cells of each row.
        """
        kept = [i for i, name in enumerate(self.columns) if not (portable and name in self.local)]
        return [self.columns[i] for i in kept], [[self._text(row[i]) for i in kept] for row in self.rows]

    def _text(self, cell: Cell) -> str:
        if cell is None or (isinstance(cell, float) and math.isnan(cell)):
            return "–"
        if isinstance(cell, str):
            return cell
        return str(cell) if isinstance(cell, int) else f"{cell:{self.form}}"


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a claim holds in one of the two worlds, and the numbers that say so.

    Parameters
    ----------
    holds : bool
        Whether it does.
    numbers : str
        Which say so.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.Verdict(True, "1 < 2").word
    'holds'
    """

    holds: bool
    numbers: str

    @property
    def word(self) -> str:
        """For tables."""
        return "holds" if self.holds else "does not hold"


@dataclass(frozen=True, slots=True)
class Claim:
    """A conclusion of a paper.

    Parameters
    ----------
    text : str
        What the paper says.
    simulated : Verdict, optional
        Whether it holds in the simulation; None: not tried.
    real : Verdict, optional
        The same for real recordings.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> claim = ar.papers.Claim("It holds", ar.papers.Verdict(True, "1 < 2"), None)
    >>> claim.simulated.word
    'holds'
    """

    text: str
    simulated: Verdict | None
    real: Verdict | None


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure as plotly draws it.

    Parameters
    ----------
    title : str
        Of the figure.
    data : sequence of mapping
        Plotly's traces.
    layout : mapping
        Plotly's layout.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.Plot("Errors", [], {}).title
    'Errors'
    """

    title: str
    data: Sequence[Mapping[str, Any]]
    layout: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Study:
    """One paper reproduced.

    Parameters
    ----------
    name : str
        As of its presets.
    title : str
        Authors, title, where it appeared.
    protocol : str
        What was done here, and where that is not what the paper did.
    tables : sequence of Table
        With the published numbers beside ours.
    claims : sequence of Claim
        Of the paper.
    plots : sequence of Plot, optional
        For the report.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.Study("nobody1999", "A title", "A protocol", [], []).name
    'nobody1999'
    """

    name: str
    title: str
    protocol: str
    tables: Sequence[Table]
    claims: Sequence[Claim]
    plots: Sequence[Plot] = field(default_factory=list)


def lines(title: str, x: ArrayLike, curves: Mapping[str, ArrayLike], x_title: str, y_title: str) -> Plot:
    """Curves over one axis, thinned."""
    places = np.asarray(x, dtype=np.float64)
    step = max(1, math.ceil(len(places) / POINTS))
    data = [
        {"type": "scatter", "mode": "lines", "name": name, "x": _plain(places[::step]), "y": _plain(curve, step)}
        for name, curve in curves.items()
    ]
    return Plot(title, data, _axes(x_title, y_title))


def band(plot: Plot, name: str, x: ArrayLike, low: ArrayLike, high: ArrayLike) -> Plot:
    """The plot with the area between two curves."""
    places = np.asarray(x, dtype=np.float64)
    step = max(1, math.ceil(len(places) / POINTS))
    there = _plain(places[::step])
    edges = _plain(high, step) + _plain(low, step)[::-1]
    area: dict[str, Any] = {"type": "scatter", "mode": "lines", "name": name, "x": there + there[::-1], "y": edges}
    area |= {"fill": "toself", "line": {"width": 0}, "opacity": 0.3}
    return Plot(plot.title, [area, *plot.data], plot.layout)


def boxes(title: str, groups: Mapping[str, Box], y_title: str) -> Plot:
    """A box and its whiskers for every group."""
    data: dict[str, Any] = {"type": "box", "name": "", "x": list(groups), "showlegend": False}
    for ours, theirs in (
        ("low", "lowerfence"),
        ("high", "upperfence"),
        ("median", "median"),
        ("q1", "q1"),
        ("q3", "q3"),
    ):
        data[theirs] = _plain([getattr(box, ours) for box in groups.values()])
    return Plot(title, [data], _axes("", y_title))


def radar(title: str, spokes: Sequence[str], series: Mapping[str, Sequence[float]]) -> Plot:
    """A spider chart; each spoke is scaled by its largest value, and one without a value is left out."""
    values = np.array(list(series.values()), dtype=np.float64)
    known = np.flatnonzero(~np.isnan(values).all(axis=0)).tolist()
    largest = np.nanmax(values[:, known], axis=0)
    names = [spokes[i] for i in known]
    data = []
    for name, row in zip(series, values[:, known], strict=True):
        scaled = _plain(row / np.where(largest > 0.0, largest, 1.0))
        closed = {"r": [*scaled, scaled[0]], "theta": [*names, names[0]]}
        data.append({"type": "scatterpolar", "name": name, "fill": "toself", "opacity": 0.6, **closed})
    return Plot(title, data, {"polar": {"radialaxis": {"visible": True, "range": [0, 1]}}})


def _axes(x_title: str, y_title: str) -> dict[str, Any]:
    return {"xaxis": {"title": {"text": x_title}}, "yaxis": {"title": {"text": y_title}}}


def _plain(values: ArrayLike, step: int = 1) -> list[float | None]:
    """Numbers of five digits, None for what is not known: what JSON knows."""
    array = np.asarray(values, dtype=np.float64)[::step]
    return [float(f"{value:.5g}") if math.isfinite(value) else None for value in array.tolist()]
