"""Writes python/ahrs_rs/filters.pyi from the registry: `make stubs`. With --check, only says whether it is current."""

from __future__ import annotations

import inspect
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ahrs_rs import FILTERS, Filter, Param
from ahrs_rs._extra_constructors import SPECIAL

STUB = Path(__file__).parents[1] / "python" / "ahrs_rs" / "filters.pyi"

HEAD = """# Made by tools/stubs.py from the registry; do not edit.
from typing import Any, Literal, Self

from numpy.typing import DTypeLike

from ahrs_rs._classes import Registry
from ahrs_rs._filter import Filter

FILTERS: Registry
"""


def keywords(cls: type[Filter]) -> str:
    """The keyword arguments of a constructor."""
    lines = ["*", "rate: float | None = None"]
    for param in cls.PARAMS.values():
        kind = attribute_type(param)
        if isinstance(param.default, str):
            kind = f"Literal[{', '.join(map(quoted, map(str, param.options or ())))}]"
        default = quoted(param.default) if isinstance(param.default, str) else param.default
        lines.append(f"{param.name}: {kind} = {default}")
    common_range = [] if "gyr_range" in cls.PARAMS else ["gyr_range: float = 0.0"]
    lines += [
        'frame: Literal["ENU", "NED", "NWU"] = "ENU"',
        "declination: float = 0.0",
        'gyr_hold: Literal["zero-order", "linear"] = "zero-order"',
        'repeated: Literal["new", "missing"] = "new"',
        *common_range,
        "dtype: DTypeLike = ...",
    ]
    return ",\n        ".join(lines)


def attribute_type(param: Param) -> str:
    """The type of a parameter's value."""
    return type(param.default).__name__


def quoted(text: str) -> str:
    return f'"{text}"'


def ignored(param: Param) -> str:
    """For a parameter of what every filter has: an attribute there, which a property goes over."""
    return (
        "  # type: ignore[override]"
        if any(param.name in inspect.get_annotations(base) for base in Filter.__mro__)
        else ""
    )


def class_stub(cls: type[Filter]) -> str:
    attributes = [
        f"    @property\n    def {param.name}(self) -> {attribute_type(param)}: ...{ignored(param)}"
        for param in cls.PARAMS.values()
    ]
    lines = [
        "",
        f"class {cls.__name__}(Filter):",
        docstring(cls),
        *attributes,
        "    def __new__(",
        "        cls,",
        f"        {keywords(cls)},",
        "    ) -> Self: ...",
        *map(method_stub, SPECIAL.get(cls.__name__, ())),
    ]
    return "\n".join(lines) + "\n"


def docstring(cls: type[Filter]) -> str:
    """That of the class, indented, so that editors show it."""
    text = textwrap.indent(inspect.getdoc(cls) or "", "    ")
    prefix = "r" if "\\" in text else ""
    return f'    {prefix}"""{text.strip()}\n    """'


def method_stub(method: Callable[..., Any]) -> str:
    """A class method of one class alone."""
    first, *others = inspect.signature(method).parameters.values()
    bare = [first.replace(annotation=inspect.Parameter.empty), *others]
    signature = inspect.Signature(bare)
    arguments = str(signature).replace("'", "")
    return f"    @classmethod\n    def {method.__name__}{arguments} -> Self: ..."


def constants_first(name: str) -> tuple[bool, str]:
    """The order that ruff wants."""
    return not name.isupper(), name


def stub() -> str:
    names = "".join(f"\n    {quoted(name)}," for name in sorted(["FILTERS", *FILTERS], key=constants_first))
    return HEAD + f"__all__ = [{names}\n]\n" + "".join(map(class_stub, FILTERS.values()))


def main() -> int:
    text = stub()
    if "--check" in sys.argv[1:]:
        current = STUB.exists() and STUB.read_text(encoding="utf-8") == text
        if not current:
            print(f"{STUB.name} is not current: run `make stubs`", file=sys.stderr)
        return 0 if current else 1
    STUB.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
