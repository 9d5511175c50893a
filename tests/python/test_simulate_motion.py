"""Laws of motions: each quantity is the exact derivative of the one before."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from ahrs_rs import simulate
from ahrs_rs.simulate import Compound, EulerMotion, PacedMotion, Piecewise, SplineMotion, ThrustMotion, Waves

#: For numeric derivatives, s: truncation h² and rounding 1e-16/h² are both small.
H = 1e-4
#: Every scenario as it is, and those whose parameters choose another motion.
SCENARIOS: dict[str, dict[str, Any]] = {
    **{name: {} for name in simulate.SCENARIOS},
    "walking foot": {"place": "foot"},
    "back_and_forth banked": {"bank": 0.26},
}
EVERY_SCENARIO = pytest.mark.parametrize("name", SCENARIOS)


@cache
def motion_of(name: str) -> tuple[simulate.Motion, float]:
    setup = simulate.SCENARIOS[name.split()[0]].setup(seed=5, **SCENARIOS[name])
    return setup.motion, min(setup.duration, 60.0)


def rotation(quat: np.ndarray) -> Rotation:
    return Rotation.from_quat(quat, scalar_first=True)


def times(duration: float, count: int = 500) -> np.ndarray:
    return np.random.default_rng(7).uniform(0.01, duration - 0.01, count)


def waves(seed: int, columns: int = 3) -> Waves:
    draw = np.random.default_rng(seed)
    return Waves(*(draw.uniform(0.2, 1.5, (2, columns)) for _ in range(3)))


MOTIONS = {
    "euler": EulerMotion(waves(1), waves(2)),
    "lever": EulerMotion(waves(1), waves(2), lever=(0.3, -0.2, 0.5)),
    "thrust": ThrustMotion(waves(3), waves(4, 1)),
    "spline": SplineMotion.through(
        Rotation.from_rotvec(np.random.default_rng(3).uniform(-0.8, 0.8, (8, 3))).as_quat(scalar_first=True), 1.3
    ),
    "paced": PacedMotion(EulerMotion(waves(1), waves(2)), simulate.moves([0.0], [(4.0, [3.0]), (4.0, [1.0])])),
    "compound": Compound(EulerMotion(waves(1), waves(2)), EulerMotion(waves(5), waves(6))),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_each_motion_is_differentiated_exactly(name: str) -> None:
    check_derivatives(MOTIONS[name], 8.0)


@EVERY_SCENARIO
def test_each_scenario_is_differentiated_exactly(name: str) -> None:
    check_derivatives(*motion_of(name))


def check_derivatives(motion: simulate.Motion, duration: float) -> None:
    t = times(duration)
    back, forth = rotation(motion.orientation(t - H)), rotation(motion.orientation(t + H))
    before, here, after = (motion.position(t + k * H) for k in (-1, 0, 1))
    measured = {
        "angular_rate": (back.inv() * forth).as_rotvec() / (2 * H),
        "velocity": (after - before) / (2 * H),
        "acceleration": (after - 2 * here + before) / H**2,
    }
    for name, found in measured.items():
        exact = getattr(motion, name)(t)
        # Differences of positions up to 1e2 m have roundings of 1e-14, divided by h² for the acceleration; of
        # smooth functions they err by h²/6 times the second next derivative: for waves of 2700 rad/s (three
        # times the rotors' 900) by (2700 h)²/6 = 1.2 % of the vibration, and below 1e-4 of everything else.
        # A spline's acceleration has kinks: where one lies within h, it errs by the jerk (below 300 m/s³) times h.
        size = np.abs(exact).max() + 1e-3
        rounding = 4e-14 * (1.0 + np.abs(here).max()) / H**2
        assert np.abs(found - exact).max() < 0.02 * size + rounding, name
        assert np.median(np.abs(found - exact)) < 4e-3 * size + rounding, name


@EVERY_SCENARIO
def test_angular_rate_and_acceleration_are_continuous(name: str) -> None:
    motion, duration = motion_of(name)
    t = np.arange(0.0, duration, 1e-3)
    for quantity in (motion.angular_rate, motion.acceleration):
        value = quantity(t)
        # A jump would be as large over a tenth of the step; what is smooth shrinks with it.
        worst = int(np.abs(np.diff(value, axis=0)).max(axis=1).argmax())
        fine = quantity(np.linspace(t[worst], t[worst + 1], 11))
        whole = np.abs(value[worst + 1] - value[worst]).max()
        assert np.abs(np.diff(fine, axis=0)).max() < 0.35 * whole + 1e-9


@EVERY_SCENARIO
def test_orientation_is_unit_at_every_time(name: str) -> None:
    motion, duration = motion_of(name)
    quat = motion.orientation(np.linspace(-1.0, duration + 1.0, 3001))
    # Products of up to four unit quaternions: some ten roundings.
    assert np.abs(np.linalg.norm(quat, axis=1) - 1.0).max() < 3e-15


def test_thrust_is_along_the_z_axis() -> None:
    motion, t = MOTIONS["thrust"], times(8.0)
    force = rotation(motion.orientation(t)).inv().apply(motion.acceleration(t) + np.array([0.0, 0.0, simulate.GRAVITY]))
    assert np.abs(force[:, :2]).max() < 1e-13  # a rotation of 10 m/s²
    assert force[:, 2].min() > 0.0


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.integers(2, 12), st.floats(0.01, 100.0))
def test_a_quaternion_spline_goes_through_its_way_points_and_rests_at_its_ends(
    seed: int, count: int, interval: float
) -> None:
    draw = np.random.default_rng(seed)
    steps = Rotation.from_rotvec(draw.uniform(-0.5, 0.5, (count, 3)))
    points, at = [], Rotation.identity()
    for step in steps:
        at = at * step
        points.append(at.as_quat(scalar_first=True))
    spline = SplineMotion.through(np.array(points) * draw.choice([-1.0, 1.0], (count, 1)), interval)
    knots = interval * np.arange(count)
    # The iteration that finds the control points halves the error 80 times; what is left is rounding.
    assert (rotation(spline.orientation(knots)).inv() * rotation(np.array(points))).magnitude().max() < 1e-13
    ends = np.array([-1.0, -1e-9, 0.0, knots[-1], knots[-1] + 1.0])
    assert np.abs(spline.angular_rate(ends)).max() * interval < 1e-7
    fine = spline.orientation(np.linspace(-1.0, knots[-1] + 1.0, 2001))
    assert (fine[1:] * fine[:-1]).sum(axis=1).min() > 0.0  # no jump from q to -q


def test_a_quaternion_spline_is_close_to_scipys_between_the_way_points() -> None:
    # Both are C² and go through the same points; they differ by their ends and by what "cubic" means on the sphere.
    angles = 0.3 * np.sin(np.linspace(0.0, 6.0, 25)[:, None] + [0.0, 1.0, 2.0])
    given = Rotation.from_rotvec(angles)
    ours = SplineMotion.through(given.as_quat(scalar_first=True), 0.25)
    theirs = RotationSpline(np.linspace(0.0, 6.0, 25), given)
    t = np.linspace(1.5, 4.5, 500)
    assert (rotation(ours.orientation(t)).inv() * theirs(t)).magnitude().max() < 1e-4
    assert np.abs(ours.angular_rate(t) - theirs(t, 1)).max() < 2e-3


def test_a_spline_of_positions_is_scipys_clamped_one() -> None:
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (9, 3))
    ours = simulate.spline(points, 0.5, begin=2.0)
    theirs = CubicSpline(2.0 + 0.5 * np.arange(9), points, bc_type="clamped")
    t = np.linspace(2.0, 5.999, 400)
    for order in range(4):
        # The iteration ends at rounding, which each derivative divides by the interval.
        assert np.abs(ours.derivative(t, order) - theirs(t, order)).max() < 1e-12


@given(st.integers(0, 4), st.floats(0.05, 0.5), st.floats(0.1, 50.0))
def test_a_move_has_its_mean_speed_and_ends_at_rest(smoothness: int, ramp: float, duration: float) -> None:
    move = simulate.moves([1.0, 2.0], [(duration, [3.0, 2.0])], ramp=ramp, smoothness=smoothness, begin=4.0)
    assert move.derivative(np.array([0.0, 4.0]), 0).tolist() == [[1.0, 2.0], [1.0, 2.0]]
    assert np.allclose(move.derivative(np.array([4.0 + duration, 1e6]), 0), [3.0, 2.0], rtol=1e-13)
    largest = move.derivative(4.0 + duration * np.linspace(0.0, 1.0, 1001), 1).max()
    assert largest * (1.0 - ramp) * duration == pytest.approx(2.0, rel=1e-9)
    inside = np.array([4.0 + 1e-12, 4.0 + duration * (1.0 - 1e-12)])
    assert np.abs(move.derivative(inside, 1)).max() < 1e-6 / duration


def test_a_periodic_function_goes_on_from_where_it_has_ended() -> None:
    stair = simulate.moves([0.0], [(1.0, [1.0]), (1.0, [1.0])], periodic=True)
    t = np.array([-2.5, 0.5, 1.5, 3.5, 21.5])
    assert stair.derivative(t, 0)[:, 0] == pytest.approx([-1.0 + 0.0, 0.5, 1.0, 2.0, 11.0])
    assert stair.derivative(t + 40.0, 2) == pytest.approx(stair.derivative(t, 2))


def test_pulses_have_the_stated_height_and_peak() -> None:
    pulses = simulate.bumps(0.2, 0.1, 1.0, [0.0, 2.0])
    assert isinstance(pulses, Piecewise)
    assert pulses.derivative(np.array([3.25]), 0)[0] == pytest.approx([0.0, 2.0])
    assert pulses.derivative(np.array([3.25]), 2)[0] == pytest.approx([0.0, -32.0 * 2.0 / 0.1**2])
    assert np.abs(pulses.derivative(np.array([0.1, 0.5, 1.1]), 0)).max() == 0.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: simulate.moves([0.0], [(0.0, [1.0])]), "steps: expected positive durations, got 0.0"),
        (lambda: simulate.moves([0.0], [(1.0, [1.0])], ramp=0.6), "ramp: expected a number above 0"),
        (lambda: simulate.spline([[0.0]], 1.0), "points: expected at least two, got 1"),
        (lambda: SplineMotion.through([[1.0, 0.0, 0.0, 0.0]], 1.0), "orientations: expected shape"),
        (lambda: SplineMotion.through([[0.0] * 4] * 3, 1.0), "orientations: expected finite quaternions"),
        (lambda: SplineMotion.through(np.eye(4), 1.0), "orientations: the turns between way points are too large"),
        (lambda: SplineMotion.through(np.ones((3, 4)), -1.0), "interval: expected a positive number of s"),
    ],
)
def test_impossible_motions_are_refused(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()  # type: ignore[operator]
