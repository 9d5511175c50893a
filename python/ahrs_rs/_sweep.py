"""Many parameter sets over many recordings."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ahrs_rs._filter import Filter, thread_count
from ahrs_rs._frame import data_frame
from ahrs_rs._progress import counting_on, progress_count
from ahrs_rs.batch import run_many
from ahrs_rs.estimate import Estimate
from ahrs_rs.metrics import Score, score
from ahrs_rs.recording import Recording

__all__ = ["Sweep", "SweepInterrupted", "sweep"]

Metric = str | Callable[[Estimate, Recording], float]
Grid = Mapping[str, ArrayLike] | Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Errors of parameter sets over recordings."""

    filter: str
    """The name of the filter."""
    params: list[dict[str, Any]]
    """What was given of each parameter set, P of them."""
    metric: str
    """What the errors are: the root mean square in degrees of "total", "heading" or "inclination", or the name of a
    function."""
    errors: NDArray[np.float64]
    """(P, R), NaN where a recording has no sample that counts, and where `done` is False."""
    done: NDArray[np.bool_]
    """(P, R), False where the sweep was interrupted before."""

    @property
    def mean(self) -> NDArray[np.float64]:
        """(P,) mean of the errors over the recordings that have one; NaN where a set is not done."""
        counted = ~np.isnan(self.errors)
        count = counted.sum(axis=1)
        mean = np.full(len(self.errors), np.nan)
        np.divide(np.where(counted, self.errors, 0.0).sum(axis=1), count, out=mean, where=count > 0)
        return np.where(self.done.all(axis=1), mean, np.nan)

    @property
    def best(self) -> dict[str, Any]:
        """The parameters with the smallest mean error: one setting for all recordings."""
        return self.params[_smallest(self.mean)]

    @property
    def best_each(self) -> list[dict[str, Any]]:
        """The parameters with the smallest error of each recording, R of them."""
        return [self.params[_smallest(errors)] for errors in self.errors.T]

    def to_frame(self) -> Any:
        """A polars or pandas DataFrame, whichever is installed, a row an error.

        Columns: those of the parameters, then ``recording`` (index) and ``error`` (deg).
        """
        sets, recordings = self.errors.shape
        columns: dict[str, Any] = {
            name: [one.get(name) for one in self.params for _ in range(recordings)] for name in _names(self.params)
        }
        columns["recording"] = np.tile(np.arange(recordings), sets)
        columns["error"] = self.errors.reshape(-1)
        return data_frame(columns)


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep; what was done is in `partial`, and ``sweep(..., resume=partial)`` goes on from it."""

    def __init__(self, partial: Sweep) -> None:
        super().__init__(f"sweep interrupted: {int(partial.done.sum())} of {partial.done.size} errors are done")
        self.partial = partial


def sweep(
    filter: type[Filter],
    grid: Grid,
    recordings: Iterable[Recording | Mapping[str, Any]],
    metric: Metric = "total",
    *,
    threads: int | None = None,
    progress: bool | Callable[[int, int], object] = False,
    dtype: DTypeLike = np.float64,
    resume: Sweep | None = None,
    frame: str = "ENU",
    declination: float = 0.0,
    gyr_hold: str = "zero-order",
    repeated: str = "new",
    gyr_range: float = 0.0,
) -> Sweep:
    """Errors of every parameter set over every recording: parameter sets are computed side by side in vector registers.

    Parameters
    ----------
    filter : the class, of ``ar.FILTERS``
    grid : a dict of values for each parameter, of which every combination is taken (the last parameter changes
        fastest), or a list of dicts; what is not named has its default
    recordings : each a `Recording` with `ref`, or a dict of its fields
    metric : the error whose root mean square over the samples of ``mask`` is wanted, as in `metrics.score`:
        ``"total"``, ``"heading"`` or ``"inclination"``, in degrees; or a function of an `Estimate` and a `Recording`
    threads : by default as many as there are cores
    progress : show a progress bar, if standard error is a terminal; or a function that is called with how many errors
        are done and how many there are
    dtype : ``float32`` or ``float64``, in which the filter computes
    resume : a sweep that was interrupted: what it has is taken over
    frame, declination, gyr_hold, repeated, gyr_range : as for the filter; `ref` stands in the same frame

    Raises
    ------
    ValueError
        for values that a parameter does not take, recordings without truth, a `resume` of another sweep.
    SweepInterrupted
        for Ctrl-C; nothing of what was done is lost.
    """
    sets = parameter_sets(filter, grid)
    trials = [_recording(index, one, truth=not callable(metric)) for index, one in enumerate(recordings)]
    name = metric if isinstance(metric, str) else getattr(metric, "__name__", "metric")
    shape = (len(sets), len(trials))
    result = Sweep(filter.NAME, sets, name, np.full(shape, np.nan), np.zeros(shape, dtype=bool))
    if resume is not None:
        if (resume.filter, resume.params, resume.metric, resume.errors.shape) != (filter.NAME, sets, name, shape):
            raise ValueError("resume: expected a sweep of the same filter, grid, metric and recordings, got another")
        result.errors[:], result.done[:] = resume.errors, resume.done
    settings: dict[str, Any] = {"frame": frame, "declination": declination, "gyr_hold": gyr_hold, "repeated": repeated}
    if gyr_range:  # else a parameter of that name is swept
        settings["gyr_range"] = gyr_range
    threads = thread_count(threads)
    shown = progress if isinstance(progress, bool) else False
    with progress_count(total=result.done.size, shown=shown, unit="error") as bar:

        def count(finished: int) -> None:
            if bar:
                bar(finished)
            if callable(progress):
                progress(finished, result.done.size)

        try:
            if callable(metric):
                _by_function(result, filter, settings, trials, metric, threads, dtype, count)
            elif not filter.STREAMING:
                _by_function(result, filter, settings, trials, _score_of(metric), threads, dtype, count)
            else:
                _by_name(result, filter, settings, trials, threads, dtype, count)
        except KeyboardInterrupt:
            raise SweepInterrupted(result) from None
        count(int(result.done.sum()))
    return result


def parameter_sets(filter: type[Filter], grid: Grid) -> list[dict[str, Any]]:
    """The parameter sets of a grid, checked."""
    if isinstance(grid, Mapping):
        values = [np.atleast_1d(np.asarray(each)).tolist() for each in grid.values()]
        sets = [dict(zip(grid, each, strict=True)) for each in itertools.product(*values)]
    else:
        sets = [dict(each) for each in grid]
    for one in sets:
        filter._encoded(one)
    return sets


def _by_name(
    result: Sweep,
    filter: type[Filter],
    settings: dict[str, Any],
    trials: list[Recording],
    threads: int | None,
    dtype: DTypeLike,
    count: Callable[[int], object],
) -> None:
    """Fills in what is not done, by the native engine."""
    values = [filter._encoded(one) for one in result.params]
    native = [_trial(one, dtype) for one in trials]
    # What is missing is the same for most recordings: all of it, or none.
    for missing in {tuple(np.flatnonzero(~done)) for done in result.done.T}:
        which = [r for r, done in enumerate(result.done.T) if tuple(np.flatnonzero(~done)) == missing]
        if not missing:
            continue
        made = filter(**settings)
        errors, done, error = made._sweep(
            [values[p] for p in missing],
            [native[r] for r in which],
            result.metric,
            threads,
            np.dtype(dtype) == np.float32,
            counting_on(count, int(result.done.sum())),
        )
        places = np.ix_(np.array(missing), np.array(which))
        result.errors[places] = np.degrees(errors).reshape(len(missing), len(which))
        result.done[places] = done.reshape(len(missing), len(which))
        if error is not None:
            raise error


def _by_function(
    result: Sweep,
    filter: type[Filter],
    settings: dict[str, Any],
    trials: list[Recording],
    metric: Callable[[Estimate, Recording], float],
    threads: int | None,
    dtype: DTypeLike,
    count: Callable[[int], object],
) -> None:
    """Fills in what is not done, set after set, the recordings side by side."""
    for p, one in enumerate(result.params):
        for rate in {recording.rate for recording in trials}:
            which = [r for r, recording in enumerate(trials) if recording.rate == rate and not result.done[p, r]]
            runs = [_keywords(trials[r], dtype) for r in which]
            estimates = run_many(filter(rate=rate, **one, **settings), runs, threads=threads)
            for r, estimate in zip(which, estimates, strict=True):
                result.errors[p, r] = metric(estimate, trials[r])
                result.done[p, r] = True
        count(int(result.done.sum()))


def _score_of(metric: str) -> Callable[[Estimate, Recording], float]:
    """The function of a metric that has a name."""
    names = [field.name for field in fields(Score)]
    if metric not in names:
        raise ValueError(f"metric: expected one of {names}, got {metric!r}")

    def error(estimate: Estimate, recording: Recording) -> float:
        assert recording.ref is not None
        return float(getattr(score(estimate.quat, recording.ref, recording.mask), metric))

    return error


def _recording(index: int, one: Recording | Mapping[str, Any], truth: bool) -> Recording:
    try:
        recording = one if isinstance(one, Recording) else Recording(**one)
    except (TypeError, ValueError) as error:
        raise ValueError(f"recording {index}: {error}") from None
    if truth and recording.ref is None:
        raise ValueError(f"recording {index}: expected ref, the true orientation, got None")
    return recording


def _keywords(recording: Recording, dtype: DTypeLike) -> dict[str, Any]:
    sensors = {"gyr": recording.gyr, "acc": recording.acc, "mag": recording.mag}
    arrays = {name: None if array is None else array.astype(dtype, copy=False) for name, array in sensors.items()}
    return {**arrays, "t": recording.t}


def _trial(recording: Recording, dtype: DTypeLike) -> tuple[Any, ...]:
    """A recording for the native side; the truth is NaN where it does not count."""
    keywords = _keywords(recording, dtype)
    assert recording.ref is not None
    norm = np.linalg.norm(recording.ref, axis=1, keepdims=True)
    counted = norm > 0.0 if recording.mask is None else (norm > 0.0) & recording.mask[:, np.newaxis]
    ref = np.full(recording.ref.shape, np.nan)
    np.divide(recording.ref, norm, out=ref, where=counted)
    return keywords["gyr"], keywords["acc"], keywords["mag"], recording.t, recording.rate, ref


def _names(params: list[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(name for one in params for name in one))


def _smallest(errors: NDArray[np.float64]) -> int:
    if np.isnan(errors).all():
        raise ValueError("no parameter set has an error: nothing is done, or no sample counts")
    return int(np.nanargmin(errors))
