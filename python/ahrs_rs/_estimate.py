"""The result of a run."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _html, _native
from ahrs_rs._constants import GRAVITY
from ahrs_rs._dataframe import Table, data_frame
from ahrs_rs._derived import Derived
from ahrs_rs._optional import require, version
from ahrs_rs._state import State
from ahrs_rs._status import Status
from ahrs_rs._typing import Floats

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

    from ahrs_rs._recording import Recording


class _Later:
    """Stamps and states of an estimate, made when they are first asked for: most runs are short, and few want them."""

    __slots__ = ("_make",)
    _make: Callable[[str], Any]
    """Gives an attribute by its name."""

    def __getattr__(self, name: str) -> Any:
        # Called where a slot is empty.
        if name not in ("t", "state"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        value = self._make(name)
        object.__setattr__(self, name, value)
        return value


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Estimate(_Later, Derived, Table):
    """Attitudes of one recording (T samples), or of N recordings of T samples.

    Quaternions are scalar-first ``[w, x, y, z]``, of unit norm, and rotate from the sensor frame to the earth frame
    that the filter was made for. Their sign is continuous along time.

    Parameters
    ----------
    quat : ndarray
        (T, 4) or (N, T, 4).
    gyr_bias : ndarray, optional
        (..., T, 3) gyroscope bias in rad/s, or None where the filter estimates none.
    status : ndarray
        (..., T) bits of `ahrs_rs.Status`.
    t : ndarray
        (T,) stamps in s, or (N, T) where they differ between recordings.
    state : State or list of State, optional
        After the last sample (a list of N for N recordings): ``run(..., state=est.state)`` goes on
        from here; None of an offline filter.
    extra : mapping
        What ``outputs=`` asked for, by name: (..., T, *shape).
    frame : str, optional
        The earth frame.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=5.0)
    >>> est = ar.Madgwick(rate=100.0).run(rec)
    >>> est.quat.shape, est.euler(degrees=True).shape
    ((500, 4), (500, 3))
    """

    quat: Floats
    gyr_bias: Floats | None
    status: NDArray[np.uint16]
    t: NDArray[np.float64]
    state: State | list[State] | None
    extra: Mapping[str, Floats]
    frame: str = "ENU"

    @classmethod
    def _of_run(
        cls,
        quat: Floats,
        gyr_bias: Floats | None,
        status: NDArray[np.uint16],
        extra: Mapping[str, Floats],
        frame: str,
        make: Callable[[str], Any],
    ) -> Self:
        """An estimate whose stamps and state are made later."""
        self, put = object.__new__(cls), object.__setattr__
        put(self, "quat", quat)
        put(self, "gyr_bias", gyr_bias)
        put(self, "status", status)
        put(self, "extra", extra)
        put(self, "frame", frame)
        put(self, "_make", make)
        return self

    def __repr__(self) -> str:
        parts = [f"quat{self.quat.shape}", str(self.quat.dtype)]
        if self.gyr_bias is not None:
            parts.append("gyr_bias")
        return f"<Estimate {', '.join([*parts, *self.extra])}>"

    def _repr_html_(self) -> str:
        several = self.quat.ndim == 3
        rows: list[tuple[str, object]] = []
        if several:
            rows.append(("recordings", len(self.quat)))
        rows.append(("samples", len(self)))
        if self.t.size > 1:
            rows.append(
                ("time", f"{_html.number(float(self.t.flat[0]))} to {_html.number(float(self.t.flat[-1]), 's')}")
            )
        rows.append(("frame", f"{self.frame}, {self.quat.dtype}"))
        if len(self) and self.quat.size:
            last = self.quat.reshape(-1, len(self), 4)[0, -1:]
            names = ("roll", "pitch", "yaw")
            angles = np.rad2deg(_native.euler_angles(last))[0]
            shown = ", ".join(f"{name} {angle:.1f}°" for name, angle in zip(names, angles, strict=True))
            rows.append(("at the end" + (" of the first" if several else ""), shown))
            counts = {flag.name: int(np.count_nonzero(self.status & flag.value)) for flag in Status}
            flags = [f"{name} {100.0 * count / self.status.size:.3g} %" for name, count in counts.items() if count]
            rows.append(("status", ", ".join(flags) or "no flag at any sample"))
        if self.extra:
            rows.append(("outputs", ", ".join(self.extra)))
        return _html.summary("Estimate", rows)

    def __reduce__(self) -> tuple[Any, ...]:
        # A read-only mapping cannot be pickled, its contents can.
        return _estimate, (self.quat, self.gyr_bias, self.status, self.t, self.state, dict(self.extra), self.frame)

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

        Parameters
        ----------
        degrees : bool, optional
            Degrees in place of radians.

        Returns
        -------
        ndarray
            (..., T, 3) roll, pitch, yaw.
        """
        angles = _native.euler_angles(self.quat)
        return np.rad2deg(angles) if degrees else angles

    def matrix(self) -> Floats:
        """Rotation matrices (..., T, 3, 3): ``v_earth = R @ v_sensor``.

        Returns
        -------
        ndarray
            (..., T, 3, 3).
        """
        return _native.rotation_matrices(self.quat)

    def rotation(self) -> Rotation:
        """A ``scipy.spatial.transform.Rotation`` of the same leading shape (needs the extra ``scipy``).

        Returns
        -------
        scipy.spatial.transform.Rotation
            Of the same leading shape.
        """
        rotation: type[Rotation] = require("scipy.spatial.transform", "scipy", "rotation needs").Rotation
        quat = self.quat[..., [1, 2, 3, 0]]  # their order, which every version knows
        if quat.ndim > 2:
            if quat.shape[0] == 0:
                return rotation.from_quat(quat.reshape(-1, 4))
            if version("scipy") < (1, 17):
                raise ImportError("rotation of several recordings needs scipy 1.17 or later: pip install 'scipy>=1.17'")
        return rotation.from_quat(quat)

    def plot(self, *, ref: ArrayLike | None = None, recording: int | None = None, ax: Any = None) -> NDArray[Any]:
        """Draw the angles, and bias, innovations and status where there is something of them.

        Parameters
        ----------
        ref : array_like, optional
            (T, 4) the truth, drawn dashed.
        recording : int, optional
            Which one, of an estimate of several.
        ax : Axes or sequence of Axes, optional
            As many as there are panels; by default on a new figure.

        Returns
        -------
        ndarray
            (n,) of axes, from top to bottom.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        ValueError
            Several recordings and none of them named, or another number of axes.

        See Also
        --------
        ahrs_rs.plots : Each of the panels by itself.
        """
        from ahrs_rs import plots  # for drawing only

        return plots.estimate(self, ref=ref, recording=recording, ax=ax)

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        recording: Recording | None = None,
        degrees: bool = False,
        outputs: Sequence[str] = (),
        gravity: float = GRAVITY,
    ) -> None:
        """Write the estimate of one recording to a file.

        Parameters
        ----------
        path : str or path-like
            The ending tells the format:

            - .csv, .parquet: columns t, qw, qx, qy, qz, roll, pitch, yaw, bias_x, bias_y, bias_z where estimated, what
              ``outputs=`` asked for (covariance_0_1, ...), status
            - .npz: the same as arrays (quat, euler, gyr_bias, ...)
            - .sto: for OpenSim; `ahrs_rs.io.write_sto` writes several sensors
            - .tum: trajectory text, scalar-last, positions zero
            - .mcap, .ros2 (a folder): messages of ROS 2 (the extra ``ros``), QuaternionStamped, and Imu with
              `recording`; ROS expects the frame ENU
        recording : Recording, optional
            Of the same rows; CSV, Parquet and npz then have the linear acceleration in the earth frame
            (m/s²), and messages of ROS the readings.
        degrees : bool, optional
            Euler angles in degrees and the bias in degrees a second, as their names then say (yaw_deg).
        outputs : sequence of str, optional
            What else follows from the attitudes, for CSV, Parquet and npz: ``gravity``,
            ``linear_acceleration``, ``linear_acceleration_sensor``, ``turn_rate`` (these three with
            `recording`), ``heading``, ``inclination``, ``rotation_vector``, and, of an estimate with
            covariance, ``heading_std`` and ``inclination_std``.
        gravity : float, optional
            Of the place, m/s².

        Raises
        ------
        ValueError
            Another ending, several recordings in one estimate, or a recording of another length.
        ImportError
            The format needs a package that is not installed.
        """
        from ahrs_rs.io import save_estimate

        save_estimate(path, self, recording, degrees=degrees, outputs=outputs, gravity=gravity)

    def to_frame(self) -> Any:
        """A polars or pandas DataFrame, whichever is installed (polars first), a row a sample.

        Columns ``t, qw, qx, qy, qz, roll, pitch, yaw`` (rad), ``bias_x, bias_y, bias_z`` (rad/s) where estimated,
        ``status``, the extra outputs with their indices, and ``recording`` where there are N of them.

        Returns
        -------
        polars.DataFrame or pandas.DataFrame
            A row a sample.
        """
        return data_frame(self._columns())

    def to_xarray(self) -> Any:
        """A ``xarray.Dataset`` (needs the extra ``xarray``), whose arrays are those of the estimate, not copies.

        Variables ``quat`` (component: w, x, y, z), ``euler`` (angle: roll, pitch, yaw; rad), ``gyr_bias`` (axis;
        rad/s) where estimated, ``status``, and the extra outputs, over the dimension ``t`` with the stamps for
        coordinates; of N recordings ``recording`` before it, and ``sample`` in place of ``t`` where stamps differ.

        Returns
        -------
        xarray.Dataset
            With the earth frame in its attributes.
        """
        from ahrs_rs._labelled import dataset

        return dataset(self)

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
    frame: str = "ENU",
) -> Estimate:
    """The pickled estimate."""
    return Estimate(quat, gyr_bias, status, t, state, MappingProxyType(extra), frame)
