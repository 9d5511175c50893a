"""Every filter agrees with its oracle, a plain numpy twin written from the paper (see `oracle`)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import oracle
from cases import CASES, COMMON, Case, each_case
from signals import RATE, Signals, angle_between, disturbed, gappy, motion, multiply, quats, turns_by

SAMPLES = 10_000


def compare(case: Case, signals: Signals, *, nine: bool = True, use_t: bool = False, **settings: Any) -> None:
    """Run filter and oracle; attitudes, biases and status bits must be the same."""
    q0 = settings.pop("q0", None)
    time = {"t": signals.t} if use_t else {}
    sensors = signals.sensors(nine=nine)
    est = case.make(rate=RATE, **settings).run(*sensors, q0=q0, **time, outputs=tuple(case.cls.OUTPUTS))
    twin = oracle.run(case.name, case.params, *sensors, rate=RATE, q0=q0, **time, **settings)
    assert np.array_equal(est.status, twin.status)
    assert angle_between(est.quat, twin.quat).max() < case.agreement
    assert np.abs(est.quat - twin.quat).max() < case.agreement, "the sign is part of the output"
    for name, values in twin.extra.items():
        known = np.isfinite(values)
        assert np.array_equal(np.isfinite(est.extra[name]), known), name
        # Angles and their variances in units of 1; a normalised innovation is as large as the model is wrong.
        assert np.all(np.abs(est.extra[name] - values)[known] < case.agreement * (1.0 + np.abs(values[known]))), name
    assert (est.gyr_bias is None) == (twin.gyr_bias is None)
    if est.gyr_bias is not None:
        assert np.abs(est.gyr_bias - twin.gyr_bias).max() < case.agreement


@each_case
def test_nine_axes_at_a_constant_rate(case: Case) -> None:
    compare(case, motion(SAMPLES, 1, level=case.euler_rates))


@each_case
def test_six_axes_with_jitter_gaps_and_linear_hold_in_ned(case: Case) -> None:
    signals = gappy(motion(SAMPLES, 2, level=case.euler_rates, jitter=True), 3)
    compare(case, signals, nine=False, use_t=True, frame="NED", gyr_hold="linear", declination=0.2)


@each_case
def test_gaps_and_a_late_magnetometer_from_q0_with_declination_in_nwu(case: Case) -> None:
    signals = gappy(motion(SAMPLES, 4, level=case.euler_rates, jitter=True), 5).without(mag=slice(0, 700))
    q0 = multiply(signals.before, quats(turns_by(0.3, 1, 6))[0])
    compare(case, signals, use_t=True, frame="NWU", declination=-0.3, q0=q0)


@each_case
def test_a_start_without_accelerometer_and_magnetometer(case: Case) -> None:
    signals = gappy(motion(2000, 7, level=case.euler_rates), 8)
    signals = signals.without(acc=slice(0, 100), mag=slice(0, 150), gyr=slice(0, 3))
    compare(case, signals, declination=0.1, frame="NED", gyr_hold="linear")


@each_case
def test_rest_acceleration_and_a_disturbed_field(case: Case) -> None:
    compare(case, disturbed())


@each_case
def test_a_start_in_a_field_that_is_soon_another_one(case: Case) -> None:
    compare(case, disturbed(slice(800)))


def hostile(samples: int, seed: int) -> Signals:
    """Measurements of which a fifth of the rows hold something that is hardly a measurement."""
    rng = np.random.default_rng(seed)
    signals = motion(samples, seed, jitter=True)
    values = [np.nan, 0.0, 1e200, -1e200, 1e-170, 1e-160, 1e-154, 1e154, 5e-324, 1e100, 1e7, -3e8]
    for array in (signals.gyr, signals.acc, signals.mag):
        bad = rng.random(samples) < 0.2
        rows = rng.choice(values, (int(bad.sum()), 3))
        array[bad] = np.where(rng.random((len(rows), 3)) < 0.5, rows, array[bad])
        array[rng.random(samples) < 0.02] = 0.0
    return signals


@pytest.mark.parametrize("hold", ["zero-order", "linear"])
@pytest.mark.parametrize("seed", range(5))
def test_status_bits_of_hostile_values(seed: int, hold: str) -> None:
    # Status only: a turn by up to 1e6 rad in a step leaves no digits of the attitude to compare, nor of anything that a
    # filter judges by it.
    signals = hostile(2000, seed)
    settings = {"rate": RATE, "gyr_hold": hold}
    for case in CASES:
        est = case.make(**settings).run(*signals.sensors(), t=signals.t)
        twin = oracle.run(case.name, case.params, *signals.sensors(), t=signals.t, **settings)
        assert np.array_equal(est.status & COMMON, twin.status & COMMON), case.label
        assert np.isfinite(est.quat).all(), case.label
