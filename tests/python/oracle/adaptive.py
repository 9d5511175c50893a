"""The adaptive gain of Valenti et al., Sensors 15(8), 2015, with one threshold in m/s² and twice as much."""

import math

from .so3 import Vec3

GRAVITY = 9.80665
ACC_REJECTED = 8


def acc_share(acc: Vec3 | None, threshold: float) -> float:
    """Share of the accelerometer's gain: 1 up to the threshold, 0 from its double on, linear between."""
    if acc is None or threshold == 0:
        return 1.0
    deviation = abs(math.hypot(*acc) - GRAVITY)
    if deviation <= threshold:
        return 1.0
    if deviation >= 2 * threshold:
        return 0.0
    return (2 * threshold - deviation) / threshold
