"""How fast published filters forget an error that nothing tells them of: at the pace that their own gains give them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

#: Inclination of the field below the horizontal, rad: the steepest of the recordings (BROAD, Berlin).
DIP = math.radians(67.0)
#: An error that can be no larger, °.
LARGEST = 180.0


@dataclass(frozen=True, slots=True)
class Pace:
    """What is left of an error, and where that comes from."""

    text: str
    #: (inclination °, heading °, s since then, Hz) -> ° of what the filter observes
    left_of: Callable[[float, float, float, float], float]

    def left(self, inclination: float, heading: float, time: float, rate: float) -> float:
        """° that may be left after a time in s of an error with these parts in °."""
        return min(LARGEST, self.left_of(inclination, heading, time, rate))


def near(left: Callable[[float, float], float]) -> Callable[[float, float, float, float], float]:
    """A law of the sum of both errors, up to 90°.

    From further away a filter may pass close to the turn by 180°, where its correction has no direction.
    """

    def left_of(inclination: float, heading: float, time: float, _rate: float) -> float:
        return left(inclination + heading, time) if inclination + heading <= 90.0 else LARGEST

    return left_of


def madgwick(error: float, time: float, beta: float = 0.041) -> float:
    # A descent turns by 2 β, of which noise and acceleration take a share: half of it.
    return max(0.0, error - math.degrees(beta) * time)


def mahony(error: float, time: float, kp: float = 1.0, ki: float = 0.3) -> float:
    # The slowest pair of poles has this real part. The integral has learnt a bias in the sensor's axes, and holds
    # the error at ki/(kp² λ) times what it came from where they turn.
    slowest = 1.0 - math.sin(DIP)
    return error * (1.0 + ki / (kp**2 * slowest)) * math.exp(-0.5 * kp * slowest * time)


def fusion(error: float, time: float, gain: float = 0.5) -> float:
    # An inclination that is wrong shows a heading that is wrong by tan dip times as much, and both decay alike.
    return error * (1.0 + gain * time * math.tan(DIP)) * math.exp(-gain * time)


@cache
def _one_axis(rate: float) -> list[float]:
    """What is left of an error of 1, at each step: of an angle whose filter learns a bias from it."""
    dt, variance = 1.0 / rate, 0.8072362
    angle_process, bias_process = 7.195063e-4 * dt, 2.607525e-7 * dt
    p_angle, p_cross, p_bias = variance, 0.0, 0.01**2
    angle, bias, errors = 0.0, 0.0, []
    begin = round(30.0 * rate)
    for step in range(3 * begin):
        if step == begin:
            angle, bias = 1.0, 0.0
        angle -= bias * dt
        p_angle += angle_process - 2.0 * dt * p_cross + dt**2 * p_bias
        p_cross -= dt * p_bias
        p_bias += bias_process
        gain, bias_gain = p_angle / (p_angle + variance), p_cross / (p_angle + variance)
        angle, bias = angle - gain * angle, bias - bias_gain * angle
        p_angle, p_cross, p_bias = (1.0 - gain) * p_angle, (1.0 - gain) * p_cross, p_bias - bias_gain * p_cross
        errors.append(abs(angle))
    return errors[begin:]


def linear_kalman(_inclination: float, _heading: float, time: float, rate: float) -> float:
    # Roll may be wrong by 180° and pitch by 90° where the inclination is wrong by any angle.
    return math.hypot(LARGEST, 0.5 * LARGEST) * max(_one_axis(rate)[round(time * rate) :])


def vqf(inclination: float, heading: float, time: float, _rate: float) -> float:
    # The field is rejected while it contradicts, for up to a minute; what it says may pull the heading to any side.
    return math.sqrt(2.0) * inclination * math.exp(-time / 3.0) + _pulled(inclination, heading, time, 18.0)[0]


def basic_vqf(inclination: float, heading: float, time: float, _rate: float) -> float:
    pulled, wait = _pulled(inclination, heading, time, 9.0)
    return math.sqrt(2.0) * inclination * math.exp(-time / 3.0) + pulled * math.exp(-(time - wait) / 9.0)


def _pulled(inclination: float, heading: float, time: float, tau: float) -> tuple[float, float]:
    """The heading's error when the inclination is right to 10°, and the time until then, in which it may be pulled."""
    wait = min(time, max(0.0, 3.0 * math.log(max(math.sqrt(2.0) * inclination, 1e-9) / 10.0)))
    return heading + (LARGEST - heading) * -math.expm1(-wait / tau), wait


def anything(_inclination: float, _heading: float, _time: float, _rate: float) -> float:
    return LARGEST


#: By the names of the filters.
PACES = {
    "LinearKalman": Pace(
        "roll and pitch as the published matrices forget them: 3.3 s at 100 Hz and 2 s at 286 Hz, with a bias that is "
        "learnt meanwhile",
        linear_kalman,
    ),
    "Mahony": Pace(
        "up to 90°: (1 + ki/(kp² λ)) exp(−kp λ t/2) with λ = 1 − sin dip, that is 25 s and, by what the integral has "
        "learnt, 4.8 times the error at a dip of 67°",
        near(mahony),
    ),
    "Madgwick": Pace("up to 90°: β, that is 2.3 °/s, half of the published descent's rate", near(madgwick)),
    "Fusion": Pace("up to 90°: (1 + g t tan dip) exp(−g t) with the gain g = 0.5/s", near(fusion)),
    "VQF": Pace(
        "the inclination as √2 exp(−t/3 s); the heading waits until the field is no longer rejected, up to a minute",
        vqf,
    ),
    "BasicVQF": Pace(
        "the inclination as √2 exp(−t/3 s), and when it is right to 10° the heading as exp(−t/9 s)", basic_vqf
    ),
    "OfflineVQF": Pace(
        "nothing is asked: at rest, where the field is no reference, its heading keeps the error for minutes", anything
    ),
}
