"""The accelerometer: its norm at rest, vibration, misalignment, and the distance from the centre of rotation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check import _changes
from ahrs_rs._check._case import Case
from ahrs_rs._check._findings import Change, Finding, confidence
from ahrs_rs._check._gyr import refined
from ahrs_rs._constants import GRAVITY

FloatArray = NDArray[np.float64]

#: The norm at rest, over gravity: told from the first difference on, grave from the second.
NORM = (0.02, 0.06)
#: Directions of two rests that differ by more than this are two attitudes, rad; a calibration needs so many of them.
APART, ATTITUDES = 0.5, 8
#: Misalignment in degrees: told, grave; by so many standard errors, where little is left.
TURNED, ERRORS, LEFT = (3.0, 8.0), 5.0, 0.05
#: A lever that is told, m; the part of the acceleration that it has to explain.
LEVER, EXPLAINED = 0.1, 0.3


def check_accelerometer(case: Case) -> Iterator[Finding]:
    """Findings about norm, misalignment and lever."""
    if "acc" not in case.has:
        return
    yield from _norm(case)
    yield from misaligned(case, "acc", "accelerometer", LEFT)
    yield from _lever(case)


def gravity_here(case: Case) -> float:
    """m/s² at the place, or the standard one."""
    if case.place is None:
        return GRAVITY
    from ahrs_rs import earth

    return float(earth.gravity(case.place[0], case.place[2]))


def _norm(case: Case) -> Iterator[Finding]:
    cells = case.cells("acc")
    still = case.still()[: len(cells.t)]
    mean = cells.mean[still]
    if len(mean) < 4:
        yield Finding("acc.norm", "note", "cannot tell its scale: the sensor never rests", None, "m/s²", 0.5)
        return
    gravity = gravity_here(case)
    norms = np.linalg.norm(mean, axis=1)
    attitudes = _attitudes(mean / norms[:, np.newaxis])
    worst = float(np.max(np.abs(norms / gravity - 1.0)))
    middle = float(np.median(norms))
    off = max(abs(middle / gravity - 1.0), abs(float(np.quantile(norms, 0.9)) / gravity - 1.0))
    off = max(off, abs(float(np.quantile(norms, 0.1)) / gravity - 1.0))
    if off > 0.5:
        return  # another unit, or no gravity: told there
    severity = "ok" if off < NORM[0] else "note" if off < NORM[1] else "warning"
    change, said = _calibration(case, mean, gravity, len(attitudes)) if off > 0.005 else (None, "")
    yield Finding(
        "acc.norm",
        severity,
        f"at rest it reads {middle:.4g} m/s² ({norms.min():.4g} to {norms.max():.4g}) in {len(attitudes)} attitudes"
        + said,
        middle,
        "m/s²",
        0.95,
        "" if severity == "ok" else f"the vertical is off by up to {np.degrees(min(off, 1.0)):.1f}° in some attitudes",
        "" if severity == "ok" else "calibrate it: rests with each axis up and down (ahrs-rs calibrate acc)",
        {"attitudes": len(attitudes), "worst": worst},
        change,
    )


def _attitudes(directions: FloatArray) -> list[FloatArray]:
    """Directions that are more than half a radian apart."""
    found: list[FloatArray] = []
    for one in directions[:: max(len(directions) // 500, 1)]:
        if all(one @ other < np.cos(APART) for other in found):
            found.append(one)
    return found


def _calibration(case: Case, mean: FloatArray, gravity: float, attitudes: int) -> tuple[Change | None, str]:
    """Scale and offset by the rests, where these are enough and the fit explains them."""
    from ahrs_rs.calibration import CalibrationError, ellipsoid

    if attitudes < ATTITUDES:
        return None, ""
    try:
        fit = ellipsoid(mean, parameters=6, norm=gravity, name="acc")
    except (CalibrationError, ValueError):
        return None, ""
    if fit.residual_rms > 0.01 * gravity or fit.deviation_after > 0.5 * fit.deviation_before:
        return None, ""
    offset = ", ".join(f"{one:.3g}" for one in fit.calibration.offset)
    scale = ", ".join(f"{one:.4f}" for one in np.diag(fit.calibration.matrix))
    text = f"acc: offset ({offset}) m/s² taken off, scale ({scale})"
    change = _changes.calibrated("acc.norm", "acc", fit.calibration.matrix, fit.calibration.offset, text)
    return change, f"; an offset of ({offset}) m/s² and a scale of ({scale}) explain it"


def misaligned(case: Case, sensor: str, name: str, left: float) -> Iterator[Finding]:
    """The small rotation between a vector's axes and those of the gyroscope."""
    verdict = case.known.get("verdicts", {}).get(sensor)
    unsettled = verdict is not None and verdict.state == "other" and not case.rotations
    if verdict is None or verdict.state == "unknown" or unsettled:
        return
    found = refined(case, sensor)
    if found is None or found.left > left:
        return
    angle = float(np.degrees(np.linalg.norm(found.rotation)))
    error = float(np.degrees(np.linalg.norm(found.rotation_error)))
    score = angle / max(error, 1e-3)
    large = angle > TURNED[0] and score > ERRORS
    grave = large and angle > TURNED[1]
    yield Finding(
        f"axes.{sensor}_misaligned",
        "warning" if grave else "note" if large else "ok",
        f"the {name} is turned against the gyroscope by {angle:.2g}° ± {error:.1g}°",
        angle,
        "°",
        confidence(score) if large else 0.9,
        "the attitude is drawn to and fro while it turns" if large else "",
        "turn its readings by the given vector" if large else "",
        {"rotation_vector": np.degrees(found.rotation), "standard_error": np.degrees(found.rotation_error)},
    )


