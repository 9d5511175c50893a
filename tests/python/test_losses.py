"""What the gyroscope has lost comes back from the accelerometer and the magnetometer, and until then nobody is sure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from ahrs_rs import Status
from cases import OFFLINE, STREAMING, each_streaming_filter
from commands import Capture, output_of, saved, simulated
from losses import BEFORE, LASTING, SEEING, TURN, largest_errors, lost, observed_error, resting, run_all, set_ahead
from signals import RATE, Signals, angle_between, quats, rotation, squares

DEGREE = np.pi / 180.0
SEEDS = range(6)

#: The filters that say how sure they are.
SURE = [name for name in SEEING if "covariance" in ar.FILTERS[name].OUTPUTS]

#: Marks a test to run over the filters that see where they are and go on from sample to sample.
each_seeing_filter = pytest.mark.parametrize("name", [name for name in SEEING if name in STREAMING])

#: Losses that the data tell: by a NaN, by stamps, or by readings at the range that the filter was told.
TOLD = ["gyr is NaN", "rows are missing", "all sensors are NaN", "gyr is clipped"]


def told(name: str, how: str) -> ar.Filter:
    """The filter, which knows the range if readings are clipped."""
    return ar.FILTERS[name](rate=RATE, **({"gyr_range": 1.0} if how == "gyr is clipped" else {}))


@pytest.mark.parametrize("how", TOLD)
@pytest.mark.parametrize("name", SEEING)
def test_a_turn_that_is_lost_is_found_again_within_seconds_of_rest(name: str, how: str) -> None:
    # One sample of force and field gives the attitude; 5 s are there to see that the sensor is quiet.
    after = (BEFORE + TURN) / RATE + 5.0
    whole = [resting(seed) for seed in SEEDS]
    usual = largest_errors(ar.FILTERS[name](rate=RATE), whole, after).max()
    errors = largest_errors(told(name, how), [lost(one, how) for one in whole], after)
    assert errors.max() < max(1.0 * DEGREE, 2.0 * usual)


@pytest.mark.parametrize("how", TOLD)
@pytest.mark.parametrize("name", [name for name in SURE if name in STREAMING])
def test_a_turn_that_is_lost_is_in_the_covariance_a_second_later_and_until_it_is_found(name: str, how: str) -> None:
    def normalised(f: ar.Filter, recordings: list[Signals]) -> float:
        values = []
        for est, one in zip(run_all(f, recordings, outputs=("covariance",)), recordings, strict=True):
            rows = one.t >= (BEFORE + TURN) / RATE + 1.0
            error = (rotation(est.quat[rows]).inv() * rotation(one.truth[rows])).as_rotvec()
            values.append(squares(error, est.covariance[rows]))
        return float(np.median(values, axis=0).max())

    whole = [resting(seed) for seed in SEEDS]
    # χ² of three degrees of freedom is above 16.3 once in a thousand, and the median of six hardly ever; where a filter
    # is too sure of itself without a loss, three times of that.
    usual = normalised(ar.FILTERS[name](rate=RATE), whole)
    assert normalised(told(name, how), [lost(one, how) for one in whole]) < max(16.3, 3.0 * usual)


@pytest.mark.parametrize("name", LASTING)
def test_a_filter_says_that_it_recovers_and_when_it_has(name: str) -> None:
    for how in ("gyr is NaN", "rows are missing"):
        signals = lost(resting(0), how)
        (est,) = run_all(ar.FILTERS[name](rate=RATE), [signals])
        recovering = est.status & Status.RECOVERING > 0
        assert not recovering[:BEFORE].any()
        assert recovering[np.flatnonzero(signals.t >= BEFORE / RATE)[0] :][: TURN + 1].any()
        assert not recovering[signals.t > (BEFORE + TURN) / RATE + 5.0].any()


@each_streaming_filter
def test_a_row_that_is_lost_at_rest_is_no_loss(name: str) -> None:
    # 10 ms at 0.002 rad/s leave a thousandth of a degree unknown: nothing is aligned again, and the rate is held.
    signals = resting(1, angle=0.0)
    held = signals.gyr.copy()
    held[1000] = held[999]
    f = ar.FILTERS[name](rate=RATE)
    a = f.run(*lost(signals, "gyr is NaN", slice(1000, 1001)).sensors())
    b = f.run(held, signals.acc, signals.mag)
    # What a Kalman filter does not know it may count, to a thousandth of a degree. For the EKF a rate that is lost is
    # none, and one that is held a measurement once more, of some 0.002 rad/s noise, over 10 ms and what the gain makes.
    assert angle_between(a.quat, b.quat).max() < (3e-3 if name == "EKF" else 1e-3) * DEGREE
    assert not (a.status[999:1100] & Status.RECOVERING).any()


def test_the_gyroscope_alone_is_never_aligned_again() -> None:
    angle = 0.5 * np.pi
    signals = lost(resting(2, angle=angle), "gyr is NaN")
    est = ar.GyroIntegration(rate=RATE).run(*signals.sensors())
    assert not (est.status & Status.RECOVERING).any()
    # Held noise of 0.002 rad/s for 0.4 s, and its walk of 50 s: 1e-3 rad.
    assert angle_between(est.quat[-1], signals.truth[-1]) == pytest.approx(angle, abs=5e-3)


@pytest.mark.parametrize("how", ["gyr is NaN", "rows are missing"])
@each_seeing_filter
def test_six_axes_keep_their_heading_when_they_are_aligned_again(name: str, how: str) -> None:
    # From level by 60° about the sensor's y axis: a turn that leaves the heading as it was, and the yaw too.
    pose, axis = quats(Rotation.from_euler("z", 40.0, degrees=True)), np.array([0.0, 1.0, 0.0])
    whole = [resting(seed, angle=np.pi / 3.0, axis=axis, pose=pose) for seed in SEEDS]
    f = ar.FILTERS[name](rate=RATE)
    after = (BEFORE + TURN) / RATE + 5.0

    def largest(recordings: list[Signals]) -> float:
        estimates = run_all(f, recordings, nine=False, q0=pose)
        pairs = zip(estimates, recordings, strict=True)
        return max(angle_between(est.quat[one.t > after], one.truth[one.t > after]).max() for est, one in pairs)

    # In 50 s the noise of the rate turns the heading by 0.002 √(50/100) rad, 0.08°; the noise of the force that aligns,
    # 0.01/9.8 rad, is a twentieth of a degree. A bias about the vertical that it has learnt meanwhile it cannot see.
    assert largest([lost(one, how) for one in whole]) < largest(whole) + 2.0 * DEGREE


@pytest.mark.parametrize("how", TOLD)
@pytest.mark.parametrize("name", [name for name in OFFLINE if ar.FILTERS[name].FEEDBACK])
def test_an_offline_filter_is_not_wrong_before_a_loss(name: str, how: str) -> None:
    for signals in (lost(resting(seed), how) for seed in SEEDS):
        est = told(name, how).run(*signals.sensors(), t=signals.t)
        # Without the loss it is right to 0.1°. A block of the smoother is 0.1 s.
        before = signals.t < BEFORE / RATE - 0.1
        assert angle_between(est.quat[before], signals.truth[before]).max() < 0.5 * DEGREE


# Clocks and holes.

#: A minute, an hour, and what a clock is set ahead by when it has found out which year it is.
JUMPS = [60.0, 3600.0, 2e8]
#: A bias that no filter could integrate over the jump, rad/s.
BIAS = np.array([0.004, -0.005, 0.003])


@pytest.mark.parametrize("jump", JUMPS)
@each_seeing_filter
def test_a_clock_that_is_set_ahead_at_rest_is_no_matter_ten_seconds_later(name: str, jump: float) -> None:
    signals = resting(3, angle=0.0)
    signals.gyr[:] += BIAS
    ahead = set_ahead(signals, BEFORE, jump)
    f = ar.FILTERS[name](rate=RATE)
    est, without = run_all(f, [ahead, signals])
    late = slice(BEFORE + 1000, None)
    truth = signals.truth[late]
    # Field and gravity have not changed: the filter is where it was, and where it was is where a bias holds it.
    usual = observed_error(f, without.quat[late], truth).max()
    assert observed_error(f, est.quat[late], truth).max() < usual + 0.5 * DEGREE


@pytest.mark.parametrize("hole", [36.0, 3600.0])
@pytest.mark.parametrize("name", SEEING)
def test_a_sensor_that_was_turned_in_a_hole_is_found_again(name: str, hole: float) -> None:
    whole = [resting(seed) for seed in SEEDS]
    recordings = [set_ahead(lost(one, "rows are missing"), BEFORE, hole) for one in whole]
    f, after = ar.FILTERS[name](rate=RATE), (BEFORE + TURN) / RATE + 5.0
    usual = largest_errors(f, whole, after).max()
    assert largest_errors(f, recordings, after + hole).max() < max(1.0 * DEGREE, 2.0 * usual)


@pytest.mark.parametrize("jump", [5.0, *JUMPS])
@each_streaming_filter
def test_a_gap_is_told_where_it_is_and_nowhere_else(name: str, jump: float) -> None:
    signals = set_ahead(resting(4, angle=0.0), BEFORE, jump)
    (est,) = run_all(ar.FILTERS[name](rate=RATE), [signals])
    assert est.status.dtype == np.uint16
    assert np.flatnonzero(est.status & Status.GAP).tolist() == [BEFORE]


@each_streaming_filter
def test_a_jittering_clock_and_single_lost_rows_are_no_gap(name: str) -> None:
    draw = np.random.default_rng(5)
    signals = resting(5, angle=0.0)
    t = signals.t + draw.uniform(-0.4, 0.4, len(signals)) / RATE
    left = draw.random(len(signals)) > 0.05
    est = ar.FILTERS[name](rate=RATE).run(signals.gyr[left], signals.acc[left], signals.mag[left], t=t[left])
    # Two or three rows in turn are lost here at times: a step is at most some four times as long as usual.
    assert not (est.status & (Status.GAP | Status.RECOVERING)).any()


@pytest.mark.parametrize("jump", [37.0, 86400.0])
def test_the_command_names_the_largest_step_of_the_clock(tmp_path: Path, capsys: Capture, jump: float) -> None:
    recording = simulated()
    t = recording.t.copy()
    t[100:] += jump
    shown = output_of(capsys, "run", saved(tmp_path / "walk.npz", t=t), "--filter", "mahony")
    assert any("step" in line and f"{jump:g}" in line for line in shown.splitlines())
    assert "GAP 1 " in shown
    assert "GAP" not in output_of(capsys, "run", saved(tmp_path / "walk.npz"), "--filter", "mahony")


# On real recordings.


@pytest.mark.parametrize("how", ["gyr is NaN", "rows are missing", "all sensors are NaN"])
@pytest.mark.parametrize("name", ["MEKF", "SelfCalKF", "EKF", "DcmImu", "VQF", "Madgwick", "Mahony"])
def test_a_second_that_is_lost_in_motion_is_forgotten_half_a_minute_later(
    data_folder: Path, name: str, how: str
) -> None:
    (file,) = (data_folder / "broad").glob("05_*.hdf5")
    r = ar.read(file)[8000:23000]  # from 28 s to 80.5 s; it moves from 35 s on
    gyr, acc, mag, keep = r.gyr.copy(), r.acc.copy(), r.mag.copy(), np.ones(len(r), dtype=bool)
    hit = slice(5500, 5500 + round(r.rate))
    if how == "rows are missing":
        keep[hit] = False
    else:
        for array in (gyr,) if how == "gyr is NaN" else (gyr, acc, mag):
            array[hit] = np.nan
    f = ar.FILTERS[name](rate=r.rate)
    est = f.run(gyr[keep], acc[keep], mag[keep] if f.MAGNETOMETER else None, t=r.t[keep])
    whole = f.run(r.gyr, r.acc, r.mag if f.MAGNETOMETER else None, t=r.t)
    late = slice(-1000, None)
    error, usual = (np.nanmean(observed_error(f, one.quat[late], r.ref[late])) / DEGREE for one in (est, whole))
    # As without the loss, or 3°: what the filters have here by themselves.
    assert error < max(2.0 * usual, 3.0)
