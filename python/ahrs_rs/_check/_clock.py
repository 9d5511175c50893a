"""The clock of the reference: by how far sensor and reference turn, whatever their frames and forms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _quat
from ahrs_rs._check._case import Coarse

FloatArray = NDArray[np.float64]

#: The offset is looked for this far, s.
FARTHEST = 2.0
#: Turns over 50 ms that count, rad; so many are needed.
SLOWEST, FEWEST = 0.0125, 30


def unit(ref: FloatArray) -> FloatArray:
    """Quaternions of unit norm; NaN where one is far from it."""
    norm = np.linalg.norm(ref, axis=1, keepdims=True)
    return np.asarray(np.where((norm > 0.9) & (norm < 1.1), ref / np.maximum(norm, 1e-12), np.nan))


def clock_of(coarse: Coarse, ref: FloatArray) -> tuple[float, float, bool]:
    """Offset of the reference's clock, s (positive: it is late), the correlation there, and whether enough turns."""
    rate = coarse.rate
    step = max(round(0.05 * rate), 1)
    turn = _quat.log(_quat.multiply(_quat.conjugate(ref[:-step]), ref[step:]))
    optical = np.linalg.norm(turn, axis=1)
    total = np.cumsum(np.vstack([np.zeros(3), np.nan_to_num(coarse.turn)]), axis=0)
    sensor = np.linalg.norm(total[step + 1 :] - total[1:-step], axis=1)
    count = min(len(optical), len(sensor))
    optical, sensor = optical[:count], sensor[:count]
    enough = np.count_nonzero((optical > SLOWEST) & (sensor > SLOWEST)) > FEWEST
    reach = min(int(FARTHEST * rate), count // 3)
    lost = np.cumsum(np.concatenate([[0.0], np.isnan(coarse.turn).any(axis=1)]))
    known = np.isfinite(optical) & ((lost[step + 1 :] - lost[1:-step])[:count] == 0.0)
    x = np.where(known, optical, 0.0)
    stride = max(count // 40000, 1)
    scores = np.zeros(2 * reach + 1)
    for k, lag in enumerate(range(-reach, reach + 1)):
        a, b, there = _shifted(sensor, x, known, lag)
        a, b, there = a[::stride], b[::stride], there[::stride]
        scores[k] = _correlation(a[there], b[there])
    best = int(np.argmax(scores))
    offset = float(best - reach)
    if 0 < best < 2 * reach:  # the top of the parabola through three
        low, mid, high = scores[best - 1 : best + 2]
        bend = low - 2.0 * mid + high
        if bend < 0.0:
            offset += 0.5 * (low - high) / bend
    middle = float(scores[reach])
    if scores[best] - middle < 0.003:  # no better than no offset
        offset = 0.0
    return offset / rate, float(scores[best]), bool(enough)


def _shifted(
    sensor: FloatArray, optical: FloatArray, known: NDArray[np.bool_], lag: int
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """The reference at k + lag beside the sensor at k."""
    if lag >= 0:
        end = len(sensor) - lag
        return sensor[:end], optical[lag:], known[lag:]
    return sensor[-lag:], optical[:lag], known[:lag]


def _correlation(a: FloatArray, b: FloatArray) -> float:
    if len(a) < 50:
        return 0.0
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / size if size > 0.0 else 0.0
