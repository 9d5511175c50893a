"""What a search found."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _atomic
from ahrs_rs._filter import Filter
from ahrs_rs.filters import FILTERS
from ahrs_rs.tuning._space import Value

FORMAT = "ahrs_rs.tuned"


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Errors over some of the recordings: with the parameters found, and with the filter's defaults."""

    recordings: list[int]
    """Which of the recordings."""
    errors: NDArray[np.float64]
    """(R,) with the parameters found; NaN where no sample counts."""
    defaults: NDArray[np.float64]
    """(R,) with the defaults."""

    @property
    def mean(self) -> float:
        """Of the errors that are known."""
        return _mean(self.errors)

    @property
    def default_mean(self) -> float:
        """Of the errors of the defaults."""
        return _mean(self.defaults)


@dataclass(frozen=True, slots=True, eq=False)
class Tuned:
    """The parameters with the smallest mean error, and what that error is where they were not chosen on."""

    filter: str
    """The name of the filter."""
    params: dict[str, Value]
    """Those that were searched, and those that were held at a given value; all others have their defaults."""
    metric: str
    method: str
    """"grid" or "evolve"."""
    seed: int
    evaluated: int
    """How many parameter sets were tried."""
    train: Scores
    """On the recordings that the parameters were chosen on."""
    test: Scores | None
    """On the others."""
    history: list[float] = field(default_factory=list)
    """The smallest mean error after each generation."""

    def make(self, **keywords: Any) -> Filter:
        """The filter with these parameters; further keywords are those of its constructor, as ``rate``."""
        return FILTERS[self.filter](**{**self.params, **keywords})

    def save(self, path: str | os.PathLike[str], names: list[str] | None = None) -> None:
        """Write a JSON file that `load` reads; `names` are those of the recordings, for the reader."""
        data: dict[str, Any] = {"format": FORMAT, "version": 1}
        data |= {key: getattr(self, key) for key in ("filter", "params", "metric", "method", "seed", "evaluated")}
        for part in ("train", "test"):
            data[part] = _written(getattr(self, part), names)
        data["history"] = self.history
        _atomic.write_text(path, json.dumps(data, indent=1) + "\n")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Tuned:
        """What `save` wrote; ``ValueError`` for another file."""
        try:
            data = json.loads(Path(path).read_text(encoding="utf-8"))
        except (json.JSONDecodeError, UnicodeDecodeError):
            data = None
        if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != 1:
            raise ValueError(f"path: expected a file of tuned parameters, got {Path(path).name!r}")
        own = {key: data[key] for key in ("filter", "params", "metric", "method", "seed", "evaluated", "history")}
        return cls(**own, train=_read(data["train"]), test=None if data["test"] is None else _read(data["test"]))


def _mean(errors: NDArray[np.float64]) -> float:
    known = errors[~np.isnan(errors)]
    return float(known.mean()) if known.size else float("nan")


def _written(scores: Scores | None, names: list[str] | None) -> dict[str, Any] | None:
    if scores is None:
        return None
    return {
        "mean": scores.mean,
        "default_mean": scores.default_mean,
        "recordings": scores.recordings,
        **({} if names is None else {"names": [names[index] for index in scores.recordings]}),
        "errors": scores.errors.tolist(),
        "defaults": scores.defaults.tolist(),
    }


def _read(data: Mapping[str, Any]) -> Scores:
    errors, defaults = (np.array(data[name], dtype=np.float64) for name in ("errors", "defaults"))
    return Scores(list(data["recordings"]), errors, defaults)
