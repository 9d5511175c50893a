"""What a fit by an ellipsoid, a sphere or a circle gives, and what all of them refuse."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _html
from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration._common import CalibrationError
from ahrs_rs.calibration._model import Calibration

__all__ = ["EllipsoidFit"]

#: The largest standard deviation of a scale factor, or of an offset as a share of the norm: 0.03 of a horizontal field
#: are 1.7° of heading. (BROAD's recording 07 by itself gives 0.047, and takes VQF from 1.4° to 3.5°.)
LARGEST_UNCERTAINTY = 0.03
#: Larger residuals, as a share of the radius, are those of no ellipsoid; a cloud of noise alone has 42 %.
LARGEST_RESIDUAL = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidFit:
    """A calibration by an ellipsoid, with what tells how good it is.

    Parameters
    ----------
    calibration : Calibration
        S and b.
    norm : float
        Of calibrated readings: the given one, or the estimated one.
    norm_std : float
        Standard deviation of an estimated norm; 0 where it was given.
    names : tuple of str
        Of the parameters: S_xx, S_yy, S_zz, with nine S_xy, S_xz, S_yz, and b_x, b_y, b_z. With four
        radius (or S where the norm is given), b_x, b_y, b_z; with three radius and the offset along
        two of the sensor's axes, put into the plane.
    values : ndarray
        (p,) the parameters.
    covariance : ndarray
        (p, p) of the parameters: by the residuals, with their correlation in time; no law of the
        noise is assumed.
    residual_rms : float
        Of the calibrated norm about `norm`, over the readings that are no outliers, in the unit of
        the readings.
    residual_max : float
        The largest of them.
    correlation : float
        So many readings tell what one independent reading does (1: white noise).
    deviation_before : float
        Standard deviation of the norm of the readings over its mean, % (Cirillo et al. 2014),
        outliers included.
    deviation_after : float
        The same of the calibrated readings.
    coverage : float
        Share of 72 cells of equal area of the sphere that the readings have seen.
    observability : float
        Information about the least known combination of parameters, over that of evenly spread
        directions.
    samples : int
        Readings that were used.
    outliers : int
        Readings that were left out as outliers.
    missing : int
        Rows without a reading (NaN).
    left_out : int
        Rows in motion that an accelerometer's fit did not look at.
    normal : ndarray, optional
        (3,) of the plane that the readings lie in, with three parameters: along it the offset is
        not known and left as 0, and `norm` is the radius of the circle. Else None.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal((2000, 3))
    >>> x *= 48.0 / np.linalg.norm(x, axis=1, keepdims=True)
    >>> fit = ar.calibration.magnetometer(x + [12.0, -3.0, 5.0])
    >>> fit.samples, round(fit.norm, 6)
    (2000, 48.0)
    """

    calibration: Calibration
    norm: float
    norm_std: float
    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    residual_rms: float
    residual_max: float
    correlation: float
    deviation_before: float
    deviation_after: float
    coverage: float
    observability: float
    samples: int
    outliers: int
    missing: int
    left_out: int
    normal: FloatArray | None = None

    @property
    def std(self) -> FloatArray:
        """(p,) standard deviations of the parameters."""
        std: FloatArray = np.sqrt(np.diag(self.covariance))
        return std

    def summary(self) -> str:
        """All of it for reading, over several lines.

        Returns
        -------
        str
            Several lines.
        """
        lines = [
            f"norm       {self.norm:.5g}" + (f" ± {self.norm_std:.2g}" if self.norm_std else " (given)"),
            *(
                f"{name:<10} {value:.6g} ± {std:.2g}"
                for name, value, std in zip(self.names, self.values, self.std, strict=True)
            ),
            f"deviation  {self.deviation_before:.3g} % of the norm before, {self.deviation_after:.3g} % after",
            f"residual   {self.residual_rms:.3g} RMS, {self.residual_max:.3g} at most, "
            f"correlated over {self.correlation:.3g} readings",
            f"coverage   {self.coverage:.0%} of the directions, observability {self.observability:.2g}",
            f"readings   {self.samples} used, {self.outliers} outliers, {self.missing} missing, "
            f"{self.left_out} in motion",
        ]
        if self.normal is not None:
            x, y, z = self.normal
            lines.append(
                f"plane      normal ({x:.3f}, {y:.3f}, {z:.3f}): the offset along it is unknown, the heading of a "
                "sensor that turns in this plane needs none"
            )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = [
            (name, f"{value:.5g} ± {std:.2g}")
            for name, value, std in zip(self.names, self.values, self.std, strict=True)
        ]
        rows.append(("norm", f"{self.norm:.5g}" + (f" ± {self.norm_std:.2g}" if self.norm_std else " (given)")))
        rows.append(
            ("deviation of the norm", f"{self.deviation_before:.3g} % before, {self.deviation_after:.3g} % after")
        )
        rows.append(("coverage", f"{self.coverage:.0%} of the directions"))
        rows.append(("readings", f"{self.samples} used, {self.outliers} outliers"))
        return _html.summary("Fit of an ellipsoid", rows)

    def plot(self, readings: ArrayLike, *, ax: Any = None) -> NDArray[Any]:
        """Draw readings in three planes and their norms, before and after.

        Parameters
        ----------
        readings : array_like
            (T, 3) that it was fitted to, or others.
        ax : sequence of Axes, optional
            Eight of them, (2, 4); by default on a new figure.

        Returns
        -------
        ndarray
            (2, 4) of axes.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        ValueError
            A wrong shape, or another number of axes.
        """
        from ahrs_rs import plots  # for drawing only

        return plots.ellipsoid(self, readings, ax=ax)


def deviation(norms: FloatArray) -> float:
    """Cirillo's measure, in %: the standard deviation of ‖y‖ over its mean."""
    mean = float(norms.mean())
    return 100.0 * float(norms.std()) / mean if mean > 0 else math.inf


def check(
    name: str,
    readings: int,
    deviation: float,
    radius: float,
    correlation: float,
    information: float,
    shape: str = "ellipsoid",
) -> None:
    """Refuse a fit whose residuals are those of another shape, or whose parameters are hardly known.

    Parameters
    ----------
    information : of all readings about the least known combination of parameters, for residuals of the radius.
    """
    misfit = deviation / radius
    if misfit > LARGEST_RESIDUAL:
        raise CalibrationError(
            f"{name}: the readings lie on no {shape} (residuals of {misfit:.0%} of the radius): turn the sensor "
            + ("about one axis by a whole turn" if shape == "circle" else "in all directions")
            + ", at one place and away from magnets and iron"
        )
    uncertainty = float(misfit * np.sqrt(correlation / information))
    if not uncertainty < LARGEST_UNCERTAINTY:
        hint = "away from magnets and iron" if name == "mag" else "at rest in each attitude"
        raise CalibrationError(
            f"{name}: the parameters would be known to {uncertainty:.0%} only (residuals of {deviation:.2g}, "
            f"correlated over {correlation:.0f} of {readings} readings): record longer, in all directions, {hint}"
        )
