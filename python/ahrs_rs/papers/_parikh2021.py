"""Parikh, Vohra, Kaveshgar 2021: four filters under external acceleration and vibration."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

import ahrs_rs as ar
from ahrs_rs._typing import FloatArray
from ahrs_rs.papers import _common
from ahrs_rs.papers._study import Cell, Claim, Plot, Study, Table, Verdict, lines, radar

Filters: TypeAlias = Mapping[str, ar.Filter]
Params: TypeAlias = Mapping[str, Mapping[str, Any]]
Cases: TypeAlias = Mapping[str, Sequence[ar.Recording]]
Found: TypeAlias = dict[str, dict[str, FloatArray]]
"""For every case and filter (5, 2): the metrics of roll and pitch."""

Gains: TypeAlias = dict[str, dict[str, tuple[float, float, float]]]
"""For every case and filter: RMSE without and with a threshold, and the threshold."""

TITLE = (
    "D. Parikh, S. Vohra, M. Kaveshgar: Comparison of attitude estimation algorithms with IMU under external "
    "acceleration, iSES 2021 (MPU6050 and ESP32)"
)

PROTOCOL = """Three cases at 200 Hz, six axes: level and pushed back and forth (1), the same banked by 15° (2), and
still with rotors running (3), which start after 5 s of rest and count from then on. The numbers are means over five
sensors. All signals pass a Butterworth low-pass filter of order 4; its cut-off is not given in the paper and is 20 Hz
here. Parameters: the paper's, and ours, found as in the paper by a grid on case 2 for the smallest RMSE. All filters
have the published first-order step and gradient.

A percentage of a true angle of zero is not defined: MAPE counts samples whose true angle is larger than 1° only. GAE
is the geometric mean of the absolute errors, IMRE the iterative mid-range error.

