"""Without a magnetometer the heading of the start is zero in the chosen frame."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from cases import STREAMING, each_filter
from signals import GRAVITY, RATE, Floats, angle_between, conjugate, motion, multiply, quats, rotation

#: Which way gravity's counterforce points in each frame.
UP = {"ENU": 1.0, "NWU": 1.0, "NED": -1.0}
each_frame = pytest.mark.parametrize("frame", list(UP))
#: Filters that an accelerometer inclines at once.
INCLINED = [name for name in ar.FILTERS if ar.FILTERS[name].FEEDBACK]


def rounding(name: str) -> float:
    """What the first attitude may be off by, rad; the filters of OfflineVQF, which go to and fro, leave 1e-7."""
    return 1e-12 if ar.FILTERS[name].STREAMING else 1e-6


def first(name: str, frame: str, acc: Floats) -> Floats:
    """The attitudes (N, 4) at the first sample of sensors that rest, with these forces (N, 3)."""
    rows = np.repeat(acc[:, None], 30, axis=1)
    est = ar.FILTERS[name](rate=RATE, frame=frame).run(np.zeros_like(rows), rows)
    return np.asarray(est.quat[:, 0])


def forces(frame: str, tilt: float, count: int = 24) -> Floats:
    """Forces (count, 3) of sensors that are tilted from the frame's level pose by an angle in rad, to all sides."""
    around = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    side = np.sin(tilt) * np.stack((np.cos(around), np.sin(around)), axis=1)
    return GRAVITY * np.concatenate((side, np.full((count, 1), UP[frame] * np.cos(tilt))), axis=1)


@each_frame
@each_filter
def test_a_level_sensor_starts_with_roll_pitch_and_yaw_zero(name: str, frame: str) -> None:
    q = first(name, frame, forces(frame, 0.0))
    assert angle_between(q, [1.0, 0.0, 0.0, 0.0]).max() < rounding(name)


@pytest.mark.parametrize("tilt", [1e-9, 1e-3, 0.3, 1.0, 1.5])
@each_frame
@pytest.mark.parametrize("name", INCLINED)
def test_a_tilted_sensor_starts_by_the_shortest_turn_from_level(name: str, frame: str, tilt: float) -> None:
    # The shortest turn has a level axis: nothing about the vertical.
    q = first(name, frame, forces(frame, tilt))
    assert np.abs(q[:, 3]).max() < rounding(name)
    assert angle_between(q, [1.0, 0.0, 0.0, 0.0]) == pytest.approx(tilt, abs=max(1e-8, rounding(name)))
    up = rotation(q).apply(forces(frame, tilt)) / GRAVITY
    assert np.abs(up - [0.0, 0.0, UP[frame]]).max() < rounding(name)


@pytest.mark.parametrize("axis", [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8]], ids=str)
@each_frame
@pytest.mark.parametrize("name", INCLINED)
def test_the_start_is_continuous_in_the_tilt_up_to_ninety_degrees(name: str, frame: str, axis: list[float]) -> None:
    tilts = np.linspace(-0.499 * np.pi, 0.499 * np.pi, 400)
    acc = np.outer(np.sin(tilts), [*axis, 0.0]) + np.outer(np.cos(tilts), [0.0, 0.0, UP[frame]])
    q = first(name, frame, GRAVITY * acc)
    steps = angle_between(q[:-1], q[1:])
    # A turn about one level axis: each step is that of the tilt.
    assert steps == pytest.approx(np.diff(tilts), abs=max(1e-8, rounding(name)))


@pytest.mark.parametrize("tilt", [0.0, 0.2, 1.2])
@pytest.mark.parametrize("name", INCLINED)
def test_in_ned_a_sensor_whose_z_points_up_starts_from_its_back(name: str, tilt: float) -> None:
    # Roll 180°, yaw 0, and from there the shortest turn.
    q = first(name, "NED", forces("ENU", tilt))
    turn = multiply(q, [0.0, -1.0, 0.0, 0.0])
    assert np.abs(turn[:, 3]).max() < rounding(name)
    assert angle_between(q, [0.0, 1.0, 0.0, 0.0]) == pytest.approx(tilt, abs=max(1e-8, rounding(name)))


