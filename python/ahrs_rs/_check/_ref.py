"""The reference: form of its quaternions, frames, clock, leaps, and whether it is that of this sensor.

Norms of turns are the same in every form (scalar-last, inverse, mirrored) and every frame: they find the clock. Then
the turns over a fifth of a second, as each form gives them, are compared with the gyroscope's: a form is right if one
constant rotation takes the one into the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _quat
from ahrs_rs._check import _changes
from ahrs_rs._check._case import Case, Coarse
from ahrs_rs._check._clock import clock_of, unit
from ahrs_rs._check._findings import Finding

FloatArray = NDArray[np.float64]

#: Turns over this time are compared, s; so many have to be above this angle, rad.
SPAN, TURNED, FEWEST = 0.2, 0.05, 30
#: Part of the gyroscope's turns that is left: of a form that is right, and of one that is wrong.
FITS, WRONG = 0.35, 0.6
#: A form leaves so much more than another one, and by so many standard errors in either half of the recording.
APART, CLEAR = 0.1, 5.0
#: Offsets of the clock that are told, and grave ones, s.
OFFSET = (0.02, 0.1)
#: Correlation of the norms below which it is another body's.
ALIKE, OTHER = 0.6, 0.25
#: Rotation between the sensor frames, and tilt of the earth frame, rad.
TURN, TILT = np.radians(5.0), np.radians(8.0)
#: A leap: the reference turns by so much more than the gyroscope in one span, rad.
LEAP = 0.5


def _scalar_last(q: FloatArray) -> FloatArray:
    return np.asarray(q[:, [3, 0, 1, 2]])


def _negated(axis: int) -> Callable[[FloatArray], FloatArray]:
    signs = np.ones(4)
    signs[1 + axis] = -1.0
    return lambda q: np.asarray(q * signs)


def _as_it_is(q: FloatArray) -> FloatArray:
    return q


#: Forms that turn like the right one up to constant rotations of both frames, and those that turn like its inverse. A
#: quaternion whose scalar part is taken for another one is the inverse between two constant rotations; so is one with
#: the sign of one vector part changed.
RIGHT: dict[str, Callable[[FloatArray], FloatArray]] = {"": _as_it_is}
INVERSE: dict[str, Callable[[FloatArray], FloatArray]] = {
    "inverse": _quat.conjugate,
    "scalar-last": _scalar_last,
    "mirrored in x": _negated(0),
    "mirrored in y": _negated(1),
    "mirrored in z": _negated(2),
}
FORMS = RIGHT | INVERSE
MEANS = {
    "inverse": "it turns from the earth frame to the sensor's, not from the sensor's to the earth's",
    "scalar-last": "its scalar part comes last",
    **{f"mirrored in {axis}": f"its {axis} has the other sign" for axis in "xyz"},
}


def check_reference(case: Case) -> Iterator[Finding]:
    """Findings about the reference against the sensors."""
    if case.recording.ref is None or "gyr" not in case.has:
        return
    if case.known.get("axes in doubt"):
        yield Finding(
            "ref.form",
            "note",
            "cannot tell the form of the reference: the gyroscope's axes are in doubt",
            confidence=0.5,
        )
        return
    coarse = case.coarse()
    assert coarse.ref is not None
    ref = unit(coarse.ref)
    length = max(round(SPAN * coarse.rate), 1)
    if len(coarse) < 20 * length:
        return
    offset, alike, enough = clock_of(coarse, ref)
    if not enough:
        yield Finding("ref.form", "note", "cannot tell the form of the reference: it turns too little", None, "", 0.5)
        return
    if alike < OTHER:
        yield Finding(
            "ref.other",
            "error",
            f"the reference turns at other times than the sensor (correlation {alike:.2f} at best)",
            alike,
            "",
            0.9,
            "errors against it mean nothing",
            "check that it belongs to this recording, and its clock (ar.join_reference finds one)",
        )
        return
    yield from _judged(coarse, ref, offset, alike, length)


def _judged(coarse: Coarse, ref: FloatArray, offset: float, alike: float, length: int) -> Iterator[Finding]:
    shift = round(offset * coarse.rate)
    starts, gyr, known = _turns(coarse, ref, length, shift)
    if np.count_nonzero(known) < FEWEST:
        yield Finding("ref.form", "note", "cannot tell the form of the reference: it turns too little", None, "", 0.5)
        return
    left: dict[str, float] = {}
    rests: dict[str, FloatArray] = {}
    rotations: dict[str, FloatArray] = {}
    mirrored: dict[str, float] = {}
    for name, form in FORMS.items():
        turns = _of_reference(form(ref), starts, length)
        rotations[name], rests[name], mirrored[name] = _fitted(gyr[known], turns[known])
        left[name] = float(np.median(rests[name]))
    inverse = min(left[name] for name in INVERSE)
    opposite = _clear(rests[""], rests["inverse"])
    if min(left[""], inverse) > WRONG and min(mirrored[""], mirrored["inverse"]) < FITS:
        yield _mirrored_finding(mirrored, left[""])
        return
    chosen = ""
    if min(left[""], inverse) > WRONG:
        yield _no_form(left, alike)
        return
    if inverse < FITS and (left[""] > WRONG or (left[""] > max(3.0 * inverse, inverse + APART) and opposite)):
        chosen, finding = _inverse(coarse, ref, left, rotations, shift, alike)
        yield finding
        if not chosen:
            return
    else:
        sure = left[""] < FITS and inverse > left[""] + 0.15
        yield Finding(
            "ref.form",
            "ok" if sure else "note",
            f"scalar-first, from the sensor to the earth: {100.0 * left['']:.0f} % of the turns are left"
            + ("" if sure else "; cannot tell it from its inverse"),
            left[""],
            "of the turns",
            0.95 if sure else 0.6,
            evidence={"left": left, "correlation": alike},
        )
        if left[""] > WRONG:
            return
    yield from _frames(coarse, FORMS[chosen](ref), rotations[chosen], shift)
    yield from _offset(offset, alike)
    yield from _leaps(coarse, FORMS[chosen](ref), rotations[chosen], starts, gyr, length)


def _no_form(left: dict[str, float], alike: float) -> Finding:
    return Finding(
        "ref.form",
        "warning" if alike < ALIKE else "note",
        f"the reference's turns are not the sensor's in any form ({100.0 * min(left.values()):.0f} % are left)",
        min(left.values()),
        "of the turns",
        0.7,
        "errors against it mean little",
        "check that it is fixed to this sensor, and its clock",
        {"correlation": alike, "left": left},
    )


def _inverse(
    coarse: Coarse,
    ref: FloatArray,
    left: dict[str, float],
    rotations: dict[str, FloatArray],
    shift: int,
    alike: float,
) -> tuple[str, Finding]:
    """Which of the forms that turn like the inverse it is: the one with our frames, if there is one alone."""
    ours = []
    for name in INVERSE:
        angle = float(np.arccos(np.clip(0.5 * (np.trace(rotations[name]) - 1.0), -1.0, 1.0)))
        up = _up(coarse, FORMS[name](ref), rotations[name], shift)
        if angle < np.radians(15.0) and (up is None or up[2] > 0.9 * np.linalg.norm(up)):
            ours.append(name)
    form = ours[0] if len(ours) == 1 else ""
    unsure = "it is inverse, scalar-last or mirrored; cannot tell which"
    if form:
        said = f"the reference is {form}: {MEANS[form]}"
    else:
        said = f"the reference turns like the inverse of the sensor's attitude: {unsure}"
    change = _changes.referenced("ref.form", FORMS[form], f"ref: {form}, put in our form") if form else None
    finding = Finding(
        "ref.form",
        "error",
        said,
        min(left[name] for name in INVERSE),
        "of the turns",
        0.97,
        "errors against it mean nothing",
        "conjugate it" if form == "inverse" else "put its parts in the order w, x, y, z, from the sensor to the earth",
        {"left": left, "correlation": alike, "form": form},
        change,
    )
    return form, finding


def _up(coarse: Coarse, ref: FloatArray, matrix: FloatArray, shift: int) -> FloatArray | None:
    """The mean of the specific force in the reference's earth frame; None where it is not known."""
    if coarse.acc is None:
        return None
    acc = np.roll(coarse.acc, shift, axis=0) @ matrix  # in the reference's sensor frame
    known = np.isfinite(acc).all(axis=1) & np.isfinite(ref).all(axis=1)
    if np.count_nonzero(known) < 200:
        return None
    return np.asarray(_quat.rotate(ref[known], acc[known]).mean(axis=0))


