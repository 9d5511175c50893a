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
from ahrs_rs import Status
from settling import (
    ARRIVED,
    Settling,
    at_once,
    complementary,
    dcm_imu,
    ekf,
    fusion,
    linear_kalman,
    madgwick,
    mahony,
    mekf,
    selfcal,
    vqf,
)
from signals import RATE, Signals

#: The status bits of the rules that all filters share; the others are a filter's own judgement of its measurements.
COMMON = int(
    Status.ACC_MISSING | Status.MAG_MISSING | Status.GYR_HELD | Status.NOT_ALIGNED | Status.GAP | Status.REPEATED
)
#: Rounding of 1e-16 in each of 10,000 steps, amplified at most by feedback that forgets it and by passes near
#: pitch 90°: measured at most 4e-13 rad.
ROUNDING = 1e-12
#: A Kalman filter's gain is the small difference of large terms, and the library takes one scalar measurement after
#: the other where the oracles solve for whole vectors: measured at most 3e-12 rad, and 3e-11 of an innovation squared.
KALMAN = 1e-10


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
    #: Steps of Euler rates or of a yaw of their own: near pitch ±90° they amplify rounding without bound, so that data
    #: must stay clear of it.
    euler_rates: bool = False
    #: What is left (rad/s) of a gyroscope's bias of 0.03 rad/s at rest, after twice the settling time; None where the
    #: parameters estimate none. Linear feedback leaves `ARRIVED` rad / 1 s. Madgwick's ζ integrates a direction of
    #: unit length and drives the bias to and fro about its value: a thirtieth of it is far from its start at zero.
    bias_left: float | None = None
    #: Why a row does not keep the sensor-rotation law that its class claims for the defaults.
    law_broken: str = ""
    #: Largest angle (rad) between runs that differ in nothing but rounding, over 10,000 samples; as well the largest
    #: difference of quaternions, and of biases in rad/s.
    agreement: float = ROUNDING
    #: Whether the length of the specific force, not only its direction, says something.
    acc_length: bool = False
    #: Whether the attitude is turned by a rate of the filter's own, which follows the gyroscope's.
    own_rate: bool = False
    #: Whether the filter takes its start from the first measurements by itself: the first sample is a step like others.
    starts_itself: bool = False
    #: Bias (rad/s) that a filter which starts by itself learns from the turn that aligns it.
    start_bias: float = 0.0
    #: Why a row keeps the sensor-rotation law "exact" although its class claims none.
    law_kept: str = ""
    #: Why in nine axes only a start that is turned about the vertical alone gets to the truth.
    level_start: str = ""

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
        params = self.make().params
        options = (params.get("integration"), params.get("prediction"))
        return self.name == "Trigonometric" or "first-order" in options or "euler" in options

    @property
    def kalman(self) -> bool:
        """Whether the filter keeps a covariance, which remembers the time before the alignment."""
        return "covariance" in self.cls.OUTPUTS

    @property
    def knows_its_age(self) -> bool:
        """Whether it does other things a while after the start: by its covariance, or by a gain that falls."""
        return self.kalman or "startup" in self.cls.OUTPUTS

    @property
    def law(self) -> str:
        """What a rotation of the sensor frame does: "exact", "heading" or "no"."""
        if self.law_kept:
            return "exact"
        return "no" if self.law_broken else self.cls.EQUIVARIANCE.partition(":")[0]


# Largest angles between float32 and float64, measured over 8 recordings (9D and 6D, constant and jittered
# steps, gaps) and multiplied by four.
#: Rounding of 6e-8 in each of 10,000 steps adds up as a random walk, to 1.3e-5 where nothing feeds it back.
WALK = 5e-5
#: The feedback forgets rounding within its time constant; what is left is the walk of the heading in 6D.
FEEDBACK = 4e-5
#: Each step goes to Euler angles and back: near pitch ±90° the rounding of roll and yaw is 1/cos(pitch) larger, and
#: that of the yaw of 6D adds up in one direction, to 9e-5.
EULER = 2e-3

# Those of the Kalman filters are largest in six axes, where the heading keeps what it gets.
#: Each axis by itself, from Euler angles and back.
LINEAR_KALMAN_FLOAT32 = 1.2e-3
#: A bias learnt in steps of 1e-8 rad/s is off by 5e-5 rad/s in float32, which the heading integrates over 100 s: 5e-3.
BIAS_FLOAT32 = 2e-2
#: The same where its gain is larger: 1.1e-3.
MEKF_FLOAT32 = 5e-3
#: Of the inclination 7e-4. The accelerometer is believed to a hundredth of its noise, so that the heading, which it
#: seems to show while the sensor turns, is thrown about by 50° at the start and rounding with it: 0.08.
EKF_FLOAT32 = 0.34

#: A bias that is learnt, as MEKF's.
VQF_FLOAT32 = 5e-3
#: Where the rounding of uneven steps ends a block of 0.1 s one sample later, the start is another one: measured
#: 0.037 rad for a while, and 1e-4 where the blocks are the same.
SELFCAL_FLOAT32 = 0.15
#: The walk of two quaternions, and an inclination that forgets rounding within 3 s.
ORIENTATION_FLOAT32 = 2e-4

PAPER = "the part of the published gradient along q depends on the axes"

#: A measurement close to the limit of rejection is used by one and not by the other: a step of half the gain.
DECISIONS = 1e-2

