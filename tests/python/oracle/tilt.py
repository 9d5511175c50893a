"""Attitude from the vector measurements alone: inclination (Tilt), inclination and heading (Ecompass)."""

from .base import Filter, Told
from .gyro_integration import gyro_step
from .so3 import IDENTITY, Quat, Vec3, multiply, normalize, north_turn, rotate, shortest_to_z, unit


class Tilt(Filter):
    """Measured up is up: at every valid accelerometer sample the shortest turn that makes it so."""

    realigned = False

    def __init__(self) -> None:
        self.q = IDENTITY

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude."""
        self.q = normalize(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; the gyroscope is used only where there is no accelerometer sample, mag is not used."""
        self._level(gyr, acc, dt)

    def _level(self, gyr: Vec3, acc: Vec3 | None, dt: float) -> None:
        if acc is None:
            self.q = gyro_step(self.q, gyr, dt, "exponential")
        else:
            up = rotate(self.q, unit(acc))
            self.q = normalize(multiply(shortest_to_z(up), self.q))


class Ecompass(Tilt):
    """As Tilt, then at every valid magnetometer sample the turn about z that puts the field over north."""

    follows_field = True

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample; the gyroscope is used only where there is no accelerometer sample."""
        self._level(gyr, acc, dt)
        if mag is not None:
            turn = north_turn(rotate(self.q, unit(mag)))
            if turn is not None:
                self.q = normalize(multiply(turn, self.q))