def _clear(worse: FloatArray, better: FloatArray) -> bool:
    """Whether one form leaves more than another in paired spans, in either half of the recording."""
    apart = np.minimum(worse, 1.0) - np.minimum(better, 1.0)
    half = len(apart) // 2
    scores = [
        float(part.mean()) / max(float(part.std(ddof=1)) / np.sqrt(len(part)), 1e-9)
        for part in (apart[:half], apart[half:])
    ]
    return bool(min(scores) > CLEAR)


def _mirrored_finding(mirrored: dict[str, float], left: float) -> Finding:
    best = min(mirrored, key=lambda name: mirrored[name])
    return Finding(
        "ref.mirrored",
        "error",
        "the reference is mirrored against the gyroscope: one of the two is in left-handed axes"
        + (f" (and {best})" if best else ""),
        mirrored[best],
        "of the turns",
        0.95,
        "errors against it mean nothing",
        "change the sign of one axis where the reference is made, or of the gyroscope (see axes.gyr)",
        {"left_as_rotation": left},
    )


def _turns(
    coarse: Coarse, ref: FloatArray, length: int, shift: int
) -> tuple[NDArray[np.intp], FloatArray, NDArray[np.bool_]]:
    """First steps of the reference's spans, the gyroscope's turns over them, and which are known and turn."""
    from ahrs_rs.filters import FILTERS

    first = max(-shift, 0)
    count = (min(len(coarse), len(coarse) - shift) - first - 1) // length
    starts = first + np.arange(max(count, 0)) * length
    index = starts[:, np.newaxis] + 1 + np.arange(length)
    turn = coarse.turn[np.minimum(index, len(coarse) - 1)]
    known = np.isfinite(turn).all(axis=(1, 2))
    padded = np.concatenate([np.zeros((len(turn), 1, 3)), np.nan_to_num(turn)], axis=1)
    quat = np.asarray(FILTERS["GyroIntegration"](rate=1.0).run(padded).quat)
    gyr = _quat.log(np.asarray(quat[:, -1], dtype=np.float64)) if len(quat) else np.zeros((0, 3))
    starts = starts + shift
    inside = (starts >= 0) & (starts + length < len(ref))
    starts, gyr, known = starts[inside], gyr[inside], known[inside]
    known = known & np.isfinite(ref[starts]).all(axis=1) & np.isfinite(ref[starts + length]).all(axis=1)
    return starts, gyr, known & (np.linalg.norm(gyr, axis=1) > TURNED)


