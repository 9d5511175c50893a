"""Laws of the scores: BROAD's definitions, Huynh's distances, Euler angles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ahrs_rs import metrics

FloatArray = NDArray[np.float64]

#: A few roundings of numbers of size 1 to 2π: products of unit quaternions, atan2, wrapping.
ROUNDING = 1e-14

angles = st.floats(-math.pi, math.pi)
component = st.floats(-1.0, 1.0)


@st.composite
def unit_quats(draw: st.DrawFn) -> FloatArray:
    quat = np.array(draw(st.tuples(component, component, component, component)))
    norm = np.linalg.norm(quat)
    assume(norm > 1e-3)
    unit: FloatArray = quat / norm
    return unit


def random_quats(count: int, seed: int = 0) -> FloatArray:
    quat = np.random.default_rng(seed).standard_normal((count, 4))
    unit: FloatArray = quat / np.linalg.norm(quat, axis=1, keepdims=True)
    return unit


def from_axis(axis: tuple[float, float, float], angle: float) -> FloatArray:
    direction = np.array(axis) / np.linalg.norm(axis)
    return np.concatenate(([np.cos(angle / 2)], np.sin(angle / 2) * direction))


def product(p: FloatArray, q: FloatArray) -> FloatArray:
    turned = Rotation.from_quat(p, scalar_first=True) * Rotation.from_quat(q, scalar_first=True)
    return np.asarray(turned.as_quat(scalar_first=True))


def test_error_quat_times_reference_is_the_estimate() -> None:
    est, ref = random_quats(100), random_quats(100, 1)
    back = product(metrics.error_quat(est, ref), ref)
    assert np.abs(np.abs((back * est).sum(axis=1)) - 1).max() < ROUNDING


def test_errors_equal_the_formulas_of_broad() -> None:
    est, ref = random_quats(1000), random_quats(1000, 1)
    w, _, _, z = metrics.error_quat(est, ref).T
    # The published forms lose digits near 0 and π; random orientations stay far enough away for 1e-10.
    assert np.allclose(metrics.total_error(est, ref), 2 * np.arccos(np.abs(w)), atol=1e-10, rtol=0)
    assert np.allclose(metrics.heading_error(est, ref), 2 * np.arctan(np.abs(z / w)), atol=1e-10, rtol=0)
    inclination = 2 * np.arccos(np.sqrt(w**2 + z**2))
    assert np.allclose(metrics.inclination_error(est, ref), inclination, atol=1e-10, rtol=0)


@given(unit_quats(), st.floats(1e-12, math.pi))
def test_turn_about_the_vertical_is_heading_error_only(ref: FloatArray, angle: float) -> None:
    est = product(from_axis((0, 0, 1), angle), ref)
    assert metrics.heading_error(est, ref) == pytest.approx(angle, abs=ROUNDING)
    assert metrics.total_error(est, ref) == pytest.approx(angle, abs=ROUNDING)
    assert metrics.inclination_error(est, ref) == pytest.approx(0.0, abs=ROUNDING)


@given(unit_quats(), st.floats(1e-12, math.pi - 1e-3), angles)
def test_turn_about_a_horizontal_axis_is_inclination_error_only(
    ref: FloatArray, angle: float, direction: float
) -> None:
    est = product(from_axis((math.cos(direction), math.sin(direction), 0), angle), ref)
    assert metrics.inclination_error(est, ref) == pytest.approx(angle, abs=ROUNDING)
    # The heading is that of a vector of length cos(angle/2) >= 5e-4: rounding grows by its inverse.
    assert metrics.heading_error(est, ref) == pytest.approx(0.0, abs=ROUNDING / math.cos(angle / 2))


def test_small_errors_keep_their_digits() -> None:
    for angle in (1e-9, 1e-7, 1e-5):
        error = metrics.total_error(from_axis((1, 2, 3), angle), [1.0, 0.0, 0.0, 0.0])
        assert error == pytest.approx(angle, rel=1e-15 / angle + 1e-14)


@given(unit_quats(), unit_quats())
def test_total_error_bounds_heading_and_inclination(est: FloatArray, ref: FloatArray) -> None:
    total = metrics.total_error(est, ref)
    assert metrics.heading_error(est, ref) <= total + ROUNDING
    assert metrics.inclination_error(est, ref) <= total + ROUNDING


@given(unit_quats(), unit_quats())
def test_metrics_do_not_depend_on_the_sign_of_a_quaternion(est: FloatArray, ref: FloatArray) -> None:
    for metric in (
        metrics.total_error,
        metrics.heading_error,
        metrics.inclination_error,
        metrics.chordal_distance,
        metrics.inner_product_distance,
    ):
        assert metric(-est, ref) == pytest.approx(metric(est, ref), abs=ROUNDING)


@given(unit_quats(), unit_quats(), unit_quats())
def test_distances_are_metrics_that_rotations_leave_alone(p: FloatArray, q: FloatArray, r: FloatArray) -> None:
    for distance in (metrics.geodesic_distance, metrics.chordal_distance):
        d = float(distance(p, q))
        assert d >= 0
        assert distance(p, p) == pytest.approx(0.0, abs=ROUNDING)
        assert distance(q, p) == pytest.approx(d, abs=ROUNDING)
        assert distance(product(r, p), product(r, q)) == pytest.approx(d, abs=ROUNDING)
        assert d <= distance(p, r) + distance(r, q) + ROUNDING


@given(unit_quats(), unit_quats())
def test_distances_are_functions_of_the_angle(p: FloatArray, q: FloatArray) -> None:
    # Huynh 2009: chord 2 sin(θ/4), inner product 1 - cos(θ/2).
    angle = float(metrics.geodesic_distance(p, q))
    assert metrics.chordal_distance(p, q) == pytest.approx(2 * math.sin(angle / 4), abs=ROUNDING)
    assert metrics.inner_product_distance(p, q) == pytest.approx(1 - math.cos(angle / 2), abs=ROUNDING)


def test_rmse_is_the_root_of_the_mean_square_of_the_masked_values() -> None:
    error = np.array([3.0, 100.0, 4.0, np.nan])
    assert metrics.rmse(error, np.array([True, False, True, True])) == math.sqrt(12.5)
    assert metrics.rmse(error[:3]) == pytest.approx(math.sqrt((9 + 1e4 + 16) / 3), rel=1e-15)


def test_rmse_of_nothing_is_nan_without_a_warning() -> None:
    assert math.isnan(metrics.rmse([np.nan, np.nan]))
    assert math.isnan(metrics.rmse([1.0, 2.0], np.array([False, False])))
    assert math.isnan(metrics.rmse([]))


def test_score_of_many_recordings_equals_the_scores_of_each() -> None:
    est, ref = random_quats(60).reshape(3, 20, 4), random_quats(60, 1).reshape(3, 20, 4)
    mask = np.random.default_rng(2).random((3, 20)) < 0.7
    together = metrics.score(est, ref, mask)
    for i in range(3):
        alone = metrics.score(est[i], ref[i], mask[i])
        assert isinstance(alone.total, float)
        for name in ("total", "heading", "inclination"):
            # The same numbers summed in another order: a few roundings of 20 terms.
            assert getattr(together, name)[i] == pytest.approx(getattr(alone, name), rel=1e-14)


def test_score_is_in_degrees_unless_asked_for_radians() -> None:
    est, ref = random_quats(50), random_quats(50, 1)
    degrees, radians = metrics.score(est, ref), metrics.score(est, ref, degrees=False)
    assert degrees.total == pytest.approx(math.degrees(radians.total), rel=1e-14)
    assert radians.heading == metrics.rmse(metrics.heading_error(est, ref))


def test_samples_without_truth_do_not_count() -> None:
    est, ref = random_quats(50), random_quats(50, 1)
    ref[10:20] = np.nan
    ref[30, 2] = np.nan
    keep = np.ones(50, dtype=bool)
    keep[10:20] = keep[30] = False
    assert metrics.score(est, ref) == metrics.score(est, ref, keep)
    assert metrics.score(est, ref).total == pytest.approx(metrics.score(est[keep], ref[keep]).total, rel=1e-14)


def test_rows_with_nan_pass_through_as_nan() -> None:
    quat = random_quats(3)
    quat[1, 0] = np.nan
    for values in (metrics.total_error(quat, random_quats(3, 1)), metrics.euler(quat)[:, 0]):
        assert np.isnan(values).tolist() == [False, True, False]


def test_one_reference_serves_many_estimates() -> None:
    est, ref = random_quats(30).reshape(5, 6, 4), random_quats(6, 1)
    assert np.array_equal(metrics.total_error(est, ref)[3], metrics.total_error(est[3], ref))
    assert metrics.total_error(est, [1.0, 0, 0, 0]).shape == (5, 6)


@pytest.mark.parametrize(
    ("est", "ref", "message"),
    [
        (np.zeros(3), np.zeros(4), r"estimate: expected shape \(..., 4\), got \(3,\)"),
        (np.float64(1), np.zeros(4), r"estimate: expected shape \(..., 4\), got \(\)"),
        (random_quats(5), random_quats(6), r"expected the shape of the estimate, \(5, 4\), got \(6, 4\)"),
        (random_quats(1), random_quats(6), r"expected the shape of the estimate"),
        (random_quats(5) * 1.002, random_quats(5), r"estimate: expected unit quaternions, got norm 1.002"),
        (random_quats(5), np.zeros((5, 4)), r"reference: expected unit quaternions, got norm 0 at index 0"),
        ([np.inf, 0, 0, 0], [1, 0, 0, 0], r"estimate: expected unit quaternions, got norm inf"),
    ],
)
def test_impossible_quaternions_are_refused(est: object, ref: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        metrics.total_error(est, ref)


def test_masks_of_the_wrong_kind_are_refused() -> None:
    with pytest.raises(ValueError, match="mask: expected an array of bool"):
        metrics.rmse([1.0, 2.0], [0, 1])
    with pytest.raises(ValueError, match=r"mask: expected shape \(2,\), got \(3,\)"):
        metrics.rmse([1.0, 2.0], [True, True, False])
    with pytest.raises(ValueError, match=r"mask: expected shape \(2,\), got \(1,\)"):
        metrics.rmse([1.0, 2.0], [True])


def test_small_differences_of_the_norm_are_normalised_away() -> None:
    est, ref = random_quats(20), random_quats(20, 1)
    scaled = metrics.total_error(est * 1.0009, ref * 0.9991)
    assert np.allclose(scaled, metrics.total_error(est, ref), atol=ROUNDING, rtol=0)


def test_euler_angles_are_scipys_zyx_reversed() -> None:
    quat = random_quats(1000)
    expected = Rotation.from_quat(quat, scalar_first=True).as_euler("ZYX")[:, ::-1]
    # Near the gimbal lock rounding grows by 1/cos(pitch); the closest of these is 1e-3 rad away from it.
    assert np.abs(metrics.euler(quat) - expected).max() < 1e-12
    assert np.allclose(metrics.euler(quat, degrees=True), np.degrees(expected), atol=1e-10, rtol=0)


@given(unit_quats())
def test_euler_angles_give_the_rotation_back(quat: FloatArray) -> None:
    roll, pitch, yaw = metrics.euler(quat)
    assert -math.pi <= roll <= math.pi
    assert -math.pi <= yaw <= math.pi
    assert abs(pitch) <= math.pi / 2
    back = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat(scalar_first=True)
    # 1e-12 is what the rule for the gimbal lock may turn.
    assert metrics.geodesic_distance(quat, back) < 2e-12


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
@pytest.mark.parametrize("distance", [0.0, 1e-15, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize(("roll", "yaw"), [(0.0, 0.0), (0.3, -2.0), (3.0, 3.1), (-3.0, 0.1)])
def test_euler_angles_give_the_rotation_back_at_the_gimbal_lock(
    pitch: float, distance: float, roll: float, yaw: float
) -> None:
    quat = Rotation.from_euler("ZYX", [yaw, pitch * (1 - distance), roll]).as_quat(scalar_first=True)
    found = metrics.euler(quat)
    back = Rotation.from_euler("ZYX", found[::-1]).as_quat(scalar_first=True)
    assert metrics.geodesic_distance(quat, back) < 2e-12
    if distance == 0.0:
        assert found[0] == 0.0  # roll is 0, yaw takes the turn


@given(st.tuples(angles, st.floats(-1.5, 1.5), angles), st.tuples(angles, st.floats(-1.5, 1.5), angles))
def test_euler_error_is_the_wrapped_difference(a: tuple[float, float, float], b: tuple[float, float, float]) -> None:
    p, q = (Rotation.from_euler("ZYX", e[::-1]).as_quat(scalar_first=True) for e in (a, b))
    error = metrics.euler_error(p, q)
    assert np.all((error > -np.pi) & (error <= np.pi))
    difference = np.array(a) - np.array(b)
    # Compared as points of the circle; |pitch| <= 1.5 keeps 1/cos(pitch) below 15.
    assert np.abs(np.exp(1j * error) - np.exp(1j * difference)).max() < 30 * ROUNDING
