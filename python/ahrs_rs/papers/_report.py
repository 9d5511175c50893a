"""The report: one HTML file with everything in it, and the tables as CSV files."""

from __future__ import annotations

import html
import json
import platform
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ahrs_rs import _atomic
from ahrs_rs._optional import require
from ahrs_rs._printable import printable
from ahrs_rs._version import __version__
from ahrs_rs.papers._study import Plot, Study, Table
from ahrs_rs.papers._text import claims_with_numbers, comma_separated, is_number, numeric

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Five papers on attitude estimation, reproduced</title>
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 75em; margin: 2em auto; padding: 0 1em; color: #222; }}
table {{ border-collapse: collapse; margin: 0.5em 0 0.3em; }}
td, th {{ padding: 0.2em 0.8em; border-bottom: 1px solid #ddd; text-align: right; vertical-align: top; }}
td.text, th.text {{ text-align: left; }}
caption {{ text-align: left; font-weight: 600; padding-top: 1em; }}
p.note {{ color: #555; max-width: 60em; margin-top: 0; }}
.holds, .refuted {{ white-space: nowrap; }} .holds {{ color: #06692d; }} .refuted {{ color: #a3211a; }}
.plot {{ height: 420px; margin: 1em 0; }}
</style>
<script>
// Before all else: what goes wrong in a script is counted, and shown.
window.addEventListener("error", event => {{
  const told = document.documentElement.dataset;
  told.errors = (told.errors ? told.errors + "; " : "") + event.message;
}});
</script>
<script>{library}</script>
</head>
<body>
<h1>Five papers on attitude estimation, reproduced</h1>
{body}
<script type="application/json" id="figures">{figures}</script>
<script>
const figures = JSON.parse(document.getElementById("figures").textContent);
const told = document.documentElement.dataset;
told.plots = figures.length;
told.drawn = 0;
figures.forEach((figure, index) => {{
  const layout = Object.assign({{margin: {{t: 50, r: 20}}, template: "none", hovermode: "closest"}}, figure.layout);
  layout.title = {{text: figure.title}};
  Plotly.newPlot("plot-" + index, figure.data, layout, {{responsive: true, displaylogo: false}})
    .then(() => {{ told.drawn = Number(told.drawn) + 1; }})
    .catch(error => {{ told.errors = String(error); }});
}});
</script>
</body>
</html>
"""


def require_plotly() -> Any:
    """The module that has plotly's JavaScript; an ImportError that says what to install, where plotly is missing.

    Returns
    -------
    module
        ``plotly.offline``.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.require_plotly().__name__  # doctest: +SKIP
    """
    return require("plotly.offline", "papers", "the report needs")


def write_report(studies: Sequence[Study], directory: Path, seed: int, recordings: Sequence[str]) -> list[Path]:
    """Write report.html and a CSV file for every table into a directory; return their paths.

    Parameters
    ----------
    studies : sequence of Study
        From `study`.
    directory : path-like
        Where to.
    seed : int
        Of the simulations.
    recordings : sequence of str
        Names of the real recordings.

    Returns
    -------
    list of path-like
        What was written; report.html first.

    Raises
    ------
    ImportError
        plotly is not installed.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.write_report([ar.papers.study("cirillo2014")], "report", 0, [])  # doctest: +SKIP
    """
    library = require_plotly().get_plotlyjs()
    figures = [plot for study in studies for plot in study.plots]
    page = PAGE.format(
        library=library,
        body=_body(studies, seed, recordings),
        # A "<" could end the script element, or begin a comment in it.
        figures=json.dumps([_figure(plot) for plot in figures]).replace("<", "\\u003c"),
    )
    texts = {"report.html": page} | {name: comma_separated(table) for name, table in _files(studies).items()}
    with _atomic.Together() as files:
        files.folder(directory)
        for name, text in texts.items():
            files.write_text(directory / name, text)
    return [directory / name for name in texts]


def environment(seed: int, recordings: Sequence[str]) -> dict[str, str]:
    """What the numbers were made with."""
    return {
        "ahrs_rs": __version__,
        "Python": platform.python_version(),
        "numpy": np.__version__,
        "machine": f"{platform.system()} {platform.machine()}",
        "seed": str(seed),
        "recordings": f"{len(recordings)}: {', '.join(map(printable, recordings))}"
        if recordings
        else "none (AHRS_RS_DATA is not set)",
    }


def _files(studies: Sequence[Study]) -> Mapping[str, Table]:
    files = {
        f"{study.name}_{number}.csv": table for study in studies for number, table in enumerate(study.tables, start=1)
    }
    return files | {"claims.csv": claims_with_numbers(studies)}


def _figure(plot: Plot) -> dict[str, object]:
    return {"title": plot.title, "data": list(plot.data), "layout": dict(plot.layout)}


def _body(studies: Sequence[Study], seed: int, recordings: Sequence[str]) -> str:
    made = [[name, text] for name, text in environment(seed, recordings).items()]
    parts = [
        "<p>Ours beside the published numbers. Drag over a plot to zoom, double-click to see all of it.</p>",
        _table(claims_with_numbers(studies)),
        _table(Table("Environment", ["what", "which"], made)),
    ]
    number = 0
    for study in studies:
        parts.append(f'<h2 id="{study.name}">{html.escape(study.name)}</h2>')
        parts.append(f"<p><em>{html.escape(study.title)}</em></p>")
        parts += [f"<p>{html.escape(text)}</p>" for text in study.protocol.split("\n\n")]
        parts += [_table(table) for table in study.tables]
        for _ in study.plots:
            parts.append(f'<div class="plot" id="plot-{number}"></div>')
            number += 1
    return "\n".join(parts)


def _table(table: Table) -> str:
    columns, rows = table.shown()
    title = html.escape(table.title) + (" (measured)" if table.measured else "")
    pairs = zip(columns, numeric(columns, rows), strict=True)
    head = "".join(f'<th class="{"" if right else "text"}">{html.escape(name)}</th>' for name, right in pairs)
    lines = ["<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows]
    note = f'<p class="note">{html.escape(table.note)}</p>' if table.note else ""
    return f"<table><caption>{title}</caption><tr>{head}</tr>\n" + "\n".join(lines) + f"</table>{note}"


def _cell(text: str) -> str:
    kind = {"holds": "text holds", "does not hold": "text refuted"}.get(text, "" if is_number(text) else "text")
    return f'<td class="{kind}">{html.escape(text)}</td>'
