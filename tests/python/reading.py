"""Reading in tests: a recording and what was told of it."""

from __future__ import annotations

import importlib.util
import warnings
from pathlib import Path
from typing import Any

import pytest

import ahrs_rs as ar


def told(path: Path, **options: Any) -> tuple[ar.Recording, list[str]]:
    """The recording, and the sentences of its `DataWarning`."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        recording = ar.read(path, **options)
    assert all(issubclass(one.category, ar.DataWarning) for one in caught), [str(one.message) for one in caught]
    prefix = f"{path}: "
    return recording, [str(one.message).removeprefix(prefix) for one in caught]


def needs(package: str) -> pytest.MarkDecorator:
    """A mark that skips a test, visibly, where a package is not installed."""
    return pytest.mark.skipif(importlib.util.find_spec(package) is None, reason=f"{package} is not installed")
