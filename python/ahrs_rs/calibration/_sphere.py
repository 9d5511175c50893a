"""Hard iron alone: of readings that lie on a sphere (4 parameters), or on a circle in a plane (3)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration import _directions, _ellipsoid_fit, _fit_result, _linear, _sphere_fit
from ahrs_rs.calibration._common import AXES, CalibrationError
from ahrs_rs.calibration._fit_result import EllipsoidFit
from ahrs_rs.calibration._model import Calibration

#: Readings whose spread across a plane is more than this share of that along it are of no circle: a tilt of 10° RMS in
#: a field that dips by 60° gives 0.25, and errors that are even about the level leave the centre where it is.
FLATTEST = 0.3
#: The median of |N(0, 1)|.
NORMAL_MEDIAN = 0.674490


def fit(x: FloatArray, parameters: int, norm: float | None, name: str, missing: int) -> EllipsoidFit:
    """The fit of readings (3, n) with 3 or 4 parameters."""
    if parameters == 3 and norm is not None:
        raise ValueError("norm: expected None with parameters=3, as a circle in a plane has no scale, got a number")
    basis = _plane(name, x) if parameters == 3 else np.eye(3)
    # The part across the plane stays as it is: a circle says nothing about it.
    coordinates = basis @ x
    try:
        found = _sphere_fit.fit(coordinates)
    except (_linear.NoEllipsoidError, np.linalg.LinAlgError):
        raise CalibrationError(_advice(name, coordinates)) from None
    keep = found.keep
    used = int(np.count_nonzero(keep))
    _fit_result.check(
        name,
        x.shape[1],
        found.deviation,
        found.radius,
        found.correlation,
        used * found.observability / len(basis),
        "circle" if parameters == 3 else "sphere",
    )
    covariance = found.covariance
    normal: FloatArray | None = None
    if parameters == 3:
        # A plane at a distance d from zero, that tilts by da, moves the centre by d da.
        normal = np.cross(basis[0], basis[1])
        across = normal @ x[:, keep]
        u = coordinates[:, keep] - coordinates[:, keep].mean(axis=1, keepdims=True)
        tilt = np.linalg.inv(u @ u.T) * float(across.var()) * found.correlation
        covariance[1:, 1:] += tilt * float(across.mean()) ** 2
    gain, values, names = 1.0, np.array([found.radius, *found.centre]), ["radius"]
    if norm is not None:
        # S = norm / ρ: dS = −S dρ / ρ
        gain = norm / found.radius
        slope = np.array([-gain / found.radius, *np.ones(len(basis))])
        covariance = covariance * np.outer(slope, slope)
        values, names = np.array([gain, *found.centre]), ["S"]
    names += [f"b_{AXES[int(np.argmax(np.abs(row)))]}" for row in basis]
    centred = coordinates - found.centre[:, None]
    before = _fit_result.deviation(np.sqrt((coordinates**2).sum(axis=0)))
    after = _fit_result.deviation(np.sqrt((centred**2).sum(axis=0)))
    norm_std = float(np.sqrt(found.covariance[0, 0])) if norm is None else 0.0
    std = np.sqrt(np.diag(covariance))
    info: dict[str, Any] = {
        "method": f"{'circle' if parameters == 3 else 'sphere'}, {parameters} parameters",
        "norm": gain * found.radius,
        "norm_std": norm_std,
        "std": dict(zip(names, std.tolist(), strict=True)),
        "norm_deviation_percent": {"before": before, "after": after},
        "samples": used,
        "outliers": len(keep) - used,
    }
    if normal is not None:
        info["plane"] = {"normal": normal.tolist(), "offset along it": "unknown, left as 0"}
    directions = basis.T @ centred[:, keep]
    return EllipsoidFit(
        calibration=Calibration(gain * np.eye(3), basis.T @ found.centre, info),
        norm=info["norm"],
        norm_std=norm_std,
        names=tuple(names),
        values=values,
        covariance=covariance,
        residual_rms=found.deviation * gain,
        residual_max=float((np.abs(found.residual) * keep).max()) * gain,
        correlation=found.correlation,
        deviation_before=before,
        deviation_after=after,
        coverage=_directions.circle_coverage(centred[:, keep]) if parameters == 3 else _directions.coverage(directions),
        observability=found.observability,
        samples=used,
        outliers=len(keep) - used,
        missing=missing,
        left_out=0,
        normal=normal,
    )


def _plane(name: str, x: FloatArray) -> FloatArray:
    """(2, 3) orthonormal axes of the plane that the readings lie in: two of the sensor's axes, put into the plane."""
    if not np.ptp(x, axis=1).any():
        raise CalibrationError(f"{name}: all readings are the same: turn the sensor while recording")
    centred, keep = x - np.median(x, axis=1, keepdims=True), np.ones(x.shape[1], dtype=np.bool_)
    for _ in range(3):  # again without what is far from the plane
        part = centred[:, keep] - centred[:, keep].mean(axis=1, keepdims=True)
        values, vectors = np.linalg.eigh(part @ part.T / part.shape[1])
        across = vectors[:, 0] @ centred
        across -= np.median(across)
        keep = np.abs(across) <= max(
            _ellipsoid_fit.CUT * float(np.median(np.abs(across))) / NORMAL_MEDIAN, 1e-12 * float(values[2]) ** 0.5
        )
    spread = np.sqrt(np.maximum(values, 0.0))
    if spread[1] < _directions.FLAT * spread[2]:
        raise CalibrationError(f"{name}: the readings lie on a line: turn the sensor by a whole turn")
    if spread[0] > FLATTEST * spread[1]:
        raise CalibrationError(
            f"{name}: expected readings in a plane with parameters=3, got a spread of {spread[0]:.3g} across, beside "
            f"{spread[2]:.3g} along it; parameters=4 is for readings in space"
        )
    normal = vectors[:, 0]
    first, second = sorted(np.argsort(np.abs(normal), kind="stable")[:2])
    rows: list[FloatArray] = []
    for axis in (first, second):
        row = np.eye(3)[axis] - normal * normal[axis]
        for before in rows:
            row = row - before * (before @ row)
        rows.append(row / np.linalg.norm(row))
    return np.array(rows)


def _advice(name: str, x: FloatArray) -> str:
    """What readings (d, n) lack."""
    shape = "circle" if len(x) == 2 else "sphere"
    head = f"{name}: the readings do not determine the {len(x) + 1} parameters of a {shape}"
    if len(x) == 2:
        return f"{head}: turn the sensor by a whole turn, or by half of one at least"
    return f"{head}: they saw few directions only: turn the sensor in more of them, at one place"
