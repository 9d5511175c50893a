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
    rows = []
    for recording in recordings:
        assert recording.ref is not None
        score = ar.metrics.score(estimate(name, keywords, recording), recording.ref, recording.mask)
        rows.append([score.total, score.heading, score.inclination])
    return np.array(rows)


def aligned_scores(
    name: str, keywords: dict[str, Any], recordings: Sequence[ar.Recording]
) -> tuple[np.ndarray, list[ar.metrics.Alignment]]:
    """The same after the best constant rotations and offset, and these."""
    rows, found = [], []
    for recording in recordings:
        assert recording.ref is not None
        quat = estimate(name, keywords, recording)
        one = ar.metrics.align(quat, recording.ref, recording.mask, t=recording.t, check=False)
        score = ar.metrics.score(*one.pair(quat, recording.ref), recording.mask)
        rows.append([score.total, score.heading, score.inclination])
        found.append(one)
    return np.array(rows), found


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts, whose columns but the first are numbers."""
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
