"""Recordings that lose something: what the tests of losses, recoveries and clocks share."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from signals import FIELD, RATE, UP, Floats, Signals, angle_between, inclination_between, quats, rotation, turned

#: The filters that see where they are.
SEEING = [name for name, cls in ar.FILTERS.items() if cls.FEEDBACK]
#: Those that are at every sample where the measurements are, and have no time constant.
AT_ONCE = ("Tilt", "Ecompass", "Trigonometric")
#: The other ones that go on from sample to sample.
LASTING = [name for name in SEEING if ar.FILTERS[name].STREAMING and name not in AT_ONCE]

#: Samples until a sensor at rest turns, of its turn, and behind it.
BEFORE, TURN, BEHIND = 2000, 40, 3000


def resting(
    seed: int, *, angle: float = 0.5 * np.pi, axis: Floats | None = None, pose: Floats | None = None
) -> Signals:
    """A sensor that rests for 20 s, turns by an angle (rad) within 0.4 s, and rests for 30 s again.

    The noise is that of a good sensor: even `Ecompass`, for which the noise of one sample is one of the attitude, is
    right to a degree (a field of 25 µT along the ground, known to 0.05 µT, is known to 0.1°).
    """
    draw = np.random.default_rng(seed)
    if axis is None:
        axis = draw.standard_normal(3)
    axis = axis / np.linalg.norm(axis)
    if pose is None:
        pose = quats(Rotation.random(random_state=seed))
    count = BEFORE + TURN + BEHIND
    run = angle * np.clip((np.arange(count) - BEFORE + 1) / TURN, 0.0, 1.0)
    truth = turned(pose, run[:, None] * axis)
    gyr = 0.002 * draw.standard_normal((count, 3))
    gyr[BEFORE : BEFORE + TURN] += angle / TURN * RATE * axis
    back = rotation(truth).inv()
    return Signals(
        t=np.arange(count) / RATE,
        gyr=gyr,
        acc=back.apply(UP) + 0.01 * draw.standard_normal((count, 3)),
        mag=back.apply(FIELD) + 0.05 * draw.standard_normal((count, 3)),
        truth=truth,
        before=np.asarray(pose),
    )


def kept(signals: Signals, rows: NDArray[Any]) -> Signals:
    """The rows that are left."""
    return Signals(
        **{name: getattr(signals, name)[rows] for name in ("t", "gyr", "acc", "mag", "truth")}, before=signals.before
    )


def lost(signals: Signals, how: str, rows: slice = slice(BEFORE, BEFORE + TURN), limit: float = 1.0) -> Signals:
    """What is left of a recording whose sensors fail in some rows."""
    if how == "gyr is NaN":
        return signals.without(gyr=rows)
    if how == "all sensors are NaN":
        return signals.without(gyr=rows, acc=rows, mag=rows)
    if how == "rows are missing":
        left = np.ones(len(signals), dtype=bool)
        left[rows] = False
        return kept(signals, left)
    gyr = signals.gyr.copy()
    beyond = np.abs(gyr) > limit
    if how == "gyr is clipped":
        gyr[beyond] = np.sign(gyr[beyond]) * limit
    elif how == "gyr has the other sign":
        gyr[beyond] *= -1.0
    elif how == "gyr is wrapped":
        gyr[beyond] = (gyr[beyond] + limit) % (2.0 * limit) - limit
    else:
        raise ValueError(how)
    return replace(signals, gyr=gyr)


def set_ahead(signals: Signals, row: int, seconds: float) -> Signals:
    """With a clock that leaps before a row."""
    t = signals.t.copy()
    t[row:] += seconds
    return replace(signals, t=t)


def run_all(f: ar.Filter, recordings: Sequence[Signals], *, nine: bool = True, **keywords: Any) -> list[ar.Estimate]:
    """Estimates by the stamps."""
    calls = [
        {"gyr": one.gyr, "acc": one.acc, "mag": one.mag if nine else None, "t": one.t, **keywords} for one in recordings
    ]
    return ar.run_many(f, calls)


def observed_error(cls: type[ar.Filter], quat: Floats, truth: Floats) -> Floats:
    """Errors (T,) in rad: total where the filter uses a magnetometer, else that of the inclination."""
    return angle_between(quat, truth) if cls.MAGNETOMETER else inclination_between(quat, truth)


def largest_errors(
    f: ar.Filter,
    recordings: Sequence[Signals],
    after: float,
    *,
    error: Callable[[Floats, Floats], Floats] | None = None,
    **keywords: Any,
) -> Floats:
    """The largest error (rad) of each recording from a time in s on, in what the filter observes or another measure."""
    estimates = run_all(f, recordings, **keywords)
    measure = functools.partial(observed_error, type(f)) if error is None else error
    errors = [
        measure(est.quat[one.t > after], one.truth[one.t > after]).max()
        for est, one in zip(estimates, recordings, strict=True)
    ]
    return np.array(errors)
