"""docs/peers.md and docs/from-peers.md: what they name is there, here and in the packages."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import ahrs_rs as ar

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [DOCS / "peers.md", DOCS / "from-peers.md"]
#: What the short names of the pages stand for.
SHORT: dict[str, Any] = {"ar": ar, "f": ar.Filter, "est": ar.Estimate, "rec": ar.Recording, "recording": ar.Recording}


def section(page: Path, title: str) -> str:
    """The text of a page below a title that starts so."""
    for part in page.read_text(encoding="utf-8").split("\n## ")[1:]:
        if part.startswith(title):
            return part
    raise AssertionError(f"{page.name} has no section {title}")


def named_there(title: str) -> set[str]:
    """The names in the first columns of a section of docs/peers.md."""
    rows = [line.split("|")[1] for line in section(PAGES[0], title).splitlines() if line.startswith("| `")]
    assert rows
    return {name for row in rows for name in re.findall(r"`([\w.]+)`", row)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_name_on_our_side_exists(page: Path) -> None:
    text = "\n".join(re.findall(r"`([^`]+)`", page.read_text(encoding="utf-8")))
    names = {match[0] for match in re.finditer(r"(?<![\w.])(?:ar|f|est|rec|recording)(?:\.[A-Za-z_]\w*)+", text)}
    assert len(names) > 20
    for name in sorted(names):
        first, *rest = name.split(".")
        value = SHORT[first]
        for part in rest:
            if isinstance(value, type) and part in inspect.get_annotations(value):
                break  # a field of a dataclass
            assert hasattr(value, part), name
            value = getattr(value, part)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_keyword_of_a_filter_exists(page: Path) -> None:
    for name, arguments in re.findall(r"`ar\.([A-Z]\w+)\(([^)]*)\)", page.read_text(encoding="utf-8")):
        if name in ar.FILTERS:
            known = set(ar.FILTERS[name]().get_params())
            assert set(re.findall(r"(\w+)=", arguments)) <= known, name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_row_says_what_is_here(page: Path) -> None:
    rows = [line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    assert len(rows) > 30
    for row in rows:
        cells = [cell.strip() for cell in row.split("|")[1:-1]]
        assert len(cells) == 3, row
        here = cells[2] if page.name == "peers.md" else cells[1]
        assert re.search(r"`|^no\b|TODO-LEAD|crate|\"frame", here), row


def installed(name: str) -> Any:
    return pytest.importorskip(name, reason=f"the package {name} is not installed")


def public(module: Any) -> set[str]:
    """Functions and classes that a module itself has, not those of numpy and typing."""
    return {
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and (inspect.isroutine(value) or inspect.isclass(value))
        and (getattr(value, "__module__", "") or "").partition(".")[0]
        not in ("typing", "numpy", "io", "_io", "builtins")
    }


def test_nothing_of_ahrs_lacks() -> None:
    ahrs = installed("ahrs")
    names = public(ahrs) | public(ahrs.filters)
    for module in ("orientation", "quaternion", "dcm", "frames", "geometry", "mathfuncs"):
        names |= public(importlib.import_module(f"ahrs.common.{module}"))
    for module in ("metrics", "sensors", "wmm", "wgs84", "geodesy", "core"):
        names |= public(importlib.import_module(f"ahrs.utils.{module}"))
    assert len(names) > 80
    assert names - named_there("`ahrs`") == set()


def test_nothing_of_vqf_lacks() -> None:
    vqf = installed("vqf")
    names = public(vqf) | {"offlineVQF"}
    for name in ("VQF", "BasicVQF", "PyVQF"):
        names |= {each for each in dir(getattr(vqf, name)) if not each.startswith("_")}
    assert len(names) > 40
    assert names - named_there("`vqf`") == set()


def test_nothing_of_imufusion_lacks() -> None:
    imufusion = installed("imufusion")
    names = {name for name in dir(imufusion) if not name.startswith(("_", "ALIGNMENT_", "CONVENTION_"))}
    names |= {each for each in dir(imufusion.Ahrs) if not each.startswith("_")}
    assert len(names) > 20
    assert names - named_there("`imufusion`") - {"np", "numpy"} == set()


def test_nothing_of_qmt_lacks() -> None:
    qmt = installed("qmt")
    names = {name for name in public(qmt) if not name.endswith("_debugPlot")}
    assert len(names) > 70
    assert names - named_there("`qmt`") == set()


def test_nothing_of_smsfusion_lacks() -> None:
    smsfusion = installed("smsfusion")
    assert public(smsfusion) - named_there("`smsfusion`") == set()
    listed = {name.rpartition(".")[2] for name in named_there("`smsfusion`")}
    for module in ("noise", "calibrate"):
        assert public(getattr(smsfusion, module)) - listed == set()


def test_what_gtsam_is_said_to_have_is_there() -> None:
    gtsam = installed("gtsam")
    lacking = {name for name in named_there("`gtsam`") if not hasattr(gtsam, name)}
    assert lacking == set()
