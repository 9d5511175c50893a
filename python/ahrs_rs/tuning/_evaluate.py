"""The errors of parameter sets, of which none is computed twice: not even after an interruption."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._filter import Filter
from ahrs_rs._sweep import Metric, Sweep, SweepInterrupted, sweep
from ahrs_rs.recording import Recording
from ahrs_rs.tuning._space import Value

#: So many sets are computed before they are written to the checkpoint.
BLOCK = 1024

FORMAT = "ahrs_rs.tuning checkpoint"


class TuningInterrupted(KeyboardInterrupt):
    """Ctrl-C during a search. With a checkpoint the same call goes on from there, and ends as if nothing had been."""

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
        self.filter, self.recordings, self.metric, self.settings = filter, list(recordings), metric, dict(settings)
        self.path = None if checkpoint is None else Path(checkpoint)
        self.known: dict[str, NDArray[np.float64]] = {}
        #: What was asked for, in this order, as (parameters, mean error).
        self.asked: dict[str, tuple[dict[str, Value], float]] = {}
        self._count = count or (lambda finished: None)
        if self.path is not None:
            self._read(self.path)

    def means(self, sets: Sequence[Mapping[str, Value]]) -> NDArray[np.float64]:
        """(S,) mean error over the recordings that have one; infinite where none has."""
        keys = [_key(one) for one in sets]
        missing = {key: dict(one) for key, one in zip(keys, sets, strict=True) if key not in self.known}
        names = list(missing)
        for begin in range(0, len(names), BLOCK):
            self._compute({key: missing[key] for key in names[begin : begin + BLOCK]})
        means = [_mean(self.known[key]) for key in keys]
        for key, one, mean in zip(keys, sets, means, strict=True):
            self.asked.setdefault(key, (dict(one), mean))
        self._count(len(self.asked))
        return np.array(means)

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
        before = len(self.asked)
        try:
            found = sweep(
                self.filter,
                list(missing.values()),
                self.recordings,
                self.metric,
                progress=lambda done, _: self._count(before + done // len(self.recordings)),
                **self.settings,
            )
        except SweepInterrupted as interruption:
            self._keep(list(missing), interruption.partial)
            raise
        self._keep(list(missing), found)

    def _keep(self, keys: Sequence[str], found: Sweep) -> None:
        rows = [(key, errors) for key, errors, done in zip(keys, found.errors, found.done, strict=True) if done.all()]
        self.known.update(rows)
        if self.path is not None and rows:
            with self.path.open("a", encoding="utf-8") as file:
                file.writelines(json.dumps([key, errors.tolist()]) + "\n" for key, errors in rows)

    def _job(self) -> dict[str, Any]:
        """What the errors depend on, beside the parameters."""
        from ahrs_rs import __version__

        name = self.metric if isinstance(self.metric, str) else getattr(self.metric, "__name__", "metric")
        settings = {name: str(value) for name, value in self.settings.items() if name != "threads"}
        return {
            "format": FORMAT,
            "version": __version__,
            "filter": self.filter.NAME,
            "metric": name,
            "settings": settings,
            "recordings": [_digest(one) for one in self.recordings],
        }

    def _read(self, path: Path) -> None:
        """Takes over what the file has, or begins it."""
        head = json.dumps(self._job())
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if not text:
            path.write_text(head + "\n", encoding="utf-8")
            return
        first, *lines = text.split("\n")
        if first != head:
            raise ValueError(f"checkpoint: {path} is of another search (filter, metric, recordings or settings)")
        # What follows the last newline was cut off in writing; it is computed again.
        for line in lines[:-1]:
            key, errors = json.loads(line)
            self.known[key] = np.array(errors, dtype=np.float64)
        if lines[-1]:
            path.write_text("\n".join([first, *lines[:-1]]) + "\n", encoding="utf-8")


def _key(params: Mapping[str, Value]) -> str:
    """The set as text: numbers with all their digits."""
    return json.dumps(dict(params), sort_keys=True)


def _mean(errors: NDArray[np.float64]) -> float:
    known = errors[~np.isnan(errors)]
    return float(known.mean()) if known.size else float("inf")


def _digest(recording: Recording) -> str:
    """A short text that differs where a number of the recording does."""
    digest = hashlib.sha256(repr(recording.rate).encode())
    for name in ("t", "gyr", "acc", "mag", "ref", "mask"):
        array = getattr(recording, name)
        digest.update(name.encode() if array is None else np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]
