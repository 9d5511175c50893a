"""Hyyti & Visala 2015: DCM-IMU, Madgwick and Mahony, with accelerations and with a biased gyroscope."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

import ahrs_rs as ar
from ahrs_rs._typing import FloatArray
from ahrs_rs.papers import _common
from ahrs_rs.papers._study import Cell, Claim, Plot, Study, Table, Verdict, band, boxes, lines
from ahrs_rs.papers._warm_up import WarmUp

Errors: TypeAlias = dict[str, list[FloatArray]]
"""For every filter and recording (3, T): errors of roll, pitch and yaw in degrees, NaN where none counts."""
Sweep: TypeAlias = dict[str, FloatArray]
"""For every filter (B, 3): RMSE of roll, pitch and yaw at every added bias."""
Tests: TypeAlias = Mapping[str, Sequence[ar.Recording]]

TITLE = (
    "H. Hyyti, A. Visala: A DCM based attitude estimation algorithm for low-cost MEMS IMUs, International Journal of "
    "Navigation and Observation, 2015 (Kuka LWR 4+, MicroStrain Inertia-Link, SparkFun 6DOF)"
)

PROTOCOL = """Six axes at 150 Hz. Rotation test: a path in 6D driven four times, each time at half the speed of the
time before; acceleration test: back and forth along x, y and z, each four times at halved speeds, almost without
rotation. Both with a good sensor (A, Inertia-Link) and a cheap one (B, SparkFun), calibrated. Then a constant bias of
0 to 7°/s is added to all axes of A's gyroscope, and the filters start cold. Madgwick has β 0.1, Mahony kp 0.5 and ki
0, DCM-IMU the numbers of Table 1; all have the published first-order step and gradient. "DCM, exponential" is DCM-IMU
with a prediction by the exponential map, which the paper does not have. The built-in estimate of the Inertia-Link is
not reproduced.

Without a magnetometer yaw is relative to its start: the error of the first sample that counts is taken off.

