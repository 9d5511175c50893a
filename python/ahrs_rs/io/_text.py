"""Numbers of text tables, through pyarrow: of the wanted columns, strict about the shape of the rows."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.io._contents import one_line, require
from ahrs_rs.io._preamble import Layout, cells, encoding_of
from ahrs_rs.io._source import Source

#: Spellings of a missing value.
MISSING = (
    "",
    *[
        "NaN",
        "nan",
        "NAN",
        "Nan",
        "-nan",
        "-NaN",
        "NA",
        "N/A",
        "n/a",
        "#N/A",
        "#NA",
        "<NA>",
        "NULL",
        "null",
        "None",
        "none",
        "-",
        "--",
        "1.#QNAN",
        "1.#IND",
        "-1.#IND",
    ],
)
#: Those that nearly all tables have, "nan" being a number: with fewer to look for, a tenth of the time is saved.
USUAL = ("",)
#: Bytes at the beginning and at the end of a file that tell whether it can be read as it is.
PLAIN = 1 << 16
#: Threads do not pay on so few processors.
FEW = 2
#: Rows that are damaged are left out where they are no more than this part of all.
DAMAGED = 0.01


def content_of(source: Source) -> bytes:
    """The text of the source in an encoding with single bytes for separators and digits."""
    content = source.read()
    encoding = encoding_of(content[:65536])
    if encoding.startswith("utf-16"):
        return content.decode(encoding, errors="replace").removeprefix("\ufeff").encode()
    return content.removeprefix(b"\xef\xbb\xbf")


def read_columns(
    source: Source,
    layout: Layout,
    columns: Mapping[int, str],
    *,
    text: Collection[int] = (),
    whole: Collection[int] = (),
    groups: Collection[tuple[int, ...]] = (),
) -> tuple[dict[int, NDArray[Any]], list[str]]:
    """Columns (index -> name for messages) of a text table below its header.

    Parameters
    ----------
    source, layout : what is read, and how it is laid out.
    columns : those that are wanted.
    text : of these, those that are kept as text.
    whole : of these, those that hold integers, which a float64 has no room for (nanoseconds since 1970).
    groups : columns of numbers that are the axes of one reading: they come as the columns of one array.

    Returns
    -------
    arrays : by column index: float64 (NaN: missing), text as an array of bytes, integers as int64, or as float64 where
        one is missing.
    repairs : what was left out.

    Raises
    ------
    ValueError
        No rows, too many rows of another width than the first, or a cell that is no number.
    """
    if max(columns) >= layout.width:
        raise ValueError(f"line {layout.start + 1}: expected at least {max(columns) + 1} cells, got {layout.width}")
    repairs: list[str] = []
    rows: bytes | tuple[Path, int] | None = _plain_rows(source, layout)
    if rows is None:
        rows, repairs = _rows_of(content_of(source), layout)
    separator = "\t" if layout.separator == " " else layout.separator
    reader = _Reader(rows, separator, layout, columns, frozenset(text), frozenset(whole))
    found = reader.read(repairs, groups)
    if not len(next(iter(found.values()))):
        raise ValueError("has a header, but no rows")
    return found, repairs


def _start_of(content: bytes, lines: int) -> int:
    """Where so many lines end; -1 where there are fewer."""
    start = 0
    line_end = re.compile(rb"\r\n|\n|\r")
    for _ in range(lines):
        end = line_end.search(content, start)
        if end is None:
            return -1
        start = end.end()
    return start


def _plain_rows(source: Source, layout: Layout) -> tuple[Path, int] | None:
    """A file on the disk that can be read as it is, and where its rows begin; None where they have to be put right."""
    path = source.on_disk
    if path is None or layout.separator == " ":
        return None
    with path.open("rb") as file:
        head = file.read(PLAIN)
        file.seek(max(file.seek(0, os.SEEK_END) - PLAIN, 0))
        tail = file.read(PLAIN)
    start = _start_of(head, layout.start)
    # A \r at the very end of the head may be half of a line end.
    if encoding_of(head).startswith("utf-16") or not 0 <= start < len(head):
        return None
    rows = tail.rstrip(b"\r\n")
    last = rows[max(rows.rfind(b"\n"), rows.rfind(b"\r")) + 1 :]
    if last != last.rstrip(b" \0") or len(cells(last.decode("latin-1"), layout.separator)) != layout.width:
        return None
    return path, start


def _rows_of(content: bytes, layout: Layout) -> tuple[bytes, list[str]]:
    """The rows without what stands above them, and without a last one that is cut off."""
    start = _start_of(content, layout.start)
    if start < 0:
        return b"", []
    content = content[start:].rstrip(b" \r\n\0")
    repairs = []
    begin = max(content.rfind(b"\n"), content.rfind(b"\r")) + 1
    if begin and len(cells(content[begin:].decode("latin-1"), layout.separator)) < layout.width:
        content = content[:begin]
        repairs.append("last row is cut off: left out")
    if layout.separator == " ":
        # In this order each takes a time that grows as the content does.
        content = re.sub(rb"[ \t]+", b"\t", content)
        content = re.sub(rb"(?m)^\t|\t(?=\r?$)", b"", content)
    return content, repairs


class _Reader:
    """One text of rows."""

    def __init__(
        self,
        rows: bytes | tuple[Path, int],
        separator: str,
        layout: Layout,
        columns: Mapping[int, str],
        text: frozenset[int],
        whole: frozenset[int],
    ) -> None:
        self.rows, self.separator, self.layout, self.columns = rows, separator, layout, columns
        self.text, self.whole = text, whole
        self.damaged = 0

    def read(self, repairs: list[str], groups: Collection[tuple[int, ...]]) -> dict[int, NDArray[Any]]:
        pa = require("pyarrow")
        errors = (pa.ArrowInvalid, pa.ArrowNotImplementedError, pa.ArrowKeyError)
        try:
            try:
                table = self._table(self.text, self.whole, missing=USUAL)
            except errors as error:
                if "conversion error" not in str(error):
                    raise
                table = self._table(self.text, self.whole)
        except errors as error:
            if "conversion error" not in str(error):
                raise ValueError(self._explained(error)) from error
            return self._one_by_one(repairs, errors, error)
        self._count(table.num_rows, repairs)
        rooms: dict[int, FloatArray] = {}
        for group in groups:
            if not self.text.intersection(group) and not self.whole.intersection(group):
                block = np.empty((table.num_rows, len(group)))
                rooms |= {index: block[:, k] for k, index in enumerate(group)}
        return {index: _numpy(table.column(k), rooms.get(index)) for k, index in enumerate(self.columns)}

    def _table(
        self,
        text: frozenset[int],
        whole: frozenset[int],
        *,
        strict: bool = False,
        only: int | None = None,
        missing: Sequence[str] = MISSING,
    ) -> Any:
        """The wanted columns; `strict` stops at the first row of another width, and numbers the rows."""
        pa, pa_csv = require("pyarrow"), require("pyarrow.csv")
        names = [str(index) for index in range(self.layout.width)]
        self.damaged = 0
        types = {
            names[index]: pa.binary() if index in text else pa.int64() if index in whole else pa.float64()
            for index in self.columns
        }
        wanted = [names[index] for index in ([only] if only is not None else self.columns)]
        with self._open() as rows:
            return pa_csv.read_csv(
                rows,
                read_options=pa_csv.ReadOptions(
                    use_threads=not strict and pa.cpu_count() > FEW, column_names=names, block_size=1 << 20
                ),
                parse_options=pa_csv.ParseOptions(
                    delimiter=self.separator,
                    invalid_row_handler=None if strict else self._skip,
                    ignore_empty_lines=True,
                ),
                convert_options=pa_csv.ConvertOptions(
                    include_columns=wanted,
                    column_types=types,
                    null_values=list(missing),
                    strings_can_be_null=False,
                    check_utf8=False,
                    decimal_point=self.layout.decimal,
                ),
            )

    def _open(self) -> Any:
        """The rows for pyarrow: the bytes, or the file from where they begin."""
        pa = require("pyarrow")
        if isinstance(self.rows, bytes):
            return pa.BufferReader(pa.py_buffer(self.rows))
        path, start = self.rows
        file = pa.OSFile(os.fspath(path))
        file.seek(start)
        return file

    def _skip(self, row: Any) -> str:
        self.damaged += 1
        return "skip"

    def _count(self, rows: int, repairs: list[str]) -> None:
        """Damaged rows are told, or an error where they are many."""
        if not self.damaged:
            return
        if self.damaged > DAMAGED * (rows + self.damaged):
            pa = require("pyarrow")
            try:
                self._table(self.text, self.whole, strict=True)
            except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
                raise ValueError(self._explained(error)) from error
        repairs.append(f"{self.damaged} rows with another number of cells than {self.layout.width}: left out")

    def _one_by_one(self, repairs: list[str], errors: Any, first: Exception) -> dict[int, NDArray[Any]]:
        """Each column for itself: integers that are none as floats, and cells that are no numbers as missing ones."""
        found = {}
        for index in self.columns:
            for whole in (self.whole, frozenset[int]()):
                try:
                    table = self._table(self.text, whole, only=index)
                    found[index] = _numpy(table.column(0))
                    break
                except errors as error:
                    if "conversion error" not in str(error):
                        raise ValueError(self._explained(error)) from error
            else:
                found[index] = self._tolerant(index, repairs, errors, first)
        self._count(len(next(iter(found.values()))), repairs)
        return found

    def _tolerant(self, index: int, repairs: list[str], errors: Any, first: Exception) -> FloatArray:
        """The numbers of a column in which some cells are none."""
        cells_of = _numpy(self._table(frozenset({index}), frozenset(), only=index).column(0))
        numbers = np.full(len(cells_of), np.nan)
        bad = []
        missing = {one.encode() for one in MISSING}
        for k, cell in enumerate(cells_of):
            one = bytes(cell).strip().replace(b",", b".") if self.layout.decimal == "," else bytes(cell).strip()
            try:
                numbers[k] = float(one)
            except ValueError:
                if one not in missing:
                    bad.append(k)
                    if len(bad) > DAMAGED * len(cells_of):
                        break
        if len(bad) > DAMAGED * len(cells_of):
            try:
                self._table(self.text, frozenset(), strict=True)
            except errors as error:
                raise ValueError(self._explained(error)) from error
            raise ValueError(self._explained(first))
        name = self.columns[index]
        if bad:
            repairs.append(
                f"column {name!r}: {len(bad)} cells that are no numbers turned into NaN, first in row {bad[0] + 1}"
            )
        return numbers

    def _explained(self, error: Exception) -> str:
        """pyarrow's message with the name of the column in place of its number, and the number of the line."""
        text = one_line(error)
        ragged = re.search(r"Expected (\d+) columns, got (\d+)", text)
        if ragged:
            row = re.search(r"Row #(\d+)", text)
            if row is None:
                pa = require("pyarrow")
                try:
                    self._table(self.text, self.whole, strict=True)
                except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as numbered:
                    row = re.search(r"Row #(\d+)", str(numbered))
            line = f"line {int(row[1]) + self.layout.start}: " if row else ""
            return f"{line}expected {ragged[1]} cells, got {ragged[2]}"
        if "Empty CSV" in text:
            return "has a header, but no rows"
        for index, name in self.columns.items():
            text = text.replace(f"In CSV column #{index}:", f"column {name!r}:")
        row = re.search(r"Row #(\d+)", text)
        if row:
            text = text.replace(row[0], f"line {int(row[1]) + self.layout.start}")
        return f"is not a table of numbers: {text}"


