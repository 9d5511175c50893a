"""The result of a run: frozen, and the same attitudes in every form."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import sys
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from ahrs_rs._optional import version
from cases import Case, each_case
from oracle.mahony import add
from oracle.so3 import cross, rotate, rotate_inverse, unit
from signals import RATE, gappy, motion, multiply, poses, random_turns, rotation, still

#: A few roundings of numbers up to 2π.
ROUNDING = 4e-15


#: Whether scipy has rotations of any leading shape.
SEVERAL = version("scipy") >= (1, 17)


def estimate(quat: NDArray[Any]) -> ar.Estimate:
    """An estimate of nothing but these attitudes."""
    status = np.zeros(quat.shape[:-1], np.uint16)
    return ar.Estimate(quat, None, status, np.arange(quat.shape[-2]) / RATE, ar.Tilt().state(), {})


def of_run(n: int | None = None, **keywords: Any) -> ar.Estimate:
    signals = gappy(motion(40, 1), 2)
    arrays = signals.sensors() if n is None else [np.stack([a] * n) for a in signals.sensors()]
    return ar.Mahony(rate=RATE).run(*arrays, **keywords)


def test_an_estimate_is_frozen() -> None:
    est = of_run(outputs=("innovation",))
    for field in dataclasses.fields(est):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(est, field.name, None)
    with pytest.raises(TypeError, match="does not support item assignment"):
        est.extra["innovation"] = est.quat


def test_stamps_and_state_are_made_once_and_the_readings_are_let_go() -> None:
    gyr = np.zeros((40, 3))
    gone = weakref.ref(gyr)
    est = ar.Mahony(rate=RATE).run(gyr)
    del gyr
    assert gone() is None, "what is made later keeps no array that was given"
    assert est.t is est.t
    assert est.state is est.state
    assert np.array_equal(est.t, np.arange(40) / RATE)
    with pytest.raises(AttributeError, match="'Estimate' object has no attribute 'stamps'"):
        _ = est.stamps


def test_stamps_are_those_that_were_given_whatever_happens_to_them() -> None:
    t = list(np.arange(40) / RATE)
    est = of_run(t=t)
    t[0] = -1.0
    assert est.t[0] == 0.0
    assert of_run(t=est.t).t is est.t


def test_shapes_and_dtypes_are_those_of_the_documentation() -> None:
    for n, leading in ((None, (40,)), (3, (3, 40))):
        est = of_run(n, outputs=("innovation",))
        assert est.quat.shape == (*leading, 4)
        assert est.gyr_bias.shape == (*leading, 3)
        assert est.status.shape == leading
        assert est.status.dtype == np.uint16
        assert est.extra["innovation"].shape == (*leading, 3)
        assert est.matrix().shape == (*leading, 3, 3)
        assert est.euler().shape == (*leading, 3)
        if n is None or SEVERAL:
            assert est.rotation().as_quat().shape == (*leading, 4)
        assert len(est) == 40
        assert est.covariance is None
        assert isinstance(est.state, list) == (n is not None)
        assert f"quat{est.quat.shape}" in repr(est)


@each_case
def test_a_bias_is_given_by_the_filters_that_estimate_one(case: Case) -> None:
    est = case.run(motion(5, 3))
    f = case.make()
    assert (est.gyr_bias is None) == (f.gyr_bias is None)
    if case.bias_left is not None:
        assert est.gyr_bias is not None


@pytest.mark.parametrize("clone", [lambda e: pickle.loads(pickle.dumps(e)), copy.deepcopy], ids=["pickle", "deepcopy"])
def test_an_estimate_can_be_sent_to_another_process(clone: Callable[[ar.Estimate], ar.Estimate]) -> None:
    est = of_run(outputs=("innovation",))
    again = clone(est)
    assert np.array_equal(again.quat, est.quat)
    assert np.array_equal(again.extra["innovation"], est.extra["innovation"])
    assert again.state == est.state


# Time.


def test_t_is_what_was_given_or_counts_from_zero_at_the_rate() -> None:
    signals = motion(10, 4)
    f = ar.Tilt(rate=RATE)
    assert np.array_equal(f.run(signals.gyr, t=signals.t).t, signals.t)
    first = f.run(signals.gyr)
    assert np.allclose(first.t, np.arange(10) / RATE, atol=1e-15, rtol=0)
    # A run that goes on from a state goes on in time.
    assert np.allclose(f.run(signals.gyr, state=first.state).t, np.arange(10, 20) / RATE, atol=1e-15, rtol=0)
    both = np.stack((signals.gyr, signals.gyr))
    assert f.run(both).t.shape in ((10,), (2, 10))
    t = np.stack((signals.t, signals.t + 1.0))
    assert np.array_equal(f.run(both, t=t).t, t)


# Forms of the attitude. Angles of the intrinsic sequence z, y', x'' are given as roll, pitch, yaw.


def test_euler_angles_are_those_of_scipy_in_reverse_order() -> None:
    quat = random_turns(1000, 5).as_quat(scalar_first=True)
    expected = rotation(quat).as_euler("ZYX")[:, ::-1]
    # scipy's and our formulas each lose up to 1/cos(pitch) digits; 1000 random pitches come within 2e-3 of 90°.
    assert np.abs(estimate(quat).euler() - expected).max() < 1e-12
    assert np.abs(estimate(quat).euler(degrees=True) - np.degrees(expected)).max() < 1e-10


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-7, -np.pi / 2 + 1e-9])
def test_euler_angles_give_the_attitude_back_at_and_near_vertical(pitch: float) -> None:
    rng = np.random.default_rng(6)
    yaw, roll = rng.uniform(-np.pi, np.pi, (2, 100))
    half = 0.5 * np.stack((yaw, np.full(100, pitch), roll))
    (cy, cp, cr), (sy, sp, sr) = np.cos(half), np.sin(half)
    zero = 0.0 * cy
    z, y, x = (np.stack(parts, axis=1) for parts in ((cy, zero, zero, sy), (cp, zero, sp, zero), (cr, sr, zero, zero)))
    quat = multiply(multiply(z, y), x)
    angles = estimate(quat).euler()
    back = Rotation.from_euler("ZYX", angles[:, ::-1])
    assert (back.inv() * rotation(quat)).magnitude().max() < ROUNDING
    assert np.abs(angles[:, 1]).max() <= np.pi / 2
    if abs(pitch) == np.pi / 2:
        assert np.all(angles[:, 0] == 0.0), "only yaw ± roll is defined: roll is zero"


def test_euler_angles_are_in_their_ranges_for_every_pose_of_a_cube() -> None:
    quat = poses(0, 0)
    for attitude in (quat, -quat, quat.astype(np.float32)):
        angles = estimate(attitude).euler()
        assert angles.dtype == attitude.dtype
        assert np.abs(angles[:, [0, 2]]).max() <= attitude.dtype.type(np.pi)
        assert np.abs(angles[:, 1]).max() <= attitude.dtype.type(np.pi / 2)
        back = Rotation.from_euler("ZYX", angles[:, ::-1].astype(np.float64))
        tolerance = 10 * np.finfo(attitude.dtype).eps
        assert (back.inv() * rotation(quat)).magnitude().max() < tolerance


def test_matrices_and_rotations_are_those_of_scipy() -> None:
    quat = random_turns(1000, 7).as_quat(scalar_first=True)
    est = estimate(quat)
    assert np.abs(est.matrix() - rotation(quat).as_matrix()).max() < ROUNDING
    assert np.abs(est.rotation().as_quat(scalar_first=True) - quat).max() < ROUNDING
    three = estimate(quat.reshape(10, 100, 4))
    assert np.array_equal(three.matrix().reshape(-1, 3, 3), est.matrix())
    assert np.array_equal(three.euler().reshape(-1, 3), est.euler())
    if SEVERAL:
        assert np.array_equal(three.rotation().as_matrix().reshape(-1, 3, 3), est.rotation().as_matrix())


def test_rotations_of_several_recordings_need_a_scipy_that_knows_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ahrs_rs._estimate.version", lambda package: (1, 16))
    assert len(of_run().rotation()) == 40
    with pytest.raises(ImportError, match=r"needs scipy 1\.17 or later: pip install 'scipy>=1\.17'"):
        of_run(3).rotation()


@pytest.mark.skipif(not SEVERAL, reason="needs scipy 1.17")
def test_rotation_takes_the_sensors_up_to_the_earths() -> None:
    truth = poses(10, 8)
    sensors = still(truth, 2)
    est = ar.Ecompass(rate=RATE).run(**sensors)
    up = est.rotation().apply(sensors["acc"])
    assert np.abs(up - [0.0, 0.0, 9.80665]).max() < 10 * ROUNDING
    assert np.abs((est.matrix() @ sensors["acc"][..., None])[..., 0] - up).max() < 10 * ROUNDING


# Tables.

COLUMNS = ["t", "qw", "qx", "qy", "qz", "roll", "pitch", "yaw", "bias_x", "bias_y", "bias_z"]


@pytest.mark.parametrize("package", ["polars", "pandas"])
def test_to_frame_is_a_table_of_whichever_package_there_is(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if package == "pandas":
        monkeypatch.setitem(sys.modules, "polars", None)
    est = of_run(outputs=("innovation",))
    table = est.to_frame()
    named = est.to_pandas() if package == "pandas" else est.to_polars()
    assert named.equals(table)
    assert isinstance(table, pl.DataFrame if package == "polars" else pd.DataFrame)
    assert list(table.columns) == [*COLUMNS, *(f"innovation_{i}" for i in range(3)), "status"]
    expected = np.column_stack((est.t, est.quat, est.euler(), est.gyr_bias, est.extra["innovation"], est.status))
    assert np.array_equal(table.to_numpy(), expected)


def test_to_frame_of_many_recordings_says_which_is_which() -> None:
    est = of_run(3)
    table = est.to_frame()
    assert table["recording"].to_list() == [0] * 40 + [1] * 40 + [2] * 40
    assert np.array_equal(table["qz"].to_numpy(), est.quat[..., 3].ravel())
    assert np.array_equal(table["t"].to_numpy(), np.tile(np.arange(40) / RATE, 3))
    no_bias = ar.Tilt(rate=RATE).run(np.zeros((5, 3))).to_frame()
    assert [c for c in no_bias.columns if c.startswith("bias")] == []


def test_to_frame_without_a_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "polars", None)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install ahrs-rs\[io\]"):
        of_run().to_frame()
    with pytest.raises(ImportError, match=r"to_pandas needs pandas: pip install ahrs-rs\[io\]"):
        of_run().to_pandas()
    with pytest.raises(ImportError, match="to_polars needs polars: pip install polars"):
        of_run().to_polars()


# Further outputs.


@each_case
def test_every_output_can_be_asked_for_and_changes_nothing_else(case: Case) -> None:
    signals = motion(50, 9)
    plain = case.run(signals)
    assert plain.extra == {}
    for name in case.cls.OUTPUTS:
        est = case.run(signals, outputs=(name,))
        assert list(est.extra) == [name]
        assert est.extra[name].shape[0] == 50
        # Sample 0 aligns: what the measurements show is NaN there, as that of an unused sensor is.
        known = np.isfinite(est.extra[name])
        may_lack = (case.kalman and name != "covariance") or "NaN" in case.cls.OUTPUTS[name]
        assert np.all(known[2:] == known[1]) if may_lack else known.all()
        assert known[1].any()
        assert np.array_equal(est.quat, plain.quat)
        assert np.array_equal(case.run(signals, outputs=name).extra[name], est.extra[name], equal_nan=True)
    both = tuple(case.cls.OUTPUTS) * 2
    assert set(case.run(signals, outputs=both).extra) == set(both)
    with pytest.raises(ValueError, match=f"outputs: expected names from .* for {case.name}, got 'nothing'"):
        case.run(signals, outputs=("nothing",))


def test_mahonys_innovation_is_the_error_of_the_directions_at_the_attitude_before() -> None:
    signals = motion(200, 10)
    est = ar.Mahony(rate=RATE).run(*signals.sensors(), outputs=("innovation",))
    for k in range(1, 200):
        q, acc, mag = tuple(est.quat[k - 1]), unit(tuple(signals.acc[k])), unit(tuple(signals.mag[k]))
        x, y, z = rotate(q, mag)
        field = (0.0, float(np.hypot(x, y)), z)
        up = rotate_inverse(q, (0.0, 0.0, 1.0))
        error = add(cross(acc, up), cross(mag, rotate_inverse(q, field)))
        assert np.abs(est.extra["innovation"][k] - error).max() < 1e-14


def test_madgwicks_innovation_turns_at_two_radians_per_second_and_unit_of_beta() -> None:
    signals = motion(200, 11)
    est = ar.Madgwick(rate=RATE).run(*signals.sensors(), outputs=("innovation",))
    assert np.abs(np.linalg.norm(est.extra["innovation"][1:], axis=1) - 2.0).max() < ROUNDING
