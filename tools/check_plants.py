"""Faults that are planted into recordings, and what a check has to say of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import ahrs_rs as ar
from ahrs_rs import _quat
from ahrs_rs._check import _chips, _ties

SIGNED = [sign * one for sign in (1.0, -1.0) for one in _ties.ROTATIONS]
IDENTITY = np.eye(3)
DEGREE = np.pi / 180.0

#: found as it is; named up to what the data cannot tell (the sign of a vector, which of two sensors); "cannot tell";
#: nothing said; something wrong said, as an error or below.
OUTCOMES = ("found", "up to sign or sensor", "cannot tell", "not found", "wrong")


@dataclass(frozen=True)
class Plant:
    """One fault."""

    kind: str
    apply: Callable[[ar.Recording], ar.Recording]
    judge: Callable[[ar.Report, ar.Report], str]
    """Of the report and that of the recording without the fault: one of OUTCOMES."""
    keywords: dict[str, Any] = field(default_factory=dict)
    allowed: tuple[str, ...] = ()
    """Codes of errors that follow from the fault."""


def rows(recording: ar.Recording, **changes: Any) -> ar.Recording:
    """The recording with other rows."""
    names = ("t", "gyr", "acc", "mag", "ref", "mask", "temperature")
    return ar.Recording(**{**{name: getattr(recording, name) for name in names}, "meta": {}, **changes})


def times(sensor: str, factor: Any) -> Callable[[ar.Recording], ar.Recording]:
    """Readings times a factor."""
    return lambda r: r.changed(lambda name, x: x * factor if name == sensor else x)


def of_rows(sensor: str, change: Callable[[ar.Recording, np.ndarray], np.ndarray]) -> Callable[..., ar.Recording]:
    """Readings changed row by row."""

    def apply(recording: ar.Recording) -> ar.Recording:
        return rows(recording, **{sensor: change(recording, np.array(getattr(recording, sensor)))})

    return apply


def has(code: str, accept: Callable[[Any, Any], bool] = lambda found, right: True) -> Callable[..., str]:
    """Found where there is a note or more of the code that is accepted."""

    def judge(report: ar.Report, right: ar.Report) -> str:
        found = report.get(code)
        if found is None:
            return "not found"
        if found.severity == "ok":
            return "not found"
        if found.message.startswith("cannot tell"):
            return "cannot tell"
        return "found" if accept(found, right.get(code)) else "wrong"

    return judge


def axes(sensor: str, matrix: np.ndarray) -> Callable[..., str]:
    """Found where the inverse of the permutation is named."""
    inverse = np.linalg.inv(matrix)

    def judge(report: ar.Report, right: ar.Report) -> str:
        errors = [one for one in report.of("error") if one.code.startswith("axes.")]
        if not errors:
            return (
                "cannot tell"
                if any(one.message.startswith("cannot tell whether") for one in report.findings)
                else ("not found")
            )
        one = errors[0]
        if one.code.startswith("axes.gyr_"):
            named = _chips.matrix_of(one.evidence["gyr"].replace(" ", ""))
            expected = inverse if sensor == "gyr" else np.round(np.linalg.det(matrix)) * matrix
            pair = one.code.removeprefix("axes.gyr_")
            fits = np.array_equal(named, expected) and sensor in ("gyr", pair)
            return "up to sign or sensor" if fits else "wrong"
        if one.code != f"axes.{sensor}":
            return "wrong"
        named = _chips.matrix_of(one.evidence["axes"].replace(" ", ""))
        if np.array_equal(named, inverse):
            return "found"
        signs = sensor != "gyr" and np.array_equal(named, -inverse)
        return "up to sign or sensor" if signs and one.change is None else "wrong"

    return judge


def fixable(report: ar.Report, right: ar.Report) -> str:
    """Found where nothing grave is left after `fixed`."""
    return "found" if not ar.check(report.fixed()).of("error") else "wrong"


def plants(source: ar.Recording, every: int) -> Iterator[Plant]:
    """The faults for a recording; of the permutations one in so many."""
    present = [name for name in ("gyr", "acc", "mag") if getattr(source, name) is not None]
    for sensor in present:
        invisible = [IDENTITY] if sensor == "gyr" else [IDENTITY, -IDENTITY]
        some = [one for one in SIGNED if not any(np.array_equal(one, other) for other in invisible)]
        for matrix in some[::every]:

            def turn(r: ar.Recording, matrix: np.ndarray = matrix, sensor: str = sensor) -> ar.Recording:
                return r.changed(lambda name, x: x @ matrix.T if name == sensor else x)

            yield Plant(f"axes of {sensor}", turn, axes(sensor, matrix), allowed=("axes.", "ref."))
    yield from _units(present)
    yield from _clocks(source)
    yield from _values(source, present)
    if "mag" in present:
        yield from _field(source)
    if source.ref is not None:
        yield from _reference()


def _units(present: list[str]) -> Iterator[Plant]:
    for unit, size in (("ms", 1e3), ("us", 1e6), ("ns", 1e9)):

        def scale(r: ar.Recording, size: float = size) -> ar.Recording:
            return rows(r, t=r.t * size)

        yield Plant(
            f"t in {unit}",
            scale,
            has("time.unit", lambda f, _, unit=unit: f.evidence["unit"] == unit),
            allowed=("time.",),
        )
    yield Plant("gyr in deg/s", times("gyr", 1.0 / DEGREE), has("gyr.unit"), allowed=("gyr.unit",))
    if "acc" in present:
        for unit, size in (("g", 9.80665), ("mg", 9.80665e-3)):
            accept = has("acc.unit", lambda f, _, unit=unit: f.evidence.get("unit") == unit)
            yield Plant(f"acc in {unit}", times("acc", 1.0 / size), accept, allowed=("acc.unit",))
    if "mag" in present:
        for unit, size in (("gauss", 1e2), ("T", 1e6), ("nT", 1e-3)):
            yield Plant(f"mag in {unit}", times("mag", 1.0 / size), has("mag.unit"))


def _clocks(source: ar.Recording) -> Iterator[Plant]:
    step = 1.0 / source.rate

    def packets(r: ar.Recording) -> ar.Recording:
        return rows(r, t=r.t[0] + np.floor(np.arange(len(r)) / 8) * 8 * step)

    def gap(r: ar.Recording) -> ar.Recording:
        t = np.array(r.t)
        t[len(t) // 2 :] += 3.0
        return rows(r, t=t)

    def stamps(r: ar.Recording) -> ar.Recording:
        t = np.array(r.t)
        t[10::20] = t[9:-1:20][: len(t[10::20])]
        return rows(r, t=t)

    def held(r: ar.Recording) -> ar.Recording:
        gyr, acc = np.array(r.gyr), np.array(r.acc)
        gyr[10::20], acc[10::20] = gyr[9:-1:20][: len(gyr[10::20])], acc[9:-1:20][: len(acc[10::20])]
        return rows(r, gyr=gyr, acc=acc)

    yield Plant("rows in packets of 8", packets, has("time.bursts"))
    yield Plant("a gap of 3 s", gap, has("time.gaps", lambda f, _: abs(f.value - 3.0) < 0.2))
    yield Plant("a row in 20 with the stamp before", stamps, has("time.repeated_stamps"))
    yield Plant("a row in 20 held", held, has("time.repeated_rows"))
    yield Plant("a stated rate twice as high", lambda r: rows(r, rate=2.0 * r.rate), has("time.stated"))


def _values(source: ar.Recording, present: list[str]) -> Iterator[Plant]:
    for sensor in ("gyr", "acc"):
        if sensor not in present:
            continue
        reach = float(np.nanmax(np.abs(getattr(source, sensor))))
        for part in (0.5, 0.6, 0.7, 0.8, 0.9):
            level = part * reach
            clip = of_rows(sensor, lambda r, x, level=level: np.clip(x, -level, level))
            accept = has(f"{sensor}.clipped", lambda f, _, level=level: abs(f.value / level - 1.0) < 0.01)
            # Where all readings of an axis are beyond the level, it is dead.
            yield Plant(f"{sensor} clipped", clip, accept, allowed=(f"{sensor}.dead",))
    reach = 0.6 * float(np.nanmax(np.abs(source.gyr)))
    wrap = of_rows("gyr", lambda r, x: (x + reach) % (2.0 * reach) - reach)
    yield Plant("gyr wrapped", wrap, has("gyr.wrapped"), allowed=("gyr.wrapped", "axes.", "ref."))

    def dead(r: ar.Recording, x: np.ndarray) -> np.ndarray:
        x[:, 1] = 0.01
        return x

    yield Plant("gyr: y dead", of_rows("gyr", dead), has("gyr.dead"), allowed=("gyr.dead", "ref."))
    for size in (1.0, 5.0):
        vector = size * DEGREE * np.array([0.6, -0.8, 0.0])
        near = has("gyr.bias", lambda f, _, size=size: abs(f.value / DEGREE - size) < 0.7)
        yield Plant(f"gyr: bias of {size:.0f} °/s", of_rows("gyr", lambda r, x, v=vector: x + v), near)
    for scale in (0.9, 1.1):
        near = has("gyr.scale", lambda f, _, scale=scale: abs(f.value * scale - 1.0) < 0.04)
        yield Plant("gyr: scale off by 10 %", times("gyr", scale), near)
    if "acc" in present:
        yield Plant("acc: scale off by 10 %", times("acc", 1.1), has("acc.norm"))
        gravity = first_up(source)
        if gravity is not None:
            judge = has("acc.sign")
            yield Plant("acc negated, up= known", times("acc", -1.0), judge, {"up": gravity}, ("acc.sign",))


def first_up(source: ar.Recording) -> str | None:
    """Which axis is up at the start, for `up=`."""
    start = np.nanmean(source.acc[: max(int(source.rate), 10)], axis=0)
    start = start / np.linalg.norm(start)
    axis = int(np.argmax(np.abs(start)))
    if abs(start[axis]) < 0.8:
        return None
    return ("-" if start[axis] < 0.0 else "") + "xyz"[axis]


def _field(source: ar.Recording) -> Iterator[Plant]:
    norm = float(np.nanmedian(np.linalg.norm(source.mag, axis=1)))
    for size in (5.0, 20.0, 50.0):
        offset = size / 49.0 * norm * np.array([0.6, 0.0, -0.8])

        def near(found: Any, right: Any, offset: np.ndarray = offset) -> bool:
            base = np.zeros(3) if right is None else np.asarray(right.evidence.get("offset", np.zeros(3)))
            apart = np.linalg.norm(np.asarray(found.evidence["offset"]) - base - offset)
            return bool(apart < max(0.3 * float(np.linalg.norm(offset)), 0.08 * norm))

        plant = of_rows("mag", lambda r, x, offset=offset: x + offset)
        yield Plant(f"mag: hard iron of {size:.0f} of 49 µT", plant, has("mag.iron", near))
    for delay in (0.01, 0.02, 0.04):
        steps = round(delay * source.rate)
        real = steps / source.rate

        def close(found: Any, right: Any, real: float = real) -> bool:
            base = 0.0 if right is None or right.value is None else right.value
            return abs(found.value - base - real) < 0.006

        plant = of_rows("mag", lambda r, x, steps=steps: np.vstack([x[:1]] * steps + [x[:-steps]]))
        yield Plant(f"mag late by {1e3 * delay:.0f} ms", plant, has("mag.delay", close))


def _reference() -> Iterator[Plant]:
    def change(form: Callable[[np.ndarray], np.ndarray]) -> Callable[[ar.Recording], ar.Recording]:
        return lambda r: rows(r, ref=form(np.array(r.ref)))

    def leap(q: np.ndarray) -> np.ndarray:
        turned = _quat.multiply(_quat.about_axis(2, np.array(1.2)), q)
        return np.where((np.arange(len(q)) > len(q) // 2)[:, np.newaxis], turned, q)

    forms = {
        "inverse": _quat.conjugate,
        "scalar-last": lambda q: q[:, [1, 2, 3, 0]],
        "mirrored": lambda q: q * np.array([1.0, 1.0, -1.0, 1.0]),
    }
    for name, form in forms.items():
        yield Plant(f"ref: {name}", change(form), _form(name), allowed=("ref.form",))
    yield Plant("ref: a leap of 69°", change(leap), has("ref.leaps"))

    def late(r: ar.Recording) -> ar.Recording:
        return rows(r, ref=np.roll(r.ref, round(0.2 * r.rate), axis=0))

    yield Plant("ref late by 0.2 s", late, has("ref.clock", lambda f, _: abs(f.value - 0.2) < 0.03))


def _form(name: str) -> Callable[..., str]:
    def judge(report: ar.Report, right: ar.Report) -> str:
        found = report.get("ref.form")
        if found is None or found.severity == "ok":
            return "not found"
        if "cannot tell" in found.message:
            return "up to sign or sensor" if found.severity == "error" else "cannot tell"
        if found.severity != "error":
            return "not found"
        return "found" if str(found.evidence.get("form", "")).startswith(name) else "wrong"

    return judge
