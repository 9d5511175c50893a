"""Smooth functions of time with exact derivatives: what motions are made of.

A function has `derivative(t, order)`: the values at the times t (T,) as (T, columns). Order 0 is the function itself.
Each column is in one piece in memory (the array is the transpose of one that numpy would call contiguous), which is the
fast layout for what is computed from it, column by column.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.polynomial import Polynomial as Power
from numpy.typing import ArrayLike, NDArray

from ahrs_rs._typing import FloatArray

#: The correction of control points halves the error of a spline at its way points each time.
SPLINE_ROUNDS = 80
#: Shorter runs of times in the same piece are not worth a loop of their own.
LEAST_RUN = 64


class Function(Protocol):
    """Something that has a value and derivatives at every time.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> line: ar.simulate.Function = ar.simulate.Polynomial(np.array([[0.0], [2.0]]))
    >>> line.derivative(np.array([1.0]), 1)
    array([[2.]])
    """

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """The derivative of an order.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        order : int
            Of the derivative; 0: the value.

        Returns
        -------
        ndarray
            (T, columns).
        """
        ...


@dataclass(frozen=True, slots=True)
class Polynomial:
    """Σ coefficients[i] · tⁱ, with coefficients (degree + 1, columns): a constant, a steady motion.

    Parameters
    ----------
    coefficients : ndarray
        (degree + 1, columns).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.Polynomial(np.array([[1.0], [2.0]])).derivative(np.array([0.0, 1.0]), 0)
    array([[1.],
           [3.]])
    """

    coefficients: FloatArray

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """The derivative of an order.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        order : int
            Of the derivative; 0: the value.

        Returns
        -------
        ndarray
            (T, columns).
        """
        total = np.zeros((self.coefficients.shape[1], len(t)))
        for power in range(len(self.coefficients) - 1, order - 1, -1):
            total = total * t + math.perm(power, order) * self.coefficients[power][:, None]
        return total.T


def constant(value: ArrayLike) -> Polynomial:
    """The value (columns,) at all times.

    Parameters
    ----------
    value : array_like
        (columns,) or a number.

    Returns
    -------
    Polynomial
        A function of time.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.constant([3.0]).derivative(np.zeros(2), 0)
    array([[3.],
           [3.]])
    """
    return Polynomial(np.array(value, dtype=np.float64)[np.newaxis])


@dataclass(frozen=True, slots=True)
class Waves:
    """Sums of sines Σ amplitude · sin(frequency · t + phase), one per column: three arrays (terms, columns).

    The frequency is in rad/s.

    Parameters
    ----------
    amplitude : ndarray
        (terms, columns).
    frequency : ndarray
        (terms, columns) rad/s.
    phase : ndarray
        (terms, columns) rad.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> one = np.ones((1, 1))
    >>> ar.simulate.Waves(one, one, 0.0 * one).derivative(np.zeros(1), 1)
    array([[1.]])
    """

    amplitude: FloatArray
    frequency: FloatArray
    phase: FloatArray

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """The derivative of an order.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        order : int
            Of the derivative; 0: the value.

        Returns
        -------
        ndarray
            (T, columns).
        """
        total = np.zeros((self.amplitude.shape[1], len(t)))
        for amplitude, frequency, phase in zip(self.amplitude, self.frequency, self.phase, strict=True):
            angle = frequency[:, None] * t
            angle += phase[:, None]
            angle += 0.5 * math.pi * order
            np.sin(angle, out=angle)
            angle *= (amplitude * frequency**order)[:, None]
            total += angle
        return total.T


@dataclass(frozen=True, slots=True)
class Sum:
    """Functions of as many columns added up.

    Parameters
    ----------
    terms : tuple of Function
        What is added up.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> f = ar.simulate.Sum((ar.simulate.constant([1.0]), ar.simulate.constant([2.0])))
    >>> f.derivative(np.zeros(1), 0)
    array([[3.]])
    """

    terms: tuple[Function, ...]

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """The derivative of an order.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        order : int
            Of the derivative; 0: the value.

        Returns
        -------
        ndarray
            (T, columns).
        """
        total = self.terms[0].derivative(t, order)
        for term in self.terms[1:]:
            total = total + term.derivative(t, order)
        return total


@dataclass(frozen=True, slots=True)
class Modulo:
    """A function of one column, counted again from zero at every multiple of the period.

    Parameters
    ----------
    function : Function
        Of one column.
    period : float
        What it is counted by.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> s = ar.simulate.Modulo(ar.simulate.Polynomial(np.array([[0.0], [1.0]])), 2.0)
    >>> s.derivative(np.array([0.0, 3.0]), 0)
    array([[0.],
           [1.]])
    """

    function: Function
    period: float

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """The derivative of an order.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        order : int
            Of the derivative; 0: the value.

        Returns
        -------
        ndarray
            (T, columns).
        """
        value = self.function.derivative(t, order)
        return np.mod(value, self.period) if order == 0 else value


@dataclass(frozen=True, slots=True)
class Piecewise:
    """Polynomials between breaks; before the first and after the last one, the value there, at rest.

    Parameters
    ----------
    breaks : ndarray
        (pieces + 1,) s, increasing.
    coefficients : ndarray
        (degree + 1, pieces, columns), of the powers of the time since the piece's start.
    periodic : bool, optional
        Go on with the first piece after the last one, from where that has ended, and so for all
        times.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> f = ar.simulate.moves([0.0], [(1.0, [2.0])])
    >>> f.derivative(np.array([0.0, 5.0]), 0)
    array([[0.],
           [2.]])
    """

    breaks: FloatArray
    coefficients: FloatArray
    periodic: bool = False

    def derivative(self, t: FloatArray, order: int) -> FloatArray:
        """The derivative of an order.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        order : int
            Of the derivative; 0: the value.

        Returns
        -------
        ndarray
            (T, columns).
        """
        first, last = self.breaks[0], self.breaks[-1]
        cycle = np.floor((t - first) / (last - first)) if self.periodic else None
        inside = np.clip(t if cycle is None else t - cycle * (last - first), first, last)
        piece = np.searchsorted(self.breaks[1:-1], inside, side="right")
        x = inside - self.breaks[piece]
        factors = [math.perm(power, order) for power in range(len(self.coefficients))]
        total = np.zeros((self.coefficients.shape[2], len(t)))
        for run, which in _runs(piece):
            part, time = total[:, run], x[run]
            for power in range(len(self.coefficients) - 1, order - 1, -1):
                part *= time
                part += factors[power] * self.coefficients[power, which].T
        if cycle is None:
            if order > 0:
                total *= (t >= first) & (t < last)
        elif order == 0:
            total += cycle * (self._end() - self.coefficients[0, 0])[:, None]
        return total.T

    def _end(self) -> FloatArray:
        x = self.breaks[-1] - self.breaks[-2]
        end: FloatArray = (self.coefficients[:, -1] * (x ** np.arange(len(self.coefficients)))[:, None]).sum(axis=0)
        return end

    @property
    def end(self) -> float:
        """The last break, s."""
        return float(self.breaks[-1])


def _runs(piece: NDArray[np.intp]) -> Iterator[tuple[slice, NDArray[np.intp]]]:
    """Slices of times in the same piece, with its number as (1,); where runs are short, all times at once."""
    starts = np.flatnonzero(np.diff(piece, prepend=-1))
    if len(starts) * LEAST_RUN > len(piece):
        yield slice(None), piece
        return
    for start, stop in itertools.pairwise((*starts.tolist(), len(piece))):
        yield slice(start, stop), piece[start : start + 1]


def moves(
    start: ArrayLike,
    steps: Sequence[tuple[float, ArrayLike]],
    *,
    ramp: float = 0.25,
    smoothness: int = 2,
    begin: float = 0.0,
    periodic: bool = False,
) -> Piecewise:
    """From rest to rest, one value after the other.

    Parameters
    ----------
    start : array_like
        The value before `begin`, (columns,).
    steps : sequence of tuple
        A duration in s and the value at its end, each; the value before means a rest.
    ramp : float, optional
        Part of a step's duration in which its speed rises, and again in which it falls, at most
        0.5. The mean speed is (1 - ramp) of the largest.
    smoothness : int, optional
        How many derivatives of the speed are continuous: with 2, those of the value up to the
        third.
    begin : float, optional
        s.
    periodic : bool, optional
        Repeat the steps for all times.

    Returns
    -------
    Piecewise
        A function of time.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.moves([0.0], [(1.0, [2.0])]).derivative(np.array([0.0, 5.0]), 0)
    array([[0.],
           [2.]])
    """
    if not 0.0 < ramp <= 0.5:
        raise ValueError(f"ramp: expected a number above 0 and at most 0.5, got {ramp}")
    rise = _ramp(smoothness).integ()
    value = np.array(start, dtype=np.float64)
    breaks: list[float] = [begin]
    pieces: list[FloatArray] = []
    for duration, end in steps:
        if not (math.isfinite(duration) and duration > 0.0):
            raise ValueError(f"steps: expected positive durations, got {duration}")
        way = np.asarray(end, dtype=np.float64) - value
        length = ramp * duration
        speed = way / (duration - length)
        u = Power([0.0, 1.0 / length])
        parts = [(length, rise(u) * length), (duration - 2.0 * length, Power([0.5 * length, 1.0]))]
        # The fall is the rise backward in time: what is still to go after x is the way of the rise in length - x.
        parts.append((length, Power([duration - length]) - rise(1.0 - u) * length))
        for lasting, part in parts if np.any(way != 0.0) else [(duration, Power([0.0]))]:
            if lasting > 1e-12 * duration:
                breaks.append(breaks[-1] + lasting)
                piece = _real(part)[:, None] * speed
                piece[0] += value
                pieces.append(piece)
        value = value + way
    degree = max(map(len, pieces))
    padded = [np.concatenate((piece, np.zeros((degree - len(piece), len(value))))) for piece in pieces]
    return Piecewise(np.array(breaks), np.stack(padded, axis=1), periodic)


def bumps(start: float, width: float, period: float, height: ArrayLike) -> Piecewise:
    """height · (4u(1 - u))⁴ for u from 0 to 1 over the width, once a period from `start` on; zero in between.

    Its third derivative is continuous. All times in s; height (columns,).

    Parameters
    ----------
    start : float
        Of the first one, s.
    width : float
        s.
    period : float
        S from one to the next.
    height : array_like
        (columns,).

    Returns
    -------
    Piecewise
        A function of time.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.bumps(0.0, 1.0, 2.0, [1.0]).derivative(np.array([0.5, 1.5]), 0)
    array([[1.],
           [0.]])
    """
    u = Power([0.0, 1.0 / width])
    shape = _real((4.0 * u * (1.0 - u)) ** 4)[:, None] * np.asarray(height, dtype=np.float64)
    coefficients = np.stack((shape, np.zeros_like(shape)), axis=1)
    return Piecewise(np.array([start, start + width, start + period]), coefficients, periodic=True)


def spline(points: ArrayLike, interval: float, begin: float = 0.0) -> Piecewise:
    """The cubic spline through points (n, columns), one every `interval` s, that starts and ends with speed zero.

    Speed and acceleration are continuous between the ends.

    Parameters
    ----------
    points : array_like
        (n, columns).
    interval : float
        S between two points.
    begin : float, optional
        Time of the first one, s.

    Returns
    -------
    Piecewise
        A function of time.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.spline([[0.0], [1.0], [0.0]], 1.0).derivative(np.array([1.0]), 0).round(6)
    array([[1.]])
    """
    through = np.asarray(points, dtype=np.float64)
    if len(through) < 2:
        raise ValueError(f"points: expected at least two, got {len(through)}")
    inner = through.copy()
    for _ in range(SPLINE_ROUNDS):
        control = np.concatenate((inner[1:2], inner, inner[-2:-1]))  # mirrored: no speed at the ends
        inner += 1.5 * (through - (control[:-2] + 4.0 * control[1:-1] + control[2:]) / 6.0)
    control = np.concatenate((inner[1:2], inner, inner[-2:-1]))
    a, b, c, d = control[:-3], control[1:-2], control[2:-1], control[3:]
    powers = ((a + 4.0 * b + c) / 6.0, 0.5 * (c - a), 0.5 * (a + c) - b, (d - a) / 6.0 + 0.5 * (b - c))
    coefficients = np.stack([power / interval**i for i, power in enumerate(powers)])
    return Piecewise(begin + interval * np.arange(float(len(through))), coefficients)


def _real(polynomial: Power) -> FloatArray:
    """The coefficients, which numpy's types would let be complex."""
    return np.asarray(polynomial.coef, dtype=np.float64)


def _ramp(smoothness: int) -> Power:
    """The polynomial that rises from 0 to 1 over [0, 1] with so many vanishing derivatives at both ends."""
    n = smoothness
    coefficients = np.zeros(2 * n + 2)
    for k in range(n + 1):
        coefficients[n + 1 + k] = math.comb(n + k, k) * math.comb(2 * n + 1, n - k) * (-1) ** k
    return Power(coefficients)