def _numpy(column: Any, room: FloatArray | None = None) -> NDArray[Any]:
    """A column of pyarrow as an array (in the room that is given), without pandas, which pyarrow's own way imports.

    Numbers come from the buffers; missing integers make the column float64.
    """
    chunks = column.chunks
    kind = str(column.type)
    if kind == "binary":
        return np.array([b"" if cell is None else cell for chunk in chunks for cell in chunk.to_pylist()], dtype=object)
    dtype = np.dtype(np.int64 if kind == "int64" else np.float64)
    parts = []
    for chunk in chunks:
        validity, values = chunk.buffers()
        numbers = (
            np.frombuffer(values, dtype=dtype, count=len(chunk) + chunk.offset)[chunk.offset :]
            if len(chunk)
            else np.zeros(0, dtype)
        )
        if chunk.null_count:
            bits = np.unpackbits(np.frombuffer(validity, dtype=np.uint8), bitorder="little")
            valid = bits[chunk.offset : chunk.offset + len(chunk)].view(np.bool_)
            numbers = np.where(valid, numbers, np.nan)
        parts.append(numbers)
    if room is None:
        return np.concatenate(parts) if parts else np.zeros(0, dtype)
    begin = 0
    for part in parts:
        room[begin : begin + len(part)] = part
        begin += len(part)
    return room
