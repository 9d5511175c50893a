"""What every filter shares: time, missing data, alignment, earth frames, losses and the sign of the output.

Inside, the earth frame is ENU, its y axis on magnetic north as soon as a magnetometer sample has been used. What is
lost, and how it comes back, are the rules of docs/losses.md.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .base import Filter, Told
from .gyro_integration import gyro_step
from .intake import Interval, Repeats
from .losses import Losses
from .monitor import LOOK, Monitor
from .recovery import ZERO, Recovery
from .so3 import (
    IDENTITY,
    Quat,
    Vec3,
    about_z,
    conjugate,
    multiply,
    normal,
    normalize,
    north_turn,
    rotate,
    rotation_vector,
    shortest_to_z,
    squared_norm,
    unit,
)

ACC_MISSING = 1
MAG_MISSING = 2
GYR_HELD = 4
NOT_ALIGNED = 64
RECOVERING = 128
GAP = 256
REPEATED = 512

# Largest |ω| dt / 2 (rad) in double precision, and the longest time step (s).
ANGLE_RANGE = 1e6
MAX_DT = 1e6

#: Variance (rad²) of an attitude that is lost without having been told.
UNKNOWN = math.pi**2 / 3
#: Angles (rad) within which an attitude is left as it is: in motion, and of a filter that knows how sure it is.
NEAR, NEAR_BY_ITSELF = 2.0 * 0.0765, math.radians(20.0)
#: The attitude of a roll by 180° in NED, seen from east-north-up.
UPSIDE_DOWN: Quat = (0.0, 0.0, 1.0, 0.0)

# What a filter may report beside attitude and bias, if it has no such list of its own.
OUTPUTS = ("covariance", "innovation", "nis")

# output = c ⊗ q, from the internal ENU to the frame asked for
FRAMES: dict[str, Quat] = {
    "ENU": (1.0, 0.0, 0.0, 0.0),
    "NED": (0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0),
    "NWU": (math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5)),
}


@dataclass(frozen=True)
class OracleResult:
    """Attitudes (T, 4), gyroscope biases (T, 3) in rad/s or None, status bits (T,) as uint16, outputs (T, ...)."""

    quat: NDArray[np.float64]
    gyr_bias: NDArray[np.float64] | None
    status: NDArray[np.uint16]
    extra: dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Settings:
    """What the user chooses beside a filter's own parameters."""

    frame: str = "ENU"
    declination: float = 0.0
    gyr_hold: str = "zero-order"
    repeated: str = "new"
    gyr_range: float = 0.0

    def __post_init__(self) -> None:
        for name, known in (
            ("frame", sorted(FRAMES)),
            ("gyr_hold", ["zero-order", "linear"]),
            ("repeated", ["new", "missing"]),
        ):
            if getattr(self, name) not in known:
                raise ValueError(f"{name}: expected one of {known}, got {getattr(self, name)!r}")


class Sensor:
    """Accelerometer or magnetometer: what its rows stand for, and the bit that is set where one is no measurement."""

    def __init__(self, missing: int) -> None:
        self.missing = missing
        self.repeats, self.interval = Repeats(), Interval()


