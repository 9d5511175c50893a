"""What the values of each axis tell: clipping, wraps, dead and stuck axes, the size of a count."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check._case import BLOCK, Case
from ahrs_rs._check._findings import Finding
from ahrs_rs._clipping import ends, extremes, heap, is_new

FloatArray = NDArray[np.float64]

AXES = "xyz"
NAMES = {"gyr": "gyroscope", "acc": "accelerometer", "mag": "magnetometer"}
UNITS = {"gyr": "rad/s", "acc": "m/s²", "mag": "µT"}
#: A flat end: readings within this part of it, so many of them, and so many in a row.
FLAT, FLAT_ROWS = 0.007, (30, 8)
#: A wrap is a jump by more than this part of twice the range between readings that change by less than the other part.
WRAP, SMOOTH = 0.8, 0.15
#: An axis that stands still for so long, s, while the others move by so many of its usual steps.
STUCK, OTHERS = 1.0, 20.0
#: A dead axis takes a recording of so many rows.
DEAD = 500
#: Counts that a filter feels: rad/s, m/s², part of the field.
COARSE = {"gyr": 0.02, "acc": 0.2, "mag": 0.03}
SOME = 20000


def check_ranges(case: Case) -> Iterator[Finding]:
    """Findings about the values of every axis."""
    for sensor in case.has:
        rows = case.rows(sensor)
        assert rows is not None
        if len(rows) < 50:
            continue
        low, high = extremes(rows)
        factor = case.factors[sensor]
        yield from _dead(sensor, rows, low, high)
        yield from _clipped(case, sensor, rows, low, high, factor)
        if sensor != "mag":
            yield from _wrapped(sensor, rows, low, high, factor)
        yield from _stuck(case, sensor, rows, low, high)
        yield from _counts(sensor, rows, factor)


def _dead(sensor: str, rows: FloatArray, low: FloatArray, high: FloatArray) -> Iterator[Finding]:
    constant = low == high
    if not constant.any() or constant.all() or len(rows) < DEAD:
        return
    named = " and ".join(AXES[k] for k in np.flatnonzero(constant))
    one = np.count_nonzero(constant) == 1
    yield Finding(
        f"{sensor}.dead",
        "error" if one else "warning",
        f"{named} of the {NAMES[sensor]} reads {low[constant][0]:.4g} all the time",
        float(low[constant][0]),
        UNITS[sensor],
        0.97 if one else 0.7,
        "what happens about this axis is not seen" if sensor == "gyr" else "the direction is wrong",
        "check the driver, and which columns are read",
    )


def _clipped(
    case: Case,
    sensor: str,
    rows: FloatArray,
    low: FloatArray,
    high: FloatArray,
    factor: float,
) -> Iterator[Finding]:
    """An end at which readings heap up."""
    new = is_new(rows)
    found = [
        (("" if one.sign > 0 else "-") + AXES[one.axis], one.value, one.readings) for one in ends(rows, new, low, high)
    ]
    if not found:
        yield from _flat(sensor, rows, new, low, high, factor)
        return
    level = float(np.median([abs(one[1]) for one in found])) * abs(factor)
    count = sum(one[2] for one in found)
    shown = f"{np.degrees(level):.4g} °/s" if sensor == "gyr" else f"{level:.4g} {UNITS[sensor]}"
    named = ", ".join(one[0] for one in found)
    case.known[f"{sensor}.clipped"] = level
    remedy = {
        "gyr": f"a larger range of the sensor; the filters' gyr_range={level:.4g} makes them distrust the ends",
        "acc": "a larger range of the sensor",
        "mag": "keep magnets and iron away; a larger range of the sensor",
    }
    yield Finding(
        f"{sensor}.clipped",
        "warning",
        f"{count} readings of the {NAMES[sensor]} are at the end of its range, {shown} ({named})",
        level,
        UNITS[sensor],
        0.95,
        "turns are lost where it clips" if sensor == "gyr" else "readings at the end are wrong in size and direction",
        remedy[sensor],
        {"share": count / len(rows), "ends": {name: value * factor for name, value, _ in found}},
    )


def _flat(
    sensor: str, rows: FloatArray, new: NDArray[np.bool_], low: FloatArray, high: FloatArray, factor: float
) -> Iterator[Finding]:
    """Ends that are flat, with noise on them: a range in units of a calibration that changes, or a steady turn."""
    for axis in range(3):
        if not high[axis] > 0.0 > low[axis] or abs(high[axis] + low[axis]) > 0.03 * high[axis]:
            continue
        found = [heap(rows[:, axis], new, float(end), np.sign(end), FLAT) for end in (high[axis], low[axis])]
        if all(at >= FLAT_ROWS[0] and longest >= FLAT_ROWS[1] and at > near for at, near, longest in found):
            level = float(min(high[axis], -low[axis])) * abs(factor)
            yield Finding(
                f"{sensor}.flat",
                "note",
                f"{AXES[axis]} of the {NAMES[sensor]} has flat ends at ±{level:.4g} {UNITS[sensor]}: it may be clipped",
                level,
                UNITS[sensor],
                0.6,
                "turns are lost where it clips",
                "compare it with the range of the sensor",
                {"axis": AXES[axis]},
            )
            return


def _wrapped(sensor: str, rows: FloatArray, low: FloatArray, high: FloatArray, factor: float) -> Iterator[Finding]:
    """Readings that leave one end of the range and come in at the other."""
    for axis in range(3):
        reach = max(abs(low[axis]), abs(high[axis]))
        if not reach > 0.0 or min(-low[axis], high[axis]) < 0.7 * reach:
            continue
        count, first = 0, -1
        for i in range(0, len(rows) - 3, BLOCK):
            x = rows[i : i + BLOCK + 3, axis]
            step = np.diff(x)
            jump = np.abs(step[1:-1]) > 2.0 * WRAP * reach
            small = SMOOTH * reach
            jump &= (np.abs(step[:-2]) < small) & (np.abs(step[2:]) < small)
            mended = np.abs(step[1:-1]) - 2.0 * reach
            jump &= np.abs(mended) < 2.0 * small
            hits = np.flatnonzero(jump)
            count += hits.size
            first = i + int(hits[0]) + 2 if hits.size and first < 0 else first
        if count >= 2:
            yield Finding(
                f"{sensor}.wrapped",
                "error",
                f"{AXES[axis]} of the {NAMES[sensor]} wraps {count} times at ±{reach * factor:.4g} {UNITS[sensor]}, "
                f"first in row {first}",
                reach * factor,
                UNITS[sensor],
                0.9,
                "the sensor seems to turn the other way there" if sensor == "gyr" else "the direction is wrong there",
                "take the counts as signed numbers of the width that the sensor has, or a larger range",
                {"count": count, "axis": AXES[axis]},
            )
            return


def _stuck(case: Case, sensor: str, rows: FloatArray, low: FloatArray, high: FloatArray) -> Iterator[Finding]:
    """An axis that repeats one value for a second or more while the others go on."""
    least = max(round(STUCK * case.rate), 50)
    for axis in range(3):
        if low[axis] == high[axis]:
            continue
        moved = np.flatnonzero(np.diff(rows[:, axis]) != 0.0)
        edges = np.concatenate([[-1], moved, [len(rows) - 1]])
        lengths = np.diff(edges)
        k = int(np.argmax(lengths))
        if lengths[k] < least:
            continue
        part = rows[int(edges[k]) + 1 : int(edges[k + 1]) + 1]
        others = [one for one in range(3) if one != axis]
        usual = np.median(np.abs(np.diff(rows[:SOME, others], axis=0)), axis=0)
        still = np.isnan(part).any() or (np.diff(part[:, others], axis=0) == 0.0).mean() > 0.5
        if still or (np.ptp(part[:, others], axis=0) < OTHERS * np.maximum(usual, 1e-12)).any():
            continue
        yield Finding(
            f"{sensor}.stuck",
            "warning",
            f"{AXES[axis]} of the {NAMES[sensor]} stands at {part[0, axis]:.4g} for {lengths[k] / case.rate:.3g} s "
            "while the others move",
            float(lengths[k] / case.rate),
            "s",
            0.85,
            "what happens about this axis is not seen meanwhile",
            "check the driver; treat these rows as missing (NaN)",
            {"row": int(edges[k]) + 1, "axis": AXES[axis]},
        )
        return


def _counts(sensor: str, rows: FloatArray, factor: float) -> Iterator[Finding]:
    """The size of a count, where readings take few values."""
    some = rows[:SOME]
    some = some[np.isfinite(some).all(axis=1)]
    if len(some) < 200:
        return
    steps = []
    for axis in range(3):
        values = np.unique(some[:, axis])
        if 3 < values.size < 0.3 * len(some):
            steps.append(float(np.quantile(np.diff(values), 0.1)))
    if not steps:
        return
    step = max(steps) * abs(factor)
    limit = COARSE[sensor]
    if sensor == "mag":
        limit *= float(np.median(np.linalg.norm(some, axis=1))) * abs(factor)
    yield Finding(
        f"{sensor}.counts",
        "note" if step > limit else "ok",
        f"a count of the {NAMES[sensor]} is {step:.3g} {UNITS[sensor]}",
        step,
        UNITS[sensor],
        0.8,
        "turns slower than a count are not seen" if step > limit else "",
        "a smaller range of the sensor, if it allows one" if step > limit else "",
    )
