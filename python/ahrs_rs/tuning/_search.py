"""The two ways to search."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._cells import Metric
from ahrs_rs._engine import SETTINGS
from ahrs_rs._filter import Filter
from ahrs_rs._optional import require
from ahrs_rs._progress import progress_count
from ahrs_rs._recording import Recording
from ahrs_rs._sweep import require_class
from ahrs_rs.tuning._evaluate import Evaluator, TuningInterrupted
from ahrs_rs.tuning._result import Scores, Tuned
from ahrs_rs.tuning._space import Axis, Value, at, combinations, space

Params = Sequence[str] | Mapping[str, Any] | None
Test = float | Sequence[Recording] | None
Checkpoint = str | os.PathLike[str] | None


def grid(
    filter: type[Filter],
    params: Params | Iterable[Recording] = None,
    recordings: Iterable[Recording] | Params = (),
    *,
    points: int = 21,
    metric: Metric = "total",
    fixed: Mapping[str, Value] | None = None,
    test: Test = None,
    seed: int = 0,
    checkpoint: Checkpoint = None,
    progress: bool = False,
    **settings: Any,
) -> Tuned:
    """Try every combination of parameters.

    Parameters
    ----------
    filter : type
        The class, of ``ar.FILTERS``.
    params : mapping or sequence of str or iterable of Recording, optional
        Which parameters and where, as in `space`.
    recordings : iterable of Recording or mapping or sequence of str, optional
        With `ref`, unless the metric is a function.
    points : int, optional
        So many values of each number.
    metric : str or callable, optional
        As in `ahrs_rs.sweep`: ``"total"``, ``"heading"``, ``"inclination"``, or a function of an
        `Estimate` and a `Recording` (slower); the mean over the recordings is made small.
    fixed : mapping, optional
        Parameters that are held at other values than their defaults.
    test : float or sequence of Recording, optional
        Recordings on which the parameters are not chosen but judged, or which part of `recordings`
        is taken away for that, as 0.3: whole recordings, drawn by the seed.
    seed : int, optional
        Of the draw.
    checkpoint : path-like, optional
        A file in which the errors are kept while they are computed: the same call after an
        interruption goes on from it. A function as metric is known by its name only.
    progress : bool, optional
        Show a progress bar, if standard error is a terminal.
    **settings : object
        Threads, dtype, frame, declination and gyr_hold, as in `ahrs_rs.sweep`.

    Returns
    -------
    Tuned
        The parameters and their errors.

    Raises
    ------
    ValueError
        for parameters that the filter does not have, recordings without truth, a checkpoint of another search.
    TuningInterrupted
        for Ctrl-C.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.tuning.grid(ar.Madgwick, {"beta": (0.01, 1.0)}, [rec], points=5)
    >>> sorted(found.params)
    ['beta']
    """
    params, recordings = _in_order(params, recordings)
    filter = require_class(filter)
    axes = space(filter, params)
    sets = [{**(fixed or {}), **one} for one in combinations(axes, points)]

    def search(evaluator: Evaluator) -> list[float]:
        return [float(evaluator.means(sets).min())]

    parts = _split(recordings, test, seed)
    return _tune("grid", filter, parts, metric, fixed, seed, checkpoint, progress, settings, len(sets), search)


def evolve(
    filter: type[Filter],
    params: Params | Iterable[Recording] = None,
    recordings: Iterable[Recording] | Params = (),
    *,
    population: int = 15,
    generations: int = 50,
    tolerance: float = 1e-3,
    metric: Metric = "total",
    fixed: Mapping[str, Value] | None = None,
    test: Test = None,
    seed: int = 0,
    checkpoint: Checkpoint = None,
    progress: bool = False,
    **settings: Any,
) -> Tuned:
    """Search genetically: differential evolution (Storn & Price 1997), by `scipy.optimize.differential_evolution`.

    Parameters as in `grid`, and

    Parameters
    ----------
    filter : type
        The class, of ``ar.FILTERS``.
    params : mapping or sequence of str or iterable of Recording, optional
        Which parameters and where, as in `space`.
    recordings : iterable of Recording or mapping or sequence of str, optional
        With `ref`, unless the metric is a function.
    population : int, optional
        So many sets for each parameter; a generation is computed at once.
    generations : int, optional
        At most.
    tolerance : float, optional
        The search ends earlier where the errors of a generation differ by less than this part of
        their mean.
    metric : str or callable, optional
        As in `ahrs_rs.sweep`.
    fixed : mapping, optional
        Parameters that are held at other values than their defaults.
    test : float or sequence of Recording, optional
        Recordings for the test, or which part of `recordings` is taken away for it.
    seed : int, optional
        Of the search, and of the draw of the test recordings.
    checkpoint : path-like, optional
        A file in which the errors are kept.
    progress : bool, optional
        Show a progress bar, if standard error is a terminal.
    **settings : object
        Threads, dtype, frame, declination, gyr_hold, as in `ahrs_rs.sweep`.

    Returns
    -------
    Tuned
        The parameters and their errors.

    Notes
    -----
    The defaults are tried first, and are in the first generation if they are within the ranges.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> found = ar.tuning.evolve(ar.Madgwick, ["beta"], [rec], generations=1, population=4)
    >>> sorted(found.params)
    []
    """
    params, recordings = _in_order(params, recordings)
    filter = require_class(filter)
    axes = space(filter, params)
    sets = 1 + (generations + 1) * max(population * len(axes), 5)

    def search(evaluator: Evaluator) -> list[float]:
        return _evolve(evaluator, filter, axes, fixed or {}, population, generations, tolerance, seed)

    parts = _split(recordings, test, seed)
    return _tune("evolve", filter, parts, metric, fixed, seed, checkpoint, progress, settings, sets, search)


def _evolve(
    evaluator: Evaluator,
    filter: type[Filter],
    axes: Sequence[Axis],
    fixed: Mapping[str, Value],
    population: int,
    generations: int,
    tolerance: float,
    seed: int,
) -> list[float]:
    optimize = require("scipy.optimize", "scipy", "tuning.evolve needs")
    search: Any = optimize.differential_evolution  # whose type does not know what vectorized=True changes
    history: list[float] = []

    def energies(coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
        columns = coordinates.T if coordinates.ndim == 2 else coordinates[np.newaxis]
        means = evaluator.means([{**fixed, **at(axes, each)} for each in columns])
        history.append(min(float(means.min()), history[-1] if history else np.inf))
        return means if coordinates.ndim == 2 else means[0]

    evaluator.means([dict(fixed)])  # what is wrong with recordings or metric shows here, not within scipy
    start = [axis.coordinate(filter.PARAMS[axis.name].default) for axis in axes]
    minimise = partial(
        search,
        energies,
        [axis.bounds for axis in axes],
        maxiter=generations,
        popsize=population,
        tol=tolerance,
        rng=np.random.default_rng(seed),
        polish=False,  # its gradients would be computed one set after the other
        vectorized=True,
        updating="deferred",
        integrality=[axis.options is not None for axis in axes],
        x0=None if None in start else start,
    )
    try:
        minimise()
    except RuntimeError as error:  # scipy puts a metric's ValueError under one that blames the mapping
        raise error.__cause__ or error from None
    return history


def _in_order(
    params: Params | Iterable[Recording], recordings: Iterable[Recording] | Params
) -> tuple[Params, Iterable[Recording]]:
    """Parameters and recordings, also where they come in the order of version 0.0, which their types tell."""
    if _is_params(params):
        return cast(Params, params), cast("Iterable[Recording]", recordings)
    warnings.warn(
        "params: expected before recordings, as in ahrs_rs.sweep; the old order will be an error",
        DeprecationWarning,
        stacklevel=3,
    )
    # Parameters that were not given are an empty tuple here.
    return cast(Params, recordings or None), cast("Iterable[Recording]", params)


def _is_params(value: object) -> bool:
    if value is None or isinstance(value, (str, Mapping)):
        return True
    return isinstance(value, Sequence) and all(isinstance(each, str) for each in value)


def _split(recordings: Iterable[Recording], test: Test, seed: int) -> tuple[list[Recording], list[int], list[int]]:
    """All recordings, and which of them are for the choice and for the test."""
    every = list(recordings)
    if not every:
        raise ValueError("recordings: expected at least one, got none")
    if test is None:
        return every, list(range(len(every))), []
    if not isinstance(test, (int, float)):
        others = list(test)
        count = len(every)
        return every + others, list(range(count)), list(range(count, count + len(others)))
    if not 0.0 < test < 1.0:
        raise ValueError(f"test: expected a part between 0 and 1, or recordings, got {test}")
    if len(every) < 2:
        raise ValueError("test: expected two recordings or more, of which some can be taken away; cut the one in two")
    count = max(int(test * len(every)), 1)
    order = np.random.default_rng(seed).permutation(len(every)).tolist()
    return every, sorted(order[count:]), sorted(order[:count])


def _tune(
    method: str,
    filter: type[Filter],
    parts: tuple[list[Recording], list[int], list[int]],
    metric: Metric,
    fixed: Mapping[str, Value] | None,
    seed: int,
    checkpoint: Checkpoint,
    progress: bool,
    settings: Mapping[str, Any],
    total: int,
    search: Callable[[Evaluator], list[float]],
) -> Tuned:
    every, train, test = parts
    known = ("threads", "dtype", *SETTINGS)
    wrong = [name for name in settings if name not in known]
    if wrong:
        raise TypeError(f"{method} has no argument {wrong[0]!r}; settings are {', '.join(known)}")

    def evaluator(which: list[int], path: Checkpoint, count: Callable[[int], object] | None) -> Evaluator:
        return Evaluator(filter, [every[index] for index in which], metric, settings, path, count)

    with progress_count(total=total, shown=progress, unit="set") as count:
        chosen = evaluator(train, checkpoint, count)
        with _interruptible(chosen):
            history = search(chosen)
            best, evaluated = chosen.best(), len(chosen.asked)
            judges = {"train": (train, chosen), "test": (test, evaluator(test, None, None))}
            scores = {
                name: Scores(which, judge.errors(best), judge.errors(dict(fixed or {})))
                for name, (which, judge) in judges.items()
                if which
            }
    name = metric if isinstance(metric, str) else getattr(metric, "__name__", "metric")
    return Tuned(filter.NAME, best, name, method, seed, evaluated, scores["train"], scores.get("test"), history)


@contextmanager
def _interruptible(evaluator: Evaluator) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        raise TuningInterrupted(len(evaluator.known), evaluator.path) from None
