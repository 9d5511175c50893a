"""`SelfCalSmoother` is the least-squares solution of all measurements at once (`oracle.selfcal_smoother`)."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from oracle import OracleResult
from oracle.selfcal_smoother import MOST_PASSES, PASSES, SelfCalSmoother, SmootherParameters
from oracle_results import twins
from oracle_sources import sources_hash
from selfcal_cases import CASES, RATE, Faults, recorded
from signals import angle_between

#: Both solve the same equations in float64, one by covariances that are carried on, the other by a normal matrix whose
#: eigenvalues lie between 1 and some 1e8: measured at most 3e-12 rad, where a clipped gyroscope leaves half a radian
#: unknown, and 3e-13 elsewhere.
AGREEMENT = 1e-10


@pytest.mark.parametrize("name", CASES)
def test_it_is_the_least_squares_solution_of_all_measurements_at_once(name: str) -> None:
    case = CASES[name]
    signals = case.signals()
    sensors = signals.sensors(nine=case.nine)
    time: dict[str, Any] = {"t": signals.t} if case.stamped else {}
    rate = None if case.stamped else RATE
    f = ar.SelfCalSmoother(rate=rate, gyr_hold=case.hold, **case.params)
    est = f.run(*sensors, **time, outputs=tuple(f.OUTPUTS))
    assert case.shows(est), "the recording is not what it is meant to be"
    assert est.gyr_bias is not None

    def compute() -> OracleResult:
        smoother = SelfCalSmoother(**case.params)
        result = smoother.run(*sensors, **time, rate=rate, gyr_hold=case.hold)
        assert PASSES <= smoother.passes < MOST_PASSES, "it has converged"
        return result

    sources = sources_hash(name, modules=("oracle/selfcal_smoother.py", "selfcal_cases.py"))
    for twin in twins("selfcal-smoother", name, sources, compute):
        twin.assert_same_status(est.status)
        quat, gyr_bias = est.quat[twin.rows], est.gyr_bias[twin.rows]
        assert angle_between(quat, twin.values["quat"]).max() < AGREEMENT
        assert np.abs(quat - twin.values["quat"]).max() < AGREEMENT, "the sign is part of the output"
        assert np.abs(gyr_bias - twin.values["gyr_bias"]).max() < AGREEMENT
        assert set(twin.extra) == set(f.OUTPUTS)
        for output, values in twin.extra.items():
            # Covariances and states are small numbers: in units of the largest of them. A bias of nearly zero is the
            # difference of larger numbers.
            mine = est.extra[output]
            bound = AGREEMENT * max(0.01, np.abs(mine).max())
            assert np.abs(mine[twin.rows] - values).max() < bound, output


def test_the_twin_has_its_parameters() -> None:
    params, twin = ar.SelfCalSmoother().params, asdict(SmootherParameters())
    # Those of the causal filter alone, at its defaults.
    assert set(twin) - set(params) == {"largest_hard_iron", "mag_new_time"}
    for name, value in params.items():
        assert value == pytest.approx(twin[name], rel=1e-15), name


@pytest.mark.parametrize("name", ar.SelfCalSmoother().params)
def test_every_parameter_counts(name: str) -> None:
    base = {"initial_hard_iron": 0.01}
    value = {**ar.SelfCalSmoother().params, **base}[name]
    other = 0.1 * value or {"gyr_range": 2.2, "latency": 0.01, "hard_iron_noise": 1e-3}[name]
    sensors = recorded(10, 8.0, Faults(rest=(4.0, 8.0))).sensors()
    plain, changed = (
        ar.SelfCalSmoother(rate=RATE, **{**base, **params}).run(*sensors) for params in ({}, {name: other})
    )
    assert not np.array_equal(plain.quat, changed.quat)
