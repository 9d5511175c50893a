"""x-io's revision of Madgwick's filter (thesis, chapter 7; Fusion 1.3), with times for its counts of samples.

In quaternions and vectors of the sensor frame, as its authors describe it: half of the predicted directions, feedback
by their cross products with the measured ones, added to half of the angular rate.
"""

import math

from .base import Filter, Told
from .gyro_integration import gyro_step
from .so3 import IDENTITY, Quat, Vec3, cross, normalize, rotate_inverse, unit

ACC_REJECTED = 8
MAG_REJECTED = 16
REST = 32
RECOVERING = 128

STARTUP_GAIN = 10.0
STARTUP_PERIOD = 3.0
#: What is left of the start's gain where it counts as over.
STARTUP_REST = 1e-9
#: Cut-off of the bias' low-pass filter in Hz.
CUTOFF = 0.02
#: Times are compared to a sixteenth of a step, so that rounding does not decide about sums of equal ones.
TOLERANCE = 1.0 / 16.0
#: A field closer to the vertical than this (rad) has no heading.
VERTICAL_FIELD = 1e-6

HALF_UP: Vec3 = (0.0, 0.0, 0.5)
HALF_WEST: Vec3 = (-0.5, 0.0, 0.0)
ZERO: Vec3 = (0.0, 0.0, 0.0)


class Sensor:
    """What rejects the measurements of one sensor."""

    def __init__(self, rejection: float, timeout: float) -> None:
        """Half the sine of the angle in degrees is the largest half of a residual; none where the angle is 0."""
        self.largest = 0.5 * math.sin(math.radians(rejection)) if rejection > 0.0 else math.inf
        self.timeout = timeout
        self.restart()

    def restart(self) -> None:
        """As before the first sample."""
        self.time = 0.0
        self.recovery = False

    def feedback(self, residual: Vec3 | None, startup: bool, dt: float) -> Vec3:
        """Half of the feedback: the residual, unless it is rejected."""
        self.measured = residual is not None
        self.ignored = True
        if residual is None:
            return ZERO
        self.error = math.degrees(math.asin(min(1.0, 2.0 * math.hypot(*residual))))
        if startup or math.hypot(*residual) <= self.largest:
            self.ignored = False
            self.time -= 9.0 * dt
        else:
            self.time += dt
        threshold = 0.0 if self.recovery else self.timeout
        self.recovery = self.time > threshold + TOLERANCE * dt
        self.ignored = self.ignored and not self.recovery
        self.time = min(max(self.time, 0.0), self.timeout)
        return ZERO if self.ignored else residual


def residual(measured: Vec3, half_predicted: Vec3) -> Vec3:
    """Cross product of a direction and half of its prediction; from 90° on its direction."""
    product = cross(measured, half_predicted)
    if sum(a * b for a, b in zip(measured, half_predicted, strict=True)) > 0.0:
        return product
    return unit(product) if any(abs(c) > 1e-154 for c in product) else ZERO


class Fusion(Filter):
    """Startup with a falling gain, then proportional feedback of what is not rejected."""

    follows_field = True

    def __init__(
        self,
        *,
        gain: float = 0.5,
        gyroscope_range: float = 0.0,
        acceleration_rejection: float = 0.0,
        magnetic_rejection: float = 0.0,
        rejection_timeout: float = 0.0,
        bias: bool = False,
        stationary_threshold: float = 3.0,
        stationary_period: float = 3.0,
        integration: str = "first-order",
    ) -> None:
        self.gain = gain
        self.range = math.radians(0.98 * gyroscope_range) if gyroscope_range > 0.0 else math.inf
        rejects = gain > 0.0 and rejection_timeout > 0.0
        self.acc = Sensor(acceleration_rejection if rejects else 0.0, rejection_timeout)
        self.mag = Sensor(magnetic_rejection if rejects else 0.0, rejection_timeout)
        self.estimates_bias = bias
        self.threshold = math.radians(stationary_threshold)
        self.period = stationary_period
        self.integration = integration
        self.q: Quat = IDENTITY
        self.ramped_gain = max(STARTUP_GAIN, gain)
        self.overrange = False
        self.bias: Vec3 = ZERO
        self.still_for = 0.0
        self.flags = 0

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; everything else stays."""
        self.q = normalize(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample."""
        self.flags = 0
        if self.estimates_bias:
            gyr = self.without_bias(gyr, dt)
        if any(abs(rate) > self.range for rate in gyr):
            self.ramped_gain = max(STARTUP_GAIN, self.gain)
            self.acc.restart()
            self.mag.restart()
            self.overrange = True
        fall = max(0.0, (STARTUP_GAIN - self.gain) / STARTUP_PERIOD)
        self.ramped_gain -= fall * dt
        self.startup = self.ramped_gain > self.gain + STARTUP_REST
        self.ramped_gain = self.ramped_gain if self.startup else self.gain
        self.overrange = self.overrange and self.startup

        half_up = rotate_inverse(self.q, HALF_UP)
        half_west = rotate_inverse(self.q, HALF_WEST)
        inclination = heading = None
        if acc is not None:
            inclination = residual(unit(acc), half_up)
        if mag is not None:
            west = cross(half_up, unit(mag))  # of length ½ sin of the angle between field and vertical
            if 2.0 * math.hypot(*west) >= VERTICAL_FIELD:
                heading = residual(unit(west), half_west)
        turn = [0.5 * rate * dt for rate in gyr]
        for sensor, seen, time in (
            (self.acc, inclination, told.acc_interval),
            (self.mag, heading, told.mag_interval),
        ):
            # In a gap the feedback counts for at most 1/gain, so that it does not overshoot.
            share = min(self.ramped_gain * time, 1.0)
            feedback = sensor.feedback(seen, self.startup, time)
            turn = [half + share * e for half, e in zip(turn, feedback, strict=True)]
        self.q = gyro_step(self.q, (2.0 * turn[0], 2.0 * turn[1], 2.0 * turn[2]), 1.0, self.integration)

        self.flags |= ACC_REJECTED if self.acc.measured and self.acc.ignored else 0
        self.flags |= MAG_REJECTED if self.mag.measured and self.mag.ignored else 0
        self.flags |= RECOVERING if self.acc.recovery or self.mag.recovery or self.overrange else 0

    def without_bias(self, gyr: Vec3, dt: float) -> Vec3:
        """The angular rate less the bias so far, which follows it at rest."""
        rate = (gyr[0] - self.bias[0], gyr[1] - self.bias[1], gyr[2] - self.bias[2])
        if any(abs(c) > self.threshold for c in rate):
            self.still_for = 0.0
        elif self.still_for + TOLERANCE * dt < self.period:
            self.still_for += dt
        else:
            weight = min(1.0, 2.0 * math.pi * CUTOFF * dt)
            bx, by, bz = (b + weight * c for b, c in zip(self.bias, rate, strict=True))
            self.bias = (bx, by, bz)
            self.flags |= REST
        return rate

    def outputs(self) -> dict[str, float]:
        """What the last step says beside attitude and bias."""
        values = {"startup": float(self.startup), "overrange_recovery": float(self.overrange)}
        for name, sensor in (("accelerometer", self.acc), ("magnetometer", self.mag)):
            quantity = {"accelerometer": "acceleration", "magnetometer": "magnetic"}[name]
            values[f"{name}_ignored"] = float(sensor.ignored)
            values[f"{quantity}_error"] = sensor.error if sensor.measured else math.nan
            values[f"{quantity}_recovery"] = float(sensor.recovery)
            values[f"{quantity}_recovery_trigger"] = sensor.time / sensor.timeout if sensor.timeout else 0.0
        return values