@each_frame
@pytest.mark.parametrize("name", STREAMING)
def test_before_the_first_force_the_attitude_is_the_identity_of_the_frame(name: str, frame: str) -> None:
    f = ar.FILTERS[name](rate=RATE, frame=frame)
    assert np.array_equal(f.quat, [1.0, 0.0, 0.0, 0.0])
    # Computed in east-north-up and turned to the frame: by a product that rounds, of a quaternion that is rounded.
    assert np.abs(f.run(np.zeros((3, 3))).quat - [1.0, 0.0, 0.0, 0.0]).max() < 4.0 * np.finfo(np.float64).eps
    # The heading that is turned meanwhile stays: 0.1 rad about the vertical of the frame.
    turn = np.array([[0.0, 0.0, 0.1 * RATE]])
    assert angle_between(f.run(np.zeros((1, 3)), q0=[1.0, 0.0, 0.0, 0.0]).quat[0], [1.0, 0.0, 0.0, 0.0]) < rounding(
        name
    )
    moved = f.run(np.concatenate((np.zeros((1, 3)), turn)), t=[0.0, 0.01]).quat[-1]
    # A first-order step of 0.1 rad is short by (0.1)³/12; EKF takes the rate from its own, to a hundredth.
    assert angle_between(moved, quats(Rotation.from_euler("z", 0.1))) < 1e-3


@each_frame
@pytest.mark.parametrize("name", STREAMING)
def test_six_axes_in_two_frames_differ_by_one_turn_of_the_frame_and_one_about_the_vertical(
    name: str, frame: str
) -> None:
    signals = motion(300, 1, level=True)
    enu, other = (
        ar.FILTERS[name](rate=RATE, frame=one).run(*signals.sensors(nine=False)).quat for one in ("ENU", frame)
    )
    between = multiply(other, conjugate(enu))
    # The same turn for all samples, but for rounding, which steps of Euler rates and a Kalman filter's gain amplify.
    assert angle_between(between, between[:1]).max() < 1e-9
    # Of the frame: which takes ENU's up to the frame's; beside that nothing but a turn about the vertical.
    assert rotation(between[0]).apply([0.0, 0.0, 1.0]) == pytest.approx([0.0, 0.0, UP[frame]], abs=1e-9)


@each_frame
@pytest.mark.parametrize("name", STREAMING)
def test_the_start_is_the_same_in_a_stream(name: str, frame: str) -> None:
    signals = motion(5, 2)
    f = ar.FILTERS[name](rate=RATE, frame=frame)
    stream = [f.update(gyr, acc).copy() for gyr, acc in zip(signals.gyr, signals.acc, strict=True)]
    assert np.array_equal(f.run(signals.gyr, signals.acc).quat, np.array(stream))


@each_frame
@pytest.mark.parametrize("name", [name for name in STREAMING if ar.FILTERS[name].MAGNETOMETER])
def test_with_a_magnetometer_two_frames_differ_by_the_frame_alone(name: str, frame: str) -> None:
    signals = motion(300, 3, level=True)
    enu, other = (ar.FILTERS[name](rate=RATE, frame=one).run(*signals.sensors()).quat for one in ("ENU", frame))
    frames = {
        "ENU": [1.0, 0.0, 0.0, 0.0],
        "NWU": [0.5**0.5, 0.0, 0.0, -(0.5**0.5)],
        "NED": [0.0, 0.5**0.5, 0.5**0.5, 0.0],
    }
    # The computation is that in east-north-up; turning the output rounds once.
    assert angle_between(other, multiply(frames[frame], enu)).max() < 1e-14
