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


def madgwick(inclination: float, heading: float, time: float, _rate: float, beta: float = 0.041) -> float:
    # From further away a descent may pass close to the turn by 180°, where the gradient says nothing.
    if inclination + heading > 90.0:
        return LARGEST
    return max(0.0, inclination + heading - math.degrees(2.0 * beta / math.sqrt(3.0)) * time)


def mahony(inclination: float, heading: float, time: float, _rate: float, kp: float = 1.0) -> float:
    # A pair of poles has this real part; the integral lets the error swing to the other side before it has decayed.
    if inclination + heading > 90.0:
        return LARGEST
    return (inclination + heading) * math.exp(-0.5 * kp * (1.0 - math.sin(DIP)) * time)


def fusion(inclination: float, heading: float, time: float, _rate: float, gain: float = 0.5) -> float:
    # Above 90° the correction is a constant turn.
    fallen = gain * time - math.radians(max(0.0, inclination - 90.0) + max(0.0, heading - 90.0))
    decayed = max(0.0, fallen)
    return (inclination + heading) * (1.0 + decayed * math.tan(DIP)) * math.exp(-decayed)


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


def vqf(tau_mag: float, rejected: float) -> Callable[[float, float, float, float], float]:
    def left(inclination: float, heading: float, time: float, _rate: float) -> float:
        tilt = math.sqrt(2.0) * inclination
        # Until the inclination is right to 10° the heading is corrected to a wrong one, or not at all.
        wait = min(time, max(0.0, 3.0 * math.log(max(tilt, 1e-9) / 10.0)) + rejected)
        pulled = heading + (LARGEST - heading) * -math.expm1(-wait / tau_mag)
        return tilt * math.exp(-time / 3.0) + pulled * math.exp(-(time - wait) / tau_mag)

    return left


_VQF = "the inclination falls as √2 exp(−t/3 s), and when it is right to 10° the heading as exp(−t/{tau:g} s){more}"
_REFERENCE = ": `tau_mag` times 2, as long as the field is no reference"

#: By the names of the filters.
PACES = {
    "LinearKalman": Pace(
        "roll and pitch as the published matrices forget them: 3.3 s at 100 Hz and 2 s at 286 Hz, with a bias that is "
        "learnt meanwhile",
        linear_kalman,
    ),
    "Mahony": Pace("up to 90°: exp(−t kp (1 − sin dip)/2), that is 25 s at a dip of 67°", mahony),
    "Madgwick": Pace("up to 90°: 2 β/√3, that is 2.7 °/s", madgwick),
    "Fusion": Pace("(1 + g t tan dip) exp(−g t) with the gain g = 0.5/s; above 90° a turn by g rad/s", fusion),
    "VQF": Pace(_VQF.format(tau=18.0, more=_REFERENCE), vqf(18.0, 0.5)),
    "BasicVQF": Pace(_VQF.format(tau=9.0, more=""), vqf(9.0, 0.0)),
    "OfflineVQF": Pace("as VQF, in both directions of time", vqf(18.0, 0.5)),
}
