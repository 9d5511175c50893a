"""The result of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _native
from ahrs_rs._frame import data_frame
from ahrs_rs.state import State

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Estimate:
    """Attitudes of one recording (T samples), or of N recordings of T samples.

    Quaternions are scalar-first ``[w, x, y, z]``, of unit norm, and rotate from the sensor frame to the earth frame
    that the filter was made for. Their sign is continuous along time.
    """

    quat: Floats
    """(T, 4) or (N, T, 4)."""
    gyr_bias: Floats | None
    """(..., T, 3) gyroscope bias in rad/s, or None where the filter estimates none."""
    status: NDArray[np.uint16]
    """(..., T) bits of `ahrs_rs.Status`."""
    t: NDArray[np.float64]
    """(T,) stamps in s, or (N, T) where they differ between recordings."""
    state: State | list[State] | None
    """After the last sample (a list of N for N recordings): ``run(..., state=est.state)`` goes on from here; None of an
    offline filter."""
    extra: Mapping[str, Floats]
    """What ``outputs=`` asked for, by name: (..., T, *shape)."""

    def __repr__(self) -> str:
        parts = [f"quat{self.quat.shape}", str(self.quat.dtype)]
        if self.gyr_bias is not None:
            parts.append("gyr_bias")
        return f"<Estimate {', '.join([*parts, *self.extra])}>"

    def __reduce__(self) -> tuple[Any, ...]:
        # A read-only mapping cannot be pickled, its contents can.
        return _estimate, (self.quat, self.gyr_bias, self.status, self.t, self.state, dict(self.extra))

    def __len__(self) -> int:
        """The number of samples of one recording."""
        return int(self.quat.shape[-2])

    @property
    def covariance(self) -> Floats | None:
        """(..., T, 3, 3) covariance of the attitude error in the sensor frame in rad², or None where not asked for."""
        return self.extra.get("covariance")

    def euler(self, degrees: bool = False) -> Floats:
        """Roll, pitch, yaw (..., T, 3) of the intrinsic Z-Y'-X'' sequence, in rad or degrees.

        The order is the reverse of scipy's ``as_euler("ZYX")``, which gives yaw first. Pitch is in [-pi/2, pi/2];
        where it is at an end of that, roll is 0.
        """
        angles = _native.euler_angles(self.quat)
        return np.rad2deg(angles) if degrees else angles

    def matrix(self) -> Floats:
        """Rotation matrices (..., T, 3, 3): ``v_earth = R @ v_sensor``."""
        return _native.rotation_matrices(self.quat)

    def rotation(self) -> Rotation:
        """A ``scipy.spatial.transform.Rotation`` of the same leading shape (needs the extra ``rotation``)."""
        from scipy.spatial.transform import Rotation

        if self.quat.ndim > 2 and self.quat.shape[0] == 0:
            return Rotation.from_quat(self.quat.reshape(-1, 4), scalar_first=True)
        return Rotation.from_quat(self.quat, scalar_first=True)

    def to_frame(self) -> Any:
        """A polars or pandas DataFrame, whichever is installed (polars first), a row a sample.

        Columns ``t, qw, qx, qy, qz, roll, pitch, yaw`` (rad), ``bias_x, bias_y, bias_z`` (rad/s) where estimated,
        ``status``, the extra outputs with their indices, and ``recording`` where there are N of them.
        """
        return data_frame(self._columns())

    def _columns(self) -> dict[str, NDArray[Any]]:
        leading = self.quat.shape[:-1]
        columns: dict[str, NDArray[Any]] = {}
        if len(leading) == 2:
            columns["recording"] = np.repeat(np.arange(leading[0]), leading[1])
        columns["t"] = np.broadcast_to(self.t, leading).reshape(-1)

        def add(names: list[str], values: Floats) -> None:
            flat = values.reshape(-1, len(names))
            columns.update({name: np.ascontiguousarray(flat[:, i]) for i, name in enumerate(names)})

        add(["qw", "qx", "qy", "qz"], self.quat)
        add(["roll", "pitch", "yaw"], self.euler())
        if self.gyr_bias is not None:
            add(["bias_x", "bias_y", "bias_z"], self.gyr_bias)
        for name, values in self.extra.items():
            shape = values.shape[len(leading) :]
            add(["_".join([name, *map(str, index)]) for index in np.ndindex(*shape)], values)
        columns["status"] = self.status.reshape(-1)
        return columns


def _estimate(
    quat: Floats,
    gyr_bias: Floats | None,
    status: NDArray[np.uint16],
    t: NDArray[np.float64],
    state: State | list[State] | None,
    extra: dict[str, Floats],
) -> Estimate:
    """The pickled estimate."""
    return Estimate(quat, gyr_bias, status, t, state, MappingProxyType(extra))
