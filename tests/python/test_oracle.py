"""Every filter agrees with its oracle, a plain numpy twin written from the paper (see `oracle`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
import pytest

import oracle
import oracle_results
from cases import CASES, COMMON, Case, each_case
from oracle_results import twins
from oracle_sources import sources_hash
from signals import RATE, Signals, angle_between, disturbed, gappy, hostile, motion, multiply, quats, turns_by

SAMPLES = 10_000


@dataclass(frozen=True)
class Inputs:
    """A recording and how it is run."""

    signals: Signals
    nine: bool = True
    use_t: bool = False
    settings: dict[str, Any] = field(default_factory=dict)

    def run(self, case: Case) -> Any:
        """The filter's estimate."""
        return case.make(rate=RATE, **self._filter).run(*self._sensors, **self._run, outputs=tuple(case.cls.OUTPUTS))

    def run_oracle(self, case: Case) -> oracle.OracleResult:
        """The oracle's."""
        settings, params = self._filter, dict(case.params)
        if "gyr_range" in case.cls.PARAMS and "gyr_range" in settings:  # a filter that has its own use for it
            params["gyr_range"] = settings.pop("gyr_range")
        return oracle.run(case.name, params, *self._sensors, rate=RATE, **settings, **self._run)

    @property
    def _sensors(self) -> tuple[Any, ...]:
        return self.signals.sensors(nine=self.nine)

    @property
    def _filter(self) -> dict[str, Any]:
        return {name: value for name, value in self.settings.items() if name != "q0"}

    @property
    def _run(self) -> dict[str, Any]:
        return {"q0": self.settings.get("q0"), **({"t": self.signals.t} if self.use_t else {})}


#: Makes the inputs of a test, level for filters that step Euler rates.
Scenario = Callable[[bool], Inputs]


def sources(case: Case, *inputs: object, modules: tuple[str, ...] = ()) -> str:
    """What a result of the oracle depends on."""
    module = oracle.ORACLES[case.name].__module__.replace(".", "/") + ".py"
    parts = (case.name, sorted(case.params.items()), case.euler_rates, SAMPLES, Inputs, *inputs)
    return sources_hash(*parts, modules=(module, "oracle/driver.py", "signals.py", *modules))


def compare(case: Case, scenario: Scenario, *modules: str) -> None:
    """Run filter and oracle; attitudes, biases and status bits must be the same. The scenario depends on modules."""
    inputs = scenario(case.euler_rates)
    est = inputs.run(case)
    key = sources(case, scenario, modules=modules)
    for twin in twins(case.label, scenario.__name__, key, lambda: inputs.run_oracle(case)):
        twin.assert_same_status(est.status)
        quat = est.quat[twin.rows]
        assert angle_between(quat, twin.values["quat"]).max() < case.agreement
        assert np.abs(quat - twin.values["quat"]).max() < case.agreement, "the sign is part of the output"
        for name, values in twin.extra.items():
            mine, known = est.extra[name][twin.rows], np.isfinite(values)
            assert np.array_equal(np.isfinite(mine), known), name
            # Angles and their variances in units of 1; a normalised innovation is as large as the model is wrong.
            assert np.all(np.abs(mine - values)[known] < case.agreement * (1.0 + np.abs(values[known]))), name
        assert (est.gyr_bias is None) == ("gyr_bias" not in twin.values)
        if est.gyr_bias is not None:
            assert np.abs(est.gyr_bias[twin.rows] - twin.values["gyr_bias"]).max() < case.agreement


@cache
def nine_axes(level: bool) -> Inputs:
    return Inputs(motion(SAMPLES, 1, level=level).rounded())


@each_case
def test_nine_axes_at_a_constant_rate(case: Case) -> None:
    compare(case, nine_axes)


@cache
def six_axes(level: bool) -> Inputs:
    signals = gappy(motion(SAMPLES, 2, level=level, jitter=True), 3).rounded()
    settings = {"frame": "NED", "gyr_hold": "linear", "declination": 0.2}
    return Inputs(signals, nine=False, use_t=True, settings=settings)


@each_case
def test_six_axes_with_jitter_gaps_and_linear_hold_in_ned(case: Case) -> None:
    compare(case, six_axes)


@cache
def late_magnetometer(level: bool) -> Inputs:
    signals = gappy(motion(SAMPLES, 4, level=level, jitter=True), 26).without(mag=slice(0, 700)).rounded()
    q0 = multiply(signals.before, quats(turns_by(0.3, 1, 6))[0])
    return Inputs(signals, use_t=True, settings={"frame": "NWU", "declination": -0.3, "q0": q0})


@each_case
def test_gaps_and_a_late_magnetometer_from_q0_with_declination_in_nwu(case: Case) -> None:
    compare(case, late_magnetometer)


@cache
def late_start(level: bool) -> Inputs:
    signals = gappy(motion(2000, 7, level=level), 8)
    signals = signals.without(acc=slice(0, 100), mag=slice(0, 150), gyr=slice(0, 3)).rounded()
    return Inputs(signals, settings={"declination": 0.1, "frame": "NED", "gyr_hold": "linear"})


@each_case
def test_a_start_without_accelerometer_and_magnetometer(case: Case) -> None:
    compare(case, late_start)


@cache
def rest_and_disturbances(_: bool) -> Inputs:
    return Inputs(disturbed().rounded())


@each_case
def test_rest_acceleration_and_a_disturbed_field(case: Case) -> None:
    compare(case, rest_and_disturbances)


@cache
def disturbed_start(_: bool) -> Inputs:
    return Inputs(disturbed(slice(800)).rounded())


@each_case
def test_a_start_in_a_field_that_is_soon_another_one(case: Case) -> None:
    compare(case, disturbed_start)


@pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")
@pytest.mark.parametrize("hold", ["zero-order", "linear"])
@pytest.mark.parametrize("seed", range(5))
def test_status_bits_of_hostile_values(seed: int, hold: str) -> None:
    # Status only: a turn by up to 1e6 rad in a step leaves no digits of the attitude to compare, nor of anything that a
    # filter judges by it.
    inputs = Inputs(hostile(2000, seed), use_t=True, settings={"gyr_hold": hold})
    for case in CASES:
        est = inputs.run(case)
        key = sources(case, 2000, seed, hold)
        for twin in twins(
            case.label,
            f"hostile {seed} {hold}",
            key,
            lambda case=case: inputs.run_oracle(case),
            mask=COMMON,
            status_only=True,
        ):
            twin.assert_same_status(est.status)
        assert np.isfinite(est.quat).all(), case.label


def test_nothing_is_kept_of_what_is_no_case_any_more() -> None:
    labels = {case.label for case in CASES} | {"selfcal-smoother"}
    assert {file.stem for file in oracle_results.FOLDER.glob("*.npz")} <= labels
    assert {title.partition(": ")[0] for title in oracle_results.read_sources()} <= labels
