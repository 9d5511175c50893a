"""The model of docs/selfcal.md, as `SelfCalKF` and `SelfCalSmoother` share it: parameters, sums over blocks, equations.

The state is θ(3, earth frame), b(3), M(9, row by row), v(3), b_a(3), g, h(3), d(3), B_h, B_z, τ.
"""

import math
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from .kalman import SATURATION, UNKNOWN_ANGLE, Array, rotation, saturated, skew, triple
from .so3 import exp_half

N = 31
THETA, TURN, BIAS, MATRIX, VELOCITY, ACC_BIAS, GRAVITY = 0, 2, 3, 6, 15, 18, 21
IRON, DISTURBANCE, HORIZONTAL, VERTICAL, DELAY = 22, 25, 28, 29, 30
#: The time of a block, and the longest ones that a specific force and a block's field stand for, in s.
BLOCK, LONGEST_FORCE, LONGEST_FIELD = 0.1, 0.1, 0.2


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
        variances = np.array(sigma) ** 2
        variances[: TURN + 1] = np.minimum(variances[: TURN + 1], UNKNOWN_ANGLE)
        return variances

    def largest_variances(self) -> Array:
        """The largest of all states."""
        largest = self.initial_variances()
        largest[:3] = UNKNOWN_ANGLE
        largest[VELOCITY:ACC_BIAS] += self.velocity**2
        iron = slice(IRON, DISTURBANCE)
        largest[iron] = np.maximum(largest[iron], self.largest_hard_iron**2)
        return largest

    def velocity_variance(self, rests: bool, time: float) -> float:
        """Of the pseudo-measurement that the velocity at the end of a block is zero."""
        return self.rest_velocity**2 if rests else 2.0 * self.velocity**2 * self.velocity_time / time

    def field_variance(self, block: "Block", interval: float, weight: float) -> float:
        """Of a component of a block's mean field, which stands for an interval (s)."""
        turning2 = block.rate2 / block.time
        return (self.mag_noise**2 + self.mag_rate_noise**2 * turning2) / (interval * weight)

    def weight(self, deviation: float) -> float:
        """Of a field that is off by so many norms."""
        return (1.0 + (deviation / self.mag_tolerance) ** 2 / self.mag_tail) ** -2


class Block:
    """Sums over the samples of 0.1 s; the attitude of each is R, the state x."""

    def __init__(self) -> None:
        self.time = self.rate2 = self.slip = self.rest = self.force_time = 0.0
        self.fields = 0
        self.turn, self.clipped, self.force_turn, self.field_turn = (np.zeros((3, 3)) for _ in range(4))
        self.matrix = np.zeros((3, 9))
        self.gyr, self.force, self.field, self.field_change = (np.zeros(3) for _ in range(4))

    def turns(self, r: Array, omega: Array, rate: Array, turning: Array, dt: float, *, lost: bool = False) -> None:
        """Turn for dt (s) at a corrected rate; `rate` is ω − b, without what is clipped.

        A turn that was lost shows nothing of the gyroscope's errors.
        """
        self.time += dt
        self.gyr += omega * dt
        if lost:
            return
        self.turn += r * dt
        self.matrix += (r[:, :, None] * rate * dt).reshape(3, 9)
        self.rate2 += float(turning @ turning) * dt

    def pushes(self, r: Array, force: Array, x: Array, dt: float) -> bool:
        """Add a specific force that stands for dt (s); False where it is beyond what counts."""
        if np.linalg.norm(force) > SATURATION * x[GRAVITY]:
            return False
        self.force += r @ (force - x[ACC_BIAS:GRAVITY]) * dt
        self.force_turn += r * dt
        self.force_time += dt
        return True

    def points(self, r: Array, field: Array, turning: Array, x: Array) -> None:
        """Add a field (in its norms), turned back by the delay."""
        seen = rotation(exp_half(triple(turning * (-0.5 * x[DELAY])))) @ saturated(field, SATURATION)
        self.field += r @ seen
        self.field_change += r @ np.cross(turning, seen)
        self.field_turn += r
        self.fields += 1

    def transition(self, x: Array) -> Array:
        """F of the error, without the disturbance's decay."""
        f = np.eye(N)
        f[:3, BIAS:MATRIX] = -self.turn @ (np.eye(3) + x[MATRIX:VELOCITY].reshape(3, 3))
        f[:3, MATRIX:VELOCITY] = self.matrix
        v = slice(VELOCITY, ACC_BIAS)
        pushed = -skew(self.force)
        pushed[:, TURN] = 0.0  # the velocity's error turns with the heading
        f[v, :3] = pushed
        f[v, BIAS:VELOCITY] = 0.5 * pushed @ f[:3, BIAS:VELOCITY]
        f[v, ACC_BIAS:GRAVITY] = -self.force_turn
        f[VELOCITY + 2, GRAVITY] = -self.force_time
        return f

    def noise(self, k: Parameters, kept: float) -> Array:
        """The variances of what enters; `kept` is what is left of the disturbance."""
        noise = np.zeros(N)
        noise[:3] = k.gyr_noise**2 * self.time + k.rate_noise**2 * self.rate2 + self.slip
        noise[BIAS:MATRIX] = k.bias_noise**2 * self.time
        unknown = min(max(self.time - self.force_time, 0.0), 1.0) * k.gravity
        noise[VELOCITY:ACC_BIAS] = k.velocity_noise**2 * self.time + unknown**2
        noise[IRON:DISTURBANCE] = k.hard_iron_noise**2 * self.time
        noise[DISTURBANCE:HORIZONTAL] = k.disturbance**2 * (1.0 - kept**2)
        # What is known exactly at the start does not wander.
        exact = k.initial_variances() == 0.0
        noise[IRON:DISTURBANCE][exact[IRON:DISTURBANCE]] = noise[BIAS:MATRIX][exact[BIAS:MATRIX]] = 0.0
        return noise

    def predicted(self, x: Array, kept: float) -> Array:
        """The mean of the states after the block."""
        after = x.copy()
        after[VELOCITY:ACC_BIAS] += self.force - np.array([0.0, 0.0, x[GRAVITY] * self.force_time])
        after[DISTURBANCE:HORIZONTAL] *= kept
        return after

    def clean(self, x: Array) -> Array:
        """The mean field without the hard iron."""
        clean: Array = (self.field - self.field_turn @ x[IRON:DISTURBANCE]) / self.fields
        return clean

    def deviation(self, x: Array) -> float:
        """How far the field is from the reference, at most 16; of a turn about the vertical counts a tenth, squared."""
        clean = self.clean(x)
        east, north, up = clean - np.array([0.0, x[HORIZONTAL], x[VERTICAL]])
        longer = math.hypot(clean[0], clean[1]) - x[HORIZONTAL]
        turned2 = max(east**2 + north**2 - longer**2, 0.0)
        return min(math.sqrt(longer**2 + up**2 + 0.1 * turned2), 16.0)

    def field_rows(self, x: Array) -> tuple[Array, Array]:
        """H (3, N) and innovation of the mean field: y + θ × y = B + d + R h + change δτ."""
        field, turn, change = (m / self.fields for m in (self.field, self.field_turn, self.field_change))
        h = np.zeros((3, N))
        h[:, :3] = skew(field)  # θ × y = −y × θ
        h[:, IRON:DISTURBANCE] = turn
        h[:, DISTURBANCE:HORIZONTAL] = np.eye(3)
        h[1, HORIZONTAL] = h[2, VERTICAL] = 1.0
        h[:, DELAY] = change
        expected = np.array([0.0, x[HORIZONTAL], x[VERTICAL]]) + x[DISTURBANCE:HORIZONTAL]
        return h, self.clean(x) - expected


