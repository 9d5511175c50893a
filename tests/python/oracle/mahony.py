"""Mahony's passive complementary filter: Ludwig & Burnham 2018, Algorithm 1."""

import math

from .adaptive import ACC_REJECTED, acc_share
from .base import Filter, Told
from .gyro_integration import gyro_step
from .so3 import IDENTITY, Z_AXIS, Quat, Vec3, cross, normalize, rotate, rotate_inverse, unit


class Mahony(Filter):
    """Proportional-integral feedback of the angle between measured and expected directions."""

    follows_field = True

    def __init__(
        self, *, kp: float = 1.0, ki: float = 0.3, acc_threshold: float = 0.0, integration: str = "exponential"
    ) -> None:
        self.kp = kp
        self.ki = ki
        self.acc_threshold = acc_threshold
        self.integration = integration
        self.q = IDENTITY
        self.flags = 0
        self.bias: Vec3 = (0.0, 0.0, 0.0)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; the bias stays."""
        self.q = normalize(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample: the error at the previous attitude, the bias by it, then one gyroscope step by both."""
        q = self.q
        error = (0.0, 0.0, 0.0)
        weights = told.weights(dt)
        share = acc_share(acc, self.acc_threshold)
        self.flags = ACC_REJECTED if share == 0 else 0
        if acc is not None:
            expected_up = rotate_inverse(q, Z_AXIS)  # line 1: q⁻¹ ⊗ E_a ⊗ q
            error = add(error, scale(weights.acc * share, cross(unit(acc), expected_up)))  # line 3, first term
        if mag is not None:
            # E_m: the measured field in the earth frame, turned about z to north, which is y (as in Alg 2)
            hx, hy, hz = rotate(q, unit(mag))
            field = (0.0, math.hypot(hx, hy), hz)
            expected_field = rotate_inverse(q, field)  # line 2: q⁻¹ ⊗ E_m ⊗ q
            error = add(error, scale(weights.mag, cross(unit(mag), expected_field)))  # line 3, second term
        # In a gap the feedback counts for at most 1/(2 kp), so that it does not overshoot.
        feedback = min(weights.time, 0.5 / self.kp) if self.kp > 0 else weights.time
        if not told.recovering:
            self.bias = add(self.bias, scale(-self.ki * feedback, error))  # line 4, integrated
        rate = add(gyr, scale(-1.0, self.bias))
        turn = add(scale(dt, rate), scale(self.kp * feedback, error))  # line 5, integrated
        self.q = gyro_step(q, turn, 1.0, self.integration)  # line 6, integrated


def add(a: Vec3, b: Vec3) -> Vec3:
    """Sum of two vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scale(factor: float, v: Vec3) -> Vec3:
    """Vector times a number."""
    return (factor * v[0], factor * v[1], factor * v[2])