Real recordings: slow and fast translations for the acceleration, and a vibrating phone for the vibration, as BROAD
has them (no low-pass filter: a hand turns faster than a plank, and the delay of 20 ms would be the largest error).
Our parameters are found on the slow translations. The verdicts go by the root mean square over roll and pitch, with
our parameters."""

CLASSES: dict[str, type[ar.Filter]] = {
    "Kalman": ar.FILTERS["LinearKalman"],
    "Madgwick": ar.FILTERS["Madgwick"],
    "Mahony": ar.FILTERS["Mahony"],
    "Complementary": ar.FILTERS["Complementary"],
}
#: Where the grid looks. Of the Kalman filter's three numbers only the ratios matter; R is the paper's.
GRID: dict[str, tuple[dict[str, tuple[float, float]], int]] = {
    "Kalman": ({"angle_process": (1e-8, 1.0), "bias_process": (1e-12, 1e-3)}, 13),
    "Madgwick": ({"beta": (1e-4, 1.0)}, 81),
    "Mahony": ({"kp": (1e-3, 10.0), "ki": (1e-5, 1.0)}, 17),
    "Complementary": ({"tau": (0.01, 1000.0)}, 81),
}
METRICS = ("RMSE", "MAPE", "MAD", "GAE", "IMRE")
#: Table III: RMSE of pitch and roll, of the filters in their order.
RMSE: dict[str, dict[str, tuple[float, float]]] = {
    case: dict(zip(CLASSES, numbers, strict=True))
    for case, numbers in (
        ("1: level", ((0.33, 0.28), (0.30, 0.24), (0.34, 0.29), (0.42, 0.37))),
        ("2: banked 15°", ((0.39, 0.40), (0.35, 0.30), (0.40, 0.41), (0.41, 0.43))),
        ("3: vibration", ((0.33, 0.57), (0.22, 1.74), (0.82, 0.57), (0.38, 0.53))),
    )
}
#: Table II: µs on an ESP32.
TIMES = {"Kalman": 51.0, "Madgwick": 17.0, "Mahony": 14.0, "Complementary": 10.0}

RATE = 200.0
#: So many draws of the sensor's errors.
SENSORS = 5
#: Of the low-pass filter, Hz.
CUTOFF = 20.0
#: Before the rotors start, s.
REST = 5.0
#: Smallest true angle of a percentage, degrees.
LEAST = 1.0
#: "Near identical", as a part of the error.
NEAR = 0.1
#: The parameter of adaptive gains, the paper's future work: a threshold of the acceleration's size.
ADAPTIVE = "acc_threshold"


def study(recordings: list[ar.Recording], seed: int) -> Study:
    """The study."""
    simulated = simulated_cases(seed)
    real = real_cases(recordings)
    paper, tuned = measure({}, simulated), tune(simulated["2: banked 15°"])
    ours = measure(tuned, simulated)
    real_tuned = tune(real["real: slow translation"]) if real else {}
    real_ours = measure(real_tuned, real)
    equal: list[list[Cell]] = [[case, *_with_gain(group)] for case, group in simulated.items()]
    best = under_acceleration(_common.smallest("Madgwick"))
    worst = under_acceleration(_common.largest("Complementary"))
    thresholds = threshold_gains(tuned, simulated, real_tuned, real)
    table, ns = _common.times(
        "Table II: time of a step", filters(RATE, {}), simulated["1: level"][0], TIMES, "µs", nine_axes=False
    )
    clocked = ns, _common.clocked_on_first(lambda rate: filters(rate, {}), recordings, nine_axes=False)
    both = ours, real_ours or None
    return Study(
        name="parikh2021",
        title=TITLE,
        protocol=PROTOCOL,
        tables=[
            _rmse_table(paper, ours, real_ours),
            _metrics_table(ours | real_ours),
            _parameter_table(tuned, real_tuned),
            Table(
                "RMSE of the Kalman filter, and of α = 1 − K1", ["case", "Kalman", "complementary"], equal, form=".4f"
            ),
            *thresholds[0],
            table,
        ],
        claims=[
            Claim("Madgwick suppresses acceleration best", *_common.verdicts(best, *both)),
            Claim("The complementary filter suppresses it least", *_common.verdicts(worst, *both)),
            Claim("All metrics order the filters alike under acceleration", *_common.verdicts(one_order, *both)),
            Claim("Under vibration Kalman and Mahony beat Madgwick", *_common.verdicts(robust_to_vibration, *both)),
            Claim("With α = 1 − K1 complementary is nearly Kalman", *_common.verdicts(gain_is_enough, simulated, real)),
            Claim(
                "The complementary filter is the fastest", *_common.verdicts(_common.fastest("Complementary"), *clocked)
            ),
            Claim("Kalman is the slowest", *_common.verdicts(_common.slowest("Kalman"), *clocked)),
            *thresholds[1],
        ],
        plots=_plots(tuned, simulated, ours),
    )


def simulated_cases(seed: int) -> Cases:
    """The three, filtered as the paper does."""

    def pushed(seed: int, bank: float) -> ar.Recording:
        return ar.simulate.scenario("back_and_forth", rate=RATE, seed=seed, bank=np.radians(bank))

    seeds = range(seed, seed + SENSORS)
    return {
        "1: level": [low_passed(pushed(one, 0.0)) for one in seeds],
        "2: banked 15°": [low_passed(pushed(one, 15.0)) for one in seeds],
        "3: vibration": [low_passed(rotors(one)) for one in seeds],
    }


def rotors(seed: int) -> ar.Recording:
    """Rest, and then the rotors; the first sample of a vibrating accelerometer would be no start."""
    rest = ar.simulate.scenario("vibration", rate=RATE, seed=seed, duration=REST, acc=0.0, gyr=0.0)
    loud = ar.simulate.scenario("vibration", rate=RATE, seed=seed)
    return ar.Recording(
        t=np.concatenate((rest.t, REST + loud.t)),
        gyr=np.concatenate((rest.require("gyr"), loud.require("gyr"))),
        acc=np.concatenate((rest.require("acc"), loud.require("acc"))),
        ref=np.concatenate((_common.truth(rest), _common.truth(loud))),
        mask=np.arange(len(rest) + len(loud)) >= len(rest),
        rate=RATE,
    )


def real_cases(recordings: Sequence[ar.Recording]) -> Cases:
    """Recordings by what disturbs them."""
    cases = {
        f"real: {kind}": _common.named(recordings, kind.replace(" ", "_"))
        for kind in ("slow translation", "fast translation", "vibration")
    }
    return {name: group for name, group in cases.items() if group} if all(cases.values()) else {}


def low_passed(recording: ar.Recording) -> ar.Recording:
    """As section III.B."""
    gyr, acc = (
        np.asarray(ar.signal.low_pass(recording.require(name), CUTOFF, recording.rate, order=4), dtype=np.float64)
        for name in ("gyr", "acc")
    )
    return dataclasses.replace(recording, gyr=gyr, acc=acc)


def filters(rate: float, params: Params) -> Filters:
    """The four, with other parameters than the paper's where they are given."""
    return {
        name: _common.as_published(cls, "parikh2021", rate, **params.get(name, {})) for name, cls in CLASSES.items()
    }


def tune(recordings: Sequence[ar.Recording]) -> dict[str, dict[str, Any]]:
    """The smallest RMSE on a grid: of the inclination, which roll and pitch are."""
    found = {}
    for name, (where, points) in GRID.items():
        preset = _common.as_published(CLASSES[name], "parikh2021", RATE).params
        fixed = {key: value for key, value in preset.items() if key not in where}
        found[name] = ar.tuning.grid(
            CLASSES[name], where, recordings, points=points, metric="inclination", fixed=fixed
        ).params
    return found


