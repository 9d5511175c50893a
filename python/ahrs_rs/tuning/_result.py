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

from ahrs_rs import _atomic, _json, _stored
from ahrs_rs._filter import Filter
from ahrs_rs.filters import FILTERS
from ahrs_rs.tuning._space import Value

FORMAT = "ahrs_rs.tuned"
VERSION = 1


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Errors over some of the recordings: with the parameters found, and with the filter's defaults.

    Parameters
    ----------
    recordings : list of int
        Which of the recordings.
    errors : ndarray
        (R,) with the parameters found; NaN where no sample counts.
    defaults : ndarray
        (R,) with the defaults.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.tuning.grid(ar.Madgwick, {"beta": [0.02, 0.1]}, [rec])
    >>> found.train.errors.shape
    (1,)
    """

    recordings: list[int]
    errors: NDArray[np.float64]
    defaults: NDArray[np.float64]

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
    """The parameters with the smallest mean error, and what that error is where they were not chosen on.

    Parameters
    ----------
    filter : str
        The name of the filter.
    params : dict
        Those that were searched, and those that were held at a given value; all others have their
        defaults.
    metric : str
        What was made small.
    method : str
        "grid" or "evolve".
    seed : int
        Of all that is random.
    evaluated : int
        How many parameter sets were tried.
    train : Scores
        On the recordings that the parameters were chosen on.
    test : Scores, optional
        On the others.
    history : list of float, optional
        The smallest mean error after each generation.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.tuning.grid(ar.Madgwick, {"beta": [0.02, 0.1]}, [rec])
    >>> found.filter, found.evaluated
    ('Madgwick', 2)
    """

    filter: str
    params: dict[str, Value]
    metric: str
    method: str
    seed: int
    evaluated: int
    train: Scores
    test: Scores | None
    history: list[float] = field(default_factory=list)

    def make(self, **keywords: Any) -> Filter:
        """The filter with these parameters; further keywords are those of its constructor, as ``rate``.

        Parameters
        ----------
        **keywords : object
            Of the constructor, as ``rate``.

        Returns
        -------
        Filter
            The filter.
        """
        return FILTERS[self.filter](**{**self.params, **keywords})

    def save(self, path: str | os.PathLike[str], names: list[str] | None = None) -> None:
        """Write a JSON file that `load` reads; `names` are those of the recordings, for the reader.

        Parameters
        ----------
        path : str or path-like
            Of a JSON file.
        names : list of str, optional
            Those of the recordings, for the reader.
        """
        data: dict[str, Any] = {"format": FORMAT, "version": VERSION}
        data |= {key: getattr(self, key) for key in ("filter", "params", "metric", "method", "seed", "evaluated")}
        for part in ("train", "test"):
            data[part] = _written(getattr(self, part), names)
        data["history"] = self.history
        _atomic.write_text(path, json.dumps(data, indent=1) + "\n")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Tuned:
        """What `save` wrote; ``ValueError`` for another file.

        Parameters
        ----------
        path : str or path-like
            Of a file that `save` wrote.

        Returns
        -------
        Tuned
            The parameters and their errors.
        """
        try:
            data = _json.read(path)
        except ValueError:
            data = None
        if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != VERSION:
            raise ValueError(f"path: expected a file of tuned parameters, got {Path(path).name!r}")
        try:
            return cls(**_fields(data))
        except ValueError as error:
            raise ValueError(f"path: expected a file of tuned parameters, got {Path(path).name!r}: {error}") from None


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


def _fields(data: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of `Tuned`; ``ValueError`` where one is none."""
    kinds: dict[str, Any] = {"filter": str, "params": dict, "metric": str, "method": str, "seed": int, "evaluated": int}
    kinds |= {"train": dict, "test": dict | None, "history": list}
    for name, kind in kinds.items():
        if not isinstance(data.get(name, ...), kind):
            raise ValueError(f"{name}: {_stored.shown(data.get(name))}")
    if data["filter"] not in FILTERS:
        raise ValueError(f"filter: {_stored.shown(data['filter'])}")
    try:
        FILTERS[data["filter"]]._encoded(data["params"])
    except TypeError as error:  # a parameter that it does not have
        raise ValueError(str(error)) from None
    fields = {name: data[name] for name in kinds}
    fields["history"] = _numbers("history", data["history"]).tolist()
    return fields | {name: None if data[name] is None else _read(data[name]) for name in ("train", "test")}


def _read(data: Mapping[str, Any]) -> Scores:
    errors, defaults = (_numbers(name, data.get(name)) for name in ("errors", "defaults"))
    which = data.get("recordings")
    if not isinstance(which, list) or not all(type(one) is int for one in which):
        raise ValueError(f"recordings: {_stored.shown(which)}")
    if not len(which) == len(errors) == len(defaults):
        raise ValueError(f"errors: {len(errors)} and {len(defaults)} of {len(which)} recordings")
    return Scores(which, errors, defaults)


def _numbers(name: str, values: object) -> NDArray[np.float64]:
    if not isinstance(values, list) or not all(isinstance(one, float) for one in values):
        raise ValueError(f"{name}: {_stored.shown(values)}")
    return np.array(values, dtype=np.float64)
