"""Quaternion arithmetic in numpy: scalar-first, Hamilton, any leading shape, in the dtype of the arguments.

Nothing is checked here: `ahrs_rs.rotation` has the same for users.
"""

from __future__ import annotations

import numpy as np

from ahrs_rs._typing import FloatArray


def multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """Hamilton product p ⊗ q."""
    pw, px, py, pz = p[..., 0], p[..., 1], p[..., 2], p[..., 3]
    qw, qx, qy, qz = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    return columns(
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def conjugate(q: FloatArray) -> FloatArray:
    """The inverse of a unit quaternion."""
    inverse: FloatArray = q * np.array([1.0, -1.0, -1.0, -1.0], dtype=np.asarray(q).dtype)
    return inverse


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """The vectors v (..., 3) turned by the unit quaternions q: v + 2 u × (u × v + w v) for q = (w, u)."""
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    a, b, c = v[..., 0], v[..., 1], v[..., 2]
    d, e, f = y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c
    return columns(a + 2.0 * (y * f - z * e), b + 2.0 * (z * d - x * f), c + 2.0 * (x * e - y * d))


def log(q: FloatArray) -> FloatArray:
    """Rotation vectors (..., 3) in rad, of angle at most π, of unit quaternions; q and -q give the same."""
    q = upper(q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    # angle / sin(angle/2): 2 at the identity, where the quotient is 0/0; sine is exact for every other q.
    factor = np.full_like(sine, 2.0)
    np.divide(2.0 * np.arctan2(sine, q[..., :1]), sine, out=factor, where=sine > 0)
    vector: FloatArray = factor * q[..., 1:]
    return vector


def exp(vector: FloatArray) -> FloatArray:
    """Unit quaternions (..., 4) of rotation vectors (..., 3) in rad."""
    half = 0.5 * np.linalg.norm(vector, axis=-1)
    size = 0.5 * np.sinc(half / np.pi)  # sinc(x) = sin(πx)/(πx)
    return columns(np.cos(half), *(size * part for part in np.moveaxis(vector, -1, 0)))


def about_axis(axis: int, angle: FloatArray) -> FloatArray:
    """Unit quaternions of rotations by `angle` (rad) about the axis 0, 1 or 2 (x, y, z)."""
    q = np.zeros((*np.shape(angle), 4), dtype=np.result_type(angle, np.float32))
    q[..., 0] = np.cos(0.5 * angle)
    q[..., 1 + axis] = np.sin(0.5 * angle)
    return q


def slerp(p: FloatArray, q: FloatArray, part: FloatArray) -> FloatArray:
    """The shortest rotation from p to q, of which a part has been made: p at 0, q (or -q) at 1."""
    return multiply(p, exp(part[..., np.newaxis] * log(multiply(conjugate(p), q))))


def of_matrix(matrix: FloatArray) -> FloatArray:
    """Unit quaternions (..., 4), w >= 0, of rotation matrices (..., 3, 3), by the largest row of 4 q qᵀ."""
    products = products_of(matrix)
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(products, largest[..., np.newaxis, np.newaxis], axis=-2)[..., 0, :]
    return upper(row / np.linalg.norm(row, axis=-1, keepdims=True))


def products_of(matrix: FloatArray) -> FloatArray:
    """(..., 4, 4): 4 q qᵀ of rotation matrices (..., 3, 3); of others its largest eigenvector is the nearest rotation.

    That one has the largest tr(Rᵀ matrix), which is qᵀ (products - 1) q, so the least sum of squares of R - matrix.
    """
    r = np.moveaxis(matrix, (-2, -1), (0, 1))
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    x, y, z = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    xy, xz, yz = r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1]
    diagonal = [1.0 + 2.0 * r[k, k] - trace for k in range(3)]
    rows = [[1.0 + trace, x, y, z], [x, diagonal[0], xy, xz], [y, xy, diagonal[1], yz], [z, xz, yz, diagonal[2]]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def mean(quat: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """The mean (..., 4), w >= 0, of rotations (..., n, 4): the largest eigenvector of Σ w q qᵀ, whatever their signs.

    Markley, Cheng, Crassidis and Oshman, "Averaging quaternions", J. Guidance 30(4), 2007, eqs 12 and 13.
    """
    weighted = quat if weights is None else quat * weights[..., np.newaxis]
    return upper(np.linalg.eigh(np.swapaxes(weighted, -1, -2) @ quat)[1][..., -1])


def upper(q: FloatArray) -> FloatArray:
    """The same rotations with w >= 0."""
    return np.where(q[..., :1] < 0.0, -q, q)


def columns(*parts: FloatArray) -> FloatArray:
    """An array (..., n) from n arrays (...), each of which stays in one piece in memory: the fast layout here."""
    stacked = np.array(parts)
    return stacked.T if stacked.ndim <= 2 else np.moveaxis(stacked, 0, -1)
