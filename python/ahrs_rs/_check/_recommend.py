"""Which filter, with which parameters, for a recording, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ahrs_rs._check._expected import EXPECTED

if TYPE_CHECKING:
    from ahrs_rs._check._report import Report
    from ahrs_rs._filter import Filter

#: Standard deviation of the specific force over half a second, in the median, that is strong, m/s².
SHAKEN = 4.0
#: Findings of errors that a filter with more states finds by itself.
FOUND = ("gyr.bias", "gyr.scale", "acc.norm", "mag.iron")


@dataclass(frozen=True, slots=True, eq=False)
class Recommendation:
    """A filter for a recording, and why."""

    name: str
    """Of the filter."""
    params: Mapping[str, float | str | bool]
    """That differ from its defaults."""
    keywords: Mapping[str, Any]
    """What every filter takes: rate, declination."""
    six_axes: bool
    """Whether to leave the magnetometer out."""
    reasons: tuple[str, ...]
    """A sentence each."""
    expected: tuple[float, float, int] | None
    """° of total error (RMSE) on real recordings of this kind, median and worst, and how many these are; of
    the inclination where `six_axes`."""
    alternatives: Mapping[str, str] = field(default_factory=dict)
    """Other filters -> when to take them."""

    def make(self) -> Filter:
        """The filter."""
        from ahrs_rs.filters import FILTERS

        given: dict[str, Any] = {**self.keywords, **self.params}
        return FILTERS[self.name](**given)

    def __str__(self) -> str:
        """For reading."""
        given = " ".join(f"{key}={value:.6g}" for key, value in {**self.keywords, **self.params}.items())
        lines = [f"{self.name} {given}" + (", without the magnetometer" if self.six_axes else "")]
        lines += [f"  because {one}" for one in self.reasons]
        if self.expected is not None:
            what = "inclination" if self.six_axes else "attitude"
            lines.append(
                f"  expect {self.expected[0]:.1f}° (RMSE of the {what}, as a median; {self.expected[1]:.0f}° at worst)"
            )
        lines += [f"  or {name}: {when}" for name, when in self.alternatives.items()]
        return "\n".join(lines)


def recommend(report: Report, *, online: bool) -> Recommendation:
    """See `Report.recommend`."""
    case = report._case
    has = case.has
    reasons: list[str] = []
    keywords: dict[str, Any] = {"rate": float(case.rate)}
    if "gyr" not in has:
        reasons.append("there is no gyroscope: the attitude is that of gravity and the field alone")
        name = "Ecompass" if "mag" in has else "Tilt"
        return Recommendation(name, {}, keywords, "mag" not in has, tuple(reasons), None)
    if "acc" not in has:
        reasons.append("there is no accelerometer: the gyroscope is integrated, and drifts")
        return Recommendation("GyroIntegration", {}, keywords, True, tuple(reasons), None)
    six, why = _without_field(report)
    reasons.append(why)
    reasons.append(
        "readings are taken as they come"
        if online
        else "the whole recording is there: a filter that looks ahead and back is more accurate"
    )
    wrong = [code for code in FOUND if _severity(report, code) in ("note", "warning")]
    wrong = [code for code in wrong if (report[code].value or 0.0) and not (six and code.startswith("mag"))]
    calibrates = "gyr.scale" in wrong or "acc.norm" in wrong or "mag.iron" in wrong
    own, other = ("SelfCalKF", "VQF") if online else ("SelfCalSmoother", "OfflineVQF")
    name = own if calibrates and not six else other
    if name == own:
        reasons.append(f"it finds by itself what is wrong of the sensors ({', '.join(wrong)})")
    params: dict[str, float | str | bool] = {}
    shaken = _shaken(report)
    if shaken > SHAKEN and name == other:
        params["tau_acc"] = 6.0
        reasons.append(f"acceleration of {shaken:.2g} m/s² hides the vertical: a longer time constant")
    delay = _value(report, "mag.delay")
    if delay is not None and not six and _severity(report, "mag.delay") != "ok":
        if name == other and delay > 0.0:
            params["mag_delay"] = round(delay, 4)
            reasons.append(
                f"the magnetometer is {1e3 * delay:.0f} ms late (on fixed() it is not: leave mag_delay away)"
            )
        else:
            reasons.append(f"the magnetometer is {1e3 * delay:.0f} ms off: run it on fixed()")
    if not six and case.place is not None and case.known.get("field") is not None:
        keywords["declination"] = float(case.known["field"].declination)
        reasons.append(f"the declination there is {np.degrees(keywords['declination']):.1f}°")
    kind = "6D" if six else "disturbed" if _severity(report, "mag.disturbed") in ("note", "warning") else "still field"
    alternatives = {other if name == own else own: _when(name == own)}
    if not online:
        alternatives["VQF"] = "where the same has to run in real time"
    return Recommendation(name, params, keywords, six, tuple(reasons), EXPECTED[(name, kind)], alternatives)


def _when(calibrating: bool) -> str:
    if calibrating:
        return "where the sensors are calibrated: it has fewer states to go wrong"
    return "where bias, scale and hard iron are to be found too"


def _without_field(report: Report) -> tuple[bool, str]:
    """Whether to leave the magnetometer out, and why or why not."""
    if "mag" not in report._case.has:
        return True, "there is no magnetometer: the heading is relative to the start, and drifts"
    if any(one.code in ("axes.gyr_mag", "axes.contradiction") for one in report.of("error")):
        return True, "the axes of the magnetometer are in doubt: it would draw the heading anywhere"
    axes = [one for one in report.of("error") if one.code in ("axes.mag", "mag.sign") and one.change is None]
    if axes:
        return True, "the sign of the magnetometer is in doubt: the heading could be half a turn off"
    share = _value(report, "mag.disturbed") or 0.0
    if share > 0.6:
        return True, f"the field is disturbed over {100.0 * share:.0f} % of the time"
    return False, "there is a magnetometer, and it fits: the heading is that of magnetic north"


def _shaken(report: Report) -> float:
    """Median standard deviation of the specific force over half a second, m/s²."""
    cells = report._case.cells("acc")
    std = np.linalg.norm(cells.std[cells.share > 0.05], axis=1)
    return float(np.median(std)) if std.size else 0.0


def _value(report: Report, code: str) -> float | None:
    found = report.get(code)
    return None if found is None else found.value


def _severity(report: Report, code: str) -> str:
    found = report.get(code)
    return "ok" if found is None else found.severity
