"""The head of a text table: encoding, separator and decimal sign, where the names stand, where the rows begin."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from ahrs_rs.io._contents import Options
from ahrs_rs.io._source import Source
from ahrs_rs.io._units import UNITS, unit_key

#: How much of a file is looked at for the first row of data; the second where the first holds none.
HEAD_BYTES, LONG_HEAD_BYTES = 2**16, 2**22
#: A cell that is longer is no name of a column.
LONGEST_NAME = 200
#: Columns of a table.
MOST_COLUMNS = 100_000
#: Separators in the order in which they are tried; " " stands for any run of blanks.
SEPARATORS = (",", ";", "\t", "|", " ")
#: Lines from which separator and width are found.
SAMPLE = 40

_NUMBER = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?")
_MOMENT = re.compile(
    r"(?:\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}[T _]?)?(?:\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d*)?)?)?(?:Z|UTC|[+-]\d{2}:?\d{2})?"
)
_MISSING = frozenset({"nan", "na", "n/a", "null", "none", "-", "--", "inf", "-inf", "+inf", "-nan", "true", "false"})
_LABELS = frozenset(["x", "y", "z", "w", "0", "1", "2", "3", "roll", "pitch", "yaw", "q0", "q1", "q2", "q3"])
_KNOWN_UNITS = frozenset(unit for units in UNITS.values() for unit in units)
_COMMENT = "#%/! \t"


@dataclass(slots=True)
class Layout:
    """How a text table is laid out."""

    separator: str
    decimal: str
    headers: list[str] = field(default_factory=list)
    """Names of the columns; empty where there are none."""
    units: list[str] = field(default_factory=list)
    """Units of a line of their own; empty where there is none."""
    start: int = 0
    """Lines before the first row."""
    width: int = 0
    """Cells of a row."""
    preamble: list[str] = field(default_factory=list)
    """The lines above the names."""
    rows: list[list[str]] = field(default_factory=list)
    """Some of the first rows."""


def encoding_of(head: bytes) -> str:
    """The encoding that the first bytes of a text show."""
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if head.startswith(b"\xef\xbb\xbf"):
        return "utf-8-sig"
    some = head[:512]
    if len(some) > 8 and some[1::2].count(0) > 0.4 * len(some) / 2 and some[::2].count(0) == 0:
        return "utf-16-le"
    if len(some) > 8 and some[::2].count(0) > 0.4 * len(some) / 2 and some[1::2].count(0) == 0:
        return "utf-16-be"
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        if error.start < len(head) - 4:  # else a character that is cut off
            return "latin-1"
    return "utf-8"


def is_text(head: bytes) -> bool:
    """Whether a file with these first bytes can be a text table."""
    if encoding_of(head).startswith("utf-16"):
        return True
    return bool(head.strip()) and b"\0" not in head


def head_lines(source: Source, size: int = HEAD_BYTES) -> list[str]:
    """The first lines of the source, empty ones included; Latin-1 where it is not UTF-8."""
    head = source.read(size=size)
    text = head.decode(encoding_of(head), errors="replace").removeprefix("\ufeff")
    lines = re.split("\r\n|\n|\r", text)
    return lines[:-1] if len(head) == size and len(lines) > 1 else lines


def cells(line: str, separator: str) -> list[str]:
    """The cells of one line, stripped."""
    if separator == " ":
        return line.split()
    if '"' not in line:  # of any length, where csv takes a cell of 131072 characters for an error
        return [cell.strip() for cell in line.split(separator)] if line else []
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    except csv.Error as error:
        raise ValueError(f"is not a text table: {error}") from error


def layout_of(lines: Sequence[str], options: Options) -> Layout:
    """How a text table with these first lines is laid out.

    Raises
    ------
    ValueError
        No header line, or a separator or decimal sign that is none.
    """
    lines = list(lines)
    stated = _separator_line(lines)
    separator = _option("separator", options.separator) or stated or _found_separator(lines)
    decimal = options.decimal if options.decimal is not None else None
    if decimal is not None and decimal not in (".", ","):
        raise ValueError(f"decimal: expected '.' or ',', got {decimal!r}")
    if decimal == "," and separator == ",":
        raise ValueError("decimal: expected '.', as the separator is ','")
    made = Layout(separator, decimal or _found_decimal(lines, separator))
    if options.skip_rows is not None:
        _placed(made, lines, options.skip_rows, isinstance(options.columns, (list, tuple)))
    else:
        _found_header(made, lines)
    if isinstance(options.columns, (list, tuple)):
        _named_by(made, lines, options.columns)
    if not made.headers:
        raise ValueError(
            f"has no header line: name its {made.width} columns by columns=[...] (--columns NAME,NAME,...), '' for "
            "those that are not wanted"
        )
    if len(made.headers) > MOST_COLUMNS:
        raise ValueError(f"has {len(made.headers)} columns, and no more than {MOST_COLUMNS} are looked at")
    made.headers[0] = made.headers[0].lstrip(_COMMENT)  # numpy.savetxt marks its header as a comment
    made.headers, made.units = ([_name(cell) for cell in row] for row in (made.headers, made.units))
    return made


def _name(cell: str) -> str:
    """A cell of the head, cut where it is longer than any name."""
    return cell if len(cell) <= LONGEST_NAME else f"{cell[:LONGEST_NAME]}…"


def _option(name: str, value: str | None) -> str | None:
    if value is None:
        return None
    value = {"\\t": "\t", "tab": "\t", "blank": " ", "space": " ", "blanks": " "}.get(value.lower(), value)
    if len(value) != 1 or value in '\r\n"':
        raise ValueError(f"{name}: expected one character (or 'tab', 'blanks'), got {value!r}")
    return value


def _separator_line(lines: list[str]) -> str | None:
    """The separator that a first line like ``sep=,`` states; the line is blanked."""
    for i, line in enumerate(lines[:3]):
        if line.strip():
            match = re.match(r"\"?sep=(.)\"?", line.strip("\ufeff"), flags=re.IGNORECASE)
            if match is not None and not line[match.end() :].strip(f"{match[1]} \t"):
                lines[i] = ""
                return match[1]
            return None
    return None


def _found_separator(lines: Sequence[str]) -> str:
    """The separator by which the last lines have the same number of cells, and most of them numbers."""
    filled = [line for line in lines if line.strip()]
    sample = filled[-min(SAMPLE, max(2, len(filled) // 2)) :]
    best, chosen = (0.0, 0.0, 0), ","
    for separator in SEPARATORS:
        split = [cells(line, separator) for line in sample]
        widths = [len(row) for row in split]
        width = max(set(widths), key=lambda one: (widths.count(one), one), default=0)
        if width < 2:
            continue
        alike = [row for row in split if abs(len(row) - width) <= 1]
        flat = [cell for row in alike for cell in row if cell]
        numbers = sum(map(is_value, flat)) / max(len(flat), 1)
        score = (round(numbers, 1), round(len(alike) / len(split), 1), width)
        if score > best:
            best, chosen = score, separator
    return chosen


def _found_decimal(lines: Sequence[str], separator: str) -> str:
    if separator == ",":
        return "."
    text = separator.join([line for line in lines if line.strip()][-SAMPLE:])
    split = [
        cell
        for cell in cells(text.replace("\t", separator if separator == " " else "\t"), separator)
        if _NUMBER.fullmatch(cell)
    ]
    return "," if any("," in cell for cell in split) and not any("." in cell for cell in split) else "."


def is_number(cell: str) -> bool:
    """Whether a cell is a number, or a word for a missing one."""
    return bool(_NUMBER.fullmatch(cell)) or cell.lower() in _MISSING


def is_value(cell: str) -> bool:
    """Whether a cell is a number, a time, or a word for a missing value."""
    return is_number(cell) or (cell[:1].isdigit() and bool(_MOMENT.fullmatch(cell)))


def _is_row(row: Sequence[str], width: int) -> bool:
    filled = [cell for cell in row if cell]
    return abs(len(row) - width) <= 1 and bool(filled) and 2 * sum(map(is_value, filled)) >= len(filled)


def _found_header(made: Layout, lines: Sequence[str]) -> None:
    """Finds the first row and the names above it."""
    filled = [(i, line) for i, line in enumerate(lines) if line.strip()]
    if not filled:
        raise ValueError("has no header line")
    split: list[tuple[int, list[str]]] = []

    def until(count: int) -> list[tuple[int, list[str]]]:
        """The first lines as cells: no more of them are split than are looked at."""
        split.extend((i, cells(line, made.separator)) for i, line in filled[len(split) : count])
        return split

    last = [len(cells(line, made.separator)) for _, line in filled[-min(SAMPLE, max(2, len(filled) // 2)) :]]
    width = max(set(last), key=lambda one: (last.count(one), one))
    first = None
    for k in range(len(filled)):
        near = [_is_row(other, width) for _, other in until(k + 4)[k : k + 4]]
        if near[0] and 2 * sum(near) >= len(near):
            first = k
            break
    if first is None:  # names alone
        made.headers, made.width, made.start = split[-1][1], len(split[-1][1]), split[-1][0] + 1
        return
    made.start = split[first][0]
    made.rows = [row for _, row in until(first + SAMPLE)[first : first + SAMPLE]]
    made.width = len(made.rows[0])
    above = split[:first]
    if above:
        made.width = width if len(above[-1][1]) == width else made.width
        _take_names(made, lines, above)


def _take_names(made: Layout, lines: Sequence[str], above: list[tuple[int, list[str]]]) -> None:
    """The names, with the units or the groups of other lines, from the lines above the first row."""
    index, names = above[-1]
    names = _uncommented(names, lines[index], made.separator)
    if len(above) > 1 and _are_units(names) and _fits(above[-2][1], made.width):
        made.units, above = names, above[:-1]
        index, names = above[-1]
        names = _uncommented(names, lines[index], made.separator)
    if not _fits(names, made.width):
        return
    if len(above) > 1 and _are_labels(names) and _fits(above[-2][1], made.width):
        names = _joined(above[-2][1], names)
        above = above[:-1]
    made.headers = names
    made.width = table_width(names, next((row for row in made.rows if len(row) == made.width), made.rows[0]))
    made.preamble = [lines[i] for i, _ in above[:-1]]


def _uncommented(names: list[str], line: str, separator: str) -> list[str]:
    bare = line.lstrip(_COMMENT)
    return cells(bare, separator) if bare != line else names


def _fits(row: Sequence[str], width: int) -> bool:
    """Whether a line above the rows may name their columns: as many cells, but for separators at the end."""
    filled = len([*row]) - next((k for k, cell in enumerate(reversed(row)) if cell), len(row))
    return (filled <= width and len(row) >= width - 1) or len(row) == width or (len(row) > width and filled <= width)


def _are_units(names: Sequence[str]) -> bool:
    filled = [name for name in names if name]
    if not filled:
        return False
    units = [name for name in filled if unit_key(name) in _KNOWN_UNITS or re.fullmatch(r"[\[(].*[\])]", name)]
    return len(units) >= 0.7 * len(filled) and not any(
        re.fullmatch(r"(?i)[a-z]*[gam][xyz]|time.*", name) for name in filled
    )


def _are_labels(names: Sequence[str]) -> bool:
    filled = [name.lower() for name in names if name]
    return bool(filled) and sum(name.partition(" ")[0] in _LABELS for name in filled) >= 0.6 * len(filled)


def _joined(groups: Sequence[str], labels: Sequence[str]) -> list[str]:
    """Names of two lines: a group stands above the first of its labels."""
    found, group = [], ""
    for k in range(max(len(groups), len(labels))):
        own = groups[k].lstrip(_COMMENT) if k < len(groups) else ""
        label = labels[k] if k < len(labels) else ""
        group = own or group
        found.append(f"{group} {label}".strip() if label else own)
    return found


def _placed(made: Layout, lines: Sequence[str], skip: int, named: bool) -> None:
    """The header stands below so many lines, as the user says."""
    if isinstance(skip, bool) or not isinstance(skip, int) or not skip >= 0:
        raise ValueError(f"skip_rows: expected a number of lines, got {skip!r}")
    if skip >= len(lines):
        raise ValueError(f"skip_rows: expected less than the {len(lines)} lines of the file's head, got {skip}")
    rest = [(i, cells(line, made.separator)) for i, line in enumerate(lines) if i >= skip and line.strip()]
    if not rest:
        raise ValueError("has a header, but no rows")
    if named:
        made.start, made.rows = rest[0][0], [row for _, row in rest[:SAMPLE]]
        made.width = len(made.rows[0])
        return
    made.headers = _uncommented(rest[0][1], lines[rest[0][0]], made.separator)
    body = rest[1:]
    if body and not _is_row(body[0][1], len(body[0][1])) and _are_units(body[0][1]):
        made.units, body = body[0][1], body[1:]
    if body:
        made.start, made.rows = body[0][0], [row for _, row in body[:SAMPLE]]
        made.width = table_width(made.headers, made.rows[0])
    made.preamble = list(lines[:skip])


def _named_by(made: Layout, lines: Sequence[str], names: Sequence[str]) -> None:
    """The names that the user gives, for a table without a header."""
    if made.headers:
        raise ValueError(
            f"columns: expected a mapping, as the table has a header ({', '.join(map(repr, made.headers[:6]))}); "
            "a list names the columns of a table without one (skip_rows= leaves a header out)"
        )
    if made.rows and len(names) != made.width:
        trailing = len(names) == made.width - 1 and not any(row[-1] for row in made.rows if len(row) == made.width)
        if not trailing:
            raise ValueError(f"columns: expected {made.width} names, one a column, got {len(names)}")
    made.headers = [str(name) for name in names]


def table_width(header: Sequence[str], first_row: Sequence[str]) -> int:
    """Cells in a row, where header and rows may differ by separators at the end of the line."""
    short, long = sorted((header, first_row), key=len)
    return len(first_row) if not any(long[len(short) :]) else len(header)
