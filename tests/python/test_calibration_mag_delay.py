"""Laws of `calibration.mag_delay`: a planted delay comes back with an honest standard error, or an error that helps."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import CalibrationError, mag_delay
from commands import DATA, needs_data
from late import late, noisy
from signals import conjugate, random_turns, rotation


def spoilt(delay: float, seed: int, duration: float = 60.0, wander: float = 1.0) -> ar.Recording:
    """A late magnetometer of a bad sensor, with white noise.

    The gyroscope has a scale and misalignment of 1 % and a bias of 0.6 °/s, the magnetometer soft iron of 3 % and hard
    iron of 6 %, and the field wanders by 2 % with a memory of 8 s.
    """
    recording = late(delay, seed, duration)
    assert recording.mag is not None
    assert recording.ref is not None
    draw = np.random.default_rng(1000 + seed)
    keep = np.exp(-1.0 / (8.0 * recording.rate))
    disturbance = np.zeros_like(recording.mag)
    for k in range(1, len(disturbance)):
        disturbance[k] = keep * disturbance[k - 1] + wander * np.sqrt(1 - keep**2) * draw.standard_normal(3)
    gyr = recording.gyr @ (np.eye(3) + 0.01 * draw.standard_normal((3, 3))) + 0.01 * draw.standard_normal(3)
    mag = recording.mag @ (np.eye(3) + 0.03 * draw.standard_normal((3, 3))) + 3.0 * draw.standard_normal(3)
    mag += rotation(conjugate(recording.ref)).apply(disturbance)
    return noisy(dataclasses.replace(recording, gyr=gyr, mag=mag), seed)


@pytest.mark.parametrize("delay", [0.0, 0.005, 0.013, 0.027, 0.04])
def test_planted_delay_comes_back_to_two_milliseconds(delay: float) -> None:
    for seed in range(2):
        found = mag_delay(spoilt(delay, seed))
        assert found.delay == pytest.approx(delay, abs=2e-3)
        assert 1e-5 < found.standard_error < 2e-3
        assert found.windows == pytest.approx(60, abs=1)


def test_of_an_exact_recording_it_is_exact() -> None:
    """But for the attitude between samples, whose rate is taken for constant: α (10 ms)²/8 is 1e-4 rad at 10 rad/s²."""
    for delay in (0.0, 0.018):
        assert mag_delay(late(delay, 3)).delay == pytest.approx(delay, abs=1e-4)


def test_standard_error_covers_the_truth() -> None:
    """Of twenty seeds 68 % within one and 95 % within two: at least 9 (of 13.6) and 16 (of 19), by three deviations."""
    off = []
    for seed in range(20):
        found = mag_delay(spoilt(0.013, seed, duration=40.0))
        off.append(abs(found.delay - 0.013) / found.standard_error)
    assert np.count_nonzero(np.array(off) < 1.0) >= 9
    assert np.count_nonzero(np.array(off) < 2.0) >= 16
    assert float(np.sqrt(np.mean(np.square(off)))) > 0.5  # an error that is far too large is none either


def test_a_slower_magnetometer_and_gaps_are_enough() -> None:
    recording = spoilt(0.02, 1)
    assert recording.mag is not None
    mag = recording.mag.copy()
    mag[np.arange(len(mag)) % 4 != 1] = np.nan
    mag[2000:2500] = np.nan
    gyr = recording.gyr.copy()
    gyr[100:103] = np.nan
    found = mag_delay(dataclasses.replace(recording, gyr=gyr, mag=mag))
    assert found.delay == pytest.approx(0.02, abs=2e-3)
    assert found.windows == pytest.approx(55, abs=1)


def test_uneven_stamps_are_used() -> None:
    fine = ar.simulate.demo(60.0, 1000.0, 2, noise=False)
    assert fine.mag is not None
    kept = np.cumsum(np.random.default_rng(0).integers(6, 15, 5500))
    kept = kept[kept < len(fine)]
    turned = np.concatenate(([[0.0, 0.0, 0.0]], np.cumsum(fine.gyr * 1e-3, axis=0)))
    first = kept[:-1] + 1
    gyr = (turned[kept[1:] + 1] - turned[first]) / ((kept[1:] - kept[:-1]) * 1e-3)[:, np.newaxis]
    kept = kept[1:]
    recording = ar.Recording(t=fine.t[kept], gyr=gyr, mag=fine.mag[np.maximum(kept - 13, 0)])
    assert mag_delay(recording).delay == pytest.approx(0.013, abs=5e-4)


def test_field_units_and_mounting_do_not_matter() -> None:
    recording = spoilt(0.013, 4)
    assert recording.mag is not None
    plain = mag_delay(recording)
    (turn,) = random_turns(1, 0)
    scaled = mag_delay(dataclasses.replace(recording, mag=0.02 * recording.mag))
    turned = mag_delay(dataclasses.replace(recording, gyr=turn.apply(recording.gyr), mag=turn.apply(recording.mag)))
    # The same sums in another order and another scale.
    assert scaled.delay == pytest.approx(plain.delay, abs=1e-8)
    assert turned.delay == pytest.approx(plain.delay, abs=1e-6)
    assert turned.standard_error == pytest.approx(plain.standard_error, rel=1e-3)


def test_a_gyroscope_that_is_late_gives_a_negative_delay() -> None:
    recording = late(0.0, 5)
    shifted = dataclasses.replace(recording[:-2], mag=np.asarray(recording.mag)[2:], acc=None, ref=None)
    assert mag_delay(shifted).delay == pytest.approx(-0.02, abs=2e-4)


def still(samples: int = 6000) -> ar.Recording:
    draw = np.random.default_rng(0)
    return ar.Recording(
        t=np.arange(samples) / 100.0,
        gyr=2e-3 * draw.standard_normal((samples, 3)),
        mag=[20.0, 0.0, -40.0] + 0.3 * draw.standard_normal((samples, 3)),
    )


def test_what_does_not_determine_the_delay_is_refused_with_advice() -> None:
    advice = "turn the sensor quickly to and fro"
    with pytest.raises(CalibrationError, match=rf"the angular rate changes by 0.00\d+ rad/s \(RMS\) only: {advice}"):
        mag_delay(still())
    with pytest.raises(
        CalibrationError, match=rf"expected at least 10 windows of 1 s with 8 readings, got 5: {advice}"
    ):
        mag_delay(still(500))
    # A steady turn shows the same field as another north would: nothing tells its delay.
    turning = still()
    speed, z = 1.0, np.array([0.0, 0.0, 1.0])
    attitude = rotation(quats_about_z(speed * turning.t))
    steady = dataclasses.replace(
        turning, gyr=turning.gyr + speed * z, mag=turning.mag * 0.01 + attitude.inv().apply([20.0, 0.0, -40.0])
    )
    with pytest.raises(CalibrationError, match=advice):
        mag_delay(steady)


def quats_about_z(angle: np.ndarray) -> np.ndarray:
    return np.stack((np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)), axis=-1)


def test_what_does_not_belong_together_is_refused() -> None:
    recording = late(0.013, 2)
    with pytest.raises(CalibrationError, match="no magnetometer"):
        mag_delay(dataclasses.replace(recording, mag=None))
    assert recording.mag is not None
    swapped = dataclasses.replace(recording, mag=recording.mag[:, [1, 0, 2]])
    with pytest.raises(CalibrationError, match=r"axes|frame|turn the sensor"):
        mag_delay(swapped)
    with pytest.raises(CalibrationError, match="the field is zero"):
        mag_delay(dataclasses.replace(recording, mag=0.0 * recording.mag))
    with pytest.raises(ValueError, match="window: expected a positive number"):
        mag_delay(recording, window=0.0)
    with pytest.raises(CalibrationError, match="ms only"):
        mag_delay(spoilt(0.013, 0), largest_error=1e-5)


def test_what_was_found_serves_a_filter() -> None:
    recording = spoilt(0.03, 6)
    assert recording.ref is not None
    found = mag_delay(recording)
    errors = [
        ar.metrics.score(
            ar.OfflineVQF(rate=recording.rate, mag_delay=delay).run(recording.gyr, recording.acc, recording.mag).quat,
            late(0.03, 6).ref,  # type: ignore[arg-type]
        ).heading
        for delay in (0.0, found.delay)
    ]
    assert errors[1] < errors[0]


@needs_data
def test_real_recordings_show_the_delays_of_their_sensors() -> None:
    """BROAD's 13 ms; of RepoIMU's T-stick less than one. What differs more has a standard error that says so."""
    pytest.importorskip("h5py")
    for pattern, expected in (
        ("broad/0[27]*.hdf5", 0.0131),
        ("broad/16*.hdf5", 0.0131),
        ("repoimu/TStick*.csv", 0.0007),
    ):
        files = sorted(Path(DATA).glob(pattern))
        assert files
        for file in files:
            found = mag_delay(ar.read(file))
            assert found.standard_error < 1e-3
            assert abs(found.delay - expected) < max(3.0 * found.standard_error, 5e-4)
