"""Euler and Tait-Bryan angles of all sequences.

Bernardes and Viollet, "Quaternion to Euler angles conversion: a direct, general and computationally efficient method",
PLoS ONE 17(11):e0276302, 2022. With i, j, k the axes of an extrinsic sequence (k the third axis that there is, where
the first and last are the same), angles α, β, γ, and ε = ±1 the sign of the permutation (i, j, k), the proper sequence
i, j, i has

    w  = cos(β/2) cos((γ + α)/2)        q_j   = sin(β/2) cos((γ - α)/2)
    q_i = cos(β/2) sin((γ + α)/2)       ε q_k = sin(β/2) sin((γ - α)/2).

A quarter turn about j takes k to ε i. So exp(j π/4) ⊗ q of the sequence i, j, k is the proper one of α, β + π/2, ε γ.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import FloatArray, Floats

__all__ = ["from_euler", "to_euler"]

#: All proper Euler and Tait-Bryan sequences; upper case is intrinsic, lower case extrinsic.
SEQUENCES = tuple(
    name
    for intrinsic in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "XYX", "XZX", "YXY", "YZY", "ZXZ", "ZYZ")
    for name in (intrinsic, intrinsic.lower())
)
#: The sine or cosine of half the middle angle, in rounding errors, up to which it is zero: the first and third
#: rotations are then about one axis.
SINGULAR = 8.0


def from_euler(angles: ArrayLike, sequence: str, *, degrees: bool = False) -> Floats:
    """Quaternions of three rotations about axes.

    Parameters
    ----------
    angles : array_like
        (..., 3) rad, in the order of the sequence.
    sequence : str
        Three of x, y and z, neighbours being different: the 6 Tait-Bryan sequences and the 6 proper Euler sequences.
        Upper case is intrinsic (about the axes as they have been turned so far), lower case extrinsic (about the axes
        that stay), as in scipy. ``"ZYX"`` is yaw, pitch, roll.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 4).

    Raises
    ------
    ValueError
        Another shape or sequence.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.from_euler([0.0, 0.0, 60.0], "ZYX", degrees=True).round(6)
    array([0.866025, 0.5     , 0.      , 0.      ])
    """
    axes = _axes(sequence)
    values = _validate.rows("angles", angles, 3)
    values = np.radians(values) if degrees else values
    first, second, third = (_quat.about_axis(axis, values[..., k]) for k, axis in enumerate(axes))
    if sequence.isupper():
        return _quat.multiply(_quat.multiply(first, second), third)
    return _quat.multiply(third, _quat.multiply(second, first))


def to_euler(q: ArrayLike, sequence: str, *, degrees: bool = False) -> Floats:
    """Angles of three rotations about axes.

    The first and third angles are in [-π, π], the second in [-π/2, π/2] of a Tait-Bryan sequence and in [0, π] of a
    proper Euler sequence. Where it is at an end of that, only the sum or the difference of the others is defined: the
    third is 0 then.

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first.
    sequence : str
        As in `from_euler`; ``"ZYX"`` gives yaw, pitch, roll.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 3) rad, in the order of the sequence.

    Raises
    ------
    ValueError
        Another shape or sequence, or a norm that is not 1.

    See Also
    --------
    ahrs_rs.metrics.euler : Roll, pitch and yaw, in that order.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.from_euler([10.0, 90.0, 30.0], "ZYX", degrees=True)
    >>> ar.rotation.to_euler(q, "ZYX", degrees=True).round(6) + 0.0
    array([-20.,  90.,   0.])
    >>> ar.rotation.to_euler(q, "zxz", degrees=True).round(6) + 0.0
    array([-90.,  90.,  70.])
    """
    i, j, k = _axes(sequence)
    quat = _validate.unit_quaternions("q", q)
    intrinsic = sequence.isupper()
    if intrinsic:  # the extrinsic sequence backward
        i, k = k, i
    proper = i == k
    if proper:
        k = 3 - i - j
    sign = float((i - j) * (j - k) * (k - i)) / 2.0
    w, qi, qj, qk = quat[..., 0], quat[..., 1 + i], quat[..., 1 + j], sign * quat[..., 1 + k]
    a, b, c, d = (w, qi, qj, qk) if proper else (w - qj, qi + qk, qj + w, qk - qi)
    cosine, sine = np.hypot(a, b), np.hypot(c, d)  # of half the middle angle; √2 times those of i, j, k
    half_sum, half_difference = np.arctan2(b, a), np.arctan2(d, c)  # (γ + α)/2, (γ - α)/2
    least = SINGULAR * np.finfo(quat.dtype).eps
    half_sum = np.where(cosine <= least, np.where(intrinsic, half_difference, -half_difference), half_sum)
    half_difference = np.where(sine <= least, np.where(intrinsic, half_sum, -half_sum), half_difference)
    first, second, third = half_sum - half_difference, 2.0 * np.arctan2(sine, cosine), half_sum + half_difference
    if not proper:
        second, third = second - 0.5 * np.pi, sign * third
    if intrinsic:
        first, third = third, first
    angles = np.stack([_wrapped(first), second, _wrapped(third)], axis=-1).astype(quat.dtype, copy=False)
    return np.degrees(angles) if degrees else angles


def _axes(sequence: object) -> tuple[int, int, int]:
    if not isinstance(sequence, str) or sequence not in SEQUENCES:
        raise ValueError(
            "sequence: expected three of x, y, z (extrinsic) or of X, Y, Z (intrinsic), no two neighbours alike, "
            f"got {sequence!r}"
        )
    first, second, third = ("xyz".index(letter) for letter in sequence.lower())
    return first, second, third


def _wrapped(angle: FloatArray) -> FloatArray:
    """Angles within two turns, in [-π, π]."""
    turned: FloatArray = np.where(
        angle > np.pi, angle - 2.0 * np.pi, np.where(angle < -np.pi, angle + 2.0 * np.pi, angle)
    )
    return turned