Real recordings: rotations for the rotation test, translations for the acceleration test, both without their
magnetometer, whose gyroscope has biases of 0.2 to 0.5°/s before any is added. A test without rotation does not exist
among them. There is no real recording of a warming sensor."""

CLASSES: dict[str, type[ar.Filter]] = {name: ar.FILTERS[key] for name, key in (
    ("DCM", "DcmImu"), ("Madgwick", "Madgwick"), ("Mahony", "Mahony"), ("DCM, exponential", "DcmImu")
)}  # fmt: skip
#: Those of the paper.
OWN = ("DCM", "Madgwick", "Mahony")
SENSORS = {"A": "inertialink", "B": "sparkfun6dof"}
#: Tables 2 and 3: RMSE of yaw, pitch, roll in degrees.
RMSE: dict[str, dict[str, dict[str, tuple[float, float, float]]]] = {
    "rotation": {
        "A": {"DCM": (1.57, 0.56, 0.61), "Madgwick": (2.40, 0.98, 1.52), "Mahony": (2.49, 0.68, 0.82)},
        "B": {"DCM": (3.91, 1.29, 1.46), "Madgwick": (4.28, 1.46, 1.71), "Mahony": (4.20, 1.22, 1.05)},
    },
    "acceleration": {
        "A": {"DCM": (1.19, 0.42, 0.17), "Madgwick": (0.31, 0.93, 0.87), "Mahony": (0.31, 0.40, 0.32)},
        "B": {"DCM": (2.29, 0.26, 0.70), "Madgwick": (0.14, 0.78, 0.79), "Mahony": (0.16, 0.30, 0.40)},
    },
}

#: So many draws of the sensors' errors.
DRAWS = 3
#: "As accurate" is what the paper calls 1.21 times the best (Table 2, sensor B).
AS_ACCURATE = 1.25
#: Added to every axis, deg/s.
BIASES = np.arange(0.0, 7.25, 0.5)
#: Of Fig 10, deg/s.
INDUCED = 1.0
#: A variance is read so often, s.
EVERY = 0.5
#: Where the covariance of the bias stands in the variables of DcmImu's state: the last three of the diagonal of P.
VARIANCES = (35, 42, 49)
#: Part of an added bias that may be missing in the estimate.
FOUND = 0.1


def study(recordings: list[ar.Recording], seed: int) -> Study:
    """The study."""
    simulated = {sensor: simulated_tests(name, seed) for sensor, name in SENSORS.items()}
    real = real_tests(recordings)
    found = {sensor: {test: errors(group) for test, group in tests.items()} for sensor, tests in simulated.items()}
    real_found = {test: errors(group) for test, group in real.items()}
    swept = {test: sweep(group) for test, group in simulated["A"].items()}
    real_swept = {test: sweep(group) for test, group in real.items()}
    fig10, real_fig10 = convergence(simulated["A"]["acceleration"][0]), None
    if real:
        real_fig10 = convergence(real["acceleration"][0])
    warm = WarmUp.of(seed)
    both = found["A"], real_found or None
    sweeps = swept, real_swept or None
    return Study(
        name="hyyti2015",
        title=TITLE,
        protocol=PROTOCOL,
        tables=[
            _rmse_table("Table 2: RMSE of the rotation test", "rotation", found, real_found),
            _rmse_table("Table 3: RMSE of the acceleration test", "acceleration", found, real_found),
            _box_table(found["A"], real_found),
            *(_sweep_table(test, swept[test], real_swept.get(test)) for test in swept),
            _bias_table(fig10, real_fig10),
            warm.table(),
        ],
        claims=[
            Claim("Calibrated, DCM-IMU is as accurate as the others", *_common.verdicts(as_accurate, *both)),
            Claim("DCM-IMU is the most robust against acceleration", *_common.verdicts(most_robust, *both)),
            Claim("Mahony is more robust against acceleration than Madgwick", *_common.verdicts(mahony, *both)),
            Claim("Only DCM-IMU finds a gyroscope's bias", *_common.verdicts(finds_the_bias, *sweeps)),
            Claim("With rotation its yaw endures a bias of 1°/s", *_common.verdicts(keeps_yaw, *sweeps)),
            Claim("Without rotation the vertical bias is not found", _not_found(fig10), None),
            Claim(
                "Where it cannot be found its σ does not grow: the filter is stable",
                _stable(fig10),
                _stable(real_fig10) if real_fig10 else None,
            ),
            Claim("A linear model of temperature takes the bias away", warm.verdict(), None),
        ],
        plots=[*_box_plots(found["A"]), *_sweep_plots(swept, "simulated"), *_sweep_plots(real_swept, "real"),
               *_bias_plots(fig10), warm.plot()],
    )  # fmt: skip


def simulated_tests(sensor: str, seed: int) -> dict[str, list[ar.Recording]]:
    """Both tests with a sensor, in several draws of its errors."""
    return {
        test: [ar.simulate.scenario(f"{test}_test", sensor=sensor, seed=one) for one in range(seed, seed + DRAWS)]
        for test in RMSE
    }


def real_tests(recordings: Sequence[ar.Recording]) -> dict[str, list[ar.Recording]]:
    """The nearest real recordings, where roll and yaw are told apart."""
    found = {
        test: [_common.not_vertical(one) for one in _common.named(recordings, kind)]
        for test, kind in {"rotation": "_rotation", "acceleration": "_translation"}.items()
    }
    return found if all(found.values()) else {}


def filters(rate: float) -> Mapping[str, ar.Filter]:
    """Those of the paper and a form of its own that is not in it."""
    own = {"DCM, exponential": {"prediction": "exponential"}}
    return {name: _common.as_published(cls, "hyyti2015", rate, **own.get(name, {})) for name, cls in CLASSES.items()}


def errors(group: Sequence[ar.Recording]) -> Errors:
    """Of all filters on all recordings."""
    return {
        name: [
            _errors(est, recording)
            for est, recording in zip(_common.estimates(f, group, nine_axes=False), group, strict=True)
        ]
        for name, f in filters(group[0].rate).items()
    }


def rmse(found: Errors) -> dict[str, FloatArray]:
    """(3,) of roll, pitch and yaw: means over the recordings."""
    return {name: _common.mean(ar.metrics.rmse(each) for each in group) for name, group in found.items()}


def inclined(found: Errors) -> dict[str, float]:
    """RMSE, RMS over roll and pitch."""
    return {name: float(np.sqrt((each[:2] ** 2).mean())) for name, each in rmse(found).items()}


def sweep(group: Sequence[ar.Recording]) -> Sweep:
    """RMSE at every added bias."""
    return {
        name: np.array([rmse({name: each})[name] for each in _biased(f, group)])
        for name, f in filters(group[0].rate).items()
    }


def as_accurate(found: Mapping[str, Errors]) -> Verdict:
    """On the rotation test, by roll and pitch."""
    values = inclined(found["rotation"])
    return Verdict(values["DCM"] <= AS_ACCURATE * min(values[name] for name in OWN), _common.listed(values))


def most_robust(found: Mapping[str, Errors]) -> Verdict:
    """By the largest error of roll and pitch on the acceleration test."""
    values = {
        name: max(float(np.nanmax(np.abs(each[:2]))) for each in group) for name, group in found["acceleration"].items()
    }
    return Verdict(min(OWN, key=values.__getitem__) == "DCM", "at most " + _common.listed(values))


def mahony(found: Mapping[str, Errors]) -> Verdict:
    """By the RMSE of roll and pitch on the acceleration test."""
    values = inclined(found["acceleration"])
    return Verdict(values["Mahony"] < values["Madgwick"], _common.listed(values))


def finds_the_bias(swept: Mapping[str, Sweep]) -> Verdict:
    """Whether on both tests the bias makes the others' roll and pitch worse, and DCM-IMU's less than half as much."""
    growth = {}
    for test, each in swept.items():
        joint = {name: np.sqrt((values[:, :2] ** 2).mean(axis=1)) for name, values in each.items()}
        growth[test] = {name: float(values[-1] - values[0]) for name, values in joint.items()}
    holds = all(values["DCM"] < 0.5 * min(values["Madgwick"], values["Mahony"]) for values in growth.values())
    parts = [f"{test}: {_common.listed(values)}" for test, values in growth.items()]
    return Verdict(holds, f"RMSE more at {BIASES[-1]:g}°/s, " + "; ".join(parts))


def keeps_yaw(swept: Mapping[str, Sweep]) -> Verdict:
    """By the RMSE of yaw on the rotation test with 1°/s added, as Fig 7: a tenth of the others'."""
    place = int(np.searchsorted(BIASES, INDUCED))
    values = {name: float(each[place, 2]) for name, each in swept["rotation"].items()}
    return Verdict(values["DCM"] < 0.1 * min(values["Madgwick"], values["Mahony"]), _common.listed(values))