class Driver:
    """One filter over a stream of samples."""

    def __init__(self, filter_: Filter, q0: Quat | None, settings: Settings) -> None:
        self.filter = filter_
        self.settings = settings
        self.frame_turn = FRAMES[settings.frame]
        self.started = False
        self.last_rate: Vec3 = ZERO
        self.last_output: Quat | None = None
        self.inclined = self.heading_set = q0 is not None
        self.magnetic = False
        self.acc, self.mag = Sensor(ACC_MISSING), Sensor(MAG_MISSING)
        self.losses = Losses(settings.gyr_range)
        self.recovery, self.monitor = Recovery(), Monitor(starts_in_motion=self.filter.starts_in_motion)
        if q0 is None:
            # Level, with the heading 0, in the frame of the output.
            self.filter.set_attitude(conjugate(self.frame_turn))
        else:
            self.filter.start_from(normalize(multiply(conjugate(self.frame_turn), q0)))

    def feed(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float) -> tuple[Quat, int]:
        """One sample, acc or mag None where the array is not given at all; returns output and status."""
        dt = min(dt, MAX_DT)
        moves = self.started and gyr != self.last_rate
        longest = self.losses.longest
        acc, acc_interval, acc_status = self._row(self.acc, acc, moves, longest, dt)
        mag, mag_interval, mag_status = self._row(self.mag, mag, moves, longest, dt)
        status = acc_status | mag_status

        rate, held = self._rate(gyr, dt)
        status |= GYR_HELD if held else 0
        self._turn_frame(acc, mag)
        used = self._used(acc, mag)
        told = Told(acc_interval if used[0] else dt, mag_interval if used[1] else dt)

        loss = self.losses.step(None if held or not self.losses.within_range(rate) else gyr, dt)
        status |= GAP if loss.gap else 0
        if loss.lost:
            if self.filter.has_covariance:
                self.filter.lose_rotation(loss.added)
            if self.filter.realigned and self.inclined and loss.counts:
                self.recovery.lose(loss.total)
        if self.filter.watched:
            self._watch(rate, used, dt)
        recovering = self.recovery.active
        if recovering:
            # What hides little turns by the rate that is held.
            self._recover(rate, used, told, dt, loss.counts)

        # The alignment may have taken the heading away.
        used = self._used(acc, mag)
        intervals = acc_interval if used[0] else dt, mag_interval if used[1] else dt
        told = Told(*intervals, loss.lost, recovering, max(longest, dt))
        self.filter.step(rate, *used, dt, told)
        self.started = True
        self._align(acc, mag)
        status |= self.filter.flags
        status |= RECOVERING if self.recovery.active else 0
        status |= 0 if self.inclined else NOT_ALIGNED
        return self._output(), status

    def _row(
        self, sensor: Sensor, row: Vec3 | None, moves: bool, longest: float, dt: float
    ) -> tuple[Vec3 | None, float, int]:
        """A sensor's measurement, if its row is one, the time for which it stands, and status bits."""
        if row is None:
            return None, dt, 0
        value, status = row if normal(row) else None, 0
        if self.settings.repeated == "missing" and sensor.repeats.step(value, dt) and moves:
            value, status = None, REPEATED
        interval = sensor.interval.step(dt, longest, value is not None)
        return value, interval, status | (sensor.missing if value is None else 0)

    def _rate(self, gyr: Vec3, dt: float) -> tuple[Vec3, bool]:
        """The angular rate of the step, and whether it is not the measured one."""
        previous = self.last_rate
        measured_rate = in_range(gyr, dt)
        rate = self.last_rate = gyr if measured_rate else previous
        if self.settings.gyr_hold == "linear" and self.started:
            rate = ((previous[0] + rate[0]) / 2, (previous[1] + rate[1]) / 2, (previous[2] + rate[2]) / 2)
        # A rate too large for this step is left out of it, and kept for the next one.
        turned = in_range(rate, dt)
        return rate if turned else ZERO, not (measured_rate and turned)

    def _turn_frame(self, acc: Vec3 | None, mag: Vec3 | None) -> None:
        """What the first measurements say of the frame in which the attitude stands."""
        # A given q0 is relative to true north; the magnetometer knows magnetic north.
        if mag is not None and self.inclined and self.heading_set and not self.magnetic:
            self.filter.set_attitude(multiply(about_z(self.settings.declination), self.filter.q))
            self.magnetic = True
        # Level in NED is rolled over in ENU.
        if self.settings.frame == "NED" and acc is not None and not self.inclined:
            q = self.filter.q
            if rotate(q, unit(acc))[2] < 0.0:
                self.filter.set_attitude(multiply(UPSIDE_DOWN, q))

    def _used(self, acc: Vec3 | None, mag: Vec3 | None) -> tuple[Vec3 | None, Vec3 | None]:
        """What the filter is given: what aligns it is no measurement, unless it starts by itself."""
        if self.filter.starts_itself:
            return acc, mag if self.inclined or acc is not None else None
        return acc if self.inclined else None, mag if self.heading_set else None

    def _bias(self) -> Vec3:
        bias: Vec3 = getattr(self.filter, "bias", ZERO)
        return bias

    def _watch(self, rate: Vec3, used: tuple[Vec3 | None, Vec3 | None], dt: float) -> None:
        """Look, ten times a second, whether the attitude is lost."""
        self.monitor.since_acc += dt
        acc, mag = used
        if acc is None or not self.inclined or self.monitor.since_acc < LOOK:
            return
        if self.recovery.active:
            self.monitor.restart()
            return
        bias = self._bias()
        turning = minus(rate, bias)
        q = gyro_step(self.filter.q, turning, dt, "exponential")
        if mag is not None:
            # A field of before is off by as much as the sensor has turned since.
            mag = rotate(gyro_step(IDENTITY, turning, -self.filter.known_mag_delay(), "exponential"), mag)
        field = mag if self.filter.follows_field else None
        lost = self.monitor.look(acc, field, (q, bias), self.filter.claimed())
        if lost is not None:
            self.monitor.restart()
            self.filter.reopen(lost)
            self.recovery.lose(UNKNOWN)

    def _recover(self, rate: Vec3, used: tuple[Vec3 | None, Vec3 | None], told: Told, dt: float, lost: bool) -> None:
        """Align the attitude where there are enough readings; else take this one, if no loss that counts goes on."""
        recovery, filter_ = self.recovery, self.filter
        if recovery.quiet or recovery.over:
            q = filter_.q
            found, headed = recovery.aligned(q, filter_.follows_field)
            far = angle(q, found) > (NEAR_BY_ITSELF if filter_.has_covariance else NEAR)
            sure = recovery.quiet and (recovery.surer or not filter_.has_covariance)
            sets = sure or (far and (recovery.quiet or recovery.surer))
            if sets:
                if filter_.follows_field and self.magnetic and not headed:
                    self.heading_set = False
                filter_.realign(found)
                if filter_.has_covariance:
                    filter_.lose_rotation(recovery.variance)
            recovery.end()
        elif not lost:
            recovery.take(minus(rate, self._bias()), (used[0], told.acc_interval), (used[1], told.mag_interval), dt)

    def _align(self, acc: Vec3 | None, mag: Vec3 | None) -> None:
        """Inclination and heading by the first measurements of them."""
        itself = self.filter.starts_itself
        if acc is not None and not self.inclined:
            q = self.filter.q
            if not itself:
                self.filter.set_attitude(multiply(shortest_to_z(rotate(q, unit(acc))), q))
            self.inclined = True
        if mag is not None and self.inclined and not self.heading_set:
            q = self.filter.q
            turn = north_turn(rotate(q, unit(mag)))
            if turn is not None:
                if not itself:
                    self.filter.set_attitude(multiply(turn, q))
                self.heading_set = self.magnetic = True

    def _output(self) -> Quat:
        """Attitude in the frame asked for, of the two signs the one that continues the previous output."""
        q = self.filter.q
        if self.magnetic:
            q = multiply(about_z(-self.settings.declination), q)
        q = multiply(self.frame_turn, q)
        reference = self.last_output or IDENTITY
        if sum(a * b for a, b in zip(q, reference, strict=True)) < 0.0:
            q = (-q[0], -q[1], -q[2], -q[3])
        self.last_output = q
        return q


