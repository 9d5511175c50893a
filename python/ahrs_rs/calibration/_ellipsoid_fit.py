"""The numbers behind ellipsoid calibration: ‖A (x − b)‖ = 1 with A symmetric and positive definite.

Three steps. The start: the linear least squares of Cirillo et al. (eqs 2-6) on random small samples of the data; the
one whose median distance is the smallest is taken (least median of squares), so that up to a third of the readings may
be anything. Readings count there by the area that they stand for: a sensor that lay still half of the time has shown
one point of the ellipsoid, through which many ellipsoids pass. The refinement: Gauss-Newton on the residuals
ρ (‖A (x − b)‖ − 1), ρ = det(A)^(-1/3) the mean radius, of all readings within `CUT` robust standard deviations (from
the median of the absolute residuals), until neither parameters nor selection change. (Without ρ residuals would be
relative to the size, and a part of the sphere best fitted by an ellipsoid that is too large.) The uncertainty: the
sandwich H⁻¹ (Σ r² J Jᵀ) H⁻¹, which asks for no law of the noise, times the correlation time of the residuals.

Arrays of readings stand as (3, n) here: a row an axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ahrs_rs._typing import BoolArray, FloatArray
from ahrs_rs.calibration._linear import PAIRS, NoEllipsoidError, areas, quantile, robust_start
from ahrs_rs.calibration._sums import gradient, mean_radius, normal_equations, residuals, symmetric

#: Readings farther from the ellipsoid than so many robust standard deviations are outliers: one in 16,000 normal ones.
CUT = 4.0
WIDE_CUT = 1.5 * CUT
#: The share of readings that surely belong to the ellipsoid, by whose residuals the robust standard deviation goes.
CORE, CORE_IN_MOTION = 0.5, 0.3
#: The quantiles of |N(0, 1)| at these shares.
NORMAL_QUANTILES = {CORE: 0.674490, CORE_IN_MOTION: 0.385320}
#: The start and the robust standard deviation look at so many readings at most.
START_READINGS = 1000
#: Of more readings than these a part is fitted first.
MANY_READINGS = 50_000
#: The worst determined combination of parameters has at least so much of the information that evenly spread directions
#: give: its standard deviation is at most 7 times as large, and so is what a disturbed field does to it.
LEAST_OBSERVABILITY = 0.02
#: Centres farther away (in median distances of the readings from their median) are those of a flat piece.
FARTHEST = 30.0
#: Passes over many readings, of which three or four are needed.
MANY_PASSES = 10
#: The change of a parameter (in units of the radius) over which a derivative is taken as a difference.
DIFFERENCE = 1e-4
#: Relative residuals below this are rounding: they make no reading an outlier.
ROUNDING = 1e-11
#: A step of the parameters (in units of the radius) below this ends the refinement; the next one would be a hundredth.
CONVERGED = 1e-10
#: While outliers are being chosen, this will do.
NEARLY_CONVERGED = 1e-5
#: So many readings are looked at for the information that their directions give.
DIRECTIONS = 50_000
#: Lags of a correlation that are computed one by one; more of them by a Fourier transform.
DIRECT_LAGS = 32
#: The smallest eigenvalue of the information of one reading, where directions are spread evenly: of û_i² against û_j².
EVEN_INFORMATION = 2.0 / 15.0


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
    directions: FloatArray
    """(3, m) calibrated readings that are no outliers, of many some `DIRECTIONS`."""
    observability: float
    """By these directions."""


def fit(x: FloatArray, parameters: int, motion: bool = False) -> Ellipsoid:
    """The ellipsoid of the readings (3, n), with 6 or 9 parameters.

    Parameters
    ----------
    motion : many readings are those of an accelerometer in motion: three in ten are enough of an ellipsoid then, and
        each of them counts alike, as those at rest lie close together.

    Raises
    ------
    NoEllipsoidError
    """
    count = x.shape[1]
    random = np.random.default_rng(0)
    few = x if count <= START_READINGS else x[:, random.integers(0, count, START_READINGS)]
    weights = np.ones(few.shape[1]) if motion else areas(few)
    core = CORE_IN_MOTION if motion else CORE
    shift = quantile(few, weights, 0.5)
    size = float(quantile(np.sqrt(((few - shift[:, None]) ** 2).sum(axis=0)), weights, 0.5))
    if not size > 0:
        raise NoEllipsoidError
    z = (x - shift[:, None]) / size
    few = (few - shift[:, None]) / size
    a, b = robust_start(few, weights, parameters, core, random)
    state = _refine(few, few, weights, a, b, parameters, core)
    if observability(state.a @ (few[:, state.keep] - state.b[:, None]), parameters) < LEAST_OBSERVABILITY:
        raise NoEllipsoidError
    if not motion:
        # Areas of the sphere, whatever the axes of the ellipsoid are.
        weights = areas(state.a @ (few - state.b[:, None]))
    if count > MANY_READINGS:
        part = np.ascontiguousarray(z[:, :: count // MANY_READINGS])
        state = _refine(part, few, weights, state.a, state.b, parameters, core)
        state = _refine_many(z, few, weights, part, state, parameters, core)
    else:
        state = _refine(z, few, weights, state.a, state.b, parameters, core)
    a, b, keep, residual = state.a, state.b, state.keep, state.residual

    kept = residual[keep]
    freedom = max(len(kept) - parameters, 1)
    correlation = correlation_time(kept)
    inverse = np.linalg.inv(state.h).astype(np.float64, copy=False)
    scores, _, _, _ = normal_equations(z, a, b, parameters, keep, inverse)
    covariance = inverse @ scores @ inverse * correlation
    deviation = float(np.sqrt(kept @ kept / freedom))
    radius = mean_radius(a)
    some = np.flatnonzero(keep)[:: max(len(kept) // DIRECTIONS, 1)]
    directions = a @ (z[:, some] - b[:, None])
    observed = observability(directions, parameters)
    if observed < LEAST_OBSERVABILITY:
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
        directions=directions,
        observability=observed,
    )


def information(y: FloatArray, parameters: int) -> FloatArray:
    """The mean information of a calibrated reading (3, n) about relative changes of S and about b: (p, p).

    Of off-diagonal terms √2 times is counted, so that a rotation of the sensor leaves the eigenvalues as they are.
    """
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


@dataclass(frozen=True, slots=True)
class _State:
    """Parameters with their normal equations over a selection of readings."""

    a: FloatArray
    b: FloatArray
    keep: BoolArray
    h: FloatArray
    g: FloatArray
    residual: FloatArray
    cost: float
    """Σ r² over the readings that are kept."""

    @classmethod
    def of(cls, z: FloatArray, a: FloatArray, b: FloatArray, keep: BoolArray, parameters: int) -> _State:
        return cls(a, b, keep, *normal_equations(z, a, b, parameters, keep))


def _refine(
    z: FloatArray, few: FloatArray, weights: FloatArray, a: FloatArray, b: FloatArray, parameters: int, core: float
) -> _State:
    """Gauss-Newton with outliers left out, until parameters and selection stay.

    A reading on the border may be an outlier where it is left out, and none where it is fitted. So that the outcome
    does not depend on the start, outliers are first those beyond a border that is half as far again, where hardly a
    reading is.
    """
    state, residual = None, residuals(z, a, b)
    cut = WIDE_CUT if z.shape[1] <= MANY_READINGS else CUT
    for _ in range(30):
        keep = np.abs(residual) <= _border(few, weights, a, b, core, cut)
        if state is not None and np.array_equal(keep, state.keep):
            if cut == CUT:
                break
            # From here on the same whatever came before.
            state, cut = _converge(z, state, parameters, CONVERGED), CUT
            a, b, residual = state.a, state.b, state.residual
            continue
        state = _converge(z, _State.of(z, a, b, keep, parameters), parameters, NEARLY_CONVERGED)
        a, b, residual = state.a, state.b, state.residual
    if state is None:  # for the checker: the loop has run
        raise NoEllipsoidError
    return _converge(z, state, parameters, CONVERGED)


def _refine_many(
    z: FloatArray,
    few: FloatArray,
    weights: FloatArray,
    part: FloatArray,
    start: _State,
    parameters: int,
    core: float,
) -> _State:
    """The same for many readings from the fit to a part of them: by gradients alone, which take a third of the time.

    What a step changes in the gradient is taken from the part, by differences (Newton's method, so that readings of
    another shape than the model's take no more passes). So near to its end neither a step nor the readings that it
    takes in or leaves out make the next one larger; should they, it goes on as in `_refine`.
    """
    a, b = start.a, start.b
    slope = _slope(part, start, parameters) / np.count_nonzero(start.keep)
    before = None
    for _ in range(MANY_PASSES):
        border = _border(few, weights, a, b, core, CUT)
        g, residual = gradient(z, a, b, parameters, border)
        keep = np.abs(residual) <= border
        step = np.linalg.solve(slope * np.count_nonzero(keep), g).astype(np.float64, copy=False)
        same = before is not None and np.array_equal(keep, before)
        if same and float(np.abs(step).max()) < CONVERGED * (1.0 + float(np.abs(b).max())):
            return _State.of(z, a, b, keep, parameters)
        before, a, b = keep, a - symmetric(step[:-3]), b - step[-3:]
    return _refine(z, few, weights, start.a, start.b, parameters, core)


def _slope(z: FloatArray, state: _State, parameters: int) -> FloatArray:
    """The derivatives of the gradient by the parameters, for the readings that are kept."""
    columns = []
    for step in DIFFERENCE * np.eye(parameters):
        ends = [
            gradient(z, state.a + sign * symmetric(step[:-3]), state.b + sign * step[-3:], parameters, state.keep)[0]
            for sign in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * DIFFERENCE))
    slope: FloatArray = np.stack(columns, axis=1)
    return slope


def _border(few: FloatArray, weights: FloatArray, a: FloatArray, b: FloatArray, core: float, cut: float) -> float:
    """The largest residual of what is no outlier: so many robust standard deviations."""
    deviation = float(quantile(np.abs(residuals(few, a, b)), weights, core)) / NORMAL_QUANTILES[core]
    return max(cut * deviation, ROUNDING)


def _converge(z: FloatArray, state: _State, parameters: int, enough: float) -> _State:
    """Gauss-Newton to a step below `enough`, halved where the sum of squares would grow."""
    for _ in range(30):
        try:
            step = np.linalg.solve(state.h, state.g).astype(np.float64, copy=False)
        except np.linalg.LinAlgError:
            raise NoEllipsoidError from None
        size = float(np.abs(step).max())
        if not size < FARTHEST or np.linalg.norm(state.b) > FARTHEST:
            raise NoEllipsoidError
        # Near the end the cost changes by rounding alone, which is no reason to go back.
        most = state.cost * (1 + 1e-9) + 1e-24 * z.shape[1]
        for _ in range(30):
            a, b = state.a - symmetric(step[:-3]), state.b - step[-3:]
            if np.linalg.eigvalsh(a)[0] > 0:
                tried = _State.of(z, a, b, state.keep, parameters)
                if tried.cost <= most:
                    break
            step = 0.5 * step
        else:
            return state
        state = tried
        if size < enough * (1.0 + float(np.abs(state.b).max())):
            return state
    return state


def correlation_time(residual: FloatArray) -> float:
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