DIP_OF_START = "the reference field has the inclination that the start gives it, for good"

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
    Case(
        "complementary-adaptive",
        "Complementary",
        {"tau": 0.5, "acc_threshold": 0.5},
        EULER,
        complementary(0.5),
        acc_length=True,
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
    Case(
        "mahony-adaptive",
        "Mahony",
        {"kp": 2.0, "acc_threshold": 0.5},
        FEEDBACK,
        mahony(2.0, 0.3),
        bias_left=ARRIVED,
        acc_length=True,
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
        "madgwick-adaptive",
        "Madgwick",
        {"beta": 0.1, "acc_threshold": 0.5},
        FEEDBACK,
        madgwick(0.1),
        acc_length=True,
    ),
    Case(
        "madgwick-paper-adaptive",
        "Madgwick",
        {"gradient": "paper", "beta": 0.1, "acc_threshold": 0.5},
        FEEDBACK,
        madgwick(0.1, paper=True),
        law_broken=PAPER,
        acc_length=True,
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
    # Roll and pitch alone have biases, of rates that are not the sensor's: none is the gyroscope's at rest in any pose.
    Case("linear-kalman", "LinearKalman", {}, LINEAR_KALMAN_FLOAT32, linear_kalman, agreement=KALMAN),
    Case(
        "linear-kalman-first-order",
        "LinearKalman",
        {"integration": "first-order"},
        LINEAR_KALMAN_FLOAT32,
        linear_kalman,
        euler_rates=True,
        agreement=KALMAN,
    ),
    Case(
        "ekf",
        "EKF",
        {},
        EKF_FLOAT32,
        ekf,
        # A start that is found wrong is begun anew, and the normalised innovation is a quotient of a few measurements'
        # variances then: 1.7e-10 of itself. The attitudes agree to 2e-11.
        agreement=5.0 * KALMAN,
        acc_length=True,
        own_rate=True,
    ),
    Case(
        "ekf-input",
        "EKF",
        {"gyroscope": "input"},
        EKF_FLOAT32,
        ekf,
        agreement=KALMAN,
        acc_length=True,
    ),
    Case(
        "ekf-first-order",
        "EKF",
        {"integration": "first-order"},
        EKF_FLOAT32,
        ekf,
        # Without a magnetometer the variance of its heading grows to 1e4 times that of a measurement, by which rounding
        # comes back: measured 1.8e-10 rad.
        agreement=5.0 * KALMAN,
        acc_length=True,
        own_rate=True,
    ),
    # Of a sensor at rest an accelerometer does not show the bias about the vertical: see `test_kalman_bias`.
    # The yaw is outside of the filter: what passing pitch 90° adds to its rounding stays.
    Case("dcm-imu", "DcmImu", {}, BIAS_FLOAT32, dcm_imu, euler_rates=True, agreement=KALMAN, acc_length=True),
    Case(
        "dcm-imu-euler",
        "DcmImu",
        {"prediction": "euler"},
        BIAS_FLOAT32,
        dcm_imu,
        euler_rates=True,
        agreement=KALMAN,
        acc_length=True,
    ),
    Case("mekf", "MEKF", {}, MEKF_FLOAT32, mekf, bias_left=ARRIVED, agreement=KALMAN, acc_length=True),
    Case(
        "mekf-vector",
        "MEKF",
        {"magnetometer": "vector"},
        MEKF_FLOAT32,
        mekf,
        bias_left=ARRIVED,
        agreement=KALMAN,
        acc_length=True,
        level_start=DIP_OF_START,
    ),
    Case(
        "vqf",
        "VQF",
        {},
        VQF_FLOAT32,
        vqf(),
        bias_left=ARRIVED,
        agreement=KALMAN,
        acc_length=True,
        starts_itself=True,
        # The first gain of the Kalman filter, p/(p + w) at 100 Hz, times an error of 2 °/s in two axes.
        start_bias=0.5**2 / (0.5**2 + 0.1**4 / 1e-6) * math.radians(2.0) * math.sqrt(2.0),
    ),
    Case(
        "vqf-orientation",
        "VQF",
        {"motion_bias_est_enabled": False, "rest_bias_est_enabled": False, "mag_dist_rejection_enabled": False},
        ORIENTATION_FLOAT32,
        vqf(lessened=1.0, bias=False),
        agreement=KALMAN,
        acc_length=True,
        starts_itself=True,
        law_kept="nothing is clipped where no bias is estimated",
    ),
    Case("selfcal", "SelfCalKF", {}, SELFCAL_FLOAT32, selfcal, bias_left=ARRIVED, agreement=KALMAN, acc_length=True),
    Case(
        "basic-vqf",
        "BasicVQF",
        {},
        ORIENTATION_FLOAT32,
        vqf(lessened=1.0, bias=False),
        agreement=KALMAN,
        acc_length=True,
        starts_itself=True,
    ),
    Case("fusion", "Fusion", {}, FEEDBACK, fusion(0.5)),
    Case("fusion-exponential", "Fusion", {"gain": 1.0, "integration": "exponential"}, FEEDBACK, fusion(1.0)),
    Case(
        "fusion-rejection",
        "Fusion",
        {
            "gyroscope_range": 250.0,
            "acceleration_rejection": 10.0,
            "magnetic_rejection": 15.0,
            "rejection_timeout": 0.5,
        },
        DECISIONS,
        fusion(0.5),
        law_broken="the gyroscope's range is that of each axis",
    ),
    # The bias takes far longer than the attitude: see `test_fusion`.
    Case(
        "fusion-bias",
        "Fusion",
        {"bias": True, "stationary_threshold": 5.0, "stationary_period": 1.0},
        FEEDBACK,
        fusion(0.5),
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
#: The filters that go on from sample to sample: those of which `CASES` has rows. What offline filters do is tested by
#: `test_offline` for all of them, and beside their originals in files of their own.
STREAMING = [name for name, cls in ar.FILTERS.items() if cls.STREAMING]
OFFLINE = [name for name, cls in ar.FILTERS.items() if not cls.STREAMING]
#: Marks a test to run over every streaming filter at its defaults.
each_streaming_filter = pytest.mark.parametrize("name", STREAMING)
