"""How long the filters take to get from a wrong start to the truth, by their gains."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from signals import GRAVITY

#: From a start at most this far from the truth every filter with feedback must get there, rad.
START = 0.5 * math.pi
#: What counts as arrived for errors that decay exponentially, rad.
ARRIVED = 1e-4
#: The largest amplitude (rad) that an exponential decay from `START` can have. Cross products fall as sin θ,
#: so the error is tan(θ/2) = tan(θ0/2) exp(-kt): from 90° it ends as 2 exp(-kt), not as (π/2) exp(-kt); with
#: the overshoot of an underdamped pair, which no attitude error lets grow beyond π, twice π bounds both.
AMPLITUDE = 2.0 * math.pi

#: Variances in the papers' deg², in rad².
DEGREE2 = math.radians(1.0) ** 2

#: (dip in rad, or None without a magnetometer; time step in s) -> (time in s, error in rad left after it)
Settling = Callable[[float | None, float], tuple[float, float]]


def at_once(_dip: float | None, _dt: float) -> tuple[float, float]:
    """The first sample sets the attitude; 1e-12 rad is rounding."""
    return 0.0, 1e-12


def exponential(pole: float) -> tuple[float, float]:
    """A decay at a rate of `pole` (1/s)."""
    return math.log(AMPLITUDE / ARRIVED) / pole, ARRIVED


def complementary(tau: float) -> Settling:
    """Differences of roll and pitch shrink by α = τ/(τ + dt) a step."""

    def settling(_dip: float | None, dt: float) -> tuple[float, float]:
        return exponential(math.log1p(dt / tau) / dt)

    return settling


def mahony(kp: float, ki: float) -> Settling:
    """The slowest pole of the linearised filter.

    For small errors the direction error is -Λε with the eigenvalues λ = 1 (6D), or λ = 1 - sin dip, 1, 1 +
    sin dip (9D): the magnetometer's term m × m̂ is horizontal as well as vertical, so the heading does not
    decay at kp cos² dip on its own. Each direction has p² + kp λ p + ki λ = 0; underdamped, its real part is
    kp λ/2.
    """

    def settling(dip: float | None, _dt: float) -> tuple[float, float]:
        slowest = math.inf
        for eigenvalue in (1.0,) if dip is None else (1.0 - math.sin(dip), 1.0, 1.0 + math.sin(dip)):
            roots = np.roots([1.0, kp * eigenvalue, ki * eigenvalue]) if ki else [-kp * eigenvalue]
            slowest = min(slowest, *(-np.real(root) for root in roots))
        return exponential(slowest)

    return settling


def madgwick(beta: float, zeta: float = 0.0, paper: bool = False) -> Settling:
    """The descent turns at the constant rate 2β and ends in steps to and fro of 2β dt.

    6D: straight, in the time angle/(2β). 9D: each of three eigendirections of the error shrinks
    monotonically, so the path is at most √3 times as long. The published gradient wastes the part along q: of
    |∇f| the part that turns is 1/√(1 + (|Jq| |f| / 2|e|)²), with |Jq| ≤ 4 and |f|/|e| = 1/cos(θ/2) for the
    accelerometer alone (1/3 at 90°), and |Jq| ≤ √32 and |f|/|e| ≤ 1/√(1 - sin dip) with the field (1/8 at a
    dip of 60°). The bias that ζ builds up on the way helps, then decays with the time constant β/ζ while the
    steps are at most twice as long.
    """

    def settling(dip: float | None, dt: float) -> tuple[float, float]:
        wasted = 1.0
        if paper:
            ratio = 4.0 * math.sqrt(2.0) if dip is None else math.sqrt(32.0 / (1.0 - math.sin(dip)))
            wasted = math.hypot(1.0, 0.5 * ratio)
        path = START * (1.0 if dip is None else math.sqrt(3.0))
        step = 2.0 * beta * dt
        # Ten steps more for the end, where what is left is no longer large against a step.
        time = path * wasted / (2.0 * beta) + 10.0 * dt
        return (time, step) if zeta == 0.0 else (time + beta / zeta, 2.0 * step)

    return settling


def one_axis(
    dt: float,
    angle_process: float,
    bias_process: float,
    variance: Callable[[float], float],
    start: tuple[float, float],
    left: float,
) -> float:
    """Time in which a Kalman filter of one angle and its gyroscope's bias forgets an error of `START`.

    Its gain falls while it settles, so the error falls as a power of time and no pole says how fast. The arguments:
    process variances of a step, the measurement's variance for an error in rad, the variances of the start, and what
    is left of the angle, counting that to which a wrong bias holds it.
    """
    (angle, bias), (p_angle, p_cross, p_bias) = (START, 0.0), (start[0], 0.0, start[1])
    for step in range(1, 1_000_000):
        angle -= bias * dt
        p_angle += angle_process - 2.0 * dt * p_cross + dt**2 * p_bias
        p_cross -= dt * p_bias
        p_bias += bias_process
        s = p_angle + variance(angle)
        gain, bias_gain = p_angle / s, p_cross / s
        angle, bias = angle - gain * angle, bias - bias_gain * angle
        p_angle, p_cross, p_bias = (1.0 - gain) * p_angle, (1.0 - gain) * p_cross, p_bias - bias_gain * p_cross
        if abs(angle) < left and abs(bias) * dt < gain * left:
            return step * dt
    raise AssertionError("does not settle")


def linear_kalman(_dip: float | None, dt: float) -> tuple[float, float]:
    """Parikh's matrices, which keep a wrong bias for a minute: to 1e-3 rad. The start has the variance of a sample."""
    r, left = 2650.0 * DEGREE2, 1e-3
    q_angle, q_bias = (q * DEGREE2 / 0.005 * dt for q in (0.01181, 4.28e-6))
    return one_axis(dt, q_angle, q_bias, lambda _: r, (r, 0.01**2), left), left


