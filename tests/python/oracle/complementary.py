"""Complementary filter of the Euler angles: Parikh, Vohra & Kaveshgar 2021, section II-A."""

import math

from .adaptive import ACC_REJECTED, acc_share
from .base import Filter, Told
from .gyro_integration import INTEGRATIONS, gyro_step
from .so3 import IDENTITY, Quat, Vec3, from_euler, normalize, to_euler, wrap
from .trigonometric import acc_angles, euler_rate_step


class Complementary(Filter):
    """Roll and pitch weighted α for the gyroscope and 1 - α for the accelerometer; yaw from the gyroscope.

    α = τ/(τ + dt). The published α = 0.997 at 200 Hz is τ = 0.997/0.003/200 s.
    """

    def __init__(
        self, *, tau: float = 0.997 / 0.003 / 200, acc_threshold: float = 0.0, integration: str = "exponential"
    ) -> None:
        if integration not in INTEGRATIONS:
            raise ValueError(f"integration: expected one of {INTEGRATIONS}, got {integration!r}")
        self.tau = tau
        self.acc_threshold = acc_threshold
        self.integration = integration
        self.q = IDENTITY
        self.flags = 0

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude."""
        self.q = normalize(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; mag is not used."""
        if self.integration == "exponential":
            roll, pitch, yaw = to_euler(gyro_step(self.q, gyr, dt, "exponential"))
        else:
            roll, pitch, yaw = euler_rate_step(to_euler(self.q), gyr, dt)
        share = acc_share(acc, self.acc_threshold)
        self.flags = ACC_REJECTED if share == 0 else 0
        if acc is not None:
            alpha = self.tau / (self.tau + dt)
            if told.acc_interval > dt:
                # What is left after all the steps for which the measurement stands.
                alpha = math.exp(-told.acc_interval / self.tau) if self.tau > 0 else 0.0
            weight = (1 - alpha) * share
            acc_roll, acc_pitch = acc_angles(acc)
            # α angle + (1 - α) angle_acc, the difference of the two taken the short way round
            if acc_roll is not None:
                roll += weight * wrap(acc_roll - roll)
            pitch += weight * wrap(acc_pitch - pitch)
        self.q = normalize(from_euler(roll, pitch, yaw))
