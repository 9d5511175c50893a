"""Axes, signs and the unit of the gyroscope: by what turns with what.

What can be told. A gyroscope whose readings are S ω (S a signed permutation) is explained by P = S⁻¹, mirrored where S
is. An accelerometer or a magnetometer that reads S v is explained by P = det(S) S, always a rotation: a mirrored vector
and the negated mirrored one turn alike. So a mirrored P is a gyroscope's fault for sure, and of a vector the axes are
told up to its sign.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check import _changes, _chips
from ahrs_rs._check._case import Case, Coarse
from ahrs_rs._check._findings import Change, Finding, confidence
from ahrs_rs._check._ties import Candidate, Tie, tie

FloatArray = NDArray[np.float64]

#: Windows and their first and last parts, s: acceleration averages out over a second.
WINDOWS = {"acc": (2.0, 1.0), "mag": (1.0, 0.3)}
#: Standard scores: of a tie that holds; and of one that says that axes are wrong, against the next candidate and
#: against the axes as they are, and in either half of the recording.
HOLDS, WRONG, AGAINST, HALF = 4.0, 4.3, 4.5, 2.5
#: The axes that are said to be right have to leave at most so much of what the recorded ones leave.
BETTER = 0.7
NAMES = {"acc": "accelerometer", "mag": "magnetometer", "gyr": "gyroscope"}
IDENTITY = np.eye(3)


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What one sensor says of the gyroscope."""

    sensor: str
    tie: Tie | None
    state: str
    """"tied", "other" (another candidate is right) or "unknown"."""
    candidate: Candidate | None
    score: float
    """Against the next candidate."""
    against: float
    """Of the gyroscope as recorded against the best one."""
    left: tuple[float, float]
    """Mean cost of the best candidate and of the axes as recorded."""

    @property
    def matrix(self) -> FloatArray:
        """What the angular rate has to be multiplied by, without its unit."""
        return IDENTITY if self.candidate is None else self.candidate.matrix

    @property
    def evidence(self) -> dict[str, float | int]:
        """For the findings."""
        count = 0 if self.tie is None else len(self.tie.costs)
        return {"z_next": self.score, "z_recorded": self.against, "windows": count, "left": self.left[0]}


def verdict(sensor: str, coarse: Coarse) -> Verdict:
    """Which axes and unit of the gyroscope a vector is turned by."""
    vectors = coarse.acc if sensor == "acc" else coarse.mag
    assert vectors is not None
    found = tie(coarse, vectors, *WINDOWS[sensor], offset=sensor == "mag")
    if found is None:
        return Verdict(sensor, None, "unknown", None, 0.0, 0.0, (1.0, 1.0))
    scores = found.scores()
    best = found.best
    recorded = found.find(0, 1.0, 1.0)
    next_one = float(np.min(scores))
    against = float(scores[recorded]) if best != recorded else 0.0
    left = (float(found.mean[best]), float(found.mean[recorded]))
    state = "unknown"
    if best == recorded and next_one > HOLDS:
        state = "tied"
    elif best != recorded and next_one > WRONG and against > AGAINST and left[0] < BETTER * left[1]:
        half = len(found.costs) // 2
        halves = [found.score(recorded, best, part) for part in (slice(0, half), slice(half, None))]
        if min(halves) > HALF:
            state = "other"
    return Verdict(sensor, found, state, found.candidates[best], next_one, against, left)


def check_axes(case: Case) -> Iterator[Finding]:
    """Findings about the unit of the gyroscope, and about the axes of all three."""
    if "gyr" not in case.has or not {"acc", "mag"} & set(case.has):
        return
    verdicts: dict[str, Verdict] = {name: verdict(name, case.coarse()) for name in case.has if name != "gyr"}
    case.known["verdicts"] = verdicts
    unit = list(_unit(case, verdicts))
    yield from unit
    if any(one.severity == "error" for one in unit):
        verdicts = {name: verdict(name, case.coarse()) for name in verdicts}
        case.known["verdicts"] = verdicts
    yield from _judged(case, verdicts)


