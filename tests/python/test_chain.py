"""Relative orientations, angles of joints and alignments of sensors, on chains whose truth is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from chains import Chain, Floats, waves
from signals import angle_between, quats

T = np.arange(500) / 50.0
HINGE = Chain("Y", waves(5, 0.8, channels=1))
#: The axis of the hinge in the frames of both sensors.
AXES = HINGE.axis(0, [0.0, 1.0, 0.0]), HINGE.axis(1, [0.0, 1.0, 0.0])
#: The relative orientation of the sensors at angle 0.
ZERO = quats(HINGE.mounts[0].inv() * HINGE.mounts[1])
X, Z = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
#: Times and angular rates of a sensor that turns.
SPUN = T, np.sin(3.0 * T)[:, np.newaxis] * np.array(Z)


def spread(seed: int, count: int, covariance: Floats) -> Rotation:
    return Rotation.from_rotvec(np.random.default_rng(seed).multivariate_normal(np.zeros(3), covariance, count))


def covariances(seed: int, size: float) -> tuple[Floats, Floats]:
    factors = np.random.default_rng(seed).normal(size=(2, 3, 3)) * size
    return factors[0] @ factors[0].T, factors[1] @ factors[1].T


def test_the_relative_orientation_takes_the_second_frame_to_the_first() -> None:
    first, second = HINGE.sensors(T)
    found = ar.chain.relative(quats(first), quats(second))
    assert found.covariance is None
    assert angle_between(found.quat, quats(first.inv() * second)).max() < 1e-14
    assert (np.sum(found.quat[1:] * found.quat[:-1], axis=1) > 0.0).all()
    turned = ar.rotation.product(ar.rotation.about_axis("z", -0.7), quats(second))
    again = ar.chain.relative(quats(first), turned, heading=0.7)
    assert angle_between(again.quat, found.quat).max() < 1e-14


def test_the_covariance_of_a_relative_orientation_is_that_of_drawn_errors() -> None:
    first, second = (one[7] for one in HINGE.sensors(T))
    p, q = covariances(1, 0.02)
    count = 20000
    drawn = (first * spread(2, count, p)).inv() * (second * spread(3, count, q))
    truth = first.inv() * second
    errors = (truth.inv() * drawn).as_rotvec()
    found = ar.chain.relative(quats(first), quats(second), covariances=(p, q)).covariance
    assert found is not None
    # Of 20000 draws the entries scatter by 1 % of the largest; second-order terms are 0.02² of them.
    np.testing.assert_allclose(found, np.cov(errors.T), atol=0.04 * np.abs(found).max())


def test_with_a_corrected_heading_its_uncertainty_stands_in_place_of_the_filters() -> None:
    first, second = (one[7] for one in HINGE.sensors(T))
    p, q = covariances(1, 0.02)
    up = [one.inv().apply([0.0, 0.0, 1.0]) for one in (first, second)]
    # A filter without a magnetometer knows nothing of the heading.
    open_ = [cov + 3.0 * np.outer(u, u) for cov, u in zip((p, q), up, strict=True)]
    std = 0.03
    heading = ar.chain.HeadingCorrection(np.array(0.0), np.array(std), quats(second))
    found = ar.chain.relative(quats(first), quats(second), heading=heading, covariances=(open_[0], open_[1])).covariance
    assert found is not None
    # Only inclinations are drawn, and a turn about the vertical between the two.
    count = 20000
    level = [np.eye(3) - np.outer(u, u) for u in up]
    turn = Rotation.from_rotvec(np.random.default_rng(4).normal(0.0, std, (count, 1)) * [0.0, 0.0, 1.0])
    drawn_first = first * spread(2, count, level[0] @ p @ level[0])
    drawn = drawn_first.inv() * turn * (second * spread(3, count, level[1] @ q @ level[1]))
    errors = ((first.inv() * second).inv() * drawn).as_rotvec()
    np.testing.assert_allclose(found, np.cov(errors.T), atol=0.04 * np.abs(found).max())


def test_the_angle_of_a_hinge_is_that_of_its_joint() -> None:
    r = ar.chain.relative(*HINGE.quats(T))
    truth = HINGE.angles(T)[:, 0]
    found = ar.chain.joint_angle(r, AXES[0], AXES[1], zero=ZERO)
    np.testing.assert_allclose(found.angle, truth, atol=1e-13)
    np.testing.assert_allclose(found.off_axis, 0.0, atol=1e-13)
    assert found.std is None
    # Without the pose of angle zero there is a constant offset; the opposite axis turns the sign.
    free = ar.chain.joint_angle(r, AXES[0], AXES[1])
    assert np.ptp(free.angle - truth) < 1e-13
    opposite = ar.chain.joint_angle(r, -AXES[0], -AXES[1], zero=ZERO)
    np.testing.assert_allclose(opposite.angle, -truth, atol=1e-13)
    axes = ar.chain.HingeAxis(*AXES, np.zeros(2), 0.0, 1.0)
    np.testing.assert_array_equal(ar.chain.joint_angle(r, axes).angle, free.angle)


def test_the_angle_of_a_wheel_goes_on_after_half_a_turn() -> None:
    wheel = Chain("Y", lambda t: 2.0 * t[:, np.newaxis])
    found = ar.chain.joint_angle(ar.chain.relative(*wheel.quats(T)), *AXES, zero=ZERO)
    np.testing.assert_allclose(found.angle, 2.0 * T, atol=1e-12)
    quat = ar.chain.relative(*wheel.quats(T)).quat.copy()
    quat[100] = np.nan
    found = ar.chain.joint_angle(quat, *AXES, zero=ZERO)
    np.testing.assert_allclose(np.delete(found.angle, 100), np.delete(2.0 * T, 100), atol=1e-12)
    assert np.isnan(found.angle[100])


def test_what_is_no_turn_about_the_axis_is_off_axis() -> None:
    skewed = Chain("YX", lambda t: np.column_stack([np.sin(t), np.full_like(t, 0.2)]))
    found = ar.chain.joint_angle(ar.chain.relative(*skewed.quats(T)), *AXES, zero=ZERO)
    np.testing.assert_allclose(found.off_axis, 0.2, atol=1e-13)


def test_the_deviation_of_an_angle_is_that_of_drawn_errors() -> None:
    # A large angle, and axes that are not quite one: every term of the gradient counts.
    skewed = Chain("YX", lambda t: np.column_stack([np.full_like(t, 1.2), np.full_like(t, 0.3)]))
    first, second = (one[0] for one in skewed.sensors(T))
    p, q = covariances(8, 0.02)
    found = ar.chain.joint_angle(ar.chain.relative(quats(first), quats(second), covariances=(p, q)), *AXES, zero=ZERO)
    count = 20000
    drawn = quats((first * spread(2, count, p)).inv() * (second * spread(3, count, q)))
    angles = [float(ar.chain.joint_angle(one, *AXES, zero=ZERO).angle) for one in drawn[:2500]]
    assert found.std is not None
    # The standard deviation of 2500 draws scatters by 1.4 %.
    assert float(found.std) == pytest.approx(np.std(angles), rel=0.05)


def test_estimates_bring_their_covariances_and_say_where_they_know_nothing() -> None:
    rec = ar.simulate.demo(duration=5.0, seed=3)
    acc = rec.acc.copy()
    acc[:20] = np.nan
    est = ar.MEKF(rate=100.0).run(rec.gyr, acc, t=rec.t, outputs=["covariance"])
    found = ar.chain.relative(est, est)
    assert found.covariance is not None
    assert np.isnan(found.quat[:20]).all()  # not aligned yet
    assert not np.isnan(found.quat[20:]).any()
    np.testing.assert_allclose(found.covariance[20:], 2.0 * est.covariance[20:], rtol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frame": "NED"}, "^second: expected an estimate in the frame of the first, ENU, got NED"),
        ({"t": 1.0}, "^second: expected the times of the first, got times that are up to 1 s from them"),
        ({"rows": 400}, r"^second: expected the shape of the first, \(500, 4\), got \(400, 4\)"),
    ],
)
def test_estimates_that_do_not_belong_together_are_refused(change: dict[str, Any], message: str) -> None:
    rec = ar.simulate.demo(duration=5.0)
    first = ar.Mahony(rate=100.0).run(rec)
    rows = change.get("rows", 500)
    f = ar.Mahony(rate=100.0, frame=change.get("frame", "ENU"))
    second = f.run(rec.gyr[:rows], rec.acc[:rows], t=rec.t[:rows] + change.get("t", 0.0))
    with pytest.raises(ValueError, match=message):
        ar.chain.relative(first, second)


def test_a_pose_gives_how_the_sensor_is_mounted() -> None:
    rng = np.random.default_rng(1)
    mount = HINGE.mounts[0]
    pose = Rotation.from_rotvec([0.1, 0.2, -1.0])
    shaking = Rotation.from_rotvec(0.01 * rng.normal(size=(2000, 3)))
    found = ar.chain.align_by_pose(quats(pose * mount * shaking), quats(pose))
    # The mean of 2000 errors of 0.01 rad: 4 of its standard deviations.
    assert angle_between(found.quat, quats(mount)) < 4.0 * 0.01 * np.sqrt(3.0 / 2000.0)
    assert found.error == pytest.approx(0.01 * np.sqrt(3.0), rel=0.05)
    first, _ = HINGE.segments(T)
    exact = ar.chain.align_by_pose(quats(pose * mount)[np.newaxis], quats(pose))
    assert angle_between(exact.segment(quats(HINGE.sensors(T)[0])), quats(first)).max() < 1e-14
    with pytest.raises(ValueError, match=r"^quat: expected a pose that is held within 5° \(RMS\), got"):
        ar.chain.align_by_pose(quats(HINGE.sensors(T)[0]))


def test_a_functional_motion_gives_how_the_sensor_is_mounted() -> None:
    # The knee bends, the thigh rests; then the pose in which the shank leans by 0.3 rad.
    bend = Chain("Y", lambda t: np.sin(2.0 * t)[:, np.newaxis], body=lambda t: np.zeros((len(t), 3)))
    rng = np.random.default_rng(2)
    gyr = bend.gyr(T)[1] + 0.02 * rng.normal(size=(len(T), 3))
    mount = bend.mounts[1]
    up = Rotation.from_rotvec([0.0, 0.3, 0.0]).inv().apply([0.0, 0.0, 1.0])
    acc = 9.81 * mount.inv().apply(up) + 0.05 * rng.normal(size=(200, 3))
    found = ar.chain.align_by_motion(gyr, [0.0, 1.0, 0.0], acc, up)
    # 0.02 rad/s beside 1.4 rad/s (RMS) over 500 samples, and 0.05 beside 9.81 m/s² over 200: below 0.001 rad each.
    assert angle_between(found.quat, quats(mount)) < 4e-3
    assert found.error < 2e-3
    axis = ar.chain.functional_axis(gyr)
    assert axis.axis @ bend.axis(1, [0.0, 1.0, 0.0]) == pytest.approx(1.0, abs=1e-5)
    assert axis.share > 0.99
    assert ar.chain.functional_axis(-gyr).axis == pytest.approx(-axis.axis)
    # A wrong belief of the pose shows: the vertical is not where it should be against the axis.
    wrong = Rotation.from_rotvec([0.2, 0.0, 0.0]).apply(up)
    assert ar.chain.align_by_motion(gyr, [0.0, 1.0, 0.0], acc, wrong).error > 0.1


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda c: c.functional_axis(np.zeros((5, 3))), "^gyr: expected a motion, got none"),
        (lambda c: c.functional_axis(np.eye(3)), "^gyr: expected a motion about one axis, got one with 33 %"),
        (lambda c: c.functional_axis(np.zeros(3)), r"^gyr: expected shape \(T, 3\), got \(3,\)"),
        (lambda c: c.align_by_motion([Z], Z, [Z], X), "^acc: expected a vertical that is at least 10° from the axis"),
        (lambda c: c.align_by_motion([Z], Z, [X], Z), "^up: expected a vertical that is at least 10° from the axis"),
        (lambda c: c.align_by_motion([Z], [0.0] * 3, [X], Z), r"^axis: expected a vector \(3,\) that is not zero"),
        (lambda c: c.align_by_pose(np.full((3, 4), np.nan)), "^quat: expected at least one row without NaN"),
        (lambda c: c.relative(np.eye(4), np.eye(4), heading=np.zeros(3)), r"^heading: expected shape \(4,\)"),
        (lambda c: c.relative(np.eye(4), np.eye(4), covariances=(np.eye(3),) * 2), "^covariances: expected shape"),
        (lambda c: c.joint_angle(np.eye(4), [0.0, 0.0, 0.0]), r"^axis: expected a vector \(3,\) that is not zero"),
        (lambda c: c.joint_angle(np.eye(4), [0.0, 0.0, 1.0], zero=np.eye(4)), r"^zero: expected shape \(4,\)"),
        (lambda c: c.Hinge([0.0, 0.0, 1.0]), "^second: expected the axis in the frame of the second sensor, got None"),
        (lambda c: c.Universal([0.0, 0, 1], [1.0, 0, 0], 0.1), "^angle: expected one of 0.35 to"),
        (lambda c: c.Ball(np.zeros((2, 2))), r"^limits: expected shape \(\.\.\., 3, 2\)"),
        (lambda c: c.Ball([[1.0, 0.0]] * 3), r"^limits: expected \(3, 2\) least and largest"),
        (lambda c: c.relative(np.eye(4), np.eye(4), covariances=np.eye(3)), "^covariances: expected a pair, .*, got"),
        (lambda c: c.correct_heading(np.eye(4), np.eye(4), "hinge", rate=1.0), "^joint: expected a Hinge, .*, got 'hi"),
        (lambda c: c.synchronise(SPUN, SPUN, axis=[0.0, 0.0, 1.0]), "^axis: expected a HingeAxis .*, got"),
        (lambda c: c.Ball([[0.0, 1.0]] * 3, first=np.eye(4)), r"^first: expected a quaternion \(4,\), got shape"),
        (lambda c: c.Ball([[0.0, 1.0]] * 3, second=[np.nan] * 4), r"^second: expected a quaternion \(4,\), got"),
        (lambda c: c.Ball([[0.0, 1.0]] * 3, "ZZX"), "^sequence: expected three of"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(ar.chain)
