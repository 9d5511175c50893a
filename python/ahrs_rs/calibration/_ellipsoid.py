"""The numbers behind ellipsoid calibration: ‖A (x − b)‖ = 1 with A symmetric and positive definite.

Three steps. The start: the linear least squares of Cirillo et al. (eqs 2-6) on random small samples of the data; the
one whose median distance is the smallest is taken (least median of squares), so that up to a third of the readings may
be anything. Readings count there by how few are near to them: a sensor that lay still half of the time has shown one
point of the ellipsoid, through which many ellipsoids pass. The refinement: Gauss-Newton on the residuals
ρ (‖A (x − b)‖ − 1), ρ = det(A)^(-1/3) the mean radius, of all readings within `CUT` robust standard deviations (from
the median of the absolute residuals), until neither parameters nor selection change. (Without ρ residuals would be
relative to the size, and a part of the sphere best fitted by an ellipsoid that is too large.) The uncertainty: the
sandwich H⁻¹ (Σ r² J Jᵀ) H⁻¹, which asks for no law of the noise, times the correlation time of the residuals.

Arrays of readings stand as (3, n) here: a row an axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._common import FloatArray

BoolArray = NDArray[np.bool_]

#: Readings farther from the ellipsoid than so many robust standard deviations are outliers: one in 16,000 normal ones.
CUT = 4.0
#: Random samples of the start. With p + 3 readings each, 200 find one without an outlier among 30 % outliers with
#: probability 1 - (1 - 0.7^12)^200 = 94 % (9 parameters), and among 20 % surely.
DRAWS = 200
#: The start and the robust standard deviation look at so many readings at most.
START_READINGS = 2000
#: Of more readings than these a part is fitted first.
MANY_READINGS = 50_000
#: Readings within this share of the radius are near to each other.
NEAR = 0.05
#: The worst determined combination of parameters has at least so much of the information that evenly spread directions
#: give: its standard deviation is at most 7 times as large, and so is what a disturbed field does to it.
LEAST_OBSERVABILITY = 0.02
#: Centres farther away (in median distances of the readings from their median) are those of a flat piece.
FARTHEST = 30.0
#: Readings that are worked on together: their Jacobian stays in the cache.
CHUNK = 1 << 12
#: Relative residuals below this are rounding: they make no reading an outlier.
ROUNDING = 1e-11
#: A step of the parameters (in units of the radius) below this ends the refinement; the next one would be a hundredth.
CONVERGED = 1e-10
#: While outliers are being chosen, this will do.
NEARLY_CONVERGED = 1e-6
#: So many readings are looked at for the information that their directions give.
DIRECTIONS = 50_000
#: Lags of a correlation that are computed one by one; more of them by a Fourier transform.
DIRECT_LAGS = 32
#: Pairs of axes of the parameters beyond the diagonal.
PAIRS = ((0, 1), (0, 2), (1, 2))
#: The smallest eigenvalue of the information of one reading, where directions are spread evenly: of û_i² against û_j².
EVEN_INFORMATION = 2.0 / 15.0


class NoEllipsoidError(Exception):
    """The least squares gave no ellipsoid."""


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """A fit: parameters θ = (A_xx, A_yy, A_zz, [A_xy, A_xz, A_yz,] b) and what is known of them."""

    matrix: FloatArray
    centre: FloatArray
    covariance: FloatArray
    """Of θ."""
    keep: BoolArray
    """(n,) the readings that are no outliers."""
    residual: FloatArray
    """(n,) ρ (‖A (x − b)‖ − 1), in the unit of the readings."""
    deviation: float
    """Standard deviation of the residuals that are kept."""
    radius: float
    """ρ."""
    correlation: float
    """Correlation time of the residuals in readings, at least 1."""


def fit(x: FloatArray, parameters: int, core: float = 0.5) -> Ellipsoid:
    """The ellipsoid of the readings (3, n), with 6 or 9 parameters.

    Parameters
    ----------
    core : the share of readings that surely belong to it; the robust standard deviation is theirs.

    Raises
    ------
    NoEllipsoidError
    """
    count = x.shape[1]
    random = np.random.default_rng(0)
    few = x if count <= START_READINGS else x[:, random.integers(0, count, START_READINGS)]
    shift = np.median(few, axis=1)
    size = float(np.median(np.linalg.norm(few - shift[:, None], axis=0)))
    if not size > 0:
        raise NoEllipsoidError
    z = (x - shift[:, None]) / size
    few = (few - shift[:, None]) / size
    weights = _weights(few)
    a, b = _start(few, weights, parameters, core, random)
    a, b, keep = _refine(few, few, weights, a, b, parameters, core)
    if observability(a @ (few[:, keep] - b[:, None]), parameters) < LEAST_OBSERVABILITY:
        raise NoEllipsoidError
    if count > MANY_READINGS:
        part = z[:, :: count // MANY_READINGS]
        a, b, _ = _refine(part, few, weights, a, b, parameters, core)
    a, b, keep = _refine(z, few, weights, a, b, parameters, core)

    h, _, residual = _normal_equations(z, a, b, parameters, keep)
    kept = residual[keep]
    freedom = max(len(kept) - parameters, 1)
    correlation = _correlation_time(kept)
    inverse = np.linalg.inv(h).astype(np.float64, copy=False)
    scores, _, _ = _normal_equations(z, a, b, parameters, keep, inverse)
    covariance = inverse @ scores @ inverse * correlation
    deviation = float(np.sqrt(kept @ kept / freedom))
    radius = _radius(a)
    if observability(a @ (z[:, keep] - b[:, None]), parameters) < LEAST_OBSERVABILITY:
        raise NoEllipsoidError
    units = np.array([1.0 / size] * (parameters - 3) + [size] * 3)
    return Ellipsoid(
        # Noise across the radius lengthens a reading of unit length by σ² in the mean.
        matrix=a / size * (1.0 + (deviation / radius) ** 2),
        centre=shift + size * b,
        covariance=covariance * np.outer(units, units),
        keep=keep,
        residual=residual * size,
        deviation=deviation * size,
        radius=radius * size,
        correlation=correlation,
    )


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


def information(y: FloatArray, parameters: int) -> FloatArray:
    """The mean information of a calibrated reading (3, n) about relative changes of S and about b: (p, p).

    Of off-diagonal terms √2 times is counted, so that a rotation of the sensor leaves the eigenvalues as they are.
    """
    y = y[:, :: max(y.shape[1] // DIRECTIONS, 1)]
    u = y / np.sqrt((y * y).sum(axis=0))
    rows = [u * u, -u]
    if parameters == 9:
        rows.insert(1, np.sqrt(2.0) * np.stack([u[i] * u[j] for i, j in PAIRS]))
    stacked = np.concatenate(rows)
    mean: FloatArray = stacked @ stacked.T / u.shape[1]
    return mean


def observability(y: FloatArray, parameters: int) -> float:
    """The smallest eigenvalue of `information` over that of evenly spread directions; 0 where a parameter is free."""
    return max(float(np.linalg.eigvalsh(information(y, parameters))[0]) / EVEN_INFORMATION, 0.0)


def _weights(few: FloatArray) -> FloatArray:
    """One over how many readings are near to each, itself included."""
    near = np.zeros(few.shape[1])
    square = (few * few).sum(axis=0)
    for k in range(0, few.shape[1], 256):
        part = few[:, k : k + 256]
        distance2 = square[k : k + 256, None] + square - 2.0 * part.T @ few
        near[k : k + 256] = np.count_nonzero(distance2 < NEAR**2, axis=1)
    # Rounding may take a reading for far from itself.
    return 1.0 / np.maximum(near, 1.0)


def _quantile(values: FloatArray, weights: FloatArray, share: float) -> float:
    """The value up to which the values have this share of the weight."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[min(int(np.searchsorted(total, share * total[-1])), len(values) - 1)]])


