"""Two linear Kalman filters, for roll and for pitch: Parikh et al. 2021, eqs 1-2; Çoçoli & Badia 2023, Table I."""

import math

import numpy as np

from .base import Filter, Told, steps
from .gyro_integration import INTEGRATIONS, gyro_step
from .kalman import SAME_VERTICAL, UNKNOWN_ANGLE, Array, capped, gain, inflated, joseph, reported, rotation
from .so3 import IDENTITY, Quat, Vec3, from_euler, normalize, to_euler, wrap
from .trigonometric import acc_angles, euler_rate_step

DEGREE2 = math.radians(1.0) ** 2
#: Parikh's matrices belong to steps of 5 ms.
PARIKH_STEP = 0.005
#: Largest variance of a bias, (rad/s)².
LARGEST_BIAS_VARIANCE = 1e6


class LinearKalman(Filter):
    """State [angle, bias] per axis, the accelerometer's angle as measurement; yaw is integrated."""

    has_covariance = True

    def __init__(
        self,
        *,
        angle_process: float = 0.01181 * DEGREE2 / PARIKH_STEP,
        bias_process: float = 4.28e-6 * DEGREE2 / PARIKH_STEP,
        angle_variance: float = 2650.0 * DEGREE2,
        initial_angle: float = 0.0,
        initial_bias: float = 0.01,
        integration: str = "exponential",
    ) -> None:
        if integration not in INTEGRATIONS:
            raise ValueError(f"integration: expected one of {INTEGRATIONS}, got {integration!r}")
        self.q_matrix = np.diag([angle_process, bias_process])  # per second
        self.r = np.array([[angle_variance]])
        self.p0_angle = initial_angle**2 if initial_angle > 0.0 else angle_variance
        self.integration = integration
        self.q = IDENTITY
        self.b = np.zeros(2)
        self.p = [np.diag([self.p0_angle, initial_bias**2]) for _ in range(2)]  # roll, pitch
        self.innovation = np.full(2, np.nan)
        self.nis = np.full(2, np.nan)
        self.flags = 0

    @property
    def bias(self) -> Vec3:
        """Bias (bx, by, 0) in rad/s: roll's and pitch's; yaw has none."""
        return (float(self.b[0]), float(self.b[1]), 0.0)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; where its vertical is a new one, the angles' variances start afresh."""
        q = normalize(q)
        if np.linalg.norm(rotation(q)[2] - rotation(self.q)[2]) > SAME_VERTICAL:
            self.p = [np.diag([self.p0_angle, p[1, 1]]) for p in self.p]
        self.q = q

    def lose_rotation(self, variance: float) -> None:
        """Both angles are known less."""
        for p in self.p:
            p[0, 0] += variance

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; mag is not used."""
        roll_before = to_euler(self.q)[0]
        rate = (gyr[0] - float(self.b[0]), gyr[1] - float(self.b[1]), gyr[2])
        # Parikh (1) in three dimensions; Table I, "project into k+1"
        if self.integration == "exponential":
            roll, pitch, yaw = to_euler(gyro_step(self.q, rate, dt, "exponential"))
        else:
            roll, pitch, yaw = euler_rate_step(to_euler(self.q), rate, dt)
        # A bias about the sensor's y turns the pitch by -cos(roll) dt, which is Parikh's -dt where the sensor is level.
        for axis, slope in enumerate((1.0, math.cos(roll_before))):
            phi = np.array([[1.0, -slope * dt], [0.0, 1.0]])
            self.p[axis] = phi @ self.p[axis] @ phi.T + self.q_matrix * dt
            if dt > 0.0:
                self.p[axis] = capped(inflated(self.p[axis]), np.array([UNKNOWN_ANGLE, LARGEST_BIAS_VARIANCE]))

        self.innovation = np.full(2, np.nan)
        self.nis = np.full(2, np.nan)
        if acc is not None:
            acc_roll, acc_pitch = acc_angles(acc)
            r = self.r / steps(told.acc_interval, told.usual)
            if acc_roll is not None:
                roll += self._update(0, wrap(acc_roll - roll), r)
            pitch += self._update(1, wrap(acc_pitch - pitch), r)
        self.q = normalize(from_euler(roll, pitch, yaw))

    def _update(self, axis: int, innovation: float, r: Array) -> float:
        """Table I with H = [1 0], Parikh (2): corrects the axis' bias, returns the correction of its angle."""
        h = np.array([[1.0, 0.0]])
        k, s = gain(self.p[axis], h, r)
        self.p[axis] = joseph(self.p[axis], k, h, r)
        self.b[axis] += k[1, 0] * innovation
        self.innovation[axis] = innovation
        self.nis[axis] = innovation**2 / s[0, 0]
        return float(k[0, 0] * innovation)

    @property
    def covariance(self) -> Array:
        """Attitude covariance (3, 3), sensor frame, rad²: of roll about x, of pitch about (0, cos φ, -sin φ)."""
        roll = to_euler(self.q)[0]
        x = np.array([1.0, 0.0, 0.0])
        y = np.array([0.0, math.cos(roll), -math.sin(roll)])
        p = self.p[0][0, 0] * np.outer(x, x) + self.p[1][0, 0] * np.outer(y, y)
        return reported(p, rotation(self.q)[2], heading_known=False)
