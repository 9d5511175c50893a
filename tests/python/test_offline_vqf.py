"""`OfflineVQF` beside the package of its authors, and what it does beyond it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import vqf

import ahrs_rs as ar
from ahrs_rs import Status
from commands import DATA, needs_data
from signals import angle_between
from test_vqf import RECORDINGS, SETTINGS, everyday, ours

#: Rounding of 1e-16 in each sample, that the integration of the angular rate adds up over minutes.
EQUAL = 1e-9


def assert_equal_to_the_package(params: dict[str, Any], rate: float, sensors: tuple[Any, ...]) -> None:
    """Every output of a run is that of the package, at every sample."""
    gyr, acc, mag = (None if v is None else np.ascontiguousarray(v, dtype=np.float64) for v in sensors)
    theirs = vqf.offlineVQF(gyr, acc, mag, 1.0 / rate, params)
    est = ours("OfflineVQF", params, rate=rate).run(gyr, acc, mag, outputs=tuple(ar.OfflineVQF.OUTPUTS))
    six = theirs["quat6D"]
    assert angle_between(est.extra["quat6d"], six).max() < EQUAL
    assert angle_between(est.quat, theirs["quat9D"] if mag is not None else six).max() < EQUAL
    assert est.gyr_bias is not None
    assert np.abs(est.gyr_bias - theirs["bias"]).max() < EQUAL
    assert np.abs(est.extra["bias_sigma"] - theirs["biasSigma"]).max() < EQUAL
    assert np.array_equal(est.extra["rest"], theirs["restDetected"])
    assert np.array_equal(est.status & Status.REST != 0, theirs["restDetected"])
    if mag is None:
        assert not est.extra["delta"].any()
        return
    assert angle_between(est.extra["quat9d"], theirs["quat9D"]).max() < EQUAL
    off = est.extra["delta"] - theirs["delta"]
    assert np.abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))).max() < EQUAL
    assert np.array_equal(est.extra["mag_disturbed"], theirs["magDistDetected"])


@pytest.mark.parametrize("rate", [100.0, 200.0, 1000.0])
@pytest.mark.parametrize("settings", SETTINGS)
def test_equals_the_package_on_simulated_data(settings: str, rate: float) -> None:
    sensors = everyday(rate, 90.0 if rate < 1000.0 else 45.0)
    assert_equal_to_the_package(SETTINGS[settings], rate, sensors)
    assert_equal_to_the_package(SETTINGS[settings], rate, (*sensors[:2], None))


@pytest.mark.parametrize("samples", [1, 2, 3, 50, 299, 300, 301])
def test_equals_the_package_on_recordings_shorter_than_its_filters(samples: int) -> None:
    assert_equal_to_the_package({}, 100.0, tuple(v[:samples] for v in everyday(100.0, 30.0)))


@needs_data
def test_equals_the_package_on_every_broad_recording() -> None:
    assert len(RECORDINGS) >= 12
    for file in RECORDINGS:
        r = ar.read(file)
        assert r.rate is not None
        assert_equal_to_the_package({}, r.rate, (r.gyr, r.acc, r.mag))


@needs_data
@pytest.mark.parametrize("settings", SETTINGS)
def test_equals_the_package_on_its_own_recording(settings: str) -> None:
    data = np.load(Path(DATA, "vqf", "imu_data.npz"))
    sensors = (data["gyr"], data["acc"], data["mag"])
    assert_equal_to_the_package(SETTINGS[settings], float(data["sampling_rate"]), sensors)


def test_the_parameters_are_those_of_vqf() -> None:
    assert dict(ar.OfflineVQF.PARAMS) == dict(ar.VQF.PARAMS)


def test_it_knows_the_bias_and_the_field_before_they_show() -> None:
    r = ar.simulate.demo(60.0, 100.0, 4)
    bias = np.array([0.006, -0.004, 0.01])
    offline = ar.OfflineVQF(rate=100.0).run(r.gyr + bias, r.acc, r.mag)
    online = ar.VQF(rate=100.0).run(r.gyr + bias, r.acc, r.mag)
    assert offline.gyr_bias is not None
    assert online.gyr_bias is not None
    start = slice(0, 100)
    worst = [float(np.abs(est.gyr_bias[start] - bias).max()) for est in (offline, online) if est.gyr_bias is not None]
    # VQF knows nothing yet; seen from the end the horizontal part is known, the vertical one shows at rest alone.
    assert worst[0] < 0.7 * worst[1]
    assert r.ref is not None
    totals = [ar.metrics.score(est.quat, r.ref, r.mask).total for est in (offline, online)]
    assert totals[0] < totals[1]


def test_a_recording_played_backward_has_the_same_headings_and_biases_of_the_other_sign() -> None:
    # Not to the bit: the strapdown integration of the original turns by a sample's rate before it in both directions.
    gyr, acc, mag = everyday(200.0)
    forward = ar.OfflineVQF(rate=200.0).run(gyr, acc, mag)
    backward = ar.OfflineVQF(rate=200.0).run(-gyr[::-1], acc[::-1], mag[::-1])
    assert forward.gyr_bias is not None
    assert backward.gyr_bias is not None
    # The same two estimates, joined in the other order.
    assert np.abs(forward.gyr_bias + backward.gyr_bias[::-1]).max() < 1e-12
    assert np.array_equal(forward.status & Status.REST, backward.status[::-1] & Status.REST)


def test_flags_say_what_was_left_out() -> None:
    # The field is disturbed for nine seconds: left out, or in both directions for the first three of them.
    for longest, bit, other in (
        (60.0, Status.MAG_REJECTED, Status.RECOVERING),
        (3.0, Status.RECOVERING, Status.MAG_REJECTED),
    ):
        f = ar.OfflineVQF(rate=100.0, mag_max_rejection_time=longest)
        est = f.run(*everyday(100.0), outputs=("mag_disturbed",))
        disturbed = est.extra["mag_disturbed"] > 0.0
        assert 0.05 < np.mean(est.status & bit != 0) < 0.3
        assert not ((est.status & bit != 0) & ~disturbed).any()
        assert not (est.status & other).any()
    off = ours("OfflineVQF", {"magDistRejectionEnabled": False}, rate=100.0).run(*everyday(100.0))
    assert not (off.status & (Status.MAG_REJECTED | Status.RECOVERING)).any()


def test_rows_at_their_own_times_cost_little() -> None:
    # A third of the samples is lost: what is left is close to the run over all of them.
    gyr, acc, mag = everyday(200.0)
    whole = ar.OfflineVQF(rate=200.0).run(gyr, acc, mag).quat
    kept = np.flatnonzero(np.random.default_rng(2).random(len(gyr)) >= 0.3)
    part = ar.OfflineVQF(rate=200.0, gyr_hold="linear").run(gyr[kept], acc[kept], mag[kept], t=kept / 200.0).quat
    assert np.sqrt(np.mean(angle_between(part, whole[kept]) ** 2)) < 0.03
