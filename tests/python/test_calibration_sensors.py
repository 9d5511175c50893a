"""Six positions, gyroscopes against known turns, and what changes with the temperature."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

import ahrs_rs as ar
from ahrs_rs import _quat
from ahrs_rs.calibration import (
    GRAVITY,
    Calibration,
    CalibrationError,
    TemperatureCalibration,
    Turn,
    _linear,
    gyroscope,
    gyroscope_from_reference,
    held_attitudes,
    six_positions,
    two_temperatures,
    warm_up_accelerometer,
    warm_up_gyroscope,
)
from calibrated import DEGREE, TABLE_4_ACC, TABLE_4_GYR, FloatArray, directions, symmetric

#: Each axis up and down, none exactly.
POSES = np.concatenate((np.eye(3), -np.eye(3))) + 0.1 * np.array(
    [[0, 1, -1], [1, 0, 2], [-1, 1, 0], [0, -2, 1], [1, 0, -1], [2, 1, 0]]
)
POSES /= np.linalg.norm(POSES, axis=1, keepdims=True)


def measured(cal: TemperatureCalibration, y: FloatArray, temperature: Any) -> FloatArray:
    """Eq 16, as a sensor measures."""
    t = np.asarray(temperature)[..., None]
    return (cal.gain_slope * t + cal.gain_at_zero) * y + cal.bias_slope * t + cal.bias_at_zero


# Six positions.


def test_six_positions_give_gain_and_bias_without_knowing_the_positions() -> None:
    for temperature in (15.0, 35.0):
        found = six_positions(list(measured(TABLE_4_ACC, GRAVITY * POSES, temperature)))
        at = TABLE_4_ACC.at(temperature)
        # Newton's iteration ends at rounding of g², times a condition of a few.
        assert np.allclose(found.calibration.matrix, at.matrix, rtol=0, atol=1e-12)
        assert np.allclose(found.calibration.offset, at.offset, rtol=0, atol=1e-11)
        assert found.covariance is None
        assert np.abs(found.residual).max() < 1e-12
        assert found.iterations < 10


def test_six_positions_are_cirillos_linear_system_solved_by_newton() -> None:
    # Six readings and six unknowns: both solve the same equations, one linear in other unknowns.
    x = measured(TABLE_4_ACC, GRAVITY * POSES, 25.0)
    squared, centre = _linear.algebraic(x.T, 6)
    found = six_positions(list(x))
    assert np.allclose(GRAVITY * np.sqrt(np.diag(squared)), 1 / found.gain, rtol=1e-10)
    assert np.allclose(centre, found.bias, rtol=0, atol=1e-9)


def test_the_covariance_of_six_positions_is_that_of_their_errors() -> None:
    random = np.random.default_rng(0)
    lengths = []
    for _ in range(200):
        clean = measured(TABLE_4_ACC, GRAVITY * POSES, 25.0)
        parts = [mean + 0.05 * random.standard_normal((200, 3)) for mean in clean]
        found = six_positions(parts)
        at = TABLE_4_ACC.at(25.0)
        error = np.concatenate((found.gain - 1 / np.diag(at.matrix), found.bias - at.offset))
        assert found.covariance is not None
        lengths.append(error @ np.linalg.solve(found.covariance, error))
    # The mean of 200 χ² of 6: 6 ± √(12/200) = 0.245; four deviations.
    assert np.mean(lengths) == pytest.approx(6.0, abs=1.0)


def test_more_positions_are_taken_by_least_squares() -> None:
    random = np.random.default_rng(1)
    more = directions(random, 30)
    clean = measured(TABLE_4_ACC, GRAVITY * more, 25.0)
    found = six_positions([mean + 0.02 * random.standard_normal((400, 3)) for mean in clean])
    assert np.allclose(found.calibration.matrix, TABLE_4_ACC.at(25.0).matrix, rtol=0, atol=1e-3)  # 5 · 0.02/√400/g
    assert np.abs(found.residual).max() < 0.01


def test_held_attitudes_are_found_in_a_recording_and_give_the_same() -> None:
    random = np.random.default_rng(2)
    parts = []
    for up in POSES:
        parts += [np.tile(GRAVITY * up, (300, 1)), GRAVITY * up + 5.0 * random.standard_normal((150, 3))]
    x = measured(TABLE_4_ACC, np.concatenate(parts), 25.0) + 0.03 * random.standard_normal((6 * 450, 3))
    slices = held_attitudes(x, 100.0)
    assert len(slices) == 6
    for k, part in enumerate(slices):
        assert 450 * k <= part.start < part.stop <= 450 * k + 300
        assert part.stop - part.start >= 200
    found = six_positions([x[part] for part in slices])
    assert np.allclose(found.bias, TABLE_4_ACC.at(25.0).offset, rtol=0, atol=0.02)  # 0.03/√200 · 10


@pytest.mark.parametrize(
    ("positions", "error", "message"),
    [
        (
            GRAVITY * POSES[:5],
            CalibrationError,
            "expected at least six, got 5: hold the sensor still with each axis up",
        ),
        (
            GRAVITY * np.repeat(POSES[:3], 2, axis=0),
            CalibrationError,
            "there is none with x down, y down, z down; hold the sensor with each axis up and down",
        ),
        (GRAVITY * np.tile(POSES[0], (6, 1)), CalibrationError, "there is none with x down, y up, y down"),
        (POSES, ValueError, r"expected readings of about 9.807 m/s², got 1: are they in g \(times 9.80665\)"),
        (np.full((6, 3), np.nan), CalibrationError, r"positions\[0\]: expected readings, got NaN only"),
    ],
)
def test_positions_that_do_not_tell_are_refused(positions: FloatArray, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        six_positions(list(positions))


# Gyroscopes.

RATE = 200.0
GAINS = np.array([0.97, 1.04, 1.01])
BIAS = np.array([0.02, -0.03, 0.01])


def turned(axis: Any, angle: float, gain: FloatArray, seed: int, noise: float = 0.0, seconds: float = 4.0) -> Turn:
    """A turn with a smooth start and end."""
    random = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE) + 1) / RATE
    direction = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.asarray(axis) / np.linalg.norm(axis)
    # The mean rate of each step of angle · (1 − cos)/2.
    way = angle * (1 - np.cos(np.pi * np.clip((t - 0.5) / (seconds - 1.0), 0, 1))) / 2
    rate = np.concatenate(([0.0], np.diff(way) * RATE))
    gyr = np.outer(rate, direction) @ gain.T + BIAS + noise * random.standard_normal((len(t), 3))
    return Turn(gyr, axis, angle, rate=RATE)


def test_turns_by_known_angles_give_the_gains() -> None:
    gain = np.diag(GAINS)
    turns = [turned(axis, angle, gain, 0) for axis, angle in (("x", 6.0), ("y", -6.0), ("z", 3.0), ("z", -9.0))]
    found = gyroscope(np.tile(BIAS, (50, 1)), turns)
    assert np.allclose(found.gain, gain, rtol=0, atol=1e-13)
    assert np.allclose(found.bias, BIAS, rtol=0, atol=1e-16)
    assert np.abs(found.residual).max() < 1e-12
    assert np.allclose(found.calibration.apply(BIAS + GAINS * [1, 2, 3]), [1, 2, 3], rtol=0, atol=1e-12)


def test_turns_about_any_axes_give_misalignment_too() -> None:
    random = np.random.default_rng(3)
    gain = np.diag(GAINS) + 0.02 * random.standard_normal((3, 3))
    turns = [turned(axis, 6.0, gain, k) for k, axis in enumerate(directions(random, 5))]
    found = gyroscope(np.tile(BIAS, (50, 1)), turns, cross_axis=True)
    assert np.allclose(found.gain, gain, rtol=0, atol=1e-12)
    assert np.allclose(found.calibration.matrix @ gain, np.eye(3), rtol=0, atol=1e-12)


def test_errors_of_the_gains_are_within_their_deviations() -> None:
    random = np.random.default_rng(4)
    errors = []
    for seed in range(200):
        turns = [turned(axis, 2 * math.pi, np.diag(GAINS), 10 * seed + k, 0.02) for k, axis in enumerate("xyz")]
        found = gyroscope(BIAS + 0.02 * random.standard_normal((2000, 3)), turns)
        errors += [*(np.diag(found.gain) - GAINS) / np.diag(found.gain_std), *(found.bias - BIAS) / found.bias_std]
    # 1200 numbers of variance 1, those of a fit nearly independent: spread 1 ± 0.02; four deviations.
    assert np.std(errors) == pytest.approx(1.0, abs=0.08)


def test_a_missing_row_of_a_turn_holds_the_last_rate() -> None:
    turn = turned("x", 6.0, np.eye(3), 0)
    gyr = np.array(turn.gyr)
    gyr[400] = np.nan
    held = Turn(np.where(np.isnan(gyr), gyr[399], gyr), "x", 6.0, rate=RATE)
    total, _, _ = Turn(gyr, "x", 6.0, rate=RATE).integral("turn")
    assert np.array_equal(total, held.integral("turn")[0])


def test_a_rest_alone_gives_the_bias() -> None:
    found = gyroscope(BIAS + 0.01 * np.random.default_rng(5).standard_normal((400, 3)))
    assert np.allclose(found.bias, BIAS, rtol=0, atol=5 * 0.01 / 20)
    assert np.array_equal(found.calibration.matrix, np.eye(3))
    assert found.bias_std == pytest.approx(np.full(3, 0.01 / 20), rel=0.15)


@pytest.mark.parametrize(
    ("rest", "turns", "error", "message"),
    [
        (np.zeros((1, 3)), [], CalibrationError, "expected readings at rest, got 1"),
        (np.full((50, 3), 2.0), [], CalibrationError, "rest: turns by 2 rad/s: let the sensor lie still"),
        (
            np.random.default_rng(0).standard_normal((50, 3)),
            [],
            CalibrationError,
            r"rest: (varies|turns) by .* let the sensor lie still",
        ),
        (
            np.tile(BIAS, (9, 1)),
            [("x", 6.0), ("y", 6.0)],
            CalibrationError,
            r"turns\[1\]: expected .* 344° about y, got",
        ),
        (np.tile(BIAS, (9, 1)), [("x", -6.0)], CalibrationError, r"by -344° about x, got one by 344° about x"),
        (np.tile(BIAS, (9, 1)), [("x", 6.0), ("x", 8.0)], CalibrationError, "told are 344° about x, 458° about x, and"),
        (np.tile(BIAS, (9, 1)), [("x", 0.1)], CalibrationError, "expected a turn of at least 0.5 rad, got 0.1"),
        (np.tile(BIAS, (9, 1)), [("w", 6.0)], ValueError, "axis: expected x, y, z or a direction, got 'w'"),
    ],
)
def test_what_tells_nothing_of_a_gyroscope_is_refused(
    rest: FloatArray, turns: list[tuple[Any, float]], error: type[Exception], message: str
) -> None:
    made = [Turn(np.asarray(turned("x", 6.0, np.eye(3), 0).gyr), axis, angle, rate=RATE) for axis, angle in turns]
    with pytest.raises(error, match=message):
        gyroscope(rest, made)


def test_turns_in_degrees_are_told() -> None:
    turns = [turned(axis, 6.0, np.eye(3) / DEGREE, 0) for axis in "xyz"]
    with pytest.raises(ValueError, match=r"turn by 57\.\d times the angles that are given: are the readings in °/s"):
        gyroscope(np.tile(BIAS, (9, 1)), turns)


def test_a_reference_orientation_gives_gain_and_bias() -> None:
    rec = ar.simulate.demo(duration=60.0, rate=100.0, seed=3, noise=False)
    gyr = GAINS * rec.gyr + BIAS
    found = gyroscope_from_reference(gyr, rec.ref, t=rec.t)
    # The reference is exact, and rates are means over steps: what is left is where Gauss-Newton ends.
    assert np.allclose(np.diag(found.gain), GAINS, rtol=0, atol=1e-9)
    assert np.allclose(found.bias, BIAS, rtol=0, atol=1e-9)
    # In another earth frame it is the same: the frame drops out.
    assert rec.ref is not None
    other = np.broadcast_to([0.1, -0.7, 0.7, 0.1], rec.ref.shape)
    again = gyroscope_from_reference(gyr, _quat.multiply(other, rec.ref), t=rec.t)
    assert np.allclose(again.calibration.matrix, found.calibration.matrix, rtol=0, atol=1e-9)


def test_a_noisy_reference_with_gaps_and_jumps_gives_them_within_their_deviations() -> None:
    rec = ar.simulate.demo(duration=120.0, rate=100.0, seed=4, noise=False)
    assert rec.ref is not None
    random = np.random.default_rng(6)
    gyr = GAINS * rec.gyr + BIAS + 0.01 * random.standard_normal(rec.gyr.shape)
    ref = rec.ref.copy()
    ref[1000:1200] = np.nan
    ref[3000:3010] = [0.5, 0.5, 0.5, 0.5]
    found = gyroscope_from_reference(gyr, ref, t=rec.t)
    error = np.concatenate(
        ((np.diag(found.gain) - GAINS) / np.diag(found.gain_std), (found.bias - BIAS) / found.bias_std)
    )
    assert error @ error < chi2.ppf(0.9999, 6)
    assert np.abs(np.diag(found.gain) - GAINS).max() < 0.003


def test_a_reference_that_does_not_turn_with_the_sensor_is_refused() -> None:
    rec = ar.simulate.demo(duration=20.0, rate=50.0, seed=5)
    assert rec.ref is not None
    with pytest.raises(CalibrationError, match=r"ref: does not turn as the sensor does|would be known to"):
        gyroscope_from_reference(rec.gyr, rec.ref[::-1], t=rec.t)
    with pytest.raises(CalibrationError, match=r"too little turning|would be known to|does not turn"):
        gyroscope_from_reference(
            1e-3 * np.random.default_rng(0).standard_normal((1000, 3)), np.tile([1.0, 0, 0, 0], (1000, 1)), rate=50.0
        )
    with pytest.raises(ValueError, match=r"ref: expected shape \(1000, 4\)"):
        gyroscope_from_reference(rec.gyr, rec.ref[:5], t=rec.t)
    with pytest.raises(CalibrationError, match=r"at least 10 windows of 0\.5 s with a reference, got 0"):
        gyroscope_from_reference(rec.gyr, np.full((1000, 4), np.nan), t=rec.t)


# Temperature.


@pytest.mark.parametrize("table", [TABLE_4_ACC, TABLE_4_GYR], ids=["acc", "gyr"])
def test_two_temperatures_give_table_4_back(table: TemperatureCalibration) -> None:
    found = two_temperatures(table.at(15.0), table.at(35.0), (15.0, 35.0))
    # Rounding of numbers near 1 over 20 °C, and 35 times that at 0 °C.
    assert np.allclose(found.numbers, table.numbers, rtol=0, atol=1e-14)
    assert found.range == (15.0, 35.0)
    back = two_temperatures(table.at(35.0), table.at(15.0), (35.0, 15.0))
    assert np.allclose(back.numbers, found.numbers, rtol=0, atol=1e-14)
    assert back.range == (15.0, 35.0)


def test_six_positions_at_two_temperatures_are_the_papers_first_strategy() -> None:
    fits = [six_positions(list(measured(TABLE_4_ACC, GRAVITY * POSES, t))).calibration for t in (15.0, 35.0)]
    found = two_temperatures(fits[0], fits[1], (15.0, 35.0))
    assert np.allclose(found.numbers, TABLE_4_ACC.numbers, rtol=0, atol=1e-11)


def warming(seed: int, noise: float) -> list[tuple[FloatArray, FloatArray]]:
    """Six positions; in each the sensor warms up from some 12 to 36 °C, as the figures 11 and 12 of the paper show."""
    random = np.random.default_rng(seed)
    found = []
    for up in POSES:
        t = 36.0 - random.uniform(23.0, 25.0) * np.exp(-np.linspace(0, 3, 2000))
        clean = measured(TABLE_4_ACC, np.broadcast_to(GRAVITY * up, (2000, 3)), t)
        found.append((clean + noise * random.standard_normal(clean.shape), t))
    return found


def test_a_warm_up_in_six_positions_gives_table_4_back() -> None:
    found = warm_up_accelerometer(warming(0, 0.0))
    # Readings are linear in the temperature in each position, so the lines are exact; rounding as above.
    assert np.allclose(found.numbers, TABLE_4_ACC.numbers, rtol=0, atol=1e-11)
    assert found.range is not None
    assert 10.9 < found.range[0] < 13.1
    assert 34.0 < found.range[1] < 36.0


def test_the_errors_of_a_warm_up_have_the_reported_covariance() -> None:
    lengths = []
    for seed in range(100):
        found = warm_up_accelerometer(warming(seed, 0.05))
        error = found.numbers - TABLE_4_ACC.numbers
        assert found.covariance is not None
        lengths.append(error @ np.linalg.solve(found.covariance, error))
    # The mean of 100 χ² of 12: 12 ± √(24/100) = 0.49; four deviations.
    assert np.mean(lengths) == pytest.approx(12.0, abs=2.0)


def test_a_gyroscope_is_calibrated_over_the_temperature_by_a_warm_up_and_turns() -> None:
    t = 36.0 - 24.0 * np.exp(-np.linspace(0, 3, 3000))
    rest = measured(TABLE_4_GYR, np.zeros((3000, 3)), t)
    turns = []
    for warmth in (14.0, 25.0, 35.0):
        for axis in "xyz":
            clean = np.asarray(turned(axis, 6.0, np.eye(3), 0).gyr) - BIAS
            turns.append(
                (Turn(measured(TABLE_4_GYR, clean, warmth), axis, 6.0, rate=RATE), np.full(len(clean), warmth))
            )
    found = warm_up_gyroscope((rest, t), turns)
    assert np.allclose(found.numbers, TABLE_4_GYR.numbers, rtol=0, atol=1e-12)
    bias_only = warm_up_gyroscope((rest, t))
    assert np.allclose(bias_only.bias_slope, TABLE_4_GYR.bias_slope, rtol=0, atol=1e-14)
    assert np.array_equal(bias_only.gain_at_zero, np.ones(3))
    with pytest.raises(CalibrationError, match="about x they are all at 14 °C"):
        warm_up_gyroscope((rest, t), turns[:3])


def test_the_bias_of_a_warm_up_is_within_its_deviations() -> None:
    random = np.random.default_rng(7)
    t = 36.0 - 24.0 * np.exp(-np.linspace(0, 3, 3000))
    lengths = []
    for _ in range(100):
        rest = measured(TABLE_4_GYR, np.zeros((3000, 3)), t) + 0.01 * random.standard_normal((3000, 3))
        found = warm_up_gyroscope((rest, t))
        error = (found.numbers - TABLE_4_GYR.numbers)[6:]
        assert found.covariance is not None
        lengths.append(error @ np.linalg.solve(found.covariance[6:, 6:], error))
    assert np.mean(lengths) == pytest.approx(6.0, abs=1.4)  # 6 ± √(12/100), four deviations


def test_temperatures_that_tell_nothing_of_a_slope_are_refused() -> None:
    at = TABLE_4_ACC.at(20.0)
    with pytest.raises(CalibrationError, match="temperatures: expected two that differ by at least 1"):
        two_temperatures(at, at, (20.0, 20.5))
    with pytest.raises(ValueError, match="second: expected a calibration without terms between axes"):
        two_temperatures(at, Calibration(symmetric(np.random.default_rng(0), 9), np.zeros(3)), (10.0, 20.0))
    constant = [(acc, np.full(2000, 20.0)) for acc, _ in warming(0, 0.0)]
    with pytest.raises(CalibrationError, match=r"positions\[0\]: expected a warm-up over at least 1.0 °C"):
        warm_up_accelerometer(constant)
    apart = warming(0, 0.0)
    apart[2] = (apart[2][0], apart[2][1] + 40.0)
    with pytest.raises(CalibrationError, match="expected warm-ups over the same temperatures"):
        warm_up_accelerometer(apart)
    with pytest.raises(CalibrationError, match="expected at least six, got 0"):
        warm_up_accelerometer([])
    with pytest.raises(ValueError, match=r"positions\[0\]: temperature: expected shape \(2000,\)"):
        warm_up_accelerometer([(acc, t[:5]) for acc, t in warming(0, 0.0)])
