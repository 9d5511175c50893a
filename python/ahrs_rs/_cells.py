"""The errors of a sweep, computed portion by portion."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ahrs_rs import _own
from ahrs_rs._estimate import Estimate
from ahrs_rs._filter import Filter
from ahrs_rs._progress import counting_on
from ahrs_rs._recording import Recording
from ahrs_rs._run_many import run_many
from ahrs_rs._validate import thread_count
from ahrs_rs.metrics import Score, score

Metric: TypeAlias = str | Callable[[Estimate, Recording], float]
Count: TypeAlias = Callable[[int], object]

#: So many sets fill every register there is; fewer of them take as long.
LANES = 16
#: So long a portion is to take, s: that much is lost where a process is killed.
SECONDS = 1.0
#: The first portion, in sets times samples: hundredths of a second for most filters.
FIRST = 1e6
#: A portion is at most so many times as large as the one before.
GROWTH = 8.0


class Cells:
    """Errors of parameter sets over recordings, in arrays that are filled in place.

    Parameters
    ----------
    filter : the class
    sets : P of them
    recordings : R of them; with `ref`, unless the metric is a function
    metric : a name, or a function
    errors, done : (P, R), the errors and whether they are known
    keep : called with the sets of each portion, after about a second; without it everything is one portion
    settings : threads, dtype, and those of the filter
    """

    def __init__(
        self,
        filter: type[Filter],
        sets: Sequence[Mapping[str, Any]],
        recordings: Sequence[Recording],
        metric: Metric,
        errors: NDArray[np.float64],
        done: NDArray[np.bool_],
        keep: Callable[[Sequence[int]], object] | None = None,
        *,
        threads: int | None = None,
        dtype: DTypeLike = np.float64,
        **settings: Any,
    ) -> None:
        self.filter, self.sets, self.recordings = filter, sets, recordings
        self.errors, self.done = errors, done
        self.threads, self.dtype, self.settings = thread_count(threads), dtype, settings
        self._keep = keep
        self._budget = math.inf if keep is None else FIRST
        self._samples = np.array([len(one) for one in recordings], dtype=np.float64)
        if isinstance(metric, str) and filter.STREAMING:
            self._compute: Callable[[list[int], list[int], Count | None], None] = self._side_by_side
            self._name, self._least = metric, LANES
            self._trials = [_trial(one, dtype) for one in recordings]
        else:
            self._compute = self._one_by_one
            self._function, self._least = (_score_of(metric) if isinstance(metric, str) else metric), 1

    def compute(self, count: Count | None = None) -> None:
        """Fill in what is not done; `count` is told how many are done meanwhile."""
        for sets, which in self._portions():
            begin = time.monotonic()
            try:
                self._compute(sets, which, counting_on(count, int(self.done.sum())))
            finally:
                if self._keep is not None:
                    self._keep(sets)
            self._adapt(len(sets) * float(self._samples[which].sum()), time.monotonic() - begin)

    def _portions(self) -> Iterator[tuple[list[int], list[int]]]:
        """Sets and recordings of which nothing is done; what is missing of a recording at once where it fits."""
        # Sets of the same choices are computed side by side.
        choices = [name for name, param in self.filter.PARAMS.items() if param.options is not None]
        order = sorted(range(len(self.sets)), key=lambda p: [str(self.sets[p].get(name)) for name in choices])
        pending = [p for p in order if not self.done[p].all()]
        while pending:
            fitting = min(self._budget / max(float(self._samples.sum()), 1.0), len(pending))
            size = max(int(fitting) // self._least, 1) * self._least if fitting < len(pending) else len(pending)
            chunk, pending = pending[:size], pending[size:]
            alike: dict[tuple[int, ...], list[int]] = {}
            for r in range(len(self.recordings)):
                alike.setdefault(tuple(p for p in chunk if not self.done[p, r]), []).append(r)
            for missing, which in alike.items():
                while missing and which:
                    work = np.cumsum(self._samples[which]) * max(len(missing), self._least)
                    part = max(int(np.searchsorted(work, self._budget, side="right")), 1)
                    yield list(missing), which[:part]
                    which = which[part:]

    def _adapt(self, work: float, seconds: float) -> None:
        """A portion as large as what this machine does in a second, but larger by degrees only."""
        fitting = work * SECONDS / max(seconds, 1e-6)
        self._budget = min(max(fitting, FIRST), self._budget * GROWTH)

    def _side_by_side(self, sets: list[int], which: list[int], count: Count | None) -> None:
        """By the native engine, which keeps the errors alone."""
        made = self.filter(**self.settings)
        errors, done, error = made._sweep(
            [self.filter._encoded(self.sets[p]) for p in sets],
            [self._trials[r] for r in which],
            self._name,
            self.threads,
            np.dtype(self.dtype) == np.float32,
            count,
        )
        places = np.ix_(np.array(sets), np.array(which))
        self.errors[places] = np.degrees(errors).reshape(len(sets), len(which))
        self.done[places] = done.reshape(len(sets), len(which))
        if error is not None:
            raise error

    def _one_by_one(self, sets: list[int], which: list[int], count: Count | None) -> None:
        """Set after set, the recordings side by side."""
        finished = 0
        for p in sets:
            for rate in {self.recordings[r].rate for r in which}:
                same = [r for r in which if self.recordings[r].rate == rate]
                own = issubclass(self.filter, _own.OwnFilter)
                runs = [self.recordings[r] if own else keywords(self.recordings[r], self.dtype) for r in same]
                estimates = run_many(
                    self.filter(rate=rate, **self.sets[p], **self.settings), runs, threads=self.threads
                )
                for r, estimate in zip(same, estimates, strict=True):
                    self.errors[p, r] = self._function(estimate, self.recordings[r])
                    self.done[p, r] = True
                finished += len(same)
                if count is not None:
                    count(finished)


def checked(recordings: Iterable[Recording | Mapping[str, Any]], metric: Metric) -> list[Recording]:
    """The recordings, each given as one or as a dict of its fields; ``ValueError`` where one lacks the truth."""
    return [_recording(index, one, truth=not callable(metric)) for index, one in enumerate(recordings)]


def _recording(index: int, one: Recording | Mapping[str, Any], truth: bool) -> Recording:
    try:
        recording = one if isinstance(one, Recording) else Recording(**one)
    except (TypeError, ValueError) as error:
        raise ValueError(f"recording {index}: {error}") from None
    if truth and recording.ref is None:
        raise ValueError(f"recording {index}: expected ref, the true orientation, got None")
    return recording


def keywords(recording: Recording, dtype: DTypeLike) -> dict[str, Any]:
    """The measurements of a recording in a dtype, as `Filter.run` takes them."""
    sensors = {"gyr": recording.gyr, "acc": recording.acc, "mag": recording.mag}
    arrays = {name: None if array is None else array.astype(dtype, copy=False) for name, array in sensors.items()}
    return {**arrays, "t": recording.t}


def _trial(recording: Recording, dtype: DTypeLike) -> tuple[Any, ...]:
    """A recording for the native side; the truth is NaN where it does not count."""
    measured = keywords(recording, dtype)
    assert recording.ref is not None
    norm = np.linalg.norm(recording.ref, axis=1, keepdims=True)
    counted = norm > 0.0 if recording.mask is None else (norm > 0.0) & recording.mask[:, np.newaxis]
    ref = np.full(recording.ref.shape, np.nan)
    np.divide(recording.ref, norm, out=ref, where=counted)
    return measured["gyr"], measured["acc"], measured["mag"], recording.t, recording.rate, ref


def _score_of(metric: str) -> Callable[[Estimate, Recording], float]:
    """The function of a metric that has a name."""
    names = [field.name for field in fields(Score)]
    if metric not in names:
        raise ValueError(f"metric: expected one of {names}, got {metric!r}")

    def error(estimate: Estimate, recording: Recording) -> float:
        assert recording.ref is not None
        return float(getattr(score(estimate.quat, recording.ref, recording.mask), metric))

    return error
