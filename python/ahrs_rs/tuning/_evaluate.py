"""The errors of parameter sets, of which none is computed twice: not even after an interruption."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._cells import Cells, Metric, checked
from ahrs_rs._checkpoint import Checkpoint, job
from ahrs_rs._filter import Filter
from ahrs_rs._recording import Recording
from ahrs_rs.tuning._space import Value

FORMAT = "ahrs_rs.tuning checkpoint"


class TuningInterrupted(KeyboardInterrupt):
    """Ctrl-C during a search. With a checkpoint the same call goes on from there, and ends as if nothing had been.

    Parameters
    ----------
    evaluated : int
        How many parameter sets are done.
    checkpoint : path-like, optional
        Where they are kept, if anywhere.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> issubclass(ar.tuning.TuningInterrupted, KeyboardInterrupt)
    True
    """

    def __init__(self, evaluated: int, checkpoint: Path | None) -> None:
        kept = "they are lost, as there is no checkpoint" if checkpoint is None else f"they are kept in {checkpoint}"
        super().__init__(f"tuning interrupted: {evaluated} parameter sets are done; {kept}")
        self.evaluated = evaluated
        self.checkpoint = checkpoint


class Evaluator:
    """Errors of parameter sets over recordings, kept in memory and in the checkpoint.

    A search asks for sets that follow from its seed and from the errors before, so one that starts again with the
    errors of an interrupted one asks for the same sets, and computes only what is missing.
    """

    def __init__(
        self,
        filter: type[Filter],
        recordings: Sequence[Recording],
        metric: Metric,
        settings: Mapping[str, Any],
        checkpoint: str | os.PathLike[str] | None,
        count: Callable[[int], object] | None,
    ) -> None:
        self.filter, self.metric, self.settings = filter, metric, dict(settings)
        self.recordings = checked(recordings, metric)
        self.known: dict[str, NDArray[np.float64]] = {}
        #: What was asked for, in this order, as (parameters, mean error).
        self.asked: dict[str, tuple[dict[str, Value], float]] = {}
        self._count = count or (lambda finished: None)
        self._kept = None
        if checkpoint is not None:
            self._kept = Checkpoint(checkpoint, job(FORMAT, filter, metric, settings, self.recordings), len(recordings))
            self.known.update(self._kept.rows())

    def means(self, sets: Sequence[Mapping[str, Value]]) -> NDArray[np.float64]:
        """(S,) mean error over the recordings that have one; infinite where none has."""
        keys = [_key(one) for one in sets]
        missing = {key: dict(one) for key, one in zip(keys, sets, strict=True) if key not in self.known}
        self._compute(missing)
        means = [_mean(self.known[key]) for key in keys]
        for key, one, mean in zip(keys, sets, means, strict=True):
            self.asked.setdefault(key, (dict(one), mean))
        self._count(len(self.asked))
        return np.array(means)

    @property
    def path(self) -> Path | None:
        """Of the checkpoint."""
        return None if self._kept is None else self._kept.path

    def errors(self, params: Mapping[str, Value]) -> NDArray[np.float64]:
        """(R,) the errors of a set."""
        self.means([params])
        return self.known[_key(params)]

    def best(self) -> dict[str, Value]:
        """The first one with the smallest mean error of those that were asked for."""
        params, mean = min(self.asked.values(), key=lambda each: each[1])
        if not np.isfinite(mean):
            raise ValueError("recordings: expected a sample that counts, got none in any of them")
        return params

    def _compute(self, missing: Mapping[str, dict[str, Value]]) -> None:
        if not missing:
            return
        errors = np.full((len(missing), len(self.recordings)), np.nan)
        done = np.zeros(errors.shape, dtype=bool)
        kept = self._kept
        if kept is not None:  # sets of which a part is known
            for row, key in enumerate(missing):
                errors[row], done[row] = kept.row(key)

        keys = list(missing)

        def keep(sets: Sequence[int]) -> None:
            if kept is not None:
                kept.add((keys[p], errors[p], done[p]) for p in sets)

        cells = Cells(
            self.filter,
            list(missing.values()),
            self.recordings,
            self.metric,
            errors,
            done,
            None if kept is None else keep,
            **self.settings,
        )
        before = len(self.asked)
        try:
            cells.compute(lambda finished: self._count(before + finished // len(self.recordings)))
        finally:
            self.known.update((key, row) for key, row, known in zip(missing, errors, done, strict=True) if known.all())


def _key(params: Mapping[str, Value]) -> str:
    """The set as text: numbers with all their digits."""
    return json.dumps(dict(params), sort_keys=True)


def _mean(errors: NDArray[np.float64]) -> float:
    known = errors[~np.isnan(errors)]
    return float(known.mean()) if known.size else float("inf")
