"""Simulated recordings with exactly known truth.

A simulation has three parts, each drawn from its own stream of one seed, so that changing one leaves the
others as they are: a motion (smooth functions of time, exactly differentiated), the readings of an ideal
sensor that follows it, and the errors of a real sensor.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import _quat
from .recording import Recording

__all__ = ["CONSUMER_MEMS", "SensorErrors", "demo"]

FloatArray: TypeAlias = NDArray[np.float64]

#: Standard gravity, m/s².
GRAVITY = 9.80665
DEGREE = math.pi / 180.0

#: Earth's field in ENU, µT: 50 µT, 60° below the horizontal, north on y.
FIELD = 50.0 * np.array([0.0, math.cos(60.0 * DEGREE), -math.sin(60.0 * DEGREE)])


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """White noise and constant bias of a 9-axis sensor.

    Parameters
    ----------
    gyr_density : one-sided noise density of the gyroscope, rad/s/√Hz; a sample at f Hz has density · √(f/2).
    acc_density : of the accelerometer, m/s²/√Hz.
    mag_noise : standard deviation of a magnetometer sample, µT.
    gyr_bias : standard deviation of the constant bias of each axis, rad/s.
    acc_bias : the same of the accelerometer, m/s².
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
class _Waves:
    """Sums of sines Σ amplitude · sin(frequency · s + phase), one per column: three arrays (terms, 3)."""

    amplitude: FloatArray
    frequency: FloatArray
    phase: FloatArray

    def derivative(self, s: FloatArray, order: int) -> FloatArray:
        """(T, 3): the derivative of the given order (0: the value) at s (T,)."""
        angle = self.frequency * s[:, None, None] + self.phase + 0.5 * math.pi * order
        total: FloatArray = (self.amplitude * self.frequency**order * np.sin(angle)).sum(axis=1)
        return total


@dataclass(frozen=True, slots=True)
class _Pace:
    """How far the motion has run, s(t): it rests at the start of every period, and at all times before zero.

    The speed ds/dt rises from 0 to 1 and falls again as 3u² - 2u³, so position has a continuous second
    derivative.
    """

    period: float
    rest: float
    ramp: float

    def derivatives(self, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """s, ds/dt and d²s/dt² at the times t (T,)."""
        cycle = np.maximum(np.floor(t / self.period), 0.0)
        local = t - cycle * self.period
        rise = np.clip((local - self.rest) / self.ramp, 0.0, 1.0)
        fall = np.clip((local - (self.period - self.ramp)) / self.ramp, 0.0, 1.0)
        steady = np.clip(local - self.rest - self.ramp, 0.0, self.period - self.rest - 2.0 * self.ramp)
        per_cycle = self.period - self.rest - self.ramp
        run = self.ramp * (_rise_integral(rise) + fall - _rise_integral(fall)) + steady
        speed = _rise(rise) - _rise(fall)
        change = (_rise_slope(rise) - _rise_slope(fall)) / self.ramp
        return cycle * per_cycle + run, speed, change


def _rise(u: FloatArray) -> FloatArray:
    return u * u * (3.0 - 2.0 * u)


def _rise_slope(u: FloatArray) -> FloatArray:
    return 6.0 * u * (1.0 - u)


def _rise_integral(u: FloatArray) -> FloatArray:
    return u * u * u * (1.0 - 0.5 * u)


@dataclass(frozen=True, slots=True)
class _Motion:
    """A rotation by Euler angles (roll, pitch, yaw) and a translation in ENU, at a pace with rests."""

    angles: _Waves  # rad
    position: _Waves  # m
    pace: _Pace

    def orientation(self, t: FloatArray) -> FloatArray:
        """(T, 4) sensor to earth, continuous in sign."""
        roll, pitch, yaw = self.angles.derivative(self.pace.derivatives(t)[0], 0).T
        turned = _quat.multiply(_quat.about_axis(2, yaw), _quat.about_axis(1, pitch))
        return _quat.multiply(turned, _quat.about_axis(0, roll))

    def acceleration(self, t: FloatArray) -> FloatArray:
        """(T, 3) in ENU, m/s²: the chain rule for position(s(t))."""
        s, speed, change = self.pace.derivatives(t)
        velocity, curvature = self.position.derivative(s, 1), self.position.derivative(s, 2)
        return curvature * (speed**2)[:, None] + velocity * change[:, None]


def demo(duration: float = 60.0, rate: float = 100.0, seed: int = 0, *, noise: bool = True) -> Recording:
    """A hand-held 9D sensor that turns and moves in all directions and rests a fifth of the time.

    The rests are 4 s in every 20 s; a recording shorter than 20 s begins with its one rest.

    Parameters
    ----------
    duration : s; the recording has round(duration · rate) samples.
    rate : Hz.
    seed : of the random motion and of the sensor errors.
    noise : False leaves the sensor errors out; the motion stays the same.

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
    """
    for name, value in (("duration", duration), ("rate", rate)):
        if not (math.isfinite(value) and value > 0):
            raise ValueError(f"{name}: expected a positive number, got {value}")
    if seed < 0:
        raise ValueError(f"seed: expected an integer that is not negative, got {seed}")
    count = round(duration * rate)
    if count < 2:
        raise ValueError(f"duration: expected at least two samples at {rate} Hz, got {duration} s")
    motion_stream, error_stream = map(np.random.default_rng, np.random.SeedSequence(seed).spawn(2))
    rest = min(4.0, 0.2 * duration)
    motion = _demo_motion(motion_stream, _Pace(period=5.0 * rest, rest=rest, ramp=0.25 * rest))

    t = np.arange(count) / rate
    ref, gyr, acc, mag = _readings(motion, t, 1.0 / rate)
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
    return Recording(t=t, rate=rate, gyr=gyr, acc=acc, mag=mag, ref=ref, mask=t >= rest, meta=meta)


def _demo_motion(stream: np.random.Generator, pace: _Pace) -> _Motion:
    """Four sines per angle (peaks of 150 to 300 °/s), three per axis of position (peaks of 3 to 5 m/s²)."""
    angles = _Waves(
        amplitude=np.array([60.0, 35.0, 90.0]) * DEGREE * stream.uniform(0.3, 0.7, (4, 3)),
        frequency=2.0 * math.pi * stream.uniform(0.05, 0.5, (4, 3)),
        phase=stream.uniform(0.0, 2.0 * math.pi, (4, 3)),
    )
    position = _Waves(
        amplitude=stream.uniform(0.02, 0.08, (3, 3)),
        frequency=2.0 * math.pi * stream.uniform(0.3, 1.0, (3, 3)),
        phase=stream.uniform(0.0, 2.0 * math.pi, (3, 3)),
    )
    return _Motion(angles, position, pace)


def _readings(
    motion: _Motion, t: FloatArray, first_step: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The truth and what an ideal sensor reads: ref, gyr, acc, mag."""
    times = np.concatenate(([t[0] - first_step], t))
    quat = motion.orientation(times)
    if quat[1, 0] < 0:
        quat = -quat
    step = _quat.multiply(_quat.conjugate(quat[:-1]), quat[1:])
    gyr = _quat.log(step) / np.diff(times)[:, None]
    ref = quat[1:]
    to_sensor = _quat.conjugate(ref)
    force = motion.acceleration(t) + np.array([0.0, 0.0, GRAVITY])
    acc = _quat.rotate(to_sensor, force)
    mag = _quat.rotate(to_sensor, np.broadcast_to(FIELD, force.shape))
    return ref, gyr, acc, mag