@dataclasses.dataclass(frozen=True, slots=True)
class Convergence:
    """Fig 10: DCM-IMU's bias and its standard deviation over time, degrees per second."""

    t: FloatArray
    bias: FloatArray
    """(N, 3)"""
    sigma: FloatArray
    """(N, 3)"""
    true: FloatArray
    """(3,) what is added and, where it is known, what the sensor has by itself."""


def convergence(recording: ar.Recording) -> Convergence:
    """The bias that is estimated where 1°/s is added, and the variances that stand in the state."""
    f = filters(recording.rate)["DCM"]
    biased = _with_bias(recording, INDUCED)
    step = max(1, round(EVERY * recording.rate))
    state, rows = None, []
    for begin in range(0, len(biased), step):
        part = biased[begin : begin + step]
        est = f.run(part.gyr, part.acc, t=part.t, state=state)
        assert isinstance(est.state, ar.State)
        assert est.gyr_bias is not None
        state = est.state
        variances = [state.variables[place] for place in VARIANCES]
        rows.append([part.t[-1] - recording.t[0], *np.degrees(est.gyr_bias[-1]), *np.degrees(np.sqrt(variances))])
    table = np.array(rows)
    own = np.degrees(np.array(recording.meta.get("gyr_bias", (0.0, 0.0, 0.0)), dtype=np.float64))
    return Convergence(table[:, 0], table[:, 1:4], table[:, 4:], own + INDUCED)


def _errors(est: ar.Estimate, recording: ar.Recording) -> FloatArray:
    """(3, T), yaw less its first error."""
    error = _common.angles(est, recording).T.copy()
    if recording.mask is not None:
        error[:, ~recording.mask] = np.nan
    known = error[2, ~np.isnan(error[2])]
    error[2] = (error[2] - known[0] + 180.0) % 360.0 - 180.0
    return error


def _with_bias(recording: ar.Recording, bias: float) -> ar.Recording:
    return dataclasses.replace(recording, gyr=recording.gyr + np.radians(bias))


def _biased(f: ar.Filter, group: Sequence[ar.Recording]) -> Iterable[list[FloatArray]]:
    """For every bias the errors on all recordings."""
    for bias in BIASES:
        runs = [_with_bias(one, float(bias)) for one in group]
        yield [_errors(est, one) for est, one in zip(_common.estimates(f, runs, nine_axes=False), runs, strict=True)]


def _not_found(found: Convergence) -> Verdict:
    missing = np.abs(found.bias[-1] - found.true) / INDUCED
    numbers = _common.listed(dict(zip("xyz", map(float, found.bias[-1]), strict=True)), "°/s")
    return Verdict(
        bool(missing[2] > 0.5 and missing[:2].max() < FOUND), f"{INDUCED:g}°/s added, found at the end: {numbers}"
    )


def _stable(found: Convergence) -> Verdict:
    first, most, last = found.sigma[0, 2], found.sigma[:, 2].max(), found.sigma[-1, 2]
    # The process noise of the bias adds less than a thousandth in an hour.
    return Verdict(bool(most <= 1.001 * first), f"σ about z: first {first:.3g}, at most {most:.3g}, last {last:.3g}°/s")