def _unit(case: Case, verdicts: dict[str, Verdict]) -> Iterator[Finding]:
    """deg/s for rad/s, where the turns tell."""
    told = [one for one in verdicts.values() if one.state == "other" and one.candidate and one.candidate.factor != 1.0]
    tied = [one for one in verdicts.values() if one.state == "tied"]
    if tied and not told:
        if case.factors["gyr"] == 1.0:
            best = max(tied, key=lambda one: one.score)
            message = f"rad/s: turns as far as the {NAMES[best.sensor]} shows"
            yield Finding("gyr.unit", "ok", message, best.score, "z", confidence(best.score), evidence=best.evidence)
        return
    if not told or tied:
        return
    best = max(told, key=lambda one: one.score)
    assert best.candidate is not None
    factor = best.candidate.factor
    if any(one.candidate and one.candidate.factor != factor for one in told):
        return
    case.factors["gyr"] *= factor
    unit = "deg/s" if factor < 1.0 else "rad/s that were turned into rad/s once more"
    yield Finding(
        "gyr.unit",
        "error",
        f"the {NAMES[best.sensor]} turns by {factor:.4g} of the angular rate: it is in {unit}",
        best.score,
        "z",
        confidence(best.score),
        "the attitude turns 57 times as far as the sensor"
        if factor < 1.0
        else "the attitude hardly follows the sensor",
        "units={'gyr': 'deg/s'} (--units gyr=deg/s)" if factor < 1.0 else "leave the conversion away",
        {**best.evidence, "factor": factor},
        _changes.scaled("gyr.unit", "gyr", factor, f"gyr × {factor:.6g}"),
    )


def _judged(case: Case, verdicts: dict[str, Verdict]) -> Iterator[Finding]:
    states = {one.state for one in verdicts.values()}
    for one in verdicts.values():
        if one.state == "tied":
            yield Finding(
                f"axes.gyr_{one.sensor}",
                "ok",
                f"gyroscope and {NAMES[one.sensor]} have the same axes",
                one.score,
                "z",
                confidence(one.score),
                evidence=one.evidence,
            )
        elif one.state == "unknown":
            yield _cannot_tell(one)
    others = [
        one for one in verdicts.values() if one.state == "other" and one.candidate and one.candidate.factor == 1.0
    ]
    if not others:
        return
    mirrored = [one for one in others if np.linalg.det(one.matrix) < 0.0]
    if len(others) == 2 and np.array_equal(others[0].matrix, others[1].matrix):
        yield _gyroscope(case, max(others, key=lambda one: one.score), "accelerometer and magnetometer agree on it")
    elif mirrored and "tied" not in states and len(others) == 1:
        yield _gyroscope(case, mirrored[0], "mirrored: no turn of the other sensor explains it")
    elif mirrored or len(others) == 2:
        case.known["axes in doubt"] = True
        yield _contradiction(others)
    else:
        yield from _one_of_two(case, others[0], verdicts)


def _cannot_tell(one: Verdict) -> Finding:
    if one.tie is None or float(np.quantile(one.tie.turned, 0.9)) < 0.15:
        why = "the sensor turns too little"
    elif one.sensor == "acc":
        why = "acceleration hides the turns of gravity, or the motion is about one axis"
    else:
        why = "the motion is about one axis, or the field is disturbed"
    return Finding(
        f"axes.gyr_{one.sensor}",
        "note",
        f"cannot tell whether gyroscope and {NAMES[one.sensor]} have the same axes: {why}",
        one.score,
        "z",
        0.5,
        "",
        "turn the sensor by 90° and back about each of its axes, for half a minute",
        one.evidence,
    )


def _contradiction(others: list[Verdict]) -> Finding:
    said = "; ".join(
        f"the {NAMES[one.sensor]} is explained by ({_chips.axes_of(one.matrix)}) of the gyroscope" for one in others
    )
    return Finding(
        "axes.contradiction",
        "error",
        f"no two of the sensors have the same axes: {said}",
        min(one.score for one in others),
        "z",
        confidence(min(one.score for one in others)),
        "the sensors work against each other",
        "look up the axes of each sensor on its board",
        {one.sensor: _chips.axes_of(one.matrix) for one in others},
    )


def _gyroscope(case: Case, one: Verdict, why: str) -> Finding:
    axes = _chips.axes_of(one.matrix)
    case.rotations["gyr"] = one.matrix
    return Finding(
        "axes.gyr",
        "error",
        f"the gyroscope's axes are not those of the others: ({axes}) of its readings fit; {why}",
        one.against,
        "z",
        confidence(one.score),
        "the attitude turns about wrong axes or the wrong way",
        f"take ({axes}) of the gyroscope's x, y, z",
        {**one.evidence, "axes": axes, "mirrored": bool(np.linalg.det(one.matrix) < 0.0)},
        _changes.turned("axes.gyr", "gyr", one.matrix, f"gyr: axes {axes}"),
    )


