"""The readings of docs/endurance.md: sensors at rest and in motion at 1 kHz, for as long as one likes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import ahrs_rs as ar
from ahrs_rs import _quat
from ahrs_rs.simulate import EulerMotion, SplineMotion, Waves, record, still

Floats = NDArray[np.float64]
Arrays = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]

SCENES = ("rest", "motion")
RATE = 1000.0
#: Steps that are computed at a time. A motion comes back to its beginning in them, so that its truth is exact for ever.
CHUNK = 100_000
#: Sensors side by side, in the lanes of the processor.
SEEDS = 8
#: Samples between two at which the error is taken.
EVERY = 100
#: Standard deviations of a sample, and of the gyroscope's constant bias: those of a consumer sensor at 1 kHz.
GYR_NOISE, ACC_NOISE, MAG_NOISE = 4.5e-3, 0.045, 0.3  # rad/s, m/s², µT
BIAS = 5e-3  # rad/s
#: The end of the rest: s of the turn on its side, and of what follows.
TURN, AFTER = 1.0, 20.0


class Readings:
    """The readings of all sensors, chunk after chunk; the same for the same chunk."""

    def __init__(self, scene: str) -> None:
        self._scene = scene
        self._exact = [_recorded(scene, seed) for seed in range(SEEDS)]
        self._draw = [SCENES.index(scene)]
        self.bias = BIAS * np.random.default_rng([*self._draw, 0]).standard_normal((SEEDS, 3))
        """(SEEDS, 3) rad/s, of the gyroscopes."""
        self.truth = np.stack([one.ref for one in self._exact])
        """(SEEDS, CHUNK, 4), the same for every chunk."""
        self._arrays = [np.stack([getattr(one, name) for one in self._exact]) for name in ("gyr", "acc", "mag")]

    def chunk(self, index: int) -> Arrays:
        """gyr, acc and mag (SEEDS, CHUNK, 3) of a chunk."""
        return self._noisy(self._arrays, index)

    def turned(self) -> tuple[Arrays, Floats]:
        """The sensors at rest turn by 90° about an axis of their own: readings and truth."""
        ends = [_on_its_side(one, seed) for seed, one in enumerate(self._exact)]
        arrays = [np.stack([getattr(one, name) for one in ends]) for name in ("gyr", "acc", "mag")]
        return self._noisy(arrays, 1 << 40), np.stack([one.ref for one in ends])

    def _noisy(self, exact: list[Floats], index: int) -> Arrays:
        draw = np.random.default_rng([*self._draw, 1, index])

        def read(values: Floats, noise: float) -> NDArray[np.float32]:
            return values.astype(np.float32) + np.float32(noise) * draw.standard_normal(values.shape, dtype=np.float32)

        gyr, acc, mag = exact
        return read(gyr + self.bias[:, None], GYR_NOISE), read(acc, ACC_NOISE), read(mag, MAG_NOISE)


def _recorded(scene: str, seed: int) -> ar.Recording:
    """One chunk of exact readings."""
    draw = np.random.default_rng([SCENES.index(scene), 2, seed])
    duration = CHUNK / RATE
    if scene == "rest":
        return record(still(*draw.uniform([-3.0, -1.2, -3.0], [3.0, 1.2, 3.0])), rate=RATE, duration=duration)
    # Whole numbers of waves in a chunk, up to 0.5 Hz of the angles and 1 Hz of the places.
    angles, places = (2.0 * np.pi / duration * draw.integers(low, high, (4, 3)) for low, high in ((5, 51), (30, 101)))
    phases = draw.uniform(0.0, 2.0 * np.pi, (2, 4, 3))
    motion = EulerMotion(
        Waves(np.radians([60.0, 35.0, 90.0]) * draw.uniform(0.3, 0.7, (4, 3)), angles, phases[0]),
        Waves(draw.uniform(0.02, 0.08, (4, 3)), places, phases[1]),
    )
    return record(motion, rate=RATE, duration=duration)


def _on_its_side(exact: ar.Recording, seed: int) -> ar.Recording:
    assert exact.ref is not None
    axis = np.random.default_rng([3, seed]).standard_normal(3)
    # Four pieces of a spline, which begins and ends at rest.
    turn = 0.125 * np.pi * axis / np.linalg.norm(axis)
    way = [exact.ref[-1]]
    for _ in range(4):
        way.append(_quat.multiply(way[-1], _quat.exp(turn)))
    return record(SplineMotion.through(way, TURN / 4.0), rate=RATE, duration=TURN + AFTER)


def observed_error(f: ar.Filter, quat: NDArray[np.floating], truth: Floats) -> Floats:
    """(SEEDS, n) ° at some samples, in what the filter observes."""
    six = f.FEEDBACK and not f.MAGNETOMETER
    error = ar.metrics.inclination_error if six else ar.metrics.total_error
    return error(quat[:, EVERY - 1 :: EVERY].astype(np.float64), truth[:, EVERY - 1 :: EVERY], degrees=True)
