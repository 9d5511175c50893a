"""How much of a rotation no step shows: docs/losses.md, "What a step does not show"."""

import math
from typing import NamedTuple

from .intake import SHORTENING
from .so3 import Vec3, squared_norm

#: A step of more usual ones than this is a gap.
GAP = 4.0
#: An axis is at the end of the gyroscope's range from this part of it on.
AT_RANGE = 0.995
#: The largest rate that counts, and the least deviation of an unknown one (rad/s).
LARGEST_RATE, LEAST_DEVIATION = 100.0, 2.0
#: The least standard deviation (rad) of a loss that counts.
COUNTING = math.radians(1.0)
#: Twice the time in s that a rate lasts.
RATE_TIME = 0.4


class Loss(NamedTuple):
    """Of a step: whether it is a gap, whether anything is lost, and the variance (rad²) in this step and so far."""

    gap: bool
    lost: bool
    added: float
    total: float

    @property
    def counts(self) -> bool:
        """Whether the attitude has to be found again."""
        return self.lost and self.total >= COUNTING**2


class Losses:
    """The usual step, the largest rate, and the loss that goes on."""

    def __init__(self, gyr_range: float) -> None:
        self.gyr_range = gyr_range
        #: The longest usual step s, and the largest rate ω_max.
        self.longest = self.largest = 0.0
        #: How long the loss goes on, and its variance.
        self.time = self.variance = 0.0

    def within_range(self, rate: Vec3) -> bool:
        """Whether no axis is at the end of the range."""
        return self.gyr_range == 0.0 or max(map(abs, rate)) < AT_RANGE * self.gyr_range

    def step(self, row: Vec3 | None, dt: float) -> Loss:
        """Go on by dt with a row of the gyroscope, None where its rate is not known."""
        if row is not None:
            self.largest = max(self.largest, min(squared_norm(row) ** 0.5, LARGEST_RATE))
        usual = self.longest
        gap = usual > 0.0 and dt > GAP * usual
        if dt > 0.0:
            self.longest = 2.0 * usual if gap else max(dt, SHORTENING * usual)
        lost = dt if row is None else dt - usual if gap else 0.0
        if lost == 0.0:
            self.time = self.variance = 0.0
            return Loss(gap, False, 0.0, 0.0)
        self.time += lost
        sigma = max(LEAST_DEVIATION, self.largest / 2) * self.time * min(1.0, self.time / RATE_TIME)
        added = max(sigma**2 - self.variance, 0.0)
        self.variance = sigma**2
        return Loss(gap, True, added, self.variance)
