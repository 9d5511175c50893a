"""Time and memory of the ellipsoid fit of a million readings; printed, not judged."""

from __future__ import annotations

import resource
import statistics
import sys
import time

import numpy as np

import ahrs_rs as ar

READINGS = 1_000_000
ROUNDS = 5


def readings(count: int) -> np.ndarray:
    """A sensor with hard and soft iron and noise of 1 %, turned at random; one reading in a hundred is an outlier."""
    random = np.random.default_rng(0)
    u = random.standard_normal((count, 3))
    u *= 48.0 / np.linalg.norm(u, axis=1, keepdims=True)
    soft = np.array([[1.1, 0.05, -0.03], [0.05, 0.9, 0.02], [-0.03, 0.02, 1.0]])
    x = u @ soft + [30.0, -20.0, 10.0] + 0.5 * random.standard_normal((count, 3))
    bad = random.random(count) < 0.01
    x[bad] += random.uniform(-100.0, 100.0, (int(bad.sum()), 3))
    return x


def main() -> int:
    x = readings(READINGS)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for parameters in (6, 9):
        clock, work = [], []
        for _ in range(ROUNDS):
            start, used = time.perf_counter(), time.process_time()
            ar.calibration.magnetometer(x, parameters=parameters)
            clock.append(time.perf_counter() - start)
            work.append(time.process_time() - used)
        print(
            f"ellipsoid, {parameters} parameters, {READINGS:,} readings: {min(clock):.2f} s at best, "
            f"{statistics.median(clock):.2f} s median ({statistics.median(work):.2f} s of the processor)"
        )
    more = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(f"memory beyond the readings: {more * 1024 / READINGS:.0f} bytes a reading")
    calibration = ar.calibration.magnetometer(x[:10_000]).calibration
    for dtype in (np.float64, np.float32):
        raw = x.astype(dtype)
        times = []
        for _ in range(ROUNDS):
            start = time.perf_counter()
            calibration.apply(raw)
            times.append(time.perf_counter() - start)
        print(f"apply, {np.dtype(dtype)}: {min(times) / READINGS * 1e9:.1f} ns a reading")
    return 0


if __name__ == "__main__":
    sys.exit(main())
