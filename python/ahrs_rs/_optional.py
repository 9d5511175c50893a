"""Packages that are not always installed: the extras of pyproject.toml."""

from __future__ import annotations

import importlib
import importlib.metadata
from typing import Any


def require(module: str, extra: str, what: str) -> Any:
    """Import a module of an optional package.

    Parameters
    ----------
    module : str
        Its name, as "scipy.signal".
    extra : str
        The extra that installs the package; empty where it is in none.
    what : str
        What needs it, for the message: "plots need", "this file format needs".

    Raises
    ------
    ImportError
        The package is not installed; the message says what to install.
    """
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise
        install = f"ahrs-rs[{extra}]" if extra else package
        raise ImportError(f"{what} {package}: pip install {install}") from error


def version(package: str) -> tuple[int, int]:
    """The version of an installed package: its first two numbers."""
    first, second = importlib.metadata.version(package).split(".")[:2]
    return int(first), int(second)