def dcm_imu(_dip: float | None, dt: float) -> tuple[float, float]:
    """The accelerometer's variance is that of the error itself, taken for acceleration.

    The time of one axis: an error of more than 35° is begun anew at once.
    """
    time = one_axis(
        dt,
        (0.1 * dt) ** 2,
        (1e-4 * dt) ** 2,
        lambda error: (10.0**2 * GRAVITY * abs(error) + 0.5**2) / GRAVITY**2,
        (1.0, 0.1**2),
        ARRIVED,
    )
    return time, ARRIVED


def ekf(dip: float | None, dt: float) -> tuple[float, float]:
    """The gain √(q/r) of the steady state, on the axis with the smallest.

    q is what a step adds: 4 W of the quaternion, and the rate that the gyroscope leaves, its variance times dt² (the
    rate's own W is far larger than the gyroscope's). r is the accelerometer's largest variance; of the magnetometer,
    the part of the field that shows the heading is cos dip.
    """
    q = 4.0 * 5e-8 * dt + 2.3e-5 * dt**2
    r = 5.5e-5 if dip is None else 2.1e-3 / math.cos(dip) ** 2
    return exponential(math.sqrt(q / r) / dt)


def fusion(gain: float) -> Settling:
    """In the first three seconds, in which nothing is rejected, the gain falls from 10 to its value.

    Its integral G = 10 t - (10 - gain) t²/6 makes an error of the inclination decay as exp(-G). Such an error shows a
    heading that is wrong by tan dip times as much, and both decay alike: the heading's as (1 + G tan dip) exp(-G).
    """

    def settling(dip: float | None, _dt: float) -> tuple[float, float]:
        fall, decay = (10.0 - gain) / 6.0, 0.0
        for _ in range(50):
            growth = 1.0 if dip is None else 1.0 + decay * math.tan(dip)
            decay = math.log(AMPLITUDE * growth / ARRIVED)
        return (5.0 - math.sqrt(25.0 - fall * decay)) / fall, ARRIVED

    return settling


def mekf(dip: float | None, _dt: float) -> tuple[float, float]:
    """The gains of the steady state, after the time in which the filter does not trust what contradicts its start.

    A level error of 90° shows as acceleration of g, which `acc_window` forgets to where `acc_adaptation` times it is
    as large as the noise; a field that contradicts is accepted after `mag_recovery`. Then the inclination decays at
    gyr_noise/(acc_noise/g), the heading at gyr_noise/heading_noise. Rest keeps the bias out of it.
    """
    distrust = 10.0 * math.log(0.3 * GRAVITY / 0.3)
    pole = 2e-3 / (0.3 / GRAVITY) if dip is None else 2e-3 / 0.1
    time, left = exponential(pole)
    return (distrust + time, left) if dip is None else (distrust + 10.0 + time, left)


def selfcal(_dip: float | None, _dt: float) -> tuple[float, float]:
    """A block of 0.1 s: at the start the attitude is that of mean force and mean field, which are exact at rest."""
    return 0.1, ARRIVED


def vqf(*, tau_acc: float = 3.0, tau_mag: float = 9.0, lessened: float = 2.0, bias: bool = True) -> Settling:
    """The slowest of three first-order decays.

    The filtered force goes from the start's vertical to the true one within √2 exp(-t/tau_acc) of the way. A bias that
    the wrong start shows in the meantime goes at rest with the gain of the steady state, variance p against p²/v: v/p a
    step for v = (0.1 °/s)² dt/100 s and p = (0.03 °/s)². Without movement no reference of the field is accepted, so
    that the heading counts less for ever.
    """

    def settling(dip: float | None, _dt: float) -> tuple[float, float]:
        poles = [1.0 / tau_acc]
        if bias:
            poles.append(0.1**2 / 100.0 / 0.03**2)
        if dip is not None:
            poles.append(1.0 / tau_mag / lessened)
        return exponential(min(poles))

    return settling
