"""Gyroscope biases: found in motion, and of no consequence for the inclination (Hyyti & Visala's third test)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import metrics, simulate
from signals import RATE, Floats, motion

#: Filters that estimate the bias of all three axes, and whether they are given a magnetometer.
FINDERS: list[tuple[str, dict[str, Any], bool]] = [
    ("DcmImu", {}, False),
    ("MEKF", {}, True),
    ("MEKF", {}, False),
    ("MEKF", {"magnetometer": "vector"}, True),
]
BIAS = np.array([0.03, -0.02, 0.025])
#: The issue's bound for the third test, in degrees.
WITHIN = 0.5
#: The time (s) that the filters have to converge: the recordings rest for as long.
CONVERGED = 30.0


def bias_errors(name: str, nine: bool, noise: float, **params: Any) -> Floats:
    """Norm (rad/s) of the error of the estimate over three minutes of motion, for five motions, as (5, T)."""
    recordings = [motion(18_000, seed, noise=noise) for seed in range(5)]
    gyr, acc, mag = (np.stack([getattr(r, sensor) for r in recordings]) for sensor in ("gyr", "acc", "mag"))
    est = ar.FILTERS[name](rate=RATE, **params).run(gyr + BIAS, acc, mag if nine else None)
    assert est.gyr_bias is not None
    return np.linalg.norm(est.gyr_bias - BIAS, axis=-1)


@pytest.mark.parametrize(("name", "params", "nine"), FINDERS)
def test_the_bias_converges_to_the_truth_in_motion(name: str, params: dict[str, Any], nine: bool) -> None:
    exact = bias_errors(name, nine, 0.0, **params)
    assert exact[:, 20].min() > 0.01, "found before it can be known"
    # What is left of 0.044 rad/s after three minutes: measured 7e-5, falling.
    assert exact[:, -1].max() < 1e-4
    assert np.all(exact[:, -1] < exact[:, 6000])
    # MEKF remembers a bias for k1/k2 = 30 s, over which the gyroscope's 5e-3 rad/s average to 1e-4 and the
    # accelerometer's noise as well, five deviations of both; DcmImu, for longer.
    assert bias_errors(name, nine, 0.1, **params)[:, -1].max() < 7e-4


def test_the_published_prediction_takes_its_own_error_for_a_bias() -> None:
    # A first-order step of ω dt = 0.05 rad is wrong by its square over 2: 0.1 rad/s at 100 Hz, of which a part lasts.
    assert bias_errors("DcmImu", False, 0.0, prediction="euler")[:, -1].min() > 20.0 * 1e-4


def errors_by_bias(name: str, recording: ar.Recording) -> Floats:
    """RMS inclination errors (8,) in degrees with 0 to 7 °/s added to each axis of the gyroscope."""
    biases = np.radians(np.arange(8.0))
    arrays = [np.broadcast_to(array, (8, *array.shape)) for array in (recording.acc, recording.mag)]
    est = ar.FILTERS[name](rate=recording.rate).run(recording.gyr + biases[:, None, None], *arrays)
    time = np.arange(len(recording)) / recording.rate
    scored = (time > CONVERGED) & (recording.mask if recording.mask is not None else True)
    return np.array([metrics.rmse(metrics.inclination_error(q, recording.ref, degrees=True), scored) for q in est.quat])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["DcmImu", "MEKF"])
def test_an_added_bias_is_of_no_consequence_in_simulated_motion(name: str, seed: int) -> None:
    # At the defaults: MEKF's start of 0.05 rad/s (2.9 °/s) caps the variance of the bias, not the bias.
    errors = errors_by_bias(name, simulate.demo(duration=120.0, seed=seed))
    assert errors[0] < 1.0, "not converged at all"
    assert np.abs(errors - errors[0]).max() < WITHIN


def test_mekf_is_indifferent_to_an_added_bias_on_broad(broad: list[ar.Recording]) -> None:
    for recording in broad:
        errors = errors_by_bias("MEKF", recording)
        assert np.abs(errors - errors[0]).max() < WITHIN


def test_dcm_imu_is_indifferent_to_an_added_bias_on_broad_where_it_is_right_without(broad: list[ar.Recording]) -> None:
    # Three of the twelve, with fast translation or a translation that lasts, it takes for a tilt: its inclination is
    # wrong by 4 to 5° without any bias, and biases are lost in that.
    right = 0
    for recording in broad:
        errors = errors_by_bias("DcmImu", recording)
        if errors[0] < 2.0:
            right += 1
            assert np.abs(errors - errors[0]).max() < WITHIN
    assert right == 9


def test_dcm_imu_needs_the_exponential_prediction_where_the_rotation_is_fast(broad: list[ar.Recording]) -> None:
    recording = broad[2]
    fastest = np.degrees(np.linalg.norm(recording.gyr, axis=1).max())
    assert fastest > 1000.0, "the recording with fast rotation is another one"
    errors, found_out = {}, {}
    for prediction in ("exponential", "euler"):
        est = ar.DcmImu(rate=recording.rate, prediction=prediction).run(recording.gyr, recording.acc)
        errors[prediction] = metrics.score(est.quat, recording.ref, recording.mask).inclination
        found_out[prediction] = np.any(est.status & ar.Status.RECOVERING)
    # As an independent implementation gives it, to the digits known.
    assert errors["exponential"] == pytest.approx(1.6, abs=0.05)
    assert not found_out["exponential"]
    # That one gives 39.1° for the other: here the watch finds it lost, again and again.
    assert errors["euler"] > 5.0 * errors["exponential"]
    assert found_out["euler"]
