"""THE list of test cases: every filter of the registry, with parameter sets that reach each of its options.

A new filter gets a row here and an oracle; every test of the filters' laws runs over this list.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from signals import RATE, Signals

#: From a start at most this far from the truth every filter with feedback must get there, rad.
START = 0.5 * math.pi
#: What counts as arrived for errors that decay exponentially, rad.
ARRIVED = 1e-4
#: The largest amplitude (rad) that an exponential decay from `START` can have. Cross products fall as sin θ,
#: so the error is tan(θ/2) = tan(θ0/2) exp(-kt): from 90° it ends as 2 exp(-kt), not as (π/2) exp(-kt); with
#: the overshoot of an underdamped pair, which no attitude error lets grow beyond π, twice π bounds both.
AMPLITUDE = 2.0 * math.pi

#: (dip in rad, or None without a magnetometer; time step in s) -> (time in s, error in rad left after it)
Settling = Callable[[float | None, float], tuple[float, float]]


@dataclass(frozen=True)
class Case:
    """A filter with a parameter set, and what is expected of it."""

    label: str
    name: str
    params: Mapping[str, Any]
    #: Largest angle (rad) between the float32 and the float64 run over 10,000 noisy samples at 100 Hz.
    float32: float
    #: Time in which an error of at most 90° has decayed; None where the parameters leave no feedback.
    settling: Settling | None = None
    #: Steps of Euler rates: near pitch ±90° they amplify rounding without bound, so that data must stay clear
    #: of it.
    euler_rates: bool = False
    #: What is left (rad/s) of a gyroscope's bias of 0.03 rad/s at rest, after twice the settling time; None where the
    #: parameters estimate none. Linear feedback leaves `ARRIVED` rad / 1 s. Madgwick's ζ integrates a direction of
    #: unit length and drives the bias to and fro about its value: a thirtieth of it is far from its start at zero.
    bias_left: float | None = None
    #: Why a row does not keep the sensor-rotation law that its class claims for the defaults.
    law_broken: str = ""

    @property
    def cls(self) -> type[ar.Filter]:
        return ar.FILTERS[self.name]

    def make(self, **keywords: Any) -> ar.Filter:
        """The filter with further keywords of its constructor."""
        return self.cls(**self.params, **keywords)

    def run(self, signals: Signals, *, nine: bool = True, **keywords: Any) -> ar.Estimate:
        """The estimate of one recording at its nominal rate."""
        return self.make(rate=RATE).run(*signals.sensors(nine=nine), **keywords)

    @property
    def first_order(self) -> bool:
        """Whether a step of ω dt is wrong by its powers: the first-order step, and that of Euler rates."""
        return self.name == "Trigonometric" or self.params.get("integration") == "first-order"

    @property
    def law(self) -> str:
        """What a rotation of the sensor frame does: "exact", "heading" or "no"."""
        return "no" if self.law_broken else self.cls.EQUIVARIANCE.partition(":")[0]


def at_once(_dip: float | None, _dt: float) -> tuple[float, float]:
    """The first sample sets the attitude; 1e-12 rad is rounding."""
    return 0.0, 1e-12


def exponential(pole: float) -> tuple[float, float]:
    """A decay at a rate of `pole` (1/s)."""
    return math.log(AMPLITUDE / ARRIVED) / pole, ARRIVED


def complementary(tau: float) -> Settling:
    """Differences of roll and pitch shrink by α = τ/(τ + dt) a step."""

    def settling(_dip: float | None, dt: float) -> tuple[float, float]:
        return exponential(math.log1p(dt / tau) / dt)

    return settling


def mahony(kp: float, ki: float) -> Settling:
    """The slowest pole of the linearised filter.

    For small errors the direction error is -Λε with the eigenvalues λ = 1 (6D), or λ = 1 - sin dip, 1, 1 +
    sin dip (9D): the magnetometer's term m × m̂ is horizontal as well as vertical, so the heading does not
    decay at kp cos² dip on its own. Each direction has p² + kp λ p + ki λ = 0; underdamped, its real part is
    kp λ/2.
    """

    def settling(dip: float | None, _dt: float) -> tuple[float, float]:
        slowest = math.inf
        for eigenvalue in (1.0,) if dip is None else (1.0 - math.sin(dip), 1.0, 1.0 + math.sin(dip)):
            roots = np.roots([1.0, kp * eigenvalue, ki * eigenvalue]) if ki else [-kp * eigenvalue]
            slowest = min(slowest, *(-np.real(root) for root in roots))
        return exponential(slowest)

    return settling


def madgwick(beta: float, zeta: float = 0.0, paper: bool = False) -> Settling:
    """The descent turns at the constant rate 2β and ends in steps to and fro of 2β dt.

    6D: straight, in the time angle/(2β). 9D: each of three eigendirections of the error shrinks
    monotonically, so the path is at most √3 times as long. The published gradient wastes the part along q: of
    |∇f| the part that turns is 1/√(1 + (|Jq| |f| / 2|e|)²), with |Jq| ≤ 4 and |f|/|e| = 1/cos(θ/2) for the
    accelerometer alone (1/3 at 90°), and |Jq| ≤ √32 and |f|/|e| ≤ 1/√(1 - sin dip) with the field (1/8 at a
    dip of 60°). The bias that ζ builds up on the way helps, then decays with the time constant β/ζ while the
    steps are at most twice as long.
    """

    def settling(dip: float | None, dt: float) -> tuple[float, float]:
        wasted = 1.0
        if paper:
            ratio = 4.0 * math.sqrt(2.0) if dip is None else math.sqrt(32.0 / (1.0 - math.sin(dip)))
            wasted = math.hypot(1.0, 0.5 * ratio)
        path = START * (1.0 if dip is None else math.sqrt(3.0))
        step = 2.0 * beta * dt
        # Ten steps more for the end, where what is left is no longer large against a step.
        time = path * wasted / (2.0 * beta) + 10.0 * dt
        return (time, step) if zeta == 0.0 else (time + beta / zeta, 2.0 * step)

    return settling


# Largest angles between float32 and float64, measured over 8 recordings (9D and 6D, constant and jittered
# steps, gaps) and multiplied by four.
#: Rounding of 6e-8 in each of 10,000 steps adds up as a random walk, to 1.3e-5 where nothing feeds it back.
WALK = 5e-5
#: The feedback forgets rounding within its time constant; what is left is the walk of the heading in 6D.
FEEDBACK = 4e-5
#: Each step goes to Euler angles and back: near pitch ±90° the rounding of roll and yaw is 1/cos(pitch) larger, and
#: that of the yaw of 6D adds up in one direction, to 9e-5.
EULER = 2e-3

PAPER = "the part of the published gradient along q depends on the axes"

CASES: list[Case] = [
    Case("gyro", "GyroIntegration", {}, WALK),
    Case("gyro-first-order", "GyroIntegration", {"integration": "first-order"}, WALK),
    Case("tilt", "Tilt", {}, WALK, at_once),
    Case("ecompass", "Ecompass", {}, WALK, at_once),
    Case("trigonometric", "Trigonometric", {}, WALK, at_once),
    Case("trigonometric-gyr", "Trigonometric", {"source": "gyr"}, WALK, euler_rates=True),
    Case("complementary", "Complementary", {}, EULER, complementary(0.997 / 0.003 / 200.0)),
    Case("complementary-fast", "Complementary", {"tau": 0.1}, EULER, complementary(0.1)),
    Case(
        "complementary-first-order",
        "Complementary",
        {"integration": "first-order", "tau": 0.5},
        EULER,
        complementary(0.5),
        euler_rates=True,
    ),
    Case("mahony", "Mahony", {}, FEEDBACK, mahony(1.0, 0.3), bias_left=ARRIVED),
    Case("mahony-proportional", "Mahony", {"kp": 0.5, "ki": 0.0}, FEEDBACK, mahony(0.5, 0.0)),
    Case("mahony-overdamped", "Mahony", {"kp": 2.0, "ki": 0.1}, FEEDBACK, mahony(2.0, 0.1), bias_left=ARRIVED),
    Case(
        "mahony-first-order",
        "Mahony",
        {"kp": 2.0, "integration": "first-order"},
        FEEDBACK,
        mahony(2.0, 0.3),
    ),
    Case("madgwick", "Madgwick", {}, FEEDBACK, madgwick(0.041)),
    Case("madgwick-bias", "Madgwick", {"beta": 0.1, "zeta": 0.01}, FEEDBACK, madgwick(0.1, 0.01), bias_left=1e-3),
    Case(
        "madgwick-first-order",
        "Madgwick",
        {"beta": 0.1, "zeta": 0.01, "integration": "first-order"},
        FEEDBACK,
        madgwick(0.1, 0.01),
        bias_left=1e-3,
    ),
    Case(
        "madgwick-paper",
        "Madgwick",
        {"gradient": "paper", "beta": 0.08},
        FEEDBACK,
        madgwick(0.08, paper=True),
        law_broken=PAPER,
    ),
    Case(
        "madgwick-paper-first-order",
        "Madgwick",
        {"gradient": "paper", "beta": 0.1, "integration": "first-order"},
        FEEDBACK,
        madgwick(0.1, paper=True),
        law_broken=PAPER,
    ),
]


def assert_same_attitudes(a: ar.Estimate, b: ar.Estimate) -> None:
    """Attitudes and biases are the same bits; status may differ."""
    assert np.array_equal(a.quat, b.quat)
    assert (a.gyr_bias is None) == (b.gyr_bias is None)
    if a.gyr_bias is not None:
        assert np.array_equal(a.gyr_bias, b.gyr_bias)


def each_case_with(condition: Callable[[Case], bool]) -> pytest.MarkDecorator:
    """Marks a test to run over the rows for which a condition holds."""
    return pytest.mark.parametrize("case", list(filter(condition, CASES)), ids=lambda case: case.label)


#: Marks a test to run over every row.
each_case = each_case_with(lambda case: True)
#: Marks a test to run over every filter of the registry at its defaults.
each_filter = pytest.mark.parametrize("name", list(ar.FILTERS))
