"""Speed of the low-pass filter beside scipy's, and of the Allan deviation.

Times are of calls from Python with arrays in memory. The two filters take turns; each ratio is the median of the
rounds.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy import signal

import ahrs_rs as ar
from ahrs_rs.calibration import allan, allan_deviation

SAMPLES = 1_000_000
LONG = 10_000_000
ROUNDS = 5


def elapsed(call: Callable[[], object]) -> float:
    """s of a call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def main() -> int:
    rng = np.random.default_rng(0)
    print(f"Low-pass, {SAMPLES} rows of (T, C): ns a number, and the time over that of scipy.signal.sosfilt")
    for channels in (1, 3, 6):
        for dtype in (np.float64, np.float32):
            x = rng.standard_normal((SAMPLES, channels)).astype(dtype)
            for order in (2, 4, 8):
                sections = signal.butter(order, 0.1, output="sos").astype(dtype)
                ours, theirs = [], []
                for _ in range(ROUNDS + 1):  # the first one warms up
                    ours.append(elapsed(partial(ar.signal.low_pass, x, 5.0, 100.0, order)))
                    theirs.append(elapsed(partial(signal.sosfilt, sections, x, axis=0)))
                ratio = statistics.median(a / b for a, b in zip(ours[1:], theirs[1:], strict=True))
                ns = statistics.median(ours[1:]) / SAMPLES / channels * 1e9
                name = np.dtype(dtype).name
                print(f"C={channels} order {order} {name}: {ns:5.1f} ns, {ratio:4.2f} times scipy's")
    f, row = ar.signal.LowPass(4, 5.0, 100.0), rng.standard_normal((20_000, 3))
    print(f"streaming, C=3: {elapsed(lambda: [f.update(one) for one in row]) / len(row) * 1e6:.1f} µs an update")
    x = rng.standard_normal(LONG)
    print(f"Allan deviation of {LONG} samples: {elapsed(lambda: allan_deviation(x, 100.0)):.2f} s", end="")
    print(f", with its coefficients {elapsed(lambda: allan(x, 100.0)):.2f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
