"""The attitude that the readings since a loss show: docs/losses.md, "Finding the attitude again"."""

import math

from .gyro_integration import gyro_step
from .so3 import (
    IDENTITY,
    Quat,
    Vec3,
    multiply,
    normal,
    normalize,
    north_turn,
    rotate,
    rotate_inverse,
    shortest_to_z,
    unit,
)

GRAVITY = 9.80665
ZERO: Vec3 = (0.0, 0.0, 0.0)
#: Rate (rad/s) below which a sensor is quiet, and part by which its specific force may differ from gravity.
QUIET_RATE, QUIET_FORCE = 0.2, 0.1
#: How long (s) it has to be quiet, and after which time the mean of motion is taken.
QUIET_TIME, LONGEST_TIME = 0.25, 2.0
#: Standard deviations (rad) of what is found in motion and at rest.
MOTION_ERROR, QUIET_ERROR = 0.0765, 0.01
#: What a reading of a quiet sensor counts, and the longest time (s) for which one does.
QUIET_WEIGHT, LONGEST_INTERVAL = 50.0, 0.1


class Recovery:
    """Sums of the readings since the end of a loss, in the sensor frame of that time."""

    def __init__(self) -> None:
        #: The variance (rad²) of what was lost; zero where nothing was.
        self.unknown = 0.0
        self._restart()

    def _restart(self) -> None:
        self.since = self.quiet_for = 0.0
        self.turn: Quat = IDENTITY
        self.force = self.field = ZERO

    @property
    def active(self) -> bool:
        """Whether it goes on."""
        return self.unknown > 0.0

    @property
    def quiet(self) -> bool:
        """Whether the sensor has been quiet."""
        return self.quiet_for >= QUIET_TIME

    @property
    def over(self) -> bool:
        """Whether the longest time is over."""
        return self.since >= LONGEST_TIME

    @property
    def surer(self) -> bool:
        """Whether the mean of motion is surer than what is known."""
        return self.unknown > MOTION_ERROR**2

    @property
    def variance(self) -> float:
        """Of the attitude that is found (rad²)."""
        return (QUIET_ERROR if self.quiet else MOTION_ERROR) ** 2

    def lose(self, variance: float) -> None:
        """A rotation that counts was lost: what was measured before it says nothing any more."""
        self.unknown = max(self.unknown, variance)
        self._restart()

    def end(self) -> None:
        """The attitude is known."""
        self.unknown = 0.0

    def take(self, rate: Vec3, force: tuple[Vec3 | None, float], field: tuple[Vec3 | None, float], dt: float) -> None:
        """A sample: rate without bias (rad/s), force and field with the times (s) that they stand for."""
        self.turn = gyro_step(self.turn, rate, dt, "exponential")
        acc, mag = force[0], field[0]
        level = acc is None or abs(math.hypot(*acc) / GRAVITY - 1.0) <= QUIET_FORCE
        quiet = math.hypot(*rate) < QUIET_RATE and level
        weight = QUIET_WEIGHT if quiet else 1.0
        if acc is not None:
            self.force = self._sum(self.force, acc, weight * min(force[1], LONGEST_INTERVAL))
        if mag is not None:
            self.field = self._sum(self.field, unit(mag), weight * min(field[1], LONGEST_INTERVAL))
        if normal(self.force):
            self.since += dt
            self.quiet_for = self.quiet_for + dt if quiet else 0.0

    def _sum(self, total: Vec3, seen: Vec3, weight: float) -> Vec3:
        x, y, z = rotate(self.turn, seen)
        return (total[0] + weight * x, total[1] + weight * y, total[2] + weight * z)

    def aligned(self, q: Quat, follows_field: bool) -> tuple[Quat, bool]:
        """An attitude by the rule of the start, and whether a field gave its heading."""
        up = unit(rotate_inverse(self.turn, self.force))
        q = normalize(multiply(shortest_to_z(rotate(q, up)), q))
        if not (follows_field and normal(self.field)):
            return q, False
        turn = north_turn(rotate(q, rotate_inverse(self.turn, self.field)))
        return (q, False) if turn is None else (normalize(multiply(turn, q)), True)
