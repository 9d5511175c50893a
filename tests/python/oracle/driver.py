"""What every filter shares: time, missing data, alignment, earth frames and the sign of the output.

Inside, the earth frame is ENU, its y axis on magnetic north as soon as a magnetometer sample has been used.
"""

import math
import sys
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .so3 import (
    IDENTITY,
    Quat,
    Vec3,
    about_z,
    conjugate,
    multiply,
    normalize,
    north_turn,
    rotate,
    shortest_to_z,
    squared_norm,
    unit,
)

ACC_MISSING = 1
MAG_MISSING = 2
GYR_HELD = 4
NOT_ALIGNED = 64

# Largest |ω| dt / 2 (rad) in double precision, and the longest time step (s).
ANGLE_RANGE = 1e6
MAX_DT = 1e6

# What a filter may report beside attitude and bias, if it has no such list of its own.
OUTPUTS = ("covariance", "innovation", "nis")

# output = c ⊗ q, from the internal ENU to the frame asked for
FRAMES: dict[str, Quat] = {
    "ENU": (1.0, 0.0, 0.0, 0.0),
    "NED": (0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0),
    "NWU": (math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5)),
}


class OracleFilter(Protocol):
    """What the driver needs of a filter.

    Attributes that it may have: `bias`, those of `OUTPUTS` and what a method `outputs` gives are reported after every
    sample, `flags` are the status bits of its last step. If `starts_itself` is true it takes its start from the first
    measurements, with the time step of the rate, and from a given attitude by `start_from`.
    """

    @property
    def q(self) -> Quat:
        """Attitude, sensor to internal ENU."""

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; everything else in the filter stays as it is."""

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float) -> None:
        """One sample: angular rate (rad/s), specific force or None, magnetic field or None, time step (s)."""


@dataclass(frozen=True)
class OracleResult:
    """Attitudes (T, 4), gyroscope biases (T, 3) in rad/s or None, status bits (T,) as uint8, outputs (T, ...)."""

    quat: NDArray[np.float64]
    gyr_bias: NDArray[np.float64] | None
    status: NDArray[np.uint16]
    extra: dict[str, NDArray[np.float64]]


def measured(v: Vec3 | None) -> bool:
    """Whether a vector is a measurement: its squared norm is finite and a normal number."""
    return v is not None and sys.float_info.min <= squared_norm(v) < math.inf


class Driver:
    """One filter over a stream of samples."""

    def __init__(
        self,
        filter_: OracleFilter,
        q0: Quat | None,
        frame: str,
        declination: float,
        gyr_hold: str,
    ) -> None:
        self.filter = filter_
        self.frame_turn = FRAMES[frame]
        self.declination = declination
        self.gyr_hold = gyr_hold
        self.started = False
        self.last_rate: Vec3 = (0.0, 0.0, 0.0)
        self.last_output: Quat | None = None
        self.inclined = self.heading_set = q0 is not None
        self.magnetic = False
        self.starts_itself = starts_itself(filter_)
        if q0 is None:
            self.filter.set_attitude(IDENTITY)
        else:
            start = getattr(self.filter, "start_from", self.filter.set_attitude)
            start(normalize(multiply(conjugate(self.frame_turn), q0)))

    def feed(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float) -> tuple[Quat, int]:
        """One sample, acc or mag None where the array is not given at all; returns output and status."""
        status = 0
        dt = min(dt, MAX_DT)
        acc_ok = measured(acc)
        mag_ok = measured(mag)
        if acc is not None and not acc_ok:
            status |= ACC_MISSING
        if mag is not None and not mag_ok:
            status |= MAG_MISSING

        previous_rate = self.last_rate
        measured_rate = self._in_range(gyr, dt)
        rate = gyr if measured_rate else previous_rate
        self.last_rate = rate
        if self.gyr_hold == "linear" and self.started:
            rate = (
                (previous_rate[0] + rate[0]) / 2,
                (previous_rate[1] + rate[1]) / 2,
                (previous_rate[2] + rate[2]) / 2,
            )
        # A rate too large for this step is left out of it, and kept for the next one.
        turned = self._in_range(rate, dt)
        if not (measured_rate and turned):
            status |= GYR_HELD
        if not turned:
            rate = (0.0, 0.0, 0.0)
        self.started = True

        # A given q0 is relative to true north; the magnetometer knows magnetic north.
        if mag_ok and self.inclined and self.heading_set and not self.magnetic:
            self.filter.set_attitude(multiply(about_z(self.declination), self.filter.q))
            self.magnetic = True

        use_acc, use_mag = self.inclined, self.heading_set
        if self.starts_itself:
            use_acc, use_mag = True, self.inclined or acc_ok
        self.filter.step(rate, acc if acc_ok and use_acc else None, mag if mag_ok and use_mag else None, dt)
        status |= getattr(self.filter, "flags", 0)

        if acc is not None and acc_ok and not self.inclined:
            q = self.filter.q
            if not self.starts_itself:
                self.filter.set_attitude(multiply(shortest_to_z(rotate(q, unit(acc))), q))
            self.inclined = True
        if mag is not None and mag_ok and self.inclined and not self.heading_set:
            q = self.filter.q
            turn = north_turn(rotate(q, unit(mag)))
            if turn is not None:
                if not self.starts_itself:
                    self.filter.set_attitude(multiply(turn, q))
                self.heading_set = self.magnetic = True
        if not self.inclined:
            status |= NOT_ALIGNED
        return self._output(), status

    @staticmethod
    def _in_range(rate: Vec3, dt: float) -> bool:
        """Whether the rate is a number and turns by no more than ANGLE_RANGE (half angle, rad) within dt."""
        return squared_norm(rate) < math.inf and math.hypot(*rate) * dt / 2 <= ANGLE_RANGE

    def _output(self) -> Quat:
        """Attitude in the frame asked for, of the two signs the one that continues the previous output."""
        q = self.filter.q
        if self.magnetic:
            q = multiply(about_z(-self.declination), q)
        q = multiply(self.frame_turn, q)
        reference = self.last_output or IDENTITY
        if sum(a * b for a, b in zip(q, reference, strict=True)) < 0.0:
            q = (-q[0], -q[1], -q[2], -q[3])
        self.last_output = q
        return q


def starts_itself(filter_: OracleFilter) -> bool:
    """Whether the first sample is a step like any other."""
    return bool(getattr(filter_, "starts_itself", False))


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
    filter_: OracleFilter,
    gyr: ArrayLike,
    acc: ArrayLike | None,
    mag: ArrayLike | None,
    *,
    t: ArrayLike | None,
    rate: float | None,
    q0: ArrayLike | None,
    frame: str,
    declination: float,
    gyr_hold: str,
) -> OracleResult:
    """Run a filter over one recording; shapes and units as in `oracle.run`."""
    if frame not in FRAMES:
        raise ValueError(f"frame: expected one of {sorted(FRAMES)}, got {frame!r}")
    if gyr_hold not in ("zero-order", "linear"):
        raise ValueError(f"gyr_hold: expected 'zero-order' or 'linear', got {gyr_hold!r}")
    n = len(np.asarray(gyr))
    start: Quat | None = None
    if q0 is not None:
        w, x, y, z = np.asarray(q0, dtype=np.float64).tolist()
        start = (w, x, y, z)
    driver = Driver(filter_, start, frame, declination, gyr_hold)
    steps = time_steps(n, t, rate, q0 is not None, starts_itself(filter_))
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
