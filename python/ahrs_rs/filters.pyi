# Made by tools/stubs.py from the registry; do not edit.
from typing import Any, Literal, Self

from numpy.typing import DTypeLike

from ahrs_rs._classes import Registry
from ahrs_rs._filter import Filter

FILTERS: Registry
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
    """The angular rate integrated from the initial alignment; accelerometer and magnetometer are
    used for that alignment only.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    integration : {"exponential", "first-order"}, default "exponential"
        Integration of the angular rate over a step: by the exponential map, exact for a rate
        that is constant over the step, or by the first-order step of the papers followed by
        normalisation.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only.

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    References
    ----------
    q⁺ = q ⊗ exp(½ω dt), the exact solution of q̇ = ½ q ⊗ ω for a rate that is constant over the
    step.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.GyroIntegration(rate=100.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """The attitude turned by the shortest way so that the specific force of this sample points up.

    The gyroscope is used only where the accelerometer has no sample, so the heading is carried
    along, not measured.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only.

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    References
    ----------
    the shortest rotation between two directions.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Tilt(rate=100.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """Inclination from the specific force and heading from the horizontal magnetic field of this
    sample alone.

    Without a magnetometer the last heading is kept; the gyroscope is used only where the
    accelerometer has no sample.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    References
    ----------
    the two directions of Wahba's problem solved in turn, the vertical exactly (TRIAD, Black
    1964).

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Ecompass(rate=100.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """Roll and pitch without fusion: from the specific force of this sample (the papers' "matrix"
    method), or from the Euler rates of the gyroscope.

    The heading of the start is held, or integrated with the rates.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    source : {"acc", "gyr"}, default "acc"
        Where roll and pitch come from: the accelerometer (eqs 3-4), or the gyroscope by Euler
        rates (eq. 5), which the accelerometer then only starts.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only.

    Mounting: does another mounting of the sensor give the same attitude? No: Euler angles
    depend on the choice of the sensor's axes.

    References
    ----------
    Çoçoli & Badia 2023, eqs 3-5, with signs for a specific force of +g at rest.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Trigonometric(rate=100.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """Roll and pitch are integrated from the gyroscope and drawn towards those of the specific
    force with a time constant: high-pass and low-pass of the same corner.

    The heading is integrated.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    tau : float, default 1.6616666666666666, in [1e-09, 1e+06] s
        Time constant τ of the correction: the gyroscope's weight in a step is α = τ/(τ + dt).
    acc_threshold : float, default 0.0, in [0, 1e+06] m/s²
        Deviation of the specific force's norm from gravity above which the accelerometer's
        weight falls, linearly to none at twice as much (Valenti et al. 2015; the adaptive gain
        that Parikh et al. 2021 propose); 0: never.
    integration : {"exponential", "first-order"}, default "exponential"
        Integration of the angular rate over a step: by the exponential map, exact for a rate
        that is constant over the step, or by the first-order step of the papers followed by
        normalisation.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only.

    Mounting: does another mounting of the sensor give the same attitude? No: Euler angles
    depend on the choice of the sensor's axes.

    Presets (``Complementary.preset(name)``): parikh2021 (tau=1.6616666666666666).

    References
    ----------
    Parikh et al. 2021, section II.A; their α = 0.997 at 200 Hz is τ = 1.6617 s.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Complementary(rate=100.0, tau=1.6616666666666666).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """Roll and pitch, each with the bias of its gyroscope axis, are estimated by a linear Kalman
    filter of its own from the angles of the specific force.

    The heading is integrated.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    angle_process : float, default 0.0007195063455362055, in [0, 1e+06] rad²/s
        Process noise of the angle: the first entry of Q is this times dt. Parikh: 0.01181 deg²
        in 5 ms.
    bias_process : float, default 2.607525113374225e-07, in [0, 1e+06] rad²/s³
        Process noise of the bias: the second entry of Q is this times dt. Parikh: 4.28e-6 deg²
        in 5 ms.
    angle_variance : float, default 0.8072361624347777, in [1e-12, 1e+06] rad²
        Variance R of the specific force's angle. Parikh: 2650 deg².
    initial_angle : float, default 0.0, in [0, 1000] rad
        Standard deviation of roll and pitch at the start (0: that of one measurement).
    initial_bias : float, default 0.01, in [1e-09, 1000] rad/s
        Standard deviation of the biases at the start.
    integration : {"exponential", "first-order"}, default "exponential"
        Integration of the angular rate over a step: by the exponential map, exact for a rate
        that is constant over the step, or by the first-order step of the papers followed by
        normalisation.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only.

    Mounting: does another mounting of the sensor give the same attitude? No: Euler angles
    depend on the choice of the sensor's axes.

    Presets (``LinearKalman.preset(name)``): parikh2021 (angle_process=0.0007195063455362055,
    bias_process=2.607525113374225e-07, angle_variance=0.8072361624347777).

    Output ``covariance``: covariance of the attitude error in the sensor frame, rad²; π²/3
    about the vertical; shape (..., T, 3, 3).

    Output ``innovation``: measured less predicted roll and pitch, rad; NaN where there is no
    measurement; shape (..., T, 2).

    Output ``nis``: squares of the innovations over their variances; shape (..., T, 2).

    References
    ----------
    Parikh et al. 2021, eqs 1-2; Çoçoli & Badia 2023, Table I.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.LinearKalman(rate=100.0, angle_process=0.0007195063455362055).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """The angular rate is corrected in proportion to the error between measured and predicted
    directions of gravity and magnetic field, and by its integral, which is the gyroscope's
    bias.

    In a gap of more than 1/(2 kp) the feedback counts for that long only: two directions pull
    with up to 2 kp.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    kp : float, default 1.0, in [0, 1e+06] rad/s
        Proportional gain kp of the direction error: the inclination's error decays at kp.
    ki : float, default 0.3, in [0, 1e+06] rad/s²
        Integral gain ki of the direction error, which estimates the gyroscope's bias.
    acc_threshold : float, default 0.0, in [0, 1e+06] m/s²
        Deviation of the specific force's norm from gravity above which the accelerometer's
        share of the error falls, linearly to none at twice as much (Valenti et al. 2015; the
        adaptive gain that Parikh et al. 2021 propose); 0: never.
    integration : {"exponential", "first-order"}, default "exponential"
        Integration of the angular rate over a step: by the exponential map, exact for a rate
        that is constant over the step, or by the first-order step of the papers followed by
        normalisation.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Presets (``Mahony.preset(name)``): cirillo2014 (kp=2.0, ki=0.6); parikh2021 (kp=0.89,
    ki=0.01); ludwig2018 (kp=0.0039216, ki=0.001); cocoli2023 (kp=10.0, ki=0.0); hyyti2015
    (kp=0.5, ki=0.0).

    Output ``innovation``: the error a × v̂ + m × m̂ between measured and predicted directions,
    sensor frame, rad for small errors; shape (..., T, 3).

    References
    ----------
    Mahony et al., IEEE TAC 53(5), 2008 (explicit complementary filter); Ludwig & Burnham 2018,
    Alg. 1; Çoçoli & Badia 2023, Alg. 1.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Mahony(rate=100.0, kp=1.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """The attitude follows the gyroscope and descends at a constant rate along the gradient of the
    squared error between measured and predicted directions of gravity and magnetic field.

    A step that would turn by more than 0.1 rad is a gap in the data, and turns no further than
    the error.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    beta : float, default 0.041, in [0, 1e+06] rad/s
        Rate β of the descent: the attitude's correction turns at 2β.
    zeta : float, default 0.0, in [0, 1e+06] rad/s²
        Gain ζ with which the direction of the descent changes the estimate of the gyroscope's
        bias (0: no estimate).
    acc_threshold : float, default 0.0, in [0, 1e+06] m/s²
        Deviation of the specific force's norm from gravity above which the accelerometer's part
        of the gradient falls, linearly to none at twice as much (Valenti et al. 2015; the
        adaptive gain that Parikh et al. 2021 propose); 0: never.
    gradient : {"tangent", "paper"}, default "tangent"
        The gradient that is normalised: its part along rotations, which does not depend on the
        choice of axes, or the published one, computed with north on x, whose part along q does.
    integration : {"exponential", "first-order"}, default "exponential"
        Integration of the angular rate over a step: by the exponential map, exact for a rate
        that is constant over the step, or by the first-order step of the papers followed by
        normalisation.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Presets (``Madgwick.preset(name)``): cirillo2014 (beta=0.041); parikh2021 (beta=0.00921);
    ludwig2018 (beta=0.011765); cocoli2023 (beta=0.05); hyyti2015 (beta=0.1).

    Output ``innovation``: the rotation rate 2 q* ⊗ ∇f/‖∇f‖ that the normalised gradient stands
    for, sensor frame, rad/s per unit β; shape (..., T, 3).

    References
    ----------
    Madgwick et al., ICORR 2011; Ludwig & Burnham 2018, Alg. 2; Çoçoli & Badia 2023, Alg. 2 with
    (17) divided by the norm of the gradient.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Madgwick(rate=100.0, beta=0.041).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """An extended Kalman filter whose state is the quaternion and the angular rate, held by
    process noise alone; gyroscope, specific force over g and field over its reference's norm
    are measurements.

    It estimates no bias. The field's inclination and norm come from the first magnetometer
    samples.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    gyr_variance_x : float, default 2.9e-05, in [1e-12, 1e+06] rad²/s²
        Variance of the gyroscope's x axis (V of the paper).
    gyr_variance_y : float, default 2.3e-05, in [1e-12, 1e+06] rad²/s²
        Variance of the gyroscope's y axis.
    gyr_variance_z : float, default 3.2e-05, in [1e-12, 1e+06] rad²/s²
        Variance of the gyroscope's z axis.
    acc_variance_x : float, default 3.1e-05, in [1e-12, 1e+06]
        Variance of the accelerometer's x axis over g².
    acc_variance_y : float, default 4.5e-05, in [1e-12, 1e+06]
        Variance of the accelerometer's y axis over g².
    acc_variance_z : float, default 5.5e-05, in [1e-12, 1e+06]
        Variance of the accelerometer's z axis over g².
    mag_variance_x : float, default 0.002, in [1e-12, 1e+06]
        Variance of the magnetometer's x axis over the square of the reference field's norm.
    mag_variance_y : float, default 0.0021, in [1e-12, 1e+06]
        Variance of the magnetometer's y axis over the square of the reference field's norm.
    mag_variance_z : float, default 0.002, in [1e-12, 1e+06]
        Variance of the magnetometer's z axis over the square of the reference field's norm.
    quat_process : float, default 5e-08, in [0, 1e+06] 1/s
        Process noise of the quaternion's components: W is this times dt. Cirillo: 1e-10 in 2
        ms.
    rate_process : float, default 0.5, in [0, 1e+06] rad²/s³
        Process noise of the angular rate: W is this times dt. Cirillo: 1e-3 in 2 ms.
    reference_time : float, default 0.0, in [0, 1e+06] s
        How long the reference field is averaged over magnetometer samples (0: the first one).
    initial_inclination : float, default 0.0, in [0, 1000] rad
        Standard deviation of the inclination at the start (0: that of one accelerometer
        sample).
    initial_heading : float, default 0.0, in [0, 1000] rad
        Standard deviation of the heading at the start (0: that of one magnetometer sample at a
        dip of 60°).
    initial_rate : float, default 1.0, in [1e-06, 1000] rad/s
        Standard deviation of the angular rate at the start.
    gravity : float, default 9.80665, in [0.001, 1000] m/s²
        Gravity g, by which the specific force is divided.
    gyroscope : {"measurement", "input"}, default "measurement"
        What the gyroscope is: a measurement of the rate in the state (Cirillo), or the input
        that turns the attitude, with the gyroscope's variances as the rate's covariance in
        every step.
    integration : {"exponential", "first-order"}, default "exponential"
        Integration of the angular rate over a step: by the exponential map, exact for a rate
        that is constant over the step, or by the first-order step of the papers followed by
        normalisation.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: does another mounting of the sensor give the same attitude? No: the variances of
    the axes are not equal.

    Presets (``EKF.preset(name)``): cirillo2014 (gyr_variance_x=2.9e-05, gyr_variance_y=2.3e-05,
    gyr_variance_z=3.2e-05, acc_variance_x=3.1e-05, acc_variance_y=4.5e-05,
    acc_variance_z=5.5e-05, mag_variance_x=0.002, mag_variance_y=0.0021, mag_variance_z=0.002,
    quat_process=5e-08, rate_process=0.5).

    Output ``covariance``: covariance of the attitude error in the sensor frame, 4 Ξᵀ P Ξ, rad²;
    π²/3 about the vertical until a magnetometer sample has come; shape (..., T, 3, 3).

    Output ``innovation``: measured less predicted angular rate (rad/s), specific force (g) and
    field (reference norms); NaN where there is no measurement; shape (..., T, 9).

    Output ``nis``: normalised innovation squared of gyroscope, accelerometer and magnetometer,
    3 degrees of freedom each; shape (..., T, 3).

    References
    ----------
    Cirillo et al. 2014, eqs 7-26, in east-north-up, from the library's alignment; with
    gyroscope="input" the form of Ludwig & Burnham 2018, eqs 17-22.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.EKF(rate=100.0, gyr_variance_x=2.9e-05).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """An extended Kalman filter whose state is the vertical seen from the sensor (the bottom row
    C3 of the rotation matrix) and the gyroscope's bias, with an accelerometer covariance that
    grows with the external acceleration.

    The heading is integrated outside of it, with the estimated bias.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    dcm_process : float, default 0.1, in [0, 1e+06] 1/s
        Process noise σ_C of C3: its variance grows by (σ_C dt)² in a step, eq. 10.
    bias_process : float, default 0.0001, in [0, 1e+06] rad/s²
        Process noise σ_b of the bias: its variance grows by (σ_b dt)² in a step, eq. 10.
    acc_std : float, default 0.5, in [1e-06, 1e+06] m/s²
        Standard deviation σ_f of the accelerometer at rest, eq. 11.
    acc_motion : float, default 10.0, in [0, 1e+06] (m/s²)^½
        How much the external acceleration a counts: σ_a² |a| is added to the variance, eq. 11.
    initial_dcm : float, default 1.0, in [1e-06, 1000]
        Standard deviation of C3 at the start.
    initial_bias : float, default 0.1, in [1e-09, 1000] rad/s
        Standard deviation of the bias at the start.
    gravity : float, default 9.80665, in [0.001, 1000] m/s²
        Gravity g where the sensor is.
    prediction : {"exponential", "euler"}, default "exponential"
        How C3 is predicted: by the exact solution over the step, or by the first-order step as
        published, which fails at high angular rates (39° on a recording of up to 1454 °/s).
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D); a magnetometer gives the initial heading only.

    Mounting: does another mounting of the sensor give the same attitude? No: the heading is
    that of the sensor's x axis.

    Presets (``DcmImu.preset(name)``): hyyti2015 (dcm_process=0.1, bias_process=0.0001,
    acc_std=0.5, acc_motion=10.0, initial_dcm=1.0, initial_bias=0.1, gravity=9.8189).

    Output ``covariance``: covariance of the attitude error in the sensor frame, rad²; π²/3
    about the vertical; shape (..., T, 3, 3).

    Output ``innovation``: measured less predicted specific force, m/s²; NaN where there is no
    measurement; shape (..., T, 3).

    Output ``nis``: normalised innovation squared of the accelerometer, 3 degrees of freedom;
    shape (..., T).

    References
    ----------
    Hyyti & Visala 2015, eqs 1-15 and A.1-A.8.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.DcmImu(rate=100.0, dcm_process=0.1).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """An error-state Kalman filter of attitude and gyroscope bias.

    Its noises are densities, so that they do not depend on the sampling rate. The specific
    force counts less where its mean is not vertical (external acceleration); the magnetometer
    corrects only the heading, and is left out where its field is strange or its innovation too
    large; at rest the gyroscope shows its bias.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    gyr_noise : float, default 0.002, in [1e-09, 1000] rad/s/√Hz
        Noise density of the gyroscope (angle random walk).
    bias_noise : float, default 0.0001, in [1e-09, 1000] rad/s²/√Hz
        Noise density of the bias' rate (rate random walk).
    acc_noise : float, default 0.3, in [1e-06, 1000] m/s²/√Hz
        Noise density of the accelerometer.
    heading_noise : float, default 0.1, in [1e-06, 1000] rad/√Hz
        Noise density of the magnetometer's heading.
    acc_adaptation : float, default 0.3, in [0, 1000] √s
        How much the mean horizontal specific force adds to the density of the accelerometer (0:
        nothing).
    acc_window : float, default 10.0, in [1e-06, 1e+06] s
        Time constant of that mean.
    mag_tolerance : float, default 0.12, in [1e-06, 1e+06]
        Relative deviation of the field from its reference at which the heading's variance is
        four times as large.
    mag_window : float, default 3.0, in [1e-06, 1e+06] s
        Time constant of the reference field.
    mag_gate : float, default 3.0, in [0.001, 1e+06]
        Innovations of the heading beyond this many standard deviations are not used.
    mag_recovery : float, default 10.0, in [0, 1e+06] s
        Time after which a field that was left out is used all the same.
    rest_gyr : float, default 0.03490658503988659, in [0, 1000] rad/s
        Deviation of the angular rate from its mean below which the sensor may be at rest.
    rest_acc : float, default 0.5, in [0, 1000] m/s²
        Deviation of the specific force from its mean below which the sensor may be at rest.
    rest_time : float, default 1.5, in [0, 1e+09] s
        Time that both have to be small for.
    rest_noise : float, default 0.01, in [1e-09, 1000] rad/s/√Hz
        Noise density of the angular rate at rest, as a measurement of the bias.
    initial_inclination : float, default 0.1, in [1e-06, 1000] rad
        Standard deviation of the inclination at the start.
    initial_heading : float, default 0.5, in [1e-06, 1000] rad
        Standard deviation of the heading at the start.
    initial_bias : float, default 0.05, in [1e-09, 1000] rad/s
        Standard deviation of the bias at the start; it never becomes larger.
    gravity : float, default 9.80665, in [0.001, 1000] m/s²
        Gravity g where the sensor is.
    magnetometer : {"heading", "vector"}, default "heading"
        What of the field is used: its heading, or all of it (the inclination too).
    mag_delay : float, default 0.0, in [0, 1] s
        How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the
        field is turned into the present sensor frame by the angular rate.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Output ``covariance``: covariance of the attitude error in the sensor frame, rad²; π²/3
    about the vertical until a magnetometer sample has been used; shape (..., T, 3, 3).

    Output ``innovation``: tilt that the specific force shows about east and north, and heading
    of the field, rad; NaN where there is no measurement; shape (..., T, 3).

    Output ``nis``: normalised innovation squared of accelerometer (2 degrees of freedom) and
    magnetometer (1; 3 with magnetometer="vector"); shape (..., T, 2).

    References
    ----------
    Markley, J. Guidance 26(2), 2003, with the error as a tilt and a turn in the earth frame.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.MEKF(rate=100.0, gyr_noise=0.002).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """Strapdown integration; the inclination is corrected by the specific force, low-pass filtered
    in an almost inertial frame; the heading by a scalar offset.

    The gyroscope's bias is estimated at rest and in motion, and a magnetic field that is
    strange in norm or dip is left out. A missing row is bridged: the next measurement stands
    for all the time since the last one.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    tau_acc : float, default 3.0, in [0, 1e+06] s
        Time constant τ_acc of the low-pass filter of the specific force: how long acceleration
        has to cancel out.
    tau_mag : float, default 9.0, in [0, 1e+06] s
        Time constant τ_mag of the heading's correction.
    motion_bias_est_enabled : bool, default True
        Whether the gyroscope's bias is estimated in motion.
    rest_bias_est_enabled : bool, default True
        Whether rest is detected and the bias estimated then.
    mag_dist_rejection_enabled : bool, default True
        Whether magnetic disturbances are detected and left out.
    bias_sigma_init : float, default 0.5, in [1e-06, 1000] °/s
        Standard deviation of the bias at the start.
    bias_forgetting_time : float, default 100.0, in [0.001, 1e+09] s
        Time in which the standard deviation of the bias grows from zero to 0.1 °/s.
    bias_clip : float, default 2.0, in [1e-06, 1e+06] °/s
        Largest bias per axis, and largest error that one sample can show.
    bias_sigma_motion : float, default 0.1, in [1e-06, 1000] °/s
        Standard deviation of the bias in motion, in the steady state.
    bias_vertical_forgetting_factor : float, default 0.0001, in [0, 1000]
        How fast the bias about the vertical, which motion does not show, goes to zero: a factor
        on its information.
    bias_sigma_rest : float, default 0.03, in [1e-06, 1000] °/s
        Standard deviation of the bias at rest, in the steady state.
    rest_min_t : float, default 1.5, in [0, 1e+06] s
        Time that the sensor has to be still for to count as resting.
    rest_filter_tau : float, default 0.5, in [0, 1e+06] s
        Time constant of the low-pass filters of the rest detection.
    rest_th_gyr : float, default 2.0, in [1e-09, 1e+06] °/s
        Largest deviation of the angular rate from its low-pass filtered value at rest.
    rest_th_acc : float, default 0.5, in [1e-09, 1e+06] m/s²
        Largest deviation of the specific force from its low-pass filtered value at rest.
    mag_current_tau : float, default 0.05, in [0, 1e+06] s
        Time constant of the low-pass filter of norm and dip of the field (0: none).
    mag_ref_tau : float, default 20.0, in [0, 1e+06] s
        Time constant with which the reference of the field follows.
    mag_norm_th : float, default 0.1, in [1e-09, 1e+06]
        Largest deviation of the field's norm, relative to the reference.
    mag_dip_th : float, default 10.0, in [1e-09, 180] °
        Largest deviation of the field's dip.
    mag_new_time : float, default 20.0, in [0, 1e+06] s
        Time of movement after which a new undisturbed field is accepted.
    mag_new_first_time : float, default 5.0, in [0, 1e+06] s
        The same for the first one.
    mag_new_min_gyr : float, default 20.0, in [0, 1e+06] °/s
        Angular rate from which on it counts as movement.
    mag_min_undisturbed_time : float, default 0.5, in [0, 1e+06] s
        Time after which a field that fits the reference is believed again.
    mag_max_rejection_time : float, default 60.0, in [0, 1e+06] s
        Time for which a disturbed field is left out; after it, it counts less.
    mag_rejection_factor : float, default 2.0, in [1, 1e+06]
        How much less, and how fast the time of rejection is won back in an undisturbed field.
    mag_delay : float, default 0.0, in [0, 1] s
        How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the
        field is turned into the present sensor frame by the angular rate.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: does another mounting of the sensor give the same attitude? No: biases and their
    errors are clipped axis by axis, and the first sample turns before it is aligned.

    Output ``quat6d``: attitude by gyroscope and accelerometer, in east-north-up with a heading
    that drifts; shape (..., T, 4).

    Output ``quat9d``: attitude with the magnetometer's heading, in east-north-up from magnetic
    north; shape (..., T, 4).

    Output ``delta``: heading offset δ from quat6d to quat9d about the vertical, rad; shape
    (..., T).

    Output ``bias_sigma``: standard deviation of the gyroscope's bias, rad/s; shape (..., T).

    Output ``rest``: 1 where the sensor rests, else 0; shape (..., T).

    Output ``mag_disturbed``: 1 where the magnetic field is disturbed or no undisturbed one is
    known yet, else 0; shape (..., T).

    Output ``mag_ref_norm``: norm of the undisturbed field, 0 until it is known, µT; shape (...,
    T).

    Output ``mag_ref_dip``: dip of the undisturbed field below the horizon, rad; shape (..., T).

    References
    ----------
    Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024); defaults and order of steps
    as published with its package vqf.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.VQF(rate=100.0, tau_acc=3.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """An error-state Kalman filter that calibrates the sensors while it runs: bias and 3×3 matrix
    of the gyroscope, bias of the accelerometer, hard iron and delay of the magnetometer.

    The local field may wander in a correlated way; the velocity, which is never far from zero
    for long, shows the inclination; the magnetometer never moves it.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    gyr_noise : float, default 0.0003, in [1e-09, 1000] rad/s/√Hz
        Noise density of the gyroscope (angle random walk).
    rate_noise : float, default 0.0007, in [0, 1000] 1/√Hz
        Noise density of the gyroscope for each rad/s that it turns.
    gyr_range : float, default 0.0, in [0, 1000] rad/s
        The largest rate that an axis of the gyroscope shows; 0 where it is not known, and found
        where readings stand still.
    bias_noise : float, default 5e-05, in [0, 1000] rad/s²/√Hz
        Noise density of the bias' rate (rate random walk).
    velocity : float, default 0.3, in [1e-06, 1000] m/s
        Standard deviation of the velocity.
    velocity_time : float, default 0.5, in [0.001, 1000] s
        The time for which a velocity lasts.
    velocity_noise : float, default 0.01, in [1e-06, 1000] m/s²/√Hz
        Noise density of the accelerometer.
    mag_noise : float, default 0.04, in [1e-06, 1000] 1/√Hz
        Noise density of a component of the magnetometer, in norms of the field.
    mag_rate_noise : float, default 0.0007, in [0, 1000] s/rad/√Hz
        How much it grows for each rad/s that the sensor turns.
    mag_tolerance : float, default 0.09, in [1e-06, 1e+09]
        Deviation of the field from its reference, in its norms, at which it begins to count
        less (1e9: every field counts alike).
    mag_tail : float, default 1.7, in [0.001, 1e+06]
        How slowly it does: the weight is (1 + (deviation/tolerance)²/tail)⁻².
    mag_new_time : float, default 20.0, in [0, 1e+06] s
        Time of movement after which a field that is not the reference's, but the same all the
        time, is the new reference. A reference that has been seen for less time itself is given
        up after that time, and after a quarter of this at the earliest.
    disturbance : float, default 0.018, in [0, 1000]
        Standard deviation of the field's disturbance, in norms of the field. Here and in all
        that follows, 0 takes the state out of the estimate.
    disturbance_time : float, default 8.0, in [0.001, 1e+06] s
        The time for which a disturbance lasts.
    hard_iron_noise : float, default 0.001, in [0, 1000] 1/√s
        How fast the hard iron wanders, in norms of the field.
    largest_hard_iron : float, default 0.1, in [0, 1000]
        The largest standard deviation of the hard iron.
    rest_gyr : float, default 0.03490658503988659, in [0, 1000] rad/s
        Deviation of the angular rate from its mean below which the sensor may be at rest.
    rest_acc : float, default 0.5, in [0, 1000] m/s²
        Deviation of the specific force from its mean below which the sensor may be at rest.
    rest_time : float, default 1.5, in [0, 1e+09] s
        Time that both have to be small for.
    rest_noise : float, default 0.0005, in [1e-09, 1000] rad/s/√Hz
        Noise density of the angular rate at rest, as a measurement of the bias.
    rest_velocity : float, default 0.02, in [1e-06, 1000] m/s
        Standard deviation of the velocity at rest.
    initial_inclination : float, default 0.5, in [1e-06, 1000] rad
        Standard deviation of the inclination at the start.
    initial_heading : float, default 1.0, in [1e-06, 1000] rad
        Standard deviation of the heading at the start.
    initial_bias : float, default 0.0087, in [0, 1000] rad/s
        Standard deviation of the gyroscope's bias at the start; it never becomes larger.
    initial_matrix : float, default 0.003, in [0, 1000]
        The same of each entry of the gyroscope's matrix.
    initial_velocity : float, default 1.0, in [1e-06, 1000] m/s
        The same of the velocity.
    initial_acc_bias : float, default 0.04, in [0, 1000] m/s²
        The same of the accelerometer's bias.
    initial_gravity : float, default 0.05, in [0, 1000] m/s²
        The same of gravity.
    initial_hard_iron : float, default 0.001, in [0, 1000]
        The same of the hard iron, in norms of the field.
    initial_field : float, default 0.05, in [0, 1000]
        The same of the reference field, in its norms.
    initial_delay : float, default 0.015, in [0, 1] s
        The same of the magnetometer's delay.
    latency : float, default 0.0, in [-1, 1] s
        Delay of all sensors behind the attitude that is wanted, by which the output is turned
        ahead.
    gravity : float, default 9.80665, in [0.001, 1000] m/s²
        Gravity g where the sensor is.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Output ``covariance``: covariance of the attitude error in the sensor frame, rad²; π²/3
    about the vertical until a magnetometer sample has been used; shape (..., T, 3, 3).

    Output ``gyr_matrix``: matrix M of the gyroscope: the angular rate is (I + M)(ω − b); shape
    (..., T, 3, 3).

    Output ``mag_delay``: delay of the magnetometer behind the gyroscope, s; shape (..., T).

    Output ``mag_delay_sigma``: standard deviation of that delay, s; shape (..., T).

    Output ``hard_iron``: field of the sensor's own, sensor frame, unit of the magnetometer;
    shape (..., T, 3).

    Output ``disturbance``: disturbance of the field where the sensor is, east, north and up,
    unit of the magnetometer; shape (..., T, 3).

    Output ``mag_weight``: weight of the last field, 0 to 1; shape (..., T).

    Output ``mag_reference``: horizontal and upward part of the reference field, unit of the
    magnetometer; zeros until it is known; shape (..., T, 2).

    References
    ----------
    this project, docs/selfcal.md.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.SelfCalKF(rate=100.0, gyr_noise=0.0003).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
    @property
    def gyr_noise(self) -> float: ...
    @property
    def rate_noise(self) -> float: ...
    @property
    def gyr_range(self) -> float: ...  # type: ignore[override]
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
    """VQF without estimation of the gyroscope's bias, rest detection and magnetic disturbance
    rejection: strapdown integration, the inclination by the specific force, low-pass filtered
    in an almost inertial frame, the heading by a scalar offset.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    tau_acc : float, default 3.0, in [0, 1e+06] s
        Time constant τ_acc of the low-pass filter of the specific force: how long acceleration
        has to cancel out.
    tau_mag : float, default 9.0, in [0, 1e+06] s
        Time constant τ_mag of the heading's correction.
    mag_delay : float, default 0.0, in [0, 1] s
        How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the
        field is turned into the present sensor frame by the angular rate.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Output ``quat6d``: attitude by gyroscope and accelerometer, in east-north-up with a heading
    that drifts; shape (..., T, 4).

    Output ``quat9d``: attitude with the magnetometer's heading, in east-north-up from magnetic
    north; shape (..., T, 4).

    Output ``delta``: heading offset δ from quat6d to quat9d about the vertical, rad; shape
    (..., T).

    References
    ----------
    Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024): strapdown integration,
    inclination and heading correction.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.BasicVQF(rate=100.0, tau_acc=3.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """The angular rate is corrected by the error between measured and predicted vertical, and
    between measured and predicted heading, which leaves the inclination alone.

    The gain falls from 10 to its value in the first three seconds, and again after the
    gyroscope has left its range. A measurement whose error is beyond the rejection's angle is
    left out, until that has lasted too long. Equal to the imufusion package at a constant rate,
    with time instead of its counts of samples: in a gap of more than 1/gain the feedback counts
    for that long only, and without a magnetometer the heading of the start is kept, not zeroed.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    gain : float, default 0.5, in [0, 1e+06] rad/s
        Gain of the feedback: an error decays at this rate. 0 is the gyroscope alone, after the
        start.
    gyroscope_range : float, default 0.0, in [0, 1e+06] °/s
        Range of the gyroscope; beyond 98 % of it on an axis the filter starts anew from its
        attitude. 0: no limit.
    acceleration_rejection : float, default 0.0, in [0, 90] °
        Error of the vertical beyond which the accelerometer is left out. 0: never.
    magnetic_rejection : float, default 0.0, in [0, 90] °
        Error of the heading beyond which the magnetometer is left out. 0: never.
    rejection_timeout : float, default 0.0, in [0, 1e+06] s
        Time of rejection after which a sensor is used all the same; a sample that is not
        rejected takes off nine times its length. 0: nothing is ever left out.
    bias : bool, default False
        Whether the gyroscope's bias is estimated at rest, axis by axis, with a cut-off of 0.02
        Hz.
    stationary_threshold : float, default 3.0, in [1e-06, 1e+06] °/s
        Angular rate on an axis, less the bias, beyond which the sensor is not at rest.
    stationary_period : float, default 3.0, in [0, 1e+06] s
        Time for which the rate must have been below it.
    integration : {"first-order", "exponential"}, default "first-order"
        Integration of the angular rate over a step: by the first-order step of the original
        followed by normalisation, or by the exponential map, exact for a rate that is constant
        over the step.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Output ``acceleration_error``: angle between measured and predicted vertical, °, 90 where it
    is more; NaN where nothing is measured, and in the sample that aligns; shape (..., T).

    Output ``accelerometer_ignored``: 1 where the accelerometer was not used, else 0; shape
    (..., T).

    Output ``acceleration_recovery_trigger``: how much of the time is over after which a
    rejected accelerometer is used all the same, 0 to 1; shape (..., T).

    Output ``magnetic_error``: angle between measured and predicted heading, °, 90 where it is
    more; NaN where nothing is measured; shape (..., T).

    Output ``magnetometer_ignored``: 1 where the magnetometer was not used, else 0; shape (...,
    T).

    Output ``magnetic_recovery_trigger``: how much of the time is over after which a rejected
    magnetometer is used all the same, 0 to 1; shape (..., T).

    Output ``startup``: 1 while the gain falls to its value, else 0; shape (..., T).

    Output ``overrange_recovery``: 1 while it does so because the gyroscope had left its range,
    else 0; shape (..., T).

    Output ``acceleration_recovery``: 1 while an accelerometer that has been rejected for long
    is used, else 0; shape (..., T).

    Output ``magnetic_recovery``: 1 while a magnetometer that has been rejected for long is
    used, else 0; shape (..., T).

    References
    ----------
    Madgwick, PhD thesis, University of Bristol 2014, chapter 7; x-io Technologies, Fusion 1.3.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.Fusion(rate=100.0, gain=0.5).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """VQF over a whole recording: the gyroscope's bias, rest and magnetic disturbances are learnt
    forward and backward in time, and the filters of the specific force and of the heading have
    no delay, so that every attitude knows the future too.

    Offline: no update and no state. Computed in float64 whatever the dtype.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    tau_acc : float, default 3.0, in [0, 1e+06] s
        Time constant τ_acc of the low-pass filter of the specific force: how long acceleration
        has to cancel out.
    tau_mag : float, default 9.0, in [0, 1e+06] s
        Time constant τ_mag of the heading's correction.
    motion_bias_est_enabled : bool, default True
        Whether the gyroscope's bias is estimated in motion.
    rest_bias_est_enabled : bool, default True
        Whether rest is detected and the bias estimated then.
    mag_dist_rejection_enabled : bool, default True
        Whether magnetic disturbances are detected and left out.
    bias_sigma_init : float, default 0.5, in [1e-06, 1000] °/s
        Standard deviation of the bias at the start.
    bias_forgetting_time : float, default 100.0, in [0.001, 1e+09] s
        Time in which the standard deviation of the bias grows from zero to 0.1 °/s.
    bias_clip : float, default 2.0, in [1e-06, 1e+06] °/s
        Largest bias per axis, and largest error that one sample can show.
    bias_sigma_motion : float, default 0.1, in [1e-06, 1000] °/s
        Standard deviation of the bias in motion, in the steady state.
    bias_vertical_forgetting_factor : float, default 0.0001, in [0, 1000]
        How fast the bias about the vertical, which motion does not show, goes to zero: a factor
        on its information.
    bias_sigma_rest : float, default 0.03, in [1e-06, 1000] °/s
        Standard deviation of the bias at rest, in the steady state.
    rest_min_t : float, default 1.5, in [0, 1e+06] s
        Time that the sensor has to be still for to count as resting.
    rest_filter_tau : float, default 0.5, in [0, 1e+06] s
        Time constant of the low-pass filters of the rest detection.
    rest_th_gyr : float, default 2.0, in [1e-09, 1e+06] °/s
        Largest deviation of the angular rate from its low-pass filtered value at rest.
    rest_th_acc : float, default 0.5, in [1e-09, 1e+06] m/s²
        Largest deviation of the specific force from its low-pass filtered value at rest.
    mag_current_tau : float, default 0.05, in [0, 1e+06] s
        Time constant of the low-pass filter of norm and dip of the field (0: none).
    mag_ref_tau : float, default 20.0, in [0, 1e+06] s
        Time constant with which the reference of the field follows.
    mag_norm_th : float, default 0.1, in [1e-09, 1e+06]
        Largest deviation of the field's norm, relative to the reference.
    mag_dip_th : float, default 10.0, in [1e-09, 180] °
        Largest deviation of the field's dip.
    mag_new_time : float, default 20.0, in [0, 1e+06] s
        Time of movement after which a new undisturbed field is accepted.
    mag_new_first_time : float, default 5.0, in [0, 1e+06] s
        The same for the first one.
    mag_new_min_gyr : float, default 20.0, in [0, 1e+06] °/s
        Angular rate from which on it counts as movement.
    mag_min_undisturbed_time : float, default 0.5, in [0, 1e+06] s
        Time after which a field that fits the reference is believed again.
    mag_max_rejection_time : float, default 60.0, in [0, 1e+06] s
        Time for which a disturbed field is left out; after it, it counts less.
    mag_rejection_factor : float, default 2.0, in [1, 1e+06]
        How much less, and how fast the time of rejection is won back in an undisturbed field.
    mag_delay : float, default 0.0, in [0, 1] s
        How long after it is measured a magnetometer's sample comes, beside the gyroscope's: the
        field is turned into the present sensor frame by the angular rate.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    gyr_range : float, default 0.0
        Largest rate in rad/s that an axis of the gyroscope shows; 0: not known. A rotation
        beyond it is lost, and the attitude is found again from the accelerometer and
        magnetometer.
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: does another mounting of the sensor give the same attitude? No: biases and their
    errors are clipped axis by axis, and the first sample turns before it is aligned.

    Output ``quat6d``: attitude by gyroscope and accelerometer, in east-north-up with a heading
    that drifts; shape (..., T, 4).

    Output ``quat9d``: attitude with the magnetometer's heading, in east-north-up from magnetic
    north; shape (..., T, 4).

    Output ``delta``: heading offset δ from quat6d to quat9d about the vertical, rad; shape
    (..., T).

    Output ``bias_sigma``: standard deviation of the gyroscope's bias, rad/s; shape (..., T).

    Output ``rest``: 1 where the sensor rests, else 0; shape (..., T).

    Output ``mag_disturbed``: 1 where forward and backward the magnetic field is disturbed or no
    undisturbed one is known, else 0; shape (..., T).

    References
    ----------
    Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024), the offline variant; defaults
    and order of steps as published with its package vqf.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.OfflineVQF(rate=100.0, tau_acc=3.0).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    """SelfCalKF over a whole recording: its linear filter and smoother go twice over the
    trajectory that SelfCalKF has found, so that every attitude knows the future too, and the
    start knows the calibration.

    Offline: no update and no state. Computed in float64 whatever the dtype.

    Parameters
    ----------
    rate : float, optional
        Sampling rate in Hz. Needed unless stamps ``t`` or steps ``dt`` are given.
    gyr_noise : float, default 0.0003, in [1e-09, 1000] rad/s/√Hz
        Noise density of the gyroscope (angle random walk).
    rate_noise : float, default 0.0014, in [0, 1000] 1/√Hz
        Noise density of the gyroscope for each rad/s that it turns.
    bias_noise : float, default 0.0002, in [0, 1000] rad/s²/√Hz
        Noise density of the bias' rate (rate random walk).
    velocity : float, default 0.6, in [1e-06, 1000] m/s
        Standard deviation of the velocity.
    velocity_time : float, default 0.5, in [0.001, 1000] s
        The time for which a velocity lasts.
    velocity_noise : float, default 0.03, in [1e-06, 1000] m/s²/√Hz
        Noise density of the accelerometer.
    mag_noise : float, default 0.035, in [1e-06, 1000] 1/√Hz
        Noise density of a component of the magnetometer, in norms of the field.
    mag_rate_noise : float, default 0.0007, in [0, 1000] s/rad/√Hz
        How much it grows for each rad/s that the sensor turns.
    mag_tolerance : float, default 0.09, in [1e-06, 1000]
        Deviation of the field from its reference, in its norms, at which it begins to count
        less.
    mag_tail : float, default 2.5, in [0.001, 1e+06]
        How slowly it does: the weight is (1 + (deviation/tolerance)²/tail)⁻².
    disturbance : float, default 0.018, in [0, 1000]
        Standard deviation of the field's disturbance, in norms of the field.
    disturbance_time : float, default 12.0, in [0.001, 1e+06] s
        The time for which a disturbance lasts.
    hard_iron_noise : float, default 0.0, in [0, 1000] 1/√s
        How fast the hard iron wanders, in norms of the field; zero: not at all.
    rest_gyr : float, default 0.03490658503988659, in [0, 1000] rad/s
        Deviation of the angular rate from its mean below which the sensor may be at rest.
    rest_acc : float, default 0.5, in [0, 1000] m/s²
        Deviation of the specific force from its mean below which the sensor may be at rest.
    rest_time : float, default 1.5, in [0, 1e+09] s
        Time that both have to be small for.
    rest_noise : float, default 0.002, in [1e-09, 1000] rad/s/√Hz
        Noise density of the angular rate at rest, as a measurement of the bias.
    rest_velocity : float, default 0.02, in [1e-06, 1000] m/s
        Standard deviation of the velocity at rest.
    initial_inclination : float, default 0.5, in [1e-06, 1000] rad
        Standard deviation of the inclination at the start.
    initial_heading : float, default 1.0, in [1e-06, 1000] rad
        Standard deviation of the heading at the start.
    initial_bias : float, default 0.0087, in [1e-09, 1000] rad/s
        Standard deviation of the gyroscope's bias at the start.
    initial_matrix : float, default 0.003, in [0, 1000]
        The same of each entry of the gyroscope's matrix.
    initial_velocity : float, default 3.0, in [1e-06, 1000] m/s
        The same of the velocity.
    initial_acc_bias : float, default 0.04, in [0, 1000] m/s²
        The same of the accelerometer's bias.
    initial_gravity : float, default 0.015, in [0, 1000] m/s²
        The same of gravity.
    initial_hard_iron : float, default 0.0, in [0, 1000]
        The same of the hard iron, in norms of the field; zero: there is none.
    initial_field : float, default 0.1, in [1e-09, 1000]
        The same of the reference field, in its norms.
    initial_delay : float, default 0.01, in [0, 1] s
        The same of the magnetometer's delay.
    latency : float, default 0.0, in [-1, 1] s
        Delay of all sensors behind the attitude that is wanted, by which the output is turned
        ahead.
    gravity : float, default 9.80665, in [0.001, 1000] m/s²
        Gravity g where the sensor is.
    gyr_range : float, default 0.0, in [0, 1000] rad/s
        The largest rate that an axis of the gyroscope can measure; what is beyond is lost and
        counts as unknown. Zero: where an axis stays at the recording's largest rate, it is
        taken for that.
    frame : {"ENU", "NED", "NWU"}, default "ENU"
        Earth frame of the attitude.
    declination : float, default 0.0
        Magnetic declination in rad, positive east. With a magnetometer, the attitude is then
        from true north.
    gyr_hold : {"zero-order", "linear"}, default "zero-order"
        The angular rate between two samples: that of the sample that ends the step, or linear
        between both.
    repeated : {"new", "missing"}, default "new"
        A row of the accelerometer or magnetometer that equals the sensor's last one bit for
        bit, while the gyroscope's row does not: a measurement as any other, or none, for 1 s at
        most (the logger repeats the last row of a slower sensor).
    dtype : data-type, default numpy.float64
        Of ``update``: float32 or float64. ``run`` computes in float32 where all its
        measurements are float32.

    Notes
    -----
    Sensors: gyroscope and accelerometer (6D), or with a magnetometer (9D).

    Mounting: another mounting of the sensor gives the same attitude, exactly.

    Output ``covariance``: covariance of the attitude error in the sensor frame, rad²; π²/3
    about the vertical without a magnetometer; shape (..., T, 3, 3).

    Output ``bias_sigma``: standard deviation of the gyroscope's bias, rad/s: the largest of the
    three axes; shape (..., T).

    Output ``gyr_matrix``: matrix M of the gyroscope: the angular rate is (I + M)(ω − b); shape
    (..., T, 3, 3).

    Output ``gyr_matrix_sigma``: standard deviations of its entries; shape (..., T, 3, 3).

    Output ``acc_bias``: bias of the accelerometer, m/s²; shape (..., T, 3).

    Output ``mag_delay``: delay of the magnetometer behind the gyroscope, s; shape (..., T).

    Output ``mag_delay_sigma``: standard deviation of that delay, s; shape (..., T).

    Output ``hard_iron``: field of the sensor's own, sensor frame, unit of the magnetometer;
    shape (..., T, 3).

    Output ``disturbance``: disturbance of the field where the sensor is, east, north and up,
    unit of the magnetometer; shape (..., T, 3).

    Output ``mag_weight``: weight of the field, 0 to 1; shape (..., T).

    Output ``mag_reference``: horizontal and upward part of the reference field, unit of the
    magnetometer; shape (..., T, 2).

    References
    ----------
    this project.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> gyr, acc = np.zeros((50, 3)), np.tile([0.0, 0.0, 9.81], (50, 1))
    >>> mag = np.tile([0.0, 20.0, -40.0], (50, 1))
    >>> est = ar.SelfCalSmoother(rate=100.0, gyr_noise=0.0003).run(gyr, acc, mag)
    >>> est.quat.shape
    (50, 4)
    """
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
    def gyr_range(self) -> float: ...  # type: ignore[override]
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
