"""What holds for the output of every filter whatever it is given: norm, sign, frames, symmetries."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from cases import CASES, ROUNDING, Case, each_case, each_case_with
from signals import (
    FIELD,
    GRAVITY,
    RATE,
    UP,
    Floats,
    about_z,
    angle_between,
    conjugate,
    gappy,
    inclination_between,
    motion,
    multiply,
    quats,
    random_turns,
    rotation,
    turns_by,
)

SAMPLES = 3000
#: The frame's quaternion and one product round a few times: four ulp of 1.
ONE_PRODUCT = 4.0 * np.finfo(np.float64).eps

HALF = np.sqrt(0.5)
#: output = c ⊗ (output in ENU): the axes of the frame are named by what x, y and z of the vectors stand for.
FROM_ENU = {"ENU": [1.0, 0.0, 0.0, 0.0], "NED": [0.0, HALF, HALF, 0.0], "NWU": [HALF, 0.0, 0.0, -HALF]}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@each_case
def test_the_norm_is_one_to_a_few_ulp(case: Case, dtype: type) -> None:
    signals = gappy(motion(SAMPLES, 1, jitter=True), 2).astype(dtype)
    for nine in (True, False):
        quat = case.make(rate=RATE, frame="NED", declination=0.2).run(*signals.sensors(nine=nine)).quat
        norm = np.linalg.norm(quat.astype(np.float64), axis=1)
        # Three products of rounded unit quaternions, one eps each; measured 2.4.
        assert np.abs(norm - 1.0).max() <= 4.0 * np.finfo(dtype).eps


@each_case
def test_the_sign_begins_with_w_not_negative_and_never_jumps(case: Case) -> None:
    signals = motion(SAMPLES, 3)
    for frame in FROM_ENU:
        quat = case.make(rate=RATE, frame=frame).run(*signals.sensors()).quat
        assert quat[0, 0] >= 0.0
        assert np.sum(quat[1:] * quat[:-1], axis=1).min() >= 0.0
        if frame == "ENU":
            assert quat[:, 0].min() < -0.5, "the motion does not turn far enough to show a jump"


def test_the_sign_of_q0_is_of_no_consequence() -> None:
    signals = motion(100, 3)
    for case in CASES:
        f = case.make(rate=RATE)
        runs = [f.run(*signals.sensors(), q0=sign * signals.before).quat for sign in (1.0, -1.0)]
        assert np.abs(runs[0] - runs[1]).max() < case.agreement, case.label


@pytest.mark.parametrize("frame", ["NED", "NWU"])
@each_case
def test_frames_differ_by_the_constant_rotation_of_their_axes(case: Case, frame: str) -> None:
    # Until the first readings the attitude is the identity of the frame, so that two frames get to the same attitude by
    # two ways: from then on they differ by rounding. (The first rows have a force and a field.)
    signals = gappy(motion(SAMPLES, 4, level=case.euler_rates), 5)
    enu = case.make(rate=RATE).run(*signals.sensors())
    other = case.make(rate=RATE, frame=frame).run(*signals.sensors())
    # Down is another way, of another length: VQF learns another bias from it, and turns by it until it is forgotten.
    learnt = 2.0 * case.start_bias * SAMPLES / RATE if frame == "NED" else 0.0
    assert angle_between(multiply(FROM_ENU[frame], enu.quat), other.quat).max() < case.agreement + learnt
    assert np.array_equal(enu.status, other.status)


@pytest.mark.parametrize(("frame", "down"), [("ENU", False), ("NWU", False), ("NED", True)])
@each_case
def test_declination_turns_by_minus_d_about_up_and_plus_d_about_down(case: Case, frame: str, down: bool) -> None:
    declination = 0.3
    signals = gappy(motion(SAMPLES, 6), 7)
    magnetic = case.make(rate=RATE, frame=frame).run(*signals.sensors())
    true = case.make(rate=RATE, frame=frame, declination=declination).run(*signals.sensors())
    turn = about_z(declination if down else -declination)
    # The first rows come before the first magnetometer sample, where no north is known.
    known = np.cumsum(np.isfinite(signals.mag[:, 0])) > 0
    assert angle_between(multiply(turn, magnetic.quat), true.quat)[known].max() < ONE_PRODUCT
    assert angle_between(magnetic.quat, true.quat)[~known].max(initial=0.0) < ONE_PRODUCT


@each_case
def test_declination_means_nothing_without_a_magnetometer(case: Case) -> None:
    signals = motion(300, 6)
    plain, turned = (case.make(rate=RATE, declination=d).run(*signals.sensors(nine=False)).quat for d in (0.0, 0.3))
    assert np.array_equal(plain, turned)


@pytest.mark.parametrize("frame", ["NED", "NWU"])
@each_case
def test_q0_is_given_in_the_frame_of_the_output(case: Case, frame: str) -> None:
    signals = motion(SAMPLES, 8, level=case.euler_rates)
    enu = case.make(rate=RATE, declination=0.2).run(*signals.sensors(), q0=signals.before)
    q0 = multiply(FROM_ENU[frame], signals.before)
    other = case.make(rate=RATE, declination=0.2, frame=frame).run(*signals.sensors(), q0=q0)
    assert angle_between(multiply(FROM_ENU[frame], enu.quat), other.quat).max() < case.agreement


@each_case
def test_q0_is_from_true_north(case: Case) -> None:
    # q0 is a rotation of the ENU attitude of magnetic north by -D, as the output is.
    signals = motion(SAMPLES, 9, level=case.euler_rates)
    declination = 0.25
    magnetic = case.make(rate=RATE).run(*signals.sensors(), q0=signals.before)
    q0 = multiply(about_z(-declination), signals.before)
    true = case.make(rate=RATE, declination=declination).run(*signals.sensors(), q0=q0)
    assert angle_between(multiply(about_z(-declination), magnetic.quat), true.quat).max() < case.agreement


def turned_runs(case: Case, mounting: Rotation, *, nine: bool, with_q0: bool) -> tuple[Floats, Floats]:
    """q ⊗ r* of the sensor as it is, and the attitudes of the sensor turned by r."""
    signals = gappy(motion(SAMPLES, 10, level=case.euler_rates), 11)
    turned = signals.turned(mounting)
    f = case.make(rate=RATE)
    as_is = f.run(*signals.sensors(nine=nine), q0=signals.before if with_q0 else None)
    other = f.run(*turned.sensors(nine=nine), q0=turned.before if with_q0 else None)
    return multiply(as_is.quat, quats(mounting.inv())), other.quat


@pytest.mark.parametrize("seed", range(3))
@each_case
def test_a_turned_sensor_gives_the_attitude_that_the_registry_claims(case: Case, seed: int) -> None:
    mounting = random_turns(1, seed)[0]
    if case.law == "exact":
        for nine, with_q0 in ((True, False), (True, True), (False, True)):
            expected, found = turned_runs(case, mounting, nine=nine, with_q0=with_q0)
            # Before the first magnetometer sample the heading is arbitrary.
            assert angle_between(expected, found)[20:].max() < case.agreement
    if case.law in ("exact", "heading"):
        expected, found = turned_runs(case, mounting, nine=False, with_q0=False)
        between = multiply(found, conjugate(expected))
        # The same for all samples, and about the vertical: from the first valid accelerometer sample on.
        assert angle_between(between[20:], between[20]).max() < case.agreement
        assert inclination_between(found, expected)[20:].max() < case.agreement
    if case.law == "no":
        runs = (turned_runs(case, mounting, nine=True, with_q0=with_q0) for with_q0 in (True, False))
        off = max(angle_between(expected, found)[20:].max() for expected, found in runs)
        assert off > 1e-4, "the law holds: the registry may claim it"


@each_case
def test_a_start_turned_about_the_vertical_turns_every_six_axis_output(case: Case) -> None:
    signals = gappy(motion(SAMPLES, 12, level=case.euler_rates), 13)
    f = case.make(rate=RATE)
    plain = f.run(*signals.sensors(nine=False), q0=signals.before).quat
    turned = f.run(*signals.sensors(nine=False), q0=multiply(about_z(1.1), signals.before)).quat
    assert angle_between(multiply(about_z(1.1), plain), turned).max() < case.agreement


@pytest.mark.parametrize("angle", [-2.5, 0.4, 3.0])
@each_case_with(lambda case: not case.own_rate)
def test_turning_the_earth_about_the_vertical_turns_the_heading(case: Case, angle: float) -> None:
    # The field of a turned earth is known in the sensor's frame only where the estimate is the truth. So there
    # is no noise, and the directions are those one step before: what feedback compares them with is that attitude.
    # A Kalman filter and VQF compare them with the attitude after the turn. (One with a rate of its own is late.)
    signals = motion(SAMPLES, 14, noise=0.0, level=True)
    before = np.concatenate(([signals.before], signals.truth[:-1]))
    back = rotation(signals.truth if case.kalman or case.starts_itself else before).inv()
    turn = Rotation.from_rotvec([0.0, 0.0, angle])
    f = case.make(rate=RATE)
    gyr, acc = signals.gyr, back.apply(UP)
    if case.make().params.get("integration") == "first-order":
        # Its step turns by 2 atan(ω dt/2): the rate whose step is the true one.
        half = 0.5 * np.linalg.norm(gyr, axis=1, keepdims=True) / RATE
        gyr = gyr * np.tan(half) / half
    plain = f.run(gyr, acc, back.apply(FIELD), q0=signals.before).quat
    q0 = multiply(quats(turn), signals.before)
    turned = f.run(gyr, acc, back.apply(turn.inv().apply(FIELD)), q0=q0).quat
    error = angle_between(multiply(quats(turn), plain), turned)
    # Madgwick steps to and fro by 2β dt at the bottom, in directions that rounding chooses.
    steps = 0.0 if case.name != "Madgwick" else 2.0 * 2.0 * float(case.make().params["beta"]) / RATE
    assert error.max() < case.agreement + steps


@pytest.mark.filterwarnings("ignore:acc. a median norm:ahrs_rs.DataWarning")  # a force in units of g is doubted
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@each_case
def test_scales_of_magnetometer_and_accelerometer_mean_nothing(case: Case, dtype: type) -> None:
    signals = gappy(motion(SAMPLES, 15, level=case.euler_rates), 16).astype(dtype)
    f = case.make(rate=RATE)
    plain = f.run(*signals.sensors()).quat
    # A power of two changes only exponents.
    acc_scale = 1.0 if case.acc_length else 0.25
    powers = f.run(signals.gyr, signals.acc * dtype(acc_scale), signals.mag * dtype(1024.0)).quat
    assert np.array_equal(plain, powers)
    if dtype is np.float64:
        acc_scale = 1.0 if case.acc_length else 1.0 / GRAVITY
        scaled = f.run(signals.gyr, signals.acc * acc_scale, signals.mag * 0.07).quat
        assert angle_between(plain, scaled).max() < case.agreement


def test_a_mounting_by_half_a_turn_about_z_swaps_signs_and_nothing_else() -> None:
    # Exact in floating point: x and y of every vector change sign, so that no rounding differs.
    signals = motion(500, 17)
    flip = np.array([-1.0, -1.0, 1.0])
    for name in ("GyroIntegration", "Mahony", "Madgwick"):
        f = ar.FILTERS[name](rate=RATE)
        plain = f.run(*signals.sensors(), q0=[1.0, 0.0, 0.0, 0.0]).quat
        turned = f.run(*(array * flip for array in signals.sensors()), q0=[0.0, 0.0, 0.0, 1.0]).quat
        assert angle_between(multiply(plain, [0.0, 0.0, 0.0, -1.0]), turned).max() < ROUNDING, name


def test_small_turns_of_the_sensor_are_small_turns_of_the_attitude() -> None:
    # The law in its differential form: no branch of a filter jumps where the axes move a little.
    signals = motion(500, 18)
    mounting = turns_by(1e-6, 1, 19)[0]
    for case in CASES:
        if case.law == "exact":
            f = case.make(rate=RATE)
            plain, turned = f.run(*signals.sensors()).quat, f.run(*signals.turned(mounting).sensors()).quat
            # 1e-6 rad, as exactly as rounding allows.
            assert np.abs(angle_between(plain, turned) - 1e-6).max() < case.agreement, case.label
