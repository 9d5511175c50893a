"""Recordings for the tests of `ahrs_rs.check`, and faults that are planted into them."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import ahrs_rs as ar

DEGREE = np.pi / 180.0


@functools.cache
def good(duration: float = 60.0, seed: int = 0) -> ar.Recording:
    """A sensor in the hand: turns by far more than 90° about all axes, with rests. At its start y is up by 54°."""
    return ar.simulate.demo(duration=duration, seed=seed)


def with_rows(source: ar.Recording, **rows: Any) -> ar.Recording:
    """The recording with other rows."""
    given = {name: getattr(source, name) for name in ("t", "gyr", "acc", "mag", "ref", "mask", "temperature")}
    return ar.Recording(**{**given, "meta": dict(source.meta), **rows})


def times(source: ar.Recording, sensor: str, factor: Any) -> ar.Recording:
    """The readings of a sensor times a factor (for each axis one)."""
    return source.changed(lambda name, x: x * factor if name == sensor else x)


def turned(source: ar.Recording, sensor: str, matrix: Any) -> ar.Recording:
    """The readings of a sensor in other axes."""
    return source.changed(lambda name, x: x @ np.asarray(matrix).T if name == sensor else x)


def added(source: ar.Recording, sensor: str, vector: Any) -> ar.Recording:
    """A constant vector in all readings of a sensor."""
    return source.changed(lambda name, x: x + np.asarray(vector) if name == sensor else x)


def grave(report: ar.Report) -> set[str]:
    """The codes of warnings and errors."""
    return {one.code for one in report.findings if one.severity in ("warning", "error")}


def vqf_error(recording: ar.Recording, truth: ar.Recording) -> float:
    """RMSE of VQF in degrees."""
    est = ar.VQF(rate=recording.rate).run(recording)
    assert truth.ref is not None
    return float(ar.metrics.score(est.quat, truth.ref, mask=truth.mask).total)
