"""The axis of a hinge in the frames of two sensors, from their angular rates and specific forces."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _validate
from ahrs_rs._typing import BoolArray, FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.chain._constraints import LEAST, Readings, fitted, rate_errors, starts, system, tangents_of

__all__ = ["HingeAxis", "hinge_axis"]

#: Smallest eigenvalue of the normal matrix per sample, over the mean square of the angular rates: a motion in which the
#: rate of one sensor leaves the axis by 3° only has 0.003.
DETERMINED = 3e-3
#: Share of the mean square of both rates about one axis, above which a motion is about the hinge alone.
PLANAR = 0.997
#: Over this time, s, the angle of the hinge is integrated to find how the signs of the axes belong together: a bias of
#: 1°/s makes 5° of it.
SPAN = 5.0
#: Blocks, over which errors may be correlated, for the covariance; and the fewest, s and number.
BLOCK, FEWEST = 1.0, 8


@dataclass(frozen=True, slots=True, eq=False)
class HingeAxis:
    """The axis of a hinge, in the frame of each sensor.

    Parameters
    ----------
    first : ndarray
        (3,) unit vector in the frame of the first sensor; its largest component is positive.
    second : ndarray
        (3,) the same direction in the frame of the second sensor.
    std : ndarray
        (2,) standard deviation of the direction of each, rad (root of the sum over both tangents). It follows from how
        blocks of 1 s scatter, so that correlated errors count; what is wrong all the time is not in it.
    residual : float
        RMS of the difference of the rates perpendicular to the axis, rad/s: of a real hinge it is that of the noise.
    sign_agreement : float
        From -1 to 1: how well the signs of both axes, as given, explain how the rates turn against each other, less how
        well opposite signs do. Near 0 the motion does not tell.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.chain.HingeAxis(np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.zeros(2), 0.0, 1.0)
    HingeAxis(first=[0. 1. 0.], second=[1. 0. 0.], std=0°, 0°)
    """

    first: FloatArray
    second: FloatArray
    std: FloatArray
    residual: float
    sign_agreement: float

    def __repr__(self) -> str:
        one, other = (np.array2string(each, precision=4) for each in (self.first, self.second))
        degrees = ", ".join(f"{value:.2g}°" for value in np.degrees(self.std))
        return f"HingeAxis(first={one}, second={other}, std={degrees})"


def hinge_axis(
    gyr1: ArrayLike,
    gyr2: ArrayLike,
    acc1: ArrayLike | None = None,
    acc2: ArrayLike | None = None,
    *,
    t: ArrayLike | None = None,
    rate: float | None = None,
    lever: float = 0.1,
) -> HingeAxis:
    """The axis of a hinge in the frames of two sensors, from any motion that is not about the hinge alone.

    Parameters
    ----------
    gyr1 : array_like
        (T, 3) angular rates of the first sensor, rad/s; rows with a NaN are left out.
    gyr2 : array_like
        (T, 3) those of the second sensor, at the same times.
    acc1 : array_like, optional
        (T, 3) specific forces of the first sensor, m/s²; with `acc2`. They help where the motion is slow, and tell how
        the signs of the axes belong together.
    acc2 : array_like, optional
        (T, 3) those of the second sensor.
    t : array_like, optional
        (T,) times in s; or `rate`.
    rate : float, optional
        Hz, for readings without stamps.
    lever : float, optional
        M from the axis to the sensors, about: with fast turns the forces count less.

    Returns
    -------
    HingeAxis
        Axes, uncertainty, and what is left.

    Raises
    ------
    ValueError
        Shapes that differ, too few samples, or a motion that does not determine the axes (the message says why).

    Notes
    -----
    The sum of squares of the difference of the lengths of ω1 × j1 and ω2 × j2 (Seel, Schauer and Raisch, IEEE CCA 2012)
    and, with forces, of j1·f1 - j2·f2 (Olsson et al., FUSION 2019 and Sensors 20(12):3534, 2020), weighted, is
    minimised from ten starts. How the signs belong together follows from the forces, or from the rates: what of them is
    perpendicular to the axis turns in one sensor against the other by the angle of the hinge.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> t = np.arange(2000) / 100.0
    >>> thigh = np.column_stack([np.sin(t), np.cos(2.0 * t), np.sin(3.0 * t)])
    >>> bend, speed = np.sin(4.0 * t), 4.0 * np.cos(4.0 * t)
    >>> back = ar.rotation.inverse(ar.rotation.about_axis("y", bend))
    >>> shank = ar.rotation.rotate(back, thigh) + speed[:, np.newaxis] * [0.0, 1.0, 0.0]
    >>> found = ar.chain.hinge_axis(thigh, shank, rate=100.0)
    >>> found.first.round(3) + 0.0, found.second.round(3) + 0.0
    (array([0., 1., 0.]), array([0., 1., 0.]))
    """
    g1, g2 = _readings("gyr1", gyr1), _readings("gyr2", gyr2)
    if (acc1 is None) != (acc2 is None):
        raise ValueError(f"{'acc1' if acc1 is None else 'acc2'}: expected specific forces of both sensors, got None")
    forces = None if acc1 is None or acc2 is None else (_readings("acc1", acc1), _readings("acc2", acc2))
    for name, each in (("gyr2", g2), *(zip(("acc1", "acc2"), forces, strict=True) if forces else ())):
        if each.shape != g1.shape:
            raise ValueError(f"{name}: expected the shape of gyr1, {g1.shape}, got {each.shape}")
    times = _validate.times("t", t, rate, len(g1))
    known: BoolArray = np.logical_not(np.isnan(np.hstack([g1, g2])).any(axis=1))
    if np.count_nonzero(known) < LEAST:
        raise ValueError(f"gyr1, gyr2: expected at least {LEAST} rows without NaN, got {np.count_nonzero(known)}")
    data = Readings.of(times, g1, g2, forces, known, positive("lever", lever))
    _refuse_planar(data)
    found = min((fitted(one, data.some(), forces=False) for one in starts(data)), key=lambda one: one[1])[0]
    found, _ = fitted(found, data, forces=False)
    agreement = _agreement(found, data)
    if data.forces is not None:
        # With the right signs j1·f1 = j2·f2: whichever says it more clearly decides.
        agreement = max(agreement, _force_agreement(found, data), key=abs)
    if agreement < 0.0:
        found = np.stack([found[0], -found[1]])
        agreement = -agreement
    std = _deviations(found, data, forces=False)
    if data.forces is not None:
        # Lever arms in fast turns can make forces worse than nothing: the fit with the smaller deviations counts.
        other, _ = fitted(found, data, forces=True)
        deviations = _deviations(other, data, forces=True)
        if not np.sum(deviations**2) >= np.sum(std**2):
            found, std = other, deviations
    if found[0, int(np.argmax(np.abs(found[0])))] < 0.0:
        found = -found
    error, _ = rate_errors(found, data)
    return HingeAxis(found[0], found[1], std, float(np.sqrt(np.mean(error**2))), float(agreement))


def _readings(name: str, given: ArrayLike) -> FloatArray:
    rows = _validate.rows(name, given, 3).astype(np.float64, copy=False)
    if rows.ndim != 2:
        raise ValueError(f"{name}: expected shape (T, 3), got {rows.shape}")
    return rows


def _refuse_planar(data: Readings) -> None:
    shares = []
    for name, rates in zip(("gyr1", "gyr2"), data.rates, strict=True):
        values = np.linalg.eigvalsh(rates.T @ rates)
        if not values[-1] > 0.0:
            raise ValueError(f"{name}: expected a motion, got none: it does not determine the axis")
        shares.append(values[-1] / values.sum())
    if min(shares) > PLANAR:
        raise ValueError(
            "gyr1, gyr2: expected a motion that is not about one axis alone, got such a one in both sensors: if it is "
            "that of the hinge, functional_axis gives it"
        )


def _agreement(axes: FloatArray, data: Readings) -> float:
    """How well the signs of both axes fit: 1 where they do, -1 where opposite signs do.

    Perpendicular to the axis both rates are one vector, which the second sensor sees turned back by the angle θ of the
    hinge, θ' = ω2·j2 - ω1·j1. In the complex plane across each axis z2 = z1 exp(-iθ) times a constant. With j2 of the
    wrong sign z2 is conjugate and θ' wrong, and the constant wanders.
    """
    tangents = tangents_of(axes)
    z1, z2 = (
        rates @ plane[:, 0] + 1j * (rates @ plane[:, 1]) for rates, plane in zip(data.rates, tangents, strict=True)
    )
    about1, about2 = (rates @ axis for rates, axis in zip(data.rates, axes, strict=True))
    step = np.append(0.0, np.diff(data.t))
    block = np.floor((data.t - data.t[0]) / SPAN).astype(np.intp)
    weight = np.sum(np.abs(z1 * z2))
    if not weight > 0.0:
        return 0.0
    found = []
    for sign in (1.0, -1.0):
        angle = np.cumsum((sign * about2 - about1) * step)
        turned = (z2 if sign > 0.0 else np.conj(z2)) * np.conj(z1) * np.exp(1j * angle)
        sums = np.zeros(block[-1] + 1, dtype=np.complex128)
        np.add.at(sums, block, turned)
        found.append(float(np.sum(np.abs(sums)) / weight))
    return found[0] - found[1]


def _force_agreement(axes: FloatArray, data: Readings) -> float:
    """The same by the forces: the correlation of j1·f1 and j2·f2 about zero."""
    assert data.forces is not None
    a, b = (force @ axis / data.force_std for force, axis in zip(data.forces, axes, strict=True))
    size = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / size if size > 0.0 else 0.0


def _deviations(axes: FloatArray, data: Readings, *, forces: bool) -> FloatArray:
    """Standard deviations of both axes, from sums of the gradient over blocks; ValueError where they are left open.

    (JᵀJ)⁻¹ Σ_b s_b s_bᵀ (JᵀJ)⁻¹ with s_b the gradient of block b: right whatever the correlation within a block.
    """
    _, bare = rate_errors(axes, data)
    least, vector = (each[..., 0] for each in np.linalg.eigh(bare.T @ bare / len(bare)))
    mean_square = float(np.mean(np.sum(data.rates**2, axis=2)))
    if least < DETERMINED * mean_square and not forces:
        if data.forces is not None:
            return np.full(2, np.inf)
        which = "gyr1" if np.sum(vector[:2] ** 2) > 0.5 else "gyr2"
        raise ValueError(
            f"{which}: expected a motion that determines the axis in its frame, got one that leaves it open: turn both "
            "segments about several axes, or give acc1 and acc2"
        )
    error, columns, inside = system(axes, data, forces)
    count = max(math.ceil((data.t[-1] - data.t[0]) / BLOCK), 1)
    block = np.minimum((np.arange(len(data.t)) * max(count, FEWEST)) // len(data.t), max(count, FEWEST) - 1)
    block = np.append(block, block[data.force_rows]) if forces else block
    scores = np.zeros((int(block.max()) + 1, 4))
    np.add.at(scores, block, columns * error[:, np.newaxis])
    # The derivative of Huber's gradient: nothing where an error is far out.
    normal = columns[inside].T @ columns[inside]
    values = np.linalg.eigvalsh(normal)
    if not values[0] > 1e-9 * values[-1]:
        raise ValueError("gyr1, gyr2: expected a motion that determines both axes, got one that leaves one open")
    inverse = np.linalg.inv(normal)
    variance = np.diag(inverse @ (scores.T @ scores) @ inverse)
    std: FloatArray = np.sqrt(np.array([variance[:2].sum(), variance[2:].sum()]))
    return std
