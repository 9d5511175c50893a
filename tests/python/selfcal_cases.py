"""The recordings on which `SelfCalSmoother` is compared with its oracle (`test_offline_selfcal`)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

import ahrs_rs as ar
from ahrs_rs import Status
from signals import FIELD, UP, Signals, gappy, quats, random_turns, rotation, turned

RATE = 50.0


@dataclass(frozen=True)
class Faults:
    """What is wrong with the sensors, in SI units, and fields in norms of the earth's."""

    bias: tuple[float, ...] = (0.004, -0.003, 0.002)
    matrix: tuple[float, ...] = (4e-3, 1e-3, -2e-3, 0.0, -3e-3, 1e-3, 2e-3, 0.0, 2e-3)
    delay: float = 0.012
    hard_iron: tuple[float, ...] = (0.0, 0.0, 0.0)
    #: The times (s) until which it rests, and from which on it does again.
    rest: tuple[float, float] = (0.0, math.inf)
    #: A magnet (earth frame) between two times.
    magnet: tuple[float, ...] = (0.0, 0.0, 0.0)
    near: tuple[float, float] = (0.0, 0.0)
    gyr_range: float = math.inf
    #: Of the accelerometer.
    scale: float = 1.0
    jitter: float = 0.0


def recorded(seed: int, seconds: float, faults: Faults) -> Signals:
    """A sensor that is turned and shaken in one place."""
    rng = np.random.default_rng(seed)
    count = int(seconds * RATE)
    t = np.arange(count) / RATE + np.cumsum(faults.jitter * rng.uniform(-1.0, 1.0, count) / RATE)
    dt = np.diff(t, prepend=t[0])
    phase = rng.standard_normal(3)
    moves = ((t - t[0] >= faults.rest[0]) & (t - t[0] < faults.rest[1]))[:, None]
    rate = np.array([2.5, 3.0, 2.0]) * np.sin(np.outer(t, [0.9, 0.7, 0.5]) + phase) * moves
    truth = np.empty((count, 4))
    q = before = quats(random_turns(1, seed))[0]
    for k in range(count):
        truth[k] = q = turned(q, rate[k] * dt[k])
    matrix = np.reshape(faults.matrix, (3, 3))
    noise = [size * rng.standard_normal((count, 3)) for size in (2e-3, 0.05, 0.3)]
    gyr = np.linalg.solve(np.eye(3) + matrix, rate.T).T + faults.bias + noise[0]
    push = 2.0 * np.cos(np.outer(t, [7.0, 9.0, 11.0])) * moves
    acc = faults.scale * (rotation(truth).inv().apply(push + UP) + noise[1])
    magnet = np.where(((t - t[0] >= faults.near[0]) & (t - t[0] < faults.near[1]))[:, None], faults.magnet, 0.0)
    size = np.linalg.norm(FIELD)
    late = rotation(turned(truth, -faults.delay * rate))
    mag = late.inv().apply(FIELD + size * magnet) + size * np.array(faults.hard_iron) + noise[2]
    return Signals(t, np.clip(gyr, -faults.gyr_range, faults.gyr_range), acc, mag, truth, before)


@dataclass(frozen=True)
class Case:
    """A recording, what the estimate is to show of it, and parameters."""

    signals: Callable[[], Signals]
    shows: Callable[[ar.Estimate], bool]
    params: dict[str, float] = field(default_factory=dict)
    nine: bool = True
    stamped: bool = False
    hold: str = "zero-order"


CASES = {
    "moving, with bias, matrix, delay and hard iron": Case(
        lambda: recorded(1, 20.0, Faults(hard_iron=(0.03, -0.02, 0.04))),
        lambda est: est.extra["mag_delay"][0] > 0.006 and est.extra["hard_iron"][0, 2] > 1.0,
        {"initial_hard_iron": 0.05, "hard_iron_noise": 1e-3, "mag_noise": 0.01},
    ),
    "at rest, moving, at rest": Case(
        lambda: recorded(2, 10.0, Faults(rest=(4.0, 7.0))), lambda est: 0.3 < part(est, Status.REST) < 0.8
    ),
    "at rest all the time, with another gravity": Case(
        lambda: recorded(3, 6.0, Faults(rest=(math.inf, math.inf), scale=1.02)),
        lambda est: part(est, Status.REST) == 1.0,
    ),
    "six axes": Case(
        lambda: recorded(4, 9.0, Faults(rest=(4.0, 9.0))),
        lambda est: bool(np.trace(est.extra["covariance"][0]) > 3.0) and part(est, Status.REST) > 0.3,
        nine=False,
    ),
    "gaps and jitter": Case(
        lambda: gappy(recorded(5, 9.0, Faults(jitter=0.4)), 6).without(mag=slice(200, 230), acc=slice(300, 315)),
        lambda est: part(est, Status.GYR_HELD) > 0.01,
        stamped=True,
        hold="linear",
    ),
    "neither accelerometer nor magnetometer at the start": Case(
        lambda: recorded(6, 8.0, Faults()).without(acc=slice(0, 30), mag=slice(0, 65), gyr=slice(0, 2)),
        lambda est: part(est, Status.MAG_MISSING) > 0.1,
        {"latency": 0.02},
    ),
    "half a second lost": Case(
        lambda: recorded(11, 9.0, Faults()).without(gyr=slice(400, 450)),
        lambda est: part(est, Status.GYR_HELD) > 0.05,
    ),
    "a magnet near by": Case(
        lambda: recorded(7, 10.0, Faults(magnet=(0.3, -0.3, 0.2), near=(4.0, 7.0))),
        lambda est: 0.2 < part(est, Status.MAG_REJECTED) < 0.5,
    ),
    "a magnet near by at the start": Case(
        lambda: recorded(8, 9.0, Faults(magnet=(0.5, -0.3, 0.3), near=(0.0, 3.0))),
        lambda est: bool(est.extra["mag_weight"][50] < 0.25),
        {"disturbance": 0.05, "disturbance_time": 2.0},
    ),
    "the end of an unknown range": Case(
        lambda: recorded(9, 8.0, Faults(gyr_range=2.2)), lambda est: bool(est.extra["covariance"].max() > 0.03)
    ),
    "the end of a known range": Case(
        lambda: recorded(9, 8.0, Faults(gyr_range=2.2)),
        lambda est: bool(est.extra["covariance"].max() > 0.03),
        {"gyr_range": 2.2},
    ),
}


def part(est: ar.Estimate, flag: Status) -> float:
    """Of the samples, with a flag."""
    return float(np.mean(est.status & flag != 0))
