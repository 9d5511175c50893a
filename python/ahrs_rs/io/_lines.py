"""Text files of devices: lines before a table, its header, and its numbers by the columns' names."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import one_line, require

#: How many bytes of a file may precede its first row.
HEAD_BYTES = 65536
SEPARATORS = (",", "\t", ";")
#: Spellings of a missing value, beside those of pyarrow (empty, NaN, NA, null, n/a, ...).
MISSING = ("None", "none", "NAN", "Nan", "-", "--", "inf", "-inf", "Inf", "-Inf", "Infinity", "-Infinity")
#: Cells that are no numbers are taken for missing up to this part of a column; more is another kind of file.
UNREADABLE = 0.01


def utf8(content: bytes) -> bytes:
    """UTF-8 without a byte-order mark, of UTF-8 (with bytes of Latin-1 in it) or UTF-16."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace").encode()
    content = content.removeprefix(b"\xef\xbb\xbf")
    return content if content.isascii() else content.decode("utf-8", errors=_LATIN_1).encode()


_LATIN_1 = "ahrs_rs.latin_1"


def _as_latin_1(error: UnicodeError) -> tuple[str, int]:
    """A byte that is no UTF-8 is taken for Latin-1."""
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("latin-1"), error.end


codecs.register_error(_LATIN_1, _as_latin_1)


def head_lines(content: bytes) -> list[str]:
    """The first lines of a file, the last of them perhaps not whole; Latin-1 where it is not UTF-8."""
    head = content[:HEAD_BYTES]
    if len(content) > HEAD_BYTES:  # a character may be cut in two
        head = head[: max(head.rfind(b"\n") + 1, 0) or HEAD_BYTES]
    return re.split("\r\n|\n|\r", utf8(head).decode())


def is_text(head: bytes) -> bool:
    """Whether a file with these first bytes can be text."""
    return bool(head.strip()) and (b"\0" not in head or head.startswith((b"\xff\xfe", b"\xfe\xff")))


def cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without blanks and quotation marks around them; a blank separates as any number of them."""
    if separator == " ":
        return line.split()
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    except csv.Error:  # a quotation mark that is not closed, a cell of 131,072 characters
        return [cell.strip().strip('"') for cell in line.split(separator)]


def separator_of(line: str) -> str:
    """The separator of a header line, a blank where none of the usual ones is in it."""
    best = max(SEPARATORS, key=line.count)
    return best if best in line else " "


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with a point or a comma."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


@dataclass(slots=True)
class Table:
    """Columns of numbers, and what was repaired to get them."""

    columns: dict[int, NDArray[Any]]
    repairs: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values())))

    def vectors(self, indices: Sequence[int]) -> FloatArray:
        """(n, k) float64 of k columns."""
        return np.column_stack([np.asarray(self.columns[index], dtype=np.float64) for index in indices])


def read_table(
    content: bytes,
    skip: int,
    names: Sequence[str],
    wanted: Iterable[int],
    separator: str,
    *,
    decimal: str = ".",
    exact: Iterable[int] = (),
) -> Table:
    """The numbers of some columns below the first `skip` lines.

    Lines with another number of cells are left out, cells that are no numbers become NaN; both are told. Columns in
    `exact` are int64 where all their cells are integers.

    Raises
    ------
    ValueError
        No rows, too few cells for the columns, or too many cells that are no numbers.
    """
    pa, pa_csv = require("pyarrow"), require("pyarrow.csv")
    content = utf8(content)
    if separator == " ":
        content, separator = re.sub(rb"(?m)^[ \t]+|[ \t]+(?=\r?$)", b"", content), " "
        content = re.sub(rb"[ \t]+", b" ", content)
    first, rows = _first_row(content, skip)
    width = _width(names, cells(first, separator))
    wanted = sorted(set(wanted))
    if wanted[-1] >= width:
        raise ValueError(f"line {skip + 1}: expected at least {wanted[-1] + 1} cells, got {width}")
    skipped: list[tuple[int, int]] = []

    def ragged(row: Any) -> str:
        skipped.append((row.number or 0, row.actual_columns))
        return "skip"

    labels = [str(index) for index in range(width)]
    try:
        table = pa_csv.read_csv(
            pa.BufferReader(rows),
            read_options=pa_csv.ReadOptions(use_threads=False, column_names=labels),
            parse_options=pa_csv.ParseOptions(delimiter=separator, invalid_row_handler=ragged),
            convert_options=pa_csv.ConvertOptions(
                include_columns=[labels[index] for index in wanted],
                column_types={labels[index]: pa.string() for index in wanted},
                strings_can_be_null=False,
            ),
        )
    except (pa.ArrowException, OverflowError) as error:
        raise ValueError(f"is not a table of numbers: {one_line(error)}") from error
    if not table.num_rows:
        raise ValueError("has a header, but no rows")
    result = Table({})
    if not content.endswith((b"\n", b"\r")):
        result.repairs.append("the file ends within a line, so that it may be cut off and its last number too short")
    if skipped:
        number, count = skipped[0]
        at_end = len(skipped) == 1 and number in (0, table.num_rows + 1) and count < width
        where = "the last one, which is cut off" if at_end else f"first line {skip + number}, {count} cells"
        result.repairs.append(
            f"{len(skipped)} of {table.num_rows + len(skipped)} lines left out ({where}; expected {width})"
        )
    for index in wanted:
        column = table[labels[index]].combine_chunks()
        result.columns[index] = _numbers(pa, column, names[index], decimal, index in set(exact), result.repairs)
    return result


def _first_row(content: bytes, skip: int) -> tuple[str, bytes]:
    """The first line that is not empty below `skip` lines, and all from there on, without blanks at the end."""
    start = 0
    for _ in range(skip):
        ends = [content.find(mark, start) for mark in (b"\n", b"\r")]
        found = min((end for end in ends if end >= 0), default=-1)
        if found < 0:
            raise ValueError("has a header, but no rows")
        start = found + (2 if content[found : found + 2] == b"\r\n" else 1)
    rows = content[start:].rstrip(b" \r\n").lstrip(b"\r\n")
    if not rows.strip():
        raise ValueError("has a header, but no rows")
    return re.split("\r\n|\n|\r", rows[:HEAD_BYTES].decode("latin-1"), maxsplit=1)[0], rows


def _width(names: Sequence[str], first: Sequence[str]) -> int:
    """Cells in a row, where header and rows may differ by separators at the end of the line."""
    short, long = sorted((names, first), key=len)
    return len(first) if not any(long[len(short) :]) else len(names)


def _numbers(pa: Any, column: Any, name: str, decimal: str, exact: bool, repairs: list[str]) -> NDArray[Any]:
    compute = require("pyarrow.compute")
    text = compute.ascii_trim_whitespace(column)
    if decimal != ".":
        text = compute.replace_substring(text, decimal, ".")
    missing = pa.array([*require("pyarrow.csv").ConvertOptions().null_values, *MISSING])
    text = compute.if_else(compute.is_in(text, value_set=missing), pa.scalar(None, pa.string()), text)
    if exact and not text.null_count:
        try:
            return np.asarray(text.cast(pa.int64()).to_numpy(zero_copy_only=False))
        except pa.ArrowInvalid:
            pass
    try:
        return np.asarray(text.cast(pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)
    except pa.ArrowInvalid:
        return _slowly(text.to_pylist(), name, repairs)


def _slowly(found: list[str | None], name: str, repairs: list[str]) -> FloatArray:
    """Cell by cell, where some are no numbers."""
    out = np.full(len(found), np.nan)
    bad: list[int] = []
    for index, cell in enumerate(found):
        try:
            out[index] = float(cell) if cell is not None else np.nan
        except ValueError:
            bad.append(index)
    if len(bad) > max(UNREADABLE * len(found), 1):
        first = f"first {found[bad[0]]!r:.40} in row {bad[0] + 1}"
        raise ValueError(f"column {name!r}: {len(bad)} of {len(found)} cells are no numbers, {first}")
    if bad:
        first = f"first in row {bad[0] + 1}"
        repairs.append(f"column {name!r}: {len(bad)} cells that are no numbers taken for missing, {first}")
    return out


@dataclass(slots=True)
class NamedTable:
    """A table whose first line that is not empty names the columns; they are found by these names."""

    names: list[str]
    columns: dict[str, NDArray[Any]]
    repairs: list[str]

    def vectors(self, names: Sequence[str]) -> FloatArray:
        """(n, k) float64 of k columns; (n,) of one."""
        rows = np.column_stack([np.asarray(self.columns[name], dtype=np.float64) for name in names])
        return rows[:, 0] if len(names) == 1 else rows


def header_of(head: bytes) -> list[str]:
    """The names in the first line that is not empty, without the mark of a comment."""
    line = next((line for line in head_lines(head) if line.strip()), "")
    names = cells(line, separator_of(line))
    return [name.lstrip("# ") if index == 0 else name for index, name in enumerate(names)]


def read_named(content: bytes, *, exact: Iterable[str] = (), wanted: Iterable[str] | None = None) -> NamedTable:
    """A table of numbers with its header in the first line that is not empty; the decimal sign is found.

    `wanted` are the columns to read where they are there (None: all), `exact` those of integers.
    """
    lines = head_lines(content)
    row = next((index for index, line in enumerate(lines) if line.strip()), None)
    if row is None:
        raise ValueError("has no header line")
    separator = separator_of(lines[row])
    names = header_of(content)
    chosen = [index for index, name in enumerate(names) if name and (wanted is None or name in set(wanted))]
    if not chosen:
        raise ValueError(f"has no column of {', '.join(wanted or ())}, only {', '.join(names)}"[:300])
    first = next((line for line in lines[row + 1 :] if line.strip()), "")
    decimal = "," if separator != "," and "," in first and "." not in first else "."
    integers = [names.index(name) for name in exact if name in names]
    table = read_table(content, row + 1, names, chosen, separator, decimal=decimal, exact=integers)
    return NamedTable(names, {names[index]: table.columns[index] for index in chosen}, table.repairs)
