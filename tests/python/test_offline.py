"""The rules for every offline filter of the registry: those of all filters that make sense without a state."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from ahrs_rs import Status
from cases import OFFLINE
from signals import (
    RATE,
    Floats,
    Signals,
    about_z,
    angle_between,
    conjugate,
    finite_and_unit,
    gappy,
    motion,
    multiply,
)

each_offline_filter = pytest.mark.parametrize("name", OFFLINE)
#: What goes on from sample to sample.
STREAMED = ["update", "reset", "state", "restore", "quat", "gyr_bias", "status", "covariance"]


def test_there_are_offline_filters() -> None:
    assert {"OfflineVQF", "SelfCalSmoother"} <= set(OFFLINE)


def run(name: str, signals: Signals, nine: bool = True, **keywords: Any) -> ar.Estimate:
    return ar.FILTERS[name](rate=RATE, **keywords).run(*signals.sensors(nine=nine))


@each_offline_filter
@pytest.mark.parametrize("member", STREAMED)
def test_it_has_nothing_of_a_streaming_filter_and_says_why(name: str, member: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    assert not hasattr(f, member)
    with pytest.raises(
        AttributeError, match=f"{name} is offline and has no {member}: it takes whole recordings by run"
    ):
        getattr(f, member)


@pytest.mark.parametrize("name", ar.FILTERS)
@pytest.mark.parametrize("with_t", [False, True], ids=["rate", "t"])
def test_an_empty_recording_gives_an_empty_estimate_and_leaves_the_others_as_they_are(name: str, with_t: bool) -> None:
    f = ar.FILTERS[name](rate=RATE)
    signals = motion(300, 1)
    whole = dict(zip(("gyr", "acc", "mag"), signals.sensors(), strict=True)) | ({"t": signals.t} if with_t else {})
    recordings: list[Any] = [whole, {name: array[:0] for name, array in whole.items()}, whole]
    assert len(f.run(**recordings[1])) == 0
    alone = f.run(**recordings[0])
    for errors in ("raise", "return"):
        first, none, last = ar.run_many(f, recordings, errors=errors)
        assert len(none) == 0
        assert np.array_equal(first.quat, alone.quat)
        assert np.array_equal(last.quat, alone.quat)


@each_offline_filter
def test_a_magnetometer_is_missing_where_its_rows_are_whatever_else_is_there(name: str) -> None:
    signals = motion(400, 5)
    mag = signals.mag.copy()
    mag[50:90] = np.nan
    f = ar.FILTERS[name](rate=RATE)
    for acc in (signals.acc, None, np.full_like(signals.acc, np.nan)):
        est = f.run(signals.gyr, acc, mag)
        assert np.array_equal(est.status & Status.MAG_MISSING != 0, np.isnan(mag).any(axis=1))
        assert not (f.run(signals.gyr, acc).status & Status.MAG_MISSING).any()


@each_offline_filter
def test_the_native_side_refuses_it_too(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    native = ar.Filter.__base__
    assert native is not None
    for call in (
        lambda: native.update(f, [0.0, 0.0, 0.0]),
        lambda: native.reset(f),
        lambda: native._snapshot(f),
        lambda: native._restore(f, ([], None, 0)),
        lambda: native._sweep(f, [], [], "total", None, False, None),
    ):
        with pytest.raises(TypeError, match=f"^{name} is offline"):
            call()


@each_offline_filter
def test_a_start_or_a_state_is_refused(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    sensors = motion(20, 1).sensors()
    with pytest.raises(ValueError, match=f"^q0: expected None, as {name} starts from the recording"):
        f.run(*sensors, q0=[1.0, 0.0, 0.0, 0.0])
    state = ar.Tilt(rate=RATE).run(*sensors).state
    with pytest.raises(ValueError, match=f"^state: expected None, as {name} is offline"):
        f.run(*sensors, state=state)
    assert f.run(*sensors).state is None
    assert f.run(*(np.stack([v, v]) for v in sensors)).state is None


@each_offline_filter
@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
def test_missing_rows_leave_finite_unit_attitudes(name: str, nine: bool) -> None:
    for samples in (0, 1, 2, 3, 700):
        for seed in range(3):
            signals = gappy(motion(samples, seed), seed)
            outputs = tuple(ar.FILTERS[name].OUTPUTS)
            est = ar.FILTERS[name](rate=RATE).run(*signals.sensors(nine=nine), outputs=outputs)
            assert samples == 0 or finite_and_unit(est.quat)
            assert est.quat.shape == (samples, 4)
            assert est.gyr_bias is None or np.isfinite(est.gyr_bias).all()
            assert all(np.isfinite(values).all() for values in est.extra.values())


@each_offline_filter
def test_rows_with_nothing_in_them_are_flagged_and_bridged(name: str) -> None:
    whole = motion(3000, 3, noise=0.0)
    expected = run(name, whole).quat
    signals = whole.without(acc=slice(0, 50), mag=slice(2900, 3000)).without(acc=slice(1000, 1100), mag=slice(0, 60))
    est = run(name, signals)
    assert not (est.status & Status.NOT_ALIGNED).any()
    assert np.array_equal(est.status & Status.ACC_MISSING != 0, np.isnan(signals.acc).any(axis=1))
    assert np.array_equal(est.status & Status.MAG_MISSING != 0, np.isnan(signals.mag).any(axis=1))
    # Half a second at the start and a second at the end are bridged by the gyroscope.
    assert angle_between(est.quat, expected).max() < 0.1


@each_offline_filter
def test_without_an_accelerometer_nothing_is_aligned(name: str) -> None:
    gyr, _, mag = motion(100, 3).sensors()
    est = ar.FILTERS[name](rate=RATE).run(gyr, None, mag)
    assert finite_and_unit(est.quat)
    assert (est.status & Status.NOT_ALIGNED).all()


@each_offline_filter
def test_the_sign_of_the_quaternion_is_continuous(name: str) -> None:
    quat = run(name, motion(3000, 5)).quat
    assert quat[0, 0] >= 0.0
    assert (np.sum(quat[1:] * quat[:-1], axis=1) > 0.0).all()


@each_offline_filter
@pytest.mark.parametrize("nine", [True, False], ids=["9D", "6D"])
def test_frames_and_declination_turn_the_output(name: str, nine: bool) -> None:
    signals = motion(500, 6)
    enu = run(name, signals, nine).quat
    h = np.sqrt(0.5)
    turns: dict[str, list[float]] = {"ENU": [1.0, 0.0, 0.0, 0.0], "NED": [0.0, h, h, 0.0], "NWU": [h, 0.0, 0.0, -h]}
    for frame, turn in turns.items():
        for declination in (0.0, 0.3):
            est = run(name, signals, nine, frame=frame, declination=declination)
            north: Floats = about_z(-declination if nine else 0.0)
            if not nine:
                # The heading of the start is 0 in each frame: a constant turn about the vertical lies between them.
                between = multiply(conjugate(np.array(turn)), multiply(est.quat, conjugate(enu)))[0]
                assert np.abs(between[1:3]).max() < 1e-14
                north = between
            # Products of unit quaternions: some 1e-16 each.
            assert angle_between(est.quat, multiply(np.array(turn), multiply(north, enu))).max() < 1e-14


@each_offline_filter
def test_float32_is_computed_in_float64_and_rounded(name: str) -> None:
    narrow = [v.astype(np.float32) for v in motion(2000, 7).sensors()]
    f = ar.FILTERS[name](rate=RATE)
    est, wide = f.run(*narrow), f.run(*(v.astype(np.float64) for v in narrow))
    assert est.quat.dtype == np.float32
    assert np.array_equal(est.quat, wide.quat.astype(np.float32))
    assert np.array_equal(est.status, wide.status)


@each_offline_filter
def test_layouts_stacks_and_run_many_give_the_same_bits(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    recordings = [gappy(motion(samples, samples), samples) for samples in (700, 3, 0, 257, 1, 1500)]
    plain = [f.run(*signals.sensors()) for signals in recordings]
    for threads in (1, 2):
        many = ar.run_many(f, [signals.sensors() for signals in recordings], threads=threads)
        for one, other in zip(plain, many, strict=True):
            assert np.array_equal(one.quat, other.quat)
            assert np.array_equal(one.status, other.status)
    sensors = recordings[0].sensors()
    stacked = f.run(*(np.stack([v, v[::-1], v]) for v in sensors))
    assert np.array_equal(stacked.quat[0], plain[0].quat)
    assert np.array_equal(stacked.quat[2], plain[0].quat)
    strided = [np.repeat(np.asfortranarray(v), 2, axis=0)[::2] for v in sensors]
    out = np.empty((700, 8))[:, ::2]
    est = f.run(*strided, out=out)
    assert est.quat is out
    assert np.array_equal(out, plain[0].quat)


@each_offline_filter
def test_an_infinite_value_is_refused(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE)
    for index, sensor in enumerate(("gyr", "acc", "mag")):
        sensors = motion(300, 1).sensors()
        sensors[index][200, 1] = np.inf
        with pytest.raises(ValueError, match=f"^{sensor}: expected"):
            f.run(*sensors)


@each_offline_filter
def test_stamps_of_a_constant_rate_give_what_the_rate_gives(name: str) -> None:
    sensors = motion(2000, 9).sensors()
    f = ar.FILTERS[name](rate=RATE)
    stamps = np.arange(2000) / RATE
    # Differences of stamps are off by 2e-15 s, so that the start of a low-pass filter may end a sample later: measured
    # 1.5e-6 rad, and 1.8e-6 rad/s of the bias.
    assert angle_between(f.run(*sensors, t=stamps).quat, f.run(*sensors).quat).max() < 1e-5
    jittered = stamps + np.random.default_rng(1).uniform(-0.003, 0.003, 2000)
    assert finite_and_unit(ar.FILTERS[name]().run(*sensors, t=jittered).quat)
    assert finite_and_unit(f.run(*sensors, t=np.repeat(stamps[::2], 2)).quat)


@each_offline_filter
def test_copies_and_pickles_are_the_same_filter(name: str) -> None:
    f = ar.FILTERS[name](rate=RATE, frame="NED", dtype=np.float32)
    for twin in (f.copy(), copy.copy(f), copy.deepcopy(f), pickle.loads(pickle.dumps(f))):
        assert repr(twin) == repr(f)
    est = f.run(*motion(20, 1).sensors())
    assert np.array_equal(pickle.loads(pickle.dumps(est)).quat, est.quat)


@each_offline_filter
@pytest.mark.parametrize("metric", ["total", "heading", "inclination"])
def test_a_sweep_has_the_errors_of_its_runs(name: str, metric: str) -> None:
    recordings = [ar.simulate.demo(10.0, 100.0, seed) for seed in range(2)]
    tuned = {"OfflineVQF": "tau_acc", "SelfCalSmoother": "velocity"}[name]
    swept = ar.sweep(ar.FILTERS[name], {tuned: [1.0, 3.0]}, recordings, metric)
    for p, value in enumerate((1.0, 3.0)):
        for r, recording in enumerate(recordings):
            assert recording.ref is not None
            est = ar.FILTERS[name](rate=100.0, **{tuned: value}).run(
                recording.gyr, recording.acc, recording.mag, t=recording.t
            )
            score = ar.metrics.score(est.quat, recording.ref, recording.mask)
            assert swept.errors[p, r] == getattr(score, metric)
    assert swept.metric == metric
    with pytest.raises(ValueError, match=r"^metric: expected one of"):
        ar.sweep(ar.FILTERS[name], {}, recordings, "nothing")
