"""What a row of a sensor stands for: the time since its last one, or nothing where it repeats that one."""

from .so3 import Vec3

#: An interval of more usual ones than this is an outage.
OUTAGE = 4.0
#: What is left of a usual interval, or step, after each one.
SHORTENING = 63.0 / 64.0
#: The longest time in s that a measurement stands for, unless its own step is longer.
LONGEST = 1.0
#: How long in s a row may be repeated.
LONGEST_REPEAT = 1.0


class Interval:
    """Of a sensor that may be slower than the gyroscope."""

    def __init__(self) -> None:
        #: The time since the last measurement; None before the first.
        self.waited: float | None = None
        #: The usual interval u; None where it is not known.
        self.usual: float | None = None

    def step(self, dt: float, longest: float, present: bool) -> float:
        """Go on by dt to a measurement, if there is one; `longest` is the longest usual step before.

        Gives the time that a measurement stands for.
        """
        if self.waited is None:
            self.waited = 0.0 if present else None
            return dt
        since = self.waited + dt
        if not present:
            self.waited = since
            return dt
        at_once, self.waited = self.waited == 0.0, 0.0
        at_least = max(self.usual or 0.0, longest, dt)
        if self.usual is not None and since > OUTAGE * at_least:
            self.usual, since = 2.0 * at_least, at_least
        elif at_once:
            self.usual = max(self.usual or 0.0, 0.0)
        else:
            self.usual = since if self.usual is None else max(since, SHORTENING * self.usual)
        return min(since, max(LONGEST, dt))


class Repeats:
    """Of a sensor whose rows may be those of before."""

    def __init__(self) -> None:
        self.last: Vec3 | None = None
        #: How long the last valid row has been the last one, in s.
        self.time = 0.0

    def step(self, row: Vec3 | None, dt: float) -> bool:
        """Go on by dt to a row, None where it is no measurement: whether it repeats the last one, and not for long."""
        same = row is not None and row == self.last
        self.time = self.time + dt if same or row is None else 0.0
        self.last = self.last if row is None else row
        return same and self.time <= LONGEST_REPEAT
