"""Laws of the simulated recordings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ahrs_rs import metrics, simulate
from ahrs_rs._recording import Recording


@pytest.fixture(scope="module")
def ideal() -> Recording:
    return simulate.demo(noise=False)


def rotation(quat: np.ndarray) -> Rotation:
    return Rotation.from_quat(quat, scalar_first=True)


def test_integrating_the_rates_of_an_ideal_sensor_gives_the_truth(ideal: Recording) -> None:
    step = np.diff(ideal.t)[:, None]
    turns = Rotation.from_rotvec(ideal.gyr[1:] * step)
    q = rotation(ideal.ref[0])
    worst = 0.0
    for k, turn in enumerate(turns):
        q = q * turn
        worst = max(worst, float(metrics.total_error(q.as_quat(scalar_first=True), ideal.ref[k + 1])))
    # 6000 products, each with a few roundings of 1.1e-16, that add up as a random walk or at worst linearly.
    assert worst < 6000 * 5 * 1.1e-16


def test_the_field_of_an_ideal_magnetometer_is_earths_field(ideal: Recording) -> None:
    assert ideal.mag is not None
    field = rotation(ideal.ref).apply(ideal.mag)
    dip = np.radians(60.0)
    assert np.allclose(field, [0.0, 50 * np.cos(dip), -50 * np.sin(dip)], atol=1e-12, rtol=0)


def test_an_ideal_accelerometer_reads_gravity_and_the_second_derivative_of_a_path() -> None:
    # At 1 kHz the double sum of the acceleration over a cycle with rests at both ends must end at rest.
    ideal = simulate.demo(duration=20.0, rate=1000.0, noise=False)
    acceleration = rotation(ideal.ref).apply(ideal.acc) - [0.0, 0.0, 9.80665]
    resting = ideal.t < 4.0
    assert np.abs(acceleration[resting]).max() < 1e-13  # a rotation there and back: a few roundings of 9.8
    assert np.abs(acceleration).max() > 1.0
    velocity = np.cumsum(acceleration, axis=0) * 1e-3
    # Riemann sum of a function with jumps in its second derivative only: error of order dt² · jerk rate.
    assert np.abs(velocity[-1]).max() < 1e-4
    assert np.abs(velocity).max() > 0.1


def test_the_sensor_rests_before_the_mask_begins(ideal: Recording) -> None:
    assert ideal.mask is not None
    # The product of a quaternion with its own inverse leaves roundings of 1e-16, divided by dt = 0.01 s.
    assert np.abs(ideal.gyr[~ideal.mask]).max() < 1e-13
    assert ideal.mask.sum() == len(ideal) - 400
    # Rests return within the recording: 4 s of every 20 s.
    assert np.mean(np.linalg.norm(ideal.gyr, axis=1) < 1e-13) == pytest.approx(0.2, abs=0.01)


def test_the_motion_is_smooth_and_of_a_hand(ideal: Recording) -> None:
    speed = np.degrees(np.linalg.norm(ideal.gyr, axis=1))
    assert 100 < speed.max() < 600
    assert np.abs(np.diff(np.degrees(ideal.gyr), axis=0)).max() < 30  # no jump: 3000 °/s² at most
    assert np.ptp(metrics.euler(ideal.ref, degrees=True), axis=0).min() > 60


@pytest.mark.parametrize("seed", range(5))
def test_the_truth_is_unit_continuous_and_starts_with_positive_w(seed: int) -> None:
    ref = simulate.demo(seed=seed).ref
    assert ref is not None
    assert np.abs(np.linalg.norm(ref, axis=1) - 1).max() < 1e-15
    assert ref[0, 0] >= 0
    assert (ref[1:] * ref[:-1]).sum(axis=1).min() > 0.99


def test_the_same_seed_gives_the_same_recording_and_another_seed_another_one() -> None:
    one, two, other = simulate.demo(5.0, seed=3), simulate.demo(5.0, seed=3), simulate.demo(5.0, seed=4)
    for name in ("t", "gyr", "acc", "mag", "ref", "mask"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
    assert not np.array_equal(one.ref, other.ref)


def test_errors_leave_the_truth_as_it_is_and_have_the_stated_size(ideal: Recording) -> None:
    real = simulate.demo()
    errors = simulate.CONSUMER_MEMS
    assert np.array_equal(real.ref, ideal.ref)
    expected = {
        "gyr": (real.meta["gyr_bias"], errors.gyr_density * np.sqrt(50.0)),
        "acc": (real.meta["acc_bias"], errors.acc_density * np.sqrt(50.0)),
        "mag": ([0.0, 0.0, 0.0], errors.mag_noise),
    }
    for name, (bias, deviation) in expected.items():
        error = getattr(real, name) - getattr(ideal, name)
        # Of 6000 samples the mean scatters by 1.3 % of the deviation and the deviation by 0.9 %: 5 sigma.
        assert np.abs(error.mean(axis=0) - bias).max() < 0.065 * deviation
        assert np.allclose(error.std(axis=0), deviation, rtol=0.05)


def test_rate_and_duration_give_the_number_of_samples() -> None:
    recording = simulate.demo(duration=2.5, rate=286.0)
    assert len(recording) == 715
    assert recording.rate == 286.0
    assert recording.mask is not None
    assert 0 < recording.mask.sum() < 715


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration": 0.0}, "duration: expected a positive number, got 0.0"),
        ({"duration": float("nan")}, "duration: expected a positive number"),
        ({"rate": -1.0}, "rate: expected a positive number"),
        ({"duration": 0.01}, "duration: expected at least two samples at 100.0 Hz"),
        ({"seed": -1}, "seed: expected an integer that is not negative"),
    ],
)
def test_impossible_arguments_are_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulate.demo(**arguments)
