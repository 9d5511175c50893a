"""What all methods share: checked vectors, weights, and the form of the result."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _arrays, _quat
from ahrs_rs._typing import BoolArray, FloatArray, Floats

#: Rounding of the inputs that turns the attitude by 1/64 rad, about a degree, leaves it undetermined.
LOST = 64.0


def vectors(name: str, given: ArrayLike, *, rows: int = 0) -> Floats:
    """An array (..., 3), or (..., n, 3) of at least so many rows, of float32 or float64.

    Raises
    ------
    ValueError
        Another shape, values that are no numbers, or infinite ones.
    """
    shape = "(..., n, 3)" if rows else "(..., 3)"
    array = np.asarray(_arrays.vectors(name, given))
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: expected an array {shape} of real numbers, got the dtype {array.dtype}")
    if array.dtype != np.float32:
        array = array.astype(np.float64)
    if array.ndim < 1 + bool(rows) or array.shape[-1] != 3:
        raise ValueError(f"{name}: expected an array {shape}, got {array.shape}")
    if rows and array.shape[-2] < rows:
        raise ValueError(f"{name}: expected at least {rows} directions, got {array.shape[-2]}")
    infinite = np.isinf(array)
    if infinite.any():
        index = tuple(int(part) for part in np.argwhere(infinite)[0])
        raise ValueError(f"{name}: expected finite values or NaN, got {array[index]} at index {index}")
    return array


def together(**arrays: Floats) -> list[Floats]:
    """Arrays with their leading axes broadcast.

    Raises
    ------
    ValueError
        Shapes that do not fit.
    """
    try:
        return list(np.broadcast_arrays(*arrays.values()))
    except ValueError:
        shapes = " and ".join(str(array.shape) for array in arrays.values())
        raise ValueError(f"{', '.join(arrays)}: expected shapes that broadcast, got {shapes}") from None


def units(array: Floats) -> tuple[FloatArray, BoolArray]:
    """Unit vectors (..., 3), and which of them there are (...): a vector that is zero or holds a NaN is zero here."""
    wide = array.astype(np.float64, order="C")  # of one layout, so that sums have one order
    size = np.abs(wide)
    # Not numpy's maximum along the axis, which is slow for three numbers.
    largest = np.maximum(np.maximum(size[..., 0], size[..., 1]), size[..., 2])[..., np.newaxis]
    known = largest > 0.0  # not where it is NaN
    scaled = np.divide(wide, largest, out=np.zeros_like(wide), where=known)  # squares neither overflow nor vanish
    return scaled / np.where(known, length(scaled)[..., np.newaxis], 1.0), known[..., 0]


def shares(name: str, given: ArrayLike | None, known: BoolArray) -> FloatArray:
    """Weights (..., n) with the sum 1 over the pairs that there are; equal ones where none are given.

    Raises
    ------
    ValueError
        Weights of another shape, or that are not finite and ≥ 0.
    """
    weights = np.ones(known.shape) if given is None else numbers(name, given, known.shape)
    weights = np.where(known, weights, 0.0)
    total = weights.sum(axis=-1, keepdims=True)
    normalised: FloatArray = np.divide(weights, total, out=np.zeros_like(weights), where=total > 0.0)
    return normalised


def numbers(name: str, given: ArrayLike, shape: tuple[int, ...], *, positive: bool = False) -> FloatArray:
    """Numbers for each pair, broadcast to a shape; finite, and not negative (or positive).

    Raises
    ------
    ValueError
        Other numbers, or a shape that does not fit.
    """
    wanted = "finite numbers > 0" if positive else "finite numbers >= 0"
    array = np.asarray(given)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: expected {wanted}, got the dtype {array.dtype}")
    array = array.astype(np.float64)
    wrong = ~(np.isfinite(array) & ((array > 0.0) if positive else (array >= 0.0)))
    if wrong.any():
        raise ValueError(f"{name}: expected {wanted}, got {array[wrong].flat[0]}")
    try:
        return np.broadcast_to(array, shape).astype(np.float64)
    except ValueError:
        raise ValueError(f"{name}: expected a shape that broadcasts to {shape}, got {array.shape}") from None


def precision(*arrays: Floats) -> Any:
    """The dtype of the result: float32 only if all arrays are."""
    return np.dtype(np.float32 if all(array.dtype == np.float32 for array in arrays) else np.float64)


def finished(quat: FloatArray, known: BoolArray, dtype: Any) -> Floats:
    """Unit quaternions with w ≥ 0 (where w is zero, the first part that is not is positive); NaN where undetermined."""
    first = np.zeros(quat.shape[:-1])
    for part in np.moveaxis(quat, -1, 0):
        first = np.where(first == 0.0, part, first)
    signed = np.where(first[..., np.newaxis] < 0.0, -quat, quat)
    norm = length(signed)[..., np.newaxis]
    whole = known[..., np.newaxis] & (norm > 0.0)
    unit = np.divide(signed, norm, out=np.full_like(signed, np.nan), where=whole)
    result: Floats = (unit + 0.0).astype(dtype)  # no -0.0
    return result


def length(vector: FloatArray) -> FloatArray:
    """Lengths (...) of vectors (..., n); several times as fast as `numpy.linalg.norm` for few numbers."""
    size: FloatArray = np.sqrt(dot(vector, vector))
    return size


def dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Scalar products (...) of vectors (..., n)."""
    product: FloatArray = np.einsum("...i,...i->...", first, second)
    return product


def determinant(matrix: FloatArray) -> FloatArray:
    """Determinants (...) of matrices (..., 3, 3)."""
    return dot(matrix[..., 0, :], np.cross(matrix[..., 1, :], matrix[..., 2, :]))


def columns(*parts: FloatArray) -> FloatArray:
    """An array (..., n) of n arrays (...)."""
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def of_matrix(matrix: FloatArray) -> FloatArray:
    """Quaternions (..., 4), not of unit norm, of rotation matrices (..., 3, 3).

    The four rows are q times each of its parts (F. L. Markley, "Unit quaternion from rotation matrix", Journal of
    Guidance, Control, and Dynamics 31(2), 2008); the longest one has no cancellation at any rotation.
    """
    return longest(_quat.products_of(matrix))


def longest(rows: FloatArray) -> FloatArray:
    """The longest of the rows (..., n, 4)."""
    best = np.argmax(np.sum(rows * rows, axis=-1), axis=-1)
    return np.take_along_axis(rows, best[..., np.newaxis, np.newaxis], axis=-2)[..., 0, :]


#: Half a turn about no axis, x, y, z: 1, i, j, k. A direction turned so has two signs changed.
HALF_TURNS = np.eye(4)
#: What they do to a direction.
SIGNS = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
