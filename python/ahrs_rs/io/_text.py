"""Text tables through pyarrow: numbers of the wanted columns, strict about the shape of every row."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from typing import Any

from ._contents import one_line, require
from ._source import Source

#: Spellings of a missing value, beside the usual ones of pyarrow (empty, NaN, NA, null, n/a, ...).
MISSING = ("None", "none", "NAN", "Nan", "-", "--")

#: How much of a file may precede the first row of data.
HEAD_BYTES = 65536


def is_text(head: bytes) -> bool:
    """Whether a file with these first bytes can be a text table in an ASCII-like encoding."""
    return bool(head.strip()) and b"\0" not in head


def head_lines(source: Source) -> list[str]:
    """The first lines of the file, empty ones included; Latin-1 where it is not UTF-8."""
    head = source.read(size=HEAD_BYTES)
    if len(head) == HEAD_BYTES:
        head = head[: head.rfind(b"\n") + 1]
    try:
        text = head.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = head.decode("latin-1")
    return re.split("\r\n|\n|\r", text)


def cells(line: str, separator: str) -> list[str]:
    """The cells of one line, stripped."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    except csv.Error as error:
        raise ValueError(f"is not a text table: {error}") from error


def table_width(header: list[str], first_row: list[str]) -> int:
    """Cells in a row, where header and rows may differ by separators at the end of the line."""
    short, long = sorted((header, first_row), key=len)
    return len(first_row) if not any(long[len(short) :]) else len(header)


def read_columns(
    source: Source,
    separator: str,
    skip_lines: int,
    width: int,
    columns: Mapping[int, str],
    plain: frozenset[int] = frozenset(),
) -> tuple[dict[int, Any], list[str]]:
    """Numbers of the columns (index -> name for messages) of a text table below its header.

    Columns in `plain` keep the type that pyarrow finds; all others must be numbers. A last row that is cut
    off is left out.

    Returns
    -------
    The arrays by column index (NaN: missing), and what was repaired.

    Raises
    ------
    ValueError
        No rows, a row of another width than the header's, or a cell that is no number.
    """
    pa, pa_csv = require("pyarrow"), require("pyarrow.csv")
    if max(columns) >= width:
        raise ValueError(f"line {skip_lines + 1}: expected at least {max(columns) + 1} cells, got {width}")
    content = source.read().rstrip(b" \r\n")
    repairs = []
    start = max(content.rfind(b"\n"), content.rfind(b"\r")) + 1
    if len(cells(content[start:].decode("latin-1"), separator)) < width:
        content = content[:start]
        repairs.append("last row is cut off: left out")
    names = [str(index) for index in range(width)]
    missing = [*pa_csv.ConvertOptions().null_values, *MISSING]
    try:
        table = pa_csv.read_csv(
            pa.BufferReader(content),
            read_options=pa_csv.ReadOptions(use_threads=False, skip_rows=skip_lines, column_names=names),
            parse_options=pa_csv.ParseOptions(delimiter=separator),
            convert_options=pa_csv.ConvertOptions(
                include_columns=[names[index] for index in columns],
                column_types={names[index]: pa.float64() for index in columns if index not in plain},
                null_values=missing,
                check_utf8=False,
            ),
        )
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError, pa.ArrowKeyError) as error:
        raise ValueError(_explain(error, columns)) from error
    if not table.num_rows:
        raise ValueError("has a header, but no rows")
    return {index: table[names[index]].to_numpy() for index in columns}, repairs


def _explain(error: Exception, columns: Mapping[int, str]) -> str:
    """pyarrow's message with the name of the column in place of its number."""
    text = one_line(error)
    ragged = re.search(r"Row #(\d+): Expected (\d+) columns, got (\d+)", text)
    if ragged:
        return "line {}: expected {} cells, got {}".format(*ragged.groups())
    if "skip initial" in text or "Empty CSV" in text:
        return "has a header, but no rows"
    for index, name in columns.items():
        text = text.replace(f"In CSV column #{index}:", f"column {name!r}:")
    return f"is not a table of numbers: {text}"
