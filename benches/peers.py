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
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import ahrs_rs as ar

SAMPLES = 6401
"""As many as Ludwig & Burnham's recording."""
MANY = 64
"""Recordings of equal length, and parameter sets of a sweep."""
ROUNDS = 7
TURN = 10_000_000
"""ns that a contender's turn lasts at least."""
RATE = 286.0
HERE = Path(__file__).resolve().parents[1]

WAYS = ("one", f"{MANY}", f"{MANY}, all cores", f"sweep of {MANY}", "sweep, all cores")
"""One recording; many on one thread and on all; one recording with many parameter sets."""


@dataclass(frozen=True)
class Contender:
    """A filter of a package on some data."""

    name: str
    kind: str
    """9D or 6D and the dtype."""
    way: str
    """One of `WAYS`."""
    samples: int
    """In a call."""
    call: Callable[[], object]


def contenders(rec: ar.Recording) -> Iterator[Contender]:
    """Ours."""
    for dtype, short in ((np.float64, "f64"), (np.float32, "f32")):
        sensors = [np.ascontiguousarray(v, dtype=dtype) for v in (rec.gyr, rec.acc, rec.mag)]
        many = [np.repeat(v[np.newaxis], MANY, axis=0) for v in sensors]
        room = np.empty((MANY, SAMPLES, 4), dtype)
        for name, cls in ar.FILTERS.items():
            f, kind = cls(rate=RATE), f"9D {short}"
            label = f"ahrs_rs {name}"
            yield Contender(label, kind, WAYS[0], SAMPLES, lambda f=f, v=sensors: f.run(*v))
            if short == "f64":
                yield Contender(label, "6D f64", WAYS[0], SAMPLES, lambda f=f, v=sensors: f.run(*v[:2]))
            for way, threads in ((WAYS[1], 1), (WAYS[2], None)):
                run = partial(f.run, *many, out=room, threads=threads)
                yield Contender(label, kind, way, SAMPLES * MANY, run)
            grid = next(
                ({p.name: np.linspace(0.5, 1.0, MANY) * p.default} for p in cls.PARAMS.values() if p.range), None
            )
            for way, threads in ((WAYS[3], 1), (WAYS[4], None)):
                if grid and cls.STREAMING:
                    call = partial(ar.sweep, cls, grid, [rec], threads=threads, dtype=dtype)
                    yield Contender(label, kind, way, SAMPLES * MANY, call)


def peers(rec: ar.Recording) -> Iterator[Contender]:
    """The other packages, on one recording: none takes more at once."""
    import ahrs
    import imufusion
    import vqf

    gyr, acc, mag = rec.gyr, rec.acc, rec.mag
    assert acc is not None
    assert mag is not None
    for name, cls in (("VQF", vqf.VQF), ("BasicVQF", vqf.BasicVQF)):
        run = partial(lambda cls: cls(1 / RATE).updateBatch(gyr, acc, mag), cls)
        yield Contender(f"vqf {name}", "9D f64", WAYS[0], SAMPLES, run)
    yield Contender("vqf VQF", "6D f64", WAYS[0], SAMPLES, lambda: vqf.VQF(1 / RATE).updateBatch(gyr, acc))
    yield Contender("vqf offlineVQF", "9D f64", WAYS[0], SAMPLES, lambda: vqf.offlineVQF(gyr, acc, mag, 1 / RATE))
    rows = list(
        zip(*(np.float32(v * unit) for v, unit in ((gyr, 57.29578), (acc, 1 / 9.80665), (mag, 1))), strict=True)
    )

    def fusion() -> None:
        f = imufusion.Ahrs()
        f.set_sample_period(1 / RATE)
        for row in rows:
            f.update(*row)

    yield Contender("imufusion Ahrs", "9D f32", WAYS[0], SAMPLES, fusion)
    few = 300  # a hundred thousand ns a sample: more would only take longer
    short = {"gyr": gyr[:few], "acc": acc[:few], "mag": mag[:few] * 1e3, "frequency": RATE}
    for name in ("Madgwick", "Mahony", "EKF"):
        yield Contender(f"ahrs {name}", "9D f64", WAYS[0], few, partial(getattr(ahrs.filters, name), **short))


def memory() -> Contender:
    """Reading and writing what a sample of nine f64 in and four out takes, without computing."""
    half = 104 // 2 * SAMPLES * MANY
    source, target = np.ones(half, np.uint8), np.ones(half, np.uint8)
    return Contender("104 bytes of memory", "f64", WAYS[1], SAMPLES * MANY, partial(np.copyto, target, source))


def repeated(call: Callable[[], object]) -> float:
    """ns of a call, the mean over those of a turn, after one that brings the data into the caches."""
    call()
    start, count, elapsed = time.perf_counter_ns(), 0, 0
    while elapsed < TURN:
        call()
        count += 1
        elapsed = time.perf_counter_ns() - start
    return elapsed / count


