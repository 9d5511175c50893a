"""Rotations of all sizes, and how far quaternions are from scipy's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from signals import quats

Floats = NDArray[Any]

#: Largest difference from scipy: some ten rounding errors of numbers up to π.
BOUNDS = {np.float64: 1e-13, np.float32: 1e-6}
DTYPES = pytest.mark.parametrize("dtype", BOUNDS, ids=["f64", "f32"])
QUARTER = np.pi / 2.0

seeds = st.integers(0, 2**32 - 1)


def rotations(seed: int, count: int = 20) -> Rotation:
    """Rotations of all sizes: any, tiny, near half a turn, and by quarters of a turn about the axes."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    axes[: count // 4] = np.eye(3)[rng.integers(0, 3, count // 4)]
    size = rng.uniform(0.0, np.pi, count)
    size[::4] = QUARTER * rng.integers(0, 4, len(size[::4]))
    size[1::8] = 10.0 ** rng.uniform(-12.0, -3.0, len(size[1::8]))
    size[2::8] = np.pi - 10.0 ** rng.uniform(-12.0, -3.0, len(size[2::8]))
    return Rotation.from_rotvec(axes * size[:, np.newaxis])


def apart(p: Floats, r: Rotation) -> float:
    """The largest distance of the quaternions, or of their negatives, from scipy's."""
    q = quats(r)
    return float(np.minimum(np.abs(p - q).max(axis=-1), np.abs(p + q).max(axis=-1)).max())


def as_dtype(r: Rotation, dtype: Any) -> tuple[Floats, Rotation]:
    """The quaternions in a dtype, and scipy's rotations of those."""
    q = quats(r).astype(dtype)
    return q, Rotation.from_quat(q.astype(np.float64), scalar_first=True)
