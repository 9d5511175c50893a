"""The demonstration: a hand-held sensor, moved at random."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from ahrs_rs._constants import GRAVITY
from ahrs_rs._recording import Recording
from ahrs_rs._typing import FloatArray
from ahrs_rs.simulate._functions import Waves
from ahrs_rs.simulate._magnetic import DEGREE
from ahrs_rs.simulate._motion import EulerMotion, PacedMotion
from ahrs_rs.simulate._record import Setup, check_positive, check_seed


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """White noise and constant bias of a 9-axis sensor: all that `demo` knows; see `Sensor` for more.

    Parameters
    ----------
    gyr_density : float
        One-sided noise density of the gyroscope, rad/s/√Hz; a sample at f Hz has density · √(f/2).
    acc_density : float
        Of the accelerometer, m/s²/√Hz.
    mag_noise : float
        Standard deviation of a magnetometer sample, µT.
    gyr_bias : float
        Standard deviation of the constant bias of each axis, rad/s.
    acc_bias : float
        The same of the accelerometer, m/s².

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.simulate.CONSUMER_MEMS.gyr_bias > 0.0
    True
    """

    gyr_density: float
    acc_density: float
    mag_noise: float
    gyr_bias: float
    acc_bias: float


#: A consumer MEMS sensor after a simple calibration. Noise densities: InvenSense MPU-9250 (PS-MPU-9250A-01,
#: tables 1 and 2), 0.01 °/s/√Hz and 300 µg/√Hz; magnetometer: ST LIS2MDL, 3 mG rms. Uncalibrated biases of
#: the MPU-9250 are up to 5 °/s and 60 mg; 0.3 °/s and 3 mg are what subtracting a mean at rest and a
#: six-position calibration leave.
CONSUMER_MEMS = SensorErrors(
    gyr_density=0.01 * DEGREE,
    acc_density=300e-6 * GRAVITY,
    mag_noise=0.3,
    gyr_bias=0.3 * DEGREE,
    acc_bias=3e-3 * GRAVITY,
)


@dataclass(frozen=True, slots=True)
class Pace:
    """How far a motion has run, s(t): it rests at the start of every period, and at all times before zero.

    The speed ds/dt rises from 0 to 1 and falls again as 3u² - 2u³, so position has a continuous second
    derivative.
    """

    period: float
    rest: float
    ramp: float

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """(T, 1): s, ds/dt or d²s/dt² at the times t (T,)."""
        cycle = np.maximum(np.floor(t / self.period), 0.0)
        local = t - cycle * self.period
        rise = np.clip((local - self.rest) / self.ramp, 0.0, 1.0)
        fall = np.clip((local - (self.period - self.ramp)) / self.ramp, 0.0, 1.0)
        if order == 0:
            steady = np.clip(local - self.rest - self.ramp, 0.0, self.period - self.rest - 2.0 * self.ramp)
            per_cycle = self.period - self.rest - self.ramp
            run = self.ramp * (_rise_integral(rise) + fall - _rise_integral(fall)) + steady
            value = cycle * per_cycle + run
        elif order == 1:
            value = _rise(rise) - _rise(fall)
        elif order == 2:
            value = (_rise_slope(rise) - _rise_slope(fall)) / self.ramp
        else:
            raise ValueError(f"order: a pace has derivatives up to the second, got {order}")
        return value[:, np.newaxis]


def _rise(u: FloatArray) -> FloatArray:
    return u * u * (3.0 - 2.0 * u)


def _rise_slope(u: FloatArray) -> FloatArray:
    return 6.0 * u * (1.0 - u)


def _rise_integral(u: FloatArray) -> FloatArray:
    return u * u * u * (1.0 - 0.5 * u)


def hand_held(stream: np.random.Generator, pace: Pace) -> PacedMotion:
    """Four sines per angle (peaks of 150 to 300 °/s), three per axis of position (peaks of 3 to 5 m/s²)."""
    angles = Waves(
        amplitude=np.array([60.0, 35.0, 90.0]) * DEGREE * stream.uniform(0.3, 0.7, (4, 3)),
        frequency=2.0 * math.pi * stream.uniform(0.05, 0.5, (4, 3)),
        phase=stream.uniform(0.0, 2.0 * math.pi, (4, 3)),
    )
    position = Waves(
        amplitude=stream.uniform(0.02, 0.08, (3, 3)),
        frequency=2.0 * math.pi * stream.uniform(0.3, 1.0, (3, 3)),
        phase=stream.uniform(0.0, 2.0 * math.pi, (3, 3)),
    )
    return PacedMotion(EulerMotion(angles, position), pace)


def resting(duration: float) -> Pace:
    """Rests of 4 s in every 20 s; a duration below 20 s begins with its one rest, a fifth of it."""
    rest = min(4.0, 0.2 * duration)
    return Pace(period=5.0 * rest, rest=rest, ramp=0.25 * rest)


def demo(duration: float = 60.0, rate: float = 100.0, seed: int = 0, *, noise: bool = True) -> Recording:
    """A hand-held 9D sensor that turns and moves in all directions and rests a fifth of the time.

    The rests are 4 s in every 20 s; a recording shorter than 20 s begins with its one rest.

    Parameters
    ----------
    duration : float, optional
        S; the recording has round(duration · rate) samples.
    rate : float, optional
        Hz.
    seed : int, optional
        Of the random motion and of the sensor errors.
    noise : bool, optional
        False leaves the sensor errors out; the motion stays the same.

    Returns
    -------
    Recording
        `ref` is the exact orientation (sensor to ENU) at `t`. `gyr[k]` is the mean angular rate over
        (t[k-1], t[k]] (a rotation by gyr[k] · dt takes ref[k-1] to ref[k]), plus errors; the sensor rests
        before t[0]. `acc` and `mag` are the specific force and the field (50 µT, dip 60°) at `t`. `mask`
        leaves the first rest out. meta holds the biases: "gyr_bias" (rad/s) and "acc_bias" (m/s²).

    Raises
    ------
    ValueError
        A duration or rate that is not positive, fewer than two samples, a negative seed.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=10.0, seed=1)
    >>> rec.gyr.shape
    (1000, 3)
    """
    check_positive("duration", duration)
    check_positive("rate", rate)
    check_seed(seed)
    motion_stream, error_stream = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
    pace = resting(duration)
    exact = Setup(motion=hand_held(motion_stream, pace), rate=rate, duration=duration).record()
    gyr, acc, mag = (exact.require(name) for name in ("gyr", "acc", "mag"))
    meta: dict[str, object] = {"simulation": "demo", "seed": seed, "noise": noise, "ref_frame": "ENU"}
    if noise:
        errors = CONSUMER_MEMS
        gyr_bias, acc_bias = (
            deviation * error_stream.standard_normal(3) for deviation in (errors.gyr_bias, errors.acc_bias)
        )
        bandwidth = math.sqrt(0.5 * rate)
        gyr += gyr_bias + errors.gyr_density * bandwidth * error_stream.standard_normal(gyr.shape)
        acc += acc_bias + errors.acc_density * bandwidth * error_stream.standard_normal(acc.shape)
        mag += errors.mag_noise * error_stream.standard_normal(mag.shape)
        meta |= {"errors": asdict(errors), "gyr_bias": gyr_bias.tolist(), "acc_bias": acc_bias.tolist()}
    return Recording(
        t=exact.t, rate=rate, gyr=gyr, acc=acc, mag=mag, ref=exact.ref, mask=exact.t >= pace.rest, meta=meta
    )