def measure(params: Params, cases: Cases) -> Found:
    """The metrics of all filters in all cases: means over the recordings of a case."""
    found: Found = {}
    for case, group in cases.items():
        found[case] = {}
        for name, f in filters(group[0].rate, params).items():
            pairs = zip(_common.estimates(f, group, nine_axes=False), group, strict=True)
            found[case][name] = _common.mean(_metrics(est, recording) for est, recording in pairs)
    return found


def joint(found: Found, number: int = 0) -> dict[str, dict[str, float]]:
    """One metric of all filters in all cases, RMS over roll and pitch."""
    return {
        case: {name: float(np.sqrt(_common.mean(each[number] ** 2))) for name, each in group.items()}
        for case, group in found.items()
    }


def accelerated(found: Found) -> Found:
    """The cases with external acceleration."""
    return {case: group for case, group in found.items() if "vibration" not in case}


def under_acceleration(judge: _common.Judge[Mapping[str, float]]) -> _common.Judge[Found]:
    """The judge's verdict in every case with external acceleration."""

    def verdict(found: Found) -> Verdict:
        each = {case: judge(values) for case, values in joint(accelerated(found)).items()}
        numbers = "; ".join(f"{case}: {one.numbers}" for case, one in each.items())
        return Verdict(all(one.holds for one in each.values()), numbers)

    return verdict


def one_order(found: Found) -> Verdict:
    """Whether all metrics order the filters alike in each case."""
    orders: dict[str, list[str]] = {}
    for case, group in accelerated(found).items():
        for number, metric in enumerate(METRICS):
            values = joint({case: group}, number)[case]
            if not any(np.isnan(value) for value in values.values()):
                order = " < ".join(sorted(values, key=values.__getitem__))
                orders.setdefault(order, []).append(f"{metric} ({case})")
    return Verdict(len(orders) == 1, "; ".join(f"{order}: {', '.join(by)}" for order, by in orders.items()))


def robust_to_vibration(found: Found) -> Verdict:
    """Kalman's and Mahony's error below Madgwick's."""
    (values,) = (group for case, group in joint(found).items() if "vibration" in case)
    return Verdict(max(values["Kalman"], values["Mahony"]) < values["Madgwick"], _common.listed(values))


def gain_is_enough(cases: Cases) -> Verdict:
    """Whether the complementary filter with the Kalman filter's gain is as accurate as that."""
    numbers = {case: _with_gain(group) for case, group in cases.items()}
    parts = [f"{case}: {kalman:.3g}° and {complementary:.3g}°" for case, (kalman, complementary) in numbers.items()]
    near = all(abs(complementary / kalman - 1.0) < NEAR for kalman, complementary in numbers.values())
    return Verdict(near, "Kalman and complementary, " + "; ".join(parts))


def _with_gain(group: Sequence[ar.Recording]) -> tuple[float, float]:
    """RMSE of the Kalman filter, and of the complementary filter with its gain."""
    rate = group[0].rate
    kalman = filters(rate, {})["Kalman"]
    first = group[0]
    settled = kalman.run(first.gyr, first.acc, t=first.t, outputs=("covariance",)).covariance
    assert settled is not None
    # P after a correction is K1 R. The sensor is near level, where roll is the turn about its x axis.
    gain = float(settled[-1, 0, 0]) / float(kalman.params["angle_variance"])
    made: Any = ar.FILTERS["Complementary"]
    twins = (kalman, made.from_kalman_gain(gain, rate=rate, integration="first-order"))
    found = []
    for f in twins:
        pairs = zip(_common.estimates(f, group, nine_axes=False), group, strict=True)
        found.append(_common.mean(_common.angle_rmse(est, recording)[:2] for est, recording in pairs))
    return float(np.sqrt((found[0] ** 2).mean())), float(np.sqrt((found[1] ** 2).mean()))


def _metrics(est: ar.Estimate, recording: ar.Recording) -> FloatArray:
    """(5, 2): the metrics of roll and pitch."""
    error = _common.angles(est, recording).T[:2]
    truth = ar.metrics.euler(_common.truth(recording), degrees=True).T[:2]
    mask = recording.mask
    return np.array([
        ar.metrics.rmse(error, mask),
        ar.metrics.mape(error, truth, mask, least=LEAST),
        ar.metrics.mad(error, mask),
        ar.metrics.gae(error, mask),
        ar.metrics.imre(error, mask),
    ])  # fmt: skip


