"""Text tables with heads of any length and content: read or told, in a time that grows as they do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar

HEAD = b"t,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z"
ROWS = 40
#: Characters of a run: if the time grew as its square, a test would take minutes.
LENGTH = 60_000

pytestmark = pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")


def table(
    path: Path, head: bytes, *, cells: int = 7, end: bytes = b"\n", above: bytes = b"", amid: bytes = b""
) -> Path:
    """A table of so many cells a row, with lines above the head, and amid the rows."""
    rows = [
        b",".join([b"%.2f" % (k / 100), b"0.1", b"0.2", b"0.3", b"0", b"0", b"9.81", *[b"0"] * (cells - 7)]) + end
        for k in range(ROWS)
    ]
    path.write_bytes(above + head + end + b"".join(rows[:9]) + amid + b"".join(rows[9:]))
    return path


def is_read(path: Path) -> bool:
    recording = ar.read(path)
    gyr = recording.gyr
    return len(recording) == ROWS and gyr is not None and np.array_equal(gyr[0], [0.1, 0.2, 0.3])


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"], ids=repr)
@pytest.mark.parametrize("above", [b"", b"# a log\n"], ids=["bare", "preamble"])
def test_every_line_end_is_one(end: bytes, above: bytes, tmp_path: Path) -> None:
    assert is_read(table(tmp_path / "a.csv", HEAD, end=end, above=above.replace(b"\n", end)))


@pytest.mark.parametrize(
    "run", [b" ", b".", b"(", b")", b"[", b"_", b"-", b"1", b"a", b"A", b"\t", b"/", b"aB", b"(a)", b"x ", b"'"]
)
@pytest.mark.parametrize("before", [b"gyr_x", b"gyr_x (", b"acc_z [m/s2]", b"sep=", b""])
@pytest.mark.parametrize("after", [b"x", b")", b""])
def test_a_cell_of_any_length_is_read_or_told(run: bytes, before: bytes, after: bytes, tmp_path: Path) -> None:
    cell = before + run * (LENGTH // len(run)) + after
    for path in (
        table(tmp_path / "beside.csv", HEAD + b"," + cell, cells=8),
        table(tmp_path / "instead.csv", HEAD.replace(b"gyr_x", cell)),
        table(tmp_path / "above.csv", HEAD, above=cell + b"\n"),
    ):
        try:
            recording = ar.read(path)
        except ValueError as error:
            told = str(error)
            assert "\n" not in told
            assert len(told) < 1000
        else:
            assert len(recording) == ROWS


@pytest.mark.parametrize("run", [b" ", b"\t", b"0", b".", b"-", b"1:"], ids=repr)
@pytest.mark.parametrize("separator", [b",", b" "], ids=["comma", "blanks"])
def test_a_row_of_any_length_is_left_out(run: bytes, separator: bytes, tmp_path: Path) -> None:
    # One of 400 rows: fewer than one in a hundred are damaged.
    rows = b"".join(b"%.2f,0.1,0.2,0.3,0,0,9.81\n" % (k / 100) for k in range(400))
    text = HEAD + b"\n" + rows[:2000] + rows[2000 : rows.index(b"\n", 2000) + 1] + b"1.9,5" + run * LENGTH + b"x\n"
    text += rows[rows.index(b"\n", 2000) + 1 :]
    (tmp_path / "a.csv").write_bytes(text.replace(b",", separator))
    recording = ar.read(tmp_path / "a.csv")
    assert 399 <= len(recording) <= 401


def test_a_cell_of_blanks_is_missing(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", HEAD, amid=b"0.09,1,0,0,0,0," + b" " * LENGTH + b"\n")
    acc = ar.read(path).acc
    assert acc is not None
    assert np.isnan(acc[9, 2])


@pytest.mark.parametrize("columns", [2_000, 30_000])
def test_a_head_that_is_longer_than_what_is_looked_at_first_is_read(columns: int, tmp_path: Path) -> None:
    head = HEAD + b"".join(b",c%d" % k for k in range(columns))
    assert is_read(table(tmp_path / "a.csv", head, cells=7 + columns))


@pytest.mark.parametrize("lines", [1_000, 100_000])
def test_any_number_of_lines_may_stand_above_the_head(lines: int, tmp_path: Path) -> None:
    assert is_read(table(tmp_path / "a.csv", HEAD, above=b"# a remark\n" * lines))


def test_a_line_above_the_head_may_be_of_any_length(tmp_path: Path) -> None:
    assert is_read(table(tmp_path / "a.csv", HEAD, above=b"# " + b"x" * 500_000 + b"\n"))


@pytest.mark.parametrize(
    ("columns", "told"), [(60_000, "has a header, but no rows"), (5_000_000, "columns, and no more")]
)
def test_a_head_that_does_not_end_is_told(columns: int, told: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(HEAD + b",c" * columns)
    with pytest.raises(ValueError, match=rf"a\.csv: .*{told}"):
        ar.read(tmp_path / "a.csv")
