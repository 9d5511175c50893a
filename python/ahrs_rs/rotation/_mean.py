"""The mean of rotations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import Floats

__all__ = ["mean"]


def mean(q: ArrayLike, weights: ArrayLike | None = None, *, axis: int | tuple[int, ...] | None = None) -> Floats:
    """The mean of rotations, whatever the signs of their quaternions.

    It is the rotation with the least (weighted) sum of squares of the distances of matrices (Frobenius), which are
    2√2 sin(angle/2): the eigenvector of Σ w q qᵀ with the largest eigenvalue. Rows with a NaN (missing) are left out.
    Where rotations are so far apart that two means are equally good, it is one of them.

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first.
    weights : array_like, optional
        Not negative, of the leading shape of q, or one that can be broadcast to it.
    axis : int or tuple of int, optional
        Axes of the leading shape over which the mean is taken; None takes all of them.

    Returns
    -------
    ndarray
        The leading shape without these axes, and 4; w >= 0. NaN where no rotation is left, or all weights are zero.

    Raises
    ------
    ValueError
        Another shape, a negative weight, an axis that is not there, or a norm that is not 1.

    Notes
    -----
    F. L. Markley, Y. Cheng, J. L. Crassidis and Y. Oshman, "Averaging quaternions", Journal of Guidance, Control, and
    Dynamics 30(4):1193-1197, 2007, eqs 12 and 13.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.about_axis("z", [10.0, 20.0, 60.0], degrees=True)
    >>> ar.rotation.to_rotvec(ar.rotation.mean(q[:2]), degrees=True).round(6) + 0.0
    array([ 0.,  0., 15.])
    >>> ar.rotation.to_rotvec(ar.rotation.mean(q, [1.0, 1.0, 0.0]), degrees=True).round(6) + 0.0
    array([ 0.,  0., 15.])
    """
    quat = _validate.unit_quaternions("q", q)
    leading = quat.shape[:-1]
    count = len(leading)
    wanted = tuple(range(count)) if axis is None else axis
    axes = _validate.axes("axis", wanted, leading, "axes, each once, of the leading shape")
    given = np.ones((), dtype=np.float32) if weights is None else _validate.reals("weights", weights)
    if not (given >= 0.0).all():
        raise ValueError(f"weights: expected numbers that are not negative, got {given[~(given >= 0.0)].flat[0]}")
    try:
        spread = np.broadcast_to(given, leading)
    except ValueError:
        raise ValueError(f"weights: expected shape {leading}, got {given.shape}") from None
    dtype = np.result_type(quat, given)
    rows_of_each = math.prod(leading[k] for k in axes)
    kept = [k for k in range(count) if k not in axes]
    order = [*kept, *axes]
    shape = [leading[k] for k in kept]
    # In float64: sums of many float32 lose what the mean gains.
    rows = np.transpose(quat, [*order, count]).reshape(*shape, rows_of_each, 4).astype(np.float64)
    weight = np.transpose(spread, order).reshape(*shape, rows_of_each).astype(np.float64)
    there = ~np.isnan(rows[..., 0])
    rows, weight = np.where(there[..., np.newaxis], rows, 0.0), np.where(there, weight, 0.0)
    total = weight.sum(axis=-1)
    found = _quat.mean(rows, weight)
    found[~(total > 0.0)] = np.nan
    return np.asarray(found, dtype=dtype)