class Slip:
    """The variance of the angle that irregular steps leave unknown."""

    def __init__(self) -> None:
        self.last: Array | None = None
        self.usual = 0.0

    def step(self, rate: Array, dt: float) -> float:
        """Go on by dt (s) at a corrected rate; the first sample makes no step."""
        if self.last is None:
            if dt <= 0.0:
                return 0.0
            self.last, self.usual = rate, dt
        across = 0.5 * np.linalg.norm(rate - self.last) + 0.1 * np.linalg.norm(rate)
        slip = min(float(across) * abs(dt - self.usual), 3.0) ** 2
        self.usual += 0.02 * (min(dt, 2.0 * self.usual + 1e-4) - self.usual)
        self.last = rate
        return slip


class Rest:
    """Finds where neither angular rate nor specific force changes."""

    def __init__(self) -> None:
        self.gyr: Array | None = None
        self.acc: Array | None = None
        self.time = 0.0

    def step(self, gyr: Array, force: Array | None, dt: float, interval: float, bias: Array, k: Parameters) -> bool:
        """Go on by dt (s); the last specific force came `interval` ago, or is given. Whether it rests."""
        if self.gyr is None:
            self.gyr = gyr
        self.gyr = self.gyr + (gyr - self.gyr) * (dt / (0.5 + dt))
        still = bool(np.linalg.norm(gyr - self.gyr) < k.rest_gyr)
        if force is None:
            still = still and interval < LONGEST_FORCE
        else:
            if self.acc is None:
                self.acc = force
            self.acc = self.acc + (force - self.acc) * (interval / (0.5 + interval))
            still = still and bool(np.linalg.norm(force - self.acc) < k.rest_acc)
        self.time = min(self.time + dt, 1e6) if still else 0.0
        slow = np.linalg.norm(self.gyr - bias) < k.rest_gyr
        return bool(self.time > k.rest_time and slow)


def corrected(omega: Array, x: Array) -> tuple[Array, Array]:
    """ω − b, and (I + M)(ω − b), of a measured rate."""
    rate = omega - x[BIAS:MATRIX]
    return rate, rate + x[MATRIX:VELOCITY].reshape(3, 3) @ rate


def detected(rates: list[Array], acc: list[Array | None], dt: list[float], bias: Array, k: Parameters) -> list[bool]:
    """Where the sensor rests, in one direction of time."""
    detector, since, found = Rest(), 0.0, []
    for rate, force, step in zip(rates, acc, dt, strict=True):
        since = min(since + step, LONGEST_FORCE)
        found.append(detector.step(rate, force, step, since, bias, k))
        since = since if force is None else 0.0
    return found


def block_ends(dt: list[float]) -> list[int]:
    """The index after the last sample of each block: that at which its time is nearest to a block's."""
    ends, time = [], 0.0
    for i, step in enumerate(dt):
        time += step
        if step > 0.0 and time + 0.5 * step >= BLOCK - 1e-9:
            ends.append(i + 1)
            time = 0.0
    return ends if ends and ends[-1] == len(dt) else [*ends, len(dt)]


def find_clipped(rates: Array, k: Parameters) -> Array:
    """Where an axis (T, 3) is at the end of its range: the given one, or the largest rate where it stays there."""
    sizes, found = np.abs(rates), np.zeros(rates.shape, dtype=bool)
    for axis in range(3):
        size = sizes[:, axis]
        largest = k.gyr_range or size.max()
        at_end = size > 0.995 * largest
        runs = [len(list(run)) for end, run in groupby(at_end) if end]
        stays = sum(run for run in runs if run >= 3)
        if k.gyr_range or (largest > 2.0 and np.sum(size > 0.98 * largest) <= 1.5 * stays):
            found[:, axis] = at_end
    return found
