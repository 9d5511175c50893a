# Made by tools/stubs.py from the registry; do not edit.
from typing import Any, Literal, Self

from numpy.typing import DTypeLike

from ahrs_rs._filter import Filter

FILTERS: dict[str, type[Filter]]
__all__ = [
    "EKF",
    "FILTERS",
    "MEKF",
    "VQF",
    "BasicVQF",
    "Complementary",
    "DcmImu",
    "Ecompass",
    "Fusion",
    "GyroIntegration",
    "LinearKalman",
    "Madgwick",
    "Mahony",
    "OfflineVQF",
    "SelfCalKF",
    "SelfCalSmoother",
    "Tilt",
    "Trigonometric",
]

class GyroIntegration(Filter):
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Tilt(Filter):
    def __new__(
        cls,
        *,
        rate: float | None = None,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Ecompass(Filter):
    def __new__(
        cls,
        *,
        rate: float | None = None,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Trigonometric(Filter):
    @property
    def source(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        source: Literal["acc", "gyr"] = "acc",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Complementary(Filter):
    @property
    def tau(self) -> float: ...
    @property
    def acc_threshold(self) -> float: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        tau: float = 1.6616666666666666,
        acc_threshold: float = 0.0,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...
    @classmethod
    def from_kalman_gain(cls, /, gain: float, *, rate: float, **keywords: Any) -> Self: ...

class LinearKalman(Filter):
    @property
    def angle_process(self) -> float: ...
    @property
    def bias_process(self) -> float: ...
    @property
    def angle_variance(self) -> float: ...
    @property
    def initial_angle(self) -> float: ...
    @property
    def initial_bias(self) -> float: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        angle_process: float = 0.0007195063455362055,
        bias_process: float = 2.607525113374225e-07,
        angle_variance: float = 0.8072361624347777,
        initial_angle: float = 0.0,
        initial_bias: float = 0.01,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Mahony(Filter):
    @property
    def kp(self) -> float: ...
    @property
    def ki(self) -> float: ...
    @property
    def acc_threshold(self) -> float: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        kp: float = 1.0,
        ki: float = 0.3,
        acc_threshold: float = 0.0,
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Madgwick(Filter):
    @property
    def beta(self) -> float: ...
    @property
    def zeta(self) -> float: ...
    @property
    def acc_threshold(self) -> float: ...
    @property
    def gradient(self) -> str: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        beta: float = 0.041,
        zeta: float = 0.0,
        acc_threshold: float = 0.0,
        gradient: Literal["tangent", "paper"] = "tangent",
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class EKF(Filter):
    @property
    def gyr_variance_x(self) -> float: ...
    @property
    def gyr_variance_y(self) -> float: ...
    @property
    def gyr_variance_z(self) -> float: ...
    @property
    def acc_variance_x(self) -> float: ...
    @property
    def acc_variance_y(self) -> float: ...
    @property
    def acc_variance_z(self) -> float: ...
    @property
    def mag_variance_x(self) -> float: ...
    @property
    def mag_variance_y(self) -> float: ...
    @property
    def mag_variance_z(self) -> float: ...
    @property
    def quat_process(self) -> float: ...
    @property
    def rate_process(self) -> float: ...
    @property
    def reference_time(self) -> float: ...
    @property
    def initial_inclination(self) -> float: ...
    @property
    def initial_heading(self) -> float: ...
    @property
    def initial_rate(self) -> float: ...
    @property
    def gravity(self) -> float: ...
    @property
    def gyroscope(self) -> str: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        gyr_variance_x: float = 2.9e-05,
        gyr_variance_y: float = 2.3e-05,
        gyr_variance_z: float = 3.2e-05,
        acc_variance_x: float = 3.1e-05,
        acc_variance_y: float = 4.5e-05,
        acc_variance_z: float = 5.5e-05,
        mag_variance_x: float = 0.002,
        mag_variance_y: float = 0.0021,
        mag_variance_z: float = 0.002,
        quat_process: float = 5e-08,
        rate_process: float = 0.5,
        reference_time: float = 0.0,
        initial_inclination: float = 0.0,
        initial_heading: float = 0.0,
        initial_rate: float = 1.0,
        gravity: float = 9.80665,
        gyroscope: Literal["measurement", "input"] = "measurement",
        integration: Literal["exponential", "first-order"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class DcmImu(Filter):
    @property
    def dcm_process(self) -> float: ...
    @property
    def bias_process(self) -> float: ...
    @property
    def acc_std(self) -> float: ...
    @property
    def acc_motion(self) -> float: ...
    @property
    def initial_dcm(self) -> float: ...
    @property
    def initial_bias(self) -> float: ...
    @property
    def gravity(self) -> float: ...
    @property
    def prediction(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        dcm_process: float = 0.1,
        bias_process: float = 0.0001,
        acc_std: float = 0.5,
        acc_motion: float = 10.0,
        initial_dcm: float = 1.0,
        initial_bias: float = 0.1,
        gravity: float = 9.80665,
        prediction: Literal["exponential", "euler"] = "exponential",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class MEKF(Filter):
    @property
    def gyr_noise(self) -> float: ...
    @property
    def bias_noise(self) -> float: ...
    @property
    def acc_noise(self) -> float: ...
    @property
    def heading_noise(self) -> float: ...
    @property
    def acc_adaptation(self) -> float: ...
    @property
    def acc_window(self) -> float: ...
    @property
    def mag_tolerance(self) -> float: ...
    @property
    def mag_window(self) -> float: ...
    @property
    def mag_gate(self) -> float: ...
    @property
    def mag_recovery(self) -> float: ...
    @property
    def rest_gyr(self) -> float: ...
    @property
    def rest_acc(self) -> float: ...
    @property
    def rest_time(self) -> float: ...
    @property
    def rest_noise(self) -> float: ...
    @property
    def initial_inclination(self) -> float: ...
    @property
    def initial_heading(self) -> float: ...
    @property
    def initial_bias(self) -> float: ...
    @property
    def gravity(self) -> float: ...
    @property
    def magnetometer(self) -> str: ...
    @property
    def mag_delay(self) -> float: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        gyr_noise: float = 0.002,
        bias_noise: float = 0.0001,
        acc_noise: float = 0.3,
        heading_noise: float = 0.1,
        acc_adaptation: float = 0.3,
        acc_window: float = 10.0,
        mag_tolerance: float = 0.12,
        mag_window: float = 3.0,
        mag_gate: float = 3.0,
        mag_recovery: float = 10.0,
        rest_gyr: float = 0.03490658503988659,
        rest_acc: float = 0.5,
        rest_time: float = 1.5,
        rest_noise: float = 0.01,
        initial_inclination: float = 0.1,
        initial_heading: float = 0.5,
        initial_bias: float = 0.05,
        gravity: float = 9.80665,
        magnetometer: Literal["heading", "vector"] = "heading",
        mag_delay: float = 0.0,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class VQF(Filter):
    @property
    def tau_acc(self) -> float: ...
    @property
    def tau_mag(self) -> float: ...
    @property
    def motion_bias_est_enabled(self) -> bool: ...
    @property
    def rest_bias_est_enabled(self) -> bool: ...
    @property
    def mag_dist_rejection_enabled(self) -> bool: ...
    @property
    def bias_sigma_init(self) -> float: ...
    @property
    def bias_forgetting_time(self) -> float: ...
    @property
    def bias_clip(self) -> float: ...
    @property
    def bias_sigma_motion(self) -> float: ...
    @property
    def bias_vertical_forgetting_factor(self) -> float: ...
    @property
    def bias_sigma_rest(self) -> float: ...
    @property
    def rest_min_t(self) -> float: ...
    @property
    def rest_filter_tau(self) -> float: ...
    @property
    def rest_th_gyr(self) -> float: ...
    @property
    def rest_th_acc(self) -> float: ...
    @property
    def mag_current_tau(self) -> float: ...
    @property
    def mag_ref_tau(self) -> float: ...
    @property
    def mag_norm_th(self) -> float: ...
    @property
    def mag_dip_th(self) -> float: ...
    @property
    def mag_new_time(self) -> float: ...
    @property
    def mag_new_first_time(self) -> float: ...
    @property
    def mag_new_min_gyr(self) -> float: ...
    @property
    def mag_min_undisturbed_time(self) -> float: ...
    @property
    def mag_max_rejection_time(self) -> float: ...
    @property
    def mag_rejection_factor(self) -> float: ...
    @property
    def mag_delay(self) -> float: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        tau_acc: float = 3.0,
        tau_mag: float = 9.0,
        motion_bias_est_enabled: bool = True,
        rest_bias_est_enabled: bool = True,
        mag_dist_rejection_enabled: bool = True,
        bias_sigma_init: float = 0.5,
        bias_forgetting_time: float = 100.0,
        bias_clip: float = 2.0,
        bias_sigma_motion: float = 0.1,
        bias_vertical_forgetting_factor: float = 0.0001,
        bias_sigma_rest: float = 0.03,
        rest_min_t: float = 1.5,
        rest_filter_tau: float = 0.5,
        rest_th_gyr: float = 2.0,
        rest_th_acc: float = 0.5,
        mag_current_tau: float = 0.05,
        mag_ref_tau: float = 20.0,
        mag_norm_th: float = 0.1,
        mag_dip_th: float = 10.0,
        mag_new_time: float = 20.0,
        mag_new_first_time: float = 5.0,
        mag_new_min_gyr: float = 20.0,
        mag_min_undisturbed_time: float = 0.5,
        mag_max_rejection_time: float = 60.0,
        mag_rejection_factor: float = 2.0,
        mag_delay: float = 0.0,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class SelfCalKF(Filter):
    @property
    def gyr_noise(self) -> float: ...
    @property
    def rate_noise(self) -> float: ...
    @property
    def gyr_range(self) -> float: ...
    @property
    def bias_noise(self) -> float: ...
    @property
    def velocity(self) -> float: ...
    @property
    def velocity_time(self) -> float: ...
    @property
    def velocity_noise(self) -> float: ...
    @property
    def mag_noise(self) -> float: ...
    @property
    def mag_rate_noise(self) -> float: ...
    @property
    def mag_tolerance(self) -> float: ...
    @property
    def mag_tail(self) -> float: ...
    @property
    def mag_new_time(self) -> float: ...
    @property
    def disturbance(self) -> float: ...
    @property
    def disturbance_time(self) -> float: ...
    @property
    def hard_iron_noise(self) -> float: ...
    @property
    def largest_hard_iron(self) -> float: ...
    @property
    def rest_gyr(self) -> float: ...
    @property
    def rest_acc(self) -> float: ...
    @property
    def rest_time(self) -> float: ...
    @property
    def rest_noise(self) -> float: ...
    @property
    def rest_velocity(self) -> float: ...
    @property
    def initial_inclination(self) -> float: ...
    @property
    def initial_heading(self) -> float: ...
    @property
    def initial_bias(self) -> float: ...
    @property
    def initial_matrix(self) -> float: ...
    @property
    def initial_velocity(self) -> float: ...
    @property
    def initial_acc_bias(self) -> float: ...
    @property
    def initial_gravity(self) -> float: ...
    @property
    def initial_hard_iron(self) -> float: ...
    @property
    def initial_field(self) -> float: ...
    @property
    def initial_delay(self) -> float: ...
    @property
    def latency(self) -> float: ...
    @property
    def gravity(self) -> float: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        gyr_noise: float = 0.0003,
        rate_noise: float = 0.0007,
        gyr_range: float = 0.0,
        bias_noise: float = 5e-05,
        velocity: float = 0.3,
        velocity_time: float = 0.5,
        velocity_noise: float = 0.01,
        mag_noise: float = 0.04,
        mag_rate_noise: float = 0.0007,
        mag_tolerance: float = 0.09,
        mag_tail: float = 1.7,
        mag_new_time: float = 20.0,
        disturbance: float = 0.018,
        disturbance_time: float = 8.0,
        hard_iron_noise: float = 0.001,
        largest_hard_iron: float = 0.1,
        rest_gyr: float = 0.03490658503988659,
        rest_acc: float = 0.5,
        rest_time: float = 1.5,
        rest_noise: float = 0.0005,
        rest_velocity: float = 0.02,
        initial_inclination: float = 0.5,
        initial_heading: float = 1.0,
        initial_bias: float = 0.0087,
        initial_matrix: float = 0.003,
        initial_velocity: float = 1.0,
        initial_acc_bias: float = 0.04,
        initial_gravity: float = 0.05,
        initial_hard_iron: float = 0.001,
        initial_field: float = 0.05,
        initial_delay: float = 0.015,
        latency: float = 0.0,
        gravity: float = 9.80665,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        dtype: DTypeLike = ...,
    ) -> Self: ...

class BasicVQF(Filter):
    @property
    def tau_acc(self) -> float: ...
    @property
    def tau_mag(self) -> float: ...
    @property
    def mag_delay(self) -> float: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        tau_acc: float = 3.0,
        tau_mag: float = 9.0,
        mag_delay: float = 0.0,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class Fusion(Filter):
    @property
    def gain(self) -> float: ...
    @property
    def gyroscope_range(self) -> float: ...
    @property
    def acceleration_rejection(self) -> float: ...
    @property
    def magnetic_rejection(self) -> float: ...
    @property
    def rejection_timeout(self) -> float: ...
    @property
    def bias(self) -> bool: ...
    @property
    def stationary_threshold(self) -> float: ...
    @property
    def stationary_period(self) -> float: ...
    @property
    def integration(self) -> str: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        gain: float = 0.5,
        gyroscope_range: float = 0.0,
        acceleration_rejection: float = 0.0,
        magnetic_rejection: float = 0.0,
        rejection_timeout: float = 0.0,
        bias: bool = False,
        stationary_threshold: float = 3.0,
        stationary_period: float = 3.0,
        integration: Literal["first-order", "exponential"] = "first-order",
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class OfflineVQF(Filter):
    @property
    def tau_acc(self) -> float: ...
    @property
    def tau_mag(self) -> float: ...
    @property
    def motion_bias_est_enabled(self) -> bool: ...
    @property
    def rest_bias_est_enabled(self) -> bool: ...
    @property
    def mag_dist_rejection_enabled(self) -> bool: ...
    @property
    def bias_sigma_init(self) -> float: ...
    @property
    def bias_forgetting_time(self) -> float: ...
    @property
    def bias_clip(self) -> float: ...
    @property
    def bias_sigma_motion(self) -> float: ...
    @property
    def bias_vertical_forgetting_factor(self) -> float: ...
    @property
    def bias_sigma_rest(self) -> float: ...
    @property
    def rest_min_t(self) -> float: ...
    @property
    def rest_filter_tau(self) -> float: ...
    @property
    def rest_th_gyr(self) -> float: ...
    @property
    def rest_th_acc(self) -> float: ...
    @property
    def mag_current_tau(self) -> float: ...
    @property
    def mag_ref_tau(self) -> float: ...
    @property
    def mag_norm_th(self) -> float: ...
    @property
    def mag_dip_th(self) -> float: ...
    @property
    def mag_new_time(self) -> float: ...
    @property
    def mag_new_first_time(self) -> float: ...
    @property
    def mag_new_min_gyr(self) -> float: ...
    @property
    def mag_min_undisturbed_time(self) -> float: ...
    @property
    def mag_max_rejection_time(self) -> float: ...
    @property
    def mag_rejection_factor(self) -> float: ...
    @property
    def mag_delay(self) -> float: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        tau_acc: float = 3.0,
        tau_mag: float = 9.0,
        motion_bias_est_enabled: bool = True,
        rest_bias_est_enabled: bool = True,
        mag_dist_rejection_enabled: bool = True,
        bias_sigma_init: float = 0.5,
        bias_forgetting_time: float = 100.0,
        bias_clip: float = 2.0,
        bias_sigma_motion: float = 0.1,
        bias_vertical_forgetting_factor: float = 0.0001,
        bias_sigma_rest: float = 0.03,
        rest_min_t: float = 1.5,
        rest_filter_tau: float = 0.5,
        rest_th_gyr: float = 2.0,
        rest_th_acc: float = 0.5,
        mag_current_tau: float = 0.05,
        mag_ref_tau: float = 20.0,
        mag_norm_th: float = 0.1,
        mag_dip_th: float = 10.0,
        mag_new_time: float = 20.0,
        mag_new_first_time: float = 5.0,
        mag_new_min_gyr: float = 20.0,
        mag_min_undisturbed_time: float = 0.5,
        mag_max_rejection_time: float = 60.0,
        mag_rejection_factor: float = 2.0,
        mag_delay: float = 0.0,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        gyr_range: float = 0.0,
        dtype: DTypeLike = ...,
    ) -> Self: ...

class SelfCalSmoother(Filter):
    @property
    def gyr_noise(self) -> float: ...
    @property
    def rate_noise(self) -> float: ...
    @property
    def bias_noise(self) -> float: ...
    @property
    def velocity(self) -> float: ...
    @property
    def velocity_time(self) -> float: ...
    @property
    def velocity_noise(self) -> float: ...
    @property
    def mag_noise(self) -> float: ...
    @property
    def mag_rate_noise(self) -> float: ...
    @property
    def mag_tolerance(self) -> float: ...
    @property
    def mag_tail(self) -> float: ...
    @property
    def disturbance(self) -> float: ...
    @property
    def disturbance_time(self) -> float: ...
    @property
    def hard_iron_noise(self) -> float: ...
    @property
    def rest_gyr(self) -> float: ...
    @property
    def rest_acc(self) -> float: ...
    @property
    def rest_time(self) -> float: ...
    @property
    def rest_noise(self) -> float: ...
    @property
    def rest_velocity(self) -> float: ...
    @property
    def initial_inclination(self) -> float: ...
    @property
    def initial_heading(self) -> float: ...
    @property
    def initial_bias(self) -> float: ...
    @property
    def initial_matrix(self) -> float: ...
    @property
    def initial_velocity(self) -> float: ...
    @property
    def initial_acc_bias(self) -> float: ...
    @property
    def initial_gravity(self) -> float: ...
    @property
    def initial_hard_iron(self) -> float: ...
    @property
    def initial_field(self) -> float: ...
    @property
    def initial_delay(self) -> float: ...
    @property
    def latency(self) -> float: ...
    @property
    def gravity(self) -> float: ...
    @property
    def gyr_range(self) -> float: ...
    def __new__(
        cls,
        *,
        rate: float | None = None,
        gyr_noise: float = 0.0003,
        rate_noise: float = 0.0014,
        bias_noise: float = 0.0002,
        velocity: float = 0.6,
        velocity_time: float = 0.5,
        velocity_noise: float = 0.03,
        mag_noise: float = 0.035,
        mag_rate_noise: float = 0.0007,
        mag_tolerance: float = 0.09,
        mag_tail: float = 2.5,
        disturbance: float = 0.018,
        disturbance_time: float = 12.0,
        hard_iron_noise: float = 0.0,
        rest_gyr: float = 0.03490658503988659,
        rest_acc: float = 0.5,
        rest_time: float = 1.5,
        rest_noise: float = 0.002,
        rest_velocity: float = 0.02,
        initial_inclination: float = 0.5,
        initial_heading: float = 1.0,
        initial_bias: float = 0.0087,
        initial_matrix: float = 0.003,
        initial_velocity: float = 3.0,
        initial_acc_bias: float = 0.04,
        initial_gravity: float = 0.015,
        initial_hard_iron: float = 0.0,
        initial_field: float = 0.1,
        initial_delay: float = 0.01,
        latency: float = 0.0,
        gravity: float = 9.80665,
        gyr_range: float = 0.0,
        frame: Literal["ENU", "NED", "NWU"] = "ENU",
        declination: float = 0.0,
        gyr_hold: Literal["zero-order", "linear"] = "zero-order",
        repeated: Literal["new", "missing"] = "new",
        dtype: DTypeLike = ...,
    ) -> Self: ...
