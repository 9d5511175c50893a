"""`VQF` and `BasicVQF` beside the package of their authors, and what they do beyond it."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import vqf
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from ahrs_rs import Status
from commands import DATA, needs_data
from signals import FIELD, UP, Floats, about_z, angle_between, motion, multiply, quats, rotation, still, turns_by

#: Rounding of 1e-16 in each sample, that the integration of the angular rate adds up: measured at most 2e-12, of the
#: heading offset.
EQUAL = 1e-10

#: Parameter sets of the package, by their names in it: each reaches another part.
SETTINGS: dict[str, dict[str, Any]] = {
    "defaults": {},
    "fast": {"tauAcc": 0.7, "tauMag": 1.5, "restFilterTau": 0.1, "magCurrentTau": 0.3, "magRefTau": 2.0},
    "no-motion-bias": {"motionBiasEstEnabled": False},
    "no-rest-bias": {"restBiasEstEnabled": False},
    "no-rejection": {"magDistRejectionEnabled": False},
    "nothing": {"motionBiasEstEnabled": False, "restBiasEstEnabled": False, "magDistRejectionEnabled": False},
    "no-rest-no-rejection": {"restBiasEstEnabled": False, "magDistRejectionEnabled": False},
    "bias": {
        "biasSigmaInit": 2.0,
        "biasForgettingTime": 10.0,
        "biasClip": 5.0,
        "biasSigmaMotion": 0.3,
        "biasVerticalForgettingFactor": 0.1,
        "biasSigmaRest": 0.01,
    },
    "rest": {"restMinT": 0.5, "restThGyr": 10.0, "restThAcc": 2.0},
    "field": {
        "magNormTh": 0.03,
        "magDipTh": 3.0,
        "magNewTime": 2.0,
        "magNewFirstTime": 0.5,
        "magNewMinGyr": 5.0,
        "magMinUndisturbedTime": 0.2,
        "magMaxRejectionTime": 3.0,
        "magRejectionFactor": 5.0,
    },
    "no-filter-of-the-field": {"magCurrentTau": 0.0, "magNewMinGyr": 0.0},
    "pass-through": {"tauAcc": 0.0004, "restFilterTau": 0.0001, "magCurrentTau": 0.0004, "tauMag": 0.0},
}
#: What the orientation alone has.
BASIC_SETTINGS = {
    "defaults": {},
    "fast": {"tauAcc": 0.7, "tauMag": 1.5},
    "pass-through": {"tauAcc": 0.0004, "tauMag": 0.0},
}


def snake_case(name: str) -> str:
    return re.sub("([A-Z])", lambda match: "_" + match[1].lower(), name)


def ours(name: str, params: dict[str, Any], **keywords: Any) -> ar.Filter:
    return ar.FILTERS[name](**{snake_case(key): value for key, value in params.items()}, **keywords)


def assert_equal_to_the_package(name: str, params: dict[str, Any], rate: float, sensors: tuple[Any, ...]) -> None:
    """Every output of a run is that of the package, at every sample."""
    gyr, acc, mag = (None if v is None else np.ascontiguousarray(v, dtype=np.float64) for v in sensors)
    theirs = getattr(vqf, name)(1.0 / rate, **params).updateBatchFullState(gyr, acc, mag)
    est = ours(name, params, rate=rate).run(gyr, acc, mag, outputs=tuple(ar.FILTERS[name].OUTPUTS))
    six = theirs["quat6D"]
    assert angle_between(est.extra["quat6d"], six).max() < EQUAL
    assert angle_between(est.quat, theirs["quat9D"] if mag is not None else six).max() < EQUAL
    if mag is not None:
        assert angle_between(est.extra["quat9d"], theirs["quat9D"]).max() < EQUAL
        off = est.extra["delta"] - theirs["delta"]
        assert np.abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))).max() < EQUAL
    if name == "BasicVQF":
        return
    assert est.gyr_bias is not None
    assert np.abs(est.gyr_bias - theirs["bias"]).max() < EQUAL
    assert np.abs(est.extra["bias_sigma"] - theirs["biasSigma"]).max() < EQUAL
    assert np.array_equal(est.extra["rest"], theirs["restDetected"])
    assert np.array_equal(est.status & Status.REST != 0, theirs["restDetected"])
    if mag is not None:
        assert np.array_equal(est.extra["mag_disturbed"], theirs["magDistDetected"])
        # Norms of some 50 µT.
        assert np.abs(est.extra["mag_ref_norm"] - theirs["magRefNorm"]).max() < 50.0 * EQUAL
        assert np.abs(est.extra["mag_ref_dip"] - theirs["magRefDip"]).max() < EQUAL


def everyday(rate: float, seconds: float = 90.0) -> tuple[Floats, Floats, Floats]:
    """Movement with rests, a biased gyroscope, and a field that is disturbed for a while and later another one."""
    r = ar.simulate.demo(seconds, rate, 3)
    assert r.acc is not None
    assert r.mag is not None
    assert r.ref is not None
    gyr, mag = r.gyr + np.array([0.006, -0.004, 0.01]), r.mag.copy()
    samples = len(gyr)
    for first, last, wrong in ((0.4, 0.5, [25.0, 0.0, 10.0]), (0.7, 1.0, [0.0, 12.0, -18.0])):
        part = slice(int(first * samples), int(last * samples))
        mag[part] += rotation(r.ref[part]).inv().apply(wrong)
    return gyr, r.acc, mag


@pytest.mark.parametrize("rate", [100.0, 200.0, 1000.0])
@pytest.mark.parametrize("settings", SETTINGS)
def test_vqf_equals_the_package_on_simulated_data(settings: str, rate: float) -> None:
    sensors = everyday(rate, 90.0 if rate < 1000.0 else 45.0)
    assert_equal_to_the_package("VQF", SETTINGS[settings], rate, sensors)
    assert_equal_to_the_package("VQF", SETTINGS[settings], rate, (*sensors[:2], None))


@pytest.mark.parametrize("rate", [100.0, 200.0, 1000.0])
@pytest.mark.parametrize("settings", BASIC_SETTINGS)
def test_basic_vqf_equals_the_package_on_simulated_data(settings: str, rate: float) -> None:
    sensors = everyday(rate, 45.0)
    assert_equal_to_the_package("BasicVQF", BASIC_SETTINGS[settings], rate, sensors)
    assert_equal_to_the_package("BasicVQF", BASIC_SETTINGS[settings], rate, (*sensors[:2], None))


def test_the_simulated_data_reaches_every_part() -> None:
    est = ar.VQF(rate=100.0, **{snake_case(k): v for k, v in SETTINGS["field"].items()}).run(
        *everyday(100.0), outputs=("rest", "mag_disturbed", "mag_ref_norm")
    )
    for bit in (Status.REST, Status.MAG_REJECTED, Status.RECOVERING):
        share = np.mean(est.status & bit != 0)
        assert 0.002 < share < 0.9, bit
    # A field of its own at the start, and another one that is accepted later.
    assert len(np.unique(est.extra["mag_ref_norm"][::500])) > 3
    assert (np.abs(np.diff(est.extra["mag_ref_norm"])) > 5.0).sum() >= 2


def test_the_parameters_are_those_of_the_package_with_its_defaults() -> None:
    for name in ("VQF", "BasicVQF"):
        theirs = {snake_case(key): value for key, value in getattr(vqf, name)(0.01).params.items()}
        ours_too = {"mag_delay": 0.0}  # which the package has not, and which does nothing at zero
        assert {key: spec.default for key, spec in ar.FILTERS[name].PARAMS.items()} == theirs | ours_too


RECORDINGS = sorted(Path(DATA, "broad").glob("*.hdf5")) if DATA else []


@needs_data
@pytest.mark.parametrize("name", ["VQF", "BasicVQF"])
def test_equals_the_package_on_every_broad_recording(name: str) -> None:
    assert len(RECORDINGS) >= 12
    for file in RECORDINGS:
        r = ar.read(file)
        assert r.rate is not None
        assert_equal_to_the_package(name, {}, r.rate, (r.gyr, r.acc, r.mag))


@needs_data
@pytest.mark.parametrize("settings", SETTINGS)
def test_vqf_equals_the_package_on_its_own_recording(settings: str) -> None:
    data = np.load(Path(DATA, "vqf", "imu_data.npz"))
    sensors = (data["gyr"], data["acc"], data["mag"])
    assert_equal_to_the_package("VQF", SETTINGS[settings], float(data["sampling_rate"]), sensors)


def total_error(r: ar.Recording, quat: Floats, rows: Any = slice(None)) -> float:
    assert r.ref is not None
    return ar.metrics.score(quat, r.ref[rows], None if r.mask is None else r.mask[rows]).total


@needs_data
def test_a_loss_of_samples_costs_little_where_their_times_are_known() -> None:
    complete, lost, linear, fixed = [], [], [], []
    for index, file in enumerate(RECORDINGS):
        r = ar.read(file)
        assert r.acc is not None
        assert r.mag is not None
        complete.append(total_error(r, ar.VQF(rate=r.rate).run(r.gyr, r.acc, r.mag).quat))
        kept = np.flatnonzero(np.random.default_rng(index).random(len(r.gyr)) >= 0.3)
        sensors = (r.gyr[kept], r.acc[kept], r.mag[kept])
        t = r.t[kept]
        lost.append(total_error(r, ar.VQF(rate=r.rate).run(*sensors, t=t).quat, kept))
        linear.append(total_error(r, ar.VQF(rate=r.rate, gyr_hold="linear").run(*sensors, t=t).quat, kept))
        fixed.append(total_error(r, ar.VQF(rate=r.rate).run(*sensors).quat, kept))
    means = [float(np.mean(errors)) for errors in (complete, lost, linear, fixed)]
    print(
        "total error in degrees: complete {:.3f}, lost {:.3f}, linear hold {:.3f}, at a fixed rate {:.2f}".format(
            *means
        )
    )
    assert means[1] < 1.25 * means[0]
    assert means[2] < 1.15 * means[0]
    # What the original would do: the gyroscope's samples count for the wrong time.
    assert means[3] > 3.0 * means[0]


@pytest.mark.parametrize("name", ["VQF", "BasicVQF"])
def test_a_cut_off_above_the_nyquist_frequency_passes_through(name: str) -> None:
    # With tau = 0.4 steps; at half a step there is a filter again.
    signals = motion(2000, 5)
    none, above, below = (
        ar.FILTERS[name](rate=100.0, tau_acc=tau).run(*signals.sensors()).quat for tau in (0.0, 0.004, 0.005)
    )
    assert np.array_equal(none, above)
    assert angle_between(above, below).max() > 1e-3
    # Nothing is filtered: the specific force of every sample is vertical.
    up = rotation(above).apply(signals.acc)
    assert np.abs(up[:, :2]).max() < 1e-12


TIMES = [key for key, spec in ar.VQF.PARAMS.items() if spec.unit == "s"]
THRESHOLDS = ["bias_clip", "rest_th_gyr", "rest_th_acc", "mag_norm_th", "mag_dip_th", "bias_forgetting_time"]
SIGMAS = ["bias_sigma_init", "bias_sigma_motion", "bias_sigma_rest", "mag_rejection_factor"]


@pytest.mark.parametrize("key", TIMES)
@pytest.mark.parametrize("value", [-1.0, -1e-9, math.nan, math.inf])
def test_times_are_not_negative(key: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"^{key}: expected a number in"):
        ar.VQF(**{key: value})


@pytest.mark.parametrize("key", THRESHOLDS + SIGMAS)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
def test_thresholds_are_positive(key: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"^{key}: expected a number in"):
        ar.VQF(**{key: value})


@pytest.mark.parametrize("value", [1, 0.0, "True", None, np.ones(1), [True]])
def test_a_switch_is_true_or_false(value: object) -> None:
    with pytest.raises(ValueError, match=r"^rest_bias_est_enabled: expected one of False, True, got"):
        ar.VQF(rest_bias_est_enabled=value)
    assert ar.VQF(rest_bias_est_enabled=np.False_).params["rest_bias_est_enabled"] is False
    assert ar.VQF().rest_bias_est_enabled is True


def test_a_slower_magnetometer_is_one_with_its_own_sampling_time() -> None:
    # The package's clocks count a sample's time from the first on, here from the second: its fast start, its averages
    # and the acceptance of the first reference come a sample earlier.
    gyr, acc, mag = everyday(100.0)
    slow = mag.copy()
    slow[np.arange(len(mag)) % 5 != 0] = np.nan
    theirs = vqf.VQF(0.01, 0.01, 0.05)
    expected = np.empty((len(gyr), 4))
    for k, (w, a, m) in enumerate(zip(gyr, acc, slow, strict=True)):
        theirs.updateGyr(w)
        theirs.updateAcc(a)
        if k % 5 == 0:
            theirs.updateMag(m)
        expected[k] = theirs.getQuat9D()
    est = ar.VQF(rate=100.0).run(gyr, acc, slow)
    assert angle_between(est.quat, expected).max() < 0.02
    assert np.sqrt(np.mean(angle_between(est.quat, expected) ** 2)) < 0.005


def test_a_slower_accelerometer_gives_the_same_attitude() -> None:
    gyr, acc, mag = everyday(200.0)
    whole = ar.VQF(rate=200.0).run(gyr, acc, mag).quat
    slow = acc.copy()
    slow[np.arange(len(acc)) % 4 != 0] = np.nan
    # The bias is found by other samples.
    assert angle_between(ar.VQF(rate=200.0).run(gyr, slow, mag).quat, whole).max() < 0.03


@pytest.mark.parametrize("name", ["VQF", "BasicVQF"])
def test_a_given_attitude_is_kept_and_pulled_by_the_time_constants(name: str) -> None:
    signals = still(quats(turns_by(0.4, 1, 2))[0], 3000)
    truth = quats(turns_by(0.4, 1, 2))[0]
    q0 = multiply(about_z(1.0), multiply(truth, quats(turns_by(0.2, 1, 3))[0]))
    est = ar.FILTERS[name](rate=100.0).run(**signals, q0=q0, outputs=("delta",))
    # A first sample of weight 1/900, or half of it while no field is known.
    assert angle_between(est.quat[0], q0) < 3e-3
    assert abs(est.extra["delta"][0]) < 2e-3
    assert abs(est.extra["delta"][-1]) > 0.5
    assert angle_between(est.quat[-1], truth) < 0.3
    six = ar.FILTERS[name](rate=100.0).run(signals["gyr"], signals["acc"], q0=q0, outputs=("quat6d", "delta"))
    assert angle_between(six.extra["quat6d"], six.quat).max() < 1e-15 * 10
    assert not six.extra["delta"].any()


@pytest.mark.parametrize("name", ["VQF", "BasicVQF"])
def test_a_late_magnetometer_sets_the_heading_at_once(name: str) -> None:
    signals = motion(3000, 8, noise=0.0).without(mag=slice(0, 1000))
    est = ar.FILTERS[name](rate=100.0).run(*signals.sensors())
    heading = rotation(est.quat).apply(signals.mag)
    assert np.abs(np.arctan2(heading[1000, 0], heading[1000, 1])) < 1e-12


def hour(rate: float) -> tuple[Floats, Floats, Floats]:
    """Five minutes of slow periodic movement with noise and a bias, to be repeated twelve times."""
    samples = int(300.0 * rate)
    phase = 2.0 * np.pi * np.arange(samples + 1)[:, None] / samples * [40.0, 30.0, 25.0]
    angles = np.sin(phase) * [2.0, 0.7, 0.9]
    attitude = Rotation.from_euler("ZYX", angles)
    rng = np.random.default_rng(4)
    rate_ = (attitude[:-1].inv() * attitude[1:]).as_rotvec() * rate
    back = attitude[1:].inv()
    gyr = rate_ + [0.004, -0.007, 0.002] + 0.01 * rng.standard_normal(rate_.shape)
    acc = back.apply(UP) + 0.2 * rng.standard_normal(rate_.shape)
    mag = back.apply(FIELD) + 0.5 * rng.standard_normal(rate_.shape)
    return gyr, acc, mag


@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
def test_float32_holds_its_accuracy_over_an_hour_at_1000_hz(nine: bool) -> None:
    # The same rounded measurements in both. In six axes nothing feeds the heading back: rounding of 6e-8 in 3.6 million
    # steps is a walk of 1.1e-4 rad, and a bias that is off by 3e-6 rad/s for the minutes in which it is forgotten adds
    # 1e-3. A state that stalled would be off by degrees.
    gyr, acc, mag = (v.astype(np.float32) for v in hour(1000.0))
    exact = (gyr.astype(np.float64), acc.astype(np.float64), mag.astype(np.float64) if nine else None)
    state32 = state64 = None
    f = ar.VQF(rate=1000.0)
    worst, worst_bias = 0.0, 0.0
    for _ in range(12):
        narrow = f.run(gyr, acc, mag if nine else None, state=state32)
        wide = f.run(*exact, state=state64)
        state32, state64 = narrow.state, wide.state
        assert narrow.quat.dtype == np.float32
        assert narrow.gyr_bias is not None
        assert wide.gyr_bias is not None
        worst = max(worst, angle_between(narrow.quat[::7].astype(np.float64), wide.quat[::7]).max())
        worst_bias = max(worst_bias, float(np.abs(narrow.gyr_bias[::7] - wide.gyr_bias[::7]).max()))
    print(f"float32 beside float64 over an hour: {worst:.2e} rad, bias {worst_bias:.2e} rad/s")
    assert worst < (1e-3 if nine else 5e-3)
    assert worst_bias < 2e-5
