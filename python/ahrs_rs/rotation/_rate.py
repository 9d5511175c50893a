"""Angular rates of attitudes, and attitudes of angular rates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import FloatArray, Floats
from ahrs_rs.rotation._time import samples

__all__ = ["angular_rate", "integrate"]

FRAMES = ("sensor", "earth")


def angular_rate(
    q: ArrayLike, t: ArrayLike | None = None, *, rate: float | None = None, frame: str = "sensor"
) -> Floats:
    """The angular rate at which attitudes turn: what an exact gyroscope reads.

    Row k is the constant rate that turns sample k - 1 to sample k by the shortest rotation, which is the mean rate over
    that step as filters take it. A turn of more than half a circle within a step cannot be told from a shorter one.

    Parameters
    ----------
    q : array_like
        (..., T, 4) attitudes, scalar-first, sensor to earth.
    t : array_like, optional
        (T,) their times in s, not decreasing; or `rate`.
    rate : float, optional
        Hz, for attitudes without stamps.
    frame : str, optional
        ``"sensor"`` (body rate) or ``"earth"``, in whose axes the rate is given.

    Returns
    -------
    ndarray
        (..., T, 3) rad/s. NaN in row 0, before which there is nothing, beside a row with a NaN, and where two samples
        have one time.

    Raises
    ------
    ValueError
        Another shape or frame, times that decrease, neither times nor rate, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.about_axis("x", [0.0, 0.1, 0.3])
    >>> ar.rotation.angular_rate(q, rate=100.0).round(6)[1:] + 0.0
    array([[10.,  0.,  0.],
           [20.,  0.,  0.]])
    """
    _validate.choice("frame", frame, FRAMES)
    quat = samples("q", q)
    step = np.diff(_validate.times("t", t, rate, quat.shape[-2]))[:, np.newaxis].astype(quat.dtype)
    before, after = quat[..., :-1, :], quat[..., 1:, :]
    back = _quat.conjugate(before)
    turn = _quat.log(_quat.multiply(back, after) if frame == "sensor" else _quat.multiply(after, back))
    found = np.full((*quat.shape[:-1], 3), np.nan, dtype=quat.dtype)
    np.divide(turn, step, out=found[..., 1:, :], where=np.broadcast_to(step > 0.0, turn.shape))
    return found


def integrate(
    gyr: ArrayLike,
    t: ArrayLike | None = None,
    *,
    rate: float | None = None,
    start: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    frame: str = "sensor",
) -> Floats:
    """The attitudes to which angular rates turn: the inverse of `angular_rate`.

    Row k of the rates holds over the step from sample k - 1 to sample k; the first row is not used.

    Parameters
    ----------
    gyr : array_like
        (..., T, 3) rad/s.
    t : array_like, optional
        (T,) times in s, not decreasing; or `rate`.
    rate : float, optional
        Hz, for rates without stamps.
    start : array_like, optional
        (..., 4) the attitude of the first sample.
    frame : str, optional
        ``"sensor"`` (body rate) or ``"earth"``, in whose axes the rate is given.

    Returns
    -------
    ndarray
        (..., T, 4) attitudes of continuous sign; after a rate that is NaN nothing is known, and all is NaN.

    Raises
    ------
    ValueError
        Another shape or frame, times that decrease, neither times nor rate, or a norm of `start` that is not 1.

    See Also
    --------
    ahrs_rs.GyroIntegration : The same as a filter, which goes on over missing rows.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.integrate([[0.0, 0.0, 1.0]] * 3, rate=10.0)
    >>> ar.rotation.to_rotvec(q).round(6) + 0.0
    array([[0. , 0. , 0. ],
           [0. , 0. , 0.1],
           [0. , 0. , 0.2]])
    """
    _validate.choice("frame", frame, FRAMES)
    rates = _validate.rows("gyr", gyr, 3)
    if rates.ndim < 2 or not rates.shape[-2]:
        raise ValueError(f"gyr: expected shape (..., T, 3) with T > 0, got {rates.shape}")
    first = _validate.unit_quaternions("start", start)
    if isinstance(start, tuple):  # the default has no dtype of its own
        first = first.astype(rates.dtype)
    rates, first = _validate.together("gyr, start", rates, first[..., np.newaxis, :], rows=2)
    count = rates.shape[-2]
    step = np.diff(_validate.times("t", t, rate, count))[:, np.newaxis].astype(rates.dtype)
    turns = _quat.exp(rates[..., 1:, :] * step)
    first = np.broadcast_to(first, (*np.broadcast_shapes(first.shape[:-2], rates.shape[:-2]), 1, 4))
    turns = np.concatenate([first, np.broadcast_to(turns, (*first.shape[:-2], count - 1, 4))], axis=-2)
    products = _products(turns if frame == "sensor" else _quat.conjugate(turns))
    if frame == "earth":  # (a ⊗ b)* = b* ⊗ a*
        products = _quat.conjugate(products)
    found: Floats = products / np.linalg.norm(products, axis=-1, keepdims=True)
    return found


def _products(turns: FloatArray) -> FloatArray:
    """Products of the first k rotations of (..., T, 4), for every k.

    Blocks of √T side by side, then from block to block: two products a sample, in 2 √T calls.
    """
    count = turns.shape[-2]
    size = math.isqrt(count - 1) + 1
    blocks = -(-count // size)
    identity = np.array([1.0, 0.0, 0.0, 0.0], dtype=turns.dtype)
    padded = np.empty((*turns.shape[:-2], blocks * size, 4), dtype=turns.dtype)
    padded[..., :count, :], padded[..., count:, :] = turns, identity
    within = padded.reshape(*turns.shape[:-2], blocks, size, 4)
    for k in range(1, size):
        within[..., k, :] = _quat.multiply(within[..., k - 1, :], within[..., k, :])
    for k in range(1, blocks):
        within[..., k, :, :] = _quat.multiply(within[..., k - 1, -1:, :], within[..., k, :, :])
    return within.reshape(*turns.shape[:-2], blocks * size, 4)[..., :count, :]
