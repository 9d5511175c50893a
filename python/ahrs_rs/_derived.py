"""What follows from attitudes and readings: gravity, accelerations, heading, inclination, and their uncertainty."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _native, _quat
from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import Floats
from ahrs_rs._validate import choice, number

#: Beside the vertical a heading, and the direction of an inclination, is none: the sine of the angle to it.
VERTICAL = 1e-6
#: Earth frame -> the components of a vector along east and north: (axis, sign).
EAST_NORTH = {"ENU": ((0, 1.0), (1, 1.0)), "NED": ((1, 1.0), (0, 1.0)), "NWU": ((1, -1.0), (0, 1.0))}

#: What follows from the attitudes -> the sensor whose readings it needs.
DERIVED = {
    "gravity": "",
    "linear_acceleration": "acc",
    "linear_acceleration_sensor": "acc",
    "turn_rate": "gyr",
    "heading": "",
    "heading_std": "",
    "inclination": "",
    "inclination_std": "",
    "rotation_vector": "",
}


class Derived:
    """Base of an estimate: what its quaternions, biases and covariances say, in other words."""

    __slots__ = ()
    quat: Floats
    gyr_bias: Floats | None
    extra: Mapping[str, Floats]
    frame: str

    def gravity(self, gravity: float = GRAVITY) -> Floats:
        """Gravity in the sensor frame, as an accelerometer at rest reads it: it points up.

        Parameters
        ----------
        gravity : float, optional
            Of the place, m/s², as `ahrs_rs.earth.gravity` gives it.

        Returns
        -------
        ndarray
            (..., T, 3) m/s²; `linear_acceleration` in the sensor frame is what is left of a reading.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> ar.Mahony(rate=100.0).run(np.zeros((50, 3)), np.tile([0.0, 0.0, 9.8], (50, 1))).gravity()[-1]
        array([0.     , 0.     , 9.80665])
        """
        up: Floats = self._vertical() * self.quat.dtype.type(number("gravity", gravity))
        return up

    def linear_acceleration(self, acc: ArrayLike, frame: str = "earth", *, gravity: float = GRAVITY) -> Floats:
        """The acceleration of the sensor, its specific force with gravity taken off: free acceleration.

        Parameters
        ----------
        acc : array_like
            (..., T, 3) specific force in the sensor frame, m/s², of the rows of the estimate.
        frame : str, optional
            ``"earth"`` or ``"sensor"``, in whose axes it is given.
        gravity : float, optional
            Of the place, m/s², as `ahrs_rs.earth.gravity` gives it.

        Returns
        -------
        ndarray
            (..., T, 3) m/s²; NaN where the accelerometer has no sample.

        Raises
        ------
        ValueError
            Another shape or frame.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> acc = np.tile([0.0, 0.0, 9.80665], (50, 1))
        >>> ar.Mahony(rate=100.0).run(np.zeros((50, 3)), acc).linear_acceleration(acc)[-1]
        array([0., 0., 0.])
        """
        choice("frame", frame, ("earth", "sensor"))
        force = self._rows("acc", acc)
        if frame == "sensor":
            return np.asarray(force - self.gravity(gravity))
        earth = np.einsum("...ij,...j->...i", _native.rotation_matrices(self.quat), force)
        earth[..., 2] -= self._up * number("gravity", gravity)
        return np.asarray(earth)

    def turn_rate(self, gyr: ArrayLike, frame: str = "sensor") -> Floats:
        """The angular rate: readings of the gyroscope less its bias, where the filter estimates one.

        Parameters
        ----------
        gyr : array_like
            (..., T, 3) rad/s, of the rows of the estimate.
        frame : str, optional
            ``"sensor"`` or ``"earth"``, in whose axes it is given.

        Returns
        -------
        ndarray
            (..., T, 3) rad/s; NaN where the gyroscope has no sample.

        Raises
        ------
        ValueError
            Another shape or frame.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> gyr = np.full((50, 3), 0.5)
        >>> ar.Madgwick(rate=100.0).run(gyr, np.tile([0.0, 0.0, 9.8], (50, 1))).turn_rate(gyr)[-1]
        array([0.5, 0.5, 0.5])
        """
        choice("frame", frame, ("sensor", "earth"))
        rate = self._rows("gyr", gyr)
        if self.gyr_bias is not None:
            rate = rate - self.gyr_bias
        if frame == "earth":
            rate = np.einsum("...ij,...j->...i", _native.rotation_matrices(self.quat), rate)
        return np.asarray(rate)

    def rotation_vector(self) -> Floats:
        """Rotation vectors of the attitudes: the axis times the angle, of at most π.

        Returns
        -------
        ndarray
            (..., T, 3) rad.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> ar.Mahony(rate=100.0).run(np.zeros((50, 3)), np.tile([0.0, 0.0, 9.8], (50, 1))).rotation_vector()[-1]
        array([0., 0., 0.])
        """
        vector: Floats = _quat.log(np.asarray(self.quat, dtype=np.float64)).astype(self.quat.dtype, copy=False)
        return vector

    def heading(self, degrees: bool = False) -> Floats:
        """Where the sensor's x axis points, clockwise from north as on a compass, in whichever earth frame.

        North is true north where the filter was given the declination.

        Parameters
        ----------
        degrees : bool, optional
            Degrees in place of radians.

        Returns
        -------
        ndarray
            (..., T) in [0, 2π); 0 where the axis is vertical.

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> est = ar.Mahony(rate=100.0).run(np.zeros((50, 3)), np.tile([0.0, 0.0, 9.8], (50, 1)))
        >>> est.heading(degrees=True)[-1]  # x is east in ENU, where nothing says otherwise
        np.float64(90.0)
        """
        east, north = self._horizontal(_axis(self.quat, 0))
        angle = np.where(np.hypot(east, north) > VERTICAL, np.arctan2(east, north), 0.0)
        turn = self.quat.dtype.type(2.0 * np.pi)
        angle = np.where(angle < 0, angle + turn, angle)
        angle = np.where(angle >= turn, 0.0, angle).astype(self.quat.dtype, copy=False)
        return np.rad2deg(angle) if degrees else angle

    def heading_std(self, degrees: bool = False) -> Floats:
        """Standard deviation of `heading`, by the covariance of the attitude.

        Parameters
        ----------
        degrees : bool, optional
            Degrees in place of radians.

        Returns
        -------
        ndarray
            (..., T); infinite where the axis is vertical.

        Raises
        ------
        ValueError
            The estimate has no covariance: ``run(..., outputs=["covariance"])``.

        Examples
        --------
        >>> import ahrs_rs as ar
        >>> rec = ar.simulate.demo(duration=5.0)
        >>> est = ar.MEKF(rate=100.0).run(rec, outputs=["covariance"])
        >>> est.heading_std(degrees=True).shape
        (500,)
        """
        covariance = self._covariance()
        matrix = _native.rotation_matrices(self.quat)
        east, north = self._horizontal(matrix[..., :, 0])
        square = east**2 + north**2
        # A small rotation d in the sensor frame moves R x by R (d × x), and d × x = (0, dz, -dy).
        moved = np.stack((np.zeros_like(matrix[..., :, 0]), -matrix[..., :, 2], matrix[..., :, 1]), axis=-1)
        east_row, north_row = self._horizontal(np.moveaxis(moved, -1, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            row = np.moveaxis((north * east_row - east * north_row) / square, 0, -1)
            std = np.sqrt(np.einsum("...i,...ij,...j->...", row, covariance, row))
        std = np.where(square > VERTICAL**2, std, np.inf).astype(self.quat.dtype, copy=False)
        return np.rad2deg(std) if degrees else std

    def inclination(self, degrees: bool = False) -> Floats:
        """The angle between the sensor's z axis and the vertical of the earth frame's z axis.

        Parameters
        ----------
        degrees : bool, optional
            Degrees in place of radians.

        Returns
        -------
        ndarray
            (..., T) in [0, π].

        Examples
        --------
        >>> import numpy as np
        >>> import ahrs_rs as ar
        >>> est = ar.Tilt(rate=100.0).run(None, np.tile([9.8, 0.0, 9.8], (50, 1)))
        >>> est.inclination(degrees=True)[-1].round(6)
        np.float64(45.0)
        """
        z = _axis(self.quat, 2)
        angle = np.arctan2(np.hypot(z[..., 0], z[..., 1]), z[..., 2])
        return np.rad2deg(angle) if degrees else np.asarray(angle)

    def inclination_std(self, degrees: bool = False) -> Floats:
        """Standard deviation of `inclination`, by the covariance of the attitude.

        Parameters
        ----------
        degrees : bool, optional
            Degrees in place of radians.

        Returns
        -------
        ndarray
            (..., T); where the axis is vertical that of the worst direction.

        Raises
        ------
        ValueError
            The estimate has no covariance: ``run(..., outputs=["covariance"])``.

        Examples
        --------
        >>> import ahrs_rs as ar
        >>> rec = ar.simulate.demo(duration=5.0)
        >>> est = ar.MEKF(rate=100.0).run(rec, outputs=["covariance"])
        >>> est.inclination_std(degrees=True).shape
        (500,)
        """
        covariance = self._covariance()
        vertical = _axis(_conjugate(self.quat), 2)  # the earth's z axis in the sensor frame
        sine = np.hypot(vertical[..., 0], vertical[..., 1])
        # The cosine is the z component v_z of the vertical; d moves v by v × d, hence the angle about (v_y, -v_x, 0).
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = vertical[..., 1] / sine, -vertical[..., 0] / sine
        variance = x * x * covariance[..., 0, 0] + 2 * x * y * covariance[..., 0, 1] + y * y * covariance[..., 1, 1]
        mean = 0.5 * (covariance[..., 0, 0] + covariance[..., 1, 1])
        half = 0.5 * (covariance[..., 0, 0] - covariance[..., 1, 1])
        worst = mean + np.hypot(half, covariance[..., 0, 1])
        std = np.sqrt(np.where(sine > VERTICAL, variance, worst)).astype(self.quat.dtype, copy=False)
        return np.rad2deg(std) if degrees else np.asarray(std)

    def _rows(self, name: str, values: ArrayLike) -> Floats:
        array = np.asarray(values, dtype=self.quat.dtype)
        if array.shape != (*self.quat.shape[:-1], 3):
            raise ValueError(f"{name}: expected shape {(*self.quat.shape[:-1], 3)}, got {array.shape}")
        return array

    def _covariance(self) -> Floats:
        if "covariance" not in self.extra:
            raise ValueError(
                'covariance: expected an estimate of run(..., outputs=["covariance"]), got one with '
                f"{', '.join(self.extra) or 'no outputs'}"
            )
        return self.extra["covariance"]

    @property
    def _up(self) -> float:
        """Along the earth frame's z axis."""
        return -1.0 if self.frame == "NED" else 1.0

    def _vertical(self) -> Floats:
        """(..., 3) up in the sensor frame."""
        up: Floats = _axis(_conjugate(self.quat), 2) * self.quat.dtype.type(self._up)
        return up

    def _horizontal(self, vector: Floats) -> tuple[Floats, Floats]:
        """East and north of vectors (..., 3) of the earth frame."""
        (east, east_sign), (north, north_sign) = EAST_NORTH[self.frame]
        return east_sign * vector[..., east], north_sign * vector[..., north]


def _axis(quat: Floats, axis: int) -> Floats:
    """(..., 3) the image of a unit vector: a column of the rotation matrix."""
    w, u = quat[..., 0], np.moveaxis(quat[..., 1:], -1, 0)
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    image = np.empty((*quat.shape[:-1], 3), dtype=quat.dtype)
    image[..., i] = 1 - 2 * (u[j] * u[j] + u[k] * u[k])
    image[..., j] = 2 * (u[i] * u[j] + w * u[k])
    image[..., k] = 2 * (u[i] * u[k] - w * u[j])
    return image


def _conjugate(quat: Floats) -> Floats:
    inverse: Floats = quat * np.array([1, -1, -1, -1], dtype=quat.dtype)
    return inverse
