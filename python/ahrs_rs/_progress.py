"""Progress of long work, on a terminal only."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")


def progress_bar(items: Iterable[T], total: int, *, shown: bool = True, unit: str = "recording") -> Iterator[T]:
    """The items; a bar on standard error counts them if it is a terminal and there is more than one."""
    if not (shown and total > 1 and sys.stderr.isatty()):
        return iter(items)
    from tqdm import tqdm

    return iter(tqdm(items, total=total, unit=unit, leave=False))


@contextmanager
def progress_count(total: int, *, shown: bool, unit: str) -> Iterator[Callable[[int], None] | None]:
    """A function to be told how many are finished, or None where nobody looks: see `progress_bar`."""
    if not (shown and total > 1 and sys.stderr.isatty()):
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=total, unit=unit, leave=False) as bar:

        def count(finished: int) -> None:
            bar.update(finished - bar.n)

        yield count


def counting_on(count: Callable[[int], object] | None, before: int) -> Callable[[int], object] | None:
    """The function for a part of the work, before which some were finished."""

    def on(finished: int) -> None:
        if count is not None:
            count(before + finished)

    return None if count is None else on
