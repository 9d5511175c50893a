"""Many parameter sets over many recordings."""

from __future__ import annotations

import itertools
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ahrs_rs import _html, _own
from ahrs_rs._cells import Cells, Metric, checked
from ahrs_rs._checkpoint import Checkpoint, digest, job
from ahrs_rs._dataframe import Table, data_frame
from ahrs_rs._filter import Filter
from ahrs_rs._progress import progress_count
from ahrs_rs._recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Sweep", "SweepInterrupted", "sweep"]

FORMAT = "ahrs_rs.sweep checkpoint"

Grid = Mapping[str, ArrayLike] | Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True, eq=False)
class Sweep(Table):
    """Errors of parameter sets over recordings.

    Parameters
    ----------
    filter : str
        The name of the filter.
    params : list of dict
        What was given of each parameter set, P of them.
    metric : str
        What the errors are: the root mean square in degrees of "total", "heading" or "inclination",
        or the name of a function.
    errors : ndarray
        (P, R), NaN where a recording has no sample that counts, and where `done` is False.
    done : ndarray
        (P, R), False where the sweep was interrupted before.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.sweep(ar.Madgwick, {"beta": [0.02, 0.05, 0.1]}, [rec])
    >>> found.errors.shape
    (3, 1)
    >>> sorted(found.best)
    ['beta']
    """

    filter: str
    params: list[dict[str, Any]]
    metric: str
    errors: NDArray[np.float64]
    done: NDArray[np.bool_]

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

        Returns
        -------
        polars.DataFrame or pandas.DataFrame
            A row an error.
        """
        return data_frame(self._columns())

    def _columns(self) -> dict[str, Any]:
        sets, recordings = self.errors.shape
        columns: dict[str, Any] = {
            name: [one.get(name) for one in self.params for _ in range(recordings)] for name in _names(self.params)
        }
        columns["recording"] = np.tile(np.arange(recordings), sets)
        columns["error"] = self.errors.reshape(-1)
        return columns

    def plot(self, params: str | Sequence[str] | None = None, *, ax: Axes | None = None) -> Axes:
        """Draw the errors over one parameter (each recording and the mean), or the mean over two of them in colours.

        Parameters
        ----------
        params : str or sequence of str, optional
            One or two; by default the first two that have several values.
        ax : Axes, optional
            Where to draw; by default on a new figure.

        Returns
        -------
        Axes
            With lines, or with a map and its colour bar.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        ValueError
            Parameters that were not swept, or more than two.
        """
        from ahrs_rs import plots  # for drawing only

        return plots.sweep(self, params, ax=ax)

    def _repr_html_(self) -> str:
        sets, recordings = self.errors.shape
        rows: list[tuple[str, object]] = [
            ("filter", self.filter),
            ("parameter sets", sets),
            ("recordings", recordings),
            ("done", f"{int(self.done.sum())} of {self.done.size}"),
        ]
        if not np.isnan(self.mean).all():
            best = ", ".join(
                f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}"
                for name, value in self.best.items()
            )
            rows.append(("best", f"{best}: {_html.number(float(np.nanmin(self.mean)))} ({self.metric})"))
        return _html.summary("Sweep", rows)


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep; what was done is in `partial`, and ``sweep(..., resume=partial)`` goes on from it.

    With a checkpoint the same call goes on from there.

    Parameters
    ----------
    partial : Sweep
        What was done.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> issubclass(ar.SweepInterrupted, KeyboardInterrupt)
    True
    """

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
    checkpoint: str | os.PathLike[str] | None = None,
    frame: str = "ENU",
    declination: float = 0.0,
    gyr_hold: str = "zero-order",
    repeated: str = "new",
    gyr_range: float = 0.0,
) -> Sweep:
    """Errors of every parameter set over every recording: parameter sets are computed side by side in vector registers.

    Parameters
    ----------
    filter : type
        The class, of ``ar.FILTERS``, or a class or function of your own, as `ahrs_rs.register` takes
        them.
    grid : mapping or list of mapping
        A dict of values for each parameter, of which every combination is taken (the last parameter
        changes fastest), or a list of dicts; what is not named has its default.
    recordings : iterable of Recording or mapping
        Each a `Recording` with `ref`, or a dict of its fields.
    metric : str or callable, optional
        The error whose root mean square over the samples of ``mask`` is wanted, as in
        `metrics.score`: ``"total"``, ``"heading"`` or ``"inclination"``, in degrees; or a function
        of an `Estimate` and a `Recording`.
    threads : int, optional
        By default as many as there are cores.
    progress : bool or callable, optional
        Show a progress bar, if standard error is a terminal; or a function that is called with how
        many errors are done and how many there are.
    dtype : data-type, optional
        ``float32`` or ``float64``, in which the filter computes.
    resume : Sweep, optional
        A sweep that was interrupted: what it has is taken over.
    checkpoint : str or path-like, optional
        A file in which the errors are kept while they are computed, every second or so: the same
        call goes on from it after whatever has ended the process. A function as metric is known by
        its name only.
    frame, declination, gyr_hold, repeated, gyr_range : str, optional
        As for the filter; `ref` stands in the same frame.

    Returns
    -------
    Sweep
        The errors, (P, R).

    Raises
    ------
    ValueError
        for values that a parameter does not take, recordings without truth, a `resume` or `checkpoint` of another
        sweep.
    SweepInterrupted
        for Ctrl-C; nothing of what was done is lost.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.sweep(ar.Madgwick, {"beta": [0.02, 0.05, 0.1]}, [rec])
    >>> found.errors.shape
    (3, 1)
    """
    filter = require_class(filter)
    if not isinstance(grid, Mapping) and any(isinstance(each, Recording) for each in grid):
        raise TypeError(
            "grid: expected a dict of values or a list of dicts, got recordings: sweep(filter, grid, recordings)"
        )
    sets = parameter_sets(filter, grid)
    trials = checked(recordings, metric)
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
    cells = Cells(
        filter,
        sets,
        trials,
        metric,
        result.errors,
        result.done,
        None if checkpoint is None else _kept(checkpoint, result, filter, trials, metric, dtype, settings),
        threads=threads,
        dtype=dtype,
        **settings,
    )
    shown = progress if isinstance(progress, bool) else False
    with progress_count(total=result.done.size, shown=shown, unit="error") as bar:

        def count(finished: int) -> None:
            if bar:
                bar(finished)
            if callable(progress):
                progress(finished, result.done.size)

        try:
            cells.compute(count)
        except KeyboardInterrupt:
            raise SweepInterrupted(result) from None
        count(int(result.done.sum()))
    return result


