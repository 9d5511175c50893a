"""Missing, repeated, late and impossible samples: DESIGN's rules for data that is not there."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from ahrs_rs import Status
from cases import CASES, COMMON, Case, assert_same_attitudes, each_case, each_case_with
from signals import (
    RATE,
    about_z,
    angle_between,
    conjugate,
    inclination_between,
    motion,
    multiply,
    quats,
    rotation,
)

NAN3 = [np.nan] * 3


# What counts as missing.


@pytest.mark.parametrize("sensor", ["gyr", "acc", "mag"])
@pytest.mark.parametrize(
    "row",
    [[np.nan, 0.1, 0.2], [0.1, np.nan, 0.2], [0.1, 0.2, np.nan], [1e200, 0.0, 0.0], [-1e154, 1e154, 1e154]],
    ids=str,
)
@each_case
def test_one_nan_and_a_norm_beyond_the_dtype_are_a_missing_row(case: Case, sensor: str, row: list[float]) -> None:
    signals = motion(60, 1)
    getattr(signals, sensor)[[20, 33, 34]] = row
    missing = signals.without(**{sensor: [20, 33, 34]})
    a, b = case.run(signals), case.run(missing)
    assert_same_attitudes(a, b)
    assert np.array_equal(a.status, b.status)


@pytest.mark.parametrize("sensor", ["acc", "mag"])
@pytest.mark.parametrize("row", [[0.0, 0.0, 0.0], [1e-170, 0.0, 0.0], [1e-160, -1e-155, 0.0]], ids=str)
@each_case
def test_a_squared_norm_of_zero_or_subnormal_is_a_missing_row(case: Case, sensor: str, row: list[float]) -> None:
    signals = motion(60, 2)
    getattr(signals, sensor)[[0, 20, 33]] = row
    missing = signals.without(**{sensor: [0, 20, 33]})
    a, b = case.run(signals), case.run(missing)
    assert_same_attitudes(a, b)
    assert np.array_equal(a.status, b.status)


@pytest.mark.parametrize(("value", "there"), [(1e-22, False), (1e-18, True), (1e18, True), (1e25, False)])
def test_in_float32_the_range_is_that_of_float32(value: float, there: bool) -> None:
    gyr = np.zeros((1, 3), np.float32)
    acc = np.array([[value, 0.0, 0.0]], np.float32)
    for dtype, expected in ((np.float32, there), (np.float64, True)):
        est = ar.Tilt(rate=RATE).run(gyr.astype(dtype), acc.astype(dtype))
        assert bool(est.status[0] & Status.ACC_MISSING) != expected


@pytest.mark.parametrize("scale", [1e-150, 1e-100, 1e-3, 1e100, 1e150])
@each_case
def test_the_smallest_and_largest_vectors_are_measurements_like_others(case: Case, scale: float) -> None:
    signals = motion(200, 3, level=case.euler_rates)
    plain = case.run(signals)
    acc = signals.acc if case.acc_length else signals.acc * scale
    scaled = case.make(rate=RATE).run(signals.gyr, acc, signals.mag * scale)
    assert np.array_equal(scaled.status, plain.status)
    # Scaling rounds to 1e-16.
    assert angle_between(scaled.quat, plain.quat).max() < case.agreement


# Status bits.


@each_case
def test_status_says_what_is_missing_and_nothing_else(case: Case) -> None:
    signals = motion(300, 4)
    rows = np.random.default_rng(5).random((3, 300)) < 0.5
    signals = signals.without(gyr=rows[0], acc=rows[1], mag=rows[2])
    expected = (
        Status.GYR_HELD * rows[0]
        + Status.ACC_MISSING * rows[1]
        + Status.MAG_MISSING * rows[2]
        + Status.NOT_ALIGNED * (np.cumsum(~rows[1]) == 0)
    )
    assert np.array_equal(case.run(signals).status & COMMON, expected)


@each_case
def test_a_sensor_that_is_not_given_is_not_missing(case: Case) -> None:
    signals = motion(10, 5)
    f = case.make(rate=RATE)
    assert not (f.run(*signals.sensors()).status & COMMON).any()
    assert not (f.run(*signals.sensors(nine=False)).status & COMMON).any()
    assert np.array_equal(f.run(signals.gyr).status & COMMON, np.full(10, Status.NOT_ALIGNED))


@each_case
def test_a_sensor_that_was_given_once_is_missing_from_then_on(case: Case) -> None:
    f = case.make(rate=RATE)
    gyr, acc, mag = [0.0, 0.0, 0.1], [0.0, 0.0, 9.8], [0.0, 20.0, -40.0]
    f.update(gyr)
    assert f.status == Status.NOT_ALIGNED
    f.update(gyr, acc)
    assert f.status == 0
    f.update(gyr)
    assert f.status == Status.ACC_MISSING
    f.update(gyr, acc, mag)
    assert f.status == 0
    f.update(gyr, mag=NAN3)
    assert f.status == Status.ACC_MISSING | Status.MAG_MISSING
    f.reset()
    f.update(gyr, acc)
    assert f.status == 0


# The filter goes on with what is left.


@each_case
def test_missing_rows_of_the_magnetometer_are_six_axes_for_that_time(case: Case) -> None:
    signals = motion(90, 6)
    f = case.make(rate=RATE)
    whole = f.run(*signals.without(mag=slice(30, 60)).sensors())
    first = f.run(*(array[:30] for array in signals.sensors()))
    six = f.run(signals.gyr[30:60], signals.acc[30:60], state=first.state)
    last = f.run(*(array[60:] for array in signals.sensors()), state=six.state)
    assert np.array_equal(whole.quat, np.concatenate((first.quat, six.quat, last.quat)))
    assert np.array_equal(whole.status[30:60], six.status)


@each_case_with(lambda case: not case.own_rate)
def test_with_no_direction_left_the_gyroscope_alone_turns(case: Case) -> None:
    # What SelfCalKF has seen it takes over at the end of a block of 0.1 s: with sample 30.
    signals = motion(61, 7, level=True)
    est = case.run(signals.without(acc=slice(31, 61), mag=slice(31, 61)))
    rates = signals.gyr[31:]
    if est.gyr_bias is not None:
        assert np.array_equal(est.gyr_bias[31:], np.repeat(est.gyr_bias[30:31], 30, axis=0))
        rates = rates - est.gyr_bias[31:]
    turns = multiply(conjugate(est.quat[30:-1]), est.quat[31:])
    angle = np.linalg.norm(rates, axis=1) / RATE
    exact = quats(Rotation.from_rotvec(rates / RATE))
    # The largest error of a first-order step: Euler rates change by (ω dt)² / cos(pitch), within 40° here.
    wrong = 2.0 * angle**2 if case.first_order else 0.0
    assert np.all(angle_between(turns, exact) < 1e-14 + wrong)


@each_case_with(lambda case: case.cls.MAGNETOMETER)
def test_a_slower_magnetometer_still_feeds_the_heading_back(case: Case) -> None:
    signals = motion(4000, 8, noise=0.1)
    q0 = multiply(about_z(0.5), signals.before)
    rows = np.arange(4000) % 5 != 0
    f = case.make(rate=RATE)
    slow = f.run(*signals.without(mag=rows).sensors(), q0=q0)
    none = f.run(*signals.sensors(nine=False), q0=q0)
    assert np.array_equal(slow.status & COMMON, Status.MAG_MISSING * rows)
    # The slowest of the rows decays with kp (1 - sin dip)/5 = 0.013/s: to 0.3 rad in these 40 s.
    assert angle_between(slow.quat[-1], signals.truth[-1]) < 0.35
    assert angle_between(none.quat[-1], signals.truth[-1]) > 0.45


# Alignment.


@each_case
def test_a_leading_time_without_directions_turns_from_the_identity_and_then_aligns_at_once(case: Case) -> None:
    signals = motion(200, 9)
    est = case.run(signals.without(acc=slice(0, 100), mag=slice(0, 150)))
    # A filter that starts by itself is at the identity one step before the first sample.
    q0 = [1.0, 0.0, 0.0, 0.0] if case.starts_itself else None
    gyro = ar.GyroIntegration(rate=RATE).run(signals.gyr[:100], q0=q0)
    if not case.starts_itself:
        assert np.array_equal(est.quat[0], [1.0, 0.0, 0.0, 0.0])
    assert np.all(est.status[:100] & COMMON == Status.NOT_ALIGNED | Status.ACC_MISSING | Status.MAG_MISSING)
    if not (case.first_order or case.own_rate):
        assert angle_between(est.quat[:100], gyro.quat).max() < 1e-12
    assert not np.any(est.status[100:] & Status.NOT_ALIGNED)
    # The inclination by the accelerometer, at once; the heading, turned as the shortest way turns it, stays.
    up = signals.acc[100] / np.linalg.norm(signals.acc[100])
    assert np.abs(rotation(est.quat[100]).apply(up) - [0.0, 0.0, 1.0]).max() < 1e-14
    # The heading by the magnetometer, at once.
    field = rotation(est.quat[150]).apply(signals.mag[150])
    assert abs(field[0]) < 1e-12 * np.linalg.norm(field)
    assert field[1] > 0.0


@each_case_with(lambda case: not case.own_rate)
def test_the_heading_is_kept_where_the_inclination_is_set(case: Case) -> None:
    # Without a rate at sample 100, all that turns there is the shortest way to the vertical: about a horizontal axis.
    signals = motion(200, 10)
    signals.gyr[100] = 0.0
    est = case.run(signals.without(acc=slice(0, 100)), nine=False)
    turn = multiply(est.quat[100], conjugate(est.quat[99]))
    assert np.linalg.norm(turn[1:3]) > 0.1
    assert abs(turn[3]) < 1e-14


@each_case
def test_the_first_row_missing_aligns_at_the_second(case: Case) -> None:
    signals = motion(50, 11)
    est = case.run(signals.without(acc=[0], mag=[0]))
    late = case.make(rate=RATE).run(*(array[1:] for array in signals.sensors()))
    assert est.status[0] == Status.ACC_MISSING | Status.MAG_MISSING | Status.NOT_ALIGNED
    # The same but for the way to the same inclination and heading: rounding.
    assert angle_between(est.quat[1], late.quat[0]) < 1e-14
    if not (case.knows_its_age or case.start_bias):
        assert inclination_between(est.quat[1:], late.quat).max() < 1e-10


def test_a_vertical_field_gives_no_heading() -> None:
    acc, down, north = [0.0, 0.0, 9.8], [0.0, 1e-6, -50.0], [20.0, 0.0, -50.0]
    for case in CASES:
        f = case.make(rate=RATE)
        f.update([0.0] * 3, acc, down)
        assert np.array_equal(f.quat, [1.0, 0.0, 0.0, 0.0]), case.label
        f.update([0.0] * 3, acc, north)
        assert angle_between(f.quat, about_z(np.pi / 2)) < 1e-14, case.label
