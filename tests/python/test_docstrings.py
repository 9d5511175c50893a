"""Docstrings: complete by numpydoc's validator, with examples that run, and readable in a terminal."""

from __future__ import annotations

import ast
import doctest
import enum
import inspect
import pydoc
import re
from pathlib import Path
from typing import Any

import pytest
from numpydoc.validate import validate

import ahrs_rs as ar
from docstrings import members, public

#: No docstring or summary; parameters that are undocumented, unknown, in another order, without type or description;
#: no section of what is returned, or no description in it.
CODES = {"GL08", "SS01", "PR01", "PR02", "PR03", "PR04", "PR07", "PR10", "RT01", "RT03", "YD01"}
#: Besides, for classes and functions: no example.
EXAMPLE = "EX01"

PUBLIC = public()
OBJECTS = {
    each: value
    for name, owner in PUBLIC.items()
    for each, value in [(name, owner), *(members(name, owner) if inspect.isclass(owner) else [])]
}


def errors(name: str, value: Any) -> list[str]:
    """What numpydoc finds missing."""
    wanted = CODES | {EXAMPLE} if name in PUBLIC else CODES
    found = [(code, text) for code, text in validate(name)["errors"] if code in wanted]
    if inspect.isclass(value) and (issubclass(value, enum.Enum) or getattr(value, "_is_protocol", False)):
        found = [(code, text) for code, text in found if code != "PR01"]  # nobody calls their constructors so
    return [f"{code} {text}" for code, text in found]


def test_there_are_all_public_objects() -> None:
    assert len(PUBLIC) > 150
    assert len(OBJECTS) > 300
    assert {"ahrs_rs.Madgwick", "ahrs_rs.sweep", "ahrs_rs.Estimate.euler", "ahrs_rs.metrics.score"} <= OBJECTS.keys()


@pytest.mark.parametrize("name", OBJECTS)
def test_numpydoc_finds_nothing_missing(name: str) -> None:
    assert errors(name, OBJECTS[name]) == []


@pytest.mark.parametrize("name", [name for name, value in OBJECTS.items() if ">>>" in (inspect.getdoc(value) or "")])
def test_the_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(OBJECTS[name]) or "", {}, name, None, 0)
    told: list[str] = []
    result = doctest.DocTestRunner(verbose=False).run(test, out=told.append)
    assert result.attempted > 0
    assert result.failed == 0, "".join(told)


@pytest.mark.parametrize("name", ["Filter", *ar.FILTERS])
def test_help_fits_a_terminal_and_has_every_keyword(name: str) -> None:
    text = pydoc.plain(pydoc.render_doc(getattr(ar, name)))
    assert [line for line in text.splitlines() if len(line) > 100] == []
    for keyword in ("rate", "frame", "declination", "gyr_hold", "repeated", "gyr_range", "dtype"):
        assert re.search(rf"^ \|  {keyword} : ", text, re.MULTILINE), keyword


def test_the_stub_has_the_docstrings_of_the_classes() -> None:
    stub = Path(ar.__file__).with_name("filters.pyi").read_text(encoding="utf-8")
    classes = {node.name: node for node in ast.parse(stub).body if isinstance(node, ast.ClassDef)}
    assert {name: ast.get_docstring(node) for name, node in classes.items()} == {
        name: inspect.getdoc(cls) for name, cls in ar.FILTERS.items()
    }
