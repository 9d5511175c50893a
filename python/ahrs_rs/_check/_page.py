"""The report as one HTML page."""

from __future__ import annotations

import html
import importlib
import json
from typing import TYPE_CHECKING, Any

from ahrs_rs._check._figures import figures
from ahrs_rs._printable import printable

if TYPE_CHECKING:
    from ahrs_rs._check._report import Report

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 75em; margin: 2em auto; padding: 0 1em; color: #222; }}
table {{ border-collapse: collapse; }}
td, th {{ padding: 0.3em 0.8em; border-bottom: 1px solid #ddd; text-align: left; vertical-align: top; }}
.error {{ color: #a3211a; font-weight: 600; }} .warning {{ color: #a85f00; font-weight: 600; }}
.note {{ color: #33518c; }} .ok {{ color: #06692d; }}
p.more {{ color: #555; margin: 0.2em 0; }}
.plot {{ height: 460px; margin: 1em 0; }}
</style>
<script>{library}</script>
</head>
<body>
<h1>{title}</h1>
<p>{what}</p>
<table>
<tr><th>severity</th><th>code</th><th>finding</th><th>sure</th></tr>
{rows}
</table>
<h2>A filter for it</h2>
<pre>{advice}</pre>
<h2>Evidence</h2>
{plots}
<script type="application/json" id="figures">{figures}</script>
<script>
const figures = JSON.parse(document.getElementById("figures").textContent);
const told = document.documentElement.dataset;
told.plots = figures.length;
told.drawn = 0;
figures.forEach((figure, index) => {{
  const layout = Object.assign({{margin: {{t: 50, r: 20}}, hovermode: "closest"}}, figure.layout);
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
    """The module that has plotly's JavaScript; an ImportError that says what to install, where plotly is missing."""
    try:
        return importlib.import_module("plotly.offline")
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "plotly":
            raise
        raise ImportError("the page needs plotly: pip install ahrs-rs[papers]") from error


def page(report: Report) -> str:
    """The page; ImportError without plotly."""
    library = require_plotly().get_plotlyjs()
    recording = report.recording
    name = printable(recording.meta.get("path", "recording"))
    drawn = figures(report)
    encoded = json.dumps(drawn, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    return PAGE.format(
        title=html.escape(f"Check of {name}"),
        what=html.escape(
            f"{len(recording)} rows, {recording.duration:.6g} s, {recording.rate:.6g} Hz: {report.severity}"
        ),
        rows="\n".join(_row(one) for one in report.findings),
        advice=html.escape(printable_lines(str(report.recommend()))),
        plots="\n".join(f'<div class="plot" id="plot-{number}"></div>' for number in range(len(drawn))),
        figures=encoded,
        library=library,
    )


def printable_lines(text: str) -> str:
    """Each line as every page takes it."""
    return "\n".join(printable(line) for line in text.split("\n"))


def _row(one: Any) -> str:
    more = "".join(
        f'<p class="more">{label}: {html.escape(printable(text))}</p>'
        for label, text in (("means", one.meaning), ("do", one.remedy))
        if text and one.severity != "ok"
    )
    return (
        f'<tr><td class="{one.severity}">{one.severity}</td><td>{html.escape(one.code)}</td>'
        f"<td>{html.escape(printable(one.message))}{more}</td><td>{100.0 * one.confidence:.0f} %</td></tr>"
    )
