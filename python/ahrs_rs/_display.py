"""Signals as a screen shows them: with gaps seen, and no more points than there are pixels for."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._rate import nominal_rate
from ahrs_rs._streams import GAP_STEPS
from ahrs_rs._typing import FloatArray

#: Of the steps of a clock, this part is no longer than a usual one also where stamps come in packets.
USUAL_SHARE = 0.9


def gaps(t: FloatArray) -> NDArray[np.intp]:
    """The rows of stamps (T,) after which the clock makes a step of more than 2.5 usual ones.

    Where samples come in packets with one stamp, the usual step is that from packet to packet.
    """
    steps = np.diff(t)
    positive = steps[steps > 0.0]
    if not positive.size:
        return np.zeros(0, dtype=np.intp)
    usual = max(1.0 / nominal_rate(t), float(np.median(positive)))
    usual = max(usual, float(np.quantile(positive, USUAL_SHARE))) if _packets(steps) else usual
    return np.flatnonzero(steps > GAP_STEPS * usual)


def gap_spans(t: FloatArray, missing: NDArray[np.bool_] | None = None) -> list[tuple[float, float]]:
    """(begin, end) of each gap of the clock, and of each time in which readings (T,) are missing for as long."""
    found = [(float(t[row]), float(t[row + 1])) for row in gaps(t)]
    if missing is not None and missing.any():
        usual = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        found += [span for span in spans(t, missing) if span[1] - span[0] > GAP_STEPS * usual]
    return found


def broken(t: FloatArray, y: FloatArray, after: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    """Times (T,) and values (T, ...) with a row of NaN after each of some rows: a line breaks there."""
    if not len(after):
        return t, y
    between = 0.5 * (t[after] + t[after + 1])
    return np.insert(t, after + 1, between), np.insert(y, after + 1, np.nan, axis=0)


def wraps(angle: FloatArray, turn: float) -> NDArray[np.intp]:
    """The rows after which an angle (T,) goes on at the other end of its range: it changes by more than half a turn."""
    with np.errstate(invalid="ignore"):
        return np.flatnonzero(np.abs(np.diff(angle)) > 0.5 * turn)


def kept(columns: FloatArray, points: int) -> NDArray[np.intp]:
    """The rows of columns (T, k) that draw the same picture: of each bin the extremes of every column, and its ends.

    Rows with a NaN stay where they begin and end within a bin, so that gaps stay gaps. At most about `points` rows.
    """
    count, width = columns.shape
    if count <= points:
        return np.arange(count)
    bins = max(points // (2 * width + 4), 1)
    edges = np.linspace(0, count, bins + 1).astype(np.intp)
    chosen = [edges[:-1], edges[1:] - 1]
    size = int(np.max(np.diff(edges)))
    # (bins, size): a bin that is shorter has its last row twice.
    rows = np.minimum(edges[:-1, np.newaxis] + np.arange(size), edges[1:, np.newaxis] - 1)
    for column in columns.T:
        values = column[rows]
        missing = np.isnan(values)
        for extreme in (
            np.argmin(np.where(missing, np.inf, values), axis=1),
            np.argmax(np.where(missing, -np.inf, values), axis=1),
        ):
            chosen.append(rows[np.arange(bins), extreme])
    lacking = np.isnan(columns.sum(axis=1))[rows]
    some = np.flatnonzero(lacking.any(axis=1))
    chosen.append(rows[some, np.argmax(lacking[some], axis=1)])
    chosen.append(rows[some, size - 1 - np.argmax(lacking[some][:, ::-1], axis=1)])
    return np.unique(np.concatenate(chosen))


def thinned(t: FloatArray, columns: Any, points: int) -> tuple[FloatArray, FloatArray]:
    """Times (T,) and columns (T, k) or (T,) at the rows of `kept`."""
    values = np.asarray(columns, dtype=np.float64)
    rows = kept(values.reshape(len(values), -1) if values.size else np.zeros((len(values), 1)), points)
    return t[rows], values[rows]


def spans(t: FloatArray, mask: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """(begin, end) of each run of samples in the mask: a sample stands for the time from its stamp to the next one."""
    if not mask.any():
        return []
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8))).reshape(-1, 2)
    steps = np.diff(t)
    usual = float(np.median(steps)) if len(steps) else 0.0
    last = len(t) - 1
    return [
        (float(t[start]), float(t[stop]) if stop <= last else float(t[last]) + usual) for start, stop in edges.tolist()
    ]


def _packets(steps: FloatArray) -> bool:
    """Whether samples come several at a stamp."""
    return int(np.count_nonzero(steps == 0.0)) > 0.5 * len(steps)
