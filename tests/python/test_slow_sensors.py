"""A sensor that is slower than the gyroscope: a measurement stands for the time since the sensor's last one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ahrs_rs as ar
from ahrs_rs import Status
from cases import STREAMING, Case, assert_same_attitudes, each_case
from losses import LASTING
from signals import FIELD, RATE, UP, Floats, Signals, angle_between, motion, quats, rotation

#: Rows of the gyroscope for one of the slower sensor.
EVERY = 10
#: Rows of all sensors at the slow rate.
COUNT = 40
DEGREE = np.pi / 180.0

#: Filters whose variances are those of a sample at the gyroscope's rate: ten rows of it are worth more than one.
OF_SAMPLES = ("EKF", "LinearKalman", "DcmImu")
#: Slow sensors, whether there is a magnetometer, the axis of the wrong start, and the other filters.
DECAYS = [
    (slow, nine, axis, name)
    for slow, nine, axis in (
        (("acc",), False, "x"),
        (("acc",), False, "y"),
        (("acc", "mag"), True, "x"),
        (("acc", "mag"), True, "z"),
    )
    for name in LASTING
    if name not in OF_SAMPLES and (ar.FILTERS[name].MAGNETOMETER or not nine)
]


def still(count: int, start: Floats, slow: tuple[str, ...] = ()) -> Signals:
    """A sensor at rest, level and to the north, whose slow sensors have the last row of every ten."""
    rows = np.arange(count)
    arrays = {"acc": np.tile(UP, (count, 1)), "mag": np.tile(FIELD, (count, 1))}
    for name in slow:
        arrays[name][rows % EVERY != EVERY - 1] = np.nan
    truth = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    return Signals(t=rows / RATE, gyr=np.zeros((count, 3)), truth=truth, before=start, **arrays)


def errors(name: str, count: int, rate: float, start: Floats, slow: tuple[str, ...] = (), nine: bool = False) -> Floats:
    """Angles from the truth (count,) of a run that starts elsewhere, about the axis of that start."""
    signals = still(count, start, slow)
    est = ar.FILTERS[name](rate=rate).run(*signals.sensors(nine=nine), q0=start)
    axis = rotation(start).as_rotvec()
    return rotation(est.quat).as_rotvec() @ (axis / np.linalg.norm(axis))


@pytest.mark.parametrize(("slow", "nine", "axis", "name"), DECAYS, ids=str)
def test_an_error_decays_as_if_all_sensors_came_at_the_slow_rate(
    slow: tuple[str, ...], nine: bool, axis: str, name: str
) -> None:
    start = quats(Rotation.from_euler(axis, 20.0, degrees=True))
    mixed = errors(name, COUNT * EVERY, RATE, start, slow, nine)[EVERY - 1 :: EVERY]
    slowly = errors(name, COUNT, RATE / EVERY, start, nine=nine)
    # The first measurement stands for one row or for ten: a tenth of a second of what follows. After that the same
    # measurements correct at the same times; where a gain is large, what was one step before are ten. What Mahony's
    # integral turns in nine rows the next measurement sees at once, of one step it is seen by the one after that:
    # its overshoot, by a fifth of the start, is a tenth smaller.
    shift = np.abs(slowly[:-1] - slowly[1:])
    near = np.minimum(np.abs(mixed[1:-1] - slowly[:-2]), np.abs(mixed[1:-1] - slowly[1:-1]))
    assert np.all(near <= shift[:-1] + (0.1 if name == "Mahony" else 0.05) * np.abs(slowly[:-2]) + 0.05 * DEGREE)


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("name", OF_SAMPLES)
def test_a_measurement_is_worth_as_much_as_one_in_each_row_since_the_last(name: str, axis: str) -> None:
    start = quats(Rotation.from_euler(axis, 20.0, degrees=True))
    mixed, fast = (errors(name, COUNT * EVERY, RATE, start, slow)[EVERY - 1 :: EVERY] for slow in (("acc",), ()))
    slowly = errors(name, COUNT, RATE / EVERY, start)
    # The first one stands for one row, so that the others are one interval behind.
    if name == "DcmImu":
        # Its variance grows with the innovation, which falls from row to row: ten rows are worth more than one.
        assert np.all((fast[:5] < mixed[1:6]) & (mixed[1:6] < slowly[1:6]))
    else:
        # The filter is one row older then; the variance of one row would leave four times as much.
        assert mixed[1:11] == pytest.approx(fast[:10], rel=0.1)


def test_a_time_constant_is_one_at_any_rate_of_the_accelerometer() -> None:
    # The first measurement comes in the tenth row, and stands for that row alone.
    for tau in (0.5, 1.0, 3.0):
        count = round(tau * RATE)
        start = quats(Rotation.from_euler("x", 20.0, degrees=True))
        signals = still(count, start, ("acc",))
        est = ar.Complementary(rate=RATE, tau=tau).run(signals.gyr, signals.acc, q0=start)
        left = angle_between(est.quat[-1], signals.truth[-1]) / (20.0 * DEGREE)
        since = (count - EVERY) / RATE
        # It is all that differs from e^(−t/τ).
        assert left == pytest.approx(np.exp(-since / tau), rel=1.1 / RATE / tau)


@pytest.mark.parametrize("name", [name for name in LASTING if ar.FILTERS[name].MAGNETOMETER])
def test_a_slower_magnetometer_holds_the_heading_as_well(data_folder: Path, name: str) -> None:
    (file,) = (data_folder / "broad").glob("07_*.hdf5")
    r = ar.read(file)
    mag = np.where(np.arange(len(r))[:, None] % 15 == 0, r.mag, np.nan)
    f = ar.FILTERS[name](rate=r.rate)
    whole, slow = (ar.metrics.score(f.run(r.gyr, r.acc, m).quat, r.ref, r.mask).total for m in (r.mag, mag))
    # At 19 Hz instead of 286 Hz, while it turns by up to 25 rad/s: noise counts more. Those that went by time before
    # (VQF, SelfCalKF and MEKF) differ by less than 3 %.
    assert slow < 1.25 * whole + 0.5


# Rows that repeat.

#: Longest time (s) for which a row that repeats is none.
LONGEST = 1.0


def repeating(signals: Signals, every: int, sensors: tuple[str, ...]) -> tuple[Signals, Signals]:
    """With a slower sensor whose last row is repeated, and with rows of NaN instead."""
    rows = np.arange(len(signals))
    held = {name: getattr(signals, name)[rows // every * every] for name in sensors}
    missing = signals.without(**dict.fromkeys(sensors, rows % every != 0))
    return Signals(**{**vars_of(signals), **held}), missing


def vars_of(signals: Signals) -> dict[str, Floats]:
    return {name: getattr(signals, name) for name in ("t", "gyr", "acc", "mag", "truth", "before")}


@pytest.mark.parametrize("sensors", [("mag",), ("acc",), ("acc", "mag")], ids=str)
@pytest.mark.parametrize("name", STREAMING)
def test_repeated_rows_are_none_where_asked_for(name: str, sensors: tuple[str, ...]) -> None:
    held, missing = repeating(motion(400, 1), 5, sensors)
    a = ar.FILTERS[name](rate=RATE, repeated="missing").run(*held.sensors())
    b = ar.FILTERS[name](rate=RATE).run(*missing.sensors())
    assert_same_attitudes(a, b)
    again = np.arange(len(held)) % 5 != 0
    assert np.array_equal(a.status & Status.REPEATED > 0, again)
    for sensor, bit in (("acc", Status.ACC_MISSING), ("mag", Status.MAG_MISSING)):
        assert np.array_equal(a.status & bit > 0, again & (sensor in sensors))


@each_case
def test_repeated_rows_are_measurements_by_default(case: Case) -> None:
    held, _ = repeating(motion(200, 2), 5, ("mag",))
    for f in (case.make(rate=RATE), case.make(rate=RATE, repeated="new")):
        est = f.run(*held.sensors())
        assert not (est.status & (Status.REPEATED | Status.MAG_MISSING)).any()


@pytest.mark.parametrize("name", STREAMING)
def test_where_the_gyroscope_repeats_too_nothing_is_missing(name: str) -> None:
    # A simulation at rest, or a filter that is fed with one row again: every sensor says the same, and it is new.
    signals = motion(50, 3)
    arrays = [np.repeat(array, 4, axis=0) for array in signals.sensors()]
    f = ar.FILTERS[name](rate=RATE, repeated="missing")
    est, plain = f.run(*arrays), ar.FILTERS[name](rate=RATE).run(*arrays)
    assert_same_attitudes(est, plain)
    assert not (est.status & Status.REPEATED).any()


@pytest.mark.parametrize("name", STREAMING)
def test_a_row_that_repeats_for_longer_than_a_second_is_the_measurement_again(name: str) -> None:
    signals = motion(400, 4)
    signals.mag[100:] = signals.mag[100]
    est = ar.FILTERS[name](rate=RATE, repeated="missing").run(*signals.sensors())
    times = np.flatnonzero(est.status & Status.REPEATED) - 100
    # From the row after the first one on; at most LONGEST s in turn, whatever a step rounds to.
    assert np.array_equal(times, 1 + np.arange(len(times)))
    assert abs(len(times) - LONGEST * RATE) <= 1


@pytest.mark.parametrize("name", STREAMING)
def test_repeated_rows_are_the_same_in_a_stream_and_in_pieces(name: str) -> None:
    held, _ = repeating(motion(60, 5), 3, ("mag",))
    f = ar.FILTERS[name](rate=RATE, repeated="missing")
    whole = f.run(*held.sensors())
    first = f.run(*(array[:31] for array in held.sensors()))
    last = f.run(*(array[31:] for array in held.sensors()), state=first.state)
    assert np.array_equal(whole.quat, np.concatenate((first.quat, last.quat)))
    assert np.array_equal(whole.status, np.concatenate((first.status, last.status)))
    stream = [f.update(gyr, acc, mag).copy() for gyr, acc, mag in zip(*held.sensors(), strict=True)]
    assert np.array_equal(whole.quat, np.array(stream))


@pytest.mark.parametrize("repeated", ["old", "", None, 1])
def test_an_unknown_rule_for_repeated_rows_is_an_error(repeated: object) -> None:
    with pytest.raises(ValueError, match="repeated: expected one of 'new', 'missing', got"):
        ar.Madgwick(rate=RATE, repeated=repeated)