def _one_of_two(case: Case, one: Verdict, verdicts: dict[str, Verdict]) -> Iterator[Finding]:
    """A rotation between the gyroscope and one vector: which of the two is turned?"""
    other = verdicts.get({"acc": "mag", "mag": "acc"}[one.sensor])
    blame = _blame(one, other)
    if blame == "gyr":
        assert other is not None
        yield _gyroscope(case, one, f"the {NAMES[other.sensor]} turns with them too")
    elif blame == one.sensor:
        yield _vector(case, one)
    else:
        case.known["axes in doubt"] = True
        yield _pair(one)


def _blame(one: Verdict, other: Verdict | None) -> str | None:
    """Which sensor is turned, as the third one says: of two candidates it tells more than of 48."""
    if other is None or other.tie is None or one.candidate is None:
        return None
    if other.state == "tied":
        return one.sensor
    recorded = other.tie.find(0, 1.0, 1.0)
    changed = other.tie.find(one.candidate.rotation, one.candidate.sign, 1.0)
    score = other.tie.score(recorded, changed)
    half = len(other.tie.costs) // 2
    halves = [other.tie.score(recorded, changed, part) for part in (slice(0, half), slice(half, None))]
    if abs(score) < WRONG or min(halves) * max(halves) <= 0.0:
        return None
    return "gyr" if score > 0.0 else one.sensor


def _pair(one: Verdict) -> Finding:
    """Two sensors that do not fit, without a third one that says which of them is turned."""
    of_gyr, of_vector = _chips.axes_of(one.matrix), _chips.axes_of(np.asarray(one.matrix.T))
    return Finding(
        f"axes.gyr_{one.sensor}",
        "error",
        f"gyroscope and {NAMES[one.sensor]} have different axes: ({of_gyr}) of the gyroscope fit, or else "
        f"({of_vector}) of the {NAMES[one.sensor]}, or all three of these negated; cannot tell which",
        one.against,
        "z",
        confidence(one.score),
        "the two work against each other",
        "look up the axes on the board; turn the sensor by 90° about each axis, slowly, for the accelerometer to tell",
        {**one.evidence, "gyr": of_gyr, one.sensor: of_vector},
    )


def _vector(case: Case, one: Verdict) -> Finding:
    """An accelerometer or a magnetometer in other axes, up to its sign."""
    matrix = np.asarray(one.matrix.T)
    chip = _chips.chip_of(matrix) if one.sensor == "mag" else None
    change: Change | None = None
    signed, sign_known = _signed(case, one.sensor, matrix, chip)
    axes, negated = _chips.axes_of(signed), _chips.axes_of(-signed)
    said = f"({axes}) of its readings fit" if sign_known else f"({axes}) or ({negated}) of its readings fit"
    if sign_known:
        change = _changes.turned(f"axes.{one.sensor}", one.sensor, signed, f"{one.sensor}: axes {axes}")
        case.rotations[one.sensor] = signed
    named = f": the axes of {chip.names}" if chip else ""
    return Finding(
        f"axes.{one.sensor}",
        "error",
        f"the {NAMES[one.sensor]}'s axes are not the gyroscope's: {said}{named}",
        one.against,
        "z",
        confidence(one.score),
        "inclination is drawn to a wrong up" if one.sensor == "acc" else "the heading is drawn to a wrong north",
        f"take ({axes}) of the {NAMES[one.sensor]}'s x, y, z"
        + ("" if sign_known else ", or all of them negated: up= or place= tells which"),
        {**one.evidence, "axes": axes, "chip": chip.names if chip else None, "sign_known": sign_known},
        change,
    )


def _signed(case: Case, sensor: str, matrix: FloatArray, chip: _chips.Chip | None) -> tuple[FloatArray, bool]:
    """The matrix with its sign, and whether the sign is known."""
    from ahrs_rs._check._signs import dip_sign, up_sign

    for sign in (up_sign(case, matrix) if sensor == "acc" else 0, dip_sign(case, sensor, matrix)):
        if sign:
            return sign * matrix, True
    if chip is not None and chip.alone:
        return _chips.matrix_of(chip.axes), True
    return matrix, False
