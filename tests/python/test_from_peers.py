"""Rows of docs/from-peers.md: the same inputs through `ahrs`, `vqf`, `imufusion` and through ours."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from signals import GRAVITY, RATE, Floats, Signals, angle_between, motion, quats, random_turns, rotation

SAMPLES = 1000
#: Rounding over 1000 samples, and of a heading offset that adds up.
AGREEMENT, OVER_TIME = 1e-12, 1e-10
#: Rounding of float32, in which imufusion computes, over 1000 samples.
FLOAT32 = 1e-5


@pytest.fixture(scope="module")
def signals() -> Signals:
    return motion(SAMPLES, 1)


@pytest.fixture(scope="module")
def ahrs() -> Any:
    return pytest.importorskip("ahrs", reason="the package ahrs is not installed")


@pytest.fixture(scope="module")
def vqf() -> Any:
    return pytest.importorskip("vqf", reason="the package vqf is not installed")


@pytest.fixture(scope="module")
def imufusion() -> Any:
    return pytest.importorskip("imufusion", reason="the package imufusion is not installed")


def attitudes(count: int, seed: int) -> Floats:
    return quats(random_turns(count, seed))


# ---------------------------------------------------------------- ahrs


def test_ahrs_mahony(ahrs: Any, signals: Signals) -> None:
    start = attitudes(1, 2)[0]
    gyr, acc, mag = signals.sensors()
    peer = ahrs.filters.Mahony(gyr=gyr, acc=acc, mag=mag, frequency=RATE, k_P=1.0, k_I=0.3, q0=start)
    f = ar.Mahony(rate=RATE, kp=1.0, ki=0.3, integration="first-order")
    est = f.run(gyr[1:], acc[1:], mag[1:], q0=start)
    assert angle_between(peer.Q[1:], est.quat).max() < AGREEMENT


def test_ahrs_madgwick(ahrs: Any, signals: Signals) -> None:
    gyr, acc, mag = signals.sensors()
    peer, q, expected = ahrs.filters.Madgwick(frequency=RATE, gain=0.041), attitudes(1, 3)[0], []
    start = q
    for sample in zip(gyr, acc, mag, strict=True):
        q = peer.updateMARG(q, *sample)
        expected.append(q)
    f = ar.Madgwick(rate=RATE, beta=0.041, gradient="paper", integration="first-order", frame="NWU")
    assert angle_between(expected, f.run(gyr, acc, mag, q0=start).quat).max() < AGREEMENT


def test_ahrs_angular_rate(ahrs: Any, signals: Signals) -> None:
    start = attitudes(1, 4)[0]
    peer = ahrs.filters.AngularRate(gyr=signals.gyr, q0=start, frequency=RATE, method="closed")
    est = ar.GyroIntegration(rate=RATE).run(signals.gyr[1:], q0=start)
    assert angle_between(peer.Q[1:], est.quat).max() < AGREEMENT


def test_ahrs_complementary(ahrs: Any) -> None:
    # Turns about one axis: it adds angular rates to Euler angles.
    angle, gain = 1.5 * np.sin(np.arange(SAMPLES) / RATE), 0.97
    gyr = np.zeros((SAMPLES, 3))
    gyr[1:, 0] = np.diff(angle) * RATE
    acc = GRAVITY * np.column_stack((0.0 * angle, np.sin(1.1 * angle), np.cos(1.1 * angle)))
    peer = ahrs.filters.Complementary(gyr=gyr, acc=acc, frequency=RATE, gain=gain)
    f = ar.Complementary(rate=RATE, tau=gain / (1.0 - gain) / RATE)
    assert np.abs(f.run(gyr, acc).euler()[:, :2] - peer.W[:, :2]).max() < AGREEMENT


def test_ahrs_tilt(ahrs: Any, signals: Signals) -> None:
    peer = ahrs.filters.Tilt(acc=signals.acc, mag=signals.mag).Q
    assert angle_between(peer, ar.attitude.fqa(signals.acc, signals.mag, frame="NWU")).max() < AGREEMENT
    peer = ahrs.filters.Tilt(acc=signals.acc).Q
    assert angle_between(peer, ar.attitude.fqa(signals.acc)).max() < AGREEMENT


@pytest.mark.parametrize(("frame", "sign"), [("ENU", 1.0), ("NED", -1.0)])
def test_ahrs_ecompass(ahrs: Any, signals: Signals, frame: str, sign: float) -> None:
    # In NED it takes gravity, which is down, in place of the specific force.
    ecompass = ahrs.common.orientation.ecompass
    rows = zip(signals.acc[:50], signals.mag[:50], strict=True)
    peer = [ecompass(a, m, frame=frame, representation="quaternion") for a, m in rows]
    ours = ar.attitude.fqa(sign * signals.acc[:50], signals.mag[:50], frame=frame)
    assert angle_between(peer, ours).max() < AGREEMENT


def test_ahrs_metrics(ahrs: Any) -> None:
    p, q = attitudes(40, 5), attitudes(40, 6)
    peer = ahrs.utils.metrics
    assert np.abs(peer.qad(p, q) - ar.metrics.total_error(p, q)).max() < AGREEMENT
    assert np.abs(peer.qdist(p, q) - ar.metrics.chordal_distance(p, q)).max() < AGREEMENT
    assert np.abs(2.0 * peer.qcip(p, q) - ar.metrics.total_error(p, q)).max() < AGREEMENT
    assert np.abs(peer.qeip(p, q) - ar.metrics.inner_product_distance(p, q)).max() < AGREEMENT


def test_ahrs_euler_angles(ahrs: Any, signals: Signals) -> None:
    est = ar.Madgwick(rate=RATE).run(*signals.sensors())
    assert np.abs(ahrs.QuaternionArray(est.quat).to_angles() - est.euler()).max() < 1e-9  # near ±90° of pitch too


def test_ahrs_earth(ahrs: Any) -> None:
    pytest.importorskip("pygeomag", reason="the package pygeomag is not installed")
    peer = ahrs.utils.WMM(latitude=52.52, longitude=13.4, height=0.034, date=2025.5)
    field = ar.earth.field(52.52, 13.4, 34.0, 2025.5)
    for theirs, ours in ((peer.X, field.north), (peer.Y, field.east), (-peer.Z, field.up), (peer.F, field.norm)):
        assert 1e-3 * theirs == pytest.approx(ours, abs=1e-6)
    assert math.radians(peer.D) == pytest.approx(field.declination, abs=1e-9)
    assert math.radians(peer.I) == pytest.approx(field.dip, abs=1e-9)
    gravity = ahrs.utils.WGS().normal_gravity(52.52, 34.0)
    assert gravity == pytest.approx(ar.earth.gravity(52.52, 34.0), abs=1e-9)


# ---------------------------------------------------------------- vqf


def test_vqf_on_whole_arrays(vqf: Any, signals: Signals) -> None:
    peer = vqf.VQF(1.0 / RATE, tauAcc=2.0, magDistRejectionEnabled=False).updateBatchFullState(*signals.sensors())
    f = ar.VQF(rate=RATE, tau_acc=2.0, mag_dist_rejection_enabled=False)
    est = f.run(*signals.sensors(), outputs=tuple(f.OUTPUTS))
    assert angle_between(peer["quat9D"], est.quat).max() < OVER_TIME
    assert angle_between(peer["quat6D"], est.extra["quat6d"]).max() < OVER_TIME
    assert np.abs(peer["bias"] - est.gyr_bias).max() < OVER_TIME
    for theirs, name in (("restDetected", "rest"), ("magDistDetected", "mag_disturbed")):
        assert np.array_equal(peer[theirs], est.extra[name] > 0.0)
    for theirs, name in (("delta", "delta"), ("biasSigma", "bias_sigma"), ("magRefDip", "mag_ref_dip")):
        assert np.abs(peer[theirs] - est.extra[name]).max() < OVER_TIME, theirs


def test_vqf_sample_by_sample(vqf: Any, signals: Signals) -> None:
    peer, f = vqf.VQF(1.0 / RATE), ar.VQF(rate=RATE)
    for sample in zip(*(array[:300] for array in signals.sensors()), strict=True):
        peer.update(*sample)
        assert angle_between(peer.getQuat9D(), f.update(*sample)) < OVER_TIME
        assert f.gyr_bias is not None
        assert np.abs(peer.getBiasEstimate()[0] - f.gyr_bias).max() < OVER_TIME


def test_vqf_without_a_magnetometer(vqf: Any, signals: Signals) -> None:
    peer = vqf.BasicVQF(1.0 / RATE).updateBatch(signals.gyr, signals.acc)
    assert angle_between(peer["quat6D"], ar.BasicVQF(rate=RATE).run(signals.gyr, signals.acc).quat).max() < OVER_TIME


def test_offline_vqf(vqf: Any, signals: Signals) -> None:
    peer = vqf.offlineVQF(*signals.sensors(), 1.0 / RATE)
    est = ar.OfflineVQF(rate=RATE).run(*signals.sensors())
    assert angle_between(peer["quat9D"], est.quat).max() < OVER_TIME
    assert np.abs(peer["bias"] - est.gyr_bias).max() < OVER_TIME


# ---------------------------------------------------------------- imufusion


def test_imufusion_ahrs(imufusion: Any, signals: Signals) -> None:
    gyr, acc, mag = signals.sensors()
    start = attitudes(1, 7)[0]
    peer, settings = imufusion.Ahrs(), imufusion.AhrsSettings(sample_rate=RATE, gain=0.5, gyroscope_range=2000.0)
    assert settings.convention == imufusion.CONVENTION_NWU  # its default
    peer.set_settings(settings)
    peer.set_quaternion(start.astype(np.float32))
    expected, linear, on_earth, down = [], [], [], []
    for sample in zip(np.degrees(gyr), acc / GRAVITY, mag, strict=True):
        peer.update(*(one.astype(np.float32) for one in sample))
        expected.append(peer.get_quaternion())
        linear.append(GRAVITY * peer.get_linear_acceleration())
        on_earth.append(GRAVITY * peer.get_earth_acceleration())
        down.append(peer.get_gravity())
    est = ar.Fusion(rate=RATE, gain=0.5, gyroscope_range=2000.0, frame="NWU").run(gyr, acc, mag, q0=start)
    assert angle_between(np.asarray(expected, dtype=np.float64), est.quat).max() < FLOAT32
    assert np.abs(down - est.matrix()[:, 2]).max() < FLOAT32
    bound = 10.0 * GRAVITY * FLOAT32  # rounding of the attitude turns gravity
    assert np.abs(linear - est.linear_acceleration(acc, frame="sensor")).max() < bound
    assert np.abs(on_earth - est.linear_acceleration(acc, frame="earth")).max() < bound


def test_imufusion_bias(imufusion: Any) -> None:
    rng = np.random.default_rng(8)
    gyr = np.radians([0.5, -1.0, 0.2]) + 1e-3 * rng.standard_normal((SAMPLES, 3))
    acc = np.tile([0.0, 0.0, GRAVITY], (SAMPLES, 1))
    peer = imufusion.Bias()
    peer.set_settings(imufusion.BiasSettings(sample_rate=RATE, stationary_threshold=3.0, stationary_period=3.0))
    for one in np.degrees(gyr).astype(np.float32):
        peer.update(one)
    f = ar.Fusion(rate=RATE, bias=True, stationary_threshold=3.0, stationary_period=3.0)
    est = f.run(gyr, acc, q0=[1.0, 0.0, 0.0, 0.0])  # with it, sample 0 is a step, as there
    assert est.gyr_bias is not None
    assert np.abs(np.radians(peer.get_offset()) - est.gyr_bias[-1]).max() < 1e-7
    assert np.abs(est.gyr_bias[-1]).max() > 1e-3


@pytest.mark.parametrize("frame", ["NWU", "ENU", "NED"])
def test_imufusion_compass(imufusion: Any, signals: Signals, frame: str) -> None:
    convention = getattr(imufusion, f"CONVENTION_{frame}")
    rows = zip(signals.acc[:50].astype(np.float32), signals.mag[:50].astype(np.float32), strict=True)
    peer = np.array([imufusion.compass(a, m, convention) for a, m in rows])
    heading = rotation(ar.attitude.fqa(signals.acc[:50], signals.mag[:50], frame=frame)).as_euler("ZYX", degrees=True)
    assert np.abs((peer - heading[:, 0] + 180.0) % 360.0 - 180.0).max() < 1e-3  # float32 of 180°


def test_imufusion_conversions(imufusion: Any, signals: Signals) -> None:
    est = ar.Madgwick(rate=RATE).run(*(array[:50] for array in signals.sensors()))
    for k, quat in enumerate(est.quat.astype(np.float32)):
        assert np.abs(imufusion.quaternion_to_matrix(quat) - est.matrix()[k]).max() < 1e-6
        euler = imufusion.quaternion_to_euler(quat)
        assert np.abs((euler - est.euler(degrees=True)[k] + 180.0) % 360.0 - 180.0).max() < 1e-2  # near 90° of pitch


def test_imufusion_models(imufusion: Any, signals: Signals) -> None:
    reading = signals.acc[0].astype(np.float32)
    misalignment = np.array([[1.0, 0.02, -0.01], [0.01, 1.0, 0.03], [0.0, -0.02, 1.0]])
    sensitivity, offset = np.array([1.1, 0.9, 1.05]), np.array([0.1, -0.2, 0.3])
    peer = imufusion.model_inertial(
        reading, misalignment.astype(np.float32), sensitivity.astype(np.float32), offset.astype(np.float32)
    )
    ours = ar.calibration.Calibration(misalignment @ np.diag(sensitivity), offset)
    assert np.abs(peer - ours.apply(signals.acc[:1])[0]).max() < 1e-5
    peer = imufusion.model_magnetic(reading, misalignment.astype(np.float32), offset.astype(np.float32))
    ours = ar.calibration.Calibration(misalignment, offset)
    assert np.abs(peer - ours.apply(signals.acc[:1])[0]).max() < 1e-5


@pytest.mark.parametrize(("alignment", "axes"), [("PXNYNZ", "x,-y,-z"), ("PYNXPZ", "y,-x,z"), ("NZPYPX", "-z,y,x")])
def test_imufusion_remap(imufusion: Any, signals: Signals, alignment: str, axes: str) -> None:
    recording = ar.Recording(t=signals.t, gyr=signals.gyr, acc=signals.acc)
    peer = imufusion.remap(signals.gyr[5].astype(np.float32), getattr(imufusion, f"ALIGNMENT_{alignment}"))
    turned = recording.remapped(axes).gyr
    assert turned is not None
    assert np.abs(peer - turned[5]).max() < 1e-6
