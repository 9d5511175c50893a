"""Whether an attitude is lost though nothing told so: docs/losses.md, "Being wrong without having been told"."""

import math

import numpy as np

from .kalman import Array, rotation, saturated, triple
from .so3 import Quat, Vec3

GRAVITY = 9.80665
#: The time in s between two looks, and what one counts for at most.
LOOK, LONGEST_LOOK = 0.1, 0.2
#: Time constants in s of force and field, and of what is known in the long run.
FAST, SLOW = 0.5, 10.0
#: Where a force or field stops counting, in its units.
LARGEST = 16.0
#: How far the norm of a force is from one, of a field from its usual one.
GRAVITY_PART, STEADY_PART, SAME_FIELD, SHAKEN_PART = 0.1, 0.03, 0.05, 0.5
#: The deviation of a steady force.
STEADY = 0.04
#: The least tangents of inclination, and the least sine of the heading's error, that are an error.
GROSS, LARGE, SMALL, HEADING = 0.7, 0.25, 0.035, 0.17
#: How long in s each of them lasts: gross and large together, small, heading.
LASTING = (0.6, 2.5, 2.5)


def weight(time: float, constant: float) -> float:
    """Of a new value in a low-pass filter."""
    return time / (constant + time)


class Monitor:
    """What is seen in the earth frame of an estimate."""

    def __init__(self, *, starts_in_motion: bool) -> None:
        self.since_acc = self.since_mag = 0.0
        #: The long-time norm n of the field, its upward part, and the bias.
        self.norm: float | None = None
        self.up = 0.0
        self.bias = np.zeros(3)
        self.restart()
        #: A start has no credit: one gross look is enough until a force of gravity's norm agrees.
        if not starts_in_motion:
            self.lasting[0] = LASTING[0]

    def restart(self) -> None:
        """Forget what was seen, but for what is known in the long run."""
        #: F, M and S, None before the first ones.
        self.force: Array | None = None
        self.field: Array | None = None
        self.spread = 1.0
        self.lasting = np.zeros(3)

    def look(
        self,
        acc: Vec3,
        mag: Vec3 | None,
        attitude: tuple[Quat, Vec3],
        claimed: tuple[float, float],
    ) -> Vec3 | None:
        """Look at force and field by an attitude with a bias, of which these variances (rad²) are claimed.

        Where the attitude is lost, gives the bias of before.
        """
        q, bias = attitude
        r, time, self.since_acc = rotation(q), self.since_acc, 0.0
        force = r @ saturated(np.array(acc) / GRAVITY, LARGEST)
        doubted = self.lasting[0] >= LASTING[0]
        if self.force is None or doubted:
            self.force, self.spread = force, 1.0
        else:
            w = weight(time, FAST)
            self.force = self.force + w * (force - self.force)
            off = force - self.force
            self.spread += w * (float(off @ off) - self.spread)

        self.since_mag += time
        interval = self.since_mag
        seen = mag is not None and interval >= LOOK
        norm = unit = 0.0
        if mag is not None and seen:
            norm = math.hypot(*mag)
            unit = self.norm or norm
            field = r @ saturated(np.array(mag) / unit, LARGEST)
            self.field = field if self.field is None else self.field + weight(interval, FAST) * (field - self.field)
            self.since_mag = 0.0

        wrong = self._wrong(*claimed)
        off = abs(math.hypot(*self.force.tolist()) - 1.0)
        before = self.lasting[0]
        shaken = before == math.inf
        self.lasting = np.where(wrong, self.lasting + min(time, LONGEST_LOOK), 0.0)
        if doubted and off > GRAVITY_PART:
            self.lasting[0] = math.inf if off > SHAKEN_PART else before
        elif shaken or np.any(self.lasting > LASTING):
            return triple(self.bias)
        if not any(wrong):
            if seen:
                assert self.field is not None
                slow = 1.0 if self.norm is None else weight(interval, SLOW)
                self.norm = unit + slow * (min(norm, LARGEST * unit) - unit)
                self.up += slow * (float(self.field[2]) - self.up)
            self.bias = self.bias + weight(time, SLOW) * (np.array(bias) - self.bias)
        return None

    def _wrong(self, inclination: float, heading: float) -> tuple[bool, bool, bool]:
        """Whether the force is grossly or largely off, a little, or the heading alone."""
        assert self.force is not None
        across, upward = math.hypot(self.force[0], self.force[1]), float(self.force[2])
        norm = math.hypot(*self.force.tolist())

        def off(tangent: float) -> bool:
            return upward <= 0.0 or across > tangent * upward

        sigmas = 5.0 * math.sqrt(inclination)
        gravity = abs(norm - 1.0) <= GRAVITY_PART
        steady = abs(norm - 1.0) <= STEADY_PART and self.spread < STEADY**2
        gross = (gravity and off(GROSS)) or (steady and off(max(sigmas, LARGE)))
        tilted = off(max(sigmas, SMALL))
        if self.field is None or self.norm is None:
            return gross, steady and tilted, False
        east, north, up = self.field.tolist()
        small = steady and tilted and math.hypot(up - self.up, east) > across / 2
        same = abs(math.hypot(east, north, up) - 1.0) < SAME_FIELD and abs(up - self.up) < SAME_FIELD
        turned = north <= 0.0 or abs(east) > max(5.0 * math.sqrt(heading), HEADING) * math.hypot(east, north)
        return gross, small, gravity and not tilted and same and turned
