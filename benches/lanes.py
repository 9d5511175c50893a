"""How many times as fast recordings are side by side in vector registers as one after the other: what CI prints.

A filter that is not vectorised shows a ratio near one. One thread; the two take turns, medians of the rounds.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

import ahrs_rs as ar

SAMPLES = 2000
RECORDINGS = 32
ROUNDS = 5
RATE = 100.0


def elapsed(call: Callable[[], object]) -> float:
    """s of a call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def ratio(f: ar.Filter, sensors: list[np.ndarray]) -> float:
    """Time of a recording alone over its share of the time of many."""
    many = [np.repeat(array[np.newaxis], RECORDINGS, axis=0) for array in sensors]
    out = np.empty((RECORDINGS, SAMPLES, 4), sensors[0].dtype)
    ratios = []
    for _ in range(ROUNDS + 1):  # the first one warms up
        alone = statistics.median(elapsed(lambda: f.run(*sensors)) for _ in range(5))
        ratios.append(alone * RECORDINGS / elapsed(lambda: f.run(*many, out=out, threads=1)))
    return statistics.median(ratios[1:])


def main() -> int:
    rec = ar.simulate.demo(duration=SAMPLES / RATE, rate=RATE, seed=1)[:SAMPLES]
    print(f"{RECORDINGS} recordings of {SAMPLES} samples, 9D, one thread: times as fast as one after the other")
    for name, cls in ar.FILTERS.items():
        if cls.STREAMING:
            sensors = [
                [np.asarray(v, dtype) for v in (rec.gyr, rec.acc, rec.mag)] for dtype in (np.float64, np.float32)
            ]
            wide, narrow = (ratio(cls(rate=RATE), arrays) for arrays in sensors)
            print(f"{name:16} f64 {wide:4.1f}   f32 {narrow:4.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
