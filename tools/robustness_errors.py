"""Errors of the filters before, during and after the faults of docs/robustness.md, and what is asked of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from robustness_faults import Fault
from robustness_paces import PACES
from robustness_scenes import AFTER, HALF, TAIL, Clean, Scene

import ahrs_rs as ar
from ahrs_rs import _quat

Floats = NDArray[np.float64]

#: An error below this is no failure, °.
SMALL = 1.0
#: Times its undisturbed error that a filter may have.
FACTOR = 2.0
#: Times its undisturbed NEES that a filter may have, and the medians of χ² by degrees of freedom: what is not above
#: this many times these is honest, however small it was before.
NEES_FACTOR, CHI2_MEDIAN = 3.0, {2: 1.386, 3: 2.366}
#: s of a recording until a filter has to have settled, for its undisturbed error.
SETTLED = 10.0
#: s before a fault at which the errors of offline filters, which know what comes, are taken.
BEFORE = (10.0, 1.0)
#: s after a fault for which the goal holds, and where it stands in `AFTER`.
GOAL = AFTER.index(10.0)


def observed(name: str) -> str:
    """What a filter observes: "total", "inclination", or "" for nothing."""
    cls = ar.FILTERS[name]
    if not cls.FEEDBACK:
        return ""
    return "total" if cls.MAGNETOMETER else "inclination"


def filter_of(name: str, rate: float, gyr_range: float | None = None) -> ar.Filter | None:
    """A filter at its defaults; None where it cannot be told the gyroscope's range."""
    if gyr_range is None:
        return ar.FILTERS[name](rate=rate)
    try:
        return ar.FILTERS[name](rate=rate, gyr_range=gyr_range)
    except TypeError:
        return None


def run(f: ar.Filter, many: Iterable[dict[str, Any]]) -> list[ar.Estimate]:
    """Estimates of recordings (gyr, acc, mag, t), with the covariance where there is one."""
    outputs = ("covariance",) if "covariance" in f.OUTPUTS else ()
    calls = [{**one, "mag": one["mag"] if f.MAGNETOMETER else None, "outputs": outputs} for one in many]
    return ar.run_many(f, calls, threads=1)


@dataclass(frozen=True, slots=True)
class Errors:
    """Sample by sample: the error in what the filter observes, °, the NEES and the claimed σ, °, of the same."""

    angle: Floats
    inclination: Floats
    heading: Floats
    nees: Floats | None
    sigma: Floats | None

    @classmethod
    def of(cls, kind: str, est: ar.Estimate, ref: Floats, rows: NDArray[Any]) -> Errors:
        """Of the given rows, whose truth is `ref` (n, 4)."""
        quat = np.asarray(est.quat[rows], dtype=np.float64)
        inclination = ar.metrics.inclination_error(quat, ref, degrees=True)
        heading = ar.metrics.heading_error(quat, ref, degrees=True)
        angle = inclination if kind == "inclination" else ar.metrics.total_error(quat, ref, degrees=True)
        if est.covariance is None:
            return cls(angle, inclination, heading, None, None)
        covariance = np.asarray(est.covariance[rows], dtype=np.float64)
        error = _quat.log(_quat.multiply(_quat.conjugate(quat), ref))
        if kind == "inclination":
            # In the earth frame, where the two axes of the inclination are those of east and north.
            matrix = np.moveaxis(
                [_quat.rotate(quat, np.broadcast_to(axis, (len(quat), 3))) for axis in np.eye(3)], 0, 2
            )
            covariance = (matrix @ covariance @ np.swapaxes(matrix, 1, 2))[:, :2, :2]
            up = _quat.rotate(quat, _quat.rotate(_quat.conjugate(ref), np.broadcast_to([0.0, 0.0, 1.0], (len(ref), 3))))
            error = np.stack((up[:, 1], -up[:, 0]), axis=1)
        known = np.isfinite(error).all(axis=1)
        nees = np.full(len(error), math.nan)
        # A covariance that is singular claims to know something exactly, which no error is within.
        claims = known & (np.linalg.matrix_rank(covariance) == covariance.shape[-1])
        nees[known & ~claims] = math.inf
        nees[claims] = np.sum(
            error[claims] * np.linalg.solve(covariance[claims], error[claims][..., None])[..., 0], axis=1
        )
        sigma = np.degrees(np.sqrt(np.trace(covariance, axis1=1, axis2=2)))
        return cls(angle, inclination, heading, nees, sigma)


