"""`SelfCalKF` in whole matrices: transition F P Fᵀ, Joseph's form, one scalar measurement after the other.

The model is that of `selfcal_model`; here is what the filter does with it, see docs/selfcal.md.
"""

import math
from dataclasses import fields

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
    Array,
    joseph,
    reported,
    rotation,
    saturated,
    triple,
)
from .selfcal_model import (
    ACC_BIAS,
    BIAS,
    BLOCK,
    DELAY,
    DISTURBANCE,
    GRAVITY,
    HORIZONTAL,
    IRON,
    LONGEST_FIELD,
    LONGEST_FORCE,
    MATRIX,
    TURN,
    VELOCITY,
    VERTICAL,
    Block,
    N,
    Parameters,
    Rest,
    Slip,
    corrected,
)
from .so3 import IDENTITY, Quat, Vec3, about_z, exp_half, multiply, normalize, shortest_to_z

#: Groups of states with one limit of their mean variance: first index, number.
GROUPS = ((0, 2), (2, 1), (3, 3), (6, 9), (15, 3), (18, 3), (21, 1), (22, 3), (25, 3), (28, 2), (30, 1))


class Axis:
    """Finds where an axis of the gyroscope is clipped."""

    def __init__(self) -> None:
        self.last = self.largest = self.change = self.before = self.slope = self.time = self.lost = 0.0
        self.still = 0

    def see(self, rate: float, others: bool, limit: float, dt: float) -> float:
        """The variance that a step adds to the angle."""
        size = abs(rate)
        self.largest = max(self.largest, size)
        change = abs(rate - self.last) / dt if dt > 0.0 else self.change
        high = size > 4.0 and size >= 0.95 * self.largest
        going = self.still > 0
        begins = self.before > 0.5 * size or (others and change == 0.0)
        run = high and change < 0.1 * size and (going or begins)
        still = self.still + 1 if run else 0
        at_range = limit > 0.0 and size >= 0.995 * limit
        if dt > 0.0 and not (going or self.time > 0.0):
            self.slope = max(self.before, self.change)
        since = 0.0
        if at_range or still >= 5:
            since = self.time + dt if self.time > 0.0 else dt if at_range else still * dt
        since = min(since, 1.0)
        lost = min(0.25 * self.slope * since, 3.0) * since
        added = max(lost**2 - self.lost**2, 0.0) if since > 0.0 else 0.0
        if dt > 0.0:
            self.before, self.still = self.change, still
        self.change, self.last, self.time, self.lost = change, rate, since, lost
        return added


