"""Time and memory of simulating an hour of 9D data at 1 kHz with a full sensor model.

The full model ("rough") has every error at once: noise, flicker noise and random walk, biases, scale, misalignment,
temperature, crosstalk, range, resolution, jitter, lost and missing rows, a late and slow magnetometer. One thread.
"""

from __future__ import annotations

import os
import resource
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is imported

import ahrs_rs as ar

RATE = 1000.0
HOUR = 3600.0
ROUNDS = 3
NAMES = ("static", "way_points", "robot_arm", "demo", "walking", "quadrotor")


def peak() -> float:
    """Largest memory of the process so far, bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


def main() -> int:
    duration = HOUR if len(sys.argv) < 2 else float(sys.argv[1])
    count = duration * RATE
    print(f"{duration:g} s of 9D data at {RATE:g} Hz, one thread: s (least of {ROUNDS}), wall and processor")
    before = peak()
    for name in NAMES:
        for sensor in ("ideal", "rough"):
            setup = ar.simulate.SCENARIOS[name].setup(rate=RATE, duration=duration, sensor=sensor)
            times = []
            for _ in range(ROUNDS):
                start = time.perf_counter(), time.process_time()
                setup.record()
                times.append((time.perf_counter() - start[0], time.process_time() - start[1]))
            wall, processor = (min(one) for one in zip(*times, strict=True))
            print(f"{name:12} {sensor:6} {wall:6.2f} {processor:6.2f}   {1e9 * processor / count:5.0f} ns a sample")
    print(f"memory at its peak: {(peak() - before) / count:.0f} bytes a sample")
    return 0


if __name__ == "__main__":
    sys.exit(main())
