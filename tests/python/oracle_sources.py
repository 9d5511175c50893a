"""Of which sources a result is: a hash that changes with what can change the result, and with nothing else.

Sources, not what they compute: numpy's functions differ in their last bits between processors.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
import io
import re
import tokenize
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent


def code(source: str) -> str:
    """A module without comments, documentation and empty lines: what changes no result."""
    lines = source.splitlines()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            assert node.end_lineno is not None
            lines[node.lineno - 1 : node.end_lineno] = [""] * (node.end_lineno - node.lineno + 1)
    return "\n".join(line.rstrip() for line in lines if line.strip())


def imported(path: Path) -> set[Path]:
    """The modules of this folder that a module imports, and those that these do."""
    found: set[Path] = set()
    todo = [path]
    while todo:
        module = todo.pop()
        if module in found:
            continue
        found.add(module)
        for name in re.findall(r"^from (\.?[a-z_.0-9]+) import", module.read_text(encoding="utf-8"), re.MULTILINE):
            base = module.parent if name.startswith(".") else HERE
            other = base / (name.lstrip(".").replace(".", "/") + ".py")
            if other.exists():
                todo.append(other)
    return found


@cache
def modules_hash(*modules: str) -> str:
    """Of modules of this folder, with all that they import from it."""
    digest = hashlib.sha256()
    for path in sorted(set().union(*(imported(HERE / module) for module in modules))):
        digest.update(f"{path.relative_to(HERE)}\n{code(path.read_text(encoding='utf-8'))}\n".encode())
    return digest.hexdigest()


def sources_hash(*parts: object, modules: tuple[str, ...]) -> str:
    """Of modules, of functions (their text) and of what else has a text."""
    texts = [code(inspect.getsource(part)) if callable(part) else repr(part) for part in parts]
    return hashlib.sha256("\n".join([modules_hash(*modules), *texts]).encode()).hexdigest()