class SelfCalKF(Filter):
    """Attitude, the mean of the other states, and the covariance of the error."""

    follows_field = True
    has_covariance = True
    watched = True
    starts_in_motion = True

    def __init__(self, **params: float) -> None:
        self.k = Parameters(**params)
        assert len(params) <= len(fields(Parameters))
        self.q: Quat = IDENTITY
        self.x = np.zeros(N)
        self.x[GRAVITY] = self.k.gravity
        self.initial = self.k.initial_variances()
        self.p = np.diag(self.initial)
        self.block = Block()
        self.level, self.level_time = np.zeros(3), 0.0
        self.axes = [Axis(), Axis(), Axis()]
        self.slip, self.rest = Slip(), Rest()
        self.acc_interval = self.mag_interval = 0.0
        self.scale = 0.0
        self.headed = self.settled = False
        self.age = self.deviation = self.turned = self.confirmed = self.count = 0.0
        self.sum, self.candidate = np.zeros(3), np.zeros(3)
        self.weight = 1.0
        self.flags = 0

    @property
    def bias(self) -> Vec3:
        """Gyroscope bias in rad/s."""
        return triple(self.x[BIAS:MATRIX])

    def outputs(self) -> dict[str, Array]:
        """What the filter gives beside attitude and bias."""
        r = rotation(self.q)
        norm = 1.0 / self.scale if self.scale > 0.0 else 0.0
        return {
            "covariance": reported(r.T @ self.p[:3, :3] @ r, r[2], self.headed),
            "gyr_matrix": self.x[MATRIX:VELOCITY].reshape(3, 3).copy(),
            "mag_delay": np.array(self.x[DELAY]),
            "mag_delay_sigma": np.array(math.sqrt(self.p[DELAY, DELAY])),
            "hard_iron": self.x[IRON:DISTURBANCE] * norm,
            "disturbance": self.x[DISTURBANCE:HORIZONTAL] * norm,
            "mag_weight": np.array(self.weight),
            "mag_reference": self.x[HORIZONTAL:DELAY] * norm,
        }

    def _forget(self, *states: int) -> None:
        for i in states:
            self.p[i, :] = self.p[:, i] = 0.0
            self.p[i, i] = self.initial[i]

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude: heading and velocity start afresh, the inclination where the vertical is new."""
        q = normalize(q)
        if np.linalg.norm(rotation(q)[2] - rotation(self.q)[2]) > SAME_VERTICAL:
            self._forget(0, 1)
            self.level, self.level_time = np.zeros(3), 0.0
        self._forget(TURN, *range(VELOCITY, ACC_BIAS))
        self.x[VELOCITY:ACC_BIAS] = 0.0
        self.block = Block()
        self.q = q

    def lose_rotation(self, variance: float) -> None:
        """The attitude is known less from the end of the block on."""
        self.block.slip += variance

    def claimed(self) -> tuple[float, float]:
        """Variances of the error's two tilts, the larger one, and of its turn."""
        return max(float(self.p[0, 0]), float(self.p[1, 1])), float(self.p[TURN, TURN])

    def known_mag_delay(self) -> float:
        """Delay in s of the magnetometer behind the gyroscope: the one that is estimated."""
        return float(self.x[DELAY])

    def reopen(self, bias: Vec3) -> None:
        """Start anew, but for the field and the magnetometer's delay; their variances too are those of the start."""
        self.p = np.diag(self.initial)
        self.x[BIAS:MATRIX] = bias
        self.x[MATRIX:GRAVITY] = self.x[IRON:HORIZONTAL] = 0.0
        self.x[GRAVITY] = self.k.gravity
        self.block = Block()
        self.level, self.level_time = np.zeros(3), 0.0

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample: turn the attitude, add to the block, and end it where it is long enough."""
        self.flags = 0
        k, block = self.k, self.block
        omega = np.array(gyr)
        rate, turning = corrected(omega, self.x)
        self.q = gyro_step(self.q, triple(turning), dt, "exponential")
        r = rotation(self.q)
        turning = saturated(turning, 1e4)
        moved = [axis.last != value for axis, value in zip(self.axes, gyr, strict=True)]
        others = [any(moved[:i] + moved[i + 1 :]) for i in range(3)]
        seen_by = zip(self.axes, gyr, others, strict=True)
        clipped = np.array([axis.see(value, other, k.gyr_range, dt) for axis, value, other in seen_by])
        shown = np.where(clipped > 0.0, 0.0, rate)
        block.turns(r, omega, shown, turning, dt, lost=told.lost)
        block.clipped += r @ np.diag(clipped) @ r.T
        block.slip += self.slip.step(turning, dt)

        self.acc_interval = min(self.acc_interval + dt, LONGEST_FORCE)
        force = None if acc is None else np.array(acc)
        if force is not None and not block.pushes(r, force, self.x, self.acc_interval):
            self.flags |= ACC_REJECTED
        shown_time = min(dt, LONGEST_FORCE) if told.lost else dt  # one reading is no mean over a gap
        if self.rest.step(omega, force, shown_time, self.acc_interval, self.x[BIAS:MATRIX], k):
            self.flags |= REST
            block.rest += shown_time
        if acc is not None:
            self.acc_interval = 0.0
        if mag is not None:
            if self.scale == 0.0:
                self.scale = 1.0 / math.hypot(*mag)
            block.points(r, np.array(mag) * self.scale, turning, self.x)
        self.mag_interval = min(self.mag_interval + dt, LONGEST_FIELD)
        if dt > 0.0 and block.time + 0.5 * dt >= BLOCK:
            self._end_block()
        if self.weight < 0.25:
            self.flags |= MAG_REJECTED | (RECOVERING if self.turned > 0.5 * self._new_time() else 0)

    def _predict(self) -> None:
        """Covariance and mean over the block."""
        k, block = self.k, self.block
        f = block.transition(self.x)
        kept = math.exp(-block.time / k.disturbance_time)
        f[DISTURBANCE:HORIZONTAL, DISTURBANCE:HORIZONTAL] *= kept
        self.p = f @ self.p @ f.T + np.diag(block.noise(k, kept))
        self.p[:3, :3] += (block.clipped + block.clipped.T) / 2
        largest, factors = k.largest_variances(), np.ones(N)
        for start, count in GROUPS:
            total, limit = np.trace(self.p[start : start + count, start : start + count]), largest[start] * count
            factors[start : start + count] = math.sqrt(limit / total) if total > limit else 1.0
        self.p *= np.outer(factors, factors)
        self.x = block.predicted(self.x, kept)

    def _end_block(self) -> None:
        k, block = self.k, self.block
        self._predict()
        starting = self._level()
        rest = block.time < 2.0 * block.rest
        v2 = k.velocity_variance(rest, block.time)
        unit = np.eye(N)
        rows = [(unit[VELOCITY + i], -self.x[VELOCITY + i], v2, False) for i in range(3) if not starting]
        if rest:
            off = block.gyr / block.time - self.x[BIAS:MATRIX]
            rows += [(unit[BIAS + i], off[i], k.rest_noise**2 / block.time, False) for i in range(3)]
        if block.fields:
            rows += self._field_rows()
        x = np.zeros(N)
        for h, z, variance, level in rows:
            gain = self.p @ h / (h @ self.p @ h + variance)
            if level:  # the magnetometer does not move the inclination (Schmidt)
                gain[:2] = 0.0
            self.p = joseph(self.p, gain[:, None], h[None], np.array([[variance]]))
            x = x + gain * (z - h @ x)
        self._inject(x)
        self.block = Block()

    def _level(self) -> bool:
        """In the first second the mean specific force gives the inclination: whether it is that time."""
        block = self.block
        unknown = (self.p[0, 0] + self.p[1, 1]) / 2 > 0.05**2
        if not (self.level_time < 1.0 and block.force_time > 0.0 and unknown):
            return False
        total = self.level + block.force
        turn = shortest_to_z(triple(total / np.linalg.norm(total)))
        self._turn(turn)
        self.level = rotation(turn) @ total
        self.sum = rotation(turn) @ self.sum
        block.field = rotation(turn) @ block.field
        self.level_time += block.force_time
        self._forget(0, 1, 2, *range(VELOCITY, ACC_BIAS))
        self.x[VELOCITY:ACC_BIAS] = 0.0
        return True

    def _field_rows(self) -> list[tuple[Array, float, float, bool]]:
        """The measurements of the mean field, where it counts."""
        k, block, dt = self.k, self.block, self.mag_interval
        self.mag_interval = 0.0
        self.headed = True
        turning2 = block.rate2 / block.time
        if not self.settled:
            self._settle(block.field / block.fields, dt)
            return []
        now = block.deviation(self.x)
        self.deviation += -math.expm1(-dt / 0.25) * (now - self.deviation)
        self.weight = k.weight(max(now, self.deviation))
        if self._renew(block.clean(self.x), dt, turning2) or self.weight <= 1e-4:
            return []
        variance = k.field_variance(block, dt, self.weight)
        h, z = block.field_rows(self.x)
        return [(h[i], z[i], variance, True) for i in range(3)]

    def _turn(self, turn: Quat) -> None:
        """Turn the attitude, with what stands in the earth frame."""
        for start in (VELOCITY, DISTURBANCE):
            self.x[start : start + 3] = rotation(turn) @ self.x[start : start + 3]
        self.q = normalize(multiply(turn, self.q))

    def _take_reference(self, field: Array) -> float:
        """Heading and reference from a field: the turn (rad)."""
        across = math.hypot(field[0], field[1])
        angle = math.atan2(field[0], field[1]) if across > 1e-6 else 0.0
        self._turn(about_z(angle))
        self.x[HORIZONTAL], self.x[VERTICAL] = across, field[2]
        self._forget(HORIZONTAL, VERTICAL)
        return angle

    def _settle(self, field: Array, dt: float) -> None:
        """At the start the mean field gives heading and reference."""
        kept = math.exp(-dt)
        self.sum = self.sum * kept + field
        self.count = self.count * kept + 1.0
        angle = self._take_reference(self.sum / self.count)
        if math.hypot(self.sum[0], self.sum[1]) > 1e-6 * self.count:
            self.sum = rotation(about_z(angle)) @ self.sum
            self._forget(TURN)
        self.age += dt
        self.settled = bool((self.p[0, 0] + self.p[1, 1]) / 2 < 0.05**2 or self.age > 10.0)

    def _new_time(self) -> float:
        """How long a strange field has to be the same: as long as the reference has been seen, within limits."""
        return max(self.confirmed, 0.25 * self.k.mag_new_time)

    def _renew(self, measured: Array, dt: float, rate2: float) -> bool:
        """Whether a strange field has been the same for so long that it is the new reference."""
        strange = self.weight < 0.25
        near = 2.0 * self.k.mag_tolerance * np.linalg.norm(self.candidate)
        same = bool(np.linalg.norm(measured - self.candidate) < near)
        turning = dt if rate2 > 0.35**2 else 0.0
        needed = self._new_time()
        self.turned = min(self.turned + turning, self.k.mag_new_time) if strange and same else 0.0
        if not strange:
            self.confirmed = min(self.confirmed + turning, self.k.mag_new_time)
        moved = self.candidate + (measured - self.candidate) * -math.expm1(-dt / 5.0)
        self.candidate = moved if same else measured
        if not (strange and self.turned >= needed):
            return False
        self._take_reference(self.candidate)
        self._forget(TURN)
        self.confirmed, self.turned, self.deviation, self.weight = self.turned, 0.0, 0.0, 1.0
        return True

    def _inject(self, x: Array) -> None:
        """R̂ := exp(θ) R̂, and the others by addition, within what sensors have."""
        k = self.k
        self.q = normalize(multiply(exp_half(triple(x[:3] / 2)), self.q))
        self.x[BIAS:] += x[BIAS:]
        for start, size, limit in (
            (BIAS, 3, LARGEST_BIAS * k.initial_bias),
            (MATRIX, 9, LARGEST_BIAS * k.initial_matrix),
            (VELOCITY, 3, 1e4),
            (ACC_BIAS, 3, LARGEST_BIAS * k.initial_acc_bias),
            (IRON, 3, 16.0),
            (DISTURBANCE, 3, 16.0),
        ):
            self.x[start : start + size] = saturated(self.x[start : start + size], limit)
        spread = LARGEST_BIAS * k.initial_gravity
        self.x[GRAVITY] = np.clip(self.x[GRAVITY], k.gravity - spread, k.gravity + spread)
        self.x[DELAY] = np.clip(self.x[DELAY], -LARGEST_BIAS * k.initial_delay, LARGEST_BIAS * k.initial_delay)
        self.x[HORIZONTAL:DELAY] = np.clip(self.x[HORIZONTAL:DELAY], -16.0, 16.0)
