"""A recording as a page: the board in space, played over time, with angles and status below."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ahrs_rs import _atomic
from ahrs_rs._estimate import Estimate
from ahrs_rs._recording import Recording
from ahrs_rs._view._page import page, require_plotly
from ahrs_rs._view._scene import Scene, scene

__all__ = ["View", "require_plotly", "view"]

#: Of the frame in a notebook, pixels.
HEIGHT = 900


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A page that plays recordings; made by `ahrs_rs.view`.

    Parameters
    ----------
    title : str
        Of the page.
    _scenes : tuple of Scene
        What is played, a recording each.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> shown = ar.view(rec, {"vqf": ar.VQF().run(rec)})
    >>> shown.title
    'recording'
    """

    title: str
    _scenes: tuple[Scene, ...] = field(repr=False)

    def __add__(self, other: View) -> View:
        """One page with the recordings of both, of which one is chosen at a time."""
        if not isinstance(other, View):
            return NotImplemented
        return View(f"{self.title}, {other.title}", (*self._scenes, *other._scenes))

    def to_html(self) -> str:
        """The page as one text, plotly's script within it: it needs no network and no other file.

        Returns
        -------
        str
            HTML.

        Raises
        ------
        ImportError
            Plotly is not installed (``pip install ahrs-rs[view]``).
        """
        return page(self.title, [one.data for one in self._scenes])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file.

        Parameters
        ----------
        path : str or path-like
            As "walk.html".

        Raises
        ------
        ImportError
            Plotly is not installed (``pip install ahrs-rs[view]``).
        """
        _atomic.write_text(path, self.to_html())

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.to_html())}" style="width:100%;height:{HEIGHT}px;border:0" '
            'sandbox="allow-scripts"></iframe>'
        )


def view(
    recording: Recording,
    estimates: Mapping[str, Estimate] | Estimate | None = None,
    *,
    title: str = "",
) -> View:
    """A page that plays a recording: the board in space, and angles and status over time below it.

    The first estimate is the board; the others, and the recording's reference, are drawn as outlines about it. Arrows
    are gravity, and the specific force and the magnetic field as measured, turned into the earth frame by the first
    estimate. Gaps stay gaps. Long recordings are thinned for display, and the page says so.

    Parameters
    ----------
    recording : Recording
        What was measured.
    estimates : mapping or Estimate, optional
        By name, each with the rows of the recording. None plays the reference alone.
    title : str, optional
        Of the page; by default the name of the file.

    Returns
    -------
    View
        ``save("page.html")`` writes it, a notebook shows it, and ``+`` puts several on one page.

    Raises
    ------
    ValueError
        Nothing to play: neither an estimate nor a reference, or no samples; an estimate of another length.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> shown = ar.view(rec, {"vqf": ar.VQF().run(rec), "madgwick": ar.Madgwick().run(rec)})
    >>> with TemporaryDirectory() as folder:
    ...     shown.save(Path(folder, "page.html"))
    ...     Path(folder, "page.html").stat().st_size > 1_000_000
    True
    """
    given: Mapping[str, Any] = {"estimate": estimates} if isinstance(estimates, Estimate) else estimates or {}
    made = scene(recording, given, title)
    return View(made.name, (made,))
