"""The signs of gravity and of the field: only what is known from outside tells them.

−a turns as a does. `up` says which axis of the sensor was up when the recording began (or at its first rest), `place`
whether the field points into the earth there.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._check import _changes, _chips
from ahrs_rs._check._case import Case
from ahrs_rs._check._findings import Finding

FloatArray = NDArray[np.float64]

#: An axis that is up has at least this part of gravity on it.
UPRIGHT = 0.7
#: Nearer to the magnetic equator than this dip, rad, the field's sign is not told.
DIP = np.radians(20.0)
#: Part of the cells that have to agree.
AGREE = 0.9


def up_vector(up: str) -> FloatArray:
    """The unit vector of "z", "-y" and the like; ValueError for anything else."""
    text = up.strip().lower().removeprefix("+")
    if text.removeprefix("-") not in ("x", "y", "z"):
        raise ValueError(f"up: expected one of x, y, z with its sign, like 'z' or '-y', got {up!r}")
    vector = np.zeros(3)
    vector["xyz".index(text[-1])] = -1.0 if text.startswith("-") else 1.0
    return vector


def first_gravity(case: Case) -> FloatArray | None:
    """Direction of the specific force at the first rest, or over the first two seconds."""
    if "acc" not in case.has:
        return None
    cells = case.cells("acc")
    known = np.flatnonzero(cells.share > 0.05)
    if not known.size:
        return None
    still = np.flatnonzero(case.still()[: len(cells.t)])
    early = still[cells.t[still] - cells.t[0] < 10.0][:4] if still.size else still
    chosen = early if early.size else known[:4]
    mean = cells.mean[chosen].mean(axis=0)
    norm = float(np.linalg.norm(mean))
    return mean / norm if norm > 0.0 else None


def up_sign(case: Case, matrix: FloatArray) -> int:
    """1 or -1, the sign with which `matrix` times the readings points up; 0 where it is not known."""
    gravity = first_gravity(case)
    if case.up is None or gravity is None:
        return 0
    shown = float(up_vector(case.up) @ (matrix @ gravity))
    return int(np.sign(shown)) if abs(shown) > UPRIGHT else 0


def dip_sign(case: Case, sensor: str, matrix: FloatArray) -> int:
    """1 or -1, the sign with which `matrix` times the readings of a sensor agrees with the dip of the place."""
    expected = expected_dip(case)
    if expected is None or abs(expected) < DIP or not {"acc", "mag"} <= set(case.has):
        return 0
    below = _downward(case, {sensor: matrix})
    if below is None or max(below, 1.0 - below) < AGREE:
        return 0
    return 1 if (below > 0.5) == (expected > 0.0) else -1


def expected_dip(case: Case) -> float | None:
    """Of the earth's field at the place, rad, positive where it points down."""
    if case.place is None:
        return None
    if "dip" not in case.known:
        try:
            from ahrs_rs import earth

            case.known["field"] = earth.field(*case.place, case.date)
            case.known["dip"] = case.known["field"].dip
        except ImportError:  # the field of a dipole along the axis: enough for a sign
            lat = np.radians(case.place[0])
            case.known["dip"] = float(np.arctan(2.0 * np.tan(lat)))
    return float(case.known["dip"])


def _downward(case: Case, matrices: dict[str, FloatArray]) -> float | None:
    """Part of the cells in which the field points down, as seen by the accelerometer."""
    acc, mag = case.cells("acc"), case.cells("mag")
    count = min(len(acc.t), len(mag.t))
    known = (acc.share[:count] > 0.05) & (mag.share[:count] > 0.0)
    known &= (np.linalg.norm(acc.mean[:count], axis=1) > 0.0) & (np.linalg.norm(mag.mean[:count], axis=1) > 0.0)
    if np.count_nonzero(known) < 8:
        return None
    a = acc.mean[:count][known] @ matrices.get("acc", np.eye(3)).T
    m = mag.mean[:count][known] @ matrices.get("mag", np.eye(3)).T
    product = np.einsum("ij,ij->i", a, m)
    product = product[np.isfinite(product)]
    return float(np.mean(product < 0.0)) if len(product) >= 8 else None


def check_signs(case: Case) -> Iterator[Finding]:
    """Findings about the signs of gravity and of the field, where `up` or `place` is given."""
    unturned = "acc" not in case.rotations
    if case.up is not None and "acc" in case.has and unturned:
        yield from _up(case)
    if case.place is not None and {"acc", "mag"} <= set(case.has):
        yield from _dip(case)


def _up(case: Case) -> Iterator[Finding]:
    gravity = first_gravity(case)
    assert case.up is not None
    if gravity is None:
        return
    shown = float(up_vector(case.up) @ gravity)
    if shown < -UPRIGHT:
        case.rotations["acc"] = -np.eye(3)
        yield Finding(
            "acc.sign",
            "error",
            f"{case.up} was up, and the accelerometer reads {9.81 * shown:.3g} m/s² there: its sign is the other one",
            shown,
            "g",
            0.97,
            "the world is upside down",
            "negate the accelerometer: at rest it reads +9.81 m/s² upwards",
            {"up": case.up},
            _changes.turned("acc.sign", "acc", -np.eye(3), "acc: negated"),
        )
    elif shown > UPRIGHT:
        yield Finding("acc.sign", "ok", f"{case.up} was up, as the accelerometer says", shown, "g", 0.97)
    else:
        axis = int(np.argmax(np.abs(gravity)))
        named = ("-" if gravity[axis] < 0.0 else "") + "xyz"[axis]
        yield Finding(
            "acc.sign",
            "warning",
            f"{case.up} was up, but the accelerometer shows {named} up",
            shown,
            "g",
            0.7,
            "up is drawn to another axis",
            "check up=, and the axes of the accelerometer",
            {"up": case.up, "axis": _chips.axes_of(np.eye(3))},
        )


def _dip(case: Case) -> Iterator[Finding]:
    expected = expected_dip(case)
    assert expected is not None
    if abs(expected) < DIP:
        yield Finding(
            "mag.sign", "note", "cannot tell the sign of the field near the magnetic equator", expected, "rad"
        )
        return
    below = _downward(case, {})
    if below is None:
        return
    sure = max(below, 1.0 - below) >= AGREE
    right = (below > 0.5) == (expected > 0.0)
    direction = "into the earth" if expected > 0.0 else "out of the earth"
    if right or not sure:
        message = f"the field points {direction}, as it does at this place"
        if not sure:
            message = "cannot tell the sign of the field: its dip varies too much"
        yield Finding("mag.sign", "ok" if sure else "note", message, below, "of the time", 0.9)
        return
    settled = case.up is not None
    change = _changes.turned("mag.sign", "mag", -np.eye(3), "mag: negated") if settled else None
    if settled:
        case.rotations["mag"] = -case.rotations.get("mag", np.eye(3))
    yield Finding(
        "mag.sign",
        "error",
        f"the field does not point {direction}, as it does at this place: the magnetometer"
        + ("" if settled else " or the accelerometer")
        + " has the other sign",
        below,
        "of the time",
        0.95,
        "the heading is half a turn off",
        "negate the magnetometer" + ("" if settled else ", or the accelerometer: up= tells which"),
        {"expected_dip": expected},
        change,
    )
