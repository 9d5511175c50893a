"""Ludwig & Burnham 2018: EKF, Madgwick and Mahony on a quadrotor's flight, with parameters found genetically."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

import ahrs_rs as ar
from ahrs_rs._typing import FloatArray
from ahrs_rs.papers import _common
from ahrs_rs.papers._study import Claim, Plot, Study, Table, Verdict, lines

Filters: TypeAlias = Mapping[str, ar.Filter]

TITLE = (
    "S. A. Ludwig, K. D. Burnham: Comparison of Euler estimate using extended Kalman filter, Madgwick and Mahony on "
    "quadcopter flight data, ICUAS 2018"
)

PROTOCOL = """A flight along a rectangle indoors, 6,401 samples at 100 Hz, nine axes, with a field that the floor's
iron disturbs. β, kp and ki are those of the paper, and ours, found on this flight by a genetic search for the
smallest total error; five other flights, with errors of the sensor of their own, are what the verdicts go by. The EKF
has its defaults, as in the paper. All have the published first-order step and gradient.

The paper takes the absolute values of angles before it subtracts them, against the jump at 180°; this hides an angle
of the wrong sign. Its numbers stand beside the wrapped differences, and the table has both.

Real recordings: parameters found on half of them, and judged on the other half; samples whose true pitch is beyond
75°, where roll and yaw have little meaning, do not count."""

CLASSES: dict[str, type[ar.Filter]] = {name: ar.FILTERS[name] for name in ("Madgwick", "Mahony", "EKF")}
#: What the genetic search looks for, and where.
SEARCHED: dict[str, dict[str, tuple[float, float]]] = {
    "Madgwick": {"beta": (1e-4, 1.0)},
    "Mahony": {"kp": (1e-4, 10.0), "ki": (1e-6, 1.0)},
}
#: Table I: RMSE of roll, pitch, yaw, and their norm, degrees.
RMSE = {
    "Madgwick": (3.4677, 3.3482, 12.0775, 13.0039),
    "Mahony": (4.1204, 4.7005, 9.06644, 11.0107),
    "EKF": (1.4088, 1.2055, 13.1648, 13.2948),
}
#: Table II: mean absolute errors, and their sum.
MAE = {
    "Madgwick": (1.2272, 1.8787, 3.6674, 6.7733),
    "Mahony": (1.0723, 1.0605, 4.2376, 6.3704),
    "EKF": (0.2220, 0.2397, 5.3192, 5.7809),
}
#: Table III: s for all samples, in MATLAB.
TIMES = {"Madgwick": 0.2080, "Mahony": 0.1782, "EKF": 0.2895}

FLIGHTS = 6
#: Those that the search has not seen.
OTHERS = "tuned, five other flights"
#: Parameters matter where those of other data make the error this much larger.
MATTERS = 1.2


def study(recordings: list[ar.Recording], seed: int) -> Study:
    """The study."""
    flights = [ar.simulate.scenario("quadrotor", seed=one) for one in range(seed, seed + FLIGHTS)]
    first = flights[0]
    tuned = {name: tune(name, [first], seed) for name in SEARCHED}
    paper = filters(first.rate, {})
    ours = filters(first.rate, {name: found.params for name, found in tuned.items()})
    simulated = {
        "paper's parameters": errors(paper, [first]),
        "tuned": errors(ours, [first]),
        OTHERS: errors(ours, flights[1:]),
    }

    real: dict[str, Errors] = {}
    real_tuned: dict[str, ar.tuning.Tuned] = {}
    if recordings:
        level = [_common.not_vertical(one) for one in recordings]
        real_tuned = {name: tune(name, level, seed, test=0.5) for name in SEARCHED}
        test = real_tuned["Mahony"].test
        judges = [level[index] for index in test.recordings] if test is not None else level
        found = {name: one.params for name, one in real_tuned.items()}
        rate = level[0].rate
        real = {"paper's parameters": errors(filters(rate, {}), judges), "tuned": errors(filters(rate, found), judges)}

    table, ns = _common.times("Table III: time of all 6,401 samples", paper, first, TIMES, "s")
    clocked = ns, _common.clocked_on_first(lambda rate: filters(rate, {}), recordings)
    best = simulated[OTHERS], real.get("tuned")
    both = simulated, real or None
    return Study(
        name="ludwig2018",
        title=TITLE,
        protocol=PROTOCOL,
        tables=[
            _table("Table I: RMSE of roll, pitch and yaw", "norm", RMSE, simulated, real, 0),
            _table("Table II: mean absolute error of roll, pitch and yaw", "sum", MAE, simulated, real, 1),
            _search_table(tuned, real_tuned),
            table,
        ],
        claims=[
            Claim("Tuned, Mahony has the smallest RMSE", *_common.verdicts(_norm(_common.smallest("Mahony")), *best)),
            Claim("The EKF has the largest RMSE", *_common.verdicts(_norm(_common.largest("EKF")), *best)),
            Claim("The EKF has the smallest mean absolute error", *_common.verdicts(_sum("EKF"), *best)),
            Claim("Yaw is the least accurate angle of all three", *_common.verdicts(yaw_is_worst, *best)),
            Claim("Madgwick and Mahony need parameters of each data set", *_common.verdicts(data_matter, *both)),
            Claim("Mahony is the fastest", *_common.verdicts(_common.fastest("Mahony"), *clocked)),
            Claim("The EKF is the slowest", *_common.verdicts(_common.slowest("EKF"), *clocked)),
        ],
        plots=_plots(ours, first),
    )


@dataclasses.dataclass(frozen=True, slots=True)
class Errors:
    """Of every filter: (2, 4), RMSE and mean absolute error, each of roll, pitch, yaw and joined."""

    wrapped: dict[str, FloatArray]
    absolute: dict[str, FloatArray]


def tune(name: str, recordings: Sequence[ar.Recording], seed: int, test: float | None = None) -> ar.tuning.Tuned:
    """The genetic search."""
    fixed = {key: value for key, value in published(name, 1.0).params.items() if isinstance(value, str)}
    cls, where = CLASSES[name], SEARCHED[name]
    return ar.tuning.evolve(cls, where, recordings, generations=25, fixed=fixed, test=test, seed=seed)


def published(name: str, rate: float, **params: Any) -> ar.Filter:
    """The filter in the paper's form."""
    return _common.as_published(CLASSES[name], "ludwig2018", rate, **params)


