"""Overlapping Allan deviation, its confidence, and the noise coefficients that it shows (IEEE Std 952, annex C).

Of samples x at the rate 1/τ₀, with their sums S_k = x_0 + … + x_{k−1}, the variance of clusters of m is

    σ²(m τ₀) = Σ_k (S_{k+2m} − 2 S_{k+m} + S_k)² / (2 m² M),   k = 0 … M − 1,   M = T − 2m + 1.

The model is the sum of four independent noises:

    σ²(τ) = 3 Q²/τ² + N²/τ + (2 ln 2/π) B² + K² τ/3

with the quantisation Q, the random walk N (read at 1 s), the bias instability B (the flat part over 0.664), and the
rate random walk K (read at 3 s). N² is the two-sided power density: samples at f Hz have the standard deviation N √f.
The noise density of data sheets is one-sided, √2 N.

**Confidence.** edf · σ̂²/σ² has the χ² distribution with the equivalent degrees of freedom edf of the noise that is
largest at that τ, as of Riley & Howe (NIST SP 1065, 2008, section 5.4.1), with n = T + 1:

    Q   (n + 1)(n − 2m) / (2 (n − m))
    N   (3 (n − 1)/(2m) − 2 (n − 2)/n) · 4m²/(4m² + 5)
    B   2 (n − 2)²/(2.3 n − 4.9) for m = 1,   5 n²/(4m (n + 3m)) above
    K   (n − 2)/m · ((n − 1)² − 3m (n − 1) + 4m²)/(n − 3)²

**Fit.** Least squares of σ̂² with non-negative coefficients, each point weighted by its own relative error √(2/edf) of
the model, over octaves of m. What neighbouring octaves have in common is taken into account: for a Gaussian noise of
the density S(f) the covariance of two variances is proportional to ∫ |H_i|² |H_j|² S² df, with H_m the filter of the
cluster. A term stays if it is above zero by the asked confidence. A sensor's own low-pass filter takes noise from the
shortest clusters: they are left out until the model fits. Where a recording is too short to tell a flat part from a
rise, the one that fits better is given; the interval of the other one, which reaches up to what it could be in its
place, says so.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _html
from ahrs_rs._optional import require
from ahrs_rs._typing import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


__all__ = ["Allan", "Coefficient", "allan", "allan_deviation"]


#: The largest cluster has a fifth of the samples: its deviation is still known to some 30 %.
LARGEST_SHARE = 5
#: Below this there are no four octaves.
FEWEST_SAMPLES = 50
PER_OCTAVE = 3
#: Samples that are summed at a time: such blocks stay in a processor's cache, and BLAS takes no threads for them.
BLOCK = 1 << 13

#: The terms of the model in the order of their slope, and what they look like.
TERMS = ("quantisation", "random_walk", "bias_instability", "rate_random_walk")
UNITS = ("·s", "/√Hz", "", "/√s")
LOOKS = ("fall with slope −1", "fall with slope −1/2", "flat part", "rise with slope +1/2")
FLATNESS = 2.0 * math.log(2.0) / math.pi  # 0.664²


@dataclass(frozen=True, slots=True)
class Coefficient:
    """A coefficient of the model, with its confidence interval.

    Parameters
    ----------
    value : float
        NaN where the recording does not tell.
    low : float
        Lower end of the confidence interval.
    high : float
        An upper bound also where the value is not known.
    unit : str
        Of the value.
    reason : str, optional
        Why it is not known.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal(10000)
    >>> walk = ar.calibration.allan(x, 100.0, unit="rad/s").random_walk
    >>> walk.low < walk.value < walk.high, walk.unit
    (True, 'rad/s/√Hz')
    """

    value: float
    low: float
    high: float
    unit: str
    reason: str = ""

    @property
    def known(self) -> bool:
        """Whether the samples determine it."""
        return not math.isnan(self.value)


@dataclass(frozen=True, slots=True, eq=False)
class Allan:
    """The Allan deviation of one signal, and what it is made of.

    Parameters
    ----------
    tau : ndarray
        (K,) cluster times, s.
    deviation : ndarray
        (K,) in the samples' unit.
    low : ndarray
        (K,) lower end of the confidence interval of the deviation.
    high : ndarray
        (K,) confidence interval of the deviation.
    edf : ndarray
        (K,) equivalent degrees of freedom.
    confidence : float
        Of the intervals.
    unit : str
        Of the samples.
    quantisation : Coefficient
        Q, in the unit of the samples times s.
    random_walk : Coefficient
        N: of a gyroscope the angle random walk, rad/s/√Hz = rad/√s.
    bias_instability : Coefficient
        B, in the unit of the samples.
    rate_random_walk : Coefficient
        K, in the unit of the samples over √s.
    fitted_from : float
        The shortest cluster time that the model was fitted to, s.
    misfit : float
        Χ² of the fit over its degrees of freedom; the intervals are widened by its root where it is
        above one.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal(10000)
    >>> found = ar.calibration.allan(x, 100.0, unit="rad/s")
    >>> round(found.random_walk.value, 2)
    0.1
    """

    tau: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    edf: FloatArray
    confidence: float
    unit: str
    quantisation: Coefficient
    random_walk: Coefficient
    bias_instability: Coefficient
    rate_random_walk: Coefficient
    fitted_from: float
    misfit: float

    def plot(self, *, model: bool = True, ax: Axes | None = None) -> Axes:
        """Draw the deviation over the cluster time, with its confidence and the model.

        Parameters
        ----------
        model : bool, optional
            Whether the model is drawn.
        ax : Axes, optional
            Where to draw; by default on a new figure.

        Returns
        -------
        Axes
            Logarithmic ones.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        """
        from ahrs_rs import plots  # for drawing only

        return plots.allan(self, model=model, ax=ax)

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [
            (
                name.replace("_", " "),
                f"{one.value:.4g} {one.unit} ({one.low:.3g} to {one.high:.3g})" if one.known else one.reason,
            )
            for name, one in self.coefficients.items()
        ]
        return _html.summary(f"Allan deviation, {100.0 * self.confidence:g} % intervals", rows)

    @property
    def minimum(self) -> tuple[float, float]:
        """Cluster time in s and value of the smallest deviation; over 0.664 the bias instability of data sheets.

        Of the clusters whose deviation is known to a sixth (20 degrees of freedom), where there are such: the smallest
        of many uncertain ones would be too small.
        """
        sure = self.edf >= min(20.0, float(self.edf.max()))
        index = int(np.argmin(np.where(sure, self.deviation, np.inf)))
        return float(self.tau[index]), float(self.deviation[index])

    @property
    def coefficients(self) -> dict[str, Coefficient]:
        """All four by name."""
        return {name: getattr(self, name) for name in TERMS}

    def model(self, tau: ArrayLike) -> FloatArray:
        """The deviation of the fitted model at cluster times in s; coefficients that are not known count as zero.

        Parameters
        ----------
        tau : array_like
            Cluster times in s.

        Returns
        -------
        ndarray
            The deviation at each of them.
        """
        squares = [0.0 if math.isnan(one.value) else one.value**2 for one in self.coefficients.values()]
        deviation: FloatArray = np.sqrt(_terms(np.asarray(tau, dtype=np.float64)) @ np.array(squares))
        return deviation


def allan_deviation(x: ArrayLike, rate: float, clusters: ArrayLike | None = None) -> tuple[FloatArray, FloatArray]:
    """Overlapping Allan deviation of samples at a constant rate.

    Time is linear in samples times clusters, memory in the samples. The mean is taken from the samples first: the sums
    then grow with the noise alone, and rounding stays below 1e-9 of the deviation for ten million samples of white
    noise.

    Parameters
    ----------
    x : array_like
        (T,), finite.
    rate : float
        Hz.
    clusters : array_like, optional
        Numbers of samples in a cluster, at most T/2 each; by default three an octave up to T/5.

    Returns
    -------
    tau, deviation
        (K,) each: cluster times in s, and the deviation in the unit of `x`.

    Raises
    ------
    ValueError
        A wrong shape, NaN or infinite values, too few samples, clusters that do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> tau, deviation = ar.calibration.allan_deviation(np.random.default_rng(0).standard_normal(1000), 100.0, [1, 10])
    >>> tau
    array([0.01, 0.1 ])
    """
    samples, rate = _samples(x), _rate(rate)
    if clusters is None:
        sizes = _sizes(len(samples))
    else:
        sizes = np.asarray(clusters)
        if sizes.ndim != 1 or sizes.dtype.kind not in "iu" or not ((sizes >= 1) & (2 * sizes <= len(samples))).all():
            raise ValueError(f"clusters: expected whole numbers from 1 to {len(samples) // 2}, half of the samples")
    squares, counts = _squares(samples, sizes)
    return sizes / rate, np.sqrt(squares / (2.0 * counts)) / sizes


def allan(x: ArrayLike | Sequence[ArrayLike], rate: float, *, unit: str = "rad/s", confidence: float = 0.95) -> Allan:
    """Overlapping Allan deviation of a sensor at rest, with the coefficients of its noises.

    Parameters
    ----------
    x : array_like or sequence of array_like
        (T,), finite, or a list of such: several rests of one sensor, of which the differences are
        taken together. Each has its own mean.
    rate : float
        Hz.
    unit : str, optional
        Of the samples.
    confidence : float, optional
        Of all intervals.

    Returns
    -------
    Allan
        The deviation and the fitted coefficients.

    Raises
    ------
    ImportError
        scipy is not installed.
    ValueError
        A wrong shape, NaN or infinite values, too few samples, samples that are all equal.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> x = np.random.default_rng(0).standard_normal(10000)
    >>> round(ar.calibration.allan(x, 100.0, unit="rad/s").random_walk.value, 2)
    0.1
    """
    several = list(x) if isinstance(x, (list, tuple)) and len(x) > 0 and np.ndim(x[0]) == 1 else [x]
    parts = [_samples(part) for part in several]
    rate = _rate(rate)
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence: expected a number between 0 and 1, got {confidence}")
    longest = max(map(len, parts))
    if longest < FEWEST_SAMPLES:
        raise ValueError(f"x: expected at least {FEWEST_SAMPLES} samples, got {longest}")
    sizes = _sizes(longest)
    squares, counts = np.zeros(len(sizes)), np.zeros(len(sizes))
    edf = np.zeros((len(sizes), len(TERMS)))
    for part in parts:
        fits = sizes <= len(part) // LARGEST_SHARE
        if fits.any():
            more_squares, more_counts = _squares(part, sizes[fits])
            squares[fits] += more_squares
            counts[fits] += more_counts
            edf[fits] += _degrees(len(part) + 1, sizes[fits])
    variance = squares / (2.0 * counts * sizes.astype(np.float64) ** 2)
    if not (variance > 0.0).all():
        raise ValueError(f"x: expected samples with noise, got {longest} equal ones")
    return _analysed(sizes / rate, variance, edf, sizes, unit, confidence)


def _analysed(
    tau: FloatArray, variance: FloatArray, edf_of: FloatArray, sizes: NDArray[np.int64], unit: str, confidence: float
) -> Allan:
    octaves = np.flatnonzero((sizes & (sizes - 1)) == 0)
    fit = _fit(tau[octaves], variance[octaves], edf_of[octaves], confidence)
    own_edf = edf_of[np.arange(len(tau)), np.argmax(_terms(tau) * fit.squares, axis=1)]
    chi2 = require("scipy.special", "scipy", "noise coefficients need").chdtri
    tail = 0.5 * (1.0 - confidence)
    low, high = (np.sqrt(variance * own_edf / chi2(own_edf, share)) for share in (tail, 1.0 - tail))
    longest = tau[-1]
    coefficients = []
    for index, (square, lowest, largest) in enumerate(zip(fit.squares, fit.low, fit.high, strict=True)):
        reason = ""
        if not square > 0.0:
            where = f"up to clusters of {longest:.3g} s" if index > 1 else f"from clusters of {fit.start:.3g} s on"
            reason = f"no {LOOKS[index]} {where}"
        value, lowest, largest = (math.sqrt(one) for one in (square, lowest, largest))
        coefficients.append(
            Coefficient(value if not reason else math.nan, lowest, largest, unit + UNITS[index], reason)
        )
    deviation = np.sqrt(variance)
    return Allan(
        tau=tau,
        deviation=deviation,
        low=low,
        high=high,
        edf=own_edf,
        confidence=confidence,
        unit=unit,
        **dict(zip(TERMS, coefficients, strict=True)),
        fitted_from=fit.start,
        misfit=fit.misfit,
    )


@dataclass(slots=True)
class _Fit:
    """Squares of the coefficients (zero: not known), their bounds, the first cluster time, χ² over its degrees."""

    squares: FloatArray
    low: FloatArray
    high: FloatArray
    start: float
    misfit: float


def _fit(tau: FloatArray, variance: FloatArray, edf_of: FloatArray, confidence: float) -> _Fit:
    """The model over the clusters from the first one on that it fits from; where there is none, from the best one."""
    special = require("scipy.special", "scipy", "noise coefficients need")
    clusters = _Clusters(tau, variance, edf_of)
    fits = []
    for start in range(max(1, len(tau) // 2)):
        fit, freedom = _fit_part(clusters.beyond(start), confidence)
        # A thousandth of good recordings lose their first cluster without need.
        if freedom < 1 or fit.misfit * freedom <= special.chdtri(freedom, 1e-3):
            return fit
        fits.append(fit)
    return min(fits, key=lambda fit: fit.misfit)


def _fit_part(clusters: _Clusters, confidence: float) -> tuple[_Fit, int]:
    """The fit, and its degrees of freedom."""
    special = require("scipy.special", "scipy", "noise coefficients need")
    tau, variance = clusters.tau, clusters.variance
    terms = _terms(tau)
    z = float(special.ndtri(0.5 * (1.0 + confidence)))
    kept = np.ones(len(TERMS), dtype=np.bool_)
    while True:
        squares, white = _solve(clusters, kept)
        columns, residuals = white @ terms, white @ (variance - terms @ squares)
        freedom = len(tau) - int(np.count_nonzero(squares))
        misfit = float(residuals @ residuals) / max(freedom, 1)
        alone = [_beside(columns, kept, index) for index in range(len(TERMS))]
        norms = np.array([max(float(np.linalg.norm(one)), 1e-300) for one in alone])
        deviations = math.sqrt(max(1.0, misfit)) / norms
        # The least certain of the terms that are not certain goes, one at a time.
        doubtful = np.where(kept, squares / deviations, np.inf)
        worst = int(np.argmin(doubtful))
        if np.count_nonzero(kept) == 1 or doubtful[worst] > z:
            break
        kept[worst] = False
    # Intervals are beside all terms: which of them are left out was itself decided by these variances.
    every = np.ones(len(TERMS), dtype=np.bool_)
    alone = [_beside(columns, every, index) for index in range(len(TERMS))]
    norms = np.array([max(float(np.linalg.norm(one)), 1e-300) for one in alone])
    deviations = math.sqrt(max(1.0, misfit)) / norms
    high = squares + z * deviations
    for index in np.flatnonzero(~kept):
        high[index] = _bound(clusters, squares, int(index), z * math.sqrt(max(1.0, misfit)))
    low = np.where(kept, np.maximum(squares - z * deviations, 0.0), 0.0)
    return _Fit(squares, low, high, float(tau[0]), misfit), freedom


def _solve(clusters: _Clusters, kept: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """Squares of the coefficients, and the matrix that makes the variances' errors independent and of size one.

    The errors are relative to the model, so it is solved repeatedly.
    """
    nnls = require("scipy.optimize", "scipy", "noise coefficients need").nnls
    tau, variance = clusters.tau, clusters.variance
    terms = _terms(tau)
    squares = np.zeros(len(TERMS))
    squares[TERMS.index("random_walk")] = float(np.median(variance * tau))
    for _ in range(12):  # it settles to 1e-6 in fewer
        white = clusters.whitening(squares)
        columns = white @ terms[:, kept]
        scale = np.linalg.norm(columns, axis=0)
        squares = np.zeros(len(TERMS))
        squares[kept] = nnls(columns / scale, white @ variance)[0] / scale
    return squares, white


def _bound(clusters: _Clusters, squares: FloatArray, index: int, z: float) -> float:
    """The largest square that a term which is left out could have.

    It is fitted beside all others, as one that is kept may stand in its place, and with the errors that the variances
    would have if it were there.
    """
    every = np.ones(len(TERMS), dtype=np.bool_)
    assumed = squares.copy()
    for _ in range(8):
        white = clusters.whitening(assumed)
        own = _beside(white @ _terms(clusters.tau), every, index)
        norm = max(float(np.linalg.norm(own)), 1e-300)
        assumed[index] = max(float(own @ (white @ clusters.variance)) / norm**2, 0.0) + z / norm
    return float(assumed[index])


class _Clusters:
    """The clusters of a fit, and how their variances are correlated."""

    def __init__(self, tau: FloatArray, variance: FloatArray, edf: FloatArray) -> None:
        self.tau, self.variance, self.edf = tau, variance, edf
        # One sample is the shortest cluster. At the upper end the grid averages over many sines.
        f = np.geomspace(0.02 * tau[0] / tau[-1], 0.5, 1500)
        sizes = (tau / tau[0])[:, np.newaxis]
        self._response = (np.sin(math.pi * f * sizes) ** 2 / (sizes * np.sin(math.pi * f))) ** 2
        omega = 2.0 * math.pi * f / tau[0]
        #: (F, 4): the density of each noise, and the steps of the logarithmic grid.
        self._densities = np.stack([omega**2 * tau[0], np.ones_like(f), 1.0 / omega, 1.0 / omega**2], axis=1)
        self._densities *= np.sqrt(f)[:, np.newaxis]

    def beyond(self, start: int) -> _Clusters:
        """Without the first ones."""
        other = copy.copy(self)
        other.tau, other.variance, other.edf = self.tau[start:], self.variance[start:], self.edf[start:]
        other._response = self._response[start:]
        return other

    def whitening(self, squares: FloatArray) -> FloatArray:
        """(K, K): what makes the variances' errors independent and of size one, for the noise of these coefficients."""
        terms = _terms(self.tau)
        # Where nothing of the model is left the measured variance stands in, or the weight would be infinite.
        model = np.maximum(terms @ squares, 1e-3 * self.variance)
        edf = self.edf[np.arange(len(self.tau)), np.argmax(terms * squares, axis=1)]
        white: FloatArray = np.linalg.inv(np.linalg.cholesky(self._correlation(squares))) / (model * np.sqrt(2.0 / edf))
        return white

    def _correlation(self, squares: FloatArray) -> FloatArray:
        weighted = self._response * (self._densities @ squares)
        norms = np.linalg.norm(weighted, axis=1, keepdims=True)
        if (
            not norms.all()
        ):  # none of these noises is there (a motion), and nothing says how the variances hang together
            return np.eye(len(norms))
        weighted /= norms
        correlation: FloatArray = weighted @ weighted.T
        return correlation


