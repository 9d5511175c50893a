"""The text and the tables of docs/robustness.md."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from accuracy_scores import table
from robustness_errors import BEFORE, CHI2_MEDIAN, FACTOR, GOAL, NEES_FACTOR, SETTLED, SMALL, Result, observed
from robustness_faults import FAULTS, Fault
from robustness_paces import PACES
from robustness_scenes import (
    ACC_BIAS,
    ACC_NOISE,
    AFTER,
    FIRST,
    GYR_BIAS,
    GYR_NOISE,
    HALF,
    LAST,
    MAG_NOISE,
    RATE,
    REST_RANGE,
    TURN_TIME,
)

import ahrs_rs as ar


@dataclass(frozen=True)
class Found:
    """What was measured."""

    scenes: Sequence[str]
    """Names in their order."""
    shorts: Mapping[str, str]
    faults: Sequence[Fault]
    filters: Sequence[str]
    seeds: int
    results: Mapping[tuple[str, str, str], Result]
    """By scene, fault and filter; without those that a fault does not concern."""
    usual: Mapping[tuple[str, str], float]
    """Undisturbed error by scene and filter, °: median over the seeds."""

    def of(self, fault: Fault, name: str) -> dict[str, Result]:
        """The results of a filter under a fault, by scene."""
        found = ((scene, self.results.get((scene, fault.name, name))) for scene in self.scenes)
        return {scene: result for scene, result in found if result is not None}


HEAD = """# Robustness

Made by `make robustness`: what every filter, at its defaults, makes of sensors that lose half a second. 9D for filters
that use a magnetometer, else 6D. The error is that in what a filter observes: in 9D the total one, in 6D that of the
inclination; `GyroIntegration` observes nothing, and is there to compare with. Errors are root mean squares over
±{half:g} s about 1, 10 and 30 s after good measurements are back.

The goal: {after:g} s after good measurements are back, the error is below {small:g}° or {factor:g} times what the same
filter has on the same recording without the fault (at that time, or over the recording, whichever is larger). It has to
be met for each of the {seeds} seeds.

