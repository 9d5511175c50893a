"""Data frames of whichever library is installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ahrs_rs._optional import require

if TYPE_CHECKING:
    import pandas
    import polars


class Table:
    """Base of what can be shown as a data frame. A subclass gives ``_columns``."""

    __slots__ = ()

    def _columns(self) -> Mapping[str, Any]:
        """The columns by name."""
        raise NotImplementedError

    def to_polars(self) -> polars.DataFrame:
        """The data frame of `to_frame` as one of polars; ``ImportError`` where polars is not installed.

        Returns
        -------
        DataFrame
            A row a sample, or an error.
        """
        made: polars.DataFrame = require("polars", "", "to_polars needs").DataFrame(self._columns())
        return made

    def to_pandas(self) -> pandas.DataFrame:
        """The data frame of `to_frame` as one of pandas; ``ImportError`` where pandas is not installed.

        Returns
        -------
        DataFrame
            A row a sample, or an error.
        """
        made: pandas.DataFrame = require("pandas", "io", "to_pandas needs").DataFrame(self._columns())
        return made


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
