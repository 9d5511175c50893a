"""Speed of every filter beside other packages, in one run: `make bench`, kept as docs/performance.md.

Times are of calls from Python with arrays in memory, per sample. Contenders take turns, so that a machine whose
speed drifts slows all of them; each figure is the median of the rounds, with the quartiles.
"""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import ahrs_rs as ar

SAMPLES = 6401
"""As many as Ludwig & Burnham's recording."""
RECORDINGS = 16
"""For the rows with many recordings."""
ROUNDS = 15
TURN = 10_000_000
"""ns that a contender's turn lasts at least."""
RATE = 286.0
HERE = Path(__file__).resolve().parents[1]


def contenders(rec: ar.Recording) -> Iterator[tuple[str, str, int, Callable[[], object]]]:
    """(package and filter, input, samples in a call, call)."""
    gyr, acc, mag = rec.gyr, rec.acc, rec.mag
    assert acc is not None
    assert mag is not None
    narrow = [v.astype(np.float32) for v in (gyr, acc, mag)]
    many = [np.repeat(v[np.newaxis], RECORDINGS, axis=0) for v in (gyr, acc, mag)]
    for name, cls in ar.FILTERS.items():
        f = cls(rate=RATE)
        yield f"ahrs_rs {name}", "9D f64", SAMPLES, lambda f=f: f.run(gyr, acc, mag)
        yield f"ahrs_rs {name}", "6D f64", SAMPLES, lambda f=f: f.run(gyr, acc)
        yield f"ahrs_rs {name}", "9D f32", SAMPLES, lambda f=f: f.run(*narrow)
        yield f"ahrs_rs {name}", f"{RECORDINGS} × 9D f64", SAMPLES * RECORDINGS, lambda f=f: f.run(*many)
    yield from peers(gyr, acc, mag)


def peers(gyr: np.ndarray, acc: np.ndarray, mag: np.ndarray) -> Iterator[tuple[str, str, int, Callable[[], object]]]:
    """The other packages."""
    import ahrs
    import vqf

    yield "vqf VQF", "9D f64", SAMPLES, lambda: vqf.VQF(1 / RATE).updateBatch(gyr, acc, mag)
    yield "vqf BasicVQF", "9D f64", SAMPLES, lambda: vqf.BasicVQF(1 / RATE).updateBatch(gyr, acc, mag)
    few = 300  # a hundred thousand ns a sample: more would only take longer
    short = {"gyr": gyr[:few], "acc": acc[:few], "mag": mag[:few] * 1e3, "frequency": RATE}
    yield "ahrs Madgwick", "9D f64", few, lambda: ahrs.filters.Madgwick(**short)
    yield "ahrs Mahony", "9D f64", few, lambda: ahrs.filters.Mahony(**short)
    yield "ahrs EKF", "9D f64", few, lambda: ahrs.filters.EKF(**short)


def repeated(call: Callable[[], object]) -> float:
    """ns of a call, the mean over those of a turn, after one that brings the data into the caches."""
    call()
    start, count, elapsed = time.perf_counter_ns(), 0, 0
    while elapsed < TURN:
        call()
        count += 1
        elapsed = time.perf_counter_ns() - start
    return elapsed / count


def measure(calls: list[tuple[str, str, int, Callable[[], object]]]) -> list[list[float]]:
    """ns per sample of each contender in each round."""
    results: list[list[float]] = [[] for _ in calls]
    for round_number in range(-1, ROUNDS):  # the first one warms up
        for result, (_, _, samples, call) in zip(results, calls, strict=True):
            turn = repeated(call)
            if round_number >= 0:
                result.append(turn / samples)
        if sys.stderr.isatty():
            print(f"\rround {round_number + 1} of {ROUNDS}", end="", file=sys.stderr)
    return results


def streaming(rec: ar.Recording) -> list[tuple[str, float]]:
    """ns per call of one update from Python."""
    import vqf

    acc, mag = rec.acc, rec.mag
    assert acc is not None
    assert mag is not None
    rows = [tuple(np.ascontiguousarray(v[k]) for v in (rec.gyr, acc, mag)) for k in range(2000)]
    f, other = ar.Madgwick(rate=RATE), vqf.VQF(1 / RATE)
    found = []
    for name, update in (("ahrs_rs Madgwick.update", f.update), ("vqf VQF.update", other.update)):
        times = []
        for _ in range(ROUNDS):
            start = time.perf_counter_ns()
            for row in rows:
                update(*row)
            times.append((time.perf_counter_ns() - start) / len(rows))
        found.append((name, statistics.median(times)))
    return found


def table(calls: list[tuple[str, str, int, Callable[[], object]]], results: list[list[float]]) -> list[str]:
    reference = next(r for (name, kind, _, _), r in zip(calls, results, strict=True) if name == "vqf VQF")
    lines = [
        "| filter | input | ns per sample | quartiles | million samples/s | × `vqf` VQF 9D |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for (name, kind, _, _), times in zip(calls, results, strict=True):
        low, median, high = statistics.quantiles(times, n=4)
        ratio = statistics.median(r / t for r, t in zip(reference, times, strict=True))
        lines.append(f"| {name} | {kind} | {median:.4g} | {low:.4g} to {high:.4g} | {1e3 / median:.3g} | {ratio:.3g} |")
    return lines


def main() -> int:
    rec = ar.simulate.demo(duration=SAMPLES / RATE, rate=RATE, seed=1)
    rec = rec[:SAMPLES]
    calls = list(contenders(rec))
    results = measure(calls)
    lines = [
        "# Performance",
        "",
        f"Made by `make bench`: {ROUNDS} rounds in which the contenders take turns of {TURN // 1_000_000} ms, of which",
        f"the mean call counts; medians over the rounds. One recording has {SAMPLES} samples; {RECORDINGS} recordings",
        f"are one (N, T, 3) array on all cores ({os.cpu_count()} here). The last",
        "column is how many times as fast as `vqf`'s online filter in the same round.",
        "",
        f"Python {platform.python_version()}, numpy {np.__version__}, {platform.machine()}.",
        "",
        *table(calls, results),
        "",
        "One streaming update from Python: "
        + ", ".join(f"{name} {ns / 1e3:.2f} µs" for name, ns in streaming(rec))
        + ".",
        "",
    ]
    print("\n".join(lines))
    (HERE / "docs" / "performance.md").write_text("\n".join(lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
