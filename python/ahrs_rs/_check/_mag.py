"""The magnetometer: hard and soft iron, disturbed parts, delay, repeated rows, and what the place says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check import _changes
from ahrs_rs._check._acc import misaligned
from ahrs_rs._check._case import BLOCK, Case
from ahrs_rs._check._findings import Finding, confidence
from ahrs_rs._check._gyr import refined
from ahrs_rs._check._signs import expected_dip

if TYPE_CHECKING:
    from ahrs_rs._recording import Recording
    from ahrs_rs.calibration import EllipsoidFit

FloatArray = NDArray[np.float64]

#: Hard iron over the field: told from the first on, grave from the second; by so many standard errors.
IRON, ERRORS = (0.05, 0.3), 5.0
#: Soft iron: the largest over the smallest gain, less 1.
SOFT = (0.05, 0.25)
#: A calibration is applied where it explains the norms: what is left of their deviation, the directions that were seen.
EXPLAINS, COVERED = 0.4, 0.4
#: The two ways to find the offset, by the norms and by the turns, agree within this part of the field.
AGREE = 0.08
#: A cell is disturbed whose norm is off by this part; told and grave parts of the time.
DISTURBED, TIME = 0.15, (0.05, 0.4)
#: Delays, s: told, grave; by so many standard errors. A change is made from the first on.
DELAY, DELAY_ERRORS = (0.004, 0.05), 5.0
#: Readings of the gyroscope that the delay is sought in, and at most so many a second.
DELAY_ROWS, DELAY_SECONDS = 12000, 90.0
#: Rows that repeat the one before: from this part on the magnetometer is slower than the rows.
HELD = 0.2
#: Against the model of the field: dip, rad, and norm.
DIP, NORM = np.radians(10.0), 0.25


def check_magnetometer(case: Case) -> Iterator[Finding]:
    """Findings about iron, disturbances, delay, rate and place."""
    if "mag" not in case.has:
        return
    yield from _held(case)
    yield from _iron(case)
    yield from _disturbed(case)
    yield from misaligned(case, "mag", "magnetometer", 0.06)
    yield from _delay(case)
    yield from _place(case)


def _held(case: Case) -> Iterator[Finding]:
    rows = case.rows("mag")
    assert rows is not None
    if case.recording.has_own_clocks or len(rows) < 100:
        return
    same = np.zeros(len(rows), dtype=np.bool_)
    for i in range(0, len(rows) - 1, BLOCK):
        end = min(i + BLOCK, len(rows) - 1)
        same[i + 1 : end + 1] = (rows[i + 1 : end + 1] == rows[i:end]).all(axis=1)
    there = int(np.count_nonzero(np.isfinite(rows).all(axis=1)))
    share = int(np.count_nonzero(same)) / max(there, 1)
    if share < HELD or share > 0.995:
        return
    rate = case.rate * (there - np.count_nonzero(same)) / len(rows)
    gyr = case.rows("gyr")
    whole = gyr is not None and np.mean((np.diff(gyr[:20000], axis=0) == 0.0).all(axis=1)) > 0.5 * share
    change = None
    if not whole:
        change = _changes.blanked(
            "mag.repeated", "mag", same, f"mag: {int(same.sum())} repeated rows taken for missing"
        )
    yield Finding(
        "mag.repeated",
        "note",
        f"it gives {rate:.3g} readings a second; {100.0 * share:.0f} % of the rows repeat the one before",
        rate,
        "Hz",
        0.95,
        "a reading that is held is late by up to its step, and counts several times",
        'take repeated rows for missing (NaN), or repeated="missing" of the filters',
        {"share": share},
        change,
    )


def _iron(case: Case) -> Iterator[Finding]:
    coarse = case.coarse()
    assert coarse.mag is not None
    readings = coarse.mag[np.isfinite(coarse.mag).all(axis=1)]
    readings = readings[:: max(len(readings) // 8000, 1)]
    fit, why = _ellipsoid(readings)
    turns = refined(case, "mag") if _settled(case) else None
    size = float(np.median(np.linalg.norm(readings, axis=1)))
    by_turns = None
    if turns is not None and turns.left < 0.15:
        by_turns = (turns.constant, turns.constant_error)
    if fit is None and by_turns is None:
        yield Finding("mag.iron", "note", f"cannot tell hard iron: {why}", None, "", 0.5)
        return
    field = fit.norm if fit is not None else size
    offset = fit.calibration.offset if fit is not None else by_turns[0] if by_turns else np.zeros(3)
    score = _score(fit, by_turns)
    ratio = float(np.linalg.norm(offset)) / max(field, 1e-12)
    gains = np.asarray(np.linalg.eigvalsh(fit.calibration.matrix)) if fit is not None else np.ones(3)
    soft = float(gains.max() / gains.min() - 1.0)
    agree = by_turns is not None and fit is not None and _agrees(fit, by_turns, field)
    large = score > ERRORS and (ratio > IRON[0] or (fit is not None and soft > SOFT[0]))
    if large:
        case.known["iron"] = offset
    contradicted = by_turns is not None and fit is not None and not agree
    grave = large and not contradicted and (ratio > IRON[1] or soft > SOFT[1])
    change = None
    if fit is not None and large and agree and fit.coverage > COVERED:
        explained = fit.deviation_after < EXPLAINS * fit.deviation_before
        shown = ", ".join(f"{one:.3g}" for one in offset)
        if explained:
            text = f"mag: hard iron ({shown}) taken off, soft iron of {100.0 * soft:.2g} %"
            change = _changes.calibrated("mag.iron", "mag", fit.calibration.matrix, offset, text)
    seen = "" if fit is None else f"soft iron of {100.0 * soft:.2g} %; {fit.coverage:.0%} of the directions were seen"
    how = f", {seen or 'by its turns'}"
    yield Finding(
        "mag.iron",
        "warning" if grave else "note" if large else "ok",
        f"hard iron of {100.0 * ratio:.3g} % of the field{how}",
        ratio,
        "of the field",
        confidence(score) if large and not contradicted else 0.6 if contradicted else 0.9,
        f"the heading is off by up to {np.degrees(np.arctan(min(2.0 * ratio, 10.0))):.0f}° with the attitude"
        if large
        else "",
        "calibrate it: turn the sensor in all directions (ahrs-rs calibrate mag)" if large else "",
        {
            "offset": offset,
            "by_turns": None if by_turns is None else by_turns[0],
            "coverage": None if fit is None else fit.coverage,
            "deviation_before": None if fit is None else fit.deviation_before,
            "deviation_after": None if fit is None else fit.deviation_after,
        },
        change,
    )


def _settled(case: Case) -> bool:
    """Whether the axes are those of the gyroscope, or were put right."""
    verdict = case.known.get("verdicts", {}).get("mag")
    return verdict is not None and (verdict.state == "tied" or (verdict.state == "other" and bool(case.rotations)))


def _ellipsoid(readings: FloatArray) -> tuple[EllipsoidFit | None, str]:
    from ahrs_rs.calibration import CalibrationError, ellipsoid

    why = "too few readings"
    for parameters in (9, 6):
        try:
            return ellipsoid(readings, parameters=parameters, name="mag"), ""
        except (CalibrationError, ValueError) as error:
            why = str(error).removeprefix("mag: ")
    return None, why


def _score(fit: EllipsoidFit | None, by_turns: tuple[FloatArray, FloatArray] | None) -> float:
    if fit is not None:
        return float(np.linalg.norm(fit.values[-3:])) / max(float(np.linalg.norm(fit.std[-3:])), 1e-12)
    assert by_turns is not None
    return float(np.max(np.abs(by_turns[0]) / np.maximum(by_turns[1], 1e-12)))


def _agrees(fit: EllipsoidFit, by_turns: tuple[FloatArray, FloatArray], field: float) -> bool:
    """Whether norms and turns say the same of the offset, as far as the turns tell it."""
    apart = fit.calibration.offset - by_turns[0]
    return bool((np.abs(apart) < AGREE * field + 3.0 * by_turns[1]).all()) and bool(
        (by_turns[1] < 0.1 * field).sum() >= 2
    )


def _disturbed(case: Case) -> Iterator[Finding]:
    cells = case.cells("mag")
    known = cells.share > 0.0
    mean = cells.mean[known]
    iron = case.known.get("iron")
    if iron is not None:
        mean = mean - iron
    norms = np.linalg.norm(mean, axis=1)
    if norms.size < 10:
        return
    middle = float(np.median(norms))
    off = np.abs(norms / max(middle, 1e-12) - 1.0)
    share = float(np.mean(off > DISTURBED))
    if share < 0.01:
        yield Finding("mag.disturbed", "ok", "its norm is steady", share, "of the time", 0.9)
        return
    first = float(cells.t[known][np.argmax(off > DISTURBED)] - case.recording.t[0] * case.factors["t"])
    yield Finding(
        "mag.disturbed",
        "note" if share < TIME[1] else "warning",
        f"its norm is off by more than {100.0 * DISTURBED:.0f} % over {100.0 * share:.2g} % of the time, first at "
        f"{first:.3g} s",
        share,
        "of the time",
        0.8,
        "the heading follows iron and magnets near by, or the calibration is none",
        "a filter that rejects disturbances (VQF, MEKF), away from iron; calibrate hard iron first",
        {"largest": float(off.max())},
    )


def _delay(case: Case) -> Iterator[Finding]:
    from ahrs_rs.calibration import CalibrationError, mag_delay

    if "gyr" not in case.has or not _settled(case):
        return
    part = _busiest(case)
    if part is None:
        return
    try:
        found = mag_delay(part)
    except (CalibrationError, ValueError, np.linalg.LinAlgError) as error:
        yield Finding("mag.delay", "note", f"cannot tell its delay: {str(error).removeprefix('mag: ')}", None, "s", 0.5)
        return
    score = abs(found.delay) / max(found.standard_error, 1e-5)
    large = abs(found.delay) > DELAY[0] and score > DELAY_ERRORS
    grave = large and abs(found.delay) > DELAY[1]
    late = "late" if found.delay > 0.0 else "early"
    change = None
    if large:
        text = f"mag: moved by {-1e3 * found.delay:.1f} ms"
        change = _changes.delayed("mag.delay", "mag", found.delay, text)
    yield Finding(
        "mag.delay",
        "warning" if grave else "note" if large else "ok",
        f"it is {1e3 * abs(found.delay):.1f} ± {1e3 * found.standard_error:.1f} ms {late}",
        found.delay,
        "s",
        confidence(score) if large else 0.9,
        "while it turns, the heading lags by the turn over this time" if large else "",
        f"mag_delay={found.delay:.4f} of the filters that have it, or move its stamps" if large else "",
        {"standard_error": found.standard_error, "windows": found.windows},
        change,
    )


def _busiest(case: Case) -> Recording | None:
    """The part of the recording that turns most, with units and axes put right."""
    import dataclasses

    recording = case.recording
    group = max(int(case.rate // 300.0), 1)
    count = min(len(recording), int(min(DELAY_ROWS * group, DELAY_SECONDS * case.rate)))
    cells = case.cells("gyr")
    if not len(cells.t) or case.factors["t"] != 1.0:
        return None
    length = max(len(recording) // len(cells.t), 1)
    activity = np.cumsum(np.concatenate([[0.0], np.nan_to_num(np.linalg.norm(cells.std, axis=1))]))
    wide = max(count // length, 1)
    start = int(np.argmax(activity[wide:] - activity[:-wide])) * length if len(activity) > wide else 0
    part = recording[start : start + count]
    turned_gyr: FloatArray = part.require("gyr") * case.factors["gyr"]
    turned_mag = np.array(part.require("mag"))
    same = np.zeros(len(part), dtype=np.bool_)
    same[1:] = (turned_mag[1:] == turned_mag[:-1]).all(axis=1)
    if same.mean() > HELD:
        turned_mag[same] = np.nan
    if "gyr" in case.rotations:
        turned_gyr = turned_gyr @ case.rotations["gyr"].T
    if "mag" in case.rotations:
        turned_mag = turned_mag @ case.rotations["mag"].T
    t, rate = part.t, part.rate
    if group > 1:
        used = len(part) // group * group
        t = t[group - 1 : used : group]
        turned_gyr = turned_gyr[:used].reshape(-1, group, 3).mean(axis=1)
        turned_mag = turned_mag[group - 1 : used : group]
        rate = rate / group
    return dataclasses.replace(
        part, t=t, gyr=turned_gyr, mag=turned_mag, acc=None, ref=None, mask=None, temperature=None, rate=rate, others={}
    )


def _place(case: Case) -> Iterator[Finding]:
    expected = expected_dip(case)
    if expected is None:
        return
    field = case.known.get("field")
    cells = case.cells("mag")
    norm = float(np.nanmedian(np.linalg.norm(cells.mean, axis=1)))
    if field is not None and abs(norm / field.norm - 1.0) > NORM:
        yield Finding(
            "mag.norm",
            "note",
            f"its norm is {norm:.4g} µT, that of the earth's field there {field.norm:.4g} µT",
            norm,
            "µT",
            0.8,
            "iron near by, a calibration that is none, or another unit",
            "calibrate it (ahrs-rs calibrate mag --norm), away from iron",
            {"expected": field.norm},
        )
    if "acc" not in case.has:
        return
    acc = case.cells("acc")
    count = min(len(acc.t), len(cells.t))
    known = (acc.share[:count] > 0.05) & (cells.share[:count] > 0.0)
    a, m = acc.mean[:count][known], cells.mean[:count][known]
    if len(a) < 10:
        return
    product = np.einsum("ij,ij->i", a, m) / np.maximum(np.linalg.norm(a, axis=1) * np.linalg.norm(m, axis=1), 1e-12)
    dips = np.arcsin(np.clip(-product, -1.0, 1.0))
    dip, spread = float(np.median(dips)), float(np.quantile(np.abs(dips - np.median(dips)), 0.68))
    off = min(abs(dip - expected), abs(-dip - expected))  # the sign is told elsewhere
    yield Finding(
        "mag.dip",
        "note" if off > DIP else "ok",
        f"its dip is {np.degrees(dip):.1f}° ± {np.degrees(spread):.1f}°, that of the earth's field there "
        f"{np.degrees(expected):.1f}°",
        dip,
        "rad",
        0.7,
        "the field is that of iron near by, or the calibration is none" if off > DIP else "",
        "calibrate it, away from iron" if off > DIP else "",
        {"expected": expected},
    )
