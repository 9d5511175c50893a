"""`ar.rotation` against scipy's rotations, and at the attitudes where formulas are singular."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from rotations import BOUNDS, DTYPES, QUARTER, apart, as_dtype, rotations, seeds
from signals import quats

#: Examples of a test that runs for every sequence.
FEW = 15
SEQUENCES = [a + b + c for a in "XYZ" for b in "XYZ" for c in "XYZ" if a != b != c]
SEQUENCES += [name.lower() for name in SEQUENCES]

angles = st.floats(-10.0, 10.0)


@DTYPES
@given(seed=seeds)
def test_product_inverse_rotate_and_distance_are_scipys(dtype: Any, seed: int) -> None:
    bound = BOUNDS[dtype]
    (p, r), (q, s) = as_dtype(rotations(seed), dtype), as_dtype(rotations(seed ^ 1), dtype)
    v = np.random.default_rng(seed).normal(size=(20, 3)).astype(dtype)
    results = [ar.rotation.product(p, q), ar.rotation.inverse(p), ar.rotation.rotate(p, v), ar.rotation.distance(p, q)]
    assert [result.dtype for result in results] == [dtype] * 4
    assert apart(results[0], r * s) <= bound
    assert apart(results[1], r.inv()) <= bound
    np.testing.assert_allclose(results[2], r.apply(v), rtol=0.0, atol=5.0 * bound)  # of vectors up to 5 long
    # 2 atan2 doubles the error of a quaternion's components.
    np.testing.assert_allclose(results[3], (r.inv() * s).magnitude(), rtol=0.0, atol=2.0 * bound)


@DTYPES
@given(seed=seeds)
def test_matrices_and_rotation_vectors_are_scipys(dtype: Any, seed: int) -> None:
    q, r = as_dtype(rotations(seed), dtype)
    bound = BOUNDS[dtype]
    matrix, vector = ar.rotation.to_matrix(q), ar.rotation.to_rotvec(q)
    assert (matrix.dtype, vector.dtype) == (dtype, dtype)
    np.testing.assert_allclose(matrix, r.as_matrix(), rtol=0.0, atol=2.0 * bound)
    assert apart(ar.rotation.from_matrix(matrix), r) <= 2.0 * bound
    assert apart(ar.rotation.from_rotvec(vector), r) <= bound
    # Near half a turn the axis has two signs; there the rotation is compared alone.
    clear = r.magnitude() < np.pi - 1e-5
    np.testing.assert_allclose(vector[clear], r.as_rotvec()[clear], rtol=0.0, atol=2.0 * bound)
    long = 3.0 * np.random.default_rng(seed).normal(size=(5, 4, 3)).astype(dtype)
    assert apart(ar.rotation.from_rotvec(long).reshape(-1, 4), Rotation.from_rotvec(long.reshape(-1, 3))) <= bound


@DTYPES
@pytest.mark.parametrize("sequence", SEQUENCES)
@settings(max_examples=FEW)
@given(seed=seeds)
def test_every_sequence_of_angles_is_scipys_both_ways(sequence: str, dtype: Any, seed: int) -> None:
    bound = BOUNDS[dtype]
    given = np.random.default_rng(seed).uniform(-7.0, 7.0, (10, 3)).astype(dtype)
    made = ar.rotation.from_euler(given, sequence)
    assert made.dtype == dtype
    assert apart(made, Rotation.from_euler(sequence, given.astype(np.float64))) <= bound
    q, r = as_dtype(rotations(seed), dtype)
    found = ar.rotation.to_euler(q, sequence)
    assert found.dtype == dtype
    # Angles near a singular one are sensitive each alone; what they stand for is not.
    assert apart(ar.rotation.from_euler(found, sequence), r) <= 2.0 * bound
    low, high = (0.0, np.pi) if sequence[0] == sequence[2] else (-QUARTER, QUARTER)
    # π and π/2 in float32 are not those of float64.
    assert (found[:, 1] >= low - bound).all()
    assert (found[:, 1] <= high + bound).all()
    assert (np.abs(found) <= np.pi + bound).all()


@pytest.mark.parametrize("sequence", SEQUENCES)
@settings(max_examples=FEW)
@given(first=st.floats(-3.0, 3.0), middle=st.floats(0.05, 1.5), third=st.floats(-3.0, 3.0))
def test_angles_come_back_away_from_singular_ones(sequence: str, first: float, middle: float, third: float) -> None:
    angles = np.array([first, middle, third])
    found = ar.rotation.to_euler(ar.rotation.from_euler(angles, sequence), sequence)
    # The condition is 1/sin or 1/cos of the middle angle: 20 here.
    np.testing.assert_allclose(found, angles, rtol=0.0, atol=20.0 * 1e-14)


@DTYPES
@pytest.mark.parametrize("sequence", SEQUENCES)
@pytest.mark.parametrize("side", [0, 1])
@settings(max_examples=FEW)
@given(first=st.floats(-3.0, 3.0), third=st.floats(-3.0, 3.0))
def test_at_singular_attitudes_the_third_angle_is_zero_and_the_rotation_the_same(
    sequence: str, side: int, dtype: Any, first: float, third: float
) -> None:
    proper = sequence[0] == sequence[2]
    middle = (0.0, np.pi)[side] if proper else (-QUARTER, QUARTER)[side]
    r = Rotation.from_euler(sequence, [first, middle, third])
    q, r = as_dtype(r, dtype)
    # The quaternion of float32 has its own rounding, which is taken away here: the singular attitude itself.
    found = ar.rotation.to_euler(q, sequence)
    assert apart(ar.rotation.from_euler(found, sequence), r) <= 2.0 * BOUNDS[dtype]
    if dtype == np.float64:
        assert found[2] == 0.0
        assert found[1] == pytest.approx(middle, abs=1e-14)


@given(distance=st.floats(-14.0, -1.0), sequence=st.sampled_from(SEQUENCES), first=angles, third=angles)
def test_near_singular_attitudes_the_rotation_is_the_same(
    distance: float, sequence: str, first: float, third: float
) -> None:
    middle = (0.0 if sequence[0] == sequence[2] else QUARTER) - 10.0**distance
    r = Rotation.from_euler(sequence, [first, middle, third])
    found = ar.rotation.to_euler(quats(r), sequence)
    assert apart(ar.rotation.from_euler(found, sequence), r) <= 1e-13


@DTYPES
@given(seed=seeds)
def test_the_mean_is_scipys_weighted_or_not(dtype: Any, seed: int) -> None:
    rng = np.random.default_rng(seed)
    spread = Rotation.from_rotvec(0.3 * rng.normal(size=(12, 3)))
    q, r = as_dtype(rotations(seed)[3] * spread, dtype)
    q = q * rng.choice([-1.0, 1.0], (12, 1)).astype(dtype)
    weights = rng.uniform(0.1, 1.0, 12).astype(dtype)
    found = ar.rotation.mean(q, weights)
    assert found.dtype == dtype
    assert apart(found[np.newaxis], Rotation.concatenate([r.mean(weights)])) <= BOUNDS[dtype]
    assert apart(ar.rotation.mean(q)[np.newaxis], Rotation.concatenate([r.mean()])) <= BOUNDS[dtype]


def test_the_mean_takes_whole_numbers_of_numpy_as_axes() -> None:
    q = quats(rotations(3))[:6].reshape(2, 3, 4)
    np.testing.assert_array_equal(ar.rotation.mean(q, axis=np.int64(-1)), ar.rotation.mean(q, axis=1))  # type: ignore[arg-type]
    np.testing.assert_array_equal(ar.rotation.mean(q, axis=(0, 1)), ar.rotation.mean(q))


def test_the_mean_of_axes_leaves_out_what_is_missing() -> None:
    q = ar.rotation.about_axis("x", np.array([[0.1, 0.3], [0.5, 0.7], [0.9, 2.0]]))
    for axis, expected in ((0, [0.5, 1.0]), (-1, [0.2, 0.6, 1.45]), ((0, 1), None), (None, None)):
        found = ar.rotation.to_rotvec(ar.rotation.mean(q, axis=axis))[..., 0]
        # Of turns about one axis the mean maximises Σ cos(α - mean).
        wanted = np.angle(np.exp(1j * np.array([[0.1, 0.3], [0.5, 0.7], [0.9, 2.0]])).sum(axis=axis))
        np.testing.assert_allclose(found, wanted, atol=1e-14)
        assert expected is None or found.shape == (len(expected),)
    q[2, 1] = np.nan
    found = ar.rotation.to_rotvec(ar.rotation.mean(q, axis=1))[:, 0]
    np.testing.assert_allclose(found, [0.2, 0.6, 0.9], atol=1e-14)
    assert np.isnan(ar.rotation.mean(q, np.zeros((3, 1)), axis=0)).all()
    assert np.isnan(ar.rotation.mean(np.zeros((0, 4)))).all()


@DTYPES
@given(seed=seeds)
def test_swing_and_twist_are_what_their_definition_says(dtype: Any, seed: int) -> None:
    q, r = as_dtype(rotations(seed), dtype)
    axis = np.random.default_rng(seed).normal(size=3).astype(dtype)
    swing, twist, angle = ar.rotation.swing_twist(q, axis)
    bound = 4.0 * BOUNDS[dtype]
    assert {each.dtype for each in (swing, twist, angle)} == {np.dtype(dtype)}
    assert apart(ar.rotation.product(swing, twist), r) <= bound
    unit = axis / np.linalg.norm(axis)
    np.testing.assert_allclose(swing[:, 1:] @ unit, 0.0, atol=bound)
    assert apart(twist, Rotation.from_rotvec(angle[:, np.newaxis] * unit)) <= bound
    # No other turn about the axis is nearer.
    others = Rotation.from_rotvec(np.linspace(-np.pi, np.pi, 73)[:, np.newaxis] * unit.astype(np.float64))
    for k in range(0, 20, 5):
        assert (swing_size := (r[k] * others.inv()).magnitude().min()) >= 0.0
        assert 2.0 * np.arctan2(np.linalg.norm(swing[k, 1:]), swing[k, 0]) <= swing_size + bound


def test_a_swing_of_half_a_turn_has_no_twist() -> None:
    half = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.6, 0.8, 0.0], [6e-17, 0.6, -0.8, 0.0]])
    swing, twist, angle = ar.rotation.swing_twist(half, "z")
    np.testing.assert_array_equal(twist, np.tile([1.0, 0.0, 0.0, 0.0], (3, 1)))
    np.testing.assert_array_equal(angle, 0.0)
    np.testing.assert_allclose(swing, half, atol=1e-15)
    assert ar.rotation.swing_twist([0.0, 0.0, 0.0, -1.0], "z")[2] == pytest.approx(-np.pi)


@DTYPES
@given(seed=seeds, near=st.floats(-16.0, 0.0), opposite=st.booleans())
def test_the_shortest_arc_takes_one_direction_to_the_other(dtype: Any, seed: int, near: float, opposite: bool) -> None:
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(5, 3))
    v = (-1.0 if opposite else 1.0) * u + 10.0**near * rng.normal(size=(5, 3))
    u, v = u.astype(dtype), v.astype(dtype)
    q = ar.rotation.shortest_arc(u, v)
    assert q.dtype == dtype
    a, b = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (u.astype(float), v.astype(float)))
    np.testing.assert_allclose(ar.rotation.rotate(q, a), b, rtol=0.0, atol=20.0 * BOUNDS[dtype])
    angle = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    np.testing.assert_allclose(ar.rotation.distance(q, [1.0, 0.0, 0.0, 0.0]), angle, atol=20.0 * BOUNDS[dtype])


def test_about_an_axis_by_name_or_by_vector() -> None:
    for k, name in enumerate("xyz"):
        r = Rotation.from_rotvec(0.7 * np.eye(3)[k])
        assert apart(ar.rotation.about_axis(name, 0.7)[np.newaxis], r) <= 1e-15
        assert apart(ar.rotation.about_axis(1e-200 * np.eye(3)[k], [0.7]), r) <= 1e-15
    assert ar.rotation.about_axis("x", np.float32([1.0])).dtype == np.float32
    assert ar.rotation.about_axis(np.ones((4, 3)), np.ones((2, 1))).shape == (2, 4, 4)


@given(seed=seeds)
def test_a_rough_matrix_gives_the_nearest_rotation(seed: int) -> None:
    rough = rotations(seed).as_matrix() + 3e-4 * np.random.default_rng(seed).uniform(-1.0, 1.0, (20, 3, 3))
    u, _, vt = np.linalg.svd(rough)
    assert apart(ar.rotation.from_matrix(rough), Rotation.from_matrix(u @ vt)) <= 1e-13


def test_leading_axes_are_broadcast_and_empty_arrays_stay_empty() -> None:
    q = ar.rotation.from_rotvec(np.random.default_rng(1).normal(size=(3, 1, 5, 3)))
    assert ar.rotation.product(q, q[0, 0]).shape == (3, 1, 5, 4)
    assert ar.rotation.rotate(q, np.ones((4, 1, 3))).shape == (3, 4, 5, 3)
    assert ar.rotation.slerp(q, q[0], np.ones((7, 5))).shape == (3, 7, 5, 4)
    nothing = np.zeros((0, 4))
    assert ar.rotation.product(nothing, [1.0, 0.0, 0.0, 0.0]).shape == (0, 4)
    assert ar.rotation.to_euler(nothing, "XYZ").shape == ar.rotation.to_rotvec(nothing).shape == (0, 3)
    assert ar.rotation.to_matrix(nothing).shape == (0, 3, 3)
    assert ar.rotation.from_matrix(np.zeros((0, 3, 3))).shape == (0, 4)
    assert ar.rotation.continuous(nothing).shape == (0, 4)
    assert ar.rotation.angular_rate(nothing, rate=1.0).shape == (0, 3)
    assert ar.rotation.interpolate(nothing, [], [1.0]).shape == (1, 4)
    assert ar.rotation.unwrap([]).shape == (0,)


def test_a_row_with_a_nan_gives_nan_and_leaves_the_others() -> None:
    q = ar.rotation.from_rotvec(np.random.default_rng(2).normal(size=(4, 3)))
    whole, q[1, 2] = q.copy(), np.nan
    functions = [
        lambda x: ar.rotation.product(x, x),
        ar.rotation.inverse,
        lambda x: ar.rotation.rotate(x, [1.0, 2.0, 3.0]),
        lambda x: ar.rotation.to_euler(x, "XYX"),
        lambda x: ar.rotation.to_matrix(x).reshape(4, 9),
        ar.rotation.to_rotvec,
        lambda x: ar.rotation.from_matrix(ar.rotation.to_matrix(x)),
        lambda x: ar.rotation.swing_twist(x, "x")[0],
        lambda x: ar.rotation.slerp(x, [1.0, 0.0, 0.0, 0.0], 0.3),
    ]
    for function in functions:
        result, expected = function(q), function(whole)
        assert np.isnan(result[1]).all()
        np.testing.assert_array_equal(result[[0, 2, 3]], expected[[0, 2, 3]])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda r: r.product([1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]), r"^p: expected shape \(\.\.\., 4\), got \(3,\)"),
        (lambda r: r.inverse([[1.0, 0.0, 0.0, 0.0], [2.0, 0, 0, 0]]), "^q: expected unit .*, got norm 2 at index 1"),
        (lambda r: r.inverse(["a", "b", "c", "d"]), "^q: expected an array of real numbers, got dtype"),
        (lambda r: r.inverse([np.inf, 0, 0, 0]), "^q: expected unit quaternions, got norm inf"),
        (lambda r: r.from_rotvec([0.0, np.inf, 0.0]), r"^vector: expected finite .* \(missing\), got inf at index 1"),
        (lambda r: r.inverse([[1.0], [1.0, 2.0]]), "^q: expected an array of real numbers"),
        (lambda r: r.product(np.eye(4)[:3], np.eye(4)[:2]), "^p, q: expected leading axes that fit each other, got"),
        (lambda r: r.about_axis("w", 1.0), "^axis: expected one of 'x', 'y', 'z', got 'w'"),
        (lambda r: r.about_axis([0.0, 0.0, 0.0], 1.0), "^axis: expected vectors that are not zero"),
        (lambda r: r.from_euler([0.0, 0.0, 0.0], "XYy"), "^sequence: expected three of x, y, z"),
        (lambda r: r.to_euler([1.0, 0.0, 0.0, 0.0], "XXY"), "^sequence: expected three of x, y, z"),
        (lambda r: r.from_matrix(2.0 * np.eye(3)), "^matrix: expected orthonormal columns"),
        (lambda r: r.from_matrix(-np.eye(3)), "^matrix: expected rotations, got a mirror image"),
        (lambda r: r.mean(np.eye(4), [1.0, -1.0, 1.0, 1.0]), "^weights: expected numbers that are not .*, got -1"),
        (lambda r: r.mean(np.eye(4), [1.0, 1.0]), r"^weights: expected shape \(4,\), got \(2,\)"),
        (lambda r: r.mean(np.eye(4), axis=1), r"^axis: expected axes, each once, of the leading shape \(4,\), got 1"),
        (lambda r: r.mean(np.eye(4), axis=(0, -1)), r"^axis: expected axes, each once, .*, got \(0, -1\)"),
        (lambda r: r.mean(np.eye(4), axis="x"), "^axis: expected axes, each once, of the leading shape .*, got 'x'"),
        (lambda r: r.mean(np.eye(4), axis=0.5), "^axis: expected axes, each once, of the leading shape .*, got 0.5"),
        (lambda r: r.continuous([1.0, 0.0, 0.0, 0.0]), r"^q: expected shape \(\.\.\., T, 4\), got \(4,\)"),
        (lambda r: r.interpolate(np.eye(4), [0.0, 1.0, 0.5, 2.0], [0.0]), "^t: expected times that do not decrease"),
        (lambda r: r.interpolate(np.eye(4), [0.0, 1.0], [0.0]), r"^t: expected shape \(4,\), got \(2,\)"),
        (lambda r: r.interpolate(np.eye(4), range(4), [0.0], max_gap=-1.0), "^max_gap: expected a number of s"),
        (lambda r: r.angular_rate(np.eye(4)), "^t: expected stamps in s, or a positive rate in Hz, got None"),
        (lambda r: r.angular_rate(np.eye(4), rate=1.0, frame="body"), "^frame: expected one of 'sensor', 'earth'"),
        (lambda r: r.integrate(np.zeros((0, 3)), rate=1.0), r"^gyr: expected shape \(\.\.\., T, 3\) with T > 0"),
        (lambda r: r.unwrap([0.0], period=0.0), "^period: expected a positive number"),
        (lambda r: r.angular_rate(np.eye(4), range(4), rate=1.0), "^t, rate: expected one of them, got both"),
        (lambda r: r.integrate(np.eye(3), range(3), rate=1.0), "^t, rate: expected one of them, got both"),
        (lambda r: r.unwrap([0.0], axis=1), "^axis: expected one of an array of shape"),
        (lambda r: r.unwrap([0.0], axis=None), "^axis: expected one of an array of shape .*, got"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call(ar.rotation)
