"""Error-state (multiplicative) Kalman filter of attitude and gyroscope bias.

The error δ = (δx, δy, δz) stands in the earth frame: R_true = Rz(δz) exp([(δx, δy, 0)×]) R̂, first a tilt, then a turn
about the vertical. To first order δ = R̂ δθ, with δθ the error in the sensor frame (Markley, J. Guidance 26(2), 2003).
A level measurement then knows nothing of δz to every order, so that an unknown heading stays apart.
"""

import math

import numpy as np

from .base import Filter, Told
from .gyro_integration import gyro_step
from .kalman import (
    ACC_REJECTED,
    LARGEST_BIAS,
    MAG_REJECTED,
    RECOVERING,
    REST,
    SAME_VERTICAL,
    SATURATION,
    UNKNOWN_ANGLE,
    Array,
    angle_variance,
    gain,
    inflated,
    joseph,
    normalised_square,
    reported,
    rotation,
    saturated,
    skew,
    triple,
)
from .so3 import IDENTITY, Quat, Vec3, before, exp_half, multiply, normalize, wrap

MAGNETOMETERS = ("heading", "vector")
#: Longest time (s) that one measurement stands for.
LONGEST_INTERVAL = 0.1
#: Time constants (s) of the field's deviation and of the low-pass filters that see rest.
FIELD_TIME = 0.25
REST_TIME = 0.5
#: Largest deviation of the field, in tolerances, that is still used.
FIELD_GATE = 3.0
LARGEST_DEVIATION = 1e3
#: Largest factor by which external acceleration inflates the accelerometer's variance, and the one that sets a bit.
LARGEST_INFLATION = 100.0
REJECTING_INFLATION = 4.0
#: A field closer to the vertical than this (rad) has no heading.
VERTICAL_FIELD = 1e-6