def require_class(filter: object) -> type[Filter]:
    """The class of a filter; a ``TypeError`` that says what to give, if it is none. Own ones are made to such."""
    if isinstance(filter, Filter):
        name = type(filter).__name__
        raise TypeError(f"filter: expected the class, as ar.{name}, got an instance: its parameters go into the grid")
    if not (isinstance(filter, type) and issubclass(filter, Filter) and hasattr(filter, "NAME")):
        return cast("type[Filter]", _own.own_class(filter))
    return filter


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


def _kept(
    path: str | os.PathLike[str],
    result: Sweep,
    filter: type[Filter],
    trials: Sequence[Recording],
    metric: Metric,
    dtype: DTypeLike,
    settings: Mapping[str, Any],
) -> Callable[[Sequence[int]], object]:
    """Takes over what the checkpoint has; gives what writes down the rest."""
    values = digest(json.dumps(filter._encoded(one)).encode() for one in result.params)
    own = job(FORMAT, filter, metric, {**settings, "dtype": np.dtype(dtype).name}, trials) | {"sets": values}
    kept = Checkpoint(path, own, len(trials))
    for p, (errors, done) in enumerate(zip(result.errors, result.done, strict=True)):
        before, known = kept.row(str(p))
        errors[known], done[known] = before[known], True
    return lambda sets: kept.add((str(p), result.errors[p], result.done[p]) for p in sets)


def _names(params: list[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(name for one in params for name in one))


def _smallest(errors: NDArray[np.float64]) -> int:
    if np.isnan(errors).all():
        raise ValueError("no parameter set has an error: nothing is done, or no sample counts")
    return int(np.nanargmin(errors))
