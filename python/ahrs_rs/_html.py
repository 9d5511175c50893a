"""Short tables for notebooks: what `_repr_html_` gives."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence

from ahrs_rs._printable import printable

STYLE = "text-align:left;vertical-align:top"


def summary(title: str, rows: Iterable[tuple[str, object]]) -> str:
    """A title and rows of a name and a value, escaped; without scripts or styles of a page."""
    return table(title, (), [[name, value] for name, value in rows])


def table(title: str, head: Sequence[str], rows: Iterable[Sequence[object]], note: str = "") -> str:
    """A table with a title above, escaped."""
    lines = ["<table>", f'<caption style="{STYLE}"><b>{_text(title)}</b></caption>']
    if head:
        lines.append("<tr>" + "".join(f'<th style="{STYLE}">{_text(each)}</th>' for each in head) + "</tr>")
    for row in rows:
        lines.append("<tr>" + "".join(f'<td style="{STYLE}">{_text(each)}</td>' for each in row) + "</tr>")
    lines.append("</table>")
    if note:
        lines.append(f"<p>{_text(note)}</p>")
    return "\n".join(lines)


def number(value: float, unit: str = "") -> str:
    """Five digits and a unit."""
    return f"{value:.5g} {unit}".rstrip()


def _text(value: object) -> str:
    return html.escape(printable(value))
