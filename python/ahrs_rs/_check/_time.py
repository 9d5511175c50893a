"""Time: rate, jitter, bursts, gaps, repeated rows and stamps, leaps, a stated rate that the stamps contradict."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _plausible
from ahrs_rs._check import _changes
from ahrs_rs._check._case import BLOCK, Case
from ahrs_rs._check._findings import Change, Finding
from ahrs_rs._rate import median, nominal_rate, unbroken

FloatArray = NDArray[np.float64]

SIZES = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}
#: A step of more usual ones than this is a gap; a clock that leaps by as many seconds has been set.
GAP, LEAP = 2.5, 3600.0
#: Gaps that a filter feels: the longest one, s, and the part of the time that is lost.
LONG_GAP, LOST = 0.5, 0.02
#: Standard deviation of the steps over the usual one.
JITTER = 0.2
#: Parts of the rows that repeat the one before in all sensors: more is a fault, still more a sensor slower than the
#: rows.
REPEATED = (0.01, 0.2)
#: Part of the rows with the stamp of the row before that is that of packets.
PACKED = 0.3
#: Difference of a stated rate from that of the stamps.
STATED = (0.02, 0.2)
MOST = 1 << 21


def check_time(case: Case) -> Iterator[Finding]:
    """Findings about the clock of the rows, and of sensors with clocks of their own."""
    t = case.recording.t
    if len(t) < 8 or not t[-1] > t[0]:
        yield Finding(
            "time.rate", "note", f"cannot tell: {len(t)} rows over {case.duration:.3g} s", float(len(t)), "rows", 1.0
        )
        return
    rate = nominal_rate(t)
    yield from _unit(case, rate)
    yield from _stated(case, rate)
    yield from _steps(case, t, rate)
    yield from _repeated_rows(case)
    yield from _repaired(case)
    yield from _clocks(case)


def _unit(case: Case, rate: float) -> Iterator[Finding]:
    wrong = _plausible.doubtful_rate(rate)
    if wrong is None:
        return
    unit = _plausible.likely_time_unit(rate)
    meaning = "every step is integrated over a wrong time: the attitude is wrong from the first second"
    if unit is None:
        yield Finding("time.unit", "error", wrong, rate, "Hz", 0.9, meaning, "give the right times, or rate=")
        return
    factor = SIZES[unit]
    case.factors["t"] = factor
    text = f"the stamps are in {unit}: times × {factor:g}"
    yield Finding(
        "time.unit",
        "error",
        f"{wrong}; as {unit} the stamps are those of {rate / factor:.4g} Hz",
        rate,
        "Hz",
        0.97,
        meaning,
        f"units={{'t': '{unit}'}} (--units t={unit})",
        {"unit": unit, "factor": factor},
        _changes.timed("time.unit", factor, text),
    )


def _stated(case: Case, rate: float) -> Iterator[Finding]:
    stated = case.recording.rate
    apart = abs(stated / rate - 1.0)
    if apart < STATED[0]:
        return
    yield Finding(
        "time.stated",
        "warning",
        f"a rate of {stated:.5g} Hz is stated, the stamps are those of {rate:.5g} Hz",
        rate,
        "Hz",
        0.9,
        "filters step by the stamps; time constants and the first step are of the stated rate",
        "leave rate= away, or give the times that belong to it",
        {"stated": stated},
    )


def _steps(case: Case, t: FloatArray, rate: float) -> Iterator[Finding]:
    factor = case.factors["t"]
    steps = np.diff(t)
    usual = 1.0 / rate
    _, packet = unbroken(t)
    yield from _repeated_stamps(t, steps)
    shown = rate / factor
    if packet > 1 and np.count_nonzero(steps == 0.0) + np.count_nonzero(steps < 0.2 * usual) > PACKED * len(t):
        yield Finding(
            "time.bursts",
            "warning",
            f"the rows come in packets of about {packet}: their stamps are those of the arrival",
            float(packet),
            "rows",
            0.95,
            "the angular rate is integrated over steps of nothing and then over long ones",
            "spread the stamps evenly (fixed() does), or take those of the sensor",
            {"rate": shown},
            _spread(case, t, rate, steps),
        )
        return
    regular = steps[(steps > 0.0) & (steps < GAP * usual)]
    jitter = float(regular.std()) * rate if regular.size > 2 else 0.0
    severity = "ok" if jitter < JITTER else "note"
    yield Finding(
        "time.rate",
        severity,
        f"{shown:.5g} Hz, steps vary by {100.0 * jitter:.2g} %",
        shown,
        "Hz",
        1.0,
        "" if severity == "ok" else "a filter has to be given the stamps (t=), not a rate alone",
        "" if severity == "ok" else "run it with the recording, or with t=",
        {"jitter": jitter, "usual_step": median(steps) * factor},
    )
    gaps = np.flatnonzero(steps > GAP * usual)
    if gaps.size:
        lost = float(np.sum(steps[gaps] - usual)) * factor
        longest = float(steps[gaps].max()) * factor
        at = float(t[gaps[np.argmax(steps[gaps])]] - t[0]) * factor
        leap = longest > LEAP
        grave = longest > LONG_GAP or lost > max(LOST * case.duration, LONG_GAP)
        yield Finding(
            "time.leap" if leap else "time.gaps",
            "warning" if grave else "note",
            f"{gaps.size} gaps, {lost:.3g} s in all, the longest {longest:.3g} s after {at:.4g} s"
            + ("; the clock was set there" if leap else ""),
            longest,
            "s",
            0.9,
            "what turned in a gap is unknown: the heading is off by it until the magnetometer brings it back",
            "treat the parts as recordings of their own where a gap is long",
            {"count": int(gaps.size), "lost": lost, "at": at},
        )


def _repeated_stamps(t: FloatArray, steps: FloatArray) -> Iterator[Finding]:
    same = int(np.count_nonzero(steps == 0.0))
    if 0 < same < PACKED * len(t):  # more are those of packets
        yield Finding(
            "time.repeated_stamps",
            "warning" if same > 0.01 * len(t) else "note",
            f"{same} rows have the stamp of the row before",
            same / len(t),
            "of the rows",
            0.95,
            "their angular rate counts for no time",
            "give the stamps of the sensor's own clock",
        )


def _spread(case: Case, t: FloatArray, rate: float, steps: FloatArray) -> Change | None:
    if case.recording.has_own_clocks or case.factors["t"] != 1.0 or (steps > 20.0 * max(512, 1) / rate).any():
        return None
    ahead = np.arange(len(t)) / rate
    # A packet arrives after its last reading: the line below all arrivals.
    start = float(np.min(t - ahead))
    drift = float(np.max(t - ahead) - start)
    if drift > 4.0 * float(steps.max()):
        return None
    text = f"stamps of packets spread evenly over {rate:.5g} Hz"
    return _changes.restamped("time.bursts", start + ahead, rate, text)


def _repeated_rows(case: Case) -> Iterator[Finding]:
    """Rows that are the row before in the gyroscope and in the accelerometer, to the last digit, amid others."""
    names = [name for name in ("gyr", "acc") if name in case.has]
    if not names or len(case.recording) < 100:
        return
    same = np.ones(len(case.recording) - 1, dtype=np.bool_)
    for name in names:
        rows = case.rows(name)
        assert rows is not None
        for i in range(0, len(same), BLOCK):
            end = min(i + BLOCK, len(same))
            same[i:end] &= (rows[i + 1 : end + 1] == rows[i:end]).all(axis=1)
    share = float(same.mean())
    if share == 0.0:
        return
    grave = REPEATED[0] < share < REPEATED[1] and len(names) > 1
    slower = f": the sensor gives {case.rate * (1.0 - share):.3g} readings a second" if share >= REPEATED[1] else ""
    yield Finding(
        "time.repeated_rows",
        "warning" if grave else "note",
        f"{int(same.sum())} rows repeat the row before in {' and '.join(names)}{slower}",
        share,
        "of the rows",
        0.9 if len(names) > 1 else 0.5,
        "the same turn is counted twice, or a reading was lost and the last one held",
        "take the repeated rows out, with their stamps, or give the rate at which the sensor was read",
    )


def _repaired(case: Case) -> Iterator[Finding]:
    for kind, severity in (("repairs", "note"), ("lost", "note"), ("doubts", "note")):
        for sentence in case.recording.meta.get(kind, ()):
            yield Finding(f"time.{kind}" if str(sentence).startswith("t:") else f"file.{kind}", severity, str(sentence))


def _clocks(case: Case) -> Iterator[Finding]:
    if not case.recording.has_own_clocks:
        return
    streams = {name: one for name, one in case.recording.streams.items() if name in ("gyr", "acc", "mag", "ref")}
    ends = {name: (float(one.t[0]), float(one.t[-1])) for name, one in streams.items() if len(one) > 1}
    if len(ends) < 2:
        return
    begin, end = max(one[0] for one in ends.values()), min(one[1] for one in ends.values())
    whole = max(one[1] for one in ends.values()) - min(one[0] for one in ends.values())
    share = max(end - begin, 0.0) / whole if whole > 0.0 else 1.0
    if share < 0.9:
        yield Finding(
            "time.overlap",
            "warning" if share < 0.5 else "note",
            f"the sensors' clocks overlap over {100.0 * share:.0f} % of the time: "
            + ", ".join(f"{name} {one[0]:.6g} to {one[1]:.6g} s" for name, one in ends.items()),
            share,
            "",
            0.95,
            "where a sensor is missing the filter goes on without it",
            "give all sensors on one time base",
        )
