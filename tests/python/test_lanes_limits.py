"""Recordings side by side have the bits of each alone, also where one of them needs a limit, a reset or a recovery."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import ahrs_rs as ar
from cases import Case, each_case
from signals import RATE, Signals, motion

#: Blocks of SelfCalKF end at other samples, and its start is over: after the first seconds.
SAMPLES = 1300
DTYPES = pytest.mark.parametrize("dtype", [np.float64, np.float32])


def assert_same_bits(f: ar.Filter, recordings: list[Signals]) -> None:
    """`run_many` gives what `run` gives."""
    calls = [{"gyr": one.gyr, "acc": one.acc, "mag": one.mag, "t": one.t} for one in recordings]
    for together, call in zip(ar.run_many(f, calls), calls, strict=True):
        alone = f.run(**call)
        assert np.array_equal(together.quat, alone.quat)
        assert np.array_equal(together.status, alone.status)
        assert together.state == alone.state
        if alone.gyr_bias is not None:
            assert np.array_equal(together.gyr_bias, alone.gyr_bias)


# What happens to one lane.


def biased(bias: float) -> Callable[[Signals], Signals]:
    """A gyroscope far beyond what a filter takes for a bias."""
    return lambda signals: replace(signals, gyr=signals.gyr + bias)


def clipped(signals: Signals) -> Signals:
    return replace(signals, gyr=np.clip(signals.gyr, -1.0, 1.0))


def leaping(signals: Signals) -> Signals:
    """A minute, an hour and three years."""
    t = signals.t.copy()
    for row, seconds in ((300, 60.0), (600, 3600.0), (900, 1e8)):
        t[row:] += seconds
    return replace(signals, t=t)


def silent(signals: Signals) -> Signals:
    """One sensor after the other for two seconds, and then all of them."""
    return signals.without(gyr=np.r_[200:400, 900:1100], acc=np.r_[450:650, 900:1100], mag=np.r_[650:850, 900:1100])


def upside_down(signals: Signals) -> Signals:
    """The first rows of the accelerometer have the other sign, and the middle ones are ten times too large."""
    acc = signals.acc.copy()
    acc[:3] *= -1.0
    acc[500:700] *= 10.0
    return replace(signals, acc=acc)


def elsewhere(signals: Signals) -> Signals:
    """A field of another place, of another size and to another side, for half of the recording."""
    mag = signals.mag.copy()
    mag[400:900] = -2.0 * mag[400:900, [1, 2, 0]]
    return replace(signals, mag=mag)


def lost_turns(signals: Signals) -> Signals:
    """Rows of the gyroscope with another sign, which nothing tells."""
    gyr = signals.gyr.copy()
    gyr[300:360] *= -1.0
    gyr[700:760] *= -1.0
    return replace(signals, gyr=gyr)


def at_rest(signals: Signals) -> Signals:
    """Nothing moves for half of the recording, and then it does."""
    gyr, acc, mag = (array.copy() for array in signals.sensors())
    gyr[:650] *= 1e-3
    acc[:650], mag[:650] = acc[650], mag[650]
    return replace(signals, gyr=gyr, acc=acc, mag=mag)


ALONE = {
    "bias 0.2": biased(0.2),
    "bias 3": biased(3.0),
    "clipped": clipped,
    "leaping": leaping,
    "silent": silent,
    "upside down": upside_down,
    "elsewhere": elsewhere,
    "lost turns": lost_turns,
    "at rest": at_rest,
}


@DTYPES
@each_case
def test_what_one_lane_needs_happens_in_no_other(case: Case, dtype: type) -> None:
    # Every recording has stamps of its own, so that blocks, gaps and recoveries fall on other samples in each lane.
    quiet = [motion(SAMPLES, seed, jitter=True, noise=0.02, level=True) for seed in range(len(ALONE))]
    wild = [change(one) for change, one in zip(ALONE.values(), quiet, strict=True)]
    recordings = [one.astype(dtype) for pair in zip(quiet, wild, strict=True) for one in pair]
    assert_same_bits(case.make(rate=RATE), recordings)


@DTYPES
@pytest.mark.parametrize("what", ALONE)
@pytest.mark.parametrize("name", ["SelfCalKF", "DcmImu", "MEKF", "EKF", "VQF"])
def test_one_wild_lane_among_quiet_ones_changes_none(name: str, what: str, dtype: type) -> None:
    recordings = [motion(SAMPLES, seed, jitter=True, noise=0.02) for seed in range(8)]
    recordings[3] = ALONE[what](recordings[3])
    assert_same_bits(ar.FILTERS[name](rate=RATE), [one.astype(dtype) for one in recordings])


@DTYPES
@pytest.mark.parametrize("bias", [0.1, 0.2, 0.5])
def test_a_bias_at_the_limit_of_selfcal_is_that_of_each_alone(bias: float, dtype: type) -> None:
    recordings = []
    for seed in range(4):
        draw = np.random.default_rng(seed)
        r = ar.simulate.demo(25.0, RATE, seed)
        t = np.cumsum(draw.uniform(0.5, 1.5, len(r)) / RATE)
        recordings.append(Signals(t, r.gyr + bias, r.acc, r.mag, truth=r.ref, before=r.ref[0]).astype(dtype))
    assert_same_bits(ar.SelfCalKF(rate=RATE), recordings)


@DTYPES
@pytest.mark.parametrize(
    "params",
    [
        {},
        {"acc_motion": 0.0},
        {"acc_motion": 0.0, "acc_std": 0.05},
        {"acc_motion": 0.0, "acc_std": 0.01, "initial_bias": 0.01},
    ],
    ids=str,
)
@pytest.mark.parametrize("bias", [0.5, 3.0, 30.0])
def test_a_bias_at_the_limit_of_dcm_imu_is_that_of_each_alone(
    bias: float, params: dict[str, float], dtype: type
) -> None:
    recordings = []
    for seed in range(4):
        missing = np.random.default_rng(seed).random(1000) < 0.3
        r = ar.simulate.demo(10.0, RATE, seed)
        signals = Signals(r.t, r.gyr + bias, r.acc, r.mag, truth=r.ref, before=r.ref[0])
        recordings.append(signals.without(acc=missing).astype(dtype))
    assert_same_bits(ar.DcmImu(rate=RATE, **params), recordings)
