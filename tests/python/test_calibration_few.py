"""Calibrations of sensors that cannot be turned in all directions: circle, sphere, one axis, Ferraris."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import _quat
from ahrs_rs.calibration import GRAVITY, CalibrationError, CalibrationWarning, Turn
from calibrated import FloatArray

HORIZONTAL, DOWN = 20.0, 45.0
IRON = np.array([10.0, -5.0, 8.0])
RATE = 100.0


def about(axis: int, angle: FloatArray) -> FloatArray:
    q = np.zeros((len(angle), 4))
    q[:, 0], q[:, 1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def field(seed: int, yaw: FloatArray, tilt: float, noise: float = 0.3, mount: Any = (1.0, 0.0, 0.0, 0.0)) -> FloatArray:
    """Readings in a field that dips by 66°: turned about the vertical, and tilted evenly by up to so much."""
    random = np.random.default_rng(seed)
    pitch, roll = random.uniform(-tilt, tilt, (2, len(yaw)))
    q = _quat.multiply(_quat.multiply(about(2, yaw), about(1, pitch)), about(0, roll))
    q = _quat.multiply(q, np.broadcast_to(np.asarray(mount), q.shape))
    earth = np.broadcast_to([0.0, HORIZONTAL, -DOWN], (len(yaw), 3))
    return _quat.rotate(_quat.conjugate(q), earth) + IRON + noise * random.standard_normal((len(yaw), 3))


def heading_error(mag: FloatArray, yaw: FloatArray) -> float:
    """The largest error of the heading of a level sensor, in degrees: east is 0, and the field points to 90°."""
    found = math.pi / 2 - np.arctan2(mag[:, 1], mag[:, 0])
    return float(np.rad2deg(np.abs(np.angle(np.exp(1j * (found - yaw))))).max())


def test_a_rover_that_turns_about_the_vertical_has_its_heading_from_a_circle() -> None:
    yaw = np.random.default_rng(0).uniform(-math.pi, math.pi, 2000)
    mag = field(1, yaw, 0.0)
    fit = ar.calibration.magnetometer(mag, parameters=3)
    assert fit.normal is not None
    assert np.abs(fit.normal[2]) > 0.9999
    assert abs(float(fit.normal @ fit.calibration.offset)) < 1e-12
    # Five deviations; the horizontal field is the norm of the circle.
    assert np.all(np.abs(fit.values - [HORIZONTAL, *IRON[:2]]) < 5 * fit.std)
    assert fit.names == ("radius", "b_x", "b_y")
    # Noise of 0.3 over 20 µT is 0.86°, at most some four times of it among 2000.
    assert heading_error(fit.calibration.apply(mag), yaw) < 4.5 * math.degrees(0.3 / HORIZONTAL)
    assert heading_error(mag, yaw) > 20.0
    assert "the offset along it is unknown" in fit.summary()
    for parameters in (4, 6, 9):
        with pytest.raises(
            CalibrationError, match=r"in a plane, .*; or, for a heading in this plane alone, parameters=3"
        ):
            ar.calibration.magnetometer(mag, parameters=parameters)


def test_a_sensor_that_is_mounted_at_any_angle_has_its_circle_in_that_plane() -> None:
    random = np.random.default_rng(2)
    for seed in range(5):
        mount = random.standard_normal(4)
        mount /= np.linalg.norm(mount)
        yaw = random.uniform(-math.pi, math.pi, 1000)
        fit = ar.calibration.magnetometer(field(seed, yaw, 0.0, 0.1, mount), parameters=3)
        vertical = _quat.rotate(_quat.conjugate(mount)[None], np.array([[0.0, 0.0, 1.0]]))[0]
        assert fit.normal is not None
        assert abs(float(fit.normal @ vertical)) > 0.9999
        # Turned back, a circle about zero: about the vertical, whose own offset is left.
        level = _quat.rotate(
            np.broadcast_to(mount, (1000, 4)), fit.calibration.apply(field(seed, yaw, 0.0, 0.1, mount))
        )
        assert np.linalg.norm(level[:, :2], axis=1).mean() == pytest.approx(HORIZONTAL, abs=0.05)
        # Noise of 0.1 over √1000 in the centre, and the same over 14 µT of a plane that is some 50 µT away: 0.03.
        assert np.abs(level[:, :2].mean(axis=0) - HORIZONTAL * _mean_direction(yaw)).max() < 0.1


def _mean_direction(yaw: FloatArray) -> FloatArray:
    return np.array([np.sin(yaw).mean(), np.cos(yaw).mean()])


def test_a_boat_may_roll_and_half_a_circle_is_enough_where_it_does_not() -> None:
    rolling = ar.calibration.magnetometer(
        field(3, np.linspace(0.0, 2 * math.pi, 3000), math.radians(5.0)), parameters=3
    )
    # A roll of 5° at most moves a field of 45 µT by 2.3 µT RMS: over the root of 3000 readings 0.06 of the centre.
    assert np.abs(rolling.calibration.offset[:2] - IRON[:2]).max() < 0.3
    half = np.linspace(0.0, math.pi, 3000)
    fit = ar.calibration.magnetometer(field(3, half, 0.0), parameters=3)
    assert np.abs(fit.calibration.offset[:2] - IRON[:2]).max() < 0.1
    assert 0.5 <= fit.coverage <= 8 / 12 + 1e-9  # both ends are on a border of sectors
    with pytest.raises(CalibrationError, match=r"by a whole turn|known to .* only"):
        ar.calibration.magnetometer(field(3, np.linspace(0.0, 0.5, 3000), math.radians(5.0)), parameters=3)


def test_a_drone_that_tilts_by_30_degrees_has_its_hard_iron_from_a_sphere() -> None:
    mag = field(4, np.random.default_rng(4).uniform(-math.pi, math.pi, 2000), math.radians(30.0))
    fit = ar.calibration.magnetometer(mag, parameters=4)
    assert fit.names == ("radius", "b_x", "b_y", "b_z")
    assert np.all(np.abs(fit.values - [math.hypot(HORIZONTAL, DOWN), *IRON]) < 5 * fit.std)
    assert np.array_equal(fit.calibration.matrix, np.eye(3))
    assert np.abs(fit.calibration.offset - IRON).max() < 0.3
    for parameters in (6, 9):
        with pytest.raises(CalibrationError, match="parameters=4, hard iron alone, would do with these"):
            ar.calibration.magnetometer(mag, parameters=parameters)
    with pytest.raises(CalibrationError, match=r"circle|in a plane with parameters=3, got"):
        ar.calibration.magnetometer(mag, parameters=3)


def test_a_norm_scales_a_sphere_and_is_refused_of_a_circle() -> None:
    yaw = np.random.default_rng(5).uniform(-math.pi, math.pi, 1000)
    fit = ar.calibration.magnetometer(field(5, yaw, 0.6), parameters=4, norm=50.0)
    gain = 50.0 / math.hypot(HORIZONTAL, DOWN)
    assert fit.names[0] == "S"
    assert np.all(np.abs(fit.values - [gain, *IRON]) < 5 * fit.std)
    assert np.linalg.norm(fit.calibration.apply(field(5, yaw, 0.6)), axis=1).mean() == pytest.approx(50.0, rel=1e-3)
    with pytest.raises(ValueError, match="norm: expected None with parameters=3"):
        ar.calibration.magnetometer(field(5, yaw, 0.0), parameters=3, norm=50.0)


def test_outliers_and_a_long_rest_do_not_move_either() -> None:
    random = np.random.default_rng(6)
    for parameters, tilt in ((3, 0.0), (4, 0.6)):
        mag = field(6, random.uniform(-math.pi, math.pi, 1500), tilt)
        clean = ar.calibration.magnetometer(mag, parameters=parameters).calibration.offset
        mag[::10] += random.uniform(20.0, 60.0, (150, 3)) * ([1.0, 1.0, 0.0] if parameters == 3 else 1.0)
        rest = np.repeat(field(7, np.zeros(1), 0.0, 0.0), 2000, axis=0) + 0.3 * random.standard_normal((2000, 3))
        fit = ar.calibration.magnetometer(np.concatenate((rest, mag)), parameters=parameters)
        # Most of one reading in ten lies farther off than 4 deviations; a tenth of the readings less.
        assert fit.outliers > 100
        assert np.abs(fit.calibration.offset - clean).max() < 0.3


def test_errors_of_both_have_the_reported_covariance() -> None:
    for parameters, tilt, truth in ((3, 0.0, [HORIZONTAL, *IRON[:2]]), (4, 0.6, [math.hypot(HORIZONTAL, DOWN), *IRON])):
        errors = []
        for seed in range(60):
            yaw = np.random.default_rng(seed).uniform(-math.pi, math.pi, 500)
            fit = ar.calibration.magnetometer(field(seed, yaw, tilt), parameters=parameters)
            errors.append((fit.values - truth) / fit.std)
        # 180 or 240 numbers of variance 1, those of a fit correlated: spread 1 ± 0.07; four deviations.
        assert np.std(errors) == pytest.approx(1.0, abs=0.28)


BIAS = np.array([0.01, -0.02, 0.005])
GAIN = np.array([1.03, 0.98, 1.01])


def turned(axis: Any, angle: float, seed: int = 0, *, about_: Any = None, gain: Any = None) -> Turn:
    """A smooth turn by `angle` about `about_`, told as one about `axis`."""
    t = np.arange(401) / RATE
    way = angle * (1 - np.cos(np.pi * np.clip((t - 0.5) / 3.0, 0, 1))) / 2
    rate = np.concatenate(([0.0], np.diff(way) * RATE))
    direction = np.eye(3)["xyz".index(about_ or axis)]
    noise = 1e-3 * np.random.default_rng(seed).standard_normal((401, 3))
    matrix = np.diag(GAIN) if gain is None else gain
    return Turn(np.outer(rate, direction) @ matrix.T + BIAS + noise, axis, angle, rate=RATE)


REST = BIAS + 1e-3 * np.random.default_rng(9).standard_normal((500, 3))


def test_a_turntable_gives_the_gain_of_its_axis_and_all_biases() -> None:
    for axis in range(3):
        others = ", ".join(one for k, one in enumerate("xyz") if k != axis)
        with pytest.warns(CalibrationWarning, match=f"turns: there is none about {others}, whose gains stay at 1"):
            fit = ar.calibration.gyroscope(REST, [turned("xyz"[axis], 2 * math.pi), turned("xyz"[axis], -math.pi)])
        # Noise of 1 mrad/s over 4 s of samples, and of the bias: 0.3 mrad of a turn by 6 rad.
        assert fit.gain[axis, axis] == pytest.approx(GAIN[axis], abs=5 * fit.gain_std[axis, axis])
        assert np.isfinite(fit.gain_std[axis, axis])
        assert np.isnan(np.diag(fit.gain_std)).sum() == 2
        assert np.allclose(np.delete(np.diag(fit.calibration.matrix), axis), 1.0, rtol=0, atol=0)
        assert np.allclose(fit.bias, BIAS, rtol=0, atol=5e-3 / math.sqrt(500))
    with pytest.raises(CalibrationError, match="turns: "):
        ar.calibration.gyroscope(REST, [turned("x", 6.0)], cross_axis=True)


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ("xzy", r"turns\[1\]: expected a turn by 360° about z, got one by 353° about y: are order, signs and angles"),
        ("yzx", r"turns\[0\]: expected a turn by 360° about y, got one by 371° about x"),
        ("zyx", r"turns\[0\]: .* all of them: 371° about x, 353° about y, 364° about z"),
    ],
)
def test_turns_in_another_order_are_refused(told: str, message: str) -> None:
    turns = [turned(axis, 2 * math.pi, k, about_=true) for k, (axis, true) in enumerate(zip(told, "xyz", strict=True))]
    with pytest.raises(CalibrationError, match=message):
        ar.calibration.gyroscope(REST, turns)


@pytest.mark.parametrize("wrong", range(3))
def test_a_turn_in_the_other_direction_or_by_half_the_angle_is_refused(wrong: int) -> None:
    turns = [turned(axis, 2 * math.pi, k) for k, axis in enumerate("xyz")]
    one = turns[wrong]
    turns[wrong] = Turn(one.gyr, one.axis, -one.angle, rate=RATE)
    with pytest.raises(
        CalibrationError, match=rf"turns\[{wrong}\]: expected a turn by -360° about {'xyz'[wrong]}, got"
    ):
        ar.calibration.gyroscope(REST, turns)
    turns[wrong] = Turn(one.gyr, one.axis, 0.45 * one.angle, rate=RATE)
    with pytest.raises(CalibrationError, match=rf"turns\[{wrong}\]: expected a turn by 162°"):
        ar.calibration.gyroscope(REST, turns)


def test_a_gain_that_no_gyroscope_has_is_doubted() -> None:
    one = turned("x", 2 * math.pi)
    turns = [Turn(one.gyr, "x", 1.5 * math.pi, rate=RATE), turned("y", 6.0), turned("z", 6.0)]
    with pytest.warns(CalibrationWarning, match=r"the gain of x is 1\.37, .*: are the angles of the turns right"):
        ar.calibration.gyroscope(REST, turns)


ACC_GAIN = np.eye(3) + np.array([[0.02, 0.01, -0.015], [0.005, -0.03, 0.01], [-0.01, 0.02, 0.01]])
ACC_BIAS = np.array([0.2, -0.3, 0.1])
GYR_GAIN = np.eye(3) + np.array([[0.03, -0.01, 0.02], [0.015, -0.02, 0.0], [0.0, 0.01, 0.01]])
SENSITIVITY = 1e-3 * np.array([[1.0, -0.5, 0.2], [0.0, 0.8, -0.3], [0.4, 0.1, -1.0]])


def positions(seed: int, noise: float = 0.01) -> list[tuple[FloatArray, FloatArray]]:
    """The six sides, with readings by the model of `FerrarisFit`."""
    random, held = np.random.default_rng(seed), []
    for axis in np.eye(3):
        for side in (1.0, -1.0):
            force = GRAVITY * side * axis
            held.append(
                (
                    ACC_GAIN @ force + ACC_BIAS + noise * random.standard_normal((400, 3)),
                    SENSITIVITY @ force + BIAS + 0.1 * noise * random.standard_normal((400, 3)),
                )
            )
    return held


def test_ferraris_finds_scale_misalignment_offset_and_g_sensitivity_of_both_sensors() -> None:
    turns = [turned(axis, 2 * math.pi, k, gain=GYR_GAIN) for k, axis in enumerate("xyz")]
    fit = ar.calibration.ferraris(positions(1), turns)
    # Means of 400 readings with 0.01 m/s² and 1 mrad/s: five deviations, of differences over 2 g and sums over 6.
    assert np.abs(fit.acc_gain - ACC_GAIN).max() < 5 * 0.01 / 20 / GRAVITY / math.sqrt(2)
    assert np.abs(fit.acc_bias - ACC_BIAS).max() < 5 * 0.01 / 20 / math.sqrt(6)
    assert np.abs(fit.g_sensitivity - SENSITIVITY).max() < 5e-3 / 20 / GRAVITY / math.sqrt(2)
    assert np.abs(fit.gyr_bias - BIAS).max() < 5e-3 / 20 / math.sqrt(6)
    assert np.all(np.abs(fit.gyr_gain - GYR_GAIN) < 5 * fit.gyr_gain_std)
    acc, gyr = fit.calibrations.acc, fit.calibrations.gyr
    assert isinstance(acc, ar.calibration.Calibration)
    assert isinstance(gyr, ar.calibration.Calibration)
    assert np.allclose(acc.apply(ACC_GAIN @ [1.0, 2.0, 3.0] + ACC_BIAS), [1, 2, 3], rtol=0, atol=0.01)
    assert np.allclose(gyr.apply(GYR_GAIN @ [1.0, 2.0, 3.0] + BIAS), [1, 2, 3], rtol=0, atol=0.01)


def test_ferraris_takes_its_positions_in_any_order_and_more_than_six() -> None:
    turns = [turned(axis, 2 * math.pi, k, gain=GYR_GAIN) for k, axis in enumerate("xyz")]
    held = positions(1)
    mixed = [held[k] for k in (3, 0, 5, 1, 4, 2)]
    assert np.allclose(
        ar.calibration.ferraris(mixed, turns).acc_gain,
        ar.calibration.ferraris(held, turns).acc_gain,
        rtol=0,
        atol=1e-12,
    )
    more = ar.calibration.ferraris([*held, *positions(2)], turns)
    assert np.abs(more.acc_gain - ACC_GAIN).max() < 5 * 0.01 / 20 / GRAVITY / 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda held, turns: (held[:-1], turns), "positions: there is none with z down"),
        (lambda held, turns: ([], turns), "positions: there is none with x up, x down, y up, y down, z up, z down"),
        (
            lambda held, turns: ([(np.full((9, 3), 5.6), np.zeros((9, 3))), *held], turns),
            r"positions\[0\]: expected an axis up or down, got a force of \(5\.60, 5\.60, 5\.60\)",
        ),
        (lambda held, turns: ([(a, g + 1.0) for a, g in held], turns), "positions: the sensor turns by 1"),
        (lambda held, turns: ([(a / GRAVITY, g) for a, g in held], turns), "are they in g"),
        (lambda held, turns: (held, turns[:2]), "turns: there is none about z"),
        (lambda held, turns: (held, []), "turns: expected one about each axis, got none"),
        (lambda held, turns: (held, [turns[0], turns[1], turned("z", 6.0, about_="x")]), r"turns\[2\]: expected"),
        (lambda held, turns: ([(a[:0], g) for a, g in held], turns), r"positions\[0\]: acc: expected readings"),
    ],
)
def test_what_ferraris_cannot_use_is_refused(change: Any, message: str) -> None:
    turns = [turned(axis, 2 * math.pi, k, gain=GYR_GAIN) for k, axis in enumerate("xyz")]
    held, told = change(positions(1), turns)
    with pytest.raises(ValueError, match=message):
        ar.calibration.ferraris(held, told)


HELD = positions(0)
TURNS = [turned("xyz"[axis], np.pi / 2.0, axis) for axis in range(3)]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c: c.magnetometer(np.eye(3), parameters="9"), "^parameters: expected 3, 4, 6 or 9, got '9'"),
        (lambda c: c.magnetometer(np.eye(3), norm="50"), "^norm: expected a number, got '50'"),
        (lambda c: c.LiveMagnetometer(parameters=5), "^parameters: expected 3, 4, 6 or 9, got 5"),
        (lambda c: c.LiveMagnetometer(norm=-1.0), "^norm: expected a positive number, got -1"),
        (lambda c: c.LiveMagnetometer(parameters=3, norm=50.0), "^norm: expected None with parameters=3, .*, got 50"),
        (lambda c: c.ferraris(HELD, 5), "^turns: expected Turns, as many as were made, got int"),
        (lambda c: c.ferraris(HELD, [np.eye(3)]), r"^turns\[0\]: expected a Turn, got ndarray"),
        (lambda c: c.ferraris(None, TURNS), r"^positions: expected pairs of readings \(acc, gyr\), got NoneType"),
        (lambda c: c.ferraris([HELD[0][0]], TURNS), r"^positions\[0\]: expected a pair of .* got \d+ parts"),
        (lambda c: c.ferraris(HELD, TURNS, gravity="g"), "^gravity: expected a number, got 'g'"),
        (
            lambda c: c.six_positions(9.81),
            r"^positions: expected readings \(n, 3\) or \(3,\) of each position, got flo",
        ),
        (lambda c: c.gyroscope(np.zeros((9, 3)), 1), "^turns: expected Turns, as many as were made, got int"),
        (lambda c: c.Turn(np.eye(3), "z", "90").vector, "^angle: expected a number, got '90'"),
        (lambda c: c.Turn(np.eye(3), {}, 1.0).vector, "^axis: expected an array of real numbers, got"),
        (lambda c: c.gyroscope_rests(np.zeros((9, 4)), 100.0), r"^gyr: expected shape \(T, 3\), got \(9, 4\)"),
        (lambda c: c.store({}, "imu"), "^calibrations: expected Calibrations, got dict"),
    ],
)
def test_what_is_no_reading_turn_or_number_is_told(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(ar.calibration)
