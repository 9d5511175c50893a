"""Cirillo et al. 2014, eqs 7-26: an extended Kalman filter on quaternion and angular rate.

Their base frame has z down and x along the first heading; here it is east-north-up, so the expected specific force is
+1 on z and the reference field lies in the plane of north and up.
"""

import math

import numpy as np

from .base import Filter, Told, steps
from .gyro_integration import INTEGRATIONS
from .kalman import (
    LARGEST_TURN,
    SAME_VERTICAL,
    SATURATION,
    Array,
    angle_variance,
    capped,
    gain,
    inflated,
    joseph,
    normalised_square,
    reported,
    rotation,
    saturated,
    triple,
)
from .so3 import IDENTITY, Quat, Vec3, exp_half, normalize, unit

#: Cirillo's W belongs to steps of 2 ms.
CIRILLO_STEP = 0.002
GYROSCOPES = ("measurement", "input")
#: Largest angular rate that the state takes (rad/s), and largest variances of its two parts.
LARGEST_RATE = 1e4
LARGEST_VARIANCES = np.array([1.0] * 4 + [1e4] * 3)


class EKF(Filter):
    """State x = [q, ω], measurements ω, specific force over g, field over its reference's norm."""

    follows_field = True
    #: Its variances are those of a sensor at rest, and not what is to be believed of it.
    watched = True

    def __init__(
        self,
        *,
        gyr_variance_x: float = 2.9e-5,
        gyr_variance_y: float = 2.3e-5,
        gyr_variance_z: float = 3.2e-5,
        acc_variance_x: float = 3.1e-5,
        acc_variance_y: float = 4.5e-5,
        acc_variance_z: float = 5.5e-5,
        mag_variance_x: float = 2.0e-3,
        mag_variance_y: float = 2.1e-3,
        mag_variance_z: float = 2.0e-3,
        quat_process: float = 1e-10 / CIRILLO_STEP,
        rate_process: float = 1e-3 / CIRILLO_STEP,
        reference_time: float = 0.0,
        initial_inclination: float = 0.0,
        initial_heading: float = 0.0,
        initial_rate: float = 1.0,
        gravity: float = 9.80665,
        gyroscope: str = "measurement",
        integration: str = "exponential",
    ) -> None:
        if integration not in INTEGRATIONS:
            raise ValueError(f"integration: expected one of {INTEGRATIONS}, got {integration!r}")
        if gyroscope not in GYROSCOPES:
            raise ValueError(f"gyroscope: expected one of {GYROSCOPES}, got {gyroscope!r}")
        self.v = {
            "gyr": np.diag([gyr_variance_x, gyr_variance_y, gyr_variance_z]),
            "acc": np.diag([acc_variance_x, acc_variance_y, acc_variance_z]),
            "mag": np.diag([mag_variance_x, mag_variance_y, mag_variance_z]),
        }
        self.w_diagonal = np.array([quat_process] * 4 + [rate_process] * 3)  # per second
        self.reference_time = reference_time
        # 0: as uncertain as one sample of the accelerometer, and of the magnetometer at a dip of 60°
        self.inclination_variance = angle_variance(initial_inclination**2 or float(np.trace(self.v["acc"])) / 3)
        self.heading_variance = angle_variance(initial_heading**2 or 4 * float(np.trace(self.v["mag"])) / 3)
        self.g = gravity
        self.gyroscope = gyroscope
        self.integration = integration
        self.x = np.array([*IDENTITY, 0.0, 0.0, 0.0])
        self.initial_rate = initial_rate
        self.p = np.zeros((7, 7))
        self.reopen((0.0, 0.0, 0.0))
        self.reference: Array | None = None  # horizontal and vertical part of h̄, as measured
        self.reference_count = 0
        self.reference_age = 0.0
        self.headed = False
        self.innovation = np.full(9, np.nan)
        self.nis = np.full(3, np.nan)
        self.flags = 0

    @property
    def q(self) -> Quat:
        """Attitude, the normalised first part of the state."""
        w, x, y, z = self.x[:4].tolist()
        return (w, x, y, z)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude: the heading's variance starts afresh, the inclination's where the vertical is new.

        The rate and its variance stay; the correlation of attitude and rate is dropped.
        """
        q = normalize(q)
        up_before, up = rotation(self.q)[2], rotation(q)[2]
        inclination = self._attitude_covariance()
        if np.linalg.norm(up - up_before) > SAME_VERTICAL:
            inclination = self.inclination_variance * np.eye(3)
        self.x[:4] = q
        self._start(up, inclination)

    def claimed(self) -> tuple[float, float]:
        """What is to be believed of it: 0.05 rad, and 1 rad of the heading."""
        return 0.05**2, 1.0

    def reopen(self, bias: Vec3) -> None:
        """Start anew; there is no bias."""
        self.p[4:, 4:] = self.initial_rate**2 * np.eye(3)
        self._start(rotation(self.q)[2], self.inclination_variance * np.eye(3))

    def _start(self, up: Array, inclination: Array) -> None:
        t = np.eye(3) - np.outer(up, up)
        p = t @ inclination @ t + self.heading_variance * np.outer(up, up)
        xi = xi_matrix(self.x[:4])
        self.p[:4, :] = self.p[:, :4] = 0.0
        self.p[:4, :4] = xi @ p @ xi.T / 4

    def _attitude_covariance(self) -> Array:
        """P_θ = 4 Ξᵀ P_q Ξ: from q̂ + δq = q̂ ⊗ (1, δθ/2)."""
        xi = xi_matrix(self.x[:4])
        return 4 * xi.T @ self.p[:4, :4] @ xi

    @property
    def covariance(self) -> Array:
        """Attitude covariance (3, 3), sensor frame, rad²."""
        return reported(self._attitude_covariance(), rotation(self.q)[2], self.headed)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample: (23)-(24) over dt, then (25)-(26) with what was measured."""
        rate = saturated(np.array(gyr), LARGEST_RATE)
        if self.gyroscope == "input" and dt > 0.0:
            self.x[4:] = rate
            self.p[4:, :] = self.p[:, 4:] = 0.0
            self.p[4:, 4:] = self.v["gyr"]
        if dt > 0.0:
            self._predict(dt)

        rows: dict[str, tuple[Array, Array]] = {}  # innovation and H of each sensor, all at the predicted state
        if self.gyroscope == "measurement" and dt > 0.0 and not told.lost:
            rows["gyr"] = (rate - self.x[4:], np.eye(3, 7, 4))
        if acc is not None:
            z = saturated(np.array(acc) / self.g, SATURATION)
            predicted, h = measurement(self.x[:4], np.array([0.0, 0.0, 1.0]))  # (10)
            rows["acc"] = (z - predicted, h)
        if mag is not None:
            reference = self._reference(acc, mag, told.mag_interval)
            norm = float(np.linalg.norm(reference))
            z = saturated(np.array(mag) / norm, SATURATION)
            predicted, h = measurement(self.x[:4], reference / norm)  # (16)
            rows["mag"] = (z - predicted, h)
            self.headed = True
        # V is that of a sample at the gyroscope's rate.
        v = {"gyr": self.v["gyr"]}
        v["acc"] = self.v["acc"] / steps(told.acc_interval, told.usual)
        v["mag"] = self.v["mag"] / steps(told.mag_interval, told.usual)
        self._update(rows, v)

    def _predict(self, dt: float) -> None:
        """(20), (23), (24); x⁻ = f(x), P⁻ = F P Fᵀ + W."""
        q, rate = self.x[:4].copy(), self.x[4:]
        f = np.eye(7)
        if self.integration == "exponential":
            h = rate * dt / 2
            e = np.array(exp_half(triple(h)))
            f[:4, :4] = right(e)
            f[:4, 4:] = left(q) @ exp_derivative(h) * dt / 2
            self.x[:4] = f[:4, :4] @ q
        else:
            half = saturated(rate * dt / 2, LARGEST_TURN)
            f[:4, :4] = np.eye(4) + right(np.array([0.0, *half]))  # (18): I + Ts E(ω)
            f[:4, 4:] = dt / 2 * xi_matrix(q)
            self.x[:4] = f[:4, :4] @ q
        self.p = f @ self.p @ f.T + dt * np.diag(self.w_diagonal)
        self.p = capped(inflated(self.p), LARGEST_VARIANCES)

    def _reference(self, acc: Vec3 | None, mag: Vec3, interval: float) -> Array:
        """(16)'s h̄ in east-north-up: mean of the field over the first `reference_time`, turned to north.

        What is up is said by the accelerometer, as in (11)-(14), and by the attitude where there is none.
        """
        if self.reference is not None:
            self.reference_age += interval
        if self.reference is None or self.reference_age <= self.reference_time:
            up = rotation(normalize(self.q))[2] if acc is None else np.array(unit(acc))
            field = np.array([np.linalg.norm(np.cross(mag, up)), np.dot(mag, up)])
            self.reference_count += 1
            old = np.zeros(2) if self.reference is None else self.reference
            self.reference = old + (field - old) / self.reference_count
        return np.array([0.0, *self.reference])

    def _update(self, rows: dict[str, tuple[Array, Array]], v: dict[str, Array]) -> None:
        self.innovation = np.full(9, np.nan)
        self.nis = np.full(3, np.nan)
        correction = np.zeros(7)
        # Sensor after sensor, each with the same H as if all came at once: the same estimate as (25)-(26).
        for index, sensor in enumerate(("gyr", "acc", "mag")):
            if sensor not in rows:
                continue
            innovation, h = rows[sensor]
            nu = innovation - h @ correction
            k, s = gain(self.p, h, v[sensor])
            correction = correction + k @ nu
            self.p = joseph(self.p, k, h, v[sensor])
            self.innovation[3 * index : 3 * index + 3] = innovation
            self.nis[index] = normalised_square(nu, s)
        self.x = self.x + correction
        self.x[:4] /= np.linalg.norm(self.x[:4])
        self.x[4:] = saturated(self.x[4:], LARGEST_RATE)


