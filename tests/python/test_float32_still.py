"""In float32 a filter at rest stays where it is in float64: rounding does not add up to a turn."""

from __future__ import annotations

import numpy as np
import pytest

import ahrs_rs as ar
from signals import FIELD, UP, Floats, angle_between, inclination_between, quats, random_turns, rotation

#: Hz; samples of a piece and how many of them. Rounding that has a direction is seen in these 1,000 s: SelfCalKF was
#: off by 0.08°, six times its error in float64, and DcmImu's bias about the vertical by 1.5e-3 rad/s.
RATE, PIECE, PIECES = 1000.0, 100_000, 10
#: Recordings side by side, in attitudes of their own.
COUNT = 8
#: Noise of a sample, and the gyroscope's bias: rad/s, m/s², µT, rad/s.
GYR, ACC, MAG, BIAS = 5e-3, 0.05, 0.3, 4e-3
DEGREE = np.pi / 180.0


def at_rest(name: str, *, nine: bool) -> tuple[dict[type, ar.Estimate], Floats]:
    """The last pieces of runs over the same float32 readings in both scalars, and the attitudes (COUNT, 4)."""
    draw = np.random.default_rng(1)
    pose = quats(random_turns(COUNT, 2))
    back = rotation(pose).inv()
    exact = (BIAS * draw.standard_normal((COUNT, 3)), back.apply(UP), back.apply(FIELD))
    f = ar.FILTERS[name](rate=RATE)
    last: dict[type, ar.Estimate] = {}
    for _ in range(PIECES):
        # Drawn anew for every piece: noise that repeats has a mean.
        noise = draw.standard_normal((3, COUNT, PIECE, 3), dtype=np.float32)
        readings = [
            (one[:, None] + size * n).astype(np.float32)
            for one, size, n in zip(exact, (GYR, ACC, MAG), noise, strict=True)
        ]
        for dtype in (np.float32, np.float64):
            arrays = [array.astype(dtype, copy=False) for array in readings[: 3 if nine else 2]]
            last[dtype] = f.run(*arrays, state=last[dtype].state if dtype in last else None)
    return last, pose


@pytest.mark.parametrize(("name", "nine"), [("SelfCalKF", True), ("MEKF", True), ("Mahony", True), ("DcmImu", False)])
def test_at_rest_float32_is_as_good_as_float64(name: str, nine: bool) -> None:
    last, pose = at_rest(name, nine=nine)
    single, double = (
        np.sqrt(np.mean(np.square((angle_between if nine else inclination_between)(est.quat[:, ::10], pose[:, None]))))
        for est in (last[np.float32], last[np.float64])
    )
    # The noise of both is the same: what is left of it is 0.01 to 0.05° here. 0.1° is what a day may be off by
    # (docs/endurance.md); SelfCalKF has 0.08°.
    assert single < max(3.0 * double, 0.1 * DEGREE)


@pytest.mark.parametrize(("name", "nine"), [("DcmImu", False), ("MEKF", False)])
def test_at_rest_rounding_is_no_bias(name: str, nine: bool) -> None:
    # About the vertical six axes do not show the bias at rest. It stays what it was: 1e-4 rad/s, a tenth of what the
    # bias of a good sensor changes by in an hour, is ten times what rounding makes of MEKF's.
    last, _ = at_rest(name, nine=nine)
    single, double = (last[dtype].gyr_bias[:, -1] for dtype in (np.float32, np.float64))
    assert np.abs(single - double).max() < 1e-4