def rms(values: Floats) -> float:
    """Root of the mean square of what is known."""
    return float(np.sqrt(np.nanmean(values * values)))


def usual_rows(recording: ar.Recording) -> NDArray[np.bool_]:
    """The rows over which a filter's undisturbed error is taken: those that are scored, once it has settled."""
    return recording.t >= SETTLED if recording.mask is None else recording.mask


class Undisturbed:
    """The errors of every filter without the fault, over whole recordings; each is run once."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._found: dict[tuple[str, tuple[int, bool]], Errors] = {}

    def errors(self, name: str, cleans: Sequence[Clean]) -> list[Errors]:
        """Those of each recording."""
        missing = {clean.key: clean for clean in cleans if (name, clean.key) not in self._found}
        if missing:
            f = filter_of(name, self._scene.rate)
            assert f is not None
            recordings = [clean.recording for clean in missing.values()]
            calls = [{"gyr": one.gyr, "acc": one.acc, "mag": one.mag, "t": one.t} for one in recordings]
            for key, one, est in zip(missing, recordings, run(f, calls), strict=True):
                assert one.ref is not None
                self._found[name, key] = Errors.of(observed(name), est, one.ref, np.arange(len(one)))
        return [self._found[name, clean.key] for clean in cleans]


@dataclass(frozen=True, slots=True)
class Result:
    """What a fault did to a filter: an entry for each seed."""

    error: Floats
    """(seeds, 3) °, at `AFTER`."""
    bound: Floats
    """(seeds, 3) °: what is asked, by the undisturbed error."""
    allowed: Floats
    """(seeds, 3) °: the same, with what a published filter may have left of an error that nothing tells."""
    before: Floats
    """(seeds, 2) °, at `BEFORE`."""
    allowed_before: Floats
    """(seeds, 2) °"""
    sigma: Floats | None
    """(seeds, 3) °, as claimed."""
    nees: Floats | None
    """(seeds, 3)"""
    nees_undisturbed: Floats | None
    """(seeds, 3)"""
    degrees: int
    """Of freedom of the NEES."""

    @property
    def missed(self) -> int:
        """For how many seeds the error was too large 10 s after good measurements were back."""
        return int(np.sum(~(self.error[:, GOAL] <= self.allowed[:, GOAL])))

    @property
    def missed_before(self) -> int:
        """For how many seeds an error before the fault was too large."""
        return int(np.sum(~(self.before <= self.allowed_before).all(axis=1)))

    @property
    def paced(self) -> bool:
        """Whether the goal is met by what a published filter may have left, and not without it."""
        return not self.missed and bool(np.any(self.error[:, GOAL] > self.bound[:, GOAL]))

    @property
    def nees_bound(self) -> Floats:
        """(3,) what the median of the NEES may be."""
        assert self.nees_undisturbed is not None
        return NEES_FACTOR * np.maximum(np.median(self.nees_undisturbed, axis=0), CHI2_MEDIAN[self.degrees])

    @property
    def nees_missed(self) -> bool:
        """Whether it is larger."""
        assert self.nees is not None
        return bool(np.any(~(np.median(self.nees, axis=0) < self.nees_bound)))


def measure(name: str, scene: Scene, fault: Fault, cleans: Sequence[Clean], undisturbed: Undisturbed) -> Result | None:
    """What a fault does to a filter; None where it does not concern it."""
    f = filter_of(name, scene.rate, scene.gyr_range if fault.gyr_range else None)
    if f is None or not (fault.six or f.MAGNETOMETER):
        return None
    calls, kept = [], []
    for clean in cleans:
        rows = fault.rows(clean)
        end = clean.start + clean.length + AFTER[-1] + TAIL
        here = np.flatnonzero(rows.kept & (clean.recording.t < end))
        kept.append(here)
        calls.append({sensor: getattr(rows, sensor)[here] for sensor in ("gyr", "acc", "mag", "t")})
    per_seed = [
        _seed(name, scene, fault, clean, rows, est, before)
        for clean, rows, est, before in zip(cleans, kept, run(f, calls), undisturbed.errors(name, cleans), strict=True)
    ]
    columns = [np.array(column) for column in zip(*per_seed, strict=True)]
    kalman = "covariance" in f.OUTPUTS
    return Result(*columns[:5], *(columns[5:] if kalman else [None] * 3), 2 if observed(name) == "inclination" else 3)


def _seed(
    name: str, scene: Scene, fault: Fault, clean: Clean, kept: NDArray[Any], est: ar.Estimate, without: Errors
) -> tuple[list[float], ...]:
    """The numbers of `Result` for one seed."""
    ref, kind = clean.recording.ref, observed(name)
    assert ref is not None
    t, good = clean.recording.t, clean.start + clean.length
    centres = [good + after for after in AFTER] + [clean.start - before for before in BEFORE]
    windows = [np.abs(t - centre) <= HALF for centre in centres]
    usual = rms(without.angle[usual_rows(clean.recording)])
    bounds = [max(SMALL, FACTOR * max(usual, rms(without.angle[window]))) for window in windows]
    allowed = bounds
    parts = []
    for window in windows:
        rows = np.flatnonzero(window[kept])
        parts.append(Errors.of(kind, est, ref[kept[rows]], rows))
    angles = [rms(part.angle) for part in parts]
    if not fault.told and name in PACES:
        left = _left(name, scene, [_at(kind, est, ref, kept, row) for row in _borders(clean, kept)])
        allowed = [bound + more for bound, more in zip(bounds, left, strict=True)]
    n = len(AFTER)
    found: list[list[float]] = [angles[:n], bounds[:n], allowed[:n], angles[n:], allowed[n:]]
    if parts[0].nees is not None:
        assert without.nees is not None
        assert all(part.nees is not None and part.sigma is not None for part in parts)
        found.append([float(np.median(part.sigma)) for part in parts[:n]])
        found.append([float(np.nanmean(part.nees)) for part in parts[:n]])
        found.append([float(np.nanmean(without.nees[window])) for window in windows[:n]])
    return tuple(found)


def _borders(clean: Clean, kept: NDArray[Any]) -> tuple[int, int]:
    """The last row before a fault and the first one behind it, of those that are left and whose truth is known."""
    assert clean.recording.ref is not None
    t, known = clean.recording.t[kept], np.isfinite(clean.recording.ref[kept, 0])
    return (
        int(np.flatnonzero(known & (t < clean.start))[-1]),
        int(np.flatnonzero(known & (t >= clean.start + clean.length))[0]),
    )


def _at(kind: str, est: ar.Estimate, ref: Floats, kept: NDArray[Any], row: int) -> tuple[float, float]:
    """Inclination and heading error at a row, °."""
    errors = Errors.of(kind, est, ref[kept[[row]]], np.array([row]))
    return float(errors.inclination[0]), float(errors.heading[0])


def _left(name: str, scene: Scene, at: list[tuple[float, float]]) -> list[float]:
    """° that a filter may have left at `AFTER` and `BEFORE`, of its errors just before and just after the fault."""
    inclination, heading = at[1]
    offline = not ar.FILTERS[name].STREAMING
    if offline:
        # It forgets in both directions of time: what was lost stands on both sides.
        inclination, heading = (min(180.0, before + after) for before, after in zip(*at, strict=True))
    left = [PACES[name].left(inclination, heading, after, scene.rate) for after in AFTER]
    return left + [left[AFTER.index(before)] if offline else 0.0 for before in BEFORE]