What the data do not *tell* (the columns with †), published filters have no way to find out: they forget such an error
at their own pace, and are asked for no more than that ([paces](#paces)). Offline filters know the future, and may not
be wrong before the fault either: for them the goal holds {before} s before it too.
"""

SUMMARY = """
## Summary

`met`: in all recordings, for all seeds. `pace`: by the pace that the filter's own gains give it. Else: the recordings
in which the goal was missed, `all` or some of {shorts}. –: it does not concern the filter, or the filter cannot be
told.

"""

COVARIANCES = """
### Covariances

Kalman filters say how wrong they are. The NEES is the squared error over its covariance, and its median over the seeds
has to be below {factor:g} times the undisturbed one, or {factor:g} times that of an honest covariance (6D {six:.1f},
9D {nine:.1f}), whichever is larger, 1, 10 and 30 s after good measurements are back: `met`, or where it was not.

"""

RECORDINGS = """
## What happens

{faults}

### Recordings

**rest** is simulated at {rate:g} Hz: a sensor in any attitude that rests, but for one turn by 90° within {turn:g} s.
The turn comes {first:g} s after the start, and is lost or seen in the fault; the clock is set ahead 5 s after it. The
gyroscope's range is {range:g} rad/s.

**motion** is simulated at {rate:g} Hz: a way through random points without a rest, accelerations of some 2 m/s². The
fault begins {first:g} to {last:g} s after the start. Noise and constant biases (one sigma) of both simulations:
{gyr_noise:g} and {gyr_bias:g} rad/s, {acc_noise:g} and {acc_bias:g} m/s², {mag_noise:g} µT.

**BROAD**: slow rotation (02; with breaks, 05), fast rotation (07), fast translation (16). A seed is another time of the
fault, within the movement.

In motion and on BROAD a turn beyond the gyroscope's range is one whole turn about an axis by the seed, added to the
motion. The range is 5 % above the largest rate of the recording, and the turn's largest rate is 1.3 to 1.8 times the
range.

### Paces

What published filters may have left of an error that nothing tells them of, beside their undisturbed error:

{paces}
"""

NUMBERS = """
## Numbers

Errors in degrees: medians over the seeds 1 / 10 / 30 s after good measurements are back, then ≤ the largest one after
10 s. σ is what a Kalman filter claims after 10 s (median). Bold: missed, with the number of seeds.

### Without a fault

RMS of the error over the recording (BROAD: over the movement; else from {settled:g} s on), median over the seeds.

"""

BEFORE_TEXT = """
### Before the fault

Offline filters: medians over the seeds {before} s before the fault, then ≤ the largest one.

"""

NEES_TEXT = """
### NEES

Medians over the seeds 1 / 10 / 30 s after good measurements are back, in brackets the undisturbed ones. Bold: missed.
Italics: above {factor:g} times the undisturbed one, and not above {factor:g} times an honest one.
"""


def prose(text: str, **values: object) -> str:
    """The text with its values, its paragraphs broken into lines anew."""
    blocks = text.format(**values).strip().split("\n\n")
    return "\n" + "\n\n".join(block if block[0] in "#-" else textwrap.fill(block, 120) for block in blocks) + "\n\n"


def page(found: Found) -> str:
    """The whole document."""
    before = " and ".join(f"{one:g}" for one in BEFORE)
    text = prose(HEAD, half=HALF, after=AFTER[GOAL], small=SMALL, factor=FACTOR, seeds=found.seeds, before=before)
    shorts = ", ".join(
        short if scene.endswith(short) else f"{short} ({scene})" for scene, short in found.shorts.items()
    )
    text += prose(SUMMARY, shorts=shorts) + _summary(found)
    kalman = [name for name in found.filters if "covariance" in ar.FILTERS[name].OUTPUTS]
    if kalman:
        text += prose(COVARIANCES, factor=NEES_FACTOR, six=CHI2_MEDIAN[2], nine=CHI2_MEDIAN[3])
        text += _covariances(found, kalman)
    text += _recordings(found) + prose(NUMBERS, settled=SETTLED) + _usual(found)
    for fault in found.faults:
        text += f"\n### {fault.name[0].upper()}{fault.name[1:]}{_mark(fault)}\n\n{_sentence(fault.text)}\n\n"
        text += _errors(found, fault)
    offline = [name for name in found.filters if not ar.FILTERS[name].STREAMING]
    if offline:
        text += prose(BEFORE_TEXT, before=" / ".join(f"{one:g}" for one in BEFORE)) + _before(found, offline)
    if kalman:
        text += prose(NEES_TEXT, factor=NEES_FACTOR)
        for name in kalman:
            text += f"\n#### {name}\n\n" + _nees(found, name)
    return re.sub(r"\n{3,}", "\n\n", text).lstrip()


def _mark(fault: Fault) -> str:
    return "" if fault.told else " †"


def _sentence(text: str) -> str:
    return textwrap.fill(f"{text[0].upper()}{text[1:]}.", 120)


def _number(value: float) -> str:
    """Two digits, or as many as stand before the point."""
    if not value < 1e4:
        return f"{value:.0e}".replace("e+0", "e")
    return f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def _numbers(values: np.ndarray) -> str:
    return " / ".join(_number(float(value)) for value in values)


def _judged(
    found: Found, results: Mapping[str, Result], missed: Callable[[Result], bool], paced: Callable[[Result], bool]
) -> str:
    """A cell of a summary."""
    if not results:
        return "–"
    where = [found.shorts[scene] for scene, result in results.items() if missed(result)]
    if where:
        return "all" if len(where) == len(found.scenes) else " ".join(where)
    return "pace" if any(paced(result) for result in results.values()) else "met"


def _summary(found: Found) -> str:
    rows = []
    for name in found.filters:
        if not observed(name):
            continue
        results = [found.of(fault, name) for fault in found.faults]
        rows.append([name, *(_judged(found, one, lambda r: r.missed > 0, lambda r: r.paced) for one in results)])
        if not ar.FILTERS[name].STREAMING:
            cells = [_judged(found, one, lambda r: r.missed_before > 0, lambda _: False) for one in results]
            rows.append([f"{name}, before", *cells])
    head = ["filter", *(fault.name + _mark(fault) for fault in found.faults)]
    return table(head, rows, texts=len(head))


def _covariances(found: Found, kalman: Sequence[str]) -> str:
    rows = []
    for name in kalman:
        cells = [_judged(found, found.of(one, name), lambda r: r.nees_missed, lambda _: False) for one in found.faults]
        rows.append([name, *cells])
    head = ["filter", *(fault.name + _mark(fault) for fault in found.faults)]
    return table(head, rows, texts=len(head))


def _recordings(found: Found) -> str:
    def listed(items: Sequence[str]) -> str:
        return "\n".join(textwrap.fill(item, 120, initial_indent="- ", subsequent_indent="  ") for item in items)

    return prose(
        RECORDINGS,
        faults=listed([f"**{fault.name}{_mark(fault)}**: {fault.text}." for fault in FAULTS]),
        paces=listed([f"`{name}`: {pace.text}." for name, pace in PACES.items()]),
        rate=RATE,
        turn=TURN_TIME,
        first=FIRST,
        last=LAST,
        range=REST_RANGE,
        gyr_noise=GYR_NOISE,
        gyr_bias=GYR_BIAS,
        acc_noise=ACC_NOISE,
        acc_bias=ACC_BIAS,
        mag_noise=MAG_NOISE,
    )


def _usual(found: Found) -> str:
    rows = [
        [name, observed(name) or "(total)", *(f"{found.usual[scene, name]:.2f}" for scene in found.scenes)]
        for name in found.filters
    ]
    return table(["filter", "error", *found.scenes], rows, texts=2)


def _errors(found: Found, fault: Fault) -> str:
    rows = []
    for name in found.filters:
        results = found.of(fault, name)
        if results:
            rows.append([name, *(_error_cell(name, results[scene]) for scene in found.scenes)])
    if not rows:
        return "No filter can be told.\n"
    return table(["filter", *found.scenes], rows)


def _error_cell(name: str, result: Result) -> str:
    text = f"{_numbers(np.median(result.error, axis=0))} ≤ {_number(float(result.error[:, GOAL].max()))}"
    if result.sigma is not None:
        text += f", σ {_number(float(np.median(result.sigma[:, GOAL])))}"
    return f"**{text} ({result.missed})**" if result.missed and observed(name) else text


def _before(found: Found, offline: Sequence[str]) -> str:
    rows = []
    for fault in found.faults:
        for name in offline:
            results = found.of(fault, name)
            if results:
                cells = [_before_cell(results[scene]) for scene in found.scenes]
                rows.append([fault.name + _mark(fault), name, *cells])
    return table(["fault", "filter", *found.scenes], rows, texts=2)


def _before_cell(result: Result) -> str:
    text = f"{_numbers(np.median(result.before, axis=0))} ≤ {_number(float(result.before.max()))}"
    return f"**{text} ({result.missed_before})**" if result.missed_before else text


def _nees(found: Found, name: str) -> str:
    rows = []
    for fault in found.faults:
        results = found.of(fault, name)
        if results:
            rows.append([fault.name + _mark(fault), *(_nees_cell(results[scene]) for scene in found.scenes)])
    return table(["fault", *found.scenes], rows)


def _nees_cell(result: Result) -> str:
    assert result.nees is not None
    assert result.nees_undisturbed is not None
    after, without = (np.median(one, axis=0) for one in (result.nees, result.nees_undisturbed))
    text = f"{_numbers(after)} ({_numbers(without)})"
    if result.nees_missed:
        return f"**{text}**"
    return f"*{text}*" if np.any(after >= NEES_FACTOR * without) else text
