"""Steps of time: held rates, repeated and jittered stamps, gaps, no samples and one."""

from __future__ import annotations

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import Status
from cases import COMMON, Case, assert_same_attitudes, each_case, each_case_with
from signals import RATE, about_z, angle_between, motion

EPS = float(np.finfo(np.float64).eps)


@each_case_with(lambda case: not case.own_rate)
def test_a_missing_row_of_the_gyroscope_holds_the_last_rate(case: Case) -> None:
    # A filter with a covariance knows that the turn of such a row is not known, and believes the other sensors more:
    # the gyroscope alone shows the rate that it holds.
    signals = motion(80, 12)
    others = () if case.kalman else (signals.acc, signals.mag)
    rows = [0, 1, 20, 40, 41, 42, 79]
    held = signals.gyr.copy()
    for k in rows:
        held[k] = held[k - 1] if k else 0.0
    f = case.make(rate=RATE)
    a, b = f.run(signals.without(gyr=rows).gyr, *others), f.run(held, *others)
    assert_same_attitudes(a, b)
    assert np.array_equal(np.flatnonzero(a.status & Status.GYR_HELD), rows)


@each_case_with(lambda case: case.own_rate)
def test_a_missing_row_of_the_gyroscope_is_no_measurement_of_a_rate_of_the_filters_own(case: Case) -> None:
    signals = motion(80, 12)
    rows = [0, 1, 20, 40, 41, 42, 79]
    est = case.make(rate=RATE).run(signals.without(gyr=rows).gyr, outputs=("innovation",))
    assert np.array_equal(np.flatnonzero(est.status & Status.GYR_HELD), rows)
    measured = np.isfinite(est.extra["innovation"][:, 0])
    assert np.array_equal(np.flatnonzero(~measured), rows)


@pytest.mark.parametrize("scale", [1e9, 1e150])
@each_case
def test_a_rate_too_large_to_turn_by_holds_the_last_rate(case: Case, scale: float) -> None:
    # Half an angle of 1e6 rad is the range of the sine: 2e8 rad/s over a step of 10 ms.
    signals = motion(40, 13)
    large = motion(40, 13)
    large.gyr[[10, 20, 21]] *= scale
    a, b = case.run(large), case.run(signals.without(gyr=[10, 20, 21]))
    assert_same_attitudes(a, b)
    assert np.array_equal(a.status, b.status)


@each_case
def test_a_large_but_possible_rate_is_not_held(case: Case) -> None:
    signals = motion(20, 14)
    signals.gyr[10] = [1.0e8, -1.0e8, 1.0e8]
    est = case.run(signals)
    assert not (est.status & COMMON).any()
    assert np.isfinite(est.quat).all()


@each_case_with(lambda case: not case.own_rate)
def test_time_advances_over_missing_rows(case: Case) -> None:
    # All sensors missing for a second of constant rate: the attitude is turned by that second all the same.
    rate = np.array([0.0, 0.0, 0.8])
    f = case.make(rate=RATE)
    gyr = np.tile(rate, (201, 1))
    gyr[50:150] = np.nan
    quat = f.run(gyr, q0=[1.0, 0.0, 0.0, 0.0]).quat
    # A first-order step of 8 mrad turns by (8e-3)³/12 less, one of a matrix by (8e-3)³/3, 201 times.
    assert angle_between(quat[-1], about_z(201 * 0.8 / RATE)) < 4e-5


@each_case
def test_a_repeated_stamp_makes_no_step_of_the_gyroscope(case: Case) -> None:
    signals = motion(60, 15)
    t = signals.t.copy()
    t[20] = t[19]
    t[40:43] = t[39]
    fast = signals.gyr.copy()
    fast[[20, 40, 41, 42]] = 100.0
    a = case.make().run(signals.gyr, t=t)
    b = case.make().run(fast, t=t)
    assert_same_attitudes(a, b)
    # Normalisation may round the last bit again.
    assert np.abs(a.quat[20] - a.quat[19]).max() <= EPS
    assert np.abs(a.quat[42] - a.quat[39]).max() <= 3.0 * EPS


