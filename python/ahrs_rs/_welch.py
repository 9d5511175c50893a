"""The power density of readings, by Welch's method (IEEE Trans. Audio and Electroacoustics 15(2), 1967)."""

from __future__ import annotations

import numpy as np

from ahrs_rs._typing import FloatArray

#: Rows of a segment, how many segments are looked at, and how many of them have to be without a gap.
LENGTH, SEGMENTS, FEWEST = 256, 64, 4


def density(rows: FloatArray, rate: float) -> tuple[FloatArray, FloatArray] | None:
    """Frequencies, Hz, and power density summed over the axes of readings (T, k) (one-sided); None without data."""
    if len(rows) < 2 * LENGTH:
        return None
    starts = np.linspace(0, len(rows) - LENGTH, SEGMENTS).astype(np.intp)
    window = np.hanning(LENGTH)
    power = np.zeros(LENGTH // 2 + 1)
    used = 0
    for start in starts:
        part = rows[start : start + LENGTH]
        if not np.isfinite(part).all():
            continue
        centred = (part - part.mean(axis=0)) * window[:, np.newaxis]
        power += (np.abs(np.fft.rfft(centred, axis=0)) ** 2).sum(axis=1)
        used += 1
    if used < FEWEST:
        return None
    scale = 2.0 / (rate * float(np.sum(window**2)) * used)
    return np.asarray(np.fft.rfftfreq(LENGTH, 1.0 / rate), dtype=np.float64), power * scale
