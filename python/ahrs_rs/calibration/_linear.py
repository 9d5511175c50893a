"""The start of an ellipsoid fit: the linear least squares of Cirillo et al. inside of a least median of squares.

Arrays of readings stand as (3, n) here, those of many samples as (B, 3, n).
"""

from __future__ import annotations

import numpy as np

from ahrs_rs._typing import BoolArray, FloatArray

#: Random samples of the start. With p + 3 readings each, 200 find one without an outlier among 30 % outliers with
#: probability 1 - (1 - 0.7^12)^200 = 94 % (9 parameters), and among 20 % surely.
DRAWS = 200
#: Of these so many tell which random samples are the best.
SCREENED = 400
#: So many neighbours tell how close readings are together.
NEIGHBOURS = 10
#: Pairs of axes of the parameters beyond the diagonal.
PAIRS = ((0, 1), (0, 2), (1, 2))


class NoEllipsoidError(Exception):
    """The least squares gave no ellipsoid."""


def robust_start(
    z: FloatArray, weights: FloatArray, parameters: int, core: float, random: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """The linear fit, to all readings or one of many random samples, with the smallest quantile `core` of distances."""
    count = z.shape[1]
    groups = [(z[np.newaxis], weights)]
    size = parameters + 3
    if count >= 2 * size:
        # The smallest of exponential numbers over weights are a sample by weight, without repetition.
        draws = (random.exponential(size=(DRAWS, count)) / weights).argpartition(size, axis=1)[:, :size]
        groups.append((z.T[draws].transpose(0, 2, 1), np.ones(size)))
    part = slice(None, None, max(count // SCREENED, 1))
    matrices, centres = [np.empty((0, 3, 3))], [np.empty((0, 3))]
    for group, own in groups:
        middles = _sphere_centre(group, own)
        m, b, good = _linear_fits(group - middles[:, :, None], own, parameters)
        matrices.append(m[good])
        centres.append((b + middles)[good])
    all_m, all_b = np.concatenate(matrices), np.concatenate(centres)
    screened = quantile(_distance(z[:, part], all_m, all_b[:, :, None]), weights[part], core)
    best = [
        (float(quantile(_distance(z, all_m[k], all_b[k][:, None]), weights, core)), all_m[k], all_b[k])
        for k in np.argsort(screened, kind="stable")[:5]
    ]
    # The best ones are fitted again to the readings that are near to them.
    for _, m, b in best.copy():
        for _ in range(2):
            distance = _distance(z, m, b[:, None])
            near = distance <= quantile(distance, weights, max(core, min(1.0, size / count)))
            try:
                m, b = algebraic(z[:, near], parameters, weights[near])
            except NoEllipsoidError:
                break
            best.append((float(quantile(_distance(z, m, b[:, None]), weights, core)), m, b))
    if not best:
        raise NoEllipsoidError
    _, m, b = min(best, key=lambda each: each[0])
    return _root(m), b


def areas(few: FloatArray) -> FloatArray:
    """The area of the surface that each reading stands for: the square of the distance to its tenth neighbour.

    Areas are cut off at the upper quartile, or a few readings far from all others would count for most.
    """
    count = few.shape[1]
    k = min(NEIGHBOURS, count - 1)
    area = np.empty(count)
    # Differences of what is near must not be lost in the squares of what is far.
    x = few - np.median(few, axis=1, keepdims=True)
    square = (x * x).sum(axis=0)
    for start in range(0, count, 256):
        part = slice(start, start + 256)
        distance2 = square[part, None] + square - 2.0 * x[:, part].T @ x
        area[part] = np.partition(distance2, k, axis=1)[:, k]
    most = float(np.quantile(area, 0.75))
    if not most > 0:
        most = max(float(area.max()), np.finfo(np.float64).tiny)
    weights: FloatArray = np.clip(area, 1e-6 * most, most) / most
    return weights


def quantile(values: FloatArray, weights: FloatArray, share: float) -> FloatArray:
    """The value up to which the values (..., n) have this share of the weight (n,), as (...)."""
    order = np.argsort(values, axis=-1)
    total = np.cumsum(weights[order], axis=-1)
    index = np.minimum((total < share * total[..., -1:]).sum(axis=-1, keepdims=True), values.shape[-1] - 1)
    found: FloatArray = np.take_along_axis(values, np.take_along_axis(order, index, axis=-1), axis=-1)[..., 0]
    return found


def algebraic(x: FloatArray, parameters: int, weights: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Λ² (as the whole matrix) and b by linear least squares (Cirillo eqs 2-6), after a translation to avoid d = 0.

    The translation is to the centre of the sphere that fits best, where d is near 1.
    """
    weights = np.ones(x.shape[1]) if weights is None else weights
    centre = _sphere_centre(x[np.newaxis], weights)
    m, b, good = _linear_fits((x - centre[0][:, None])[np.newaxis], weights, parameters)
    if not good[0]:
        raise NoEllipsoidError
    return m[0], centre[0] + b[0]


def centre_of_sphere(x: FloatArray) -> FloatArray:
    """(3,) the centre of the sphere that fits best to the readings (3, n)."""
    centre: FloatArray = _sphere_centre(x[np.newaxis], np.ones(x.shape[1]))[0]
    return centre


def _sphere_centre(z: FloatArray, weights: FloatArray) -> FloatArray:
    """(B, 3) centres of the spheres |z|² = 2 c·z + k through the readings (B, 3, n), by linear least squares."""
    share = weights / weights.sum()
    mean = (z @ share)[:, :, None]
    centred = z - mean
    square = (centred**2).sum(axis=1, keepdims=True)
    weighted = centred * share
    gram = weighted @ centred.transpose(0, 2, 1)
    right = weighted @ square.transpose(0, 2, 1)
    centre: FloatArray = (mean + 0.5 * _solve(gram, right))[:, :, 0]
    return centre


def _linear_fits(z: FloatArray, weights: FloatArray, parameters: int) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Cirillo eq 6 for each of many sets of readings (B, 3, n): Λ² (B, 3, 3), b (B, 3), where it is an ellipsoid."""
    columns = [z * z]
    if parameters == 9:
        columns.append(np.stack([2.0 * z[:, i] * z[:, j] for i, j in PAIRS], axis=1))
    design = np.concatenate([*columns, -2.0 * z], axis=1)
    scale = np.sqrt((design**2).mean(axis=2, keepdims=True)) + np.finfo(np.float64).tiny
    design = design / scale
    weighted = design * weights
    gram = weighted @ design.transpose(0, 2, 1)
    solution = (_solve(gram, weighted.sum(axis=2, keepdims=True)) / scale)[:, :, 0]
    m = np.zeros((len(z), 3, 3))
    m[:, range(3), range(3)] = solution[:, :3]
    if parameters == 9:
        for k, (i, j) in enumerate(PAIRS):
            m[:, i, j] = m[:, j, i] = solution[:, 3 + k]
    c = solution[:, -3:, None]
    regular = np.abs(np.linalg.det(m)) > np.finfo(np.float64).tiny
    m[~regular] = np.eye(3)
    b = np.linalg.solve(m, c)  # eq 5
    inverse_d = 1.0 + (c * b).sum(axis=1)[:, 0]  # eqs 3, 4: 1/d = 1 + bᵀ Λ̄ b
    squared = m / np.where(inverse_d == 0, 1.0, inverse_d)[:, None, None]  # eq 4: Λ² = d Λ̄
    eigenvalues = np.linalg.eigvalsh(np.where(np.isfinite(squared), squared, 0.0))
    good = regular & (eigenvalues[:, 0] > 1e-9 * np.abs(eigenvalues[:, 2])) & np.isfinite(b).all(axis=(1, 2))
    return squared, b[:, :, 0], good


def _solve(gram: FloatArray, right: FloatArray) -> FloatArray:
    """The solutions of many symmetric systems; where one is singular, the smallest."""
    try:
        solution = np.linalg.solve(gram, right).astype(np.float64, copy=False)
    except np.linalg.LinAlgError:
        solution = (np.linalg.pinv(gram, hermitian=True) @ right).astype(np.float64, copy=False)
    return solution


def _distance(z: FloatArray, m: FloatArray, b: FloatArray) -> FloatArray:
    """Distances (..., n) of the readings from the surfaces (z − b)ᵀ M (z − b) = 1, to first order."""
    v = z - b
    gradient = m @ v
    q = np.sqrt((v * gradient).sum(axis=-2))
    length = np.sqrt((gradient * gradient).sum(axis=-2))
    distance: FloatArray = np.abs(q - 1.0) * q / np.where(length > 0, length, 1.0)
    return distance


def _root(m: FloatArray) -> FloatArray:
    """The symmetric positive definite square root."""
    values, vectors = np.linalg.eigh(m)
    root: FloatArray = (vectors * np.sqrt(values)) @ vectors.T
    return root
