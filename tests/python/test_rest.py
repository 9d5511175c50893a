"""Where a sensor rests, and what its gyroscope's bias is there."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import find_rest, gyroscope_bias

RATE = 100.0


def still(
    seconds: float = 60.0, seed: int = 0, bias: tuple[float, float, float] = (0.01, -0.02, 0.003)
) -> ar.Recording:
    """White noise on a sensor that lies still."""
    count = round(seconds * RATE)
    rng = np.random.default_rng(seed)
    return ar.Recording(
        t=np.arange(count) / RATE,
        rate=RATE,
        gyr=np.array(bias) + 2e-3 * rng.standard_normal((count, 3)),
        acc=[0.0, 0.0, 9.81] + 0.02 * rng.standard_normal((count, 3)),
    )


def test_the_rests_of_a_simulation_are_found() -> None:
    recording = ar.simulate.demo(60.0, RATE, 3)
    rest = find_rest(recording)
    # It rests from 0 to 4, 20 to 24 and 40 to 44 s, and starts to move slowly: half a window less at the ends, a bit
    # more where the motion is below the thresholds.
    assert len(rest.phases) == 3
    for (start, end), begin in zip(rest.seconds, (0.0, 20.0, 40.0), strict=True):
        assert begin - 0.6 < start < begin + 0.6
        assert begin + 3.0 < end < begin + 4.6
    assert rest.duration == pytest.approx(11.0, abs=1.5)
    assert rest.mask.sum() == sum(one.stop - one.start for one in rest.phases)


def test_a_slow_steady_rotation_is_no_rest() -> None:
    recording = still(bias=(0.0, 0.0, 0.2))
    with pytest.raises(ValueError, match="expected a rest of 2 s"):
        find_rest(recording)
    assert find_rest(recording, gyr_mean=0.3).mask.all()


def test_rows_with_nan_do_not_count_and_long_gaps_are_no_rest() -> None:
    recording = still()
    gyr = recording.gyr.copy()
    gyr[::7] = np.nan
    gyr[3000:3300] = np.nan
    rest = find_rest(dataclasses.replace(recording, gyr=gyr))
    assert len(rest.phases) == 2
    # The window of ±0.5 s has to be measured by half.
    assert 29.5 < rest.seconds[0][1] < 30.5
    assert 32.5 < rest.seconds[1][0] < 33.5
    gyr[:] = np.nan
    with pytest.raises(ValueError, match="expected a rest"):
        find_rest(dataclasses.replace(recording, gyr=gyr))


def test_the_bias_is_within_its_error_as_often_as_that_says() -> None:
    truth = (0.01, -0.02, 0.003)
    errors = []
    for seed in range(100):
        bias = gyroscope_bias(still(20.0, seed, truth))
        errors.append((bias.value - truth) / bias.standard_error)
        assert bias.samples == 2000
    # White noise: normal errors, or smaller ones where the blocks say more than the samples (by 10 % or so).
    assert 0.75 < np.std(errors) < 1.05
    assert np.mean(np.abs(errors) < 1.96) > 0.93


def test_a_drifting_bias_has_a_larger_error() -> None:
    recording = still(200.0)
    drift = 1e-3 / np.sqrt(RATE) * np.cumsum(np.random.default_rng(1).standard_normal(recording.gyr.shape), axis=0)
    drifting = dataclasses.replace(recording, gyr=recording.gyr + drift)
    assert np.all(gyroscope_bias(drifting).standard_error > 5.0 * gyroscope_bias(recording).standard_error)


def test_without_an_accelerometer_the_gyroscope_is_enough() -> None:
    assert find_rest(dataclasses.replace(still(), acc=None)).mask.all()


def test_errors_say_how_close_the_recording_came() -> None:
    recording = still()
    moving = dataclasses.replace(recording, gyr=recording.gyr + np.sin(recording.t)[:, np.newaxis])
    with pytest.raises(
        ValueError, match=r"deviations below 0.01 rad/s and 0.1 m/s², but the smallest .* rad/s and 0.03"
    ):
        find_rest(moving)
    with pytest.raises(ValueError, match="more than a window of 1 s, got 50 samples"):
        find_rest(recording[:50])
    with pytest.raises(ValueError, match="window: expected a positive number, got 0"):
        find_rest(recording, window=0.0)
    rest = find_rest(recording)
    mask = rest.mask.copy()
    mask[31:] = False
    with pytest.raises(ValueError, match="gyr: expected at least 32 samples at rest, got 31"):
        gyroscope_bias(recording, dataclasses.replace(rest, mask=mask))


def test_rest_is_nowhere_in_the_motion_of_real_recordings(broad: list[ar.Recording]) -> None:
    for recording in broad:
        assert recording.mask is not None
        rest = find_rest(recording)
        # `movement` is what the authors say of the trial; it begins and ends with rest.
        assert not recording.mask[rest.mask].any(), recording.meta["path"]
        # Where it is held in the hand between motions (the 10th: 0.44 of its breaks) it is not as still as on a table.
        assert rest.mask.sum() > 0.4 * np.count_nonzero(~recording.mask)
