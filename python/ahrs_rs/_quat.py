"""Quaternion arithmetic in numpy, for scores and simulation: scalar-first, Hamilton, any leading shape."""

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
    inverse: FloatArray = q * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """The vectors v (..., 3) turned by the unit quaternions q: v + 2 u × (u × v + w v) for q = (w, u)."""
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    a, b, c = v[..., 0], v[..., 1], v[..., 2]
    d, e, f = y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c
    return columns(a + 2.0 * (y * f - z * e), b + 2.0 * (z * d - x * f), c + 2.0 * (x * e - y * d))


def log(q: FloatArray) -> FloatArray:
    """Rotation vectors (..., 3) in rad, of angle at most π, of unit quaternions; q and -q give the same."""
    q = np.where(q[..., :1] < 0, -q, q)
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
    q = np.zeros((*np.shape(angle), 4))
    q[..., 0] = np.cos(0.5 * angle)
    q[..., 1 + axis] = np.sin(0.5 * angle)
    return q


def columns(*parts: FloatArray) -> FloatArray:
    """An array (..., n) from n arrays (...), each of which stays in one piece in memory: the fast layout here."""
    stacked = np.array(parts)
    return stacked.T if stacked.ndim <= 2 else np.moveaxis(stacked, 0, -1)
