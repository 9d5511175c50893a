"""Fusion equals the imufusion package, and keeps what its options promise."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import imufusion
import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import Status
from signals import (
    GRAVITY,
    RATE,
    Floats,
    about_z,
    angle_between,
    conjugate,
    disturbed,
    motion,
    multiply,
    poses,
    still,
)

#: The original computes in float32: its rounding of 6e-8 a step adds up in what no feedback forgets. The float32 run
#: does the same sums in another order; measured at most 1.7e-6 rad over 13,514 samples.
FLOAT32 = 1e-5
#: The float64 run does not round; the original's products of degrees and radians are off by 1e-7, a rate of 6 rad/s by
#: 6e-7 rad/s, for minutes in 6D: measured 2.2e-5.
FLOAT64 = 1e-4
#: Degrees by which the errors' angles may differ: the arc sine of a float32 close to 1 is off by √(2·6e-8) rad = 0.02°.
ERROR = 0.05

REJECTION = {"acceleration_rejection": 10.0, "magnetic_rejection": 10.0, "rejection_timeout": 5.0}
#: Parameters, those of the bias (or None), and whether with a magnetometer.
GRID: list[tuple[dict[str, float], dict[str, float] | None, bool]] = [
    ({}, None, True),
    ({}, None, False),
    ({"gain": 0.0}, None, True),
    ({"gain": 0.0, **REJECTION}, None, True),
    ({"gain": 2.0}, None, True),
    ({"gain": 12.0}, None, True),
    ({"gain": 2.0, **REJECTION}, None, True),
    ({"gyroscope_range": 300.0}, None, True),
    ({"gyroscope_range": 100.0, "gain": 0.1}, {"stationary_threshold": 20.0, "stationary_period": 0.5}, False),
    ({"acceleration_rejection": 10.0, "magnetic_rejection": 10.0}, None, True),  # without a timeout nothing is rejected
    ({"rejection_timeout": 5.0}, None, True),
    ({"gyroscope_range": 2000.0, **REJECTION}, {}, True),
    ({"gyroscope_range": 250.0, **REJECTION, "rejection_timeout": 0.5}, {}, True),
    ({**REJECTION, "rejection_timeout": 1.0}, None, False),
    ({"acceleration_rejection": 2.0, "rejection_timeout": 2.0}, None, False),
    ({"acceleration_rejection": 90.0, "magnetic_rejection": 3.0, "rejection_timeout": 10.0, "gain": 0.1}, None, True),
    ({"magnetic_rejection": 20.0, "rejection_timeout": 3.0}, {"stationary_threshold": 1.0}, True),
]


def original(
    params: dict[str, float],
    bias: dict[str, float] | None,
    sensors: tuple[Floats, Floats, Floats | None],
    q0: Floats,
    rate: float,
) -> dict[str, Any]:
    """Attitudes in east-north-up, biases in rad/s and outputs of the package, sample by sample."""
    settings = imufusion.AhrsSettings(sample_rate=rate, **params)
    settings.convention = imufusion.CONVENTION_ENU  # the constructor takes no notice of it
    ahrs = imufusion.Ahrs()
    ahrs.set_settings(settings)
    ahrs.set_quaternion(q0.astype(np.float32))
    offset = imufusion.Bias()
    offset.set_settings(imufusion.BiasSettings(sample_rate=rate, **(bias or {})))
    gyr, acc, mag = sensors
    mag = np.zeros_like(acc) if mag is None else mag
    arrays = (np.degrees(gyr), acc / GRAVITY, mag)
    quats, biases = [], []
    outputs: dict[str, list[float]] = {name: [] for name in ar.Fusion.OUTPUTS}
    for w, a, m in zip(*(array.astype(np.float32) for array in arrays), strict=True):
        # A magnetometer of zeros is one that is not there; `update_no_magnetometer` zeroes the heading at the start.
        ahrs.update(w if bias is None else offset.update(w), a, m)
        quats.append(ahrs.get_quaternion())
        biases.append(np.radians(offset.get_offset()))
        states, flags = ahrs.get_internal_states(), ahrs.get_flags()
        for name, values in outputs.items():
            values.append(float(getattr(states if hasattr(states, name) else flags, name)))
    return {
        "quat": np.array(quats, np.float64),
        "bias": np.array(biases),
        **{k: np.array(v) for k, v in outputs.items()},
    }


def compare(params: dict[str, float], bias: dict[str, float] | None, sensors: Any, q0: Floats, rate: float) -> None:
    """Both dtypes against the package; in float32 the decisions are the same sample by sample."""
    expected = original(params, bias, sensors, q0, rate)
    f = ar.Fusion(rate=rate, bias=bias is not None, **params, **(bias or {}))
    for dtype, bound in ((np.float32, FLOAT32), (np.float64, FLOAT64)):
        arrays = (None if array is None else array.astype(dtype) for array in sensors)
        est = f.run(*arrays, q0=q0, outputs=tuple(f.OUTPUTS))
        assert angle_between(est.quat, expected["quat"]).max() < bound
        assert est.gyr_bias is not None
        assert np.abs(est.gyr_bias - expected["bias"]).max() < 1e-8 if bias is not None else not est.gyr_bias.any()
        for name, values in est.extra.items():
            if "error" in name:
                assert np.isnan(values).all() or np.abs(values - expected[name]).max() < ERROR, name
            elif "trigger" in name:
                # Counts as parts of the timeout; time is as exact as float32.
                assert np.abs(values - expected[name]).max() < 1e-6, name
            elif dtype is np.float32 or name not in ("startup", "overrange_recovery"):
                assert np.array_equal(values, expected[name]), name
            else:
                # Whether n falls of the gain reach its value exactly is a matter of rounding: one sample a start.
                starts = np.sum(np.diff(expected["startup"], prepend=0.0) > 0.0)
                assert np.sum(values != expected[name]) <= starts, name
        assert np.array_equal(est.status & Status.ACC_REJECTED > 0, est.extra["accelerometer_ignored"] > 0.0)
        if sensors[2] is not None:
            assert np.array_equal(est.status & Status.MAG_REJECTED > 0, est.extra["magnetometer_ignored"] > 0.0)
        recovers = sum(est.extra[f"{name}_recovery"] for name in ("acceleration", "magnetic", "overrange"))
        assert np.array_equal(est.status & Status.RECOVERING > 0, recovers > 0.0)


def upset() -> tuple[Floats, Floats, Floats]:
    """A sensor that rests, moves, is pushed and shaken, and passes a magnet and stays there."""
    signals = disturbed()
    gyr, acc, mag = signals.sensors()
    gyr[1700:1705] *= 20.0
    return gyr, acc, mag


@pytest.mark.parametrize(("params", "bias", "nine"), GRID, ids=str)
def test_a_simulated_recording_is_as_of_imufusion(
    params: dict[str, float], bias: dict[str, float] | None, nine: bool
) -> None:
    gyr, acc, mag = upset()
    q0 = ar.Ecompass(rate=RATE).run(gyr[:1], acc[:1], mag[:1]).quat[0]
    compare(params, bias, (gyr, acc, mag if nine else None), q0, RATE)


def test_the_simulated_recording_reaches_every_flag() -> None:
    gyr, acc, mag = upset()
    f = ar.Fusion(rate=RATE, bias=True, gyroscope_range=250.0, **(REJECTION | {"rejection_timeout": 0.5}))
    est = f.run(gyr, acc, mag, outputs=tuple(f.OUTPUTS))
    for name in f.OUTPUTS:
        if "error" not in name:
            assert est.extra[name].min() == 0.0, name
            assert est.extra[name].max() > 0.0, name
    for bit in (Status.ACC_REJECTED, Status.MAG_REJECTED, Status.RECOVERING, Status.REST):
        assert (est.status & bit).any(), bit


@pytest.mark.parametrize(("params", "bias", "nine"), GRID, ids=str)
def test_the_real_recording_is_as_of_imufusion(
    data_folder: Path, params: dict[str, float], bias: dict[str, float] | None, nine: bool
) -> None:
    r = ar.read(data_folder / "fusion" / "sensor_data.csv")
    assert r.acc is not None
    assert r.mag is not None
    q0 = ar.Ecompass(rate=RATE).run(r.gyr[:1], r.acc[:1], r.mag[:1]).quat[0]
    compare(params, bias, (r.gyr, r.acc, r.mag if nine else None), q0, RATE)


@pytest.mark.parametrize("rate", [50.0, 285.7, 500.0])
def test_other_rates_are_as_of_imufusion(rate: float) -> None:
    # Rates at which the original's rounding does not make the start a sample longer: that sample rejects nothing yet.
    signals = motion(4000, 3, rate=rate, noise=0.2)
    compare(
        {**REJECTION, "rejection_timeout": 0.4, "gyroscope_range": 280.0}, {}, signals.sensors(), signals.before, rate
    )


@pytest.mark.parametrize("angle", [0.5, 1.5, 1.65, 2.5, -3.0])
@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
def test_wrong_starts_are_as_of_imufusion(angle: float, nine: bool) -> None:
    # Headings that are wrong by more than 90° too, where the feedback no longer falls with the sine.
    for k, pose in enumerate(poses(3, 5)[::3]):
        sensors = still(pose, 500, nine=nine)
        turn = (
            about_z(angle) if k % 2 else np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.full(3, 3**-0.5))])
        )
        compare({}, None, tuple(sensors.values()), multiply(turn, pose), RATE)


def test_other_frames_are_as_of_imufusions_conventions() -> None:
    gyr, acc, mag = upset()
    for frame in ("NWU", "NED"):
        f = ar.Fusion(rate=RATE, frame=frame)
        est = f.run(gyr, acc, mag)
        settings = imufusion.AhrsSettings(sample_rate=RATE)
        settings.convention = getattr(imufusion, f"CONVENTION_{frame}")
        ahrs = imufusion.Ahrs()
        ahrs.set_settings(settings)
        ahrs.set_quaternion(est.quat[0].astype(np.float32))
        # The first sample aligns without a step of the gain; from there on the package is one step of it behind.
        expected = f.run(gyr[1:], acc[1:], mag[1:], q0=est.quat[0]).quat
        sensors = zip(np.degrees(gyr[1:]), acc[1:] / GRAVITY, mag[1:], strict=True)
        quats = [ahrs.update(*(v.astype(np.float32) for v in row)).get_quaternion() for row in sensors]
        assert angle_between(np.array(quats, np.float64), expected).max() < FLOAT64


def test_without_a_magnetometer_only_the_zero_of_the_heading_differs_from_imufusions_update() -> None:
    gyr, acc, _ = upset()
    q0 = ar.Tilt(rate=RATE).run(gyr[:1], acc[:1]).quat[0]
    settings = imufusion.AhrsSettings(sample_rate=RATE)
    settings.convention = imufusion.CONVENTION_ENU
    ahrs = imufusion.Ahrs()
    ahrs.set_settings(settings)
    ahrs.set_quaternion(q0.astype(np.float32))
    sensors = zip(np.degrees(gyr), acc / GRAVITY, strict=True)
    quats = [ahrs.update_no_magnetometer(*(v.astype(np.float32) for v in row)).get_quaternion() for row in sensors]
    between = multiply(ar.Fusion(rate=RATE).run(gyr, acc, q0=q0).quat, conjugate(np.array(quats, np.float64)))
    assert np.hypot(between[:, 1], between[:, 2]).max() < FLOAT64
    started = between[310:]
    assert angle_between(started, started[0]).max() < FLOAT64


# What the original leaves open.


def test_times_are_times_whatever_the_step() -> None:
    # The same rest and the same wrong field, sampled at 50 and 200 Hz and with steps of all lengths.
    params: dict[str, Any] = {"magnetic_rejection": 10.0, "rejection_timeout": 2.0, "bias": True}
    rng = np.random.default_rng(1)
    uneven = np.cumsum(rng.uniform(0.0, 0.02, 1500))
    for t in (np.arange(0.0, 15.0, 0.02), np.arange(0.0, 15.0, 0.005), uneven):
        sensors = still([1.0, 0.0, 0.0, 0.0], len(t))
        field_turned = t > 6.0
        sensors["mag"][field_turned] = [30.0, 5.0, -40.0]
        est = ar.Fusion(**params).run(**sensors, t=t, outputs=("startup", "magnetic_recovery"))
        step = np.diff(t).max()
        assert t[est.extra["startup"] > 0.0].max() - t[0] == pytest.approx(3.0, abs=step)
        assert t[est.status & Status.REST > 0].min() - t[0] == pytest.approx(3.0, abs=2.0 * step)
        rejected = est.status & Status.MAG_REJECTED > 0
        assert t[rejected].min() == pytest.approx(6.0, abs=step)
        assert t[est.extra["magnetic_recovery"] > 0.0].min() - t[rejected].min() == pytest.approx(2.0, abs=2.0 * step)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("rate", [100.0, 119.0, 1000.0])
def test_a_timeout_of_n_samples_rejects_n_of_them(rate: float, dtype: type) -> None:
    # After a minute of rejection too, whose sum of float32 steps would be off by a hundred samples.
    for seconds in (1.0, 60.0) if rate == 1000.0 else (1.0, 7.0):
        settled = int(4 * rate)
        sensors = still([1.0, 0.0, 0.0, 0.0], settled + int(seconds * rate) + 20)
        sensors["mag"][settled:] = [30.0, 5.0, -40.0]
        f = ar.Fusion(rate=rate, gain=1e-3, magnetic_rejection=10.0, rejection_timeout=seconds)
        est = f.run(*(sensors[name].astype(dtype) for name in ("gyr", "acc", "mag")))
        assert np.sum(est.status & Status.MAG_REJECTED > 0) == int(seconds * rate)


def test_the_bias_is_found_at_rest_with_the_time_constant_of_the_cut_off() -> None:
    bias = np.array([0.01, -0.02, 0.015])
    sensors = still(poses(4, 2)[::7], 6000)
    est = ar.Fusion(rate=RATE, bias=True).run(sensors["gyr"] + bias, sensors["acc"], sensors["mag"])
    assert est.gyr_bias is not None
    assert not est.gyr_bias[:, :300].any()
    t = np.arange(5600) / RATE
    left = bias - est.gyr_bias[:, 301:5901]
    expected = bias * np.exp(-2.0 * math.pi * 0.02 * t)[:, None]
    # n steps of 1 - c for exp(-nc), c = 1.26e-3, are off by at most c/2e, and the first one or two steps by c each.
    assert np.abs(left - expected).max() < 0.02 * 2.0 * 2.0 * math.pi * 0.02 / RATE
    assert not np.any(est.status[:, :300] & Status.REST)
    assert np.all(est.status[:, 302:] & Status.REST)


def test_a_rate_above_the_threshold_is_no_rest() -> None:
    sensors = still([1.0, 0.0, 0.0, 0.0], 1000)
    for axis, sign in itertools.product(range(3), (1.0, -1.0)):
        gyr = sensors["gyr"].copy()
        gyr[:, axis] = sign * math.radians(3.01)
        f = ar.Fusion(rate=RATE, bias=True)
        est = f.run(gyr, sensors["acc"], sensors["mag"])
        assert not np.any(est.status & Status.REST)
        assert f.run(0.99 * gyr, sensors["acc"]).status[-1] & Status.REST


def test_in_a_gap_the_feedback_does_not_pass_the_error() -> None:
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for angle in (0.2, 1.0, 1.5):
        q0 = np.array([math.cos(angle / 2), math.sin(angle / 2), 0.0, 0.0])
        sensors = {name: array[None] for name, array in zip(("gyr", "acc", "mag"), np.zeros((3, 3)), strict=True)}
        sensors["acc"] = np.array([[0.0, 0.0, GRAVITY]])
        est = ar.Fusion(rate=1.0 / 30.0).run(sensors["gyr"], sensors["acc"], q0=q0)
        # sin θ at once, by 2 atan of half of it.
        assert angle_between(est.quat[0], q) == pytest.approx(angle - 2.0 * math.atan(0.5 * math.sin(angle)), abs=1e-12)


@pytest.mark.parametrize("value", [-1.0, -1e-300, math.nan, math.inf])
@pytest.mark.parametrize("name", [name for name, spec in ar.Fusion.PARAMS.items() if spec.options is None])
def test_no_time_and_no_threshold_is_negative_or_not_finite(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: expected a number in \[.*\] (s|rad/s|°|°/s), got"):
        ar.Fusion(**{name: value})


def test_a_threshold_of_zero_is_refused_where_it_does_not_mean_none() -> None:
    with pytest.raises(ValueError, match=r"^stationary_threshold: expected a number in \[1e-06, 1e\+06\] °/s, got 0.0"):
        ar.Fusion(stationary_threshold=0.0)


@pytest.mark.parametrize("value", [0, 1, 1.0, "True", None, np.ones(1, bool)], ids=repr)
def test_a_switch_is_true_or_false(value: object) -> None:
    with pytest.raises(ValueError, match=r"^bias: expected one of False, True, got"):
        ar.Fusion(bias=value)  # type: ignore[arg-type]


def test_a_switch_that_was_given_is_the_one_that_is_told() -> None:
    for on in (True, False):
        assert ar.Fusion(bias=on).params["bias"] is on
        assert ar.Fusion(bias=np.bool_(on)).bias is on
    assert ar.Fusion().bias is False
