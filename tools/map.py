"""Draws the import graphs of the crates and of the Python package into docs/map.md: `make map`.

With --check, only says whether the file is current. A circle is an error in either case.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "map.md"
PACKAGE = "ahrs_rs"

Graph = Mapping[str, set[str]]

HEAD = """# Map

Made by `make map`; do not edit. An arrow points from what imports to what is imported. There is no circle, neither
between crates nor between the modules of the Python package; a test checks it. [ARCHITECTURE.md](../ARCHITECTURE.md)
says what each room holds.
"""


def crates() -> Graph:
    """The crates of the workspace, and which of them each depends on."""
    manifest = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))
    folders = [ROOT, *(path for member in manifest["workspace"]["members"] for path in sorted(ROOT.glob(member)))]
    found = {}
    for folder in folders:
        content = tomllib.loads((folder / "Cargo.toml").read_text(encoding="utf-8"))
        if "package" in content:
            found[content["package"]["name"]] = {
                spec.get("package", name) if isinstance(spec, dict) else name
                for name, spec in content.get("dependencies", {}).items()
            }
    return {name: needed & found.keys() - {name} for name, needed in found.items()}


def modules(package: Path = ROOT / "python" / PACKAGE) -> Graph:
    """The modules of a package, and which of them each imports, wherever in its text, at run time."""
    files = {_module(file, package): file for file in sorted(package.rglob("*.py"))}
    native = {f"{PACKAGE}._native": set[str]()}
    return native | {name: set(_imports(name, file, files.keys() | native)) for name, file in files.items()}


def circle(graph: Graph) -> list[str]:
    """The names along a circle, or none where there is no circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        names: list[str] = error.args[1]
        return names
    return []


def rooms(graph: Graph) -> Graph:
    """The graph of the namespaces: a private module at the top stands for itself, others for their subpackage."""
    found: dict[str, set[str]] = {}
    for name, imported in graph.items():
        room = _room(name)
        found.setdefault(room, set()).update(_room(each) for each in imported)
    return {room: imported - {room} for room, imported in found.items()}


def _room(name: str) -> str:
    return ".".join(name.split(".")[:2])


def _module(file: Path, package: Path) -> str:
    parts = file.relative_to(package.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports(name: str, file: Path, known: set[str]) -> Iterator[str]:
    for node in _at_run_time(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            targets = [each.name for each in node.names]
        else:
            # A package's own name stands for its __init__ only where something of that is imported.
            module = node.module or ""
            below = [f"{module}.{each.name}" for each in node.names]
            targets = [each if each in known else module for each in below]
        yield from (target for target in targets if target in known and target != name)


def _at_run_time(node: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """The imports below a node but those for type checkers."""
    if isinstance(node, (ast.Import, ast.ImportFrom)):
        yield node
    if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
        return
    for child in ast.iter_child_nodes(node):
        yield from _at_run_time(child)


def drawing(graph: Graph) -> str:
    """The graph as mermaid draws it, without arrows that follow from two others."""
    below = {name: _reached(graph, name) for name in graph}
    lines = ["```mermaid", "graph TD"]
    for name in sorted(graph):
        direct = graph[name] - {each for other in graph[name] for each in below[other]}
        lines += [f"    {name} --> {each}" for each in sorted(direct)] or [f"    {name}"]
    return "\n".join([*lines, "```"])


def _reached(graph: Graph, name: str) -> set[str]:
    found: set[str] = set()
    waiting = list(graph[name])
    while waiting:
        each = waiting.pop()
        if each not in found:
            found.add(each)
            waiting += graph[each]
    return found


def page(crate_graph: Graph, module_graph: Graph) -> str:
    """The page."""
    top = {name.removeprefix(f"{PACKAGE}."): imported for name, imported in rooms(module_graph).items()}
    top = {name: {each.removeprefix(f"{PACKAGE}.") for each in imported} for name, imported in top.items()}
    rows = [
        f"| `{name.removeprefix(f'{PACKAGE}.')}` | {_listed(imported)} |"
        for name, imported in sorted(module_graph.items())
    ]
    parts = [
        HEAD,
        "## Crates\n",
        drawing(crate_graph),
        "\n## Rooms of the Python package\n",
        drawing({name: imported & top.keys() - {PACKAGE} for name, imported in top.items() if name != PACKAGE}),
        "\n## Its modules\n",
        "| module | imports |\n| --- | --- |",
        *rows,
    ]
    return "\n".join(parts) + "\n"


def _listed(names: set[str]) -> str:
    return ", ".join(f"`{name.removeprefix(f'{PACKAGE}.')}`" for name in sorted(names)) or "nothing of the package"


def main() -> int:
    """Write the page, or check it."""
    crate_graph, module_graph = crates(), modules()
    for graph in (crate_graph, module_graph):
        names = circle(graph)
        if names:
            print(f"a circle: {' imports '.join(reversed(names))}", file=sys.stderr)
            return 1
    text = page(crate_graph, module_graph)
    if "--check" in sys.argv[1:]:
        current = PAGE.exists() and PAGE.read_text(encoding="utf-8") == text
        if not current:
            print(f"{PAGE.name} is not current: run `make map`", file=sys.stderr)
        return 0 if current else 1
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
