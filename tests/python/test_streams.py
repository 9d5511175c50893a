"""Streams with clocks of their own, and the rows that are made of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from scipy.spatial.transform import Rotation, Slerp

import ahrs_rs as ar

GYR_T = np.arange(200) / 100.0


def turning(t: np.ndarray) -> np.ndarray:
    """Orientations of a sensor that turns about an inclined axis at 1 rad/s, scalar-first."""
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    return np.column_stack([np.cos(t / 2.0), np.sin(t / 2.0)[:, None] * axis])


def made(**others: tuple[np.ndarray, np.ndarray]) -> ar.Recording:
    return ar.Recording.from_streams(gyr=(GYR_T, np.full((200, 3), 0.1)), **others)


def test_streams_are_kept_as_they_were_given() -> None:
    acc_t, mag_t = np.arange(50) / 26.3, np.arange(20) / 10.1
    rec = made(acc=(acc_t, np.ones((50, 3))), mag=(mag_t, np.ones((20, 3))), velocity=(mag_t, np.ones((20, 3))))
    assert set(rec.streams) == {"gyr", "acc", "mag", "velocity"}
    assert_array_equal(rec.streams["acc"].t, acc_t)
    assert len(rec.streams["mag"].values) == 20
    assert rec.has_own_clocks
    assert_array_equal(rec.t, GYR_T)


def test_a_reading_stands_on_the_first_stamp_at_or_after_its_own() -> None:
    mag_t = np.array([0.0, 0.013, 0.02, 0.0999, 1.5])
    rec = made(mag=(mag_t, np.arange(15.0).reshape(5, 3)))
    there = np.flatnonzero(~np.isnan(rec.mag[:, 0]))
    # 0.013 and 0.02 arrive at the same stamp: the later reading is kept.
    assert_array_equal(there, [0, 2, 10, 150])
    assert_array_equal(rec.mag[there], np.arange(15.0).reshape(5, 3)[[0, 2, 3, 4]])


@given(st.lists(st.floats(0.0, 1.99), min_size=1, max_size=40, unique=True), st.integers(0, 2**31))
def test_rows_are_causal_and_lose_nothing_that_has_a_stamp_of_its_own(times: list[float], seed: int) -> None:
    t = np.sort(times)
    values = np.random.default_rng(seed).normal(size=(len(t), 3))
    rec = made(acc=(t, values))
    there = np.flatnonzero(~np.isnan(rec.acc[:, 0]))
    for row in there:
        k = int(np.flatnonzero((values == rec.acc[row]).all(axis=1))[0])
        assert t[k] <= GYR_T[row], "nothing is known before it was measured"
        assert row == 0 or t[k] > GYR_T[row - 1], "nothing is held back"
    assert len(there) == len(np.unique(np.searchsorted(GYR_T, t)))


def test_interpolated_rows_are_the_line_between_readings_and_nothing_in_a_gap() -> None:
    acc_t = np.concatenate([np.arange(10) / 26.0, 1.0 + np.arange(10) / 26.0])
    rec = made(acc=(acc_t, np.column_stack([3.0 * acc_t, acc_t, -acc_t]))).aligned(interpolate=True)
    inside = (acc_t[9] >= GYR_T) | ((GYR_T >= 1.0) & (acc_t[-1] >= GYR_T))
    np.testing.assert_allclose(rec.acc[inside], GYR_T[inside, None] * [3.0, 1.0, -1.0], atol=1e-12)
    assert np.isnan(rec.acc[~inside]).all()


def test_the_truth_is_interpolated_along_the_shortest_rotation() -> None:
    ref_t = np.arange(30) / 17.0
    ref = turning(ref_t) * np.where(np.arange(30) % 2, -1.0, 1.0)[:, None]  # either sign is the same orientation
    rec = made(ref=(ref_t, ref))
    inside = ref_t[-1] >= GYR_T
    wanted = Slerp(ref_t, Rotation.from_quat(ref, scalar_first=True))(GYR_T[inside])
    got = Rotation.from_quat(rec.ref[inside], scalar_first=True)
    assert np.max((wanted.inv() * got).magnitude()) < 1e-7  # twice the root of float64's resolution: acos near 1
    assert np.isnan(rec.ref[~inside]).all(), "nothing is known after the last one"


def test_nothing_is_interpolated_over_a_gap_of_the_truth() -> None:
    ref_t = np.concatenate([np.arange(20) / 50.0, 1.0 + np.arange(20) / 50.0])
    ref = turning(ref_t)
    ref[5] = np.nan  # lost in between: a gap too
    rows = made(ref=(ref_t, ref)).ref
    assert np.isnan(rows[(ref_t[4] < GYR_T) & (ref_t[6] > GYR_T)]).all()
    assert np.isnan(rows[(ref_t[19] < GYR_T) & (GYR_T < 1.0)]).all()
    assert not np.isnan(rows[(GYR_T >= 1.0) & (ref_t[-1] >= GYR_T)]).any()


def test_rows_of_a_given_rate_hold_the_mean_of_the_angular_rate() -> None:
    gyr = np.random.default_rng(0).normal(size=(200, 3))
    rec = ar.Recording.from_streams(gyr=(GYR_T, gyr)).aligned(rate=20.0)
    assert rec.rate == 20.0
    assert_array_equal(rec.t, np.arange(40) / 20.0)
    # Five samples a step; a sample is the mean over the step before it.
    np.testing.assert_allclose(rec.gyr[1:], [gyr[5 * k - 4 : 5 * k + 1].mean(axis=0) for k in range(1, 40)], atol=1e-12)


def test_without_a_gyroscope_the_clock_is_that_of_the_first_sensor() -> None:
    acc_t, mag_t = np.arange(50) / 26.3, np.arange(20) / 10.1
    rec = ar.Recording.from_streams(mag=(mag_t, np.ones((20, 3))), acc=(acc_t, np.ones((50, 3))))
    assert rec.gyr is None
    assert_array_equal(rec.t, acc_t)
    with pytest.raises(ValueError, match=r"gyr: expected .* as VQF needs a gyroscope"):
        ar.VQF().run(rec)
    assert ar.Tilt().run(rec).quat.shape == (50, 4)


def test_between_and_changed_and_slices_keep_all_streams() -> None:
    rec = made(acc=(np.arange(100) / 50.0, np.ones((100, 3))), pressure=(np.arange(20) / 10.0, np.ones(20)))
    part = rec.between(0.5, 1.0)
    assert part.t[0] == 0.5
    assert part.t[-1] == 1.0
    assert_array_equal(part.streams["pressure"].t, [0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
    with pytest.raises(ValueError, match="start <= end"):
        rec.between(1.0, 0.5)
    with pytest.raises(ValueError, match="start <= end"):
        rec.between(float("nan"), 0.5)


@given(st.sampled_from(["x,y,z", "x,-y,-z", "y,-x,z", "-z,y,x", "z,x,y", "-x,-y,z"]))
def test_remapped_turns_vectors_and_orientations_together(axes: str) -> None:
    t = GYR_T
    field = np.tile([20.0, 3.0, -40.0], (200, 1))
    rec = made(mag=(t, field), ref=(t, turning(t)), device_quat=(t, turning(t)), velocity=(t, field), pressure=(t, t))
    new = rec.remapped(axes)
    names = [one.strip() for one in axes.split(",")]
    for k, name in enumerate(names):
        sign, old = (-1.0 if name[0] == "-" else 1.0), "xyz".index(name[-1])
        assert_array_equal(new.mag[:, k], sign * field[:, old])
    # What the sensor sees in the earth frame stays as it was.
    for quat in ("ref", "device_quat"):
        before = Rotation.from_quat(getattr(rec, quat), scalar_first=True).apply(rec.mag)
        after = Rotation.from_quat(getattr(new, quat), scalar_first=True).apply(new.mag)
        np.testing.assert_allclose(after, before, atol=1e-12)
    assert_array_equal(new.streams["velocity"].values, field), "a vector of the earth frame is not turned"
    assert new.meta["remapped"] == axes


@pytest.mark.parametrize("axes", ["x,y", "x,y,y", "x,y,-z", "a,b,c", "-x,y,z"])
def test_axes_that_are_no_rotation_are_refused(axes: str) -> None:
    with pytest.raises(ValueError, match="axes"):
        made().remapped(axes)


def test_streams_that_do_not_fit_are_refused() -> None:
    cases = {
        "gyr: expected values of shape": {"gyr": (GYR_T, np.ones((200, 2)))},
        "decrease": {"gyr": (GYR_T[::-1], np.ones((200, 3)))},
        "finite": {"gyr": (np.where(GYR_T == 0.5, np.nan, GYR_T), np.ones((200, 3)))},
        "n rows of values": {"gyr": (GYR_T, np.ones((199, 3)))},
        "at least one sensor": {},
    }
    for message, streams in cases.items():
        with pytest.raises(ValueError, match=message):
            ar.Recording.from_streams(**streams)


def test_filters_run_on_the_stamps_of_a_recording() -> None:
    """The README's own example: rows that are not regular, and stamps that say so."""
    rec = ar.simulate.demo(duration=20.0, rate=100.0, seed=3)
    keep = np.random.default_rng(4).random(len(rec)) > 0.3
    keep[0] = True
    few = ar.Recording(t=rec.t[keep], gyr=rec.gyr[keep], acc=rec.acc[keep], mag=rec.mag[keep], ref=rec.ref[keep])
    f = ar.VQF(rate=few.rate)
    assert_array_equal(f.run(few).quat, f.run(few.gyr, few.acc, few.mag, t=few.t).quat)
    assert_array_equal(f.run(few).t, few.t)


def test_every_way_to_run_takes_recordings() -> None:
    recs = [ar.simulate.demo(duration=4.0, rate=50.0, seed=seed) for seed in (0, 1)]
    single = [ar.VQF(rate=50.0).run(rec).quat for rec in recs]
    for one, est in zip(single, ar.run_many(ar.VQF(rate=50.0), recs), strict=True):
        assert_array_equal(est.quat, one)
    swept = ar.sweep(ar.Madgwick, {"beta": [0.05, 0.1]}, recs)
    alone = [ar.metrics.score(ar.Madgwick(rate=50.0, beta=0.1).run(rec).quat, rec.ref, rec.mask).total for rec in recs]
    np.testing.assert_allclose(swept.errors[1], alone, rtol=1e-6)
