"""Sensor data for the tests of the filters: still poses, smooth motion with noise, and their faults."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from ahrs_rs import simulate

Floats = NDArray[np.float64]

RATE = 100.0
GRAVITY = 9.80665
#: Inclination of the field below the horizontal, rad, as in central Europe.
DIP = math.radians(60.0)
#: Specific force at rest (m/s²) and magnetic field (µT) in east-north-up.
UP = np.array([0.0, 0.0, GRAVITY])
FIELD = 50.0 * np.array([0.0, math.cos(DIP), -math.sin(DIP)])


def multiply(p: ArrayLike, q: ArrayLike) -> Floats:
    """Hamilton product p ⊗ q of arrays (..., 4), scalar-first."""
    p, q = np.broadcast_arrays(np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64))
    w = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate((w, v), axis=-1)


def conjugate(q: ArrayLike) -> Floats:
    """The inverse of unit quaternions (..., 4)."""
    return np.asarray(q, dtype=np.float64) * [1.0, -1.0, -1.0, -1.0]


def about_z(angle: ArrayLike) -> Floats:
    """Rotations (..., 4) about the vertical by angles (...) in rad."""
    half = 0.5 * np.asarray(angle, dtype=np.float64)
    return np.stack((np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)), axis=-1)


def angle_between(p: ArrayLike, q: ArrayLike) -> Floats:
    """Angles (...) in rad between attitudes (..., 4), by 2 asin|v|: exact also where they are small."""
    error = multiply(conjugate(p), q)
    return 2.0 * np.arcsin(np.minimum(1.0, np.linalg.norm(error[..., 1:], axis=-1)))


def inclination_between(p: ArrayLike, q: ArrayLike) -> Floats:
    """Angles (...) in rad between the verticals of attitudes (..., 4), exact also where they are small."""
    error = multiply(p, conjugate(q))
    return 2.0 * np.arcsin(np.minimum(1.0, np.hypot(error[..., 1], error[..., 2])))


def quats(rotation: Rotation) -> Floats:
    """Scalar-first quaternions (..., 4)."""
    return np.asarray(rotation.as_quat(scalar_first=True))


def rotation(quat: ArrayLike) -> Rotation:
    """scipy's rotation of scalar-first quaternions (..., 4)."""
    return Rotation.from_quat(np.asarray(quat), scalar_first=True)


def turned(q: ArrayLike, vector: ArrayLike) -> Floats:
    """Quaternions (..., 4) turned by rotation vectors (..., 3) in the sensor frame."""
    return multiply(q, quats(Rotation.from_rotvec(np.asarray(vector))))


def squares(errors: Floats, covariances: Floats) -> Floats:
    """eᵀ P⁻¹ e of errors (..., n) and covariances (..., n, n)."""
    return np.asarray(np.sum(errors * np.linalg.solve(covariances, errors[..., None])[..., 0], axis=-1))


def random_turns(count: int, seed: int) -> Rotation:
    """Uniformly distributed rotations."""
    return Rotation.random(count, rng=np.random.default_rng(seed))


def turns_by(angle: float, count: int, seed: int) -> Rotation:
    """Rotations by an angle in rad about axes of every direction."""
    axis = np.random.default_rng(seed).standard_normal((count, 3))
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis, axis=1, keepdims=True))


def poses(count: int, seed: int) -> Floats:
    """The 24 attitudes of a cube and then random ones, as (24 + count, 4)."""
    return np.concatenate((quats(Rotation.create_group("O")), quats(random_turns(count, seed))))


@dataclass(frozen=True)
class Signals:
    """One recording: stamps (T,) in s, measurements (T, 3) in SI units and µT, true attitudes (T, 4)."""

    t: Floats
    gyr: Floats
    acc: Floats
    mag: Floats
    truth: Floats
    #: The true attitude one step before the first sample.
    before: Floats

    def __len__(self) -> int:
        return len(self.t)

    def sensors(self, *, nine: bool = True) -> tuple[Any, ...]:
        """gyr, acc, mag for `run`; without mag if not `nine`."""
        return (self.gyr, self.acc, self.mag if nine else None)

    def astype(self, dtype: type) -> Signals:
        """With the measurements rounded to a dtype."""
        return replace(self, gyr=self.gyr.astype(dtype), acc=self.acc.astype(dtype), mag=self.mag.astype(dtype))

    def rounded(self) -> Signals:
        """With the measurements as multiples of 2⁻²⁰, which hide that numpy's last bits depend on the processor."""
        arrays = {name: np.rint(getattr(self, name) * 2.0**20) / 2.0**20 for name in ("gyr", "acc", "mag")}
        return replace(self, **arrays)

    def turned(self, mounting: Rotation) -> Signals:
        """The same motion measured by a sensor with turned axes: a vector v becomes r v, q becomes q r*."""
        back = quats(mounting.inv())
        return Signals(
            self.t,
            *(mounting.apply(array) for array in (self.gyr, self.acc, self.mag)),
            truth=multiply(self.truth, back),
            before=multiply(self.before, back),
        )

    def without(self, **rows: Iterable[int] | slice | NDArray[Any]) -> Signals:
        """With the rows of gyr, acc or mag replaced by NaN."""
        arrays = {name: getattr(self, name).copy() for name in rows}
        for name, index in rows.items():
            arrays[name][index] = np.nan
        return replace(self, **arrays)


