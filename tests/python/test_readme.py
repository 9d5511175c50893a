"""The README's first screen: its numbers stand in the documents, its picture is there, its lines run."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import ahrs_rs as ar
from ahrs_rs.cli import _parser
from commands import saved

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
ACCURACY = (ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8")
SPEED = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")


def rows() -> list[list[str]]:
    (table,) = re.findall(r"(?:^\| .*\n)*^\| \| ahrs_rs .*\n(?:^\|.*\n)+", README, re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]


def of(cell: str) -> list[tuple[str, float]]:
    """The filters of a cell with their numbers."""
    return [(name, float(value)) for name, value in re.findall(r"`(\w+)` ([\d.]+)", cell)]


def error(name: str) -> float:
    (found,) = re.findall(rf"^\| {name} \| defaults \| ([\d.]+) \|", ACCURACY, re.MULTILINE)
    return float(found)


def speed(name: str, column: int) -> float:
    (line,) = re.findall(rf"^\| {name} \| 9D f(?:64|32) \|(.*)\|$", SPEED, re.MULTILINE)[:1]
    return float(line.split("|")[column])


def test_the_numbers_of_the_table_stand_in_the_documents() -> None:
    head, _, online, offline, one, many, update = rows()
    assert head == ["", "ahrs_rs", "`vqf`", "`imufusion`", "`ahrs`"]
    for row in (online, offline):
        assert all(error(name) == value for name, value in of(row[1]))
    assert float(online[2]) == error("VQF"), "equal to their authors' package"
    assert float(offline[2]) == error("OfflineVQF")
    assert float(online[3]) == error("Fusion")
    assert f"imufusion 1.3.3 itself, at its defaults, gives {online[3]} /" in ACCURACY
    for column, row in ((0, one), (2, many)):
        assert len(of(row[1])) == 3
        assert all(speed(f"ahrs_rs {name}", column) == value for name, value in of(row[1]))
    others = [speed(name, 0) for name in ("vqf VQF", "imufusion Ahrs", "ahrs Madgwick")]
    assert [float(cell) for cell in one[2:]] == [pytest.approx(value, abs=5e-5) for value in others]
    assert all(f"ahrs_rs {name}.update {value:g} µs" in SPEED for name, value in of(update[1]))
    assert f"vqf VQF.update {update[2]} µs" in SPEED
    assert f"imufusion Ahrs.update and get_quaternion {update[3]} µs" in SPEED
    assert "(2 here)" in SPEED
    assert "a prototype had 1.86" in ACCURACY


def test_the_picture_is_tracked_small_and_made_by_a_command() -> None:
    (name,) = re.findall(r"^!\[[^\]]+\]\((docs/[^)]+)\)$", README, re.MULTILINE)
    picture = ROOT / name
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 200_000
    assert "tools/picture.py" in (ROOT / "Makefile").read_text(encoding="utf-8")
    assert picture.name in (ROOT / "tools" / "picture.py").read_text(encoding="utf-8")


def test_the_first_lines_run_on_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    pytest.importorskip("pyarrow")
    saved(tmp_path / "walk.csv")
    monkeypatch.chdir(tmp_path)
    code = README.split("```python\n")[1].split("```")[0]
    names: dict[str, object] = {}
    exec(code, names)
    assert isinstance(names["est"], ar.Estimate)


def test_every_command_is_taken() -> None:
    blocks = re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines() if "ahrs-rs " in line]
    assert len(lines) >= 5
    for line in lines:
        words = shlex.split(line, comments=True)
        _parser(None).parse_args(words[1:])


def test_every_link_is_there() -> None:
    linked = [target for target in re.findall(r"\]\(([^)#]+)", README) if "://" not in target]
    assert len(linked) > 20
    assert [target for target in linked if not (ROOT / target).exists()] == []