class MEKF(Filter):
    """State: attitude and bias b; error [δ, b - b̂] with covariance P (6, 6)."""

    follows_field = True
    has_covariance = True
    watched = True

    def __init__(
        self,
        *,
        gyr_noise: float = 2e-3,
        bias_noise: float = 1e-4,
        acc_noise: float = 0.3,
        heading_noise: float = 0.1,
        acc_adaptation: float = 0.3,
        acc_window: float = 10.0,
        mag_tolerance: float = 0.12,
        mag_window: float = 3.0,
        mag_gate: float = 3.0,
        mag_recovery: float = 10.0,
        rest_gyr: float = math.radians(2.0),
        rest_acc: float = 0.5,
        rest_time: float = 1.5,
        rest_noise: float = 0.01,
        initial_inclination: float = 0.1,
        initial_heading: float = 0.5,
        initial_bias: float = 0.05,
        gravity: float = 9.80665,
        magnetometer: str = "heading",
        mag_delay: float = 0.0,
    ) -> None:
        if magnetometer not in MAGNETOMETERS:
            raise ValueError(f"magnetometer: expected one of {MAGNETOMETERS}, got {magnetometer!r}")
        self.gyr_noise, self.bias_noise = gyr_noise, bias_noise
        self.acc_noise, self.heading_noise = acc_noise, heading_noise
        self.acc_adaptation, self.acc_window = acc_adaptation, acc_window
        self.mag_tolerance, self.mag_window = mag_tolerance, mag_window
        self.mag_gate, self.mag_recovery = mag_gate, mag_recovery
        self.rest_gyr, self.rest_acc = rest_gyr, rest_acc
        self.rest_time, self.rest_noise = rest_time, rest_noise
        inclination = angle_variance(initial_inclination**2)
        self.initial = (inclination, inclination, angle_variance(initial_heading**2))
        self.initial_bias = initial_bias
        self.g = gravity
        self.mag_delay = mag_delay
        self.vector = magnetometer == "vector"
        self.q = IDENTITY
        self.b = np.zeros(3)
        self.p = np.diag([*self.initial, *[initial_bias**2] * 3])
        self.acc_interval = self.mag_interval = 0.0
        self.mean_acc = np.zeros(2)
        self.field: Array | None = None  # horizontal and vertical part of the reference field
        self.field_age = self.deviation2 = self.rejected_time = 0.0
        self.low_gyr: Array | None = None
        self.low_acc: Array | None = None
        self.still_time = 0.0
        self.headed = False
        self.innovation = np.full(3, np.nan)
        self.nis = np.full(2, np.nan)
        self.flags = 0

    @property
    def bias(self) -> Vec3:
        """Gyroscope bias in rad/s."""
        return triple(self.b)

    @property
    def covariance(self) -> Array:
        """Attitude covariance (3, 3), sensor frame, rad²."""
        r = rotation(self.q)
        return reported(r.T @ self.p[:3, :3] @ r, r[2], self.headed)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude: the heading's variance starts afresh, the inclination's where the vertical is new.

        What starts afresh has no correlations. Bias, its covariance and all low-pass filters stay.
        """
        q = normalize(q)
        before, after = rotation(self.q), rotation(q)
        turn = np.eye(6)
        turn[:3, :3] = after @ before.T
        self.p = turn @ self.p @ turn.T
        new = [2]
        if np.linalg.norm(after[2] - before[2]) > SAME_VERTICAL:
            new = [0, 1, 2]
        for i in new:
            self.p[i, :] = self.p[:, i] = 0.0
            self.p[i, i] = self.initial[i]
        self.q = q

    def lose_rotation(self, variance: float) -> None:
        """The attitude is known less."""
        self.p[:3, :3] += variance * np.eye(3)

    def claimed(self) -> tuple[float, float]:
        """Variances of the error's two tilts, the larger one, and of its turn."""
        return max(float(self.p[0, 0]), float(self.p[1, 1])), float(self.p[2, 2])

    def known_mag_delay(self) -> float:
        """Delay in s of the magnetometer behind the gyroscope: the one that is given."""
        return self.mag_delay

    def reopen(self, bias: Vec3) -> None:
        """Start anew; what is known of field and rest stays."""
        self.p = np.diag([*self.initial, *[self.initial_bias**2] * 3])
        self.b = np.array(bias)
        self.mean_acc = np.zeros(2)
        self.rejected_time = 0.0

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample: prediction, then specific force, field and rest, then injection and reset."""
        self.innovation = np.full(3, np.nan)
        self.nis = np.full(2, np.nan)
        self.flags = 0
        r = self._predict(gyr, dt, told.lost)
        self.acc_interval = min(self.acc_interval + dt, LONGEST_INTERVAL)
        self.mag_interval = min(self.mag_interval + dt, LONGEST_INTERVAL)
        shown = min(dt, LONGEST_INTERVAL) if told.lost else dt  # one reading is no mean over a gap
        resting = self._resting(np.array(gyr), acc, shown)
        x = np.zeros(6)
        if acc is not None:
            x = self._acc_update(x, r @ np.array(acc))
        if mag is not None:
            past = rotation(before(self.q, triple(np.array(gyr) - self.b), self.mag_delay))
            x = self._mag_update(x, past @ np.array(mag))
        if resting:
            x = self._rest_update(x, np.array(gyr), shown)
        self._inject(x)

    def _predict(self, gyr: Vec3, dt: float, lost: bool) -> Array:
        """Attitude and covariance over dt; returns the new rotation matrix."""
        rate = np.array(gyr) - self.b
        before = rotation(self.q)
        self.q = gyro_step(self.q, triple(rate), dt, "exponential")
        after = rotation(self.q)
        f = np.eye(6)
        if not lost:  # a rotation that was lost shows nothing of the bias
            f[:3, 3:] = -dt / 2 * (before + after)  # dδ/dt = -R (b - b̂), by the trapezoidal rule
        noise = np.repeat([self.gyr_noise**2, self.bias_noise**2], 3)
        self.p = f @ self.p @ f.T + dt * np.diag(noise)
        if dt > 0.0:
            self.p = inflated(self.p)
            tilt = (self.p[0, 0] + self.p[1, 1]) / 2
            bias = np.trace(self.p[3:, 3:]) / 3
            for rows, variance, cap in (
                (slice(0, 2), tilt, UNKNOWN_ANGLE),
                (slice(2, 3), self.p[2, 2], UNKNOWN_ANGLE),
                (slice(3, 6), bias, self.initial_bias**2),
            ):
                if variance > cap:
                    self.p[rows, :] *= math.sqrt(cap / variance)
                    self.p[:, rows] *= math.sqrt(cap / variance)
        return after

    def _acc_update(self, x: Array, force: Array) -> Array:
        """Specific force in the earth frame: its horizontal part over g is (-δy, δx) to first order."""
        interval, self.acc_interval = self.acc_interval, 0.0
        level = saturated(force[:2], SATURATION * self.g)
        # External acceleration that lasts: the horizontal force, low-pass filtered.
        self.mean_acc += interval / (self.acc_window + interval) * (level - self.mean_acc)
        external2 = self.acc_adaptation**2 * float(self.mean_acc @ self.mean_acc)
        density2 = self.acc_noise**2 + min(external2, (LARGEST_INFLATION - 1.0) * self.acc_noise**2)
        if density2 > REJECTING_INFLATION * self.acc_noise**2:
            self.flags |= ACC_REJECTED
        z = np.array([level[1], -level[0]]) / self.g  # the tilt that the force shows, about east and north
        self.innovation[:2] = z
        if interval == 0.0:  # white noise has no information in no time
            return x
        h = np.eye(2, 6)
        variance = density2 / self.g**2 / interval * np.eye(2)
        return self._correct(x, h, z, variance, sensor=0)

    def _mag_update(self, x: Array, field: Array) -> Array:
        """Field in the earth frame: the heading alone, or all of it."""
        interval, self.mag_interval = self.mag_interval, 0.0
        east, north, up = field.tolist()
        horizontal = math.hypot(east, north)
        measured = np.array([horizontal, up])
        if self.field is None:
            self.field = measured
        difference = math.hypot(*(measured - self.field).tolist()) / math.hypot(*self.field.tolist())
        deviation2 = min(difference, LARGEST_DEVIATION) ** 2
        self.deviation2 += interval / (FIELD_TIME + interval) * (deviation2 - self.deviation2)
        deviation2 = max(deviation2, self.deviation2)
        density2 = self.heading_noise**2 * (1.0 + deviation2 / self.mag_tolerance**2) ** 2
        heading = math.atan2(east, north)
        self.innovation[2] = heading
        if interval == 0.0 or horizontal < VERTICAL_FIELD * math.hypot(horizontal, up):
            return x

        # Derivative of the heading by δ at the reference field: turned by δ itself, and by a tilt about north.
        north_up = direction(self.field)
        h = np.array([[0.0, -north_up[1] / north_up[0], 1.0, 0.0, 0.0, 0.0]])
        r = np.array([[density2 / interval]])
        nu = wrap(heading - float(h[0] @ x))
        nis = nu**2 / float((h @ self.p @ h.T + r)[0, 0])
        strange = deviation2 > (FIELD_GATE * self.mag_tolerance) ** 2
        rejected = strange or nis > self.mag_gate**2
        self.rejected_time = min(self.rejected_time + interval, 1e6) if rejected else 0.0
        recovering = rejected and self.rejected_time > self.mag_recovery
        self.nis[1] = nis
        if rejected and not recovering:
            self.flags |= MAG_REJECTED
            return x
        if recovering:
            self.flags |= RECOVERING
        self.headed = True
        if recovering and strange:  # a field that stays is the new reference
            self.field, self.deviation2 = measured, 0.0
        self.field_age += interval
        window = self.field_age - interval if self.vector else self.mag_window
        self.field = self.field + interval / (window + interval) * (measured - self.field)
        if self.vector:
            return self._vector_update(x, field, heading, density2 / interval)
        # The gain of the inclination is zero (Schmidt): the magnetometer turns only heading and bias.
        k, _ = gain(self.p, h, r)
        k[:2] = 0.0
        self.p = joseph(self.p, k, h, r)
        return x + k[:, 0] * nu

    def _vector_update(self, x: Array, field: Array, heading: float, variance: float) -> Array:
        """All three components against the reference (0, horizontal, up), over its norm."""
        assert self.field is not None
        reference = np.array([0.0, *direction(self.field)])
        norm = math.hypot(*self.field.tolist())
        innovation = saturated(field, SATURATION * norm) / norm - reference
        innovation[0] = reference[1] * heading
        h = np.zeros((3, 6))
        h[:, :3] = skew(reference)  # -δ × m = m × δ
        return self._correct(x, h, innovation, variance * reference[1] ** 2 * np.eye(3), sensor=1)

    def _correct(self, x: Array, h: Array, z: Array, r: Array, sensor: int) -> Array:
        nu = z - h @ x
        k, s = gain(self.p, h, r)
        self.p = joseph(self.p, k, h, r)
        self.nis[sensor] = normalised_square(nu, s)
        return x + k @ nu

    def _resting(self, gyr: Array, acc: Vec3 | None, dt: float) -> bool:
        """Whether angular rate and specific force have been constant for longer than `rest_time`."""
        if self.low_gyr is None:
            self.low_gyr = gyr
        self.low_gyr = self.low_gyr + dt / (REST_TIME + dt) * (gyr - self.low_gyr)
        still = math.hypot(*(gyr - self.low_gyr).tolist()) < self.rest_gyr
        if acc is not None:
            force = np.array(acc)
            if self.low_acc is None:
                self.low_acc = force
            self.low_acc = self.low_acc + self.acc_interval / (REST_TIME + self.acc_interval) * (force - self.low_acc)
            still = still and math.hypot(*(force - self.low_acc).tolist()) < self.rest_acc
        else:
            still = still and self.acc_interval < LONGEST_INTERVAL
        self.still_time = min(self.still_time + dt, 1e6) if still else 0.0
        resting = self.still_time > self.rest_time
        if resting:
            self.flags |= REST
        return resting

    def _rest_update(self, x: Array, gyr: Array, dt: float) -> Array:
        """At rest the gyroscope shows its bias, unless it is too far from the estimate: a slow turn."""
        assert self.low_gyr is not None
        if dt == 0.0 or math.hypot(*(self.low_gyr - self.b - x[3:]).tolist()) >= self.rest_gyr:
            return x
        h = np.eye(3, 6, 3)
        k, _ = gain(self.p, h, self.rest_noise**2 / dt * np.eye(3))
        self.p = joseph(self.p, k, h, self.rest_noise**2 / dt * np.eye(3))
        return x + k @ (gyr - self.b - x[3:])

    def _inject(self, x: Array) -> None:
        """R̂ := Rz(x_z) exp([(x_x, x_y, 0)×]) R̂, b̂ := b̂ + x_b, and the covariance of the error that is left."""
        tilt = exp_half((float(x[0]) / 2, float(x[1]) / 2, 0.0))
        turn = exp_half((0.0, 0.0, float(x[2]) / 2))
        self.q = normalize(multiply(turn, multiply(tilt, self.q)))
        self.b = saturated(self.b + x[3:], LARGEST_BIAS * self.initial_bias)
        reset = np.eye(6)
        c, s = math.cos(x[2]), math.sin(x[2])
        reset[:3, :3] = [[c, -s, 0.0], [s, c, 0.0], [-x[1] / 2, x[0] / 2, 1.0]]
        self.p = reset @ self.p @ reset.T


def direction(field: Array) -> Array:
    """Unit vector of a reference field (horizontal, vertical part), its horizontal part at least 1e-6."""
    unit: Array = field / math.hypot(*field.tolist())
    return np.array([max(unit[0], VERTICAL_FIELD), unit[1]])
