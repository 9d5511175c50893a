"""What rotations do: to each other, to vectors, and about an axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _quat, _validate
from ahrs_rs._typing import FloatArray, Floats

__all__ = ["about_axis", "distance", "inverse", "product", "rotate", "shortest_arc", "swing_twist"]

#: Unit vectors of the axes by their names.
AXES = {"x": 0, "y": 1, "z": 2}


def product(p: ArrayLike, q: ArrayLike) -> Floats:
    """The Hamilton product p ⊗ q: the rotation by q, then by p.

    Parameters
    ----------
    p : array_like
        (..., 4) quaternions, scalar-first.
    q : array_like
        (..., 4) quaternions, scalar-first.

    Returns
    -------
    ndarray
        (..., 4), with the leading axes of both.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> quarter = ar.rotation.about_axis("z", 90.0, degrees=True)
    >>> ar.rotation.product(quarter, quarter).round(6) + 0.0
    array([0., 0., 0., 1.])
    """
    first, second = _pair(p, q)
    return _quat.multiply(first, second)


def inverse(q: ArrayLike) -> Floats:
    """The rotation back: from the earth frame to the sensor frame.

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first.

    Returns
    -------
    ndarray
        (..., 4).

    Raises
    ------
    ValueError
        Another shape, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.inverse([0.6, 0.0, 0.8, 0.0]) + 0.0
    array([ 0.6,  0. , -0.8,  0. ])
    """
    return _quat.conjugate(_unit("q", q))


def rotate(q: ArrayLike, v: ArrayLike) -> Floats:
    """Vectors of the sensor frame in the earth frame: v + 2 u × (u × v + w v) for q = (w, u).

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first.
    v : array_like
        (..., 3) vectors of any unit.

    Returns
    -------
    ndarray
        (..., 3), with the leading axes of both.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, or a norm of a quaternion that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> quarter = ar.rotation.about_axis("z", 90.0, degrees=True)
    >>> ar.rotation.rotate(quarter, [1.0, 0.0, 5.0]).round(6) + 0.0
    array([0., 1., 5.])
    """
    quat, vectors = _validate.together("q, v", _unit("q", q), _validate.rows("v", v, 3))
    return _quat.rotate(quat, vectors)


def distance(p: ArrayLike, q: ArrayLike) -> Floats:
    """The angle of the rotation between p and q, 0 to π, exact to rounding at every angle.

    Parameters
    ----------
    p : array_like
        (..., 4) quaternions, scalar-first.
    q : array_like
        (..., 4) quaternions, scalar-first.

    Returns
    -------
    ndarray
        (...,) rad.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, or a norm that is not 1.

    See Also
    --------
    ahrs_rs.metrics : Other distances, and errors against a reference.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(float(ar.rotation.distance([1.0, 0.0, 0.0, 0.0], [-0.6, 0.0, 0.8, 0.0])), 6)
    1.85459
    """
    first, second = _pair(p, q)
    turn = _quat.multiply(_quat.conjugate(first), second)
    angle: Floats = 2.0 * np.arctan2(np.linalg.norm(turn[..., 1:], axis=-1), np.abs(turn[..., 0]))
    return angle


def about_axis(axis: str | ArrayLike, angle: ArrayLike, *, degrees: bool = False) -> Floats:
    """Rotations by an angle about an axis, by the right-hand rule.

    Parameters
    ----------
    axis : str or array_like
        ``"x"``, ``"y"`` or ``"z"``, or vectors (..., 3) of any length but zero.
    angle : array_like
        (...,) rad.
    degrees : bool, optional
        Degrees in place of radians.

    Returns
    -------
    ndarray
        (..., 4), with the leading axes of both.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, or an axis of length zero.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.rotation.about_axis([0.0, 0.0, 2.0], 60.0, degrees=True).round(6)
    array([0.866025, 0.      , 0.      , 0.5     ])
    """
    angles = _validate.reals("angle", angle)
    angles = np.radians(angles) if degrees else angles
    if isinstance(axis, str):
        return _quat.about_axis(AXES[_validate.choice("axis", axis, tuple(AXES))], angles)
    directions = direction("axis", axis)
    half, directions = _validate.together("angle, axis", 0.5 * angles[..., np.newaxis], directions)
    vector = np.sin(half) * directions
    w = np.broadcast_to(np.cos(half), (*vector.shape[:-1], 1))
    return np.concatenate([w, vector], axis=-1)


def shortest_arc(u: ArrayLike, v: ArrayLike) -> Floats:
    """The shortest rotations that take directions u to directions v.

    Of opposite directions it is half a turn about the axis, perpendicular to u, that is nearest to the x, y or z axis
    from which u is farthest.

    Parameters
    ----------
    u : array_like
        (..., 3) vectors of any length but zero.
    v : array_like
        (..., 3) vectors of any length but zero.

    Returns
    -------
    ndarray
        (..., 4), w >= 0: ``rotate(q, u)`` points along v.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, or a vector of length zero.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.shortest_arc([1.0, 0.0, 0.0], [0.0, 0.0, 3.0])
    >>> ar.rotation.rotate(q, [1.0, 0.0, 0.0]).round(6) + 0.0
    array([0., 0., 1.])
    """
    first, second = _validate.together("u, v", direction("u", u), direction("v", v))
    first, second = np.broadcast_arrays(first, second)
    # Twice the half-way vector is u + v, and twice the half angle's sine times the axis is along u × v. Where both
    # vanish the axis is any that is perpendicular.
    farthest = np.eye(3, dtype=first.dtype)[np.argmin(np.abs(first), axis=-1)]
    across = np.cross(first, farthest)
    across = np.cross(across, first) / np.linalg.norm(across, axis=-1, keepdims=True)
    # cos and sin of the half angle as lengths: exact also near half a turn, where 1 + u·v cancels.
    cosine = 0.5 * np.linalg.norm(first + second, axis=-1, keepdims=True)
    sine = 0.5 * np.linalg.norm(first - second, axis=-1, keepdims=True)
    # u × v, of whose products nothing is lost where it is small.
    normal = np.cross(first, second + np.where(cosine < sine, first, -first))
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    # Of directions that are opposite to rounding, u × v is only rounding.
    vague = (length <= 4.0 * np.finfo(first.dtype).eps) & (cosine < sine)
    axis = np.where(vague, across, normal / np.where(length > 0.0, length, 1.0))
    quat = np.concatenate([np.where(vague, 0.0, cosine), sine * axis], axis=-1)
    found: Floats = (quat / np.linalg.norm(quat, axis=-1, keepdims=True)).astype(first.dtype, copy=False)
    return found


def swing_twist(q: ArrayLike, axis: str | ArrayLike) -> tuple[Floats, Floats, Floats]:
    """A rotation as a twist about an axis of the sensor frame, and a swing after it: q = swing ⊗ twist.

    The twist is the rotation about the axis that is nearest to q (its projection), and the axis of the swing is
    perpendicular. The twist of q = twist ⊗ swing, about the axis of the earth frame, is the same.

    Parameters
    ----------
    q : array_like
        (..., 4) quaternions, scalar-first.
    axis : str or array_like
        ``"x"``, ``"y"`` or ``"z"``, or vectors (..., 3) of any length but zero.

    Returns
    -------
    swing : ndarray
        (..., 4), w >= 0.
    twist : ndarray
        (..., 4), w >= 0.
    angle : ndarray
        (...,) of the twist, rad, in [-π, π]; 0 where the swing is half a turn, which leaves it open.

    Raises
    ------
    ValueError
        Another shape, leading axes that do not fit, an axis of length zero, or a norm that is not 1.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> q = ar.rotation.from_euler([20.0, 30.0, 0.0], "XZY", degrees=True)
    >>> swing, twist, angle = ar.rotation.swing_twist(q, "z")
    >>> round(float(angle), 6), round(float(ar.rotation.distance(swing, [1.0, 0.0, 0.0, 0.0])), 6)
    (0.523599, 0.349066)
    """
    named = isinstance(axis, str)
    given = np.eye(3, dtype=np.float32)[AXES[_validate.choice("axis", axis, tuple(AXES))]] if named else axis
    quat, unit = _validate.together("q, axis", _unit("q", q), direction("axis", given))
    w, along = quat[..., 0], np.sum(quat[..., 1:] * unit, axis=-1)
    size = np.hypot(w, along)
    # Half a turn of swing leaves w and the component along the axis zero to rounding: no twist then.
    open_ = size <= 4.0 * np.finfo(quat.dtype).eps
    safe = np.where(open_, 1.0, size)
    cosine, sine = np.where(open_, 1.0, w / safe), np.where(open_, 0.0, along / safe)
    flip = np.where(cosine < 0.0, -1.0, 1.0).astype(quat.dtype)
    cosine, sine = (cosine * flip).astype(quat.dtype), (sine * flip).astype(quat.dtype)
    shape = np.broadcast_shapes(cosine.shape, unit.shape[:-1])
    twist = np.concatenate([np.broadcast_to(cosine, shape)[..., np.newaxis], sine[..., np.newaxis] * unit], axis=-1)
    swing = _quat.upper(_quat.multiply(quat, _quat.conjugate(twist)))
    angle: Floats = 2.0 * np.arctan2(sine, cosine)
    return swing, twist, angle


def direction(name: str, given: ArrayLike) -> FloatArray:
    """Unit vectors (..., 3) of vectors; ValueError where one is zero."""
    vectors = _validate.rows(name, given, 3)
    scale = np.max(np.abs(vectors), axis=-1, keepdims=True)  # squares of small and large numbers are lost
    if (scale == 0.0).any():
        raise ValueError(f"{name}: expected vectors that are not zero, got {vectors[scale[..., 0] == 0.0][0]}")
    scaled = vectors / scale
    found: FloatArray = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
    return found


def _unit(name: str, given: ArrayLike) -> FloatArray:
    return _validate.unit_quaternions(name, given)


def _pair(p: ArrayLike, q: ArrayLike) -> tuple[FloatArray, ...]:
    return _validate.together("p, q", _unit("p", p), _unit("q", q))