def _start(
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
    found: list[tuple[float, FloatArray, FloatArray]] = []
    for group, own in groups:
        centres = _sphere_centre(group, own)
        m, b, good = _linear_fits(group - centres[:, :, None], own, parameters)
        for one, centre in zip(m[good], (b + centres)[good], strict=True):
            found.append((_quantile(_distance(z, one, centre), weights, core), one, centre))
    found.sort(key=lambda each: each[0])
    best: list[tuple[float, FloatArray, FloatArray]] = found[:1]
    # The best ones are fitted again to the readings that are near to them.
    for _, m, b in found[:10]:
        for _ in range(3):
            distance = _distance(z, m, b)
            near = distance <= _quantile(distance, weights, max(core, min(1.0, size / count)))
            try:
                m, b = algebraic(z[:, near], parameters, weights[near])
            except NoEllipsoidError:
                break
            best.append((_quantile(_distance(z, m, b), weights, core), m, b))
    if not best:
        raise NoEllipsoidError
    _, m, b = min(best, key=lambda each: each[0])
    return _root(m), b


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
    """Distances of the readings from the surface (z − b)ᵀ M (z − b) = 1, to first order."""
    v = z - b[:, None]
    gradient = m @ v
    q = np.sqrt((v * gradient).sum(axis=0))
    length = np.linalg.norm(gradient, axis=0)
    distance: FloatArray = np.abs(q - 1.0) * q / np.where(length > 0, length, 1.0)
    return distance


def _root(m: FloatArray) -> FloatArray:
    """The symmetric positive definite square root."""
    values, vectors = np.linalg.eigh(m)
    root: FloatArray = (vectors * np.sqrt(values)) @ vectors.T
    return root


def _refine(
    z: FloatArray, few: FloatArray, weights: FloatArray, a: FloatArray, b: FloatArray, parameters: int, core: float
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Gauss-Newton with outliers left out, until parameters and selection stay."""
    normal_quantile = {0.5: 0.674490, 0.3: 0.385320}[core]  # of |N(0, 1)|
    keep: BoolArray = np.zeros(z.shape[1], dtype=np.bool_)
    for _ in range(20):
        before = keep
        deviation = _quantile(np.abs(_residuals(few, a, b)), weights, core) / normal_quantile
        keep = np.abs(_residuals(z, a, b)) <= max(CUT * deviation, ROUNDING)
        if np.array_equal(keep, before):
            break
        a, b = _converge(z, a, b, parameters, keep, NEARLY_CONVERGED)
    a, b = _converge(z, a, b, parameters, keep, CONVERGED)
    return a, b, keep


def _converge(
    z: FloatArray, a: FloatArray, b: FloatArray, parameters: int, keep: BoolArray, enough: float
) -> tuple[FloatArray, FloatArray]:
    """Gauss-Newton to a step below `enough`, halved where the sum of squares would grow."""
    h, g, residual = _normal_equations(z, a, b, parameters, keep)
    cost = float((residual[keep] ** 2).sum())
    for _ in range(30):
        try:
            step = np.linalg.solve(h, g).astype(np.float64, copy=False)
        except np.linalg.LinAlgError:
            raise NoEllipsoidError from None
        size = float(np.abs(step).max())
        if not size < FARTHEST or np.linalg.norm(b) > FARTHEST:
            raise NoEllipsoidError
        for _ in range(30):
            tried, moved = a - _symmetric(step[:-3]), b - step[-3:]
            if np.linalg.eigvalsh(tried)[0] > 0:
                h, g, residual = _normal_equations(z, tried, moved, parameters, keep)
                new = float((residual[keep] ** 2).sum())
                # Near the end the cost changes by rounding alone, which is no reason to go back.
                if new <= cost * (1 + 1e-9) + 1e-24 * len(residual):
                    break
            step = 0.5 * step
        else:
            return a, b
        a, b, cost = tried, moved, new
        if size < enough * (1.0 + float(np.abs(b).max())):
            return a, b
    return a, b


def _symmetric(values: FloatArray) -> FloatArray:
    """The symmetric matrix of three values on the diagonal and, with six, three beyond it."""
    matrix = np.diag(values[:3])
    for value, (i, j) in zip(values[3:], PAIRS, strict=False):
        matrix[i, j] = matrix[j, i] = value
    return matrix


def _residuals(z: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    norms = [np.sqrt(((a @ (z[:, i : i + CHUNK] - b[:, None])) ** 2).sum(axis=0)) for i in range(0, z.shape[1], CHUNK)]
    residual: FloatArray = _radius(a) * (np.concatenate(norms) - 1.0)
    return residual


def _radius(a: FloatArray) -> float:
    """The mean radius of ‖A x‖ = 1: that of the sphere of the same volume."""
    radius: float = float(np.linalg.det(a)) ** (-1.0 / 3.0)
    return radius


def _normal_equations(
    z: FloatArray,
    a: FloatArray,
    b: FloatArray,
    parameters: int,
    keep: BoolArray,
    inverse_h: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Σ J Jᵀ and Σ J r over the readings that are kept, and all residuals r.

    With H⁻¹ J is weighted by r / √(1 − Jᵀ H⁻¹ J): the residual, by which the fit has shortened it (MacKinnon and White,
    Journal of Econometrics 29:305-325, 1985: HC2).

    J = ρ (J₀ − f w / 3), where J₀ and f are those of ‖A (x − b)‖ − 1 and w dA = tr(A⁻¹ dA) = −3 dρ/ρ.
    """
    radius, inverse = _radius(a), np.linalg.inv(a)
    w = np.zeros(parameters)
    w[: parameters - 3] = [inverse[i, i] for i in range(3)] + [2.0 * inverse[i, j] for i, j in PAIRS[: parameters - 6]]
    w /= 3.0
    h, g, power = np.zeros((parameters, parameters)), np.zeros(parameters), 0.0
    residual = np.empty(z.shape[1])
    for start in range(0, z.shape[1], CHUNK):
        part = slice(start, start + CHUNK)
        v = z[:, part] - b[:, None]
        y = a @ v
        norm = np.sqrt((y * y).sum(axis=0))
        f = norm - 1.0
        np.multiply(f, radius, out=residual[part])
        kept = keep[part]
        f *= kept
        u = y * (kept / np.maximum(norm, np.finfo(np.float64).tiny))
        j0 = np.empty((parameters, v.shape[1]))
        np.multiply(u, v, out=j0[:3])
        if parameters == 9:
            for k, (i, j) in enumerate(PAIRS):
                np.multiply(u[i], v[j], out=j0[3 + k])
                j0[3 + k] += u[j] * v[i]
        np.matmul(-a, u, out=j0[-3:])
        if inverse_h is not None:
            j0 = radius * (j0 - w[:, None] * f)
            leverage = (j0 * (inverse_h @ j0)).sum(axis=0)
            j0 *= radius * f / np.sqrt(np.maximum(1.0 - leverage, 1e-3))
        h += j0 @ j0.T
        g += j0 @ f
        power += float(f @ f)
    if inverse_h is None:
        cross = np.outer(g, w)
        h = radius**2 * (h - cross - cross.T + power * np.outer(w, w))
        g = radius**2 * (g - power * w)
    return h, g, residual


def _correlation_time(residual: FloatArray) -> float:
    """1 + 2 Σ ρ over the lags up to the first whose correlation ρ is not significant."""
    count = len(residual)
    centred = residual - residual.mean()
    power = float(centred @ centred)
    if not (count > 3 and power > 0):
        return 1.0
    significant = 2.0 / np.sqrt(count)
    total = 1.0
    for lag in range(1, min(DIRECT_LAGS, count // 2)):
        rho = float(centred[lag:] @ centred[:-lag]) / power
        if rho < significant:
            return total
        total += 2.0 * rho
    length = 1 << (2 * count - 1).bit_length()
    spectrum = np.fft.rfft(centred, length)
    correlation = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, length)[1 : count // 2] / power
    low = np.flatnonzero(correlation < significant)
    return float(1.0 + 2.0 * correlation[: int(low[0]) if low.size else None].sum())
