"""Orientations that another program has computed, as a filter."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._own_calls import TO_ENU
from ahrs_rs._recording import Recording
from ahrs_rs._streams import Stream
from ahrs_rs._validate import choice, number
from ahrs_rs._warnings import DataWarning

__all__ = ["Finished"]


class Finished:
    """Orientations that another program has computed, from files: a filter that only reads them.

    Parameters
    ----------
    files : str, path-like or mapping
        A file of any format that `ahrs_rs.read` reads, with orientations; in its name ``{stem}`` stands for
        the recording's name without its ending. Or a dict from such names to files.
    name : str, optional
        Of the filter, for tables.
    frame : str, optional
        The earth frame of the orientations.
    offset : float, optional
        S, added to their times.
    options : mapping, optional
        Keywords of `ahrs_rs.read`, as ``units`` and ``columns``.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> rec.meta["path"] = "walk.csv"
    >>> with TemporaryDirectory() as folder:
    ...     ar.write_estimate(Path(folder, "walk-other.csv"), rec.t, rec.ref)
    ...     (est,) = ar.run_many(ar.Finished(Path(folder, "{stem}-other.csv")), [rec])
    >>> round(ar.metrics.score(est.quat, rec.ref).total, 6)
    0.0
    """

    def __init__(
        self,
        files: str | os.PathLike[str] | Mapping[str, str | os.PathLike[str]],
        *,
        name: str = "Finished",
        frame: str = "ENU",
        offset: float = 0.0,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        self.files = files if isinstance(files, Mapping) else os.fsdecode(files)
        self.NAME = name
        self.FRAME = choice("frame", frame, tuple(TO_ENU))
        self.offset = number("offset", offset)
        self.options = dict(options or {})

    def __repr__(self) -> str:
        return f"Finished({self.files!r}, name={self.NAME!r})"

    def path(self, recording: Recording) -> Path:
        """The file of a recording.

        Parameters
        ----------
        recording : Recording
            Whose ``meta["path"]`` names it.

        Returns
        -------
        pathlib.Path
            Where its orientations are.
        """
        stem = Path(str(recording.meta.get("path", ""))).stem
        if isinstance(self.files, str):
            if "{stem}" in self.files and not stem:
                raise ValueError("recording: expected one that was read from a file, got one without meta['path']")
            return Path(self.files.replace("{stem}", stem))
        if stem not in self.files:
            raise ValueError(f"files: expected one for {stem!r}, got {', '.join(map(str, self.files)) or 'none'}")
        return Path(self.files[stem])

    def run(self, recording: Recording) -> NDArray[np.float64]:
        """Orientations at the samples of a recording, along the shortest rotations between those of its file.

        Parameters
        ----------
        recording : Recording
            With stamps of the same clock.

        Returns
        -------
        ndarray
            (T, 4); NaN outside of the file's times, and over its gaps.
        """
        from ahrs_rs.io import read

        path = self.path(recording)
        with warnings.catch_warnings():
            # Of columns beside the orientations; a time in another unit would show in the gaps that are left.
            warnings.simplefilter("ignore", DataWarning)
            other = read(path, **self.options)
        for name in ("ref", "device_quat"):
            stream = other.streams.get(name)
            if stream is not None and len(stream) >= 2:
                found: NDArray[np.float64] = Stream(stream.t + self.offset, stream.values).turning(recording.t)
                return found
        raise ValueError(f"{path}: expected orientations, got {', '.join(other.streams) or 'nothing'}")