def _of_reference(ref: FloatArray, starts: NDArray[np.intp], length: int) -> FloatArray:
    return _quat.log(_quat.multiply(_quat.conjugate(ref[starts]), ref[starts + length]))


def _fitted(gyr: FloatArray, turns: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """The rotation that takes the reference's turns into the gyroscope's, what it leaves, what a mirror image leaves.

    Spans at which the two differ most count less: a leap is none of the form.
    """
    weight = np.ones(len(gyr))
    matrix, left = np.eye(3), np.ones(len(gyr))
    mirror = np.eye(3)
    for _ in range(6):
        u, _, v = np.linalg.svd((gyr * weight[:, np.newaxis]).T @ turns)
        sign = np.sign(np.linalg.det(u @ v))
        matrix = u @ np.diag([1.0, 1.0, sign]) @ v
        mirror = u @ np.diag([1.0, 1.0, -sign]) @ v
        rest = np.linalg.norm(gyr - turns @ matrix.T, axis=1)
        size = np.linalg.norm(gyr, axis=1)
        weight = 1.0 / (1.0 + (rest / (0.3 * size + 1e-3)) ** 2)
        left = rest / size
    other = float(np.median(np.linalg.norm(gyr - turns @ mirror.T, axis=1) / np.linalg.norm(gyr, axis=1)))
    return matrix, left, other


def _frames(coarse: Coarse, ref: FloatArray, matrix: FloatArray, shift: int) -> Iterator[Finding]:
    """The rotation between the sensor frames, and the tilt of the earth frame."""
    angle = float(np.arccos(np.clip(0.5 * (np.trace(matrix) - 1.0), -1.0, 1.0)))
    if angle > TURN:
        yield Finding(
            "ref.sensor_frame",
            "note",
            f"its sensor frame is turned by {np.degrees(angle):.1f}° against the gyroscope's",
            angle,
            "rad",
            0.9,
            "errors hold a constant rotation",
            "compare --align, ar.metrics.align",
            {"matrix": matrix},
        )
    up = _up(coarse, ref, matrix, shift)
    if up is None or coarse.acc is None:
        return
    norm = float(np.linalg.norm(up))
    if norm < 0.7 * float(np.nanmedian(np.linalg.norm(coarse.acc, axis=1))):
        yield Finding(
            "ref.earth_frame", "note", "cannot tell the reference's up: it turns otherwise than gravity", norm
        )
        return
    up = up / norm
    tilt = float(np.arccos(np.clip(up[2], -1.0, 1.0)))
    axis = int(np.argmax(np.abs(up)))
    named = ("-" if up[axis] < 0.0 else "") + "xyz"[axis]
    yield Finding(
        "ref.earth_frame",
        "ok" if tilt < TILT else "note",
        f"up is ({up[0]:.2f}, {up[1]:.2f}, {up[2]:.2f}) in its earth frame"
        + ("" if tilt < TILT else f": {named} is up"),
        tilt,
        "rad",
        0.9,
        "" if tilt < TILT else "errors hold a constant rotation",
        "" if tilt < TILT else "compare --align; frame='NED' where z is down",
    )


def _offset(offset: float, alike: float) -> Iterator[Finding]:
    large = abs(offset) > OFFSET[0] and alike > ALIKE
    grave = large and abs(offset) > OFFSET[1]
    late = "late" if offset > 0.0 else "early"
    yield Finding(
        "ref.clock",
        "warning" if grave else "note" if large else "ok",
        f"it is {abs(offset):.3f} s {late} (correlation of the rates of turn {alike:.2f})",
        offset,
        "s",
        0.9 if alike > 0.8 else 0.6,
        "errors are those of the turns over this time" if large else "",
        f"move its times by {-offset:.3f} s (ar.join_reference, compare --align)" if large else "",
    )


def _leaps(
    coarse: Coarse, ref: FloatArray, matrix: FloatArray, starts: NDArray[np.intp], gyr: FloatArray, length: int
) -> Iterator[Finding]:
    turns = _of_reference(ref, starts, length) @ matrix.T
    apart = np.linalg.norm(turns - gyr, axis=1)
    known = np.isfinite(apart)
    leaps = np.flatnonzero(known & (apart > LEAP) & (np.linalg.norm(gyr, axis=1) < 0.5 * np.pi))
    usual = float(np.median(apart[known])) if known.any() else 0.0
    leaps = leaps[apart[leaps] > 10.0 * max(usual, 1e-3)]
    if not leaps.size:
        return
    worst = leaps[int(np.argmax(apart[leaps]))]
    yield Finding(
        "ref.leaps",
        "warning" if 0.01 * len(apart) < leaps.size < 0.2 * len(apart) else "note",
        f"it leaps {leaps.size} times, by up to {np.degrees(apart[worst]):.0f}° at {coarse.t[starts[worst]]:.4g} s",
        float(apart[worst]),
        "rad",
        0.85,
        "errors there are the reference's",
        "leave these parts out (mask)",
        {"at": coarse.t[starts[leaps[:20]]]},
    )
