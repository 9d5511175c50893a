"""A sensor at rest: an aligned estimate stays, a wrong one gets to the truth in the time that the gains give."""

from __future__ import annotations

import numpy as np
import pytest

import ahrs_rs as ar
from cases import Case, each_case, each_case_with
from settling import START
from signals import (
    DIP,
    RATE,
    Floats,
    about_z,
    angle_between,
    inclination_between,
    multiply,
    poses,
    quats,
    rotation,
    still,
    turns_by,
)

#: The 24 attitudes of a cube and as many random ones.
POSES = poses(24, 1)
#: Alignment, and what 1000 samples add to it: the readings are exact to rounding (1e-16), which the angles of the
#: heading amplify by 1/cos dip = 2, and feedback only ever removes. A heading by Euler angles walks, to 1.3e-14.
ROUNDING = 2e-14


def drift(case: Case) -> float:
    """How far (rad) a bias turns that the alignment has taught, in the ten seconds of 1000 samples."""
    return 1000.0 / RATE * case.start_bias


def at_rest(case: Case, samples: int, *, nine: bool, dtype: type = np.float64, **keywords: object) -> Floats:
    """Estimates (48, samples, 4) in all poses at once."""
    sensors = {name: None if v is None else v.astype(dtype) for name, v in still(POSES, samples, nine=nine).items()}
    return case.make(rate=RATE).run(**sensors, **keywords).quat


@each_case
def test_an_aligned_estimate_stays_in_nine_axes(case: Case) -> None:
    quat = at_rest(case, 1000, nine=True)
    assert angle_between(quat, POSES[:, None]).max() < ROUNDING + drift(case)


@each_case
def test_an_aligned_estimate_stays_in_six_axes(case: Case) -> None:
    quat = at_rest(case, 1000, nine=False)
    assert inclination_between(quat, POSES[:, None]).max() < ROUNDING + drift(case)
    # The heading is arbitrary, but it stays too.
    assert angle_between(quat, quat[:, :1]).max() < ROUNDING + drift(case)


@each_case
def test_an_aligned_estimate_stays_in_float32(case: Case) -> None:
    quat = at_rest(case, 1000, nine=True, dtype=np.float32).astype(np.float64)
    # Readings rounded to 6e-8, amplified by 1/cos dip, and 1000 steps of a heading that nothing feeds back, rounded
    # as much: a walk of 2e-6 rad, measured 2.4e-6. The published gradient is five times longer than its part that
    # turns and has sums of fours in it, so that its rounding passes the floor of 1e-6: steps to and fro of 2β dt.
    steps = 2.0 * float(case.params["beta"]) / RATE if case.params.get("gradient") == "paper" else 0.0
    assert angle_between(quat, POSES[:, None]).max() < 1e-5 + steps + drift(case)


@each_case
def test_a_bias_is_not_learnt_at_rest(case: Case) -> None:
    est = case.make(rate=RATE).run(**still(POSES, 1000))
    if est.gyr_bias is not None:
        assert np.abs(est.gyr_bias).max() < ROUNDING + case.start_bias


def settling_poses(count: int = 40) -> tuple[Floats, Floats]:
    """Attitudes, and starts that are turned from them by 0 to 90° (half of them by 90°) about random axes."""
    truth = POSES[:count]
    angles = np.linspace(0.0, 2.0 * START, count).clip(max=START)
    turns = np.concatenate([quats(turns_by(angle, 1, seed)) for seed, angle in enumerate(angles)])
    return truth, multiply(truth, turns)


@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
@each_case_with(lambda case: case.settling is not None)
def test_a_wrong_start_settles_in_the_time_that_the_gains_give(case: Case, nine: bool) -> None:
    assert case.settling is not None
    truth, q0 = settling_poses()
    if nine and case.level_start:
        q0 = multiply(about_z(np.linspace(0.0, 2.0 * START, len(truth)).clip(max=START)), truth)
    time, left = case.settling(DIP if nine else None, 1.0 / RATE)
    # The step of sample 0 is the first one from q0; as much again shows that it stays there.
    settled = int(np.ceil(time * RATE)) + 1
    heading_is_fed_back = nine and case.cls.MAGNETOMETER
    error = angle_between if heading_is_fed_back else inclination_between
    for some in np.split(np.arange(len(truth)), 5):  # all at once fill the memory where filters are slow
        sensors = still(truth[some], 2 * settled, nine=nine)
        quat = case.make(rate=RATE).run(**sensors, q0=q0[some]).quat[:, settled - 1 :]
        assert error(quat, truth[some, None]).max() <= left


