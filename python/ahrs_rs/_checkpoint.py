"""Errors of parameter sets in a file that grows while they are computed, and outlives what ends the process."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ahrs_rs import _atomic, _json
from ahrs_rs._cells import Metric
from ahrs_rs._filter import Filter
from ahrs_rs._recording import Recording
from ahrs_rs._typing import BoolArray, FloatArray
from ahrs_rs._version import __version__


class Checkpoint:
    """A file of JSON lines: what the errors depend on, then for each set its key and its errors, null where not known.

    Lines are added only, and are on the disk when that returns. A line that was torn is left out: what it had is
    computed again. A set may have several lines, each with errors that were not known before.

    Parameters
    ----------
    path : of the file, which is begun if it is not there
    job : what the errors depend on, as `job` gives it
    count : R, errors of a set

    Raises
    ------
    ValueError
        The file is of another job, or holds a line that is none of ours.
    """

    def __init__(self, path: str | os.PathLike[str], job: Mapping[str, Any], count: int) -> None:
        self.path = Path(path)
        self.count = count
        self._rows: dict[str, tuple[FloatArray, BoolArray]] = {}
        self._torn = False
        head = json.dumps(job)
        content = self.path.read_bytes() if self.path.exists() else b""
        first, newline, rest = content.partition(b"\n")
        if not newline and head.encode().startswith(first):  # nothing, or a head that was cut off
            _atomic.write_text(self.path, head + "\n")
        elif first != head.encode():
            raise ValueError(f"checkpoint: {self.path} is of another search (filter, metric, recordings or settings)")
        else:
            for number, line in enumerate(rest.split(b"\n"), start=2):
                self._take(number, line)
            self._torn = bool(content) and not content.endswith(b"\n")

    def row(self, key: str) -> tuple[FloatArray, BoolArray]:
        """(R,) the errors of a set, and which of them are known; of the caller."""
        errors, done = self._rows.get(key, (np.full(self.count, np.nan), np.zeros(self.count, dtype=bool)))
        return errors.copy(), done.copy()

    def rows(self) -> Iterable[tuple[str, FloatArray]]:
        """The sets of which all errors are known."""
        return [(key, errors) for key, (errors, done) in self._rows.items() if done.all()]

    def add(self, key_errors_done: Iterable[tuple[str, FloatArray, BoolArray]]) -> None:
        """Write down what of these errors is known and is not in the file."""
        lines = []
        for key, errors, done in key_errors_done:
            known, before = self.row(key)
            new = done & ~before
            if new.any():
                lines.append(json.dumps([key, [float(x) if one else None for x, one in zip(errors, new, strict=True)]]))
                known[new] = errors[new]
                self._rows[key] = known, before | new
        if lines:
            # One piece, so that at most its end is torn.
            _atomic.append(self.path, "\n" * self._torn + "\n".join(lines) + "\n")
            self._torn = False

    def _take(self, number: int, line: bytes) -> None:
        try:
            content = _json.parse(line)
        except ValueError:  # torn, or none
            return
        match content:
            case [str() as key, list() as errors] if len(errors) == self.count and all(
                isinstance(one, float | None) for one in errors
            ):
                known, before = self.row(key)
                done = np.array([one is not None for one in errors])
                known[done] = [one for one in errors if one is not None]
                self._rows[key] = known, before | done
            case _:
                raise ValueError(f"checkpoint: {self.path}: expected a set and {self.count} errors in line {number}")


def job(
    format: str, filter: type[Filter], metric: Metric, settings: Mapping[str, Any], recordings: Iterable[Recording]
) -> dict[str, Any]:
    """What errors depend on, beside the parameters."""
    return {
        "format": format,
        "version": __version__,
        "filter": filter.NAME,
        "metric": metric if isinstance(metric, str) else f"function {getattr(metric, '__name__', '')}",
        "settings": {name: str(value) for name, value in settings.items() if name != "threads"},
        "recordings": [_digest(one) for one in recordings],
    }


def digest(parts: Iterable[bytes]) -> str:
    """A short text that differs where a byte does."""
    import hashlib  # here: the package is imported without it

    made = hashlib.sha256()
    for part in parts:
        made.update(part)
    return made.hexdigest()[:16]


def _digest(recording: Recording) -> str:
    arrays = ((name, getattr(recording, name)) for name in ("t", "gyr", "acc", "mag", "ref", "mask"))
    parts = (name.encode() if array is None else np.ascontiguousarray(array).tobytes() for name, array in arrays)
    return digest([repr(recording.rate).encode(), *parts])