def in_range(rate: Vec3, dt: float) -> bool:
    """Whether a rate is a number and turns by no more than ANGLE_RANGE (half angle, rad) within dt."""
    return squared_norm(rate) < math.inf and math.hypot(*rate) * dt / 2 <= ANGLE_RANGE


def minus(a: Vec3, b: Vec3) -> Vec3:
    """Difference of two vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def angle(p: Quat, q: Quat) -> float:
    """Angle (rad) between two attitudes."""
    return math.hypot(*rotation_vector(multiply(conjugate(p), q)))


def time_steps(n: int, t: ArrayLike | None, rate: float | None, q0_given: bool, starts: bool) -> list[float]:
    """Time step of every sample in s; that of sample 0 is zero unless a q0, one step before it, is given."""
    if t is not None:
        times = np.asarray(t, dtype=np.float64)
        if times.shape != (n,):
            raise ValueError(f"t: expected shape ({n},), got {times.shape}")
        later = np.diff(times)
        if not np.all(later >= 0.0):
            index = int(np.argmin(later >= 0.0)) + 1
            raise ValueError(f"t: expected not decreasing, decreases at index {index}")
    elif rate is not None:
        later = np.full(max(n - 1, 0), 1.0 / rate)
    else:
        raise ValueError("rate: expected rate or t, got neither")
    first = 0.0
    if (q0_given or starts) and rate is not None:
        first = 1.0 / rate
    elif q0_given and n > 1:  # one sample and its time alone tell no step
        first = float(later[0])
    return [first, *later.tolist()]


def rows(name: str, array: ArrayLike | None, n: int) -> list[Any]:
    """The n rows of an array as tuples of floats; n times None if there is no array."""
    if array is None:
        return [None] * n
    values = np.asarray(array, dtype=np.float64)
    if values.shape != (n, 3):
        raise ValueError(f"{name}: expected shape ({n}, 3), got {values.shape}")
    if np.isinf(values).any():
        raise ValueError(f"{name}: expected finite values or NaN, got an infinite one")
    return [tuple(row) for row in values.tolist()]


def drive(
    filter_: Filter,
    gyr: ArrayLike,
    acc: ArrayLike | None,
    mag: ArrayLike | None,
    *,
    t: ArrayLike | None,
    rate: float | None,
    q0: ArrayLike | None,
    settings: Settings,
) -> OracleResult:
    """Run a filter over one recording; shapes and units as in `oracle.run`."""
    n = len(np.asarray(gyr))
    start: Quat | None = None
    if q0 is not None:
        w, x, y, z = np.asarray(q0, dtype=np.float64).tolist()
        start = (w, x, y, z)
    driver = Driver(filter_, start, settings)
    steps = time_steps(n, t, rate, q0 is not None, filter_.starts_itself)
    samples = zip(rows("gyr", gyr, n), rows("acc", acc, n), rows("mag", mag, n), steps[:n], strict=True)

    quat = np.empty((n, 4))
    bias = np.empty((n, 3)) if hasattr(filter_, "bias") else None
    status = np.empty(n, dtype=np.uint16)
    extra: dict[str, list[Any]] = {name: [] for name in getattr(filter_, "OUTPUTS", OUTPUTS) if hasattr(filter_, name)}
    further: dict[str, list[float]] = {}
    for k, (w_k, a_k, m_k, dt) in enumerate(samples):
        quat[k], status[k] = driver.feed(w_k, a_k, m_k, dt)
        if bias is not None:
            bias[k] = getattr(filter_, "bias", None)
        for name, reported in extra.items():
            reported.append(np.copy(getattr(filter_, name)))
        for name, value in filter_.outputs().items() if hasattr(filter_, "outputs") else ():
            further.setdefault(name, []).append(value)
    return OracleResult(quat, bias, status, {name: np.array(values) for name, values in (extra | further).items()})
