"""Numbers that sum up many errors."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs._typing import FloatArray

__all__ = ["Box", "box", "gae", "imre", "mad", "mae", "mape", "rmse"]


def rmse(error: ArrayLike, mask: ArrayLike | None = None) -> float | FloatArray:
    """Root of the mean of squares along the last axis, over the samples of `mask`, without the NaN ones.

    Parameters
    ----------
    error : array_like
        (..., T).
    mask : array_like, optional
        Bool, broadcast to `error`; None takes every sample.

    Returns
    -------
    float or ndarray
        A number for (T,), else an array (...,).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.metrics.rmse([3.0, -4.0, 5.0]), 6)
    4.082483
    """
    values = _errors(error)
    counted = ~np.isnan(values)
    if mask is not None:
        counted &= checked_mask("mask", mask, values.shape)
    count = counted.sum(axis=-1)
    squares = np.where(counted, values, 0.0) ** 2
    mean = np.full(count.shape, np.nan)
    np.divide(squares.sum(axis=-1), count, out=mean, where=count > 0)
    return _plain(np.sqrt(mean))


def mae(error: ArrayLike, mask: ArrayLike | None = None) -> float | FloatArray:
    """Mean of the absolute errors, as `rmse`.

    Parameters
    ----------
    error : array_like
        (..., T) errors; NaN where there is none.
    mask : array_like, optional
        (..., T) the samples that count; by default all of them.

    Returns
    -------
    float or ndarray
        A number, or (...,) for errors (..., T).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.metrics.mae([3.0, -4.0, 5.0]), 6)
    4.0
    """
    return _each(error, mask, lambda values: float(np.abs(values).mean()))


def mape(
    error: ArrayLike, truth: ArrayLike, mask: ArrayLike | None = None, *, least: float = 0.0
) -> float | FloatArray:
    """Mean of the absolute errors as a percentage of the truth, as `rmse`.

    Parameters
    ----------
    error : array_like
        (..., T).
    truth : array_like
        What the error is an error of, in its unit, broadcast to `error`.
    mask : array_like, optional
        Bool, broadcast to `error`; None takes every sample.
    least : float, optional
        Samples whose truth is not larger than this in size do not count. A percentage of zero is
        not defined, and one of a truth that is close to zero says nothing of the error.

    Returns
    -------
    float or ndarray
        In percent.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.metrics.mape([1.0, -1.0], [10.0, 20.0]), 6)
    7.5
    """
    values = _errors(error)
    try:
        size = np.broadcast_to(np.abs(np.asarray(truth, dtype=np.float64)), values.shape)
    except ValueError:
        raise ValueError(f"truth: expected shape {values.shape}, got {np.shape(truth)}") from None
    percent = np.full(values.shape, np.nan)
    np.divide(100.0 * values, size, out=percent, where=size > least)
    return mae(percent, mask)


def mad(error: ArrayLike, mask: ArrayLike | None = None) -> float | FloatArray:
    """Median absolute deviation: the median of the distances to the median, as `rmse`.

    A constant error has none.

    Parameters
    ----------
    error : array_like
        (..., T) errors; NaN where there is none.
    mask : array_like, optional
        (..., T) the samples that count; by default all of them.

    Returns
    -------
    float or ndarray
        A number, or (...,) for errors (..., T).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.metrics.mad([3.0, -4.0, 5.0]), 6)
    2.0
    """
    return _each(error, mask, lambda values: float(np.median(np.abs(values - np.median(values)))))


def gae(error: ArrayLike, mask: ArrayLike | None = None) -> float | FloatArray:
    """Geometric mean of the absolute errors, as `rmse`; zero where one of them is zero.

    Parameters
    ----------
    error : array_like
        (..., T) errors; NaN where there is none.
    mask : array_like, optional
        (..., T) the samples that count; by default all of them.

    Returns
    -------
    float or ndarray
        A number, or (...,) for errors (..., T).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.metrics.gae([3.0, -4.0, 5.0]), 6)
    3.914868
    """

    def mean(values: FloatArray) -> float:
        size = np.abs(values)
        return float(np.exp(np.log(size).mean())) if size.all() else 0.0

    return _each(error, mask, mean)


def imre(error: ArrayLike, mask: ArrayLike | None = None) -> float | FloatArray:
    """Iterative mid-range error, as `rmse`.

    The smallest and the largest absolute error are replaced by the middle between them, again and again, until one
    number is left. It is less than the mean moved by a few large errors.

    Parameters
    ----------
    error : array_like
        (..., T) errors; NaN where there is none.
    mask : array_like, optional
        (..., T) the samples that count; by default all of them.

    Returns
    -------
    float or ndarray
        A number, or (...,) for errors (..., T).

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.metrics.imre([3.0, -4.0, 5.0]), 6)
    4.0
    """
    return _each(error, mask, lambda values: _iterative_mid_range(np.abs(values)))


@dataclass(frozen=True, slots=True)
class Box:
    """The numbers of a box-and-whisker plot; arrays (...) for errors (..., T).

    Parameters
    ----------
    low : float or ndarray
        The smallest value that is no outlier, where the lower whisker ends.
    q1 : float or ndarray
        The lower quartile.
    median : float or ndarray
        The median.
    q3 : float or ndarray
        The upper quartile.
    high : float or ndarray
        The largest value that is no outlier, where the upper whisker ends.
    outliers : float or ndarray
        How many values lie beyond the whiskers.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.metrics.box([1.0, 2.0, 3.0, 4.0]).median
    2.5
    """

    low: float | FloatArray
    q1: float | FloatArray
    median: float | FloatArray
    q3: float | FloatArray
    high: float | FloatArray
    outliers: float | FloatArray


def box(error: ArrayLike, mask: ArrayLike | None = None, *, whisker: float = 1.5) -> Box:
    """Median, quartiles and whiskers of the errors with their signs, as `rmse`.

    Parameters
    ----------
    error : array_like
        (..., T).
    mask : array_like, optional
        Bool, broadcast to `error`; None takes every sample.
    whisker : float, optional
        A value is an outlier if it lies farther than this times the quartiles' distance beyond a
        quartile; ``math.inf`` takes the whiskers to the most distant values.

    Returns
    -------
    Box
        Median, quartiles, whiskers and the number of outliers.

    Notes
    -----
    Quartiles are interpolated linearly between the sorted values, as in `numpy.percentile`.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> found = ar.metrics.box([1.0, 2.0, 3.0, 4.0])
    >>> found.q1, found.q3
    (1.75, 3.25)
    """
    if not whisker >= 0.0:
        raise ValueError(f"whisker: expected a number that is not negative, got {whisker}")
    values = _errors(error)

    def numbers(row: FloatArray) -> tuple[float, ...]:
        q1, median, q3 = np.percentile(row, (25.0, 50.0, 75.0))
        reach = whisker if np.isinf(whisker) else whisker * (q3 - q1)
        inside = row[(row >= q1 - reach) & (row <= q3 + reach)]
        # Where no value lies between a quartile and its reach, the whisker has no length.
        low, high = min(inside.min(initial=q1), q1), max(inside.max(initial=q3), q3)
        return float(low), float(q1), float(median), float(q3), float(high), float(len(row) - len(inside))

    rows = _rows(values, mask)
    found = np.array([numbers(row) if row.size else (np.nan,) * 5 + (0.0,) for row in rows]).reshape(-1, 6)
    return Box(*(_plain(column.reshape(values.shape[:-1])) for column in found.T))


def checked_mask(name: str, mask: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """The mask broadcast to the shape; ``ValueError`` where it does not fit."""
    array = np.asarray(mask)
    if array.dtype != np.bool_:
        raise ValueError(f"{name}: expected an array of bool, got dtype {array.dtype}")
    if array.shape[-1:] != shape[-1:] or array.ndim > len(shape):
        raise ValueError(f"{name}: expected shape {shape}, got {array.shape}")
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{name}: expected shape {shape}, got {array.shape}") from None


def _iterative_mid_range(values: FloatArray) -> float:
    """`imre` of sizes that are at least one.

    What is left is always a run of the sorted values, from which only the ends go, and some of the middles. So the
    values are sorted once, and only the middles need heaps: n steps of log n.
    """
    ordered = np.sort(values).tolist()
    first, last = 0, len(ordered) - 1
    middles: list[float] = []  # by number; a heap of the smallest, one of the largest, and which have gone
    smallest: list[tuple[float, int]] = []
    largest: list[tuple[float, int]] = []
    gone: list[bool] = []
    for _ in range(len(ordered) - 1):
        while smallest and gone[smallest[0][1]]:
            heapq.heappop(smallest)
        if smallest and (first > last or smallest[0][0] < ordered[first]):
            low, number = heapq.heappop(smallest)
            gone[number] = True
        else:
            low, first = ordered[first], first + 1
        while largest and gone[largest[0][1]]:
            heapq.heappop(largest)
        if largest and (first > last or -largest[0][0] > ordered[last]):
            number = heapq.heappop(largest)[1]
            high, gone[number] = middles[number], True
        else:
            high, last = ordered[last], last - 1
        middle = 0.5 * low + 0.5 * high
        heapq.heappush(smallest, (middle, len(middles)))
        heapq.heappush(largest, (-middle, len(middles)))
        middles.append(middle)
        gone.append(False)
    return float(middles[-1] if middles else ordered[0])


def _errors(error: ArrayLike) -> FloatArray:
    values = np.asarray(error, dtype=np.float64)
    if values.ndim == 0:
        raise ValueError("error: expected shape (..., T), got ()")
    return values


def _rows(values: FloatArray, mask: ArrayLike | None) -> list[FloatArray]:
    """The values that count, of each series along the last axis."""
    counted = ~np.isnan(values)
    if mask is not None:
        counted &= checked_mask("mask", mask, values.shape)
    length = values.shape[-1]
    count = int(np.prod(values.shape[:-1]))
    pairs = zip(values.reshape(count, length), counted.reshape(count, length), strict=True)
    return [row[which] for row, which in pairs]


def _each(error: ArrayLike, mask: ArrayLike | None, number: Callable[[FloatArray], float]) -> float | FloatArray:
    """The number of each series, NaN where no sample counts."""
    values = _errors(error)
    found = [number(row) if row.size else np.nan for row in _rows(values, mask)]
    return _plain(np.array(found, dtype=np.float64).reshape(values.shape[:-1]))


def _plain(array: FloatArray) -> float | FloatArray:
    return float(array) if array.ndim == 0 else array
