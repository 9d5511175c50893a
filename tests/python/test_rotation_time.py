"""`ar.rotation` along time: against scipy, over gaps, and from rates and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

import ahrs_rs as ar
from rotations import BOUNDS, DTYPES, apart, as_dtype, rotations, seeds
from signals import quats


@DTYPES
@given(seed=seeds, fraction=st.floats(-0.5, 1.5))
def test_slerp_is_scipys(dtype: Any, seed: int, fraction: float) -> None:
    p, r = as_dtype(rotations(seed), dtype)
    turn = Rotation.from_rotvec(np.random.default_rng(seed).uniform(-1.7, 1.7, (20, 3)))
    q, s = as_dtype(r * turn, dtype)
    found = ar.rotation.slerp(p, q, fraction)
    assert found.dtype == dtype
    expected = [r[k] * Rotation.from_rotvec(fraction * (r[k].inv() * s[k]).as_rotvec()) for k in range(20)]
    # Half a turn less 0.2 rad at least: 1.5 / tan(0.1) is the condition.
    assert apart(found, Rotation.concatenate(expected)) <= 15.0 * BOUNDS[dtype]
    assert apart(ar.rotation.slerp(p, q, 0.0), r) <= BOUNDS[dtype]
    assert apart(ar.rotation.slerp(p, q, 1.0), s) <= 2.0 * BOUNDS[dtype]


@DTYPES
@given(seed=seeds)
def test_interpolation_is_scipys_slerp(dtype: Any, seed: int) -> None:
    rng = np.random.default_rng(seed)
    steps = Rotation.from_rotvec(rng.uniform(-1.0, 1.0, (12, 3)))
    r = [rotations(seed)[5]]
    for k in range(12):
        r.append(r[-1] * steps[k])
    q, truth = as_dtype(Rotation.concatenate(r), dtype)
    q = q * rng.choice([-1.0, 1.0], (13, 1)).astype(dtype)
    t = np.cumsum(rng.uniform(0.1, 1.0, 13))
    at = rng.uniform(t[0], t[-1], 30)
    found = ar.rotation.interpolate(q, t, at, max_gap=np.inf)
    assert found.dtype == dtype
    assert apart(found, Slerp(t, truth)(at)) <= 3.0 * BOUNDS[dtype]
    np.testing.assert_allclose(np.abs(np.sum(ar.rotation.interpolate(q, t, t) * q, axis=1)), 1.0, atol=BOUNDS[dtype])
    ordered = ar.rotation.interpolate(q, t, np.sort(at), max_gap=np.inf)
    assert (np.sum(ordered[1:] * ordered[:-1], axis=1) > 0.0).all()


def test_nothing_is_interpolated_over_a_gap_or_outside() -> None:
    q = ar.rotation.about_axis("z", np.arange(6) * 0.1)
    q[4] = np.nan  # no sample: 0.3 to 0.5 s is a gap of 2 steps, which the default allows
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    at = np.array([-0.01, 0.0, 0.25, 0.3, 0.35, 0.4, 0.5, 0.51, np.nan])
    expected = np.array([np.nan, 0.0, 0.25, 0.3, 0.35, 0.4, 0.5, np.nan, np.nan])
    np.testing.assert_allclose(ar.rotation.to_rotvec(ar.rotation.interpolate(q, t, at))[:, 2], expected, atol=1e-15)
    expected[[4, 5]] = np.nan
    for q_, t_, wanted in ((q, t, expected), (-q[[0, 1, 2, 3, 5]], t[[0, 1, 2, 3, 5]], expected)):
        found = ar.rotation.interpolate(q_, t_, at, max_gap=0.15)
        np.testing.assert_allclose(ar.rotation.to_rotvec(found)[:, 2], wanted, atol=1e-15)
    both = ar.rotation.interpolate(np.stack([q, q]), t, at, max_gap=0.15)
    np.testing.assert_array_equal(both[1], ar.rotation.interpolate(q, t, at, max_gap=0.15))
    assert np.isnan(ar.rotation.interpolate(np.full((6, 4), np.nan), t, at)).all()
    # Of two samples at one time the last one counts.
    twice = ar.rotation.interpolate(ar.rotation.about_axis("z", [0.0, 1.0, 2.0]), [0.0, 0.0, 1.0], [0.0, 0.5])
    np.testing.assert_allclose(ar.rotation.to_rotvec(twice)[:, 2], [1.0, 1.5], atol=1e-15)


@DTYPES
@given(seed=seeds)
def test_the_rate_of_attitudes_gives_them_back_and_is_the_mean_rate(dtype: Any, seed: int) -> None:
    rng = np.random.default_rng(seed)
    rates = rng.uniform(-3.0, 3.0, (2, 40, 3)).astype(dtype)
    t = np.cumsum(rng.uniform(0.01, 0.5, 40))
    start = quats(rotations(seed)[:2]).astype(dtype)
    for frame in ("sensor", "earth"):
        q = ar.rotation.integrate(rates, t, start=start, frame=frame)
        assert q.dtype == dtype
        # By the definition: one step after the other.
        r = Rotation.from_quat(start[1].astype(np.float64), scalar_first=True)
        for k in range(1, 40):
            step = Rotation.from_rotvec(rates[1, k].astype(np.float64) * (t[k] - t[k - 1]))
            r = r * step if frame == "sensor" else step * r
        assert apart(q[1, -1:], Rotation.concatenate([r])) <= 10.0 * BOUNDS[dtype]  # rounding errors of 40 steps
        back = ar.rotation.angular_rate(q, t, frame=frame)
        assert back.dtype == dtype
        assert np.isnan(back[:, 0]).all()
        # Divided by steps of 0.01 s at least, and condition of a turn of 2.6 rad at most.
        np.testing.assert_allclose(back[:, 1:], rates[:, 1:], rtol=0.0, atol=1e3 * BOUNDS[dtype])


def test_the_rate_of_a_filters_recording_is_its_gyroscope() -> None:
    motion = ar.simulate.demo(duration=4.0, noise=False)
    rates = ar.rotation.angular_rate(motion.ref, motion.t)
    # The simulation's own rates are the means of an integral; its tolerance is 1e-9.
    np.testing.assert_allclose(rates[1:], motion.gyr[1:], atol=1e-8)
    q = ar.rotation.integrate(motion.gyr, motion.t, start=motion.ref[0])
    assert ar.rotation.distance(q, motion.ref).max() < 1e-8
    filtered = ar.GyroIntegration(rate=100.0).run(motion.gyr[1:], t=motion.t[1:], q0=motion.ref[0]).quat
    assert ar.rotation.distance(q[1:], filtered).max() < 1e-12


def test_steps_without_time_and_missing_rows_have_no_rate() -> None:
    q = ar.rotation.about_axis("y", [0.0, 0.1, 0.2, 0.3, 0.4])
    q[3] = np.nan
    rates = ar.rotation.angular_rate(q, [0.0, 0.1, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(rates[:, 1], [np.nan, 1.0, np.nan, np.nan, np.nan])
    gyr = np.ones((5, 3))
    gyr[3] = np.nan
    assert np.isnan(ar.rotation.integrate(gyr, rate=1.0)).any(axis=1).tolist() == [False, False, False, True, True]


@DTYPES
@given(seed=seeds)
def test_the_sign_is_continuous_and_the_rotation_the_same(dtype: Any, seed: int) -> None:
    rng = np.random.default_rng(seed)
    gyr = rng.uniform(-20.0, 20.0, (3, 50, 3)).astype(dtype)
    smooth = ar.rotation.integrate(gyr, rate=100.0)
    torn = smooth * rng.choice([-1.0, 1.0], (3, 50, 1)).astype(dtype)
    torn[1, 7:9] = np.nan
    torn[2, 0] = np.nan
    found = ar.rotation.continuous(torn)
    assert found.dtype == dtype
    expected = smooth.copy()
    expected[1, 7:9] = expected[2, 0] = np.nan
    expected[2] *= np.sign(expected[2, 1, 0])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=BOUNDS[dtype])


@given(seed=seeds, period=st.sampled_from([2.0 * np.pi, 360.0, 1.0]))
def test_unwrapped_angles_have_no_jumps(seed: int, period: float) -> None:
    rng = np.random.default_rng(seed)
    smooth = np.cumsum(rng.uniform(-0.2, 0.2, (4, 50, 3)) * period, axis=1)
    smooth[:, 0] %= period
    wrapped = smooth % period
    found = ar.rotation.unwrap(wrapped, period=period, axis=1)
    np.testing.assert_allclose(found, np.unwrap(wrapped, period=period, axis=1), rtol=0.0, atol=1e-12 * period)
    # Steps on both sides of a row that is missing are less than half a turn together.
    wrapped[1, 5] = np.nan
    again = ar.rotation.unwrap(wrapped, period=period, axis=1)
    there = ~np.isnan(wrapped)
    np.testing.assert_array_equal(np.isnan(again), ~there)
    np.testing.assert_allclose(again[there], found[there], rtol=0.0, atol=1e-12 * period)
