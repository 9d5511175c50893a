"""Attitude of a single moment, against its definitions.

The truth is a rotation that the directions were made with; for noisy ones, scipy's `align_vectors`, which solves
Wahba's problem by singular values, the definition of the smallest loss, and derivatives by differences.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from signals import Floats, angle_between, conjugate, multiply, poses, quats, random_turns, rotation

EPS = float(np.finfo(np.float64).eps)
#: Up and magnetic north in each frame.
AXES = {
    "ENU": ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
    "NED": ([0.0, 0.0, -1.0], [1.0, 0.0, 0.0]),
    "NWU": ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
}
WAHBA: dict[str, Callable[..., Any]] = {
    "svd": ar.attitude.svd,
    "davenport": ar.attitude.davenport,
    "quest": ar.attitude.quest,
    "flae": ar.attitude.flae,
    "flae-newton": lambda *args, **kw: ar.attitude.flae(*args, method="newton", **kw),
    "flae-eig": lambda *args, **kw: ar.attitude.flae(*args, method="eig", **kw),
    "oleq": ar.attitude.oleq,
}
POLYNOMIAL = ("quest", "flae", "flae-newton")
PAIRS = {"triad": ar.attitude.triad, **WAHBA}
CLOSED: dict[str, Callable[..., Any]] = {
    "saam": ar.attitude.saam,
    "famc": ar.attitude.famc,
    "fqa": ar.attitude.fqa,
}
SEED = st.integers(0, 10**6)
#: Each example has random directions of its own.
FEW = settings(max_examples=100)


def seen(truth: Floats, directions: Floats) -> Floats:
    """Directions on earth (n, 3) in the sensor frames of attitudes (T, 4): (T, n, 3)."""
    return np.stack([rotation(truth).inv().apply(one) for one in directions], axis=-2)


def directions(count: int, seed: int) -> Floats:
    return np.random.default_rng(seed).standard_normal((count, 3))


def noisy(truth: Floats, earth: Floats, sigma: float, seed: int) -> Floats:
    """Directions that a noisy sensor sees, of random lengths."""
    rng = np.random.default_rng(seed)
    exact = seen(truth, earth / np.linalg.norm(earth, axis=-1, keepdims=True))
    return (exact + sigma * rng.standard_normal(exact.shape)) * rng.uniform(0.1, 100.0, (*exact.shape[:-1], 1))


def unit(array: Floats) -> Floats:
    return np.asarray(array / np.linalg.norm(array, axis=-1, keepdims=True))


def solved(sensor: Floats, earth: Floats, weights: Floats) -> Floats:
    """The oracle: scipy's solution of Wahba's problem, one by one."""
    found = [Rotation.align_vectors(unit(earth), unit(one), weights=weights)[0] for one in sensor]
    return quats(Rotation.concatenate(found))


def acc_and_mag(truth: Floats, frame: str, dip: float, declination: float = 0.0) -> tuple[Floats, Floats]:
    """Exact specific forces and fields."""
    up, north = np.array(AXES[frame][0]), np.array(AXES[frame][1])
    turned = Rotation.from_rotvec(-declination * up).apply(north)  # to the east is clockwise from above
    field = math.cos(dip) * turned - math.sin(dip) * up
    both = seen(truth, np.stack((9.81 * up, 48.0 * field)))
    return both[:, 0], both[:, 1]


# ---------------------------------------------------------------- exact directions


@pytest.mark.parametrize("frame", AXES)
@pytest.mark.parametrize("dip", [0.0, 1.1, -1.4])
@pytest.mark.parametrize("method", CLOSED)
def test_closed_forms_find_every_attitude(method: str, dip: float, frame: str) -> None:
    # The cube's 24 attitudes have all half turns, w = 0, level sensors and vertical axes. Rounding of the field's
    # direction, and the cancellations of FAMC's elimination, which are of the size of the gap 1 - sin(dip), count.
    truth = poses(300, 1)
    found = CLOSED[method](*acc_and_mag(truth, frame, dip), frame=frame)
    assert angle_between(truth, found).max() < 32 * EPS / (1.0 - abs(math.sin(dip)))


@pytest.mark.parametrize("frame", AXES)
@pytest.mark.parametrize("method", PAIRS)
def test_methods_of_pairs_find_every_attitude(method: str, frame: str) -> None:
    truth = poses(300, 2)
    sensor, earth = ar.attitude.pairs(*acc_and_mag(truth, frame, 1.1), frame=frame)
    # The gap of the eigenvalues is 1 - sin(1.1), a tenth; the polynomials lose its square.
    assert angle_between(truth, PAIRS[method](sensor, earth)).max() < 3e3 * EPS


@pytest.mark.parametrize("method", WAHBA)
@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_any_number_of_exact_directions(method: str, count: int) -> None:
    truth, earth = poses(100, 3), directions(count, 4)
    assert angle_between(truth, WAHBA[method](seen(truth, earth), earth)).max() < 1e4 * EPS


@pytest.mark.parametrize("frame", AXES)
@pytest.mark.parametrize("declination", [0.3, -0.2])
def test_declination_turns_to_true_north(frame: str, declination: float) -> None:
    truth = poses(50, 5)
    acc, mag = acc_and_mag(truth, frame, 1.0, declination)
    for method in CLOSED.values():
        assert angle_between(truth, method(acc, mag, frame=frame, declination=declination)).max() < 1e3 * EPS
    for dip in (None, 1.0):
        sensor, earth = ar.attitude.pairs(acc, mag, frame=frame, dip=dip, declination=declination)
        assert angle_between(truth, ar.attitude.triad(sensor, earth)).max() < 1e2 * EPS


@pytest.mark.parametrize("frame", AXES)
def test_the_pairs_are_up_and_the_field_in_every_frame(frame: str) -> None:
    up, north = AXES[frame]
    _, earth = ar.attitude.pairs(*acc_and_mag(poses(5, 6), frame, 0.7), frame=frame, dip=0.7)
    field = math.cos(0.7) * np.array(north) - math.sin(0.7) * np.array(up)
    assert np.abs(earth - np.stack((up, field))).max() < 2 * EPS


def test_fqa_without_a_magnetometer_has_yaw_zero_and_the_inclination() -> None:
    truth = poses(200, 7)
    for frame in AXES:
        acc, _ = acc_and_mag(truth, frame, 0.0)
        found = ar.attitude.fqa(acc, frame=frame)
        up = rotation(found).apply(unit(acc))
        assert np.abs(up - AXES[frame][0]).max() < 8 * EPS
        x = rotation(found).apply([1.0, 0.0, 0.0])
        slanted = np.hypot(x[:, 0], x[:, 1]) > 1e-9
        assert np.abs(x[slanted, 1]).max() < 8 * EPS
        assert x[slanted, 0].min() > 0.0


def test_level_sensors_are_the_identity_of_their_frame() -> None:
    for frame, (up, north) in AXES.items():
        for method in CLOSED.values():
            assert method(up, np.add(up, north), frame=frame).round(15).tolist() == [1.0, 0.0, 0.0, 0.0]
        assert ar.attitude.fqa(up, frame=frame).tolist() == [1.0, 0.0, 0.0, 0.0]


# ---------------------------------------------------------------- noisy directions


@pytest.mark.parametrize("method", WAHBA)
@pytest.mark.parametrize("count", [2, 3, 7])
def test_the_solution_is_that_of_singular_values(method: str, count: int) -> None:
    truth, earth = poses(60, 8), directions(count, 9)
    sensor, weights = noisy(truth, earth, 0.1, 10), np.random.default_rng(11).uniform(0.2, 5.0, count)
    found = WAHBA[method](sensor, earth, weights=weights)
    assert angle_between(solved(sensor, earth, weights), found).max() < 1e-11  # the gap is a tenth at least


def test_the_solution_is_that_of_qmt() -> None:
    qmt = pytest.importorskip("qmt", reason="the package qmt is not installed")
    earth, weights = directions(4, 48), np.array([1.0, 0.5, 2.0, 3.0])
    sensor = noisy(quats(random_turns(20, 49)), earth, 0.1, 50)
    peer = [qmt.quatFromVectorObservations(one, earth, weights) for one in sensor]
    assert angle_between(peer, ar.attitude.svd(sensor, earth, weights=weights)).max() < 1e-12


@pytest.mark.parametrize("method", WAHBA)
def test_directions_that_do_not_fit_at_all_have_a_solution(method: str) -> None:
    # Half of these profiles have a negative determinant: the reflection would fit better.
    sensor, earth = directions(300, 12).reshape(100, 3, 3), directions(3, 13)
    oracle = solved(sensor, earth, np.ones(3))
    negative = [np.linalg.det(unit(one).T @ unit(earth)) < 0.0 for one in sensor]
    assert 20 < np.count_nonzero(negative) < 80
    found = WAHBA[method](sensor, earth)
    # How far rounding reaches depends on the gap of the two largest eigenvalues, s₂ ± s₃.
    s = np.linalg.svd(np.swapaxes(unit(sensor), -1, -2) @ unit(earth) / 3.0)[1]
    gap = s[:, 1] + np.where(negative, -1.0, 1.0) * s[:, 2]
    assert (angle_between(oracle, found) < 32 * EPS / gap ** (2 if method in POLYNOMIAL else 1)).all()


@FEW
@given(seed=SEED, count=st.integers(2, 6), method=st.sampled_from(sorted(WAHBA)))
def test_no_rotation_has_a_smaller_loss(seed: int, count: int, method: str) -> None:
    sensor, earth = directions(count, seed), directions(count, seed + 1)
    weights = np.random.default_rng(seed + 2).uniform(0.1, 1.0, count)
    found = WAHBA[method](sensor, earth, weights=weights)
    least = ar.attitude.wahba_loss(found, sensor, earth, weights=weights)
    others = quats(random_turns(50, seed))
    near = multiply(found, quats(Rotation.from_rotvec(1e-3 * directions(50, seed + 3))))
    for quat in (others, near):
        # At the minimum, rounding of the attitude changes the loss by its square.
        assert (ar.attitude.wahba_loss(quat, sensor, earth, weights=weights) >= least - 16 * EPS).all()


def test_the_loss_is_its_definition() -> None:
    quat, sensor, earth, weights = poses(20, 14), directions(4, 15), directions(4, 16), np.array([1.0, 2.0, 0.0, 4.0])
    expected = [
        0.5
        * sum(
            a / 7.0 * np.sum((b - one.inv().apply(r)) ** 2)
            for a, b, r in zip(weights, unit(sensor), unit(earth), strict=True)
        )
        for one in rotation(quat)
    ]
    assert np.abs(ar.attitude.wahba_loss(3.0 * quat, sensor, earth, weights=weights) - expected).max() < 8 * EPS


@FEW
@given(seed=SEED)
def test_triad_meets_the_first_pair_and_the_plane_of_the_second(seed: int) -> None:
    sensor, earth = directions(2, seed), directions(2, seed + 1)
    turned = rotation(ar.attitude.triad(sensor, earth)).apply(unit(sensor))
    first, second = unit(earth)
    assert np.abs(turned[0] - first).max() < 8 * EPS
    normal = np.cross(first, second)
    cross = np.cross(turned[0], turned[1])
    sines = np.linalg.norm(normal) * np.linalg.norm(cross)
    assert np.cross(normal, cross) / sines == pytest.approx(0.0, abs=64 * EPS / sines)
    assert normal @ cross > 0.0


@FEW
@given(seed=SEED, frame=st.sampled_from(sorted(AXES)))
def test_closed_forms_are_triad_with_the_accelerometer_first(seed: int, frame: str) -> None:
    acc, mag = directions(2, seed)
    expected = ar.attitude.triad(*ar.attitude.pairs(acc, mag, frame=frame))
    room = np.linalg.norm(np.cross(unit(acc), unit(mag))) ** 2
    for method in CLOSED.values():
        assert angle_between(expected, method(acc, mag, frame=frame)) < 64 * EPS / room


def test_filters_start_from_the_same_attitude() -> None:
    truth = poses(30, 17)
    for frame in AXES:
        acc, mag = acc_and_mag(truth, frame, 1.1)
        mag = mag + 5.0 * directions(len(mag), 18)
        compass = ar.Ecompass(rate=1.0, frame=frame)
        start = [compass.run(None, a[np.newaxis], m[np.newaxis]).quat[0] for a, m in zip(acc, mag, strict=True)]
        assert angle_between(start, ar.attitude.fqa(acc, mag, frame=frame)).max() < 1e2 * EPS


# ---------------------------------------------------------------- covariance


def by_differences(method: Callable[[Floats], Floats], sensor: Floats, sigma: Floats) -> Floats:
    """Σ σᵢ² J Jᵀ of the rotation in the sensor frame by which the solution follows each direction."""
    step, covariance = 1e-5, np.zeros((3, 3))
    for k, one in enumerate(sigma):
        for axis in np.eye(3):
            ends = []
            for sign in (1.0, -1.0):
                moved = sensor.copy()
                moved[k] = Rotation.from_rotvec(sign * step * axis).apply(moved[k])
                ends.append(method(moved))
            turn = rotation(multiply(conjugate(ends[1]), ends[0])).as_rotvec() / (2.0 * step)
            covariance += one**2 * np.outer(turn, turn)
    return covariance


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_the_covariance_of_wahba_is_that_of_its_derivatives(count: int, weighted: bool) -> None:
    earth, truth = directions(count, 19), quats(random_turns(1, 20))
    sensor = seen(truth, earth)[0]
    sigma = np.random.default_rng(21).uniform(0.01, 0.05, count)
    weights = np.random.default_rng(22).uniform(0.2, 3.0, count) if weighted else sigma**-2.0
    expected = by_differences(lambda moved: ar.attitude.svd(moved, earth, weights=weights), sensor, sigma)
    found = ar.attitude.wahba_covariance(sensor, sigma, weights=weights if weighted else None)
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()  # step² of the differences, and EPS / step


def test_the_covariance_of_triad_is_that_of_its_derivatives() -> None:
    for seed in range(5):
        earth, sigma = directions(2, 23 + seed), np.array([0.01, 0.03])[:: (-1) ** seed]
        sensor = seen(quats(random_turns(1, seed)), earth)[0]
        expected = by_differences(lambda moved, earth=earth: ar.attitude.triad(moved, earth), sensor, sigma)
        found = ar.attitude.triad_covariance(sensor, sigma)
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


def test_the_best_weights_have_the_smallest_covariance() -> None:
    sensor, sigma = directions(4, 30), np.array([0.01, 0.02, 0.05, 0.03])
    best = ar.attitude.wahba_covariance(sensor, sigma)
    other = ar.attitude.wahba_covariance(sensor, sigma, weights=np.ones(4))
    assert np.linalg.eigvalsh(other - best).min() > -1e-18
    assert np.trace(other) > 1.1 * np.trace(best)
    two = ar.attitude.triad_covariance(sensor[:2], sigma[:2])
    assert np.linalg.eigvalsh(two - ar.attitude.wahba_covariance(sensor[:2], sigma[:2])).min() > -1e-18


def test_errors_of_noisy_directions_have_the_covariance() -> None:
    earth, sigma, count = directions(3, 31), np.array([0.01, 0.02, 0.03]), 4000
    truth = np.broadcast_to(quats(random_turns(1, 32)), (count, 4))
    exact = seen(truth, unit(earth))
    sensor = exact + sigma[:, np.newaxis] * np.random.default_rng(33).standard_normal(exact.shape)
    errors = rotation(multiply(conjugate(truth), ar.attitude.quest(sensor, earth, weights=sigma**-2.0))).as_rotvec()
    expected = ar.attitude.wahba_covariance(exact[0], sigma)
    nees = np.einsum("ti,ij,tj->t", errors, np.linalg.inv(expected), errors)
    # The mean of 4000 χ² of three degrees of freedom, √(6/4000) = 0.04: five of these.
    assert nees.mean() == pytest.approx(3.0, abs=0.2)


# ---------------------------------------------------------------- singular cases


@pytest.mark.parametrize("method", PAIRS)
def test_directions_along_one_line_determine_nothing(method: str) -> None:
    for sensor, earth in (
        ([[0.3, -0.1, 0.7], [0.6, -0.2, 1.4]], [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]),
        ([[0.3, -0.1, 0.7], [-0.6, 0.2, -1.4]], [[0.0, 0.0, 1.0], [0.0, 0.0, -2.0]]),
        ([[0.3, -0.1, 0.7], [0.3, -0.1, 0.7]], [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),  # the sensor's alone
        ([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], [[0.3, -0.1, 0.7], [0.3, -0.1, 0.7]]),  # the earth's alone
        ([[0.3, -0.1, 0.7], [0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
        ([[0.3, -0.1, 0.7], [1.0, np.nan, 0.0]], [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
        ([[0.3, -0.1, 0.7], [1.0, 0.0, 0.0]], [[0.0, 0.0, np.nan], [0.0, 1.0, 0.0]]),
    ):
        assert np.isnan(PAIRS[method](sensor, earth)).all()


@pytest.mark.parametrize("method", PAIRS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_nearly_one_line_is_found_or_told(method: str, dtype: type) -> None:
    # Whatever is given is within three times the limit, 1/64 rad, at every angle between the directions.
    angles = np.geomspace(1e-9, 1.0, 200)
    earth = np.stack([np.stack(([0.0, 0.0, 1.0], [np.sin(one), 0.0, np.cos(one)])) for one in angles])
    truth = quats(random_turns(len(angles), 34))
    sensor = np.stack([seen(truth[k : k + 1], earth[k])[0] for k in range(len(angles))])
    found = PAIRS[method](sensor.astype(dtype), earth.astype(dtype))
    there = np.isfinite(found).all(axis=-1)
    assert angle_between(truth[there], found[there]).max() < 3.0 / 64.0
    largest = {np.float32: 1e-4, np.float64: 1e-3 if method in POLYNOMIAL else 1e-6}[dtype]
    assert there[angles > max(largest, 1e-3 if method in POLYNOMIAL else 0.0)].all()
    assert not there[angles < 1e-8].any() or method == "triad"


@pytest.mark.parametrize("method", CLOSED)
def test_closed_forms_are_nan_where_nothing_is_determined(method: str) -> None:
    acc = [[0.0, 0.0, 9.81], [0.0, 0.0, 9.81], [0.0, 0.0, 0.0], [np.nan, 0.0, 9.81], [3.0, 4.0, 5.0], [0.0, 0.0, 9.81]]
    mag = [[0.0, 0.0, -40.0], [0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 20.0, 0.0], [-6.0, -8.0, -10.0], [0.0, 9.0, 0.0]]
    found = CLOSED[method](acc, mag)
    assert np.isnan(found[:5]).all()
    assert found[5].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert np.isnan(ar.attitude.fqa(acc)[2:4]).all()


@pytest.mark.parametrize("method", WAHBA)
def test_a_pair_that_is_not_there_is_left_out(method: str) -> None:
    truth, earth = poses(20, 35), directions(4, 36)
    sensor = noisy(truth, earth, 0.05, 37)
    weights = np.array([1.0, 2.0, 3.0, 4.0])
    expected = WAHBA[method](sensor[:, 1:], earth[1:], weights=weights[1:])
    for gone in (np.nan, 0.0):
        lacking = sensor.copy()
        lacking[:, 0] = gone
        assert angle_between(expected, WAHBA[method](lacking, earth, weights=weights)).max() < 1e-11
    without = weights * [0.0, 1.0, 1.0, 1.0]
    assert angle_between(expected, WAHBA[method](sensor, earth, weights=without)).max() < 1e-11
    assert np.isnan(WAHBA[method](sensor, earth, weights=[0.0, 0.0, 1.0, 0.0])).all()
    assert np.isnan(WAHBA[method](sensor, earth, weights=np.zeros(4))).all()


def test_covariances_are_nan_where_nothing_is_determined() -> None:
    line, sigma = [[0.0, 0.0, 1.0], [0.0, 0.0, -2.0]], [0.01, 0.01]
    for covariance in (ar.attitude.triad_covariance, ar.attitude.wahba_covariance):
        assert np.isnan(covariance(line, sigma)).all()
        assert np.isnan(covariance([[0.0, 0.0, 1.0], [0.0, np.nan, 0.0]], sigma)).all()
    three = directions(3, 38)
    expected = ar.attitude.wahba_covariance(three[1:], [0.02, 0.03])
    three[0] = 0.0
    assert np.abs(ar.attitude.wahba_covariance(three, [0.01, 0.02, 0.03]) / expected - 1.0).max() < 1e-13


def test_lengths_do_not_count_however_long_or_short() -> None:
    sensor, earth = directions(2, 39), directions(2, 40)
    expected = ar.attitude.svd(sensor, earth)
    for factor in (1e300, 1e-300, 5e-200):
        assert angle_between(expected, ar.attitude.svd(factor * sensor, earth / factor)) < 1e-14
    assert angle_between(expected, ar.attitude.svd(sensor, earth, weights=[7.0, 7.0])) < 1e-14


# ---------------------------------------------------------------- laws, shapes, types, errors


@FEW
@given(seed=SEED, method=st.sampled_from(sorted(PAIRS)))
def test_a_turned_sensor_or_earth_turns_the_attitude(seed: int, method: str) -> None:
    sensor, earth = directions(2, seed), directions(2, seed + 1)
    by_sensor, by_earth = random_turns(2, seed)
    turned = PAIRS[method](by_sensor.inv().apply(sensor), by_earth.apply(earth))
    expected = multiply(multiply(quats(by_earth), PAIRS[method](sensor, earth)), quats(by_sensor))
    room = min(np.linalg.norm(np.cross(*unit(side))) for side in (sensor, earth))
    if np.isfinite(expected).all():
        assert angle_between(expected, turned) < 1e3 * EPS / room**4


@FEW
@given(seed=SEED, method=st.sampled_from(sorted(WAHBA)))
def test_the_order_of_the_pairs_does_not_count(seed: int, method: str) -> None:
    earth = directions(4, seed)
    sensor = noisy(quats(random_turns(1, seed)), earth, 0.05, seed)[0]
    weights, order = np.array([1.0, 2.0, 3.0, 4.0]), [2, 0, 3, 1]
    one = WAHBA[method](sensor, earth, weights=weights)
    assert angle_between(one, WAHBA[method](sensor[order], earth[order], weights=weights[order])) < 1e-9


@pytest.mark.parametrize("method", PAIRS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_leading_axes_broadcast_and_types_stay(method: str, dtype: type) -> None:
    earth = directions(2, 41).astype(dtype)
    sensor = noisy(quats(random_turns(6, 42)), earth, 0.1, 43).astype(dtype)
    whole = PAIRS[method](sensor.reshape(2, 3, 2, 3), earth)
    assert whole.shape == (2, 3, 4)
    assert whole.dtype == dtype
    rounding = 4 * np.finfo(dtype).eps  # numpy's loops differ by the number of rows and by their layout
    assert np.abs(whole.reshape(6, 4) - [PAIRS[method](one, earth) for one in sensor]).max() <= rounding
    assert PAIRS[method](sensor[0], np.stack((earth, earth))).shape == (2, 4)
    assert PAIRS[method](sensor[:0], earth).shape == (0, 4)
    strided = np.asfortranarray(sensor)[::-1]
    assert np.abs(PAIRS[method](strided, earth)[::-1] - whole.reshape(6, 4)).max() <= rounding
    assert (whole[..., 0] >= 0.0).all()
    assert np.abs(np.linalg.norm(whole, axis=-1) - 1.0).max() < 2 * np.finfo(dtype).eps
    assert PAIRS[method](sensor.astype(np.float64), earth).dtype == np.float64


@pytest.mark.parametrize("method", CLOSED)
def test_closed_forms_broadcast_and_keep_float32(method: str) -> None:
    acc, mag = directions(6, 44).astype(np.float32).reshape(2, 3, 3), directions(3, 45).astype(np.float32)
    whole = CLOSED[method](acc, mag)
    assert whole.shape == (2, 3, 4)
    assert whole.dtype == np.float32
    wide = CLOSED[method](acc.astype(np.float64), mag)
    assert wide.dtype == np.float64
    assert angle_between(wide, whole.astype(np.float64)).max() < 1e-6  # the rounding of the result
    assert CLOSED[method](acc[:0], mag).shape == (0, 3, 4)
    assert CLOSED[method]([0, 0, 1], [0, 1, 0]).tolist() == [1.0, 0.0, 0.0, 0.0]  # integers


def test_columns_of_a_data_frame_are_taken() -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(directions(5, 46), columns=["x", "y", "z"])
    field = directions(5, 47)
    assert np.array_equal(ar.attitude.saam(table, field), ar.attitude.saam(table.to_numpy(), field))


TWO = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]
WRONG: list[tuple[Callable[[], Any], str]] = [
    (lambda: ar.attitude.svd([0.0, 0.0, 1.0], TWO), r"sensor: expected an array \(..., n, 3\), got \(3,\)"),
    (lambda: ar.attitude.svd(TWO, np.zeros((2, 4))), r"earth: expected an array \(..., n, 3\), got \(2, 4\)"),
    (lambda: ar.attitude.quest(TWO[:1], TWO[:1]), "sensor: expected at least 2 directions, got 1"),
    (lambda: ar.attitude.oleq([*TWO, TWO[0]], TWO), "sensor, earth: expected as many directions, got 3 and 2"),
    (lambda: ar.attitude.triad([*TWO, TWO[0]], [*TWO, TWO[0]]), "sensor: expected two directions, .* svd takes more"),
    (
        lambda: ar.attitude.svd([[0.0, np.inf, 1.0], TWO[0]], TWO),
        r"sensor: expected finite .* got inf at index \(0, 1\)",
    ),
    (lambda: ar.attitude.svd([["x"] * 3] * 2, TWO), "sensor: expected an array .* of real numbers, got the dtype"),
    (lambda: ar.attitude.svd(np.ones((3, 2, 3)), np.ones((4, 2, 3))), "sensor, earth: expected shapes that broadcast"),
    (lambda: ar.attitude.flae(TWO, TWO, weights=[1.0, -1.0]), "weights: expected finite numbers >= 0, got -1.0"),
    (lambda: ar.attitude.flae(TWO, TWO, weights=[1.0, np.nan]), "weights: expected finite numbers >= 0, got nan"),
    (lambda: ar.attitude.flae(TWO, TWO, weights=[1.0] * 3), r"weights: expected a shape that broadcasts to \(2,\)"),
    (lambda: ar.attitude.flae(TWO, TWO, method="newtn"), r"method: expected one of .* \(did you mean newton\?\)"),
    (lambda: ar.attitude.saam([0.0, 1.0], [0.0, 1.0, 0.0]), r"acc: expected an array \(..., 3\), got \(2,\)"),
    (
        lambda: ar.attitude.famc(TWO[0], [0.0, -np.inf, 0.0]),
        r"mag: expected finite values or NaN, got -inf at index \(1,\)",
    ),
    (lambda: ar.attitude.fqa(TWO[0], frame="ned"), r"frame: expected one of .* got 'ned' \(did you mean NED\?\)"),
    (
        lambda: ar.attitude.fqa(TWO[0], TWO[1], declination=np.nan),
        "declination: expected a finite angle in rad, got nan",
    ),
    (lambda: ar.attitude.pairs(*TWO, dip=2.0), "dip: expected an angle within ±π/2 rad, got 2.0"),
    (lambda: ar.attitude.saam(np.ones((3, 3)), np.ones((2, 3))), "acc, mag: expected shapes that broadcast"),
    (lambda: ar.attitude.wahba_covariance(TWO, [0.0, 0.1]), "sigma: expected finite numbers > 0, got 0.0"),
    (lambda: ar.attitude.triad_covariance(TWO, [-0.1, 0.1]), "sigma: expected finite numbers >= 0, got -0.1"),
    (lambda: ar.attitude.wahba_loss([1.0, 0.0], TWO, TWO), r"quat: expected an array \(..., 4\) of real numbers"),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_errors_name_the_argument(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()
