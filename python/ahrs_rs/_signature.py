"""Signatures as `help` shows them."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

#: `help` indents by four columns or eight, and puts the name before it.
WIDTH = 68


class ShownSignature(inspect.Signature):
    """A signature that is shown in short lines, without annotations."""

    def __str__(self) -> str:
        shown: list[str] = []
        for each in self.parameters.values():
            if each.kind is each.KEYWORD_ONLY and "*" not in shown:
                shown.append("*")
            star = "**" if each.kind is each.VAR_KEYWORD else ""
            default = each.default.__name__ if isinstance(each.default, type) else repr(each.default)
            shown.append(f"{star}{each.name}{'' if each.default is each.empty else f'={default}'}")
        return textwrap.fill(f"({', '.join(shown)})", WIDTH, subsequent_indent="    ", break_on_hyphens=False)


def in_lines(function: Function) -> Function:
    """The function with such a signature, and without ``*positional``, which is there only for a better error."""
    signature = inspect.signature(function)
    kept = [each for each in signature.parameters.values() if each.kind is not each.VAR_POSITIONAL]
    shown = ShownSignature(kept, return_annotation=signature.return_annotation)
    function.__signature__ = shown  # type: ignore[attr-defined]
    return function
