"""Data frames of whichever library is installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def data_frame(columns: Mapping[str, Any]) -> Any:
    """A polars or pandas DataFrame, polars first; ``ImportError`` where neither is installed."""
    try:
        import polars

        return polars.DataFrame(columns)
    except ImportError:
        pass
    try:
        import pandas
    except ImportError:
        raise ImportError("to_frame needs polars or pandas: pip install ahrs-rs[io]") from None
    return pandas.DataFrame(columns)
