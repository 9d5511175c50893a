"""Madgwick's gradient descent filter.

Sources: Madgwick et al. 2011; Ludwig & Burnham 2018, Algorithm 2; Çoçoli & Badia 2023, (14)-(19). Objective
and Jacobian are written for an earth frame with x on north, as published; q1 to q4 are w, x, y, z.
"""

import math

import numpy as np
from numpy.typing import NDArray

from .adaptive import ACC_REJECTED, acc_share
from .base import Filter, Told, Weights
from .driver import FRAMES
from .gyro_integration import INTEGRATIONS, gyro_step
from .so3 import IDENTITY, Quat, Vec3, conjugate, multiply, normalize, rotate, unit

GRADIENTS = ("tangent", "paper")
SMALLEST_GRADIENT = 1e-12
LARGE_TURN = 0.1

Rows = tuple[list[float], list[list[float]]]


def acc_rows(q: Quat, a: Vec3) -> Rows:
    """Çoçoli (15) and (16): f = (up expected in the sensor frame) - a, and its Jacobian by q1 to q4."""
    q1, q2, q3, q4 = q
    ax, ay, az = a
    f = [
        2 * (q2 * q4 - q1 * q3) - ax,
        2 * (q1 * q2 + q3 * q4) - ay,
        2 * (0.5 - q2**2 - q3**2) - az,
    ]
    j = [
        [-2 * q3, 2 * q4, -2 * q1, 2 * q2],
        [2 * q2, 2 * q1, 2 * q4, 2 * q3],
        [0.0, -4 * q2, -4 * q3, 0.0],
    ]
    return f, j


def mag_rows(q: Quat, m: Vec3) -> Rows:
    """Madgwick 2011: f = (field expected in the sensor frame) - m, and its Jacobian by q1 to q4.

    The earth's field (bx, 0, bz) is the measured one in the earth frame, turned about z to north (Ludwig
    Alg 2, lines 1 and 2, where north is y).
    """
    hx, hy, hz = rotate(q, m)
    bx = math.hypot(hx, hy)
    bz = hz
    q1, q2, q3, q4 = q
    mx, my, mz = m
    f = [
        2 * bx * (0.5 - q3**2 - q4**2) + 2 * bz * (q2 * q4 - q1 * q3) - mx,
        2 * bx * (q2 * q3 - q1 * q4) + 2 * bz * (q1 * q2 + q3 * q4) - my,
        2 * bx * (q1 * q3 + q2 * q4) + 2 * bz * (0.5 - q2**2 - q3**2) - mz,
    ]
    j = [
        [-2 * bz * q3, 2 * bz * q4, -4 * bx * q3 - 2 * bz * q1, -4 * bx * q4 + 2 * bz * q2],
        [
            -2 * bx * q4 + 2 * bz * q2,
            2 * bx * q3 + 2 * bz * q1,
            2 * bx * q2 + 2 * bz * q4,
            -2 * bx * q1 + 2 * bz * q3,
        ],
        [2 * bx * q3, 2 * bx * q4 - 4 * bz * q2, 2 * bx * q1 - 4 * bz * q3, 2 * bx * q2],
    ]
    return f, j


def raw_gradient(q: Quat, acc: Vec3 | None, mag: Vec3 | None) -> NDArray[np.float64]:
    """Çoçoli (14), ∇f = Jᵀ f, over the rows of the vectors (any length) that are there; q has x on north."""
    f: list[float] = []
    j: list[list[float]] = []
    if acc is not None:
        f_acc, j_acc = acc_rows(q, unit(acc))
        f += f_acc
        j += j_acc
    if mag is not None:
        f_mag, j_mag = mag_rows(q, unit(mag))
        f += f_mag
        j += j_mag
    if not f:
        return np.zeros(4)
    gradient: NDArray[np.float64] = np.array(j).T @ np.array(f)
    return gradient


