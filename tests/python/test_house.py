"""The rooms of the Python package: what its files are called, and what they import."""

from __future__ import annotations

import ast
import importlib
import re
import sys
import tomllib
from pathlib import Path

import pytest

import ahrs_rs as ar

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "ahrs_rs"
sys.path.insert(0, str(ROOT / "tools"))
map_tool = importlib.import_module("map")
names_tool = importlib.import_module("names")

#: The documented namespaces: what else there is has an underscore (scipy's rule).
NAMESPACES = {
    "attitude",
    "calibration",
    "chain",
    "cli",
    "earth",
    "filters",
    "io",
    "metrics",
    "papers",
    "plots",
    "rotation",
    "signal",
    "simulate",
    "tuning",
}


def test_a_name_without_underscore_is_a_documented_namespace() -> None:
    names = [name.split(".")[1:] for name in map_tool.modules() if "." in name]
    public = {tuple(parts) for parts in names if not any(part.startswith("_") for part in parts)}
    assert public == {(name,) for name in NAMESPACES}
    assert {name for name in NAMESPACES if name not in ar.__all__} == {
        "cli",
        "io",
    }  # a program; a star import would hide the standard library's


@pytest.mark.parametrize("name", sorted(map_tool.modules()))
def test_no_function_shadows_its_module(name: str) -> None:
    if name.endswith("__main__"):
        return  # runs the program
    module = importlib.import_module(name)
    parent, _, leaf = name.rpartition(".")
    assert not parent or getattr(sys.modules[parent], leaf) is module


def test_there_is_no_circle_among_modules_rooms_and_crates() -> None:
    modules = map_tool.modules()
    assert len(modules) > 100
    assert "ahrs_rs._native" in modules["ahrs_rs._engine"]
    assert map_tool.circle(modules) == []
    assert map_tool.circle(map_tool.rooms(modules)) == []
    crates = map_tool.crates()
    assert crates["ahrs-rs-lanes"] == {"ahrs-rs"}
    assert map_tool.circle(crates) == []


def test_a_circle_is_found_wherever_its_imports_stand(tmp_path: Path) -> None:
    package = tmp_path / "ahrs_rs"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "_a.py").write_text("from ahrs_rs import _b\n")
    (package / "_b.py").write_text("def late():\n    from ahrs_rs._c import x\n")
    (package / "_c.py").write_text("if TYPE_CHECKING:\n    import ahrs_rs._a\n")
    assert map_tool.circle(map_tool.modules(package)) == []
    (package / "_c.py").write_text("import ahrs_rs._a\n")
    assert {"ahrs_rs._a", "ahrs_rs._b", "ahrs_rs._c"} == set(map_tool.circle(map_tool.modules(package)))


def test_no_package_reaches_into_the_private_files_of_another() -> None:
    for name, imported in map_tool.modules().items():
        for each in imported:
            room, *private = each.split(".")[1:] or [""]
            assert not private or name.split(".")[1] == room, f"{name} imports {each}"


def test_the_map_is_current() -> None:
    made = map_tool.page(map_tool.crates(), map_tool.modules())
    assert map_tool.PAGE.read_text(encoding="utf-8") == made, "run `make map`"


def test_the_version_is_that_of_the_crate() -> None:
    manifest = tomllib.loads((ROOT / "crates" / "python" / "Cargo.toml").read_text(encoding="utf-8"))
    version = manifest["package"]["version"]
    if isinstance(version, dict):
        version = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
    assert ar.__version__ == version


def test_standard_gravity_stands_once() -> None:
    places = [
        f"{file.relative_to(PACKAGE)}:{node.lineno}"
        for file in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value == 9.80665
    ]
    assert places == ["_constants.py:6"]


PAGES = [ROOT / "ARCHITECTURE.md", *sorted((ROOT / "docs" / "design").glob("*.md"))]
#: Made by a command that takes hours, or has a machine's state: not in every checkout.
MADE = {"docs/attacks.md", "docs/robustness.md", "docs/endurance.md"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_paths_of_the_design_are_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    linked = [target for target in re.findall(r"\]\(([^)#]+)", text) if "://" not in target]
    for target in linked:
        path = (page.parent / target).resolve()
        assert path.exists() or str(path.relative_to(ROOT)) in MADE, target
    roots = ("src/", "crates/", "python/", "tests/", "docs/", "tools/", "benches/", "findings/", "firmware/", ".ci/")
    named = [name for name in re.findall(r"`([^`\s*]+)`", text) if name.startswith(roots)]
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_architecture_is_short_and_has_every_page_of_the_design() -> None:
    text = PAGES[0].read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120
    assert [page.name for page in PAGES[1:] if f"docs/design/{page.name}" not in text] == []


def test_every_decision_has_its_context_evidence_and_consequence() -> None:
    count = 0
    for page in PAGES[1:]:
        for decision in page.read_text(encoding="utf-8").split("\n## ")[1:]:
            title, *_ = decision.splitlines()
            parts = re.findall(r"^- \*\*(\w+)\.\*\* \S", decision, re.MULTILINE)
            assert parts == ["Context", "Decision", "Evidence", "Consequence"], f"{page.name}: {title}"
            count += 1
    assert count > 40


def test_commands_that_the_design_names_are_there() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for page in PAGES:
        for target in re.findall(r"`make ([a-z0-9-]+)", page.read_text(encoding="utf-8")):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"{page.name}: make {target}"


def test_the_table_of_names_is_current() -> None:
    assert names_tool.PAGE.read_text(encoding="utf-8") == names_tool.page(), "run `make names`"


def test_the_extras_are_those_that_messages_name() -> None:
    content = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = content["project"]["optional-dependencies"]
    assert {"io", "plot", "scipy", "papers", "all"} <= extras.keys()
    assert extras["rotation"] == extras["calibration"] == ["ahrs-rs[scipy]"]  # what it was called
    sources = "".join(file.read_text(encoding="utf-8") for file in PACKAGE.rglob("*.py"))
    named = set(re.findall(r"ahrs-rs\[([a-z0-9]+)\]", sources)) - {"extra"}  # a docstring's
    named |= set(re.findall(r'require\("[\w.]+", "([a-z0-9]+)", ', sources))
    assert {"io", "plot", "scipy", "papers"} <= named <= extras.keys()


def test_the_citation_has_the_version_and_the_licences() -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {ar.__version__}\n" in text
    assert "  - MIT\n  - Apache-2.0\n" in text


def test_hooks_run_what_lint_runs() -> None:
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    lint = (ROOT / "Makefile").read_text(encoding="utf-8").split("\nlint:")[1].split("\n\n")[0]
    assert set(re.findall(r"^  - repo: (.*)$", hooks, re.MULTILINE)) == {"local"}
    for tool in (
        "cargo fmt --all --check",
        "ruff format --check",
        "ruff check",
        "mypy",
        *re.findall(r"tools/\w+\.py", lint),
    ):
        assert tool in hooks, tool
        assert tool in lint, tool
