"""Attitudes between samples."""

from __future__ import annotations

import numpy as np

from ahrs_rs import _quat
from ahrs_rs._typing import FloatArray


class Attitudes:
    """Attitudes over time, interpolated along the shortest rotations between samples."""

    def __init__(self, quat: FloatArray, t: FloatArray) -> None:
        self.quat, self.t = quat, t
        self.turns = _quat.log(_quat.multiply(_quat.conjugate(quat[:-1]), quat[1:]))
        step = np.diff(t)
        self.step = np.where(step > 0.0, step, np.inf)

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Attitudes (n, 4), NaN outside of the samples, and angular rates (n, 3) in the sensor frame, rad/s."""
        index = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 2)
        part = (times - self.t[index]) / self.step[index]
        turn = self.turns[index]
        quat = _quat.multiply(self.quat[index], _quat.exp(part[:, np.newaxis] * turn))
        quat[(times < self.t[0]) | (times > self.t[-1])] = np.nan
        return quat, turn / self.step[index, np.newaxis]