def _lever(case: Case) -> Iterator[Finding]:
    """How far the accelerometer is from the centre of rotation: a = g + ([α×] + [ω×]²) r."""
    from ahrs_rs import _quat
    from ahrs_rs.filters import FILTERS

    coarse = case.coarse()
    if "gyr" not in case.has or coarse.acc is None or len(coarse) < 500:
        return
    known = np.isfinite(coarse.turn).all(axis=1) & np.isfinite(coarse.acc).all(axis=1)
    if known.mean() < 0.8 or case.known.get("verdicts", {}).get("acc") is None:
        return
    rate = coarse.rate
    omega = np.nan_to_num(coarse.turn) * rate
    if float(np.sqrt(np.mean(np.sum(omega**2, axis=1)))) < 0.5:
        return
    quat = np.asarray(FILTERS["VQF"](rate=rate).run(np.ascontiguousarray(omega), np.nan_to_num(coarse.acc)).quat)
    smooth = np.ones(5) / 5.0
    w = np.column_stack([np.convolve(omega[:, k], smooth, "same") for k in range(3)])
    a = np.column_stack([np.convolve(np.nan_to_num(coarse.acc[:, k]), smooth, "same") for k in range(3)])
    alpha = np.gradient(w, axis=0) * rate
    rows = slice(int(10 * rate) if len(coarse) > 20 * rate else 0, len(coarse), max(len(coarse) // 20000, 1))
    up = _quat.rotate(_quat.conjugate(np.asarray(quat[rows], dtype=np.float64)), np.array([0.0, 0.0, 1.0]))
    free = a[rows] - GRAVITY * up
    w, alpha = w[rows], alpha[rows]
    design = _cross(alpha) + _cross(w) @ _cross(w)
    x, y = design.reshape(-1, 3), free.reshape(-1)
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return
    lever, *_ = np.linalg.lstsq(x, y, rcond=None)
    explained = 1.0 - float(np.sum((y - x @ lever) ** 2) / max(np.sum(y**2), 1e-12))
    size = float(np.linalg.norm(lever))
    if size < LEVER or size > 5.0 or explained < EXPLAINED:
        return
    yield Finding(
        "acc.lever",
        "note",
        f"it is about {size:.2g} m from the centre of rotation, which explains {100.0 * explained:.0f} % of the "
        "acceleration",
        size,
        "m",
        0.6,
        "turning makes acceleration, which filters take for a tilt",
        "subtract it, or trust the accelerometer less while it turns (a smaller gain, a longer tau_acc)",
        {"lever": lever},
    )


def _cross(vectors: FloatArray) -> FloatArray:
    """(n, 3, 3) matrices of v × ."""
    made = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    made[:, 0, 1], made[:, 0, 2], made[:, 1, 2] = -z, y, -x
    made[:, 1, 0], made[:, 2, 0], made[:, 2, 1] = z, -y, x
    return made
