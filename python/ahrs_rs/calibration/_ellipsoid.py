"""Magnetometers and accelerometers by the ellipsoid, sphere or circle that their readings lie on."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._constants import GRAVITY
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration import _directions, _ellipsoid_fit, _fit_result, _linear, _sphere, _sums, _windows
from ahrs_rs.calibration._common import AXES, CalibrationError, CalibrationWarning, count_of, readings
from ahrs_rs.calibration._fit_result import EllipsoidFit
from ahrs_rs.calibration._model import Calibration

__all__ = ["accelerometer", "ellipsoid", "magnetometer"]

#: Earth's field is between 22 and 67 µT; inside of buildings somewhat more or less.
FIELD_RANGE = (10.0, 150.0)
#: A sensor is not off by more than this factor: then it is the unit.
LARGEST_GAIN = 2.0
#: Nothing is measured in units in which readings are beyond these: their squares would be beyond the range of numbers.
SIZES = (1e-60, 1e60)
#: Of a circle, a sphere, an ellipsoid along the axes, and any ellipsoid.
PARAMETERS = (3, 4, 6, 9)


def ellipsoid(x: ArrayLike, *, parameters: int = 9, norm: float | None = None, name: str = "x") -> EllipsoidFit:
    """The calibration that puts readings on a sphere about zero: ‖S (x − b)‖ is the same for all.

    The start is the linear least squares of Cirillo et al. 2014 (eqs 1-6; nine parameters the same way) inside of a
    least median of squares, then Gauss-Newton on the norms of the calibrated readings, with readings farther off than
    four robust standard deviations (median of the absolute residuals) left out as outliers.

    Parameters
    ----------
    x : array_like
        (T, 3); rows with NaN are left out.
    parameters : int, optional
        9 (S symmetric and positive definite: soft iron too), 6 (S diagonal: a scale and an offset
        an axis), 4 (an offset alone: readings on a sphere, of which a part is enough) or 3 (an
        offset in the plane that all readings lie in, of a sensor that turns about one axis). What a
        symmetric S leaves open is a rotation of the whole sensor, which norms say nothing about.
    norm : float, optional
        Of calibrated readings. None estimates it as that of the sphere of the ellipsoid's volume:
        det S = 1. It must be None with three parameters.
    name : str, optional
        Of the readings, in errors.

    Returns
    -------
    EllipsoidFit
        Its calibration has 1σ uncertainties and the deviations of the norm in `info`.

    Raises
    ------
    CalibrationError
        The readings do not determine the parameters; the message says what to record.
    ValueError
        A wrong shape or dtype, an infinite value, an unknown number of parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal((2000, 3))
    >>> x /= np.linalg.norm(x, axis=1, keepdims=True)
    >>> ar.calibration.ellipsoid(x + [1.0, 2.0, 3.0]).calibration.offset.round(6)
    array([1., 2., 3.])
    """
    parameters = count_of(parameters, PARAMETERS)
    if norm is not None:
        norm = positive("norm", norm)
    array, valid = readings(name, x)
    missing = len(array) - int(np.count_nonzero(valid))
    rows = array if not missing else array[valid]
    return _fit(rows, parameters, norm, name, missing)


def magnetometer(mag: ArrayLike, *, parameters: int = 9, norm: float | None = None) -> EllipsoidFit:
    """Hard iron (b) and scale or soft iron (S) of a magnetometer that was turned in all directions in a steady field.

    Parameters
    ----------
    mag : array_like
        (T, 3) in µT; another unit works where `norm` is not given, with a warning.
    parameters : int, optional
        9, 6, 4 (hard iron alone) or 3 (the same of a sensor that turns about one axis, as a rover
        or a boat), as in `ellipsoid`.
    norm : float, optional
        Of the local field, µT, as a map of the field tells it; None estimates it.

    Returns
    -------
    EllipsoidFit
        The calibration, and how good it is.

    Raises
    ------
    CalibrationError
        The readings do not determine the parameters; the message says what to record.
    ValueError
        As `ellipsoid`; or readings that differ from the given norm by more than a factor of 2: another unit.

    Warns
    -----
    CalibrationWarning
        A field that is not Earth's in µT.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal((2000, 3))
    >>> x *= 48.0 / np.linalg.norm(x, axis=1, keepdims=True)
    >>> ar.calibration.magnetometer(x + [12.0, -3.0, 5.0]).calibration.offset.round(6)
    array([12., -3.,  5.])
    """
    fit = ellipsoid(mag, parameters=parameters, norm=norm, name="mag")
    radius = fit.norm / _mean_gain(fit)
    if norm is not None:
        _check_unit(
            "mag", radius, norm, "µT", {1e-2: "Gauss (times 100)", 1e-6: "Tesla (times 1e6)", 1e3: "nT (over 1000)"}
        )
    elif (
        not (0.0 if parameters == 3 else FIELD_RANGE[0]) <= radius <= FIELD_RANGE[1]
    ):  # a circle: the part in its plane
        warnings.warn(
            f"mag: the norm is {radius:.3g}, but Earth's field is 22 to 67 µT: are the readings in another unit? The "
            "calibration is right up to that factor",
            CalibrationWarning,
            stacklevel=2,
        )
    return fit


def accelerometer(
    acc: ArrayLike,
    *,
    rate: float | None = None,
    select: str = "rest",
    still: ArrayLike | None = None,
    parameters: int = 6,
    gravity: float = GRAVITY,
    window: float = 0.25,
) -> EllipsoidFit:
    """Scale and offset of an accelerometer, by gravity alone: ‖S (x − b)‖ = g wherever it rests or turns slowly.

    Parameters
    ----------
    acc : array_like
        (T, 3) in m/s², at rest in many attitudes, or slowly turned.
    rate : float, optional
        Hz; needed to find the windows in which the sensor rests.
    select : str, optional
        "rest" takes the means of windows in which the readings vary no more than at rest (three
        times the spread of the quietest tenth). "robust" takes all readings; those that fit to no
        sphere (external acceleration) are outliers, as long as three in ten are of a sensor that
        rests.
    still : array_like, optional
        (T,) bool, the samples at rest where they are known (then nothing is looked for). Their
        means over windows are taken where `rate` is given, else the samples themselves.
    parameters : int, optional
        6, or 9 with cross-axis sensitivity (then not only attitudes with an axis up and down are
        needed).
    gravity : float, optional
        Local gravity, m/s².
    window : float, optional
        Length of a window, s.

    Returns
    -------
    EllipsoidFit
        The calibration, and how good it is.

    Raises
    ------
    CalibrationError
        The readings do not determine the parameters; the message says what to record.
    ValueError
        As `ellipsoid`; or readings that are off by more than a factor of 2: another unit.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal((2000, 3))
    >>> x *= 9.80665 / np.linalg.norm(x, axis=1, keepdims=True)
    >>> fit = ar.calibration.accelerometer(x + [0.1, 0.0, 0.0], still=np.ones(2000, dtype=bool))
    >>> fit.calibration.offset.round(6) + 0.0
    array([0.1, 0. , 0. ])
    """
    gravity = positive("gravity", gravity)
    parameters = count_of(parameters, (6, 9))
    if select not in ("rest", "robust"):
        raise ValueError(f'select: expected "rest" or "robust", got {select!r}')
    array, valid = readings("acc", acc)
    missing = len(array) - int(np.count_nonzero(valid))
    if still is not None:
        resting = np.asarray(still)
        if resting.dtype.kind != "b" or resting.shape != (len(array),):
            raise ValueError(f"still: expected bool of shape ({len(array)},), got {resting.dtype} of {resting.shape}")
        used = resting & valid
        rows = array[used] if rate is None else _windows.means(np.where(used[:, None], array, np.nan), rate, window)
        left_out = len(array) - missing - int(np.count_nonzero(used))
    elif select == "rest":
        if rate is None:
            raise ValueError('rate: needed to find the windows at rest; without it: still=, or select="robust"')
        rest = _windows.resting(array, rate, window)
        rows = rest.means
        left_out = max(len(array) - missing - len(rows) * rest.length, 0)
    else:
        rows, left_out = array[valid], 0
    if len(rows):
        size = float(np.median(np.linalg.norm(rows, axis=1)))
        _check_unit("acc", size, gravity, "m/s²", {1.0 / GRAVITY: f"g (times {GRAVITY})", 1e3 / GRAVITY: "mg"})
    return _fit(rows, parameters, gravity, "acc", missing, left_out, still is None and select == "robust")


def _fit(
    rows: FloatArray,
    parameters: int,
    norm: float | None,
    name: str,
    missing: int,
    left_out: int = 0,
    motion: bool = False,
) -> EllipsoidFit:
    if len(rows) < parameters:
        found = "readings" if not left_out else "windows at rest"
        raise CalibrationError(
            f"{name}: expected at least {parameters} {found} for {parameters} parameters, got {len(rows)}"
            f" ({missing} are NaN{f', {left_out} in motion' if left_out else ''}): "
            "record more, with the sensor turned in all directions"
        )
    x = np.ascontiguousarray(rows.T)
    size = float(np.abs(x).max())
    if size > SIZES[1] or 0 < size < SIZES[0]:
        raise CalibrationError(f"{name}: expected readings between {SIZES[0]} and {SIZES[1]}, got {size:.3g}")
    if parameters in (3, 4):
        if parameters == 4:
            _directions.check_spread(name, x)
        return _sphere.fit(x, parameters, norm, name, missing)
    _directions.check_spread(name, x)
    try:
        found_fit = _ellipsoid_fit.fit(x, parameters, motion)
    except (_linear.NoEllipsoidError, np.linalg.LinAlgError):
        raise CalibrationError(_directions.advice(name, x, parameters, motion)) from None
    keep = found_fit.keep
    observability = found_fit.observability
    _fit_result.check(
        name,
        len(rows),
        found_fit.deviation,
        found_fit.radius,
        found_fit.correlation,
        np.count_nonzero(keep) * observability * _ellipsoid_fit.EVEN_INFORMATION,
    )
    values, covariance, radius, radius_std = _scaled(found_fit, parameters, norm)
    matrix = _sums.symmetric(values[:-3])
    residual_max = float((np.abs(found_fit.residual) * keep).max()) * (radius / found_fit.radius)
    names = tuple(f"S_{axis}{axis}" for axis in AXES)
    if parameters == 9:
        names += tuple(f"S_{AXES[i]}{AXES[j]}" for i, j in _linear.PAIRS)
    names += tuple(f"b_{axis}" for axis in AXES)
    before, after = (
        _fit_result.deviation(np.sqrt((x * x).sum(axis=0))),
        _fit_result.deviation(1.0 + found_fit.residual / found_fit.radius),
    )
    std = np.sqrt(np.diag(covariance))
    info: dict[str, Any] = {
        "method": f"ellipsoid, {parameters} parameters",
        "norm": radius,
        "norm_std": radius_std,
        "std": dict(zip(names, std.tolist(), strict=True)),
        "norm_deviation_percent": {"before": before, "after": after},
        "samples": int(np.count_nonzero(keep)),
        "outliers": int(np.count_nonzero(~keep)),
    }
    return EllipsoidFit(
        calibration=Calibration(matrix, found_fit.centre, info),
        norm=radius,
        norm_std=radius_std,
        names=names,
        values=values,
        covariance=covariance,
        residual_rms=found_fit.deviation * (radius / found_fit.radius),
        residual_max=residual_max,
        correlation=found_fit.correlation,
        deviation_before=before,
        deviation_after=after,
        coverage=_directions.coverage(found_fit.directions),
        observability=observability,
        samples=info["samples"],
        outliers=info["outliers"],
        missing=missing,
        left_out=left_out,
    )


def _scaled(
    fit: _ellipsoid_fit.Ellipsoid, parameters: int, norm: float | None
) -> tuple[FloatArray, FloatArray, float, float]:
    """Parameters and covariance for the norm: S = r A, with r = det(A)^(-1/3) where it is not given."""
    a, count = fit.matrix, parameters - 3
    entries = np.concatenate((np.diag(a), [a[i, j] for i, j in _linear.PAIRS[: count - 3]]))
    jacobian = np.eye(parameters)
    norm_std = 0.0
    if norm is None:
        radius = float(np.linalg.det(a)) ** (-1.0 / 3.0)
        inverse = np.linalg.inv(a)
        weights = [inverse[i, i] for i in range(3)] + [2.0 * inverse[i, j] for i, j in _linear.PAIRS[: count - 3]]
        slope = -radius / 3.0 * np.array(weights)  # dr/dA
        norm_std = float(np.sqrt(slope @ fit.covariance[:count, :count] @ slope))
        jacobian[:count, :count] = radius * np.eye(count) + np.outer(entries, slope)
    else:
        radius = norm
        jacobian[:count, :count] *= radius
    values = np.concatenate((radius * entries, fit.centre))
    covariance: FloatArray = jacobian @ fit.covariance @ jacobian.T
    return values, covariance, radius, norm_std


def _mean_gain(fit: EllipsoidFit) -> float:
    gain: float = float(np.linalg.det(fit.calibration.matrix)) ** (1.0 / 3.0)
    return gain


def _check_unit(name: str, size: float, expected: float, unit: str, others: dict[float, str]) -> None:
    """Refuse readings that are far from what they measure."""
    ratio = size / expected
    if 1.0 / LARGEST_GAIN <= ratio <= LARGEST_GAIN:
        return
    guess = [text for factor, text in others.items() if 1.0 / LARGEST_GAIN <= ratio / factor <= LARGEST_GAIN]
    hint = f": are they in {guess[0]}?" if guess else ""
    raise ValueError(f"{name}: expected readings of about {expected:.4g} {unit}, got {size:.3g}{hint}")