def measure(calls: list[Contender]) -> dict[tuple[str, str, str], list[float]]:
    """ns per sample of each contender in each round."""
    results: dict[tuple[str, str, str], list[float]] = {(c.name, c.kind, c.way): [] for c in calls}
    for round_number in range(-1, ROUNDS):  # the first one warms up
        for c in calls:
            turn = repeated(c.call)
            if round_number >= 0:
                results[c.name, c.kind, c.way].append(turn / c.samples)
        if sys.stderr.isatty():
            print(f"\rround {round_number + 1} of {ROUNDS}", end="", file=sys.stderr)
    return results


def streaming(rec: ar.Recording) -> list[tuple[str, float]]:
    """ns per call of one update from Python."""
    import imufusion
    import vqf

    acc, mag = rec.acc, rec.mag
    assert acc is not None
    assert mag is not None
    rows = [tuple(np.ascontiguousarray(v[k]) for v in (rec.gyr, acc, mag)) for k in range(2000)]
    narrow = [tuple(np.float32(v) for v in row) for row in rows]
    ahrs = imufusion.Ahrs()

    def updated(*row: np.ndarray) -> np.ndarray:
        ahrs.update(*row)
        return ahrs.get_quaternion()

    filters = {
        "ahrs_rs Madgwick.update": (ar.Madgwick(rate=RATE).update, rows),
        "ahrs_rs VQF.update": (ar.VQF(rate=RATE).update, rows),
        "ahrs_rs Fusion.update": (ar.Fusion(rate=RATE).update, rows),
        "vqf VQF.update": (vqf.VQF(1 / RATE).update, rows),
        "imufusion Ahrs.update alone": (imufusion.Ahrs().update, narrow),
        "imufusion Ahrs.update and get_quaternion": (updated, narrow),
    }
    times: dict[str, list[float]] = {name: [] for name in filters}
    for _ in range(ROUNDS):
        for name, (update, data) in filters.items():
            start = time.perf_counter_ns()
            for row in data:
                update(*row)
            times[name].append((time.perf_counter_ns() - start) / len(data))
    found = [(name, statistics.median(each)) for name, each in times.items()]
    return found


def table(results: dict[tuple[str, str, str], list[float]]) -> list[str]:
    """A row for each filter and kind of data: million samples per second, and ratios of the same rounds."""
    reference = results["vqf VQF", "9D f64", WAYS[0]]
    head = ["filter", "data", *WAYS, "lanes", "threads", "× `vqf`", f"{MANY} × `vqf`"]
    lines = ["| " + " | ".join(head) + " |", "| --- | --- " + "| ---: " * (len(head) - 2) + "|"]
    for name, kind in dict.fromkeys((name, kind) for name, kind, _ in results):
        times = [results.get((name, kind, way)) for way in WAYS]
        cells = [f"{1e3 / statistics.median(t):.3g}" if t else "" for t in times]
        one, many, all_cores = times[:3]
        pairs = [(one, many), (many, all_cores), (reference, one), (reference, many)]
        cells += [f"{ratio(slow, fast):.3g}" if slow and fast else "" for slow, fast in pairs]
        lines.append(f"| {name} | {kind} | " + " | ".join(cells) + " |")
    return lines


def ratio(slow: list[float], fast: list[float]) -> float:
    """The median over the rounds."""
    return statistics.median(a / b for a, b in zip(slow, fast, strict=True))


def spread(results: dict[tuple[str, str, str], list[float]]) -> float:
    """The median over the contenders of (upper - lower quartile)/median."""
    quartiles = [statistics.quantiles(times, n=4) for times in results.values()]
    return statistics.median((high - low) / median for low, median, high in quartiles)


def main() -> int:
    rec = ar.simulate.demo(duration=SAMPLES / RATE, rate=RATE, seed=1)
    rec = rec[:SAMPLES]
    results = measure([*contenders(rec), *peers(rec), memory()])
    lines = [
        "# Performance",
        "",
        f"Made by `make bench`: million samples per second, called from Python. {ROUNDS} rounds in which contenders",
        f"take turns of {TURN // 1_000_000} ms, of which the mean call counts; medians over the rounds (half of the",
        f"rounds lie within {100 * spread(results):.0f} % of each other). One recording has {SAMPLES} samples;",
        f"{MANY} recordings are one (N, T, 3) array into a given array on one thread and on all cores",
        f"({os.cpu_count()} here); a sweep computes the total error of {MANY} values of a parameter on one recording.",
        f"`lanes` is how many times as fast {MANY} recordings are on one thread as one is, `threads` all cores against",
        "one, the last columns how many times as fast one and many are as `vqf`'s online filter in the same round.",
        "The last row is the memory's limit: a copy of as many bytes as nine numbers in and four out take. Further",
        "outputs of a filter (covariances) are computed one recording after the other.",
        "",
        f"Python {platform.python_version()}, numpy {np.__version__}, {platform.machine()}.",
        "",
        *table(results),
        "",
        "One streaming update from Python, which gives the attitude: "
        + ", ".join(f"{name} {ns / 1e3:.2f} µs" for name, ns in streaming(rec))
        + ".",
        "",
    ]
    print("\n".join(lines))
    (HERE / "docs" / "performance.md").write_text("\n".join(lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