@each_case_with(lambda case: not case.own_rate)
def test_steps_of_any_length_turn_by_the_same_angle(case: Case) -> None:
    rng = np.random.default_rng(16)
    t = np.sort(np.concatenate(([0.0], rng.uniform(0.0, 2.0, 400), [2.0])))
    quat = case.make().run(np.tile([0.0, 0.0, 0.5], (len(t), 1)), t=t).quat
    # First-order steps turn by 2 atan(ω dt/2), which falls short by (ω dt)³/12, those of a matrix by atan(ω dt).
    short = np.sum((0.5 * np.diff(t)) ** 3) / 3.0 if case.first_order else 0.0
    assert angle_between(quat, about_z(0.5 * t)).max() < 1e-13 + short


def test_linear_hold_turns_by_the_mean_of_both_ends() -> None:
    t = np.array([0.0, 0.1, 0.3, 0.3, 0.35])
    rate = np.array([1.0, 3.0, -1.0, 5.0, 2.0])
    gyr = rate[:, None] * [0.0, 0.0, 1.0]
    angle = np.cumsum([0.0, 0.2, 0.2, 0.0, 0.175])
    est = ar.GyroIntegration(gyr_hold="linear").run(gyr, t=t)
    assert angle_between(est.quat, about_z(angle)).max() < 1e-15
    held = ar.GyroIntegration().run(gyr, t=t)
    assert angle_between(held.quat, about_z(np.cumsum([0.0, 0.3, -0.2, 0.0, 0.1]))).max() < 1e-15


@each_case
def test_a_gap_of_years_is_no_danger(case: Case) -> None:
    t = np.array([0.0, 0.01, 1e9, 1e9 + 0.01, 1e300, 1e300])
    signals = motion(6, 17)
    quat = case.make().run(*signals.sensors(), t=t).quat
    assert np.isfinite(quat).all()
    assert np.abs(np.linalg.norm(quat, axis=1) - 1.0).max() < 1e-15


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@each_case
def test_no_samples_give_empty_results_and_an_untouched_state(case: Case, dtype: type) -> None:
    empty = np.empty((0, 3), dtype)
    f = case.make(dtype=dtype)
    for est in (f.run(empty), f.run(empty, empty, empty, t=[]), f.run(empty, q0=[0.0, 1.0, 0.0, 0.0])):
        assert est.quat.shape == (0, 4)
        assert est.status.shape == (0,)
        assert est.gyr_bias is None or est.gyr_bias.shape == (0, 3)
        assert est.euler().shape == (0, 3)
        assert est.matrix().shape == (0, 3, 3)
        assert len(est) == 0
    assert f.run(empty).state == f.state()
    assert f.run(np.empty((4, 0, 3), dtype)).quat.shape == (4, 0, 4)
    assert f.run(np.empty((0, 5, 3), dtype), t=np.arange(5.0)).quat.shape == (0, 5, 4)


@each_case
def test_one_sample_is_the_alignment(case: Case) -> None:
    signals = motion(1, 18)
    for keywords in ({}, {"t": [3.0]}):
        f = case.make(rate=None if keywords else RATE)
        est = f.run(*signals.sensors(), **keywords)
        assert est.quat.shape == (1, 4)
        expected = ar.Ecompass(rate=RATE).run(*signals.sensors()).quat
        assert angle_between(est.quat, expected).max() < 1e-14


def test_a_run_that_begins_with_no_samples_goes_on_like_one_that_does_not() -> None:
    f = ar.Tilt()
    state = f.run(np.empty((0, 3)), t=[]).state
    acc = [[0.0, 1.0, 9.8]]
    assert np.array_equal(
        f.run(np.zeros((1, 3)), acc, t=[5.0], state=state).quat, f.run(np.zeros((1, 3)), acc, t=[5.0]).quat
    )
