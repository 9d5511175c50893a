"""The gyroscope: bias at rest and its drift, noise, scale against the field and gravity."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check import _changes
from ahrs_rs._check._case import BoolArray, Case
from ahrs_rs._check._findings import Finding, confidence
from ahrs_rs._check._refine import Refined, refine

FloatArray = NDArray[np.float64]

DEGREE = np.pi / 180.0
#: Biases at rest, rad/s: told from the first on; filters that estimate it take up to about the second.
BIAS = (0.2 * DEGREE, 1.5 * DEGREE)
#: Difference of the bias between rests, rad/s.
DRIFT = (0.1 * DEGREE, 0.5 * DEGREE)
#: Noise density, rad/s/√Hz: data sheets have 0.003 to 0.03 °/s/√Hz.
DENSITY = (2e-4 * DEGREE, 0.1 * DEGREE)
#: A scale that differs by so much, by so many standard errors; and what may be left of windows for it to be believed.
SCALE, ERRORS, LEFT = (0.02, 0.05), 5.0, 0.1
#: Cells at rest that a bias needs, and the largest turn of the field between neighbours of them, rad.
RESTS, FIELD_TURN = 4, 0.006
#: Without a magnetometer a steady turn about the vertical, up to this rate, is no bias for sure, rad/s.
TURNTABLE = 1.0 * DEGREE


def check_gyroscope(case: Case) -> Iterator[Finding]:
    """Findings about bias, drift, noise and scale."""
    if "gyr" not in case.has:
        return
    yield from _at_rest(case)
    yield from _scale(case)


def resting_cells(case: Case) -> BoolArray:
    """(c,) the cells at rest, in which the field does not turn either."""
    still = np.array(case.still())
    if "mag" not in case.has:
        return still
    cells = case.cells("mag")
    norm = np.linalg.norm(cells.mean, axis=1)
    direction = cells.mean / np.maximum(norm, 1e-12)[:, np.newaxis]
    noise = np.linalg.norm(cells.std, axis=1) / np.maximum(norm, 1e-12)
    noise /= np.sqrt(np.maximum(cells.share * len(case.recording) / max(len(norm), 1), 1.0))
    limit = np.maximum(FIELD_TURN, 6.0 * noise)
    turned = np.zeros(len(norm), dtype=np.bool_)
    step = np.linalg.norm(np.diff(direction, axis=0), axis=1)
    far = (step > np.maximum(limit[1:], limit[:-1])) & still[1 : len(norm)] & still[: len(norm) - 1]
    turned[1:] |= far
    turned[:-1] |= far
    still[: len(norm)] &= ~turned
    return still


def _at_rest(case: Case) -> Iterator[Finding]:
    cells = case.cells("gyr")
    still = np.flatnonzero(resting_cells(case)[: len(cells.t)])
    if still.size < RESTS:
        yield Finding(
            "gyr.bias", "note", "cannot tell the bias: the sensor never rests for two seconds", None, "rad/s", 0.5
        )
        return
    mean = cells.mean[still]
    bias = np.asarray(np.median(mean, axis=0), dtype=np.float64)
    error = 1.2 * mean.std(axis=0, ddof=1) / np.sqrt(still.size)
    case.known["bias"] = bias
    size = float(np.linalg.norm(bias))
    severity = "ok" if size < BIAS[0] else "note" if size < BIAS[1] else "warning"
    sure = "mag" in case.has or size < TURNTABLE
    change = None
    if sure and size > max(5.0 * float(np.linalg.norm(error)), 0.02 * DEGREE):
        shown = ", ".join(f"{one:.4g}" for one in bias)
        change = _changes.calibrated("gyr.bias", "gyr", np.eye(3), bias, f"gyr: bias ({shown}) rad/s taken off")
    yield Finding(
        "gyr.bias",
        severity,
        f"at rest it reads {size / DEGREE:.3g} °/s" + ("" if sure else ", or it turns steadily about the vertical"),
        size,
        "rad/s",
        0.95 if sure else 0.6,
        "" if severity == "ok" else "integrated it is a drift of as much each second, until the filter has learnt it",
        ""
        if severity == "ok"
        else "take it off, or use a filter that estimates it (VQF, MEKF), with a rest at the start",
        {"bias": bias, "standard_error": error, "rests": int(still.size)},
        change,
    )
    yield from _drift(cells.t[still], mean)
    yield from _noise(case, cells.std[still])


def _drift(t: FloatArray, mean: FloatArray) -> Iterator[Finding]:
    if t[-1] - t[0] < 10.0:
        return
    third = max(len(t) // 3, 2)
    first, last = mean[:third], mean[-third:]
    apart = last.mean(axis=0) - first.mean(axis=0)
    error = np.sqrt((first.var(axis=0, ddof=1) + last.var(axis=0, ddof=1)) / third)
    size = float(np.linalg.norm(apart))
    if size < max(DRIFT[0], 5.0 * float(np.linalg.norm(error))):
        return
    yield Finding(
        "gyr.drift",
        "warning" if size > DRIFT[1] else "note",
        f"its bias changes by {size / DEGREE:.3g} °/s from the first rests to the last",
        size,
        "rad/s",
        0.85,
        "one constant taken off does not do",
        "a filter that estimates the bias all the time; let the sensor warm up",
        {"change": apart, "seconds": float(t[-1] - t[0])},
    )


def _noise(case: Case, std: FloatArray) -> Iterator[Finding]:
    quiet = np.quantile(std, 0.2, axis=0)
    density = float(np.max(quiet)) / np.sqrt(0.5 * case.rate)
    if density == 0.0:
        return
    shown = density / DEGREE
    loud, mute = density > DENSITY[1], density < DENSITY[0]
    words = (
        "far more than parts have"
        if loud
        else "less than parts have: filtered, or simulated"
        if mute
        else "as parts have"
    )
    yield Finding(
        "gyr.noise",
        "note" if loud or mute else "ok",
        f"noise at rest {shown:.2g} °/s/√Hz, {words} (0.003 to 0.03)",
        density,
        "rad/s/√Hz",
        0.7,
        "the attitude wanders more than it has to" if loud else "",
        "look for vibration at rest, or a range that is too large" if loud else "",
    )


def refined(case: Case, sensor: str) -> Refined | None:
    """The small errors of a vector against the gyroscope, computed once."""
    key = f"refined {sensor}"
    if key not in case.known:
        coarse = case.coarse()
        vectors = coarse.acc if sensor == "acc" else coarse.mag
        seconds, part = (2.0, 1.0) if sensor == "acc" else (1.0, 0.3)
        case.known[key] = None if vectors is None else refine(coarse, vectors, seconds, part, constant=sensor == "mag")
    found: Refined | None = case.known[key]
    return found


def _scale(case: Case) -> Iterator[Finding]:
    verdicts = case.known.get("verdicts", {})
    told: list[tuple[float, float, str]] = []
    for sensor, limit in (("mag", LEFT), ("acc", 0.5 * LEFT)):
        verdict = verdicts.get(sensor)
        if verdict is None or verdict.state not in ("tied", "other") or "axes" in case.known:
            continue
        found = refined(case, sensor)
        if found is not None and found.left < limit and found.scale_error < SCALE[0]:
            told.append((found.scale, found.scale_error, sensor))
    if not told:
        if verdicts:
            yield Finding(
                "gyr.scale", "note", "cannot tell its scale: too little turns that the others show", None, "", 0.5
            )
        return
    scale, error, sensor = min(told, key=lambda one: one[1])
    score = abs(scale) / max(error, 1e-6)
    agree = all(abs(one[0] - scale) < 4.0 * np.hypot(one[1], error) + 0.01 for one in told)
    large = abs(scale) > SCALE[0] and score > ERRORS and agree
    grave = large and abs(scale) > SCALE[1]
    yield Finding(
        "gyr.scale",
        "warning" if grave else "note" if large else "ok",
        f"its turns have to be multiplied by {1.0 + scale:.4f} ± {error:.4f} to be those of the "
        + {"mag": "field", "acc": "vertical"}[sensor],
        1.0 + scale,
        "",
        confidence(score) if large else 0.9,
        f"a turn of 90° is seen as {90.0 / (1.0 + scale):.1f}°" if large else "",
        "calibrate its scale by known turns (ahrs-rs calibrate gyr)" if large else "",
        {"standard_error": error},
    )