class Madgwick(Filter):
    """A gyroscope step, and a step of the length β dt down the gradient of the objective.

    gradient="paper" normalises the published gradient; "tangent" first takes off its component along q, which
    turns nothing and depends on the choice of axes.
    """

    follows_field = True

    def __init__(
        self,
        *,
        beta: float = 0.041,
        zeta: float = 0.0,
        acc_threshold: float = 0.0,
        gradient: str = "tangent",
        integration: str = "exponential",
    ) -> None:
        if gradient not in GRADIENTS:
            raise ValueError(f"gradient: expected one of {GRADIENTS}, got {gradient!r}")
        if integration not in INTEGRATIONS:
            raise ValueError(f"integration: expected one of {INTEGRATIONS}, got {integration!r}")
        self.beta = beta
        self.zeta = zeta
        self.acc_threshold = acc_threshold
        self.gradient = gradient
        self.integration = integration
        self.q = IDENTITY
        self.flags = 0
        self.bias: Vec3 = (0.0, 0.0, 0.0)

    def set_attitude(self, q: Quat) -> None:
        """Take over an attitude; the bias stays."""
        self.q = normalize(q)

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample: gradient at the previous attitude, bias, then both steps at once."""
        q = self.q
        weights = told.weights(dt)
        g, length = self._direction(acc, mag, weights)
        # A step that turns by more than LARGE_TURN is a gap, and turns no further than the error, half of ‖∇f‖.
        angle = 2 * self.beta * weights.time
        share = min(1.0, max(0.5 * length, LARGE_TURN) / angle) if angle > LARGE_TURN else 1.0
        feedback = weights.time * share
        _, *turn = multiply(conjugate(q), g)
        error_rate = [2 * component for component in turn]  # Ludwig Alg 2: ω_e = 2 q* ⊗ q_e
        zeta = 0.0 if told.recovering else self.zeta
        self.bias = (
            self.bias[0] + zeta * error_rate[0] * feedback,
            self.bias[1] + zeta * error_rate[1] * feedback,
            self.bias[2] + zeta * error_rate[2] * feedback,
        )
        rate = (gyr[0] - self.bias[0], gyr[1] - self.bias[1], gyr[2] - self.bias[2])
        if self.integration == "exponential":
            corrected = (
                rate[0] * dt - self.beta * error_rate[0] * feedback,
                rate[1] * dt - self.beta * error_rate[1] * feedback,
                rate[2] * dt - self.beta * error_rate[2] * feedback,
            )
            self.q = gyro_step(q, corrected, 1.0, "exponential")
        else:
            d = multiply(q, (0.0, rate[0], rate[1], rate[2]))  # twice Çoçoli (18)
            self.q = normalize(
                (
                    q[0] + dt * 0.5 * d[0] - feedback * self.beta * g[0],  # Çoçoli (17) with ‖∇f‖, and (19)
                    q[1] + dt * 0.5 * d[1] - feedback * self.beta * g[1],
                    q[2] + dt * 0.5 * d[2] - feedback * self.beta * g[2],
                    q[3] + dt * 0.5 * d[3] - feedback * self.beta * g[3],
                )
            )

    def _direction(self, acc: Vec3 | None, mag: Vec3 | None, weights: Weights) -> tuple[Quat, float]:
        """Unit gradient in the internal ENU, or zero where there is none to follow; and the gradient's length."""
        north_on_x = multiply(FRAMES["NWU"], self.q)
        of_acc = weights.acc * raw_gradient(north_on_x, acc, None)
        whole = of_acc + weights.mag * raw_gradient(north_on_x, None, mag)
        # Of the accelerometer's part only a share counts, and the step gets shorter by what is left out.
        share = acc_share(acc, self.acc_threshold)
        self.flags = ACC_REJECTED if share == 0 else 0
        g = whole - (1.0 - share) * of_acc
        if self.gradient == "tangent":
            along = np.array(north_on_x)
            g, whole = (v - (v @ along) * along for v in (g, whole))
        length = float(max(np.linalg.norm(g), np.linalg.norm(whole)))
        if length < SMALLEST_GRADIENT:
            return (0.0, 0.0, 0.0, 0.0), length
        w, x, y, z = (g / length).tolist()
        return multiply(conjugate(FRAMES["NWU"]), (w, x, y, z)), length
