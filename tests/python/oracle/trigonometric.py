"""Roll and pitch by trigonometry: Çoçoli & Badia 2023, section II-A (accelerometer) and II-B (gyroscope)."""

import math

from .base import Filter, Told
from .so3 import Quat, Vec3, from_euler, to_euler, wrap

SOURCES = ("acc", "gyr")


def acc_angles(acc: Vec3) -> tuple[float | None, float]:
    """Roll and pitch (rad) that a resting accelerometer shows; roll None where x is vertical.

    Çoçoli (3)-(4) with the sign of a sensor that reads +g on z when level, and an arctangent for the arcsine
    of (4), which needs no |a|: pitch = atan2(-ax, √(ay² + az²)), roll = atan2(ay, az).
    """
    ax, ay, az = acc
    across = math.hypot(ay, az)
    pitch = math.atan2(-ax, across)
    if across < 1e-6 * math.hypot(ax, ay, az):
        return None, pitch
    return math.atan2(ay, az), pitch


def euler_rate_step(angles: Vec3, rate: Vec3, dt: float) -> Vec3:
    """Roll, pitch, yaw (rad) after dt seconds: one explicit Euler step of Çoçoli (5), with its yaw row added.

    |cos(pitch)| is held at 1e-6 or above, its sign kept.
    """
    roll, pitch, yaw = angles
    p, q, r = rate
    cos_pitch = math.copysign(max(abs(math.cos(pitch)), 1e-6), math.cos(pitch))
    tan_pitch = math.sin(pitch) / cos_pitch
    roll_rate = p + q * math.sin(roll) * tan_pitch + r * math.cos(roll) * tan_pitch  # (5), first row
    pitch_rate = q * math.cos(roll) - r * math.sin(roll)  # (5), second row
    yaw_rate = (q * math.sin(roll) + r * math.cos(roll)) / cos_pitch  # the row that (5) leaves out
    return (wrap(roll + roll_rate * dt), wrap(pitch + pitch_rate * dt), wrap(yaw + yaw_rate * dt))


class Trigonometric(Filter):
    """Euler angles from the accelerometer (source "acc") or from Euler rates (source "gyr")."""

    def __init__(self, *, source: str = "acc") -> None:
        if source not in SOURCES:
            raise ValueError(f"source: expected one of {SOURCES}, got {source!r}")
        self.source = source
        self.realigned = source == "gyr"
        self.roll = self.pitch = self.yaw = 0.0

    @property
    def q(self) -> Quat:
        """Attitude of the three angles."""
        return from_euler(self.roll, self.pitch, self.yaw)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude."""
        self.roll, self.pitch, self.yaw = to_euler(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; mag is not used. With source "acc" an accelerometer sample leaves the yaw as it is."""
        if self.source == "acc" and acc is not None:
            roll, self.pitch = acc_angles(acc)
            if roll is not None:
                self.roll = roll
        else:
            self.roll, self.pitch, self.yaw = euler_rate_step((self.roll, self.pitch, self.yaw), gyr, dt)
