"""What the studies share: running filters, timing them, judging by both worlds."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import metrics
from ahrs_rs._estimate import Estimate
from ahrs_rs._filter import Filter
from ahrs_rs._recording import Recording
from ahrs_rs._run_many import run_many
from ahrs_rs._typing import FloatArray
from ahrs_rs.papers._study import Cell, Table, Verdict

T = TypeVar("T")
Judge: TypeAlias = Callable[[T], Verdict]

#: A time is the shortest of so many runs: what disturbs a run only makes it longer.
REPEATS = 100
#: of so many samples at most.
CLOCKED = 2000
#: Where roll and yaw are told apart, degrees of pitch.
PITCH = 75.0


def estimate(f: Filter, recording: Recording, *, nine_axes: bool = True) -> Estimate:
    """The filter's estimate, with the magnetometer or without it."""
    mag = recording.mag if nine_axes else None
    return f.run(recording.gyr, recording.acc, mag, t=recording.t)


def estimates(f: Filter, recordings: Sequence[Recording], *, nine_axes: bool = True) -> list[Estimate]:
    """The same of many recordings at once."""
    runs = [(one.gyr, one.acc, one.mag if nine_axes else None) for one in recordings]
    names = ("gyr", "acc", "mag")
    return run_many(
        f, [dict(zip(names, run, strict=True)) | {"t": one.t} for run, one in zip(runs, recordings, strict=True)]
    )


def as_published(cls: type[Filter], paper: str, rate: float, **params: float | str | bool) -> Filter:
    """The filter with a paper's parameters in the form that the paper gives: its first-order step, its gradient.

    ``paper`` may have no preset of the filter: all of its parameters are then the defaults.
    """
    forms: dict[str, float | str | bool] = {"integration": "first-order", "gradient": "paper", "prediction": "euler"}
    own = {name: value for name, value in forms.items() if name in cls.PARAMS}
    keywords: dict[str, Any] = {**own, **cls.PRESETS.get(paper, {}), **params}
    return cls(rate=rate, **keywords)


def truth(recording: Recording) -> FloatArray:
    """The reference; ``ValueError`` where there is none."""
    if recording.ref is None:
        raise ValueError("recordings: expected references, got a recording without one")
    return recording.ref


def angles(est: Estimate, recording: Recording) -> FloatArray:
    """(T, 3) errors of roll, pitch and yaw in degrees, wrapped."""
    return metrics.euler_error(est.quat, truth(recording), degrees=True)


def angle_rmse(est: Estimate, recording: Recording) -> FloatArray:
    """(3,) RMSE of roll, pitch and yaw in degrees over the samples that count."""
    return np.asarray(metrics.rmse(angles(est, recording).T, recording.mask))


def named(recordings: Iterable[Recording], part: str) -> list[Recording]:
    """The recordings whose file has the part in its name."""
    return [one for one in recordings if part in Path(str(one.meta.get("path", ""))).name]


def not_vertical(recording: Recording) -> Recording:
    """The recording where only samples count whose roll and yaw are told apart."""
    pitch = metrics.euler(truth(recording), degrees=True)[:, 1]
    mask = np.abs(pitch) < PITCH
    return dataclasses.replace(recording, mask=mask if recording.mask is None else mask & recording.mask)


def mean(rows: Iterable[ArrayLike]) -> FloatArray:
    """Over recordings; those without a sample that counts are left out."""
    table = np.array([np.asarray(row, dtype=np.float64) for row in rows])
    known = ~np.isnan(table)
    total = np.full(table.shape[1:], np.nan)
    np.divide(np.where(known, table, 0.0).sum(axis=0), known.sum(axis=0), out=total, where=known.any(axis=0))
    return total


def clocked(filters: Mapping[str, Filter], recording: Recording, *, nine_axes: bool = True) -> dict[str, float]:
    """Time of a sample on one core in ns.

    The filters take turns, so that what slows the machine down for a while slows all of them.
    """
    part = recording[:CLOCKED]
    mag = part.mag if nine_axes else None
    best = dict.fromkeys(filters, math.inf)
    for _ in range(REPEATS):
        for name, f in filters.items():
            begin = time.perf_counter_ns()
            f.run(part.gyr, part.acc, mag, t=part.t, threads=1)
            best[name] = min(best[name], time.perf_counter_ns() - begin)
    return {name: nanoseconds / len(part) for name, nanoseconds in best.items()}


def clocked_on_first(
    make: Callable[[float], Mapping[str, Filter]], recordings: Sequence[Recording], *, nine_axes: bool = True
) -> dict[str, float] | None:
    """`clocked` on the first of the real recordings, if there is one."""
    if not recordings:
        return None
    return clocked(make(recordings[0].rate), recordings[0], nine_axes=nine_axes)


def times(
    title: str,
    filters: Mapping[str, Filter],
    recording: Recording,
    published: Mapping[str, float],
    unit: str,
    *,
    nine_axes: bool = True,
    note: str = "",
) -> tuple[Table, dict[str, float]]:
    """A table of times beside the published ones, both relative to the smallest; and ours in ns."""  # fmt: skip
    ours = clocked(filters, recording, nine_axes=nine_axes)
    least, least_published = min(ours.values()), min(published.values())
    rows: list[list[Cell]] = [
        [name, published[name], published[name] / least_published, ours[name], ours[name] / least] for name in filters
    ]
    columns = ["method", f"paper [{unit}]", "paper, relative", "ours [ns/sample]", "ours, relative"]
    table = Table(title, columns, rows, note=note, form=".2f", measured=True, local=["ours [ns/sample]"])
    return table, ours


def verdicts(judge: Judge[T], simulated: T, real: T | None) -> tuple[Verdict, Verdict | None]:
    """A claim in both worlds; the real one may not be there."""
    return judge(simulated), judge(real) if real else None


def smallest(name: str, unit: str = "°") -> Callable[[Mapping[str, float]], Verdict]:
    """Judges whether the named one has the smallest value."""
    return lambda values: Verdict(min(values, key=lambda each: values[each]) == name, listed(values, unit))


def largest(name: str, unit: str = "°") -> Callable[[Mapping[str, float]], Verdict]:
    """Judges whether the named one has the largest value."""
    return lambda values: Verdict(max(values, key=lambda each: values[each]) == name, listed(values, unit))


def fastest(name: str) -> Callable[[Mapping[str, float]], Verdict]:
    """The same of times, whose numbers stand in the measured table only."""
    return lambda values: Verdict(smallest(name)(values).holds, "see the table of times")


def slowest(name: str) -> Callable[[Mapping[str, float]], Verdict]:
    """As `fastest`."""
    return lambda values: Verdict(largest(name)(values).holds, "see the table of times")


def listed(values: Mapping[str, float], unit: str = "°") -> str:
    """Like "EKF 0.31°, Mahony 0.44°"."""
    return ", ".join(f"{name} {value:.3g}{unit}" for name, value in values.items())
