"""Hyyti & Visala 2015: an adaptive extended Kalman filter on the bottom row of the rotation matrix."""

import math

import numpy as np

from .base import Filter, Told, steps
from .gyro_integration import gyro_step
from .kalman import (
    LARGEST_BIAS,
    LARGEST_TURN,
    SAME_VERTICAL,
    SATURATION,
    Array,
    capped,
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
from .so3 import Quat, Vec3, exp_half, from_euler, normalize, to_euler

PREDICTIONS = ("exponential", "euler")


class DcmImu(Filter):
    """State x = [C31 C32 C33 bx by bz]; the yaw is integrated outside, and held with the roll at pitch ±90°."""

    has_covariance = True
    watched = True

    def __init__(
        self,
        *,
        dcm_process: float = 0.1,
        bias_process: float = 1e-4,
        acc_std: float = 0.5,
        acc_motion: float = 10.0,
        initial_dcm: float = 1.0,
        initial_bias: float = 0.1,
        gravity: float = 9.80665,
        prediction: str = "exponential",
    ) -> None:
        if prediction not in PREDICTIONS:
            raise ValueError(f"prediction: expected one of {PREDICTIONS}, got {prediction!r}")
        self.q_diagonal = np.repeat([dcm_process**2, bias_process**2], 3)
        self.acc_std = acc_std
        self.acc_motion = acc_motion
        self.initial_dcm = initial_dcm
        self.initial_bias = initial_bias
        self.g = gravity
        self.prediction = prediction
        self.c3 = np.array([0.0, 0.0, 1.0])
        self.b = np.zeros(3)
        self.p = np.diag(np.repeat([initial_dcm**2, initial_bias**2], 3))
        self.roll = self.yaw = 0.0
        self.innovation = np.full(3, np.nan)
        self.nis = math.nan
        self.flags = 0

    @property
    def q(self) -> Quat:
        """Attitude of (14) and the yaw outside; the pitch by an arctangent, which needs no |C3| = 1."""
        c31, c32, c33 = triple(self.c3)
        return from_euler(self.roll, math.atan2(-c31, math.hypot(c32, c33)), self.yaw)

    @property
    def bias(self) -> Vec3:
        """Gyroscope bias in rad/s."""
        return triple(self.b)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; where its vertical is a new one, C3's covariance starts afresh."""
        q = normalize(q)
        c3 = rotation(q)[2]
        if np.linalg.norm(c3 - self.c3) > SAME_VERTICAL:
            self.p[:3, :] = self.p[:, :3] = 0.0
            self.p[:3, :3] = self.initial_dcm**2 * np.eye(3)
        self.c3 = c3
        self.roll, _, self.yaw = to_euler(q)

    def lose_rotation(self, variance: float) -> None:
        """δC3 = [C3×] δθ."""
        across = skew(self.c3)
        self.p[:3, :3] += variance * across @ across.T

    def claimed(self) -> tuple[float, float]:
        """What is to be believed of it: 0.05 rad, and 1 rad of the heading."""
        return 0.05**2, 1.0

    def reopen(self, bias: Vec3) -> None:
        """Start anew."""
        self.p = np.diag(np.repeat([self.initial_dcm**2, self.initial_bias**2], 3))
        self.b = np.array(bias)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; mag is not used."""
        before, c3 = self.q, self.c3
        u = np.array(gyr) - self.b
        turn = transition(u, dt, self.prediction)
        self.c3 = turn @ c3  # (A.3): x + dt [C3×](u - b), or the exact solution over the step
        f = np.eye(6)  # (A.4)
        f[:3, :3] = turn
        f[:3, 3:] = -dt * skew(c3)
        self.p = f @ self.p @ f.T + dt**2 * np.diag(self.q_diagonal)  # (A.4) with (10)
        if dt > 0.0:
            self.p = capped(inflated(self.p), np.repeat([1.0, 4 * self.initial_bias**2], 3))

        self.innovation = np.full(3, np.nan)
        self.nis = math.nan
        if acc is not None:
            force = saturated(np.array(acc), SATURATION * self.g)
            nu = force - self.g * self.c3  # (A.5); the same vector is a of (12)
            variance = float(np.linalg.norm(nu)) * self.acc_motion**2 + self.acc_std**2  # (11)
            r = variance / steps(told.acc_interval, told.usual) * np.eye(3)
            h = np.hstack([self.g * np.eye(3), np.zeros((3, 3))])  # (9)
            k, s = gain(self.p, h, r)
            correction = k @ nu
            self.c3 = self.c3 + correction[:3]
            self.b = saturated(self.b + correction[3:], LARGEST_BIAS * self.initial_bias)
            self.p = joseph(self.p, k, h, r)  # (A.6)
            self.innovation = nu
            self.nis = normalised_square(nu, s)

        # (A.7)-(A.8): projection onto |C3| = 1, J at the unnormalised state
        d = float(np.linalg.norm(self.c3))
        j = np.eye(6)
        j[:3, :3] = (d**2 * np.eye(3) - np.outer(self.c3, self.c3)) / d**3
        self.p = j @ self.p @ j.T
        self.c3 = self.c3 / d
        # (14), (15); where the sensor's x axis is vertical, C3 tells no roll
        if math.hypot(self.c3[1], self.c3[2]) >= 1e-6:
            self.roll = math.atan2(self.c3[1], self.c3[2])
            self.yaw = self._turned_yaw(before, np.array(gyr) - self.b, dt)

    def _turned_yaw(self, before: Quat, rate: Array, dt: float) -> float:
        """(15): first column of the whole matrix, from the previous posterior with the updated bias."""
        if self.prediction == "exponential":
            column = rotation(gyro_step(before, triple(rate), dt, "exponential"))[:, 0]
        else:
            c = rotation(before)
            column = (c + dt * c @ skew(rate))[:, 0]
        return math.atan2(column[1], column[0])

    @property
    def covariance(self) -> Array:
        """Attitude covariance (3, 3), sensor frame, rad²; from δC3 = [C3×] δθ."""
        s = skew(self.c3)
        return reported(s.T @ self.p[:3, :3] @ s, self.c3, heading_known=False)


def transition(u: Array, dt: float, prediction: str) -> Array:
    """F11, which turns C3: exp(-dt [u×]), or I - dt [u×] as published."""
    if prediction == "exponential":
        half = (-u[0] * dt / 2, -u[1] * dt / 2, -u[2] * dt / 2)
        return rotation(exp_half(half))
    return np.asarray(np.eye(3) - skew(saturated(dt * u, LARGEST_TURN)))
