"""Tables as text for a terminal, for documents and for other programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

from ahrs_rs.papers._study import Study, Table, Verdict


def plain(table: Table) -> str:
    """A table for a terminal.

    Parameters
    ----------
    table : Table
        Of a study.

    Returns
    -------
    str
        Several lines.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> table = ar.papers.Table("Errors", ["filter", "deg"], [["VQF", 1.5]])
    >>> ar.papers.plain(table).splitlines()[-1]
    'VQF     1.50'
    """
    columns, rows = table.shown()
    lines = [table.title, ""]
    widths = [max(map(len, column)) for column in zip(columns, *rows, strict=True)]
    for row in (columns, *rows):
        padded = [_aligned(text, width, i) for i, (text, width) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(padded).rstrip())
    return "\n".join([*lines, *([table.note] if table.note else [])])


def markdown(table: Table) -> str:
    """For documents: without what is of this machine only."""
    columns, rows = table.shown(portable=True)
    rule = ["---:" if right else "---" for right in numeric(columns, rows)]
    lines = ["| " + " | ".join(row) + " |" for row in (columns, rule, *rows)]
    head = [f"**{table.title}**", ""]
    return "\n".join([*head, *lines, *(["", table.note] if table.note else [])])


def comma_separated(table: Table) -> str:
    """With all digits."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(["" if cell is None else cell for cell in row] for row in table.rows)
    return file.getvalue()


def claims(studies: Sequence[Study]) -> Table:
    """All conclusions, and whether they hold.

    Parameters
    ----------
    studies : sequence of Study
        From `study`.

    Returns
    -------
    Table
        A row a claim.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.claims([]).title
    'Claims'
    """
    rows = [
        [study.name, claim.text, _word(claim.simulated), _word(claim.real)]
        for study in studies
        for claim in study.claims
    ]
    return Table("Claims", ["paper", "claim", "simulated", "real"], rows)


def claims_with_numbers(studies: Sequence[Study]) -> Table:
    """The same with the numbers behind."""
    rows = [
        [
            study.name,
            claim.text,
            _word(claim.simulated),
            _numbers(claim.simulated),
            _word(claim.real),
            _numbers(claim.real),
        ]
        for study in studies
        for claim in study.claims
    ]
    return Table("Claims", ["paper", "claim", "simulated", "by", "real", "by (real)"], rows)


def numeric(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[bool]:
    """Which columns hold numbers."""
    return [bool(rows) and all(is_number(row[i]) for row in rows) for i in range(len(columns))]


def is_number(text: str) -> bool:
    """Whether a cell stands at the right: numbers, and what is not known."""
    try:
        float(text)
    except ValueError:
        return text == "–"
    return True


def _aligned(text: str, width: int, column: int) -> str:
    return text.rjust(width) if column and is_number(text) else text.ljust(width)


def _word(verdict: Verdict | None) -> str:
    return "–" if verdict is None else verdict.word


def _numbers(verdict: Verdict | None) -> str:
    return "" if verdict is None else verdict.numbers
