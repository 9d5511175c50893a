"""Two segments and a joint between them, with a sensor on each: exact readings of motions in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from signals import UP, quats

Floats = NDArray[np.float64]
Angles = Callable[[Floats], Floats]

#: Steps of the differences for angular rates and accelerations, s: their errors are about 1e-7 rad/s and 1e-5 m/s².
TURN, PATH = 1e-4, 1e-3


def waves(seed: int, size: float, slowest: float = 0.2, fastest: float = 1.0, channels: int = 3) -> Angles:
    """Angles (T, channels) that go to and fro by sums of four sines of 0.2 to 1 Hz."""
    rng = np.random.default_rng(seed)
    hertz = rng.uniform(slowest, fastest, (4, channels))
    phases = rng.uniform(0.0, 2.0 * np.pi, (4, channels))
    sizes = size * rng.uniform(0.3, 0.7, (4, channels))
    return lambda t: np.sum(sizes * np.sin(2.0 * np.pi * hertz * t[:, np.newaxis, np.newaxis] + phases), axis=1)


@dataclass(frozen=True)
class Chain:
    """Segments whose frames are one where the angles of the joint are zero."""

    sequence: str
    """Of the joint's angles, as scipy has it; the second segment against the first."""
    angles: Angles
    body: Angles = field(default_factory=lambda: waves(1, 0.5))
    """Rotation vector of the first segment."""
    path: Angles = field(default_factory=lambda: waves(2, 0.1))
    """Of the joint, m."""
    mounts: tuple[Rotation, Rotation] = (
        Rotation.from_rotvec([0.3, -1.1, 2.0]),
        Rotation.from_rotvec([-0.7, 0.9, 0.4]),
    )
    """From each sensor's frame to its segment's."""
    levers: tuple[ArrayLike, ArrayLike] = ((0.1, 0.02, -0.2), (-0.03, 0.05, 0.15))
    """From the joint to the sensors, in the frames of the segments, m."""

    def segments(self, t: Floats) -> tuple[Rotation, Rotation]:
        first = Rotation.from_rotvec(self.body(t))
        return first, first * Rotation.from_euler(self.sequence, self.angles(t))

    def sensors(self, t: Floats) -> tuple[Rotation, Rotation]:
        return tuple(one * mount for one, mount in zip(self.segments(t), self.mounts, strict=True))  # type: ignore[return-value]

    def quats(self, t: Floats) -> tuple[Floats, Floats]:
        """Attitudes of the sensors, sensor to earth."""
        first, second = self.sensors(t)
        return quats(first), quats(second)

    def gyr(self, t: Floats) -> tuple[Floats, Floats]:
        """Angular rates at the instants, rad/s."""
        before, after = self.sensors(t - TURN), self.sensors(t + TURN)
        return tuple((a.inv() * b).as_rotvec() / (2.0 * TURN) for a, b in zip(before, after, strict=True))  # type: ignore[return-value]

    def acc(self, t: Floats) -> tuple[Floats, Floats]:
        """Specific forces, m/s²."""
        found = []
        for k in range(2):
            places = [self.path(s) + self.segments(s)[k].apply(self.levers[k]) for s in (t - PATH, t, t + PATH)]
            acceleration = (places[0] - 2.0 * places[1] + places[2]) / PATH**2
            found.append(self.sensors(t)[k].inv().apply(acceleration + UP))
        return found[0], found[1]

    def axis(self, sensor: int, of_segment: ArrayLike) -> Floats:
        """A direction of a segment in the frame of its sensor."""
        return np.asarray(self.mounts[sensor].inv().apply(of_segment))