def _rmse_table(paper: Found, ours: Found, real: Found) -> Table:
    rows: list[list[Cell]] = []
    for case in RMSE:
        for name in CLASSES:
            with_paper, with_ours = paper[case][name][0], ours[case][name][0]
            numbers = (*RMSE[case][name], with_paper[1], with_paper[0], with_ours[1], with_ours[0])
            rows.append([case, name, *map(float, numbers)])
    for case, group in real.items():
        rows += [[case, name, None, None, None, None, *map(float, each[0, ::-1])] for name, each in group.items()]
    columns = ["case", "filter", "pitch (paper)", "roll (paper)"]
    columns += ["pitch, paper's parameters", "roll, paper's parameters", "pitch, tuned", "roll, tuned"]
    return Table("Table III: RMSE of pitch and roll", columns, rows)


def _metrics_table(found: Found) -> Table:
    rows: list[list[Cell]] = []
    for case, group in found.items():
        for name, each in group.items():
            rows += [[case, name, angle, *map(float, each[:, i])] for i, angle in enumerate(("roll", "pitch"))]
    columns = ["case", "filter", "angle", *(name + (" [%]" if name == "MAPE" else " [°]") for name in METRICS)]
    return Table("Five metrics, tuned (the spider charts' numbers)", columns, rows, form=".3f")


def _parameter_table(simulated: Params, real: Params) -> Table:
    rows: list[list[Cell]] = []
    for name, (where, _) in GRID.items():
        preset = CLASSES[name].PRESETS["parikh2021"]
        for key in where:
            rows.append([name, key, *(float(each[key]) if each else None for each in (preset, simulated[name]))])
            rows[-1].append(float(real[name][key]) if real else None)
    return Table("Table I: parameters", ["filter", "parameter", "paper", "case 2", "real"], rows, form=".4g")


def threshold_gains(
    tuned: Params, simulated: Cases, real_tuned: Params, real: Cases
) -> tuple[list[Table], list[Claim]]:
    """The paper's future work, where the filters have a threshold: what it brings, and whether as the paper expects."""
    if not adaptive():
        return [], []
    worlds = gains(tuned, simulated), gains(real_tuned, real) if real else None
    rows: list[list[Cell]] = []
    for world in worlds:
        for case, values in (world or {}).items():
            rows += [[case, name, *numbers] for name, numbers in values.items()]

    def better(found: Gains) -> Verdict:
        parts = {
            f"{name} ({case})": 100.0 * (with_threshold / without - 1.0)
            for case, group in found.items()
            if "vibration" not in case
            for name, (without, with_threshold, _) in group.items()
        }
        return Verdict(max(parts.values()) < 0.0, _common.listed(parts, " %"))

    columns = ["case", "filter", "without", "with", "threshold [m/s²]"]
    claim = "Threshold-based gains improve the filters under acceleration"
    return (
        [Table("Future work of the paper: threshold-based gains, RMSE", columns, rows)],
        [Claim(claim, *_common.verdicts(better, *worlds))],
    )


def adaptive() -> list[str]:
    """The filters that have a threshold."""
    return [name for name, cls in CLASSES.items() if ADAPTIVE in cls.PARAMS]


def gains(params: Params, cases: Cases) -> Gains:
    """RMSE without and with a threshold, and the threshold, found by a grid on the first case with acceleration."""
    chosen: dict[str, dict[str, Any]] = {}
    first = next(group for case, group in cases.items() if case != "1: level")
    for name in adaptive():
        found = ar.tuning.grid(
            CLASSES[name], {ADAPTIVE: (0.05, 20.0)}, first, points=61, metric="inclination", fixed=params.get(name)
        )
        chosen[name] = found.params
    without, with_threshold = joint(measure(params, cases)), joint(measure(chosen, cases))
    return {
        case: {
            name: (without[case][name], with_threshold[case][name], float(chosen[name][ADAPTIVE])) for name in chosen
        }
        for case in cases
    }


def _plots(params: Params, cases: Cases, found: Found) -> list[Plot]:
    plots = []
    for case, (recording, *_) in cases.items():
        t = recording.t - recording.t[0]
        curves = {
            name: np.degrees(_common.estimate(f, recording).euler())
            for name, f in filters(recording.rate, params).items()
        }
        curves["truth"] = ar.metrics.euler(_common.truth(recording), degrees=True)
        plots += [
            lines(
                f"{angle}, case {case}",
                t,
                {name: each[:, i] for name, each in curves.items()},
                "time [s]",
                f"{angle} [°]",
            )
            for i, angle in enumerate(("Roll", "Pitch"))
        ]
        values = [joint({case: found[case]}, number)[case] for number in range(len(METRICS))]
        series = {name: [each[name] for each in values] for name in CLASSES}
        plots.append(radar(f"Case {case}: errors by the largest", METRICS, series))
    return plots
