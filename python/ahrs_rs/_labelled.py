"""Estimates as labelled arrays of xarray."""

from __future__ import annotations

from typing import Any

from ahrs_rs._optional import require

#: The last dimension of each array: its name and its labels.
LAST: dict[str, tuple[str, list[str]]] = {
    "quat": ("component", ["w", "x", "y", "z"]),
    "euler": ("angle", ["roll", "pitch", "yaw"]),
    "gyr_bias": ("axis", ["x", "y", "z"]),
}
UNITS = {"quat": "1", "euler": "rad", "gyr_bias": "rad/s"}


def dataset(est: Any) -> Any:
    """A ``xarray.Dataset`` of an estimate; arrays are not copied."""
    xarray = require("xarray", "xarray", "to_xarray needs")
    many = est.quat.ndim == 3
    # Stamps of each recording's own are no index, but a coordinate of two dimensions.
    alone = est.t.ndim == 1
    row = "t" if alone else "sample"
    leading = ("recording", row) if many else (row,)
    coordinates: dict[str, Any] = {"t": (("t",) if alone else leading, est.t, {"units": "s"})}
    variables: dict[str, Any] = {}
    arrays = {"quat": est.quat, "euler": est.euler()}
    if est.gyr_bias is not None:
        arrays["gyr_bias"] = est.gyr_bias
    for name, array in arrays.items():
        last, labels = LAST[name]
        variables[name] = ((*leading, last), array, {"units": UNITS[name]})
        coordinates[last] = labels
    for name, array in est.extra.items():
        own = tuple(f"{name}_{k}" for k in range(array.ndim - len(leading)))
        variables[name] = ((*leading, *own), array)
    variables["status"] = (leading, est.status)
    attributes = {"frame": est.frame, "convention": "quaternions scalar-first, sensor to earth frame"}
    return xarray.Dataset(variables, coordinates, attributes)