def _beside(columns: FloatArray, kept: NDArray[np.bool_], index: int) -> FloatArray:
    """The part of a term that the others which are kept cannot make up for."""
    others = kept.copy()
    others[index] = False
    own = columns[:, index]
    if not others.any():
        return own
    basis = columns[:, others]
    basis = basis / np.linalg.norm(basis, axis=0)
    left: FloatArray = own - basis @ np.linalg.lstsq(basis, own, rcond=None)[0]
    return left


def _terms(tau: FloatArray) -> FloatArray:
    """(K, 4): what the square of each coefficient is multiplied by."""
    return np.stack([3.0 / tau**2, 1.0 / tau, np.full_like(tau, FLATNESS), tau / 3.0], axis=-1)


def _degrees(points: int, sizes: NDArray[np.int64]) -> FloatArray:
    """(K, 4): equivalent degrees of freedom of clusters, for `points` sums, if one of the noises were alone."""
    n, m = float(points), sizes.astype(np.float64)
    flicker = np.where(sizes == 1, 2.0 * (n - 2.0) ** 2 / (2.3 * n - 4.9), 5.0 * n**2 / (4.0 * m * (n + 3.0 * m)))
    return np.stack(
        [
            (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m)),
            (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * 4.0 * m**2 / (4.0 * m**2 + 5.0),
            flicker,
            (n - 2.0) / m * ((n - 1.0) ** 2 - 3.0 * m * (n - 1.0) + 4.0 * m**2) / (n - 3.0) ** 2,
        ],
        axis=-1,
    )


