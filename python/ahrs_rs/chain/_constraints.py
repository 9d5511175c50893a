"""The constraints of a hinge on what two sensors read, and the axes that fit them best.

The parts of the angular rates that are perpendicular to the axis have one length (T. Seel, T. Schauer and J. Raisch,
"Joint axis and position estimation from inertial measurement data by exploiting kinematic constraints", IEEE CCA 2012):

    e_ω = |ω1 × j1| - |ω2 × j2| = 0,

which leaves the sign of each axis open. The specific force of a point on the axis is that of both segments. Those of
the sensors differ from it by what their lever arms make of angular rates and accelerations, so along the axis

    e_f = j1·f1 - j2·f2 ≈ 0

where the turns are slow (F. Olsson, T. Seel, D. Lehmann and K. Halvorsen, "Joint axis estimation for fast and slow
movements using weighted gyroscope and acceleration constraints", FUSION 2019; F. Olsson, M. Kok, T. Seel and K.
Halvorsen, "Robust plug-and-play joint axis estimation using inertial sensors", Sensors 20(12):3534, 2020). Their
weights follow from the noise; ours, for e_f, from what a lever arm ℓ does, with α for dω/dt:
σ² + (ℓ (|ω1|² + |ω2|² + |α1| + |α2|))². What is still far out is weighted down by Huber's rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._rate import median
from ahrs_rs._typing import BoolArray, FloatArray

#: Samples with which the starts are compared.
SOME = 1000
ROUNDS = 50
#: The search ends where the axes move by less, rad.
SETTLED = 1e-9
#: Huber's constant, in standard deviations: 95 % efficiency for normal errors.
HUBER = 1.345
#: A median of absolute values times this is a standard deviation of normal errors.
NORMAL = 1.4826
#: Error of j·f at rest, m/s²: biases and scale factors of accelerometers.
FORCE = 0.2
#: Samples that are needed.
LEAST = 20


@dataclass(frozen=True, slots=True, eq=False)
class Readings:
    """What was read by both sensors, without the rows in which something is missing."""

    t: FloatArray
    rates: FloatArray
    """(2, n, 3)"""
    forces: FloatArray | None
    """(2, m, 3) of the rows in which both have one"""
    force_rows: NDArray[np.intp]
    """(m,)"""
    force_std: FloatArray
    """(m,) of j1·f1 - j2·f2"""

    @classmethod
    def of(
        cls,
        t: FloatArray,
        g1: FloatArray,
        g2: FloatArray,
        forces: tuple[FloatArray, FloatArray] | None,
        known: BoolArray,
        lever: float,
    ) -> Readings:
        stamps, rates = t[known], np.stack([g1[known], g2[known]])
        none = np.zeros(0, dtype=np.intp)
        if forces is None:
            return cls(stamps, rates, None, none, np.zeros(0))
        both = np.stack([each[known] for each in forces])
        there = np.flatnonzero(~np.isnan(both).any(axis=(0, 2)))
        if len(there) < LEAST:
            return cls(stamps, rates, None, none, np.zeros(0))
        size = np.sum(np.linalg.norm(rates, axis=2) ** 2, axis=0)
        step = np.diff(stamps)
        step = np.maximum(step, median(step[step > 0.0]) if (step > 0.0).any() else 1.0)
        slope = np.sum(np.linalg.norm(np.diff(rates, axis=1), axis=2), axis=0) / step
        size += np.maximum(np.append(slope, slope[-1]), np.append(slope[0], slope))
        return cls(stamps, rates, both[:, there], there, np.hypot(FORCE, lever * size[there]))

    def some(self) -> Readings:
        part = slice(None, None, max(self.rates.shape[1] // SOME, 1))
        return Readings(self.t[part], self.rates[:, part], None, np.zeros(0, dtype=np.intp), np.zeros(0))


def starts(data: Readings) -> list[FloatArray]:
    """Pairs of axes: where the rates are largest, and the axes of the sensors in all pairs."""
    principal = np.stack([np.linalg.eigh(rates.T @ rates)[1][:, -1] for rates in data.rates])
    return [principal, *(np.stack([a, b]) for a in np.eye(3) for b in np.eye(3))]


def tangents_of(axes: FloatArray) -> FloatArray:
    """(2, 3, 2): two unit vectors perpendicular to each axis, whose cross product is the axis.

    Duff et al., "Building an orthonormal basis, revisited", Journal of Computer Graphics Techniques 6(1), 2017.
    """
    x, y, z = axes.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    found: FloatArray = np.array([[1.0 + sign * x * x * a, b], [sign * b, sign + y * y * a], [-sign * x, -y]])
    return np.moveaxis(found, 2, 0)


def rate_errors(axes: FloatArray, data: Readings) -> tuple[FloatArray, FloatArray]:
    """e_ω and its derivatives (n, 4) by the tangents of both axes."""
    lengths, slopes = [], []
    for rates, axis, tangents in zip(data.rates, axes, tangents_of(axes), strict=True):
        across = rates @ tangents  # of ω × j, whose length is that of what is left of ω
        length = np.hypot(across[:, 0], across[:, 1])
        # |ω × j|² = |ω|² - (ω·j)², so d|ω × j| = -(ω·j) (ω·dj) / |ω × j|
        slopes.append(across * (-(rates @ axis) / np.where(length > 0.0, length, 1.0))[:, np.newaxis])
        lengths.append(length)
    return lengths[0] - lengths[1], np.hstack([slopes[0], -slopes[1]])


def _force_errors(axes: FloatArray, data: Readings) -> tuple[FloatArray, FloatArray]:
    """e_f in its standard deviations, and its derivatives (n, 4)."""
    assert data.forces is not None
    parts = np.einsum("snk,skm->snm", data.forces, tangents_of(axes))
    error = data.forces[0] @ axes[0] - data.forces[1] @ axes[1]
    return error / data.force_std, np.hstack([parts[0], -parts[1]]) / data.force_std[:, np.newaxis]


def _weighted(error: FloatArray, columns: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """In standard deviations, found by the median, times the roots of Huber's weights; and where those are 1."""
    scale = max(NORMAL * median(np.abs(error)), 1e-12)
    size = np.abs(error) / scale
    inside: BoolArray = size <= HUBER
    root = np.sqrt(np.where(inside, 1.0, HUBER / np.maximum(size, HUBER))) / scale
    return root * error, root[:, np.newaxis] * columns, inside