@each_case_with(lambda case: case.settling is not None and case.settling(None, 1.0 / RATE)[0] > 0.0)
def test_the_time_to_settle_is_not_generous(case: Case) -> None:
    # In a tenth of it the worst start is still far: the bound is the filter's own time, not a long one.
    assert case.settling is not None
    truth, q0 = settling_poses()
    time, left = case.settling(None, 1.0 / RATE)
    quat = case.make(rate=RATE).run(**still(truth, int(0.1 * time * RATE), nine=False), q0=q0).quat[:, -1]
    assert inclination_between(quat, truth).max() > 10.0 * left


@each_case_with(lambda case: case.settling is None)
def test_a_wrong_start_stays_where_it_is_without_feedback(case: Case) -> None:
    truth, q0 = settling_poses()
    quat = case.make(rate=RATE).run(**still(truth, 500), q0=q0).quat
    assert angle_between(quat, q0[:, None]).max() < ROUNDING


@each_case
def test_six_axes_and_filters_of_six_axes_keep_the_heading_of_the_start(case: Case) -> None:
    # Turned about the vertical alone there is nothing to correct.
    q0 = multiply(about_z(1.0), POSES)
    quat = case.make(rate=RATE).run(**still(POSES, 500, nine=False), q0=q0).quat
    assert angle_between(quat, q0[:, None]).max() < ROUNDING
    if not case.cls.MAGNETOMETER:
        quat = case.make(rate=RATE).run(**still(POSES, 500, nine=True), q0=q0).quat
        assert angle_between(quat, q0[:, None]).max() < ROUNDING


@pytest.mark.parametrize("axis", [0, 1, 2])
@each_case
def test_a_start_at_half_a_turn_stays_finite(case: Case, axis: int) -> None:
    # An unstable equilibrium of every gradient and cross product: nothing but finite numbers can be asked for.
    half_turn = np.eye(4)[1 + axis]
    quat = case.make(rate=RATE).run(**still(POSES, 300), q0=multiply(POSES, half_turn)).quat
    assert np.isfinite(quat).all()


@each_case_with(lambda case: case.bias_left is not None)
def test_a_constant_bias_of_the_gyroscope_is_found(case: Case) -> None:
    assert case.settling is not None
    bias = np.array([0.01, -0.02, 0.015])
    truth = POSES[24:32]
    time, left = case.settling(DIP, 1.0 / RATE)
    # A filter whose attitude is right at once still has to see that the sensor rests: 10 s.
    sensors = still(truth, int(max(2.0 * time, 10.0) * RATE))
    est = case.make(rate=RATE).run(sensors["gyr"] + bias, sensors["acc"], sensors["mag"])
    assert est.gyr_bias is not None
    found = est.gyr_bias[:, -200:].mean(axis=1)
    assert np.abs(found - bias).max() < case.bias_left
    assert angle_between(est.quat[:, -1], truth).max() <= left


def test_alignment_is_the_shortest_turn_to_the_vertical_in_six_axes() -> None:
    turn = rotation(ar.Tilt(rate=RATE).run(**still(POSES, 1, nine=False)).quat[:, 0])
    up = rotation(POSES).inv().apply([0.0, 0.0, 1.0])
    angle = np.arctan2(np.hypot(up[:, 0], up[:, 1]), up[:, 2])
    # From exactly upside down every half turn about a horizontal axis is a shortest one.
    assert np.abs(turn.magnitude() - angle).max() < ROUNDING
    assert np.abs(turn.as_rotvec()[:, 2]).max() < ROUNDING


def test_alignment_puts_the_horizontal_field_on_north_in_nine_axes() -> None:
    sensors = still(POSES, 1)
    quat = ar.Ecompass(rate=RATE).run(**sensors).quat[:, 0]
    field = rotation(quat).apply(sensors["mag"][:, 0])
    assert np.abs(field[:, 0]).max() < 50.0 * ROUNDING
    assert field[:, 1].min() > 0.0
