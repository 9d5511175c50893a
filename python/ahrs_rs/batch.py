"""Many recordings of any length through one filter."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from typing import Any, Literal, overload

from ahrs_rs._filter import Filter, thread_count
from ahrs_rs._progress import progress_bar
from ahrs_rs.estimate import Estimate
from ahrs_rs.recording import Recording

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
    """Estimates of recordings of any lengths, in their order, computed on several threads.

    Parameters
    ----------
    f : the filter; it is not changed
    recordings : each a `Recording`, a dict of keyword arguments of ``Filter.run`` (gyr, acc, mag, t, q0, state,
        outputs, out), or a tuple (gyr, acc, mag)
    threads : how many recordings at once; by default as many as there are cores
    progress : show a progress bar, if standard error is a terminal
    errors : ``"raise"`` the first error, or ``"return"`` an exception in its recording's place

    The interpreter's lock is released while a recording is computed.
    """
    if errors not in ("raise", "return"):
        raise ValueError(f"errors: expected 'raise' or 'return', got {errors!r}")
    threads = thread_count(threads)
    items = list(recordings)
    with ThreadPoolExecutor(max_workers=threads or os.cpu_count()) as pool:
        try:
            futures: list[Future[Estimate]] = [pool.submit(_run_one, f, i, item) for i, item in enumerate(items)]
            for future in progress_bar(as_completed(futures), total=len(items), shown=progress):
                if errors == "raise":
                    future.result()
        except BaseException:
            # What has not begun is not wanted any more; what has ends within one recording.
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [future.exception() or future.result() for future in futures]


def _run_one(f: Filter, index: int, item: Measurements) -> Estimate:
    try:
        return f.run(**_keywords(item), threads=1)
    except ValueError as error:
        raise ValueError(f"recording {index}: {error}") from None


def _keywords(item: Measurements) -> dict[str, Any]:
    if isinstance(item, Recording):
        return {"gyr": item.gyr, "acc": item.acc, "mag": item.mag, "t": item.t}
    if isinstance(item, Mapping):
        return dict(item)
    if isinstance(item, (tuple, list)) and 1 <= len(item) <= 3:
        return dict(zip(("gyr", "acc", "mag"), item, strict=False))
    raise ValueError(f"expected a Recording, a dict or a tuple (gyr, acc, mag), got {type(item).__name__}")
