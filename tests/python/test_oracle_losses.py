"""Filters and oracles where something is lost, slow, repeated or wrong: the rules of docs/losses.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ahrs_rs import Status
from cases import CASES, Case, each_case
from losses import BEFORE, kept, lost, resting
from signals import RATE, Signals, disturbed, gappy, motion, multiply, quats, turns_by
from test_oracle import Inputs, Scenario, compare

#: The end of the gyroscope's range, rad/s.
LIMIT = 3.5
#: Samples of the hand-held sensor: rests, a turn, an acceleration, and the rest after them.
HAND_HELD = 3000


def hand_held(first: int = 0) -> Signals:
    """It rests until 4 s and from 20 to 24 s, and is accelerated from 10 to 15 s."""
    return kept(disturbed(slice(0, 0)), np.arange(first, min(first + HAND_HELD, 4000)))


def spans(*rows: tuple[int, int]) -> NDArray[np.intp]:
    """The rows of several spans."""
    return np.concatenate([np.arange(*span) for span in rows])


@cache
def held_rates(_: bool) -> Inputs:
    """Rates are missing: at rest, in motion, for long and without a field.

    And for so short that nothing is aligned (0.07 s), or nothing begins (0.03 s).
    """
    signals = hand_held().without(
        gyr=spans((100, 140), (600, 640), (900, 907), (1300, 1303), (1700, 1800), (2100, 2160)),
        acc=spans((1790, 1830)),
        mag=spans((1790, 1960), (2150, 2230)),
    )
    return Inputs(signals.rounded())


@cache
def clipped_rates(_: bool) -> Inputs:
    """Rates are at the end of a range that is known.

    For half a second at most: for longer, the published EKF is thousands of standard deviations off where it
    takes its rate from the specific force, and amplifies rounding.
    """
    signals = hand_held(1600)
    signals = replace(signals, gyr=np.clip(signals.gyr, -LIMIT, LIMIT)).without(mag=np.arange(len(signals)) % 5 != 0)
    settings = {"gyr_range": LIMIT, "gyr_hold": "linear", "frame": "NWU", "declination": 0.2}
    return Inputs(signals.rounded(), settings=settings)


@cache
def gaps(_: bool) -> Inputs:
    """Rows are missing, the rate falls twice, and the clock leaps."""
    left = np.ones(HAND_HELD, dtype=bool)
    left[spans((120, 180), (700, 760), (1100, 1103), (1300, 1315), (2080, 2130))] = False
    rows = np.arange(HAND_HELD)
    left &= (rows < 1500) | (rows % 2 == 0)
    left &= (rows < 2300) | (rows % 16 == 0) | (rows > 2700)
    signals = hand_held()
    signals = kept(replace(signals, t=signals.t + np.where(rows < 2800, 0.0, 6.0)), np.flatnonzero(left))
    return Inputs(signals.rounded(), use_t=True)


@cache
def slow_sensors(level: bool) -> Inputs:
    """Accelerometer and magnetometer are slower than the gyroscope, by a part that changes, and fail for a while."""
    signals = motion(HAND_HELD, 11, level=level)
    rows, jitter = np.arange(HAND_HELD), np.random.default_rng(12).uniform(-0.3, 0.3, HAND_HELD)
    signals = replace(signals, t=signals.t + jitter / RATE)
    slow = {"acc": rows % 3 != 0, "mag": rows % np.where(rows < 1500, 5, 25) != 0}
    signals = signals.without(**slow).without(acc=slice(600, 800), mag=slice(700, 1100), gyr=rows % 499 == 1).rounded()
    q0 = multiply(signals.before, quats(turns_by(0.3, 1, 12))[0])
    return Inputs(signals, use_t=True, settings={"q0": q0, "declination": -0.1, "frame": "NED"})


@cache
def slow_sensors_from_their_first_row(level: bool) -> Inputs:
    """At a constant rate, without a given start, in six axes."""
    rows = np.arange(1500)
    signals = motion(1500, 13, level=level).without(acc=rows % 7 != 3)
    return Inputs(gappy(signals, 14).rounded(), nine=False, settings={"gyr_hold": "linear"})


@cache
def repeated_rows(level: bool) -> Inputs:
    """Rows of slow sensors are repeated; now and then those of all sensors, and for more than a second."""
    signals = motion(HAND_HELD, 15, level=level)
    rows = np.arange(HAND_HELD)
    same = {"gyr": rows - (rows % 50 == 7), "acc": rows - rows % 2, "mag": rows - rows % 6}
    same["mag"][700:900], same["acc"][1000:1250] = 700, 1000
    arrays = {name: getattr(signals, name)[index] for name, index in same.items()}
    signals = replace(signals, **arrays).without(mag=rows % 13 == 0, acc=rows % 11 == 0)
    return Inputs(signals.rounded(), settings={"repeated": "missing"})


@cache
def repeated_rows_as_they_are(level: bool) -> Inputs:
    """The same, each row a measurement."""
    return replace(repeated_rows(level), settings={})


@cache
def over_in_ned(level: bool) -> Inputs:
    """Six axes, level in NED to some degrees, where the first force comes late."""
    signals = motion(1000, 16, level=level).turned(Rotation.from_euler("xy", [175.0, 8.0], degrees=True))
    return Inputs(signals.without(acc=slice(0, 20)).rounded(), nine=False, settings={"frame": "NED"})


@cache
def on_its_side_in_nwu(level: bool) -> Inputs:
    """Six axes, and a roll by 100°; the magnetometer comes later."""
    signals = motion(1000, 17, level=level).turned(Rotation.from_euler("x", 100.0, degrees=True))
    return Inputs(signals.without(mag=slice(0, 500)).rounded(), settings={"frame": "NWU", "declination": 0.1})


def turn_of_another_sign(seed: int, axis: tuple[float, float, float], angle: float) -> Signals:
    """A level sensor at rest that turns, by rates of the other sign."""
    signals = resting(seed, axis=np.array(axis), angle=angle, pose=np.array([1.0, 0.0, 0.0, 0.0]))
    return kept(lost(signals, "gyr has the other sign"), np.arange(BEFORE - 1200, BEFORE + 1000)).rounded()


@cache
def untold_inclination(_: bool) -> Inputs:
    """An inclination is off by far, in nine axes."""
    return Inputs(turn_of_another_sign(18, (1.0, 0.3, 0.1), 0.7))


@cache
def untold_inclination_in_six_axes(_: bool) -> Inputs:
    """The same in six, where it is off by a right angle and more."""
    return Inputs(turn_of_another_sign(23, (0.3, 1.0, 0.1), 0.8), nine=False)


@cache
def untold_heading(_: bool) -> Inputs:
    """The heading alone is off."""
    return Inputs(turn_of_another_sign(20, (0.0, 0.0, 1.0), 1.0))


@cache
def inverted_start(_: bool) -> Inputs:
    """The first force is of the other sign."""
    signals = turn_of_another_sign(21, (0.0, 1.0, 0.0), 0.0)
    signals.acc[0] *= -1.0
    return Inputs(signals, settings={"declination": 0.3})


#: The scenarios, with a status bit that some filter sets in each.
SCENARIOS: dict[Scenario, Status] = {
    held_rates: Status.RECOVERING,
    clipped_rates: Status.RECOVERING,
    gaps: Status.GAP,
    slow_sensors: Status.ACC_MISSING,
    slow_sensors_from_their_first_row: Status.ACC_MISSING,
    repeated_rows: Status.REPEATED,
    repeated_rows_as_they_are: Status.ACC_MISSING,
    over_in_ned: Status.NOT_ALIGNED,
    on_its_side_in_nwu: Status.MAG_MISSING,
    untold_inclination: Status.RECOVERING,
    untold_inclination_in_six_axes: Status.RECOVERING,
    untold_heading: Status.RECOVERING,
    inverted_start: Status.RECOVERING,
}
each_scenario = pytest.mark.parametrize("scenario", list(SCENARIOS), ids=lambda scenario: scenario.__name__)


@each_scenario
@each_case
def test_it_agrees_with_the_oracle(case: Case, scenario: Scenario) -> None:
    compare(case, scenario, "losses.py")


@each_scenario
def test_the_recordings_are_what_they_are_meant_to_be(scenario: Scenario) -> None:
    seen = 0
    for case in CASES:
        if case.label in ("mahony", "ekf", "dcm-imu", "mekf", "selfcal"):
            seen |= int(np.bitwise_or.reduce(scenario(case.euler_rates).run(case).status))
    assert seen & SCENARIOS[scenario]


Watched = Callable[[bool], Inputs]


@pytest.mark.parametrize(
    ("scenario", "label"),
    [
        (untold_inclination, "mekf"),
        (untold_inclination, "selfcal"),
        (untold_inclination_in_six_axes, "dcm-imu"),
        (untold_inclination_in_six_axes, "mekf"),
        (untold_heading, "mekf"),
        (untold_heading, "selfcal"),
        (inverted_start, "ekf"),
        (inverted_start, "dcm-imu"),
    ],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_what_nobody_told_is_found_out(scenario: Watched, label: str) -> None:
    """So that the comparisons with the oracle see the watch at work."""
    (case,) = [case for case in CASES if case.label == label]
    assert np.any(scenario(case.euler_rates).run(case).status & Status.RECOVERING)