def _rmse_table(title: str, test: str, found: Mapping[str, Mapping[str, Errors]], real: Mapping[str, Errors]) -> Table:
    rows: list[list[Cell]] = []
    worlds = {f"sensor {name}": each for name, each in found.items()} | ({"real": real} if real else {})
    for label, each in worlds.items():
        for name, angles in rmse(each[test]).items():
            paper = RMSE[test].get(label.removeprefix("sensor "), {}).get(name, (None, None, None))
            rows.append([label, name, *paper, *map(float, angles[::-1])])
    columns = ["data", "method", "yaw (paper)", "pitch (paper)", "roll (paper)", "yaw", "pitch", "roll"]
    return Table(title, columns, rows)


def _box_table(simulated: Mapping[str, Errors], real: Mapping[str, Errors]) -> Table:
    rows: list[list[Cell]] = []
    for world, found in (("simulated", simulated), ("real", real)):
        for test, each in found.items():
            for label, box in _boxes(test, each).items():
                numbers = (box.low, box.q1, box.median, box.q3, box.high, box.outliers)
                rows.append([world, test, label, *map(float, numbers[:5]), int(numbers[5])])
    columns = ["data", "test", "method", "low", "lower quartile", "median", "upper quartile", "high", "outliers"]
    note = "Whiskers end at the most distant errors in the rotation test, and at 1.5 quartile distances in the other."
    return Table("Figs 4 and 6: boxes and whiskers (sensor A)", columns, rows, note=note)


def _boxes(test: str, found: Errors) -> dict[str, ar.metrics.Box]:
    """Of yaw, and of roll and pitch together."""
    whisker = np.inf if test == "rotation" else 1.5
    boxes = {}
    for part, angles in (("yaw", slice(2, 3)), ("roll, pitch", slice(0, 2))):
        for name in OWN:
            values = np.concatenate([each[angles].ravel() for each in found[name]])
            boxes[f"{name}: {part}"] = ar.metrics.box(values, whisker=whisker)
    return boxes


def _sweep_table(test: str, simulated: Sweep, real: Sweep | None) -> Table:
    rows: list[list[Cell]] = []
    for world, found in (("simulated", simulated), ("real", real or {})):
        for name, values in found.items():
            for angle, column in (("yaw", 2), ("pitch", 1), ("roll", 0)):
                rows.append([world, name, angle, *map(float, values[:: len(BIASES) // 7, column])])
    columns = ["data", "method", "angle", *(f"{bias:g}°/s" for bias in BIASES[:: len(BIASES) // 7])]
    figure = {"rotation": "Fig 8", "acceleration": "Fig 9"}[test]
    return Table(f"{figure}: RMSE by added bias, {test} test", columns, rows, note="The plots have steps of 0.5°/s.")


def _bias_table(simulated: Convergence, real: Convergence | None) -> Table:
    rows: list[list[Cell]] = []
    for world, found in (("simulated", simulated), ("real", real)):
        if found is None:
            continue
        for i, axis in enumerate("xyz"):
            for seconds in (1.0, 5.0, 20.0, 80.0):
                k = int(np.searchsorted(found.t, seconds - 1e-9))
                if k < len(found.t):
                    rows.append([world, axis, float(seconds), float(found.bias[k, i]), float(found.sigma[k, i])])
    columns = ["data", "axis", "after [s]", "bias", "σ"]
    note = "In the real recording the sensor's own bias is in it."
    return Table("Fig 10: bias where 1°/s is added, acceleration test, °/s", columns, rows, note=note, form=".3f")


def _box_plots(found: Mapping[str, Errors]) -> list[Plot]:
    return [boxes(f"Errors in the {test} test (A)", _boxes(test, each), "error [°]") for test, each in found.items()]


def _sweep_plots(swept: Mapping[str, Sweep], world: str) -> list[Plot]:
    return [
        lines(f"RMSE of {angle} by added bias, {test} test, {world}", BIASES,
              {name: values[:, column] for name, values in each.items()}, "bias [°/s]", "RMSE [°]")
        for test, each in swept.items()
        for angle, column in (("roll", 0), ("pitch", 1), ("yaw", 2))
    ]  # fmt: skip


def _bias_plots(found: Convergence) -> list[Plot]:
    plots = []
    for i, axis in enumerate("xyz"):
        curves = {"estimate": found.bias[:, i], "true": np.full(len(found.t), found.true[i])}
        plot = lines(f"Bias about {axis}, acceleration test", found.t, curves, "time [s]", "bias [°/s]")
        low, high = (found.true[i] + sign * found.sigma[:, i] for sign in (-1.0, 1.0))
        plots.append(band(plot, "true ± σ", found.t, low, high))
    return plots
