"""The second-order Butterworth low-pass filter at steps of any length, from its differential equation."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


class LowPass:
    """Of any number of signals at once, with the time constant tau (s) of Laidig & Seel.

    With the cut-off frequency f = √2/(2π tau) the filter is v' = ω (x - √2 v - y), y' = ω v. A step of the trapezoidal
    rule is half a step backward (implicit) and half a step forward (explicit) Euler; ω is such that the response at f
    is that of the analogue filter (prewarping), for the step at hand.
    """

    def __init__(self, tau: float) -> None:
        self.tau = tau
        self.start: list[NDArray[np.float64]] = []
        self.start_steps: list[float] = []
        self.state: NDArray[np.float64] | None = None

    def at(self, value: ArrayLike) -> None:
        """At rest at a value."""
        value = np.array(value, dtype=np.float64)
        self.state = np.array([np.zeros_like(value), value])

    def step(self, x: ArrayLike, dt: float) -> NDArray[np.float64]:
        """The filtered value of the sample x, dt after the one before."""
        x = np.array(x, dtype=np.float64)
        if self.state is None and self.tau > 0:
            # The mean, for the duration of tau.
            self.start.append(x)
            self.start_steps.append(dt)
            mean = np.mean(self.start, axis=0)
            if math.fsum(self.start_steps) >= self.tau:
                self.at(mean)
            return mean
        if self.tau <= 0 or self.tau < dt / 2:  # a cut-off above the Nyquist frequency
            self.at(x)
            return x
        assert self.state is not None
        g = math.tan(dt / (math.sqrt(2) * self.tau))  # ω dt/2
        slope = g * np.array([[-math.sqrt(2), -1.0], [1.0, 0.0]])
        drive = g * np.outer([1.0, 0.0], x)
        middle = np.linalg.solve(np.eye(2) - slope, self.state + drive)
        self.state = middle + slope @ middle + drive
        return middle[1]
