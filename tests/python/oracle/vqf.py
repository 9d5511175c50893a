"""VQF and BasicVQF: Laidig & Seel 2023, with the defaults and the order of steps of their package."""

import math
from typing import Any

import numpy as np

from .base import Filter, Told
from .gyro_integration import gyro_step
from .low_pass import LowPass
from .so3 import (
    IDENTITY,
    Quat,
    Vec3,
    about_z,
    before,
    conjugate,
    matrix,
    multiply,
    normalize,
    rotate,
    shortest_to_z,
    unit,
)

MAG_REJECTED, REST, RECOVERING = 16, 32, 128
DEGREE = math.pi / 180
#: What a sample may stand for (s) as evidence of rest or of an undisturbed field.
EVIDENCE = 1.0
GRAVITY = 9.80665


def weight(tau: float, dt: float) -> float:
    """That of a new sample in a first-order low-pass filter."""
    return -math.expm1(-dt / tau) if tau > 0 else 1.0


def has_heading(field: Vec3) -> bool:
    """Whether a field in the earth frame is not vertical."""
    return math.hypot(field[0], field[1]) >= 1e-6 * math.hypot(*field)


class BasicVQF(Filter):
    """Gyroscope, inclination and heading, each in a frame of its own."""

    OUTPUTS: tuple[str, ...] = ("quat6d", "quat9d", "delta")
    starts_itself = True
    follows_field = True

    def __init__(self, *, tau_acc: float = 3.0, tau_mag: float = 9.0, mag_delay: float = 0.0) -> None:
        self.tau_mag, self.mag_delay = tau_mag, mag_delay
        self.gyr_quat = self.acc_quat = IDENTITY
        self.force = LowPass(tau_acc)
        self.delta = 0.0
        self.least = 1.0  # weight of the next sample of the magnetometer: 1/n at the start, then 0

    @property
    def quat6d(self) -> Quat:
        return normalize(multiply(self.acc_quat, self.gyr_quat))

    @property
    def quat9d(self) -> Quat:
        return normalize(multiply(about_z(self.delta), self.quat6d))

    @property
    def q(self) -> Quat:
        return self.quat9d

    def start_from(self, q: Quat) -> None:
        """From an attitude, along whose vertical the specific force has been for long; δ has nothing to do with it."""
        self.acc_quat = q
        self.force.at(rotate(conjugate(q), (0.0, 0.0, GRAVITY)))
        self.least = 0.0

    def set_attitude(self, q: Quat) -> None:
        """Another attitude; the almost inertial frame and δ stay."""
        level = multiply(about_z(-self.delta), q)
        self.acc_quat = multiply(level, conjugate(self.gyr_quat))

    def realign(self, q: Quat) -> None:
        """What was measured before a loss says nothing of the inclination any more; δ stays."""
        self.set_attitude(q)
        self.force.at(rotate(conjugate(self.acc_quat), (0.0, 0.0, GRAVITY)))

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample."""
        self.turn(gyr, dt)
        if acc is not None:
            self.incline(acc, told.acc_interval)
        if mag is not None:
            field = rotate(before(self.quat6d, gyr, self.mag_delay), mag)
            if has_heading(field):
                self.head(field, weight(self.tau_mag, told.mag_interval), told.mag_interval)

    def turn(self, rate: Vec3, dt: float) -> None:
        """Strapdown integration into the almost inertial frame."""
        self.gyr_quat = gyro_step(self.gyr_quat, rate, dt, "exponential")

    def incline(self, acc: Vec3, interval: float) -> Vec3:
        """The whole correction by the filtered force; gives its direction in the earth frame before."""
        slow = self.force.step(rotate(self.gyr_quat, acc), interval)
        up = unit(rotate(self.acc_quat, as_vec3(slow)))
        self.acc_quat = normalize(multiply(shortest_to_z(up), self.acc_quat))
        return up

    def head(self, field: Vec3, k: float, interval: float) -> None:
        """A first-order filter of δ, at the start the mean."""
        off = math.remainder(math.atan2(field[0], field[1]) - self.delta, 2 * math.pi)
        k = max(k, self.least)
        # As the package does it: at some rates 1/n would end the start one sample later.
        self.least = self.least / (self.least + 1)
        if self.least * self.tau_mag < interval:
            self.least = 0.0
        self.delta = math.remainder(self.delta + k * off, 2 * math.pi)


class VQF(BasicVQF):
    """With bias estimation, rest detection and magnetic disturbance rejection."""

    OUTPUTS = (
        *BasicVQF.OUTPUTS,
        "bias_sigma",
        "rest",
        "mag_disturbed",
        "mag_ref_norm",
        "mag_ref_dip",
    )

    def __init__(self, *, tau_acc: float = 3.0, tau_mag: float = 9.0, mag_delay: float = 0.0, **given: Any) -> None:
        super().__init__(tau_acc=tau_acc, tau_mag=tau_mag, mag_delay=mag_delay)
        self.p = p = {
            "motion_bias_est_enabled": True,
            "rest_bias_est_enabled": True,
            "mag_dist_rejection_enabled": True,
            "bias_sigma_init": 0.5,
            "bias_forgetting_time": 100.0,
            "bias_clip": 2.0,
            "bias_sigma_motion": 0.1,
            "bias_vertical_forgetting_factor": 0.0001,
            "bias_sigma_rest": 0.03,
            "rest_min_t": 1.5,
            "rest_filter_tau": 0.5,
            "rest_th_gyr": 2.0,
            "rest_th_acc": 0.5,
            "mag_current_tau": 0.05,
            "mag_ref_tau": 20.0,
            "mag_norm_th": 0.1,
            "mag_dip_th": 10.0,
            "mag_new_time": 20.0,
            "mag_new_first_time": 5.0,
            "mag_new_min_gyr": 20.0,
            "mag_min_undisturbed_time": 0.5,
            "mag_max_rejection_time": 60.0,
            "mag_rejection_factor": 2.0,
        } | given
        self.flags = 0
        # Covariance of the bias in (°/s)².
        self.bias = np.zeros(3)
        self.covariance_of_bias = p["bias_sigma_init"] ** 2 * np.eye(3)
        self.rotation_filter, self.earth_bias_filter = LowPass(tau_acc), LowPass(tau_acc)
        # Rest.
        self.gyr_filter, self.acc_filter = LowPass(p["rest_filter_tau"]), LowPass(p["rest_filter_tau"])
        self.slow_gyr = np.zeros(3)
        self.still_time = 0.0
        self.rest = 0.0
        # The field: norm and dip.
        self.field_filter = LowPass(p["mag_current_tau"])
        self.reference = np.zeros(2)
        self.candidate: np.ndarray | None = None
        self.undisturbed_time = self.candidate_time = 0.0
        self.rejected_time = p["mag_max_rejection_time"]
        self.mag_disturbed = 1.0

    @property
    def bias_sigma(self) -> float:
        bound = np.abs(self.covariance_of_bias).sum(axis=1).max()
        return DEGREE * math.sqrt(min(bound, self.p["bias_sigma_init"] ** 2))

    @property
    def mag_ref_norm(self) -> float:
        return float(self.reference[0])

    @property
    def mag_ref_dip(self) -> float:
        return float(self.reference[1])

    def realign(self, q: Quat) -> None:
        """The attitude that the bias' estimate has seen is the new one."""
        super().realign(q)
        r = np.array(matrix(self.quat6d))
        self.rotation_filter.at(r.ravel())
        self.earth_bias_filter.at((r @ self.bias)[:2])

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample, in the package's order: gyroscope, accelerometer, magnetometer."""
        p = self.p
        self.flags = 0
        turning = False
        if p["rest_bias_est_enabled"] or p["mag_dist_rejection_enabled"]:
            self.slow_gyr = self.gyr_filter.step(gyr, dt)
            off = np.linalg.norm(np.subtract(gyr, self.slow_gyr))
            turning = off >= p["rest_th_gyr"] * DEGREE or np.abs(self.slow_gyr).max() > p["bias_clip"] * DEGREE
        self.turn(as_vec3(np.subtract(gyr, self.bias)), dt)

        if p["rest_bias_est_enabled"]:
            self.detect_rest(turning, acc, told.acc_interval, dt)
        if acc is not None:
            up = self.incline(acc, told.acc_interval)
            if (p["motion_bias_est_enabled"] or p["rest_bias_est_enabled"]) and not told.recovering:
                self.estimate_bias(up, told.acc_interval)
        field = None
        if mag is not None:
            rate = as_vec3(np.subtract(gyr, self.bias))
            field = rotate(before(self.quat6d, rate, self.mag_delay), mag)
        if field is not None and has_heading(field):
            k = weight(self.tau_mag, told.mag_interval)
            if p["mag_dist_rejection_enabled"]:
                k = self.judge_field(field, told.mag_interval, k)
            self.head(field, k, told.mag_interval)
        self.flags |= REST if self.rest else 0

    def detect_rest(self, turning: bool, acc: Vec3 | None, interval: float, dt: float) -> None:
        """Rest is that nothing has moved for some time; a missing force has not."""
        moving = False
        if acc is not None:
            slow = self.acc_filter.step(acc, interval)
            moving = bool(np.linalg.norm(np.subtract(acc, slow)) >= self.p["rest_th_acc"])
        if turning:
            self.still_time = 0.0
        self.still_time = 0.0 if moving else self.still_time + min(dt, EVIDENCE)
        self.rest = float(not moving and self.still_time >= self.p["rest_min_t"])

    def estimate_bias(self, up: Vec3, interval: float) -> None:
        """A Kalman filter of three constants, solved as a whole."""
        p = self.p
        r = np.array(matrix(self.quat6d))
        slow_r = self.rotation_filter.step(r.ravel(), interval).reshape(3, 3)
        slow_bias = self.earth_bias_filter.step((r @ self.bias)[:2], interval)
        if interval == 0:
            return
        initial = p["bias_sigma_init"] ** 2
        v = min(0.1**2 * interval / p["bias_forgetting_time"], initial)
        covariance = self.covariance_of_bias
        covariance += np.diag(np.where(np.diag(covariance) < initial, v, 0.0))

        def noise(sigma: float) -> float:
            return sigma**4 / v + sigma**2

        if self.rest:
            h, e, w = np.eye(3), self.slow_gyr - self.bias, [noise(p["bias_sigma_rest"])] * 3
        elif p["motion_bias_est_enabled"]:
            shown = np.array([slow_bias[0] - up[1] / interval, slow_bias[1] + up[0] / interval, 0.0])
            h, e = slow_r, shown - slow_r @ self.bias
            horizontal = noise(p["bias_sigma_motion"])
            w = [horizontal, horizontal, horizontal / max(p["bias_vertical_forgetting_factor"], 1e-10)]
        else:
            return
        clip = p["bias_clip"] * DEGREE
        gain = covariance @ h.T @ np.linalg.inv(np.diag(w) + h @ covariance @ h.T)
        self.bias = np.clip(self.bias + gain @ np.clip(e, -clip, clip), -clip, clip)
        self.covariance_of_bias = covariance - gain @ h @ covariance

    def is_like(self, known: np.ndarray, seen: np.ndarray) -> bool:
        norm, dip = np.abs(seen - known)
        return bool(norm < self.p["mag_norm_th"] * known[0] and dip < self.p["mag_dip_th"] * DEGREE)

    def judge_field(self, field: Vec3, interval: float, k: float) -> float:
        """Whether the field is disturbed, and what its heading weighs then."""
        p = self.p
        norm = math.hypot(*field)
        seen = self.field_filter.step([norm, -math.asin(field[2] / norm)], interval)
        evidence = min(interval, EVIDENCE)
        learning = weight(p["mag_ref_tau"], interval)

        if self.is_like(self.reference, seen):
            self.undisturbed_time += evidence
            if self.undisturbed_time >= p["mag_min_undisturbed_time"]:
                self.mag_disturbed = 0.0
                self.reference = self.reference + learning * (seen - self.reference)
        else:
            self.undisturbed_time = 0.0
            self.mag_disturbed = 1.0

        if self.candidate is not None and self.is_like(self.candidate, seen):
            if np.linalg.norm(self.slow_gyr) >= p["mag_new_min_gyr"] * DEGREE:
                self.candidate_time += evidence
            self.candidate = self.candidate + learning * (seen - self.candidate)
            first = self.reference[0] == 0 and self.candidate_time >= p["mag_new_first_time"]
            if self.mag_disturbed and (first or self.candidate_time >= p["mag_new_time"]):
                self.reference = self.candidate
                self.mag_disturbed = 0.0
                self.undisturbed_time = p["mag_min_undisturbed_time"]
        else:
            self.candidate, self.candidate_time = seen, 0.0

        if not self.mag_disturbed:
            self.rejected_time = max(self.rejected_time - p["mag_rejection_factor"] * interval, 0.0)
            return k
        known = self.reference[0] > 0
        if self.rejected_time <= p["mag_max_rejection_time"]:
            self.rejected_time += interval
            self.flags |= MAG_REJECTED if known else 0
            return 0.0
        self.flags |= RECOVERING if known else 0
        return k / p["mag_rejection_factor"]


def as_vec3(v: np.ndarray) -> Vec3:
    """An array (3,) as a tuple."""
    x, y, z = v.tolist()
    return (x, y, z)
