"""Scores of filters on recordings, for docs/accuracy.md."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

import ahrs_rs as ar


def estimate(name: str, keywords: dict[str, Any], recording: ar.Recording) -> np.ndarray:
    """The orientations (T, 4) that a filter gives."""
    cls = ar.FILTERS[name]
    if "preset" in keywords:
        f = cls.preset(keywords["preset"], rate=recording.rate)
    else:
        f = cls(rate=recording.rate, **keywords)
    (estimated,) = ar.run_many(f, [recording])
    return np.asarray(estimated.quat)


def scores(name: str, keywords: dict[str, Any], recordings: Sequence[ar.Recording]) -> np.ndarray:
    """Total, heading and inclination error (N, 3), °."""
    return np.array([errors(estimate(name, keywords, one), one.ref, one.mask) for one in recordings])


def errors(quat: np.ndarray, ref: np.ndarray | None, mask: np.ndarray | None) -> list[float]:
    """Total, heading and inclination error, °."""
    assert ref is not None
    score = ar.metrics.score(quat, ref, mask)
    return [score.total, score.heading, score.inclination]


def aligned_scores(
    name: str, keywords: dict[str, Any], recordings: Sequence[ar.Recording]
) -> tuple[np.ndarray, list[ar.metrics.Alignment]]:
    """The same after the best constant rotations and offset, and these."""
    rows, found = [], []
    for recording in recordings:
        assert recording.ref is not None
        quat = estimate(name, keywords, recording)
        one = ar.metrics.align(quat, recording.ref, recording.mask, t=recording.t, check=False)
        rows.append(errors(*one.pair(quat, recording.ref), recording.mask))
        found.append(one)
    return np.array(rows), found


def table(head: Sequence[str], rows: Iterable[Sequence[str]], texts: int = 1) -> str:
    """A table, whose columns after the first ones, which are texts, are numbers."""
    lines = [head, ["---"] * texts + ["---:"] * (len(head) - texts), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
