"""Rotations in plain double precision, for the oracle filters.

Quaternions are tuples ``(w, x, y, z)`` (Hamilton product) and vectors tuples of three floats. Sines, cosines
and arctangents are those of the platform's C library, through `math`. The forms are chosen to be readable and
accurate everywhere; none is chosen for speed.
"""

import math
import sys

Quat = tuple[float, float, float, float]
Vec3 = tuple[float, float, float]

IDENTITY: Quat = (1.0, 0.0, 0.0, 0.0)
Z_AXIS: Vec3 = (0.0, 0.0, 1.0)


def multiply(p: Quat, q: Quat) -> Quat:
    """Hamilton product p ⊗ q (as rotations: first q, then p)."""
    pw, px, py, pz = p
    qw, qx, qy, qz = q
    return (
        pw * qw - px * qx - py * qy - pz * qz,
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
    )


def conjugate(q: Quat) -> Quat:
    """Conjugate q*, the inverse rotation of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def normalize(q: Quat) -> Quat:
    """Q divided by its norm, which must not be zero."""
    n = math.hypot(*q)
    return (q[0] / n, q[1] / n, q[2] / n, q[3] / n)


def rotate(q: Quat, v: Vec3) -> Vec3:
    """Vector part of q ⊗ (0, v) ⊗ q*: from the sensor frame to the earth frame."""
    _, x, y, z = multiply(multiply(q, (0.0, *v)), conjugate(q))
    return (x, y, z)


def rotate_inverse(q: Quat, v: Vec3) -> Vec3:
    """Vector part of q* ⊗ (0, v) ⊗ q: from the earth frame to the sensor frame."""
    return rotate(conjugate(q), v)


def before(q: Quat, rate: Vec3, time: float) -> Quat:
    """The attitude a time (s) ago, from which a constant rate has led to q."""
    x, y, z = (-0.5 * time * one for one in rate)
    return multiply(q, exp_half((x, y, z)))


def matrix(q: Quat) -> tuple[Vec3, Vec3, Vec3]:
    """Rotation matrix R(q) as three rows, v_earth = R v_sensor: its columns are the turned sensor axes."""
    c1, c2, c3 = (rotate(q, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    return ((c1[0], c2[0], c3[0]), (c1[1], c2[1], c3[1]), (c1[2], c2[2], c3[2]))


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Cross product a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def squared_norm(v: Vec3) -> float:
    """v·v; may overflow to inf or be NaN, as the driver's validity rule expects."""
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]


def normal(v: Vec3) -> bool:
    """Whether the squared norm is finite and a normal number: such a vector has a direction."""
    return sys.float_info.min <= squared_norm(v) < math.inf


def unit(v: Vec3) -> Vec3:
    """V divided by its norm, which must not be zero."""
    n = math.hypot(*v)
    return (v[0] / n, v[1] / n, v[2] / n)


def exp_half(h: Vec3) -> Quat:
    """Quaternion exponential of the pure quaternion (0, h): the rotation by the vector 2h (rad)."""
    n = math.hypot(*h)
    if n == 0.0:
        return IDENTITY
    s = math.sin(n) / n
    return (math.cos(n), s * h[0], s * h[1], s * h[2])


def about_z(angle: float) -> Quat:
    """Rotation about z by an angle in rad."""
    return (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))


def shortest_to_z(u: Vec3) -> Quat:
    """Shortest rotation that takes a direction u to +z; from exactly -z it is half a turn about x.

    Axis u × z = (u_y, -u_x, 0), angle atan2(|u × z|, u_z); u need not be a unit vector, but not zero.
    """
    s = math.hypot(u[0], u[1])
    if s == 0.0:
        return IDENTITY if u[2] > 0.0 else (0.0, 1.0, 0.0, 0.0)
    half = math.atan2(s, u[2]) / 2
    return (math.cos(half), math.sin(half) * u[1] / s, -math.sin(half) * u[0] / s, 0.0)


def north_turn(field: Vec3) -> Quat | None:
    """Turn about z that brings the horizontal part of an earth-frame field to +y (north of ENU).

    None where the horizontal part is below 1e-6 of the field: no heading in it.
    """
    if math.hypot(field[0], field[1]) < 1e-6 * math.hypot(*field):
        return None
    return about_z(math.atan2(field[0], field[1]))


def wrap(angle: float) -> float:
    """Angle (rad) brought to [-π, π]."""
    return math.remainder(angle, 2 * math.pi)


def to_euler(q: Quat) -> Vec3:
    """Roll, pitch, yaw (rad) of the intrinsic Z-Y'-X'' sequence; pitch in [-π/2, π/2].

    w + y and x - z are √2 sin(pitch/2 + π/4) times cosine and sine of (roll - yaw)/2; w - y and x + z are
    √2 cos(pitch/2 + π/4) times cosine and sine of (roll + yaw)/2. At pitch ±π/2 one of the two pairs vanishes
    and its angle is arbitrary; the angles given still rebuild q, in which that angle is multiplied by zero.
    """
    w, x, y, z = q
    half_difference = math.atan2(x - z, w + y)
    half_sum = math.atan2(x + z, w - y)
    pitch = 2 * math.atan2(math.hypot(x - z, w + y), math.hypot(x + z, w - y)) - math.pi / 2
    return (wrap(half_sum + half_difference), pitch, wrap(half_sum - half_difference))


def from_euler(roll: float, pitch: float, yaw: float) -> Quat:
    """Quaternion of roll, pitch, yaw (rad), as the product Rz(yaw) ⊗ Ry(pitch) ⊗ Rx(roll)."""
    rz = about_z(yaw)
    ry = (math.cos(pitch / 2), 0.0, math.sin(pitch / 2), 0.0)
    rx = (math.cos(roll / 2), math.sin(roll / 2), 0.0, 0.0)
    return multiply(multiply(rz, ry), rx)


def rotation_vector(q: Quat) -> Vec3:
    """The rotation (rad) of a unit quaternion, of at most half a turn."""
    w, x, y, z = q if q[0] >= 0.0 else (-q[0], -q[1], -q[2], -q[3])
    sin = math.hypot(x, y, z)
    factor = 2.0 * math.atan2(sin, w) / sin if sin > 0.0 else 2.0
    return (factor * x, factor * y, factor * z)
