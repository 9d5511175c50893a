"""Against the package `ahrs`, where what it computes is what its sources say.

Where it differs: it has no exponential map in its feedback filters (so first-order steps here), stops where the
angular rate is exactly zero, wants gains above zero, and starts at sample 0 without a step (so its q0 is the
attitude at sample 0, ours the one before the first sample). `Madgwick` with a magnetometer ignores q0 when it is given
whole arrays, so its `updateMARG` is called; its earth is x north, y west, z up. `AngularRate` by series raises the
elements of a matrix instead of the matrix to powers, so only its first order is one. `Complementary` adds the angular
rate to the Euler angles, which is right for turns about one horizontal axis only. `Mahony`'s magnetometer and
accelerometer and the factor 2 of Madgwick's bx and bz are right there.
"""

from __future__ import annotations

import ahrs
import numpy as np
import pytest

import ahrs_rs as ar
from signals import RATE, Floats, Signals, angle_between, inclination_between, motion, random_turns

SAMPLES = 1000
#: Rounding over 1000 samples, as in `test_oracle`.
AGREEMENT = 1e-12


@pytest.fixture(scope="module")
def signals() -> Signals:
    return motion(SAMPLES, 1)


@pytest.fixture(scope="module")
def q0() -> Floats:
    """The attitude at sample 0."""
    return random_turns(1, 2).as_quat(scalar_first=True)[0]


def from_q0(f: ar.Filter, signals: Signals, q0: Floats, *, nine: bool) -> Floats:
    """Our attitudes of samples 1, 2, ...: the step of sample 1 is the first one from q0."""
    return f.run(*(None if a is None else a[1:] for a in signals.sensors(nine=nine)), q0=q0).quat


def as_quats(values: object) -> Floats:
    return np.asarray(values, dtype=np.float64).reshape(-1, 4)


def test_gyroscope_by_the_exponential_map(signals: Signals, q0: Floats) -> None:
    peer = ahrs.filters.AngularRate(gyr=signals.gyr, q0=q0, frequency=RATE, method="closed")
    ours = from_q0(ar.GyroIntegration(rate=RATE), signals.without(), q0, nine=False)
    assert angle_between(as_quats(peer.Q)[1:], ours).max() < AGREEMENT


def test_gyroscope_by_first_order_steps(signals: Signals, q0: Floats) -> None:
    peer = ahrs.filters.AngularRate(gyr=signals.gyr, q0=q0, frequency=RATE, method="series", order=1)
    ours = from_q0(ar.GyroIntegration(rate=RATE, integration="first-order"), signals, q0, nine=False)
    assert angle_between(as_quats(peer.Q)[1:], ours).max() < AGREEMENT


def test_roll_and_pitch_of_the_accelerometer(signals: Signals) -> None:
    # Its yaw is zero; ours is that of the start, which the identity makes zero.
    peer = ahrs.filters.Tilt(acc=signals.acc)
    start = [1.0, 0.0, 0.0, 0.0]
    ours = ar.Trigonometric(rate=RATE).run(signals.gyr, signals.acc, q0=start)
    assert angle_between(as_quats(peer.Q), ours.quat).max() < AGREEMENT
    assert np.abs(ours.euler() - peer.angles).max() < AGREEMENT
    # Tilt has the same vertical, and another heading: its turns are the shortest ones.
    assert (
        inclination_between(as_quats(peer.Q), ar.Tilt(rate=RATE).run(signals.gyr, signals.acc).quat).max() < AGREEMENT
    )


def test_heading_of_the_magnetometer_with_north_on_x(signals: Signals) -> None:
    peer = ahrs.filters.Tilt(acc=signals.acc, mag=signals.mag)
    ours = ar.Ecompass(rate=RATE, frame="NWU").run(*signals.sensors()).quat
    assert angle_between(as_quats(peer.Q), ours).max() < AGREEMENT


@pytest.mark.parametrize(("kp", "ki"), [(1.0, 0.3), (10.0, 1e-9), (0.0039216, 0.001)])
@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
def test_mahony(signals: Signals, q0: Floats, nine: bool, kp: float, ki: float) -> None:
    # Its north is y, like ours in ENU.
    gyr, acc, mag = signals.sensors(nine=nine)
    peer = ahrs.filters.Mahony(gyr=gyr, acc=acc, mag=mag, frequency=RATE, k_P=kp, k_I=ki, q0=q0)
    f = ar.Mahony(rate=RATE, kp=kp, ki=ki, integration="first-order")
    ours = f.run(gyr[1:], acc[1:], None if mag is None else mag[1:], q0=q0)
    assert angle_between(as_quats(peer.Q)[1:], ours.quat).max() < AGREEMENT
    assert np.abs(peer.b - ours.gyr_bias[-1]).max() < AGREEMENT


@pytest.mark.parametrize("beta", [0.033, 0.1, 1.0])
def test_madgwick_without_magnetometer(signals: Signals, q0: Floats, beta: float) -> None:
    peer = ahrs.filters.Madgwick(gyr=signals.gyr, acc=signals.acc, frequency=RATE, gain=beta, q0=q0)
    f = ar.Madgwick(rate=RATE, beta=beta, gradient="paper", integration="first-order")
    assert angle_between(as_quats(peer.Q)[1:], from_q0(f, signals, q0, nine=False)).max() < AGREEMENT


@pytest.mark.parametrize("beta", [0.041, 0.1, 1.0])
def test_madgwick_with_magnetometer_and_north_on_x(signals: Signals, q0: Floats, beta: float) -> None:
    peer = ahrs.filters.Madgwick(frequency=RATE, gain=beta)
    attitudes = [q0]
    for gyr, acc, mag in zip(*signals.sensors(), strict=True):
        attitudes.append(peer.updateMARG(attitudes[-1], gyr=gyr, acc=acc, mag=mag))
    f = ar.Madgwick(rate=RATE, beta=beta, gradient="paper", integration="first-order", frame="NWU")
    ours = f.run(*signals.sensors(), q0=q0).quat
    assert angle_between(as_quats(attitudes)[1:], ours).max() < AGREEMENT


def test_the_tangent_gradient_is_another_filter(signals: Signals, q0: Floats) -> None:
    # What the package computes depends on the mounting of the sensor; the default here does not.
    peer = ahrs.filters.Madgwick(gyr=signals.gyr, acc=signals.acc, frequency=RATE, gain=0.1, q0=q0)
    f = ar.Madgwick(rate=RATE, beta=0.1, integration="first-order")
    assert angle_between(as_quats(peer.Q)[1:], from_q0(f, signals, q0, nine=False)).max() > 1e-3


def test_complementary_for_turns_about_one_axis() -> None:
    rng = np.random.default_rng(3)
    angle = 1.5 * np.sin(np.arange(SAMPLES) / RATE)
    gyr = np.zeros((SAMPLES, 3))
    gyr[1:, 0] = np.diff(angle) * RATE + 0.05 * rng.standard_normal(SAMPLES - 1)
    noisy = angle + 0.05 * rng.standard_normal(SAMPLES)
    acc = 9.81 * np.column_stack((np.zeros(SAMPLES), np.sin(noisy), np.cos(noisy)))
    gain = 0.97
    peer = ahrs.filters.Complementary(gyr=gyr, acc=acc, frequency=RATE, gain=gain)
    # α = τ/(τ + dt) is its gain.
    tau = gain / (1.0 - gain) / RATE
    for integration in ("exponential", "first-order"):
        ours = ar.Complementary(rate=RATE, tau=tau, integration=integration).run(gyr, acc)
        assert np.abs(ours.euler()[:, :2] - peer.W[:, :2]).max() < AGREEMENT
