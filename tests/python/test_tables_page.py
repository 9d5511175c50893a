"""The page of units and columns is that of the code."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.skipif(not (ROOT / "tools").is_dir(), reason="the tools are not beside the tests")
def test_the_page_of_tables_is_current() -> None:
    made = runpy.run_path(str(ROOT / "tools" / "tables.py"))["document"]()
    assert (ROOT / "docs" / "tables.md").read_text(encoding="utf-8") == made, "run `make tables`"
