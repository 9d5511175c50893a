"""`SelfCalKF` in whole matrices: transition F P Fᵀ, Joseph's form, one scalar measurement after the other.

The state is θ(3, earth frame), b(3), M(9, row by row), v(3), b_a(3), g, h(3), d(3), B_h, B_z, τ; see docs/selfcal.md.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

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
    joseph,
    reported,
    rotation,
    saturated,
    skew,
    triple,
)
from .so3 import IDENTITY, Quat, Vec3, about_z, exp_half, multiply, normalize, shortest_to_z

N = 31
THETA, TURN, BIAS, MATRIX, VELOCITY, ACC_BIAS, GRAVITY = 0, 2, 3, 6, 15, 18, 21
IRON, DISTURBANCE, HORIZONTAL, VERTICAL, DELAY = 22, 25, 28, 29, 30
#: Groups of states with one limit of their mean variance: first index, number.
GROUPS = ((0, 2), (2, 1), (3, 3), (6, 9), (15, 3), (18, 3), (21, 1), (22, 3), (25, 3), (28, 2), (30, 1))


@dataclass
class Parameters:
    """Those of the filter."""

    gyr_noise: float = 3e-4
    rate_noise: float = 7e-4
    gyr_range: float = 0.0
    bias_noise: float = 5e-5
    velocity: float = 0.3
    velocity_time: float = 0.5
    velocity_noise: float = 0.01
    mag_noise: float = 0.04
    mag_rate_noise: float = 7e-4
    mag_tolerance: float = 0.09
    mag_tail: float = 1.7
    mag_new_time: float = 20.0
    disturbance: float = 0.018
    disturbance_time: float = 8.0
    hard_iron_noise: float = 1e-3
    largest_hard_iron: float = 0.1
    rest_gyr: float = math.radians(2.0)
    rest_acc: float = 0.5
    rest_time: float = 1.5
    rest_noise: float = 5e-4
    rest_velocity: float = 0.02
    initial_inclination: float = 0.5
    initial_heading: float = 1.0
    initial_bias: float = 0.0087
    initial_matrix: float = 0.003
    initial_velocity: float = 1.0
    initial_acc_bias: float = 0.04
    initial_gravity: float = 0.05
    initial_hard_iron: float = 1e-3
    initial_field: float = 0.05
    initial_delay: float = 0.015
    latency: float = 0.0
    gravity: float = 9.80665

    def initial_variances(self) -> Array:
        """Of all states."""
        sigma = [self.initial_inclination] * 2 + [self.initial_heading] + [self.initial_bias] * 3
        sigma += [self.initial_matrix] * 9 + [self.initial_velocity] * 3 + [self.initial_acc_bias] * 3
        sigma += [self.initial_gravity] + [self.initial_hard_iron] * 3 + [self.disturbance] * 3
        sigma += [self.initial_field] * 2 + [self.initial_delay]
        return np.array(sigma) ** 2

    def largest_variances(self) -> Array:
        """The largest of all states."""
        largest = self.initial_variances()
        largest[:3] = UNKNOWN_ANGLE
        largest[VELOCITY:ACC_BIAS] += self.velocity**2
        iron = slice(IRON, DISTURBANCE)
        largest[iron] = np.maximum(largest[iron], self.largest_hard_iron**2)
        return largest


class Block:
    """Sums over the samples of 0.1 s."""

    def __init__(self) -> None:
        self.time = self.rate2 = self.slip = self.rest = self.force_time = 0.0
        self.fields = 0
        self.turn, self.clipped, self.force_turn, self.field_turn = (np.zeros((3, 3)) for _ in range(4))
        self.matrix = np.zeros((3, 9))
        self.gyr, self.force, self.field, self.field_change = (np.zeros(3) for _ in range(4))


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


class SelfCalKF:
    """Attitude, the mean of the other states, and the covariance of the error."""

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
        self.last_rate: Array | None = None
        self.usual = 0.0
        self.low_gyr: Array | None = None
        self.low_acc: Array | None = None
        self.still_time = self.acc_interval = self.mag_interval = 0.0
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

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float) -> None:
        """One sample: turn the attitude, add to the block, and end it where it is long enough."""
        self.flags = 0
        k, block = self.k, self.block
        omega = np.array(gyr)
        rate = omega - self.x[BIAS:MATRIX]
        turning = rate + self.x[MATRIX:VELOCITY].reshape(3, 3) @ rate
        self.q = gyro_step(self.q, triple(turning), dt, "exponential")
        r = rotation(self.q)
        turning = saturated(turning, 1e4)
        moved = [axis.last != value for axis, value in zip(self.axes, gyr, strict=True)]
        others = [any(moved[:i] + moved[i + 1 :]) for i in range(3)]
        seen_by = zip(self.axes, gyr, others, strict=True)
        clipped = np.array([axis.see(value, other, k.gyr_range, dt) for axis, value, other in seen_by])
        angle = np.where(clipped > 0.0, 0.0, rate) * dt
        block.time += dt
        block.turn += r * dt
        block.matrix += (r[:, :, None] * angle).reshape(3, 9)
        block.clipped += r @ np.diag(clipped) @ r.T
        block.rate2 += float(turning @ turning) * dt
        block.gyr += omega * dt
        block.slip += self._slip(turning, dt)

        self.acc_interval = min(self.acc_interval + dt, 0.1)
        if acc is not None:
            force = np.array(acc)
            if np.linalg.norm(force) > SATURATION * self.x[GRAVITY]:
                self.flags |= ACC_REJECTED
            else:
                block.force += r @ (force - self.x[ACC_BIAS:GRAVITY]) * self.acc_interval
                block.force_turn += r * self.acc_interval
                block.force_time += self.acc_interval
        if self._rests(omega, acc, dt):
            self.flags |= REST
            block.rest += dt
        if acc is not None:
            self.acc_interval = 0.0
        if mag is not None:
            if self.scale == 0.0:
                self.scale = 1.0 / math.hypot(*mag)
            field = saturated(np.array(mag) * self.scale, SATURATION)
            seen = rotation(exp_half(triple(turning * (-0.5 * self.x[DELAY])))) @ field
            block.field += r @ seen
            block.field_change += r @ np.cross(turning, seen)
            block.field_turn += r
            block.fields += 1
        self.mag_interval = min(self.mag_interval + dt, 0.2)
        if dt > 0.0 and block.time + 0.5 * dt >= 0.1:
            self._end_block()
        if self.weight < 0.25:
            self.flags |= MAG_REJECTED | (RECOVERING if self.turned > 0.5 * self._new_time() else 0)

    def _slip(self, rate: Array, dt: float) -> float:
        """The variance of the angle that an irregular step leaves unknown."""
        if self.last_rate is None:
            self.last_rate, self.usual = rate, dt
        across = 0.5 * np.linalg.norm(rate - self.last_rate) + 0.1 * np.linalg.norm(rate)
        slip = min(float(across) * abs(dt - self.usual), 3.0) ** 2
        self.usual += 0.02 * (min(dt, 2.0 * self.usual + 1e-4) - self.usual)
        self.last_rate = rate
        return slip

    def _rests(self, gyr: Array, acc: Vec3 | None, dt: float) -> bool:
        k = self.k
        if self.low_gyr is None:
            self.low_gyr = gyr
        self.low_gyr = self.low_gyr + (gyr - self.low_gyr) * (dt / (0.5 + dt))
        still = bool(np.linalg.norm(gyr - self.low_gyr) < k.rest_gyr)
        if acc is None:
            still = still and self.acc_interval < 0.1
        else:
            force, interval = np.array(acc), self.acc_interval
            if self.low_acc is None:
                self.low_acc = force
            self.low_acc = self.low_acc + (force - self.low_acc) * (interval / (0.5 + interval))
            still = still and bool(np.linalg.norm(force - self.low_acc) < k.rest_acc)
        self.still_time = min(self.still_time + dt, 1e6) if still else 0.0
        slow = np.linalg.norm(self.low_gyr - self.x[BIAS:MATRIX]) < k.rest_gyr
        return bool(self.still_time > k.rest_time and slow)

    def _predict(self) -> None:
        """Covariance and mean over the block."""
        k, block = self.k, self.block
        f = np.eye(N)
        f[:3, BIAS:MATRIX] = -block.turn @ (np.eye(3) + self.x[MATRIX:VELOCITY].reshape(3, 3))
        f[:3, MATRIX:VELOCITY] = block.matrix
        v = slice(VELOCITY, ACC_BIAS)
        pushed = -skew(block.force)
        pushed[:, TURN] = 0.0  # the velocity's error turns with the heading
        f[v, :3] = pushed
        f[v, BIAS:VELOCITY] = 0.5 * pushed @ f[:3, BIAS:VELOCITY]
        f[v, ACC_BIAS:GRAVITY] = -block.force_turn
        f[VELOCITY + 2, GRAVITY] = -block.force_time
        kept = math.exp(-block.time / k.disturbance_time)
        f[DISTURBANCE:HORIZONTAL, DISTURBANCE:HORIZONTAL] *= kept
        noise = np.zeros(N)
        noise[:3] = k.gyr_noise**2 * block.time + k.rate_noise**2 * block.rate2 + block.slip
        noise[BIAS:MATRIX] = k.bias_noise**2 * block.time
        unknown = min(max(block.time - block.force_time, 0.0), 1.0) * k.gravity
        noise[v] = k.velocity_noise**2 * block.time + unknown**2
        noise[IRON:DISTURBANCE] = k.hard_iron_noise**2 * block.time
        noise[DISTURBANCE:HORIZONTAL] = k.disturbance**2 * (1.0 - kept**2)
        self.p = f @ self.p @ f.T + np.diag(noise)
        self.p[:3, :3] += (block.clipped + block.clipped.T) / 2
        largest, factors = k.largest_variances(), np.ones(N)
        for start, count in GROUPS:
            total, limit = np.trace(self.p[start : start + count, start : start + count]), largest[start] * count
            factors[start : start + count] = math.sqrt(limit / total) if total > limit else 1.0
        self.p *= np.outer(factors, factors)
        self.x[v] += block.force - np.array([0.0, 0.0, self.x[GRAVITY] * block.force_time])
        self.x[DISTURBANCE:HORIZONTAL] *= kept

    def _end_block(self) -> None:
        k, block = self.k, self.block
        self._predict()
        starting = self._level()
        rest = block.time < 2.0 * block.rest
        v2 = k.rest_velocity**2 if rest else 2.0 * k.velocity**2 * k.velocity_time / block.time
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
        turn, field, change = (m / block.fields for m in (block.field_turn, block.field, block.field_change))
        clean = field - turn @ self.x[IRON:DISTURBANCE]
        off = clean - np.array([0.0, self.x[HORIZONTAL], self.x[VERTICAL]])
        turning2 = block.rate2 / block.time
        if not self.settled:
            self._settle(field, dt)
            return []
        longer = math.hypot(clean[0], clean[1]) - (clean[1] - off[1])
        turned2 = max(off[0] ** 2 + off[1] ** 2 - longer**2, 0.0)
        now = min(math.sqrt(longer**2 + off[2] ** 2 + 0.1 * turned2), 16.0)
        self.deviation += -math.expm1(-dt / 0.25) * (now - self.deviation)
        self.weight = (1.0 + (max(now, self.deviation) / k.mag_tolerance) ** 2 / k.mag_tail) ** -2
        if self._renew(clean, dt, turning2) or self.weight <= 1e-4:
            return []
        variance = (k.mag_noise**2 + k.mag_rate_noise**2 * turning2) / (dt * self.weight)
        # y + θ × y = B + d + R h + change δτ, and θ × y = −y × θ.
        h = np.zeros((3, N))
        h[:, IRON:DISTURBANCE] = turn
        h[:, DISTURBANCE:HORIZONTAL] = np.eye(3)
        h[1, HORIZONTAL] = h[2, VERTICAL] = 1.0
        h[:, DELAY] = change
        h[:, :3] = skew(field)
        z = off - self.x[DISTURBANCE:HORIZONTAL]
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
