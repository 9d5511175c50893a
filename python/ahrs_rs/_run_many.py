"""Many recordings of any length through one filter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Literal, overload

from ahrs_rs import _own
from ahrs_rs._engine import Call
from ahrs_rs._estimate import Estimate
from ahrs_rs._filter import Filter
from ahrs_rs._progress import counting_on, progress_count
from ahrs_rs._recording import Recording
from ahrs_rs._validate import thread_count

Measurements = Recording | Mapping[str, Any] | tuple[Any, ...]


@overload
def run_many(
    f: Filter,
    recordings: Iterable[Measurements],
    *,
    threads: int | None = None,
    progress: bool = False,
    errors: Literal["raise"] = "raise",
) -> list[Estimate]: ...
@overload
def run_many(
    f: Filter,
    recordings: Iterable[Measurements],
    *,
    threads: int | None = None,
    progress: bool = False,
    errors: Literal["return"],
) -> list[Estimate | Exception]: ...
def run_many(
    f: Filter,
    recordings: Iterable[Measurements],
    *,
    threads: int | None = None,
    progress: bool = False,
    errors: str = "raise",
) -> list[Any]:
    """Estimates of recordings of any lengths, in their order, computed side by side in the lanes of all cores.

    Parameters
    ----------
    f : Filter
        The filter; it is not changed. Or one of your own, as `ahrs_rs.register` takes them.
    recordings : iterable of Recording, mapping or tuple
        Each a `Recording`, a dict of keyword arguments of ``Filter.run`` (gyr, acc, mag, t, q0,
        state, outputs, out), or a tuple (gyr, acc, mag).
    threads : int, optional
        How many recordings at once; by default as many as there are cores and as the work pays for.
    progress : bool, optional
        Show a progress bar, if standard error is a terminal.
    errors : str, optional
        ``"raise"`` the first error, or ``"return"`` an exception in its recording's place.

    Returns
    -------
    list of Estimate
        An estimate for each recording, or its exception where asked for.

    Notes
    -----
    The interpreter's lock is released while a recording is computed.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> ests = ar.run_many(ar.Madgwick(rate=100.0), [rec, rec])
    >>> len(ests), ests[0].quat.shape
    (2, (500, 4))
    """
    if errors not in ("raise", "return"):
        raise ValueError(f"errors: expected 'raise' or 'return', got {errors!r}")
    if not isinstance(f, Filter) and _own.is_own(f):
        return _run_own(_own.made(f), recordings, progress, errors)
    if not isinstance(f, Filter):
        if isinstance(f, type) and issubclass(f, Filter):
            raise TypeError(f"f: expected a filter, as {f.__name__}(rate=100.0), got the class {f.__name__}")
        raise TypeError(f"f: expected a filter, as ar.Madgwick(rate=100.0), got {type(f).__name__}")
    if isinstance(recordings, Recording):
        raise TypeError("recordings: expected a list of them, got a single Recording: f.run(recording) takes it")
    threads = thread_count(threads)
    items = list(recordings)
    results: list[Any] = [None] * len(items)
    calls: dict[str, list[tuple[int, Call]]] = {"float64": [], "float32": []}
    for index, item in enumerate(items):
        try:
            call = f._call(**_keywords(item))
            calls[call.dtype].append((index, call))
        except (TypeError, ValueError) as error:
            results[index] = _named(index, error)
            if errors == "raise":
                raise results[index] from None
    with progress_count(total=len(items), shown=progress, unit="recording") as count:
        done = 0
        for dtype, group in calls.items():
            native = [call.native for _, call in group]
            found = f._run(native, threads, dtype == "float32", counting_on(count, done), False)
            for (index, call), result in zip(group, found, strict=True):
                wrong = isinstance(result, Exception)
                results[index] = _named(index, result) if wrong else f._estimate(call, result)
            done += len(group)
    failed = [result for result in results if isinstance(result, Exception)]
    if errors == "raise" and failed:
        raise failed[0]
    return results


def _run_own(
    f: _own.OwnFilter, recordings: Iterable[Measurements], progress: bool, errors: str
) -> list[Estimate | Exception]:
    """The same for a filter of a user's own, one recording after the other."""
    if isinstance(recordings, Recording):
        raise TypeError("recordings: expected a list of them, got a single Recording: f.run(recording) takes it")
    items = list(recordings)
    results: list[Estimate | Exception] = []
    with progress_count(total=len(items), shown=progress, unit="recording") as count:
        for index, item in enumerate(items):
            try:
                results.append(f.run(**_keywords(item)))
            except Exception as error:
                if errors == "raise":
                    raise _named(index, error) from error
                results.append(_named(index, error))
            if count:
                count(index + 1)
    return results


def _named(index: int, error: Exception) -> Exception:
    """The error with the recording that it is about."""
    return ValueError(f"recording {index}: {error}") if isinstance(error, ValueError) else error


def _keywords(item: Measurements) -> dict[str, Any]:
    if isinstance(item, Recording):
        return {"gyr": item}
    if isinstance(item, Mapping):
        return dict(item)
    if isinstance(item, (tuple, list)) and 1 <= len(item) <= 3:
        return dict(zip(("gyr", "acc", "mag"), item, strict=False))
    raise ValueError(f"expected a Recording, a dict or a tuple (gyr, acc, mag), got {type(item).__name__}")