def left(q: Array) -> Array:
    """Matrix of p -> q ⊗ p."""
    w, x, y, z = q.tolist()
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])


def right(q: Array) -> Array:
    """Matrix of p -> p ⊗ q."""
    w, x, y, z = q.tolist()
    return np.array([[w, -x, -y, -z], [x, w, z, -y], [y, -z, w, x], [z, y, -x, w]])


def xi_matrix(q: Array) -> Array:
    """Ξ(q), (4, 3): q ⊗ (0, v) = Ξ(q) v."""
    return left(q)[:, 1:]


def exp_derivative(h: Array) -> Array:
    """Derivative (4, 3) of the quaternion exponential (cos|h|, h sin|h|/|h|) by h."""
    n2 = float(h @ h)
    n = math.sqrt(n2)
    sinc = math.sin(n) / n if n > 0.0 else 1.0
    # (cos n - sin n / n) / n², by its series where the difference would cancel
    c = -1 / 3 + n2 / 30 - n2**2 / 840 + n2**3 / 45360 if n2 < 1e-2 else (math.cos(n) - sinc) / n2
    return np.vstack([-sinc * h, sinc * np.eye(3) + c * np.outer(h, h)])


def measurement(q: Array, v: Array) -> tuple[Array, Array]:
    """The earth vector v seen from the sensor, q* ⊗ v ⊗ q, and its derivative (3, 7) by the state.

    Homogeneous of second degree in q, as (10) and (16) are: q is not normalised here.
    """
    conjugate = np.diag([1.0, -1.0, -1.0, -1.0])
    vq = left(np.array([0.0, *v])) @ q  # v ⊗ q
    seen = left(conjugate @ q) @ vq
    # d(q* ⊗ v ⊗ q) = dq* ⊗ (v ⊗ q) + q* ⊗ v ⊗ dq
    by_q = right(vq) @ conjugate + left(conjugate @ q) @ left(np.array([0.0, *v]))
    return seen[1:], np.hstack([by_q[1:], np.zeros((3, 3))])
