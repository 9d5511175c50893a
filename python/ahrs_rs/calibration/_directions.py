"""Which directions readings have seen, and what to record where they are not enough."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._typing import FloatArray
from ahrs_rs.calibration import _ellipsoid_fit, _linear, _sphere_fit
from ahrs_rs.calibration._common import AXES, CalibrationError

#: Cells of equal area: bands of equal height (Archimedes) times sectors.
BANDS, SECTORS = 6, 12
#: A half axis was seen where a reading is within 45° of it.
SEEN = np.cos(np.pi / 4)
#: Readings whose spread across a plane is less than this share of that along it lie in a plane: so does a cap of 20°.
FLAT = 0.1


def cells(y: FloatArray) -> NDArray[np.int64]:
    """(n,) the cell of the sphere that each reading (3, n) is in, by bands from −z up."""
    u = y / np.sqrt((y * y).sum(axis=0))
    band = np.clip(((u[2] + 1.0) * (0.5 * BANDS)).astype(np.int64), 0, BANDS - 1)
    found: NDArray[np.int64] = band * SECTORS + _sectors(u)
    return found


def coverage(y: FloatArray) -> float:
    """Share of the cells of the sphere in which there is a reading (3, n)."""
    return float(np.count_nonzero(np.bincount(cells(y), minlength=BANDS * SECTORS))) / (BANDS * SECTORS)


def circle_coverage(y: FloatArray) -> float:
    """Share of the sectors of the circle in which there is a reading (2, n)."""
    return float(np.count_nonzero(np.bincount(_sectors(y), minlength=SECTORS))) / SECTORS


def _sectors(y: FloatArray) -> NDArray[np.int64]:
    found: NDArray[np.int64] = ((np.arctan2(y[1], y[0]) / (2.0 * np.pi) + 0.5) * SECTORS).astype(np.int64) % SECTORS
    return found


def check_spread(name: str, x: FloatArray) -> None:
    """Refuse readings (3, n) that are all the same, or lie on a line or in a plane."""
    if not np.ptp(x, axis=1).any():
        raise CalibrationError(f"{name}: all readings are the same: turn the sensor in all directions while recording")
    values, vectors = np.linalg.eigh(np.cov(x))
    spread = np.sqrt(np.maximum(values, 0.0))
    if spread[0] >= FLAT * spread[1]:
        return
    normal = vectors[:, 0]
    axis = int(np.argmax(np.abs(normal)))
    others = " and ".join(one for k, one in enumerate(AXES) if k != axis)
    where = "on a line" if spread[1] < FLAT * spread[2] else "in a plane"
    raise CalibrationError(
        f"{name}: the readings lie {where}, and say nothing about the axis {AXES[axis]} (their spread along "
        f"({', '.join(f'{part:.2f}' for part in normal)}) is {spread[0]:.2g}, beside {spread[2]:.2g}): turn the sensor "
        f"about {others} too, until {_pointing(name, AXES[axis])} and {_pointing(name, '-' + AXES[axis])}"
        + ("; or, for a heading in this plane alone, parameters=3" if name == "mag" and where == "in a plane" else "")
    )


def advice(name: str, x: FloatArray, parameters: int, motion: bool) -> str:
    """What readings lack that do not determine an ellipsoid."""
    head = f"{name}: the readings do not determine {parameters} parameters"
    few = ""
    if parameters == 9 and _determined(lambda: _ellipsoid_fit.fit(x, 6, motion)):
        few = "; parameters=6 would do with these"
    elif name == "mag" and _determined(lambda: _sphere_fit.fit(x)):
        few = "; parameters=4, hard iron alone, would do with these"
    # About the centre of the best sphere, or, as a cloud of readings looks like a sphere of its own, about zero.
    centre = _linear.centre_of_sphere(x)
    unseen = _unseen(x - centre[:, None]) or ([] if few else _unseen(x))
    if len(unseen) > 3:
        return f"{head}: they saw few directions only: turn the sensor in all directions, upside down too{few}"
    if unseen:
        side = " (turn the sensor upside down too)" if "-z" in unseen else ""
        listed = ", ".join(_pointing(name, half) for half in unseen)
        return f"{head}: nothing was recorded with {listed}{side}{few}"
    share = coverage(x - centre[:, None])
    seen = f"{share:.0%} of the directions were recorded"
    if parameters == 9 and few:
        return f"{head}: {seen}; record attitudes between those with an axis up or down, tilted by about 45°{few}"
    return f"{head}: {seen}, or they lie on no ellipsoid; turn the sensor slowly in all directions, at one place"


def _determined(fit: Callable[[], object]) -> bool:
    """Whether a fit is one that the readings determine."""
    try:
        fit()
    except (_linear.NoEllipsoidError, np.linalg.LinAlgError):
        return False
    return True


def _unseen(about: FloatArray) -> list[str]:
    """The half axes that no reading (3, n) is within 45° of."""
    norm = np.linalg.norm(about, axis=0)
    directions = about[:, norm > 0] / norm[norm > 0]
    return [
        sign + AXES[axis]
        for axis in range(3)
        for sign, side in (("", 1.0), ("-", -1.0))
        if (side * directions[axis]).max(initial=-1.0) < SEEN
    ]


def _pointing(name: str, half: str) -> str:
    if name == "acc":
        return f"{half[-1]} pointing {'down' if half.startswith('-') else 'up'}"
    return f"the field along {'−' if half.startswith('-') else '+'}{half[-1]}"
