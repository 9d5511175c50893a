"""The plots of a report, as plotly takes them: the time line, what turns with what, the ellipsoid, the spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check import _chips
from ahrs_rs._check._spectrum import spectrum

if TYPE_CHECKING:
    from ahrs_rs._check._report import Report

FloatArray = NDArray[np.float64]
Figure = dict[str, Any]

NAMES = {"gyr": "gyroscope, rad/s", "acc": "accelerometer, m/s²", "mag": "magnetometer"}
COLOURS = {"best": "#06692d", "next": "#c77700", "recorded": "#a3211a"}
#: Points of a line, and of a cloud.
POINTS, CLOUD = 2000, 3000


def figures(report: Report) -> list[Figure]:
    """Those that there is data for."""
    with np.errstate(all="ignore"):
        made = [_time_line(report), *_ties(report), _ellipsoid(report), _spectra(report)]
    return [one for one in made if one is not None]


def _rounded(values: Any) -> list[Any]:
    return [None if not np.isfinite(one) else float(f"{one:.5g}") for one in np.asarray(values, dtype=np.float64)]


def _time_line(report: Report) -> Figure | None:
    case = report._case
    traces = []
    for number, sensor in enumerate(case.has):
        cells = case.cells(sensor)
        stride = max(len(cells.t) // POINTS, 1)
        start = float(case.recording.t[0]) * case.factors["t"]
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "name": NAMES[sensor],
                "x": _rounded(cells.t[::stride] - start),
                "y": _rounded(np.linalg.norm(cells.mean[::stride], axis=1)),
                "yaxis": "y" if not number else f"y{number + 1}",
            }
        )
    if not traces:
        return None
    layout: dict[str, Any] = {"xaxis": {"title": {"text": "s"}}, "showlegend": False}
    share = 1.0 / len(traces)
    for number, trace in enumerate(traces):
        low, high = number * share, (number + 1) * share - 0.04
        axis = "yaxis" if not number else f"yaxis{number + 1}"
        layout[axis] = {"domain": [low, high], "title": {"text": trace["name"]}}
    return {"title": "Norms over half a second each", "data": traces, "layout": layout}


def _ties(report: Report) -> list[Figure]:
    """Of each vector: what is left in every window, for the best candidate, the next one, and the axes as recorded."""
    made = []
    for sensor, verdict in report._case.known.get("verdicts", {}).items():
        tie = verdict.tie
        if tie is None:
            continue
        best, recorded = tie.best, tie.find(0, 1.0, 1.0)
        chosen = {"best": best, "next": int(np.argmin(tie.scores()))}
        if recorded not in chosen.values():
            chosen["recorded"] = recorded
        traces = []
        for kind, number in chosen.items():
            one = tie.candidates[number]
            unit = "" if one.factor == 1.0 else f" × {one.factor:.3g}"
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "name": f"{kind}: gyroscope ({_chips.axes_of(one.matrix)}){unit}",
                    "x": _rounded(np.degrees(tie.turned)),
                    "y": _rounded(tie.costs[:, number]),
                    "marker": {"color": COLOURS[kind], "size": 5},
                }
            )
        layout = {
            "xaxis": {"title": {"text": "turn seen by the gyroscope in a window, °"}},
            "yaxis": {"title": {"text": "what it leaves of the vector's turn"}, "range": [0, 1.05]},
        }
        title = f"Gyroscope and {'accelerometer' if sensor == 'acc' else 'magnetometer'} (z {verdict.score:.1f})"
        made.append({"title": title, "data": traces, "layout": layout})
    return made


def _ellipsoid(report: Report) -> Figure | None:
    case = report._case
    if "mag" not in case.has:
        return None
    mag = case.coarse().mag
    assert mag is not None
    mag = mag[np.isfinite(mag).all(axis=1)]
    mag = mag[:: max(len(mag) // CLOUD, 1)]
    if not len(mag):
        return None
    traces: list[dict[str, Any]] = [_cloud("readings", mag, "#3465a4", 2), _cloud("zero", np.zeros((1, 3)), "#222", 5)]
    iron = report.get("mag.iron")
    if iron is not None and iron.evidence.get("offset") is not None:
        traces.append(_cloud("hard iron", np.asarray(iron.evidence["offset"])[np.newaxis], "#a3211a", 5))
    return {"title": "The field in the sensor's axes", "data": traces, "layout": {"scene": {"aspectmode": "data"}}}


def _cloud(name: str, points: FloatArray, colour: str, size: int) -> dict[str, Any]:
    x, y, z = (_rounded(one) for one in points.T)
    marker = {"size": size, "color": colour}
    return {"type": "scatter3d", "mode": "markers", "name": name, "x": x, "y": y, "z": z, "marker": marker}


def _spectra(report: Report) -> Figure | None:
    traces = []
    for sensor in ("gyr", "acc"):
        found = spectrum(report._case, sensor) if sensor in report._case.has else None
        if found is not None:
            amplitude = np.sqrt(np.maximum(found[1][1:], 1e-30))
            x, y = _rounded(found[0][1:]), _rounded(amplitude)
            traces.append({"type": "scatter", "mode": "lines", "name": f"{NAMES[sensor]}/√Hz", "x": x, "y": y})
    if not traces:
        return None
    layout = {"xaxis": {"title": {"text": "Hz"}}, "yaxis": {"type": "log"}}
    return {"title": "Spectrum, to the Nyquist rate", "data": traces, "layout": layout}