def filters(rate: float, params: Mapping[str, Mapping[str, Any]]) -> Filters:
    """The three, with other parameters than the paper's where they are given."""
    return {name: published(name, rate, **params.get(name, {})) for name in CLASSES}


def errors(filters: Filters, recordings: Sequence[ar.Recording]) -> Errors:
    """Means over the recordings, with both ways to take a difference of angles."""
    found = []
    for convention in ("wrapped", "absolute"):
        one: dict[str, FloatArray] = {}
        for name, f in filters.items():
            pairs = zip(_common.estimates(f, recordings), recordings, strict=True)
            one[name] = _common.mean(_numbers(est, recording, convention) for est, recording in pairs)
        found.append(one)
    return Errors(*found)


def yaw_is_worst(errors: Errors) -> Verdict:
    """Of every filter, by RMSE."""
    ratios = {name: float(each[0, 2] / each[0, :2].max()) for name, each in errors.wrapped.items()}
    numbers = "yaw's error by the larger of the others: " + _common.listed(ratios, "")
    return Verdict(min(ratios.values()) > 1.0, numbers)


def data_matter(by_parameters: Mapping[str, Errors]) -> Verdict:
    """Whether the paper's parameters are worse than those found for these data."""
    paper, tuned = by_parameters["paper's parameters"], by_parameters["tuned"]
    ratios = {name: float(paper.wrapped[name][0, 3] / tuned.wrapped[name][0, 3]) for name in SEARCHED}
    numbers = "RMSE with the paper's parameters by that with ours: " + _common.listed(ratios, "")
    return Verdict(min(ratios.values()) > MATTERS, numbers)


def _numbers(est: ar.Estimate, recording: ar.Recording, convention: str) -> FloatArray:
    error = ar.metrics.euler_error(est.quat, _common.truth(recording), degrees=True, convention=convention).T
    rmse, mae = (np.asarray(number(error, recording.mask)) for number in (ar.metrics.rmse, ar.metrics.mae))
    return np.array([[*rmse, np.linalg.norm(rmse)], [*mae, mae.sum()]])


def _norm(judge: _common.Judge[Mapping[str, float]]) -> _common.Judge[Errors]:
    return lambda errors: judge({key: float(each[0, 3]) for key, each in errors.wrapped.items()})


def _sum(name: str) -> _common.Judge[Errors]:
    return lambda errors: _common.smallest(name)({key: float(each[1, 3]) for key, each in errors.wrapped.items()})


def _table(
    title: str,
    joined: str,
    published: Mapping[str, Sequence[float]],
    simulated: Mapping[str, Errors],
    real: Mapping[str, Errors],
    number: int,
) -> Table:
    rows: list[list[str | float | None]] = [["paper", name, *published[name], None] for name in CLASSES]
    for world, found in (("simulated", simulated), ("real", real)):
        for label, each in found.items():
            for name in CLASSES:
                values = [*map(float, each.wrapped[name][number]), float(each.absolute[name][number, 3])]
                rows.append([f"{world}, {label}", name, *values])
    columns = ["data and parameters", "filter", "roll", "pitch", "yaw", joined, f"{joined} of absolute values"]
    return Table(title, columns, rows)


def _search_table(simulated: Mapping[str, ar.tuning.Tuned], real: Mapping[str, ar.tuning.Tuned]) -> Table:
    rows: list[list[str | float | None]] = []
    for name, where in SEARCHED.items():
        rows += [
            ["paper", name, parameter, float(CLASSES[name].PRESETS["ludwig2018"][parameter])] for parameter in where
        ]
        for world, found in (("simulated", simulated), ("real", real)):
            if name in found:
                rows += [[world, name, parameter, float(found[name].params[parameter])] for parameter in where]
    return Table("Parameters found by the genetic search", ["data", "filter", "parameter", "value"], rows, form=".5f")


def _plots(filters: Filters, recording: ar.Recording) -> list[Plot]:
    t = recording.t - recording.t[0]
    found = {name: np.degrees(_common.estimate(f, recording).euler()) for name, f in filters.items()}
    found["truth"] = ar.metrics.euler(_common.truth(recording), degrees=True)
    return [
        lines(
            f"{name} of the flight", t, {label: each[:, i] for label, each in found.items()}, "time [s]", f"{name} [°]"
        )
        for i, name in enumerate(("Roll", "Pitch", "Yaw"))
    ]