def _squares(samples: FloatArray, sizes: NDArray[Any]) -> tuple[FloatArray, FloatArray]:
    """Of each cluster size, the sum of the squared second differences of the sums, and how many they are."""
    sums = np.empty(len(samples) + 1)
    sums[0] = 0.0
    np.subtract(samples, samples.mean(), out=sums[1:])
    np.cumsum(sums[1:], out=sums[1:])
    counts = len(sums) - 2 * sizes
    squares = np.zeros(len(sizes))
    room = np.empty(BLOCK)
    # Block after block, and all clusters of each: what they read of the sums is then mostly in the cache.
    for start in range(0, int(counts.max()), BLOCK):
        for index, size in enumerate(sizes.tolist()):
            stop = min(start + BLOCK, len(sums) - 2 * size)
            if stop > start:
                centre = sums[start + size : stop + size]
                difference = np.subtract(sums[start + 2 * size : stop + 2 * size], centre, out=room[: stop - start])
                difference -= centre
                difference += sums[start:stop]
                squares[index] += difference @ difference
    return squares, counts.astype(np.float64)


def _sizes(samples: int) -> NDArray[np.int64]:
    """Cluster sizes, three an octave, every power of two among them."""
    largest = max(samples // LARGEST_SHARE, 1)
    steps = np.arange(math.floor(PER_OCTAVE * math.log2(largest) + 1e-9) + 1)
    return np.unique(np.rint(2.0 ** (steps / PER_OCTAVE)).astype(np.int64))


def _samples(x: Any) -> FloatArray:
    try:
        samples = np.asarray(x, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"x: expected an array of real numbers, got {error}") from None
    if samples.ndim != 1:
        raise ValueError(f"x: expected shape (T,), got {samples.shape}")
    if len(samples) < 2:
        raise ValueError(f"x: expected at least 2 samples, got {len(samples)}")
    if not math.isfinite(float(samples.sum())):
        bad = np.flatnonzero(~np.isfinite(samples))
        index = int(bad[0]) if bad.size else 0
        raise ValueError(f"x: expected finite samples, got {samples[index]} at index {index}")
    return samples


def _rate(rate: float) -> float:
    if not (math.isfinite(rate) and rate > 0.0):
        raise ValueError(f"rate: expected a positive number of Hz, got {rate}")
    return float(rate)
