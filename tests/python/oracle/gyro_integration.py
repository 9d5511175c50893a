"""Angular rate integrated, nothing else."""

from .base import Filter, Told
from .so3 import IDENTITY, Quat, Vec3, exp_half, multiply, normalize

INTEGRATIONS = ("exponential", "first-order")


def gyro_step(q: Quat, rate: Vec3, dt: float, integration: str) -> Quat:
    """Attitude after dt seconds at a constant rate (rad/s, sensor frame).

    Ludwig (7): q' = 1/2 q ⊗ (0, ω); its exact solution over dt, or one explicit Euler step of it
    (Çoçoli 12-13).
    """
    if integration == "exponential":
        half = (rate[0] * dt / 2, rate[1] * dt / 2, rate[2] * dt / 2)
        return normalize(multiply(q, exp_half(half)))
    if integration == "first-order":
        derivative = multiply(q, (0.0, rate[0], rate[1], rate[2]))
        return normalize(
            (
                q[0] + dt * 0.5 * derivative[0],
                q[1] + dt * 0.5 * derivative[1],
                q[2] + dt * 0.5 * derivative[2],
                q[3] + dt * 0.5 * derivative[3],
            )
        )
    raise ValueError(f"integration: expected one of {INTEGRATIONS}, got {integration!r}")


class GyroIntegration(Filter):
    """Gyroscope only; accelerometer and magnetometer serve the alignment, which is the driver's."""

    realigned = False

    def __init__(self, *, integration: str = "exponential") -> None:
        self.integration = integration
        self.q = IDENTITY

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude."""
        self.q = normalize(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; acc and mag are not used."""
        self.q = gyro_step(self.q, gyr, dt, self.integration)