def motion(
    samples: int,
    seed: int,
    *,
    rate: float = RATE,
    noise: float = 1.0,
    level: bool = False,
    jitter: bool = False,
) -> Signals:
    """A turning sensor: Euler angles as sums of sines, peaks of some 5 rad/s.

    Parameters
    ----------
    noise : standard deviations in 0.05 rad/s, 0.5 m/s² and 2 µT: more than a sensor has, so that no filter's
        feedback ever vanishes (a normalised gradient close to zero turns rounding into any direction)
    level : keep roll and pitch within 30° and turn slowly, at most 1 rad/s or so, so that first-order steps
        of Euler rates do not drift to pitch 90° either; otherwise every attitude is passed
    jitter : steps between 0 and 2/rate, every tenth zero, instead of 1/rate
    """
    rng = np.random.default_rng(seed)
    steps = np.full(samples + 1, 1.0 / rate)
    if jitter:
        steps = rng.uniform(0.0, 2.0 / rate, samples + 1)
        steps[10::10] = 0.0
    times = np.cumsum(steps) - steps[0]
    largest = np.radians([30.0, 30.0, 180.0]) if level else np.radians([180.0, 180.0, 180.0])
    amplitude = rng.uniform(0.2, 1.0, (3, 3)) * largest
    amplitude *= largest / amplitude.sum(axis=0)
    frequency = 2.0 * np.pi * rng.uniform(0.05, 0.4, (3, 3)) * (0.25 if level else 1.0)
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, 3))
    angles = (amplitude * np.sin(frequency * times[:, None, None] + phase)).sum(axis=1)
    attitude = Rotation.from_euler("ZYX", angles[:, ::-1])
    dt = np.diff(times)
    turn = (attitude[:-1].inv() * attitude[1:]).as_rotvec()
    gyr = turn / np.where(dt > 0.0, dt, 1.0)[:, None]
    truth = quats(attitude)
    back = attitude[1:].inv()
    return Signals(
        t=times[1:] - steps[1:2].sum() + 5.0,
        gyr=gyr + 0.05 * noise * rng.standard_normal(gyr.shape),
        acc=back.apply(UP) + 0.5 * noise * rng.standard_normal(gyr.shape),
        mag=back.apply(FIELD) + 2.0 * noise * rng.standard_normal(gyr.shape),
        truth=truth[1:],
        before=truth[0],
    )


def disturbed(wrong: slice = slice(2400, None)) -> Signals:
    """A hand-held sensor that rests from 0 to 4 s and from 20 to 24 s, at 100 Hz for 40 s.

    It is accelerated eastwards by 8 m/s² from 10 to 15 s, and the field is wrong by 40 µT in the samples `wrong`.
    """
    r = simulate.demo(40.0, RATE, 1)
    assert r.acc is not None
    assert r.mag is not None
    assert r.ref is not None
    signals = Signals(r.t, r.gyr.copy(), r.acc.copy(), r.mag.copy(), truth=r.ref, before=r.ref[0])
    signals.acc[1000:1500] += rotation(r.ref[1000:1500]).inv().apply([8.0, 0.0, 0.0])
    signals.mag[wrong] += rotation(r.ref[wrong]).inv().apply([40.0, 0.0, 0.0])
    return signals


def gappy(signals: Signals, seed: int) -> Signals:
    """With random rows missing: 2 % of gyr, 10 % of acc, half of mag."""
    draw = np.random.default_rng(seed).random((3, len(signals)))
    return signals.without(gyr=draw[0] < 0.02, acc=draw[1] < 0.1, mag=draw[2] < 0.5)


def hostile(samples: int, seed: int) -> Signals:
    """Measurements of which a fifth of the rows hold something that is hardly a measurement."""
    rng = np.random.default_rng(seed)
    signals = motion(samples, seed, jitter=True)
    values = [np.nan, 0.0, 1e200, -1e200, 1e-170, 1e-160, 1e-154, 1e154, 5e-324, 1e100, 1e7, -3e8]
    for array in (signals.gyr, signals.acc, signals.mag):
        bad = rng.random(samples) < 0.2
        rows = rng.choice(values, (int(bad.sum()), 3))
        array[bad] = np.where(rng.random((len(rows), 3)) < 0.5, rows, array[bad])
        array[rng.random(samples) < 0.02] = 0.0
    return signals


def still(pose: ArrayLike, samples: int, *, nine: bool = True) -> dict[str, Any]:
    """Exact readings at rest in the attitudes (4,) or (N, 4), as keywords of `run`."""
    back = rotation(pose).inv()

    def held(vector: Floats) -> Floats:
        return np.repeat(back.apply(vector)[..., np.newaxis, :], samples, axis=-2)

    acc = held(UP)
    return {"gyr": np.zeros_like(acc), "acc": acc, "mag": held(FIELD) if nine else None}


def finite_and_unit(quat: np.ndarray) -> bool:
    return bool(np.abs(np.linalg.norm(quat.astype(np.float64), axis=-1) - 1.0).max() < 4 * np.finfo(quat.dtype).eps)