def system(axes: FloatArray, data: Readings, forces: bool) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Errors and derivatives of all constraints; with forces weighted."""
    error, columns = rate_errors(axes, data)
    if not forces:
        return error, columns, np.ones(len(error), dtype=np.bool_)
    first, second = _weighted(error, columns), _weighted(*_force_errors(axes, data))
    return np.append(first[0], second[0]), np.vstack([first[1], second[1]]), np.append(first[2], second[2])


def fitted(axes: FloatArray, data: Readings, *, forces: bool) -> tuple[FloatArray, float]:
    """Levenberg and Marquardt from a start, and the mean square of e_ω that is left.

    With forces the weights follow the errors (iteratively reweighted least squares).
    """
    damping = 1e-3
    for _ in range(ROUNDS):
        error, columns, _ = system(axes, data, forces)
        normal = columns.T @ columns
        scale = float(np.trace(normal)) / 4.0
        if not scale > 0.0:
            break
        change = np.asarray(np.linalg.solve(normal + damping * scale * np.eye(4), -columns.T @ error), dtype=np.float64)
        tried = _moved(axes, change)
        # With forces the weights change from round to round, and costs cannot be compared.
        settled = bool(np.linalg.norm(change) < SETTLED)
        if forces or settled or np.sum(rate_errors(tried, data)[0] ** 2) <= np.sum(error**2):
            axes, damping = tried, max(damping / 10.0, 1e-9)
        else:
            damping *= 10.0
        if settled or damping > 1e6:
            break
    return axes, float(np.mean(rate_errors(axes, data)[0] ** 2))


def _moved(axes: FloatArray, change: FloatArray) -> FloatArray:
    turned = axes + np.einsum("skm,sm->sk", tangents_of(axes), change.reshape(2, 2))
    moved: FloatArray = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return moved
