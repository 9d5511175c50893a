"""The noise of simulated and real sensors, the parameters from it, and `ahrs-rs noise`."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs.calibration import Noise, find_rest, noise
from commands import Capture, error_of, output_of

RATE = 100.0
#: Standard deviations of samples: different ones of each axis, in rad/s, m/s² and µT.
GYR = np.array([2e-3, 3e-3, 1e-3])
ACC = np.array([0.02, 0.03, 0.01])
MAG = np.array([0.3, 0.5, 0.4])
FIELD = np.array([20.0, 0.0, -40.0])


def still(seconds: float = 200.0, seed: int = 0, walk: float = 0.0) -> ar.Recording:
    count = round(seconds * RATE)
    rng = np.random.default_rng(seed)
    drift = np.cumsum(walk / math.sqrt(RATE) * rng.standard_normal((count, 3)), axis=0)
    return ar.Recording(
        t=np.arange(count) / RATE,
        rate=RATE,
        gyr=0.01 + drift + GYR * rng.standard_normal((count, 3)),
        acc=[0.0, 0.0, 9.81] + ACC * rng.standard_normal((count, 3)),
        mag=FIELD + MAG * rng.standard_normal((count, 3)),
    )


@pytest.fixture(scope="module")
def result() -> Noise:
    return noise(still())


def test_the_covariance_is_cirillos(result: Noise) -> None:
    expected = np.concatenate((GYR, ACC / 9.80665, MAG / np.linalg.norm(FIELD))) ** 2
    # A variance of 20,000 samples is known to √(2/20000) = 1 %.
    assert np.allclose(result.variances, expected, rtol=0.04)
    correlation = result.covariance / np.sqrt(np.outer(result.variances, result.variances))
    assert np.abs(correlation - np.eye(9)).max() < 4.0 / math.sqrt(20_000)
    assert list(result.sensors) == ["gyr", "acc", "mag"]


def test_the_parameters_are_those_of_the_filters(result: Noise) -> None:
    ekf = ar.EKF(rate=RATE, **result.ekf_parameters())
    names = [f"{sensor}_variance_{axis}" for sensor in ("gyr", "acc", "mag") for axis in "xyz"]
    assert [ekf.params[name] for name in names] == result.variances.tolist()
    mekf = ar.MEKF(rate=RATE, **result.mekf_parameters())
    mean = [math.sqrt(np.mean(sigma**2) / RATE) for sigma in (GYR, ACC, MAG)]
    assert mekf.params["gyr_noise"] == pytest.approx(mean[0], rel=0.03)
    assert mekf.params["acc_noise"] == pytest.approx(mean[1], rel=0.03)
    assert mekf.params["heading_noise"] == pytest.approx(mean[2] / 20.0, rel=0.03)
    assert "bias_noise" not in result.mekf_parameters(), "white noise says nothing of a walk"


def test_a_walk_of_the_bias_is_the_bias_noise() -> None:
    parameters = noise(still(500.0, 1, walk=3e-4)).mekf_parameters()
    assert parameters["bias_noise"] == pytest.approx(3e-4, rel=0.25)


def test_a_slower_magnetometer_has_its_own_rate() -> None:
    recording = still()
    assert recording.mag is not None
    mag = recording.mag.copy()
    mag[np.arange(len(mag)) % 5 != 2] = np.nan
    slow = noise(dataclasses.replace(recording, mag=mag)).sensors["mag"]
    assert slow.rate == RATE / 5
    # The same standard deviation at a fifth of the rate.
    expected = math.sqrt(np.mean(MAG**2) / slow.rate)
    assert slow.mean("random_walk") == pytest.approx(expected, rel=0.05)


def test_a_few_missing_rows_do_not_matter_and_many_are_refused() -> None:
    recording = still(100.0)
    gyr = recording.gyr.copy()
    gyr[np.random.default_rng(0).choice(len(gyr), 50, replace=False)] = np.nan
    whole, gappy = noise(recording), noise(dataclasses.replace(recording, gyr=gyr))
    assert gappy.sensors["gyr"].mean("random_walk") == pytest.approx(whole.sensors["gyr"].mean("random_walk"), rel=0.02)
    gyr[np.random.default_rng(1).choice(len(gyr), 2000, replace=False)] = np.nan
    with pytest.raises(ValueError, match=r"gyr: expected measurements at a constant rate, but .* of 10000 are missing"):
        noise(dataclasses.replace(recording, gyr=gyr))


def test_six_axes_and_one_are_enough() -> None:
    recording = still(30.0)
    six = noise(dataclasses.replace(recording, mag=None))
    assert six.covariance.shape == (6, 6)
    assert ar.EKF(rate=RATE, **six.ekf_parameters()).params["mag_variance_x"] == 2.0e-3
    one = noise(dataclasses.replace(recording, acc=None, mag=None))
    assert one.covariance.shape == (3, 3)
    assert list(one.mekf_parameters()) == ["gyr_noise"]


def test_errors_name_the_sensor() -> None:
    recording = still(30.0)
    dead = np.tile(FIELD, (len(recording), 1))
    with pytest.raises(ValueError, match="mag, axis x: x: expected samples with noise, got 3000 equal ones"):
        noise(dataclasses.replace(recording, mag=dead))
    with pytest.raises(ValueError, match="mag: expected measurements at rest, got only rows with NaN"):
        noise(dataclasses.replace(recording, mag=np.full_like(dead, np.nan)))
    with pytest.raises(ValueError, match="expected a rest"):
        noise(dataclasses.replace(recording, gyr=recording.gyr + np.sin(recording.t)[:, np.newaxis]))
    with pytest.raises(ValueError, match="rest: expected one of 1000 samples"):
        noise(recording[:1000], find_rest(recording))


def test_the_command_prints_the_table_and_writes_everything(tmp_path: Path, capsys: Capture) -> None:
    still().save(tmp_path / "still.npz")
    shown = output_of(
        capsys, "noise", tmp_path / "still.npz", "-o", tmp_path / "noise.json", "--plot", tmp_path / "a.png"
    )
    assert "rest       199.99 s\n" in shown
    assert "gyr at 100 Hz" in shown
    assert "rad/s/√Hz" in shown
    assert "MEKF       gyr_noise=0.000" in shown
    assert "bias_noise" not in shown
    written = json.loads((tmp_path / "noise.json").read_text(encoding="utf-8"))
    expected = noise(ar.read(tmp_path / "still.npz")).to_dict()
    assert written == expected
    assert (written["format"], written["version"]) == ("ahrs_rs.noise", 1)
    assert written["sensors"]["gyr"]["axes"]["x"]["rate_random_walk"]["value"] is None
    assert "slope" in written["sensors"]["gyr"]["axes"]["x"]["rate_random_walk"]["reason"]
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_the_command_takes_the_interval_that_it_is_given(tmp_path: Path, capsys: Capture) -> None:
    recording = still(60.0)
    shaken = recording.gyr.copy()
    shaken[3000:] += np.sin(recording.t[3000:])[:, np.newaxis]
    path = tmp_path / "rec.npz"
    dataclasses.replace(recording, gyr=shaken).save(path)
    assert "rest       20 s\n" in output_of(capsys, "noise", path, "--static", "5:25")
    assert "rest       29.99 s\n" in output_of(capsys, "noise", path, "--static", ":29.99")
    assert "rest       59.99 s\n" in output_of(capsys, "noise", path, "--static", ":")


def test_errors_of_the_command(tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "rec.npz"
    still(30.0).save(path)
    assert "expected START:END in s, got '3'" in error_of(capsys, "noise", path, "--static", "3")
    assert "expected START before END" in error_of(capsys, "noise", path, "--static", "4:3")
    assert "no sample there; it is 29.99 s long" in error_of(capsys, "noise", path, "--static", "40:50")
    assert "got 11" in error_of(capsys, "noise", path, "--static", "0:0.1")
    assert "-o: expected a name that ends in .json" in error_of(capsys, "noise", path, "-o", tmp_path / "a.txt")
    assert "--plot" in error_of(capsys, "noise", path, "--plot", tmp_path / "a.xyz")


def test_real_sensors_are_as_their_data_sheets_say(broad: list[ar.Recording]) -> None:
    for recording in broad[::5]:
        gyr = noise(recording).sensors["gyr"]
        # Consumer MEMS gyroscopes have densities of 0.003 to 0.02 °/s/√Hz, over √2 as N.
        assert 3e-5 < gyr.mean("random_walk") < 3e-4, recording.meta["path"]
