"""Magnetic fields in µT: the earth's, and what disturbs it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ahrs_rs._typing import FloatArray

DEGREE = math.pi / 180.0

#: Earth's field in ENU, µT: 50 µT, 60° below the horizontal, north on y.
FIELD = 50.0 * np.array([0.0, math.cos(60.0 * DEGREE), -math.sin(60.0 * DEGREE)])

Vector = tuple[float, float, float]


class Disturbance(Protocol):
    """A field that is added to the earth's.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> class Steady:
    ...     def field(self, t, position, generator):
    ...         return np.tile([5.0, 0.0, 0.0], (len(t), 1))
    >>> steady: ar.simulate.Disturbance = Steady()
    >>> steady.field(np.zeros(1), np.zeros((1, 3)), np.random.default_rng(0))
    array([[5., 0., 0.]])
    """

    @property
    def frame(self) -> str:
        """ "earth": the field is in ENU; "sensor": it is in the sensor's axes and turns with it."""
        ...

    def field(self, t: FloatArray, position: FloatArray, generator: np.random.Generator) -> FloatArray:
        """The field at times and positions; called for one block of rows after the other.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        position : ndarray
            (T, 3) of the sensor in m, ENU.
        generator : numpy.random.Generator
            Of what is random.

        Returns
        -------
        ndarray
            (T, 3) µT.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Dipole:
    """A magnet or a piece of iron somewhere, as a magnetic dipole.

    Parameters
    ----------
    position : sequence of float
        M in ENU.
    moment : sequence of float
        A·m² in ENU. A steel chair or radiator has some 1 to 10, a loudspeaker 0.5.
    radius : float, optional
        M; nearer than this the field is that at the radius.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> magnet = ar.simulate.Dipole(position=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 1.0))
    >>> magnet.field(np.zeros(1), np.array([[0.0, 0.0, 1.0]]), np.random.default_rng(0)).round(6)
    array([[0. , 0. , 0.2]])
    """

    position: Vector
    moment: Vector
    radius: float = 0.1

    @property
    def frame(self) -> str:
        """The field is in ENU."""
        return "earth"

    def field(self, t: FloatArray, position: FloatArray, generator: np.random.Generator) -> FloatArray:
        """The field at times and positions.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        position : ndarray
            (T, 3) of the sensor in m, ENU.
        generator : numpy.random.Generator
            Of what is random.

        Returns
        -------
        ndarray
            (T, 3) µT.
        """
        away = position - self.position
        distance = np.linalg.norm(away, axis=1, keepdims=True)
        unit = away / np.maximum(distance, 1e-9)
        moment = np.array(self.moment)
        along = (unit @ moment)[:, None]
        field: FloatArray = 0.1 * (3.0 * along * unit - moment) / np.maximum(distance, self.radius) ** 3
        return field


@dataclass(frozen=True, slots=True, kw_only=True)
class Switched:
    """A field in the sensor's axes that is switched on and off, as by a motor or gripper that the sensor is fixed to.

    Parameters
    ----------
    amplitude : sequence of float
        ΜT, in the sensor's axes.
    period : float, optional
        S, of which the field is on for the part `duty`, at first.
    duty : float, optional
        0 to 1.
    start, end : float, optional
        S, between which it is switched; off before and after.
    rise : float, optional
        Time constant in s of the current in the coil, 0: at once.
    noise : float, optional
        Standard deviation of white noise on each axis while it is on, µT.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> motor = ar.simulate.Switched(amplitude=(5.0, 0.0, 0.0), period=2.0)
    >>> motor.level(np.array([0.5, 1.5]))
    array([1., 0.])
    """

    amplitude: Vector
    period: float = 1.0
    duty: float = 0.5
    start: float = 0.0
    end: float = math.inf
    rise: float = 0.0
    noise: float = 0.0

    @property
    def frame(self) -> str:
        """The field turns with the sensor."""
        return "sensor"

    def field(self, t: FloatArray, position: FloatArray, generator: np.random.Generator) -> FloatArray:
        """The field at times and positions.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        position : ndarray
            (T, 3) of the sensor in m, ENU.
        generator : numpy.random.Generator
            Of what is random.

        Returns
        -------
        ndarray
            (T, 3) µT.
        """
        level = self.level(t)
        field: FloatArray = level[:, None] * np.array(self.amplitude)
        if self.noise > 0.0:
            field += (level * self.noise)[:, None] * generator.standard_normal((len(t), 3))
        return field

    def level(self, t: FloatArray) -> FloatArray:
        """How far it is on.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T,) 0 to 1.
        """
        since = np.minimum(t, self.end) - self.start
        cycle = np.floor(since / self.period)
        phase = since - cycle * self.period
        on = self.duty * self.period
        if self.rise <= 0.0:
            return ((phase < on) & (t >= self.start) & (t < self.end)).astype(np.float64)
        # Charging and discharging by 1 - e^(-x); the level at the start of a cycle is a geometric sum.
        gain, keep = -math.expm1(-on / self.rise), math.exp(-self.period / self.rise)
        rest = math.exp(-(self.period - on) / self.rise)
        base = gain * rest * (1.0 - keep ** np.maximum(cycle, 0.0)) / (1.0 - keep)
        charged = 1.0 + (base - 1.0) * np.exp(-np.minimum(phase, on) / self.rise)
        level = charged * np.exp(-np.maximum(phase - on, 0.0) / self.rise)
        level = level * np.exp(-np.maximum(t - self.end, 0.0) / self.rise)
        return np.where(t >= self.start, level, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class IronFloor:
    """The uneven field of a building: iron in the floor, as a random field without sources above it.

    The field is the gradient of a harmonic potential, a sum of waves over the floor that die out with height.

    Parameters
    ----------
    deviation : float, optional
        Root mean square of the field's norm at the height z = 0, µT.
    length : float, optional
        Wavelength over the floor, m; the waves have half to twice of it.
    seed : int, optional
        Of the waves.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> floor = ar.simulate.IronFloor(deviation=5.0, seed=1)
    >>> floor.field(np.zeros(2), np.zeros((2, 3)), np.random.default_rng(0)).shape
    (2, 3)
    """

    deviation: float = 5.0
    length: float = 3.0
    seed: int = 0

    @property
    def frame(self) -> str:
        """The field is in ENU."""
        return "earth"

    def field(self, t: FloatArray, position: FloatArray, generator: np.random.Generator) -> FloatArray:
        """The field at times and positions.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.
        position : ndarray
            (T, 3) of the sensor in m, ENU.
        generator : numpy.random.Generator
            Of what is random.

        Returns
        -------
        ndarray
            (T, 3) µT.
        """
        draw = np.random.default_rng(self.seed)
        waves = 16
        number = 2.0 * math.pi / (self.length * 2.0 ** draw.uniform(-1.0, 1.0, waves))
        direction, phase = draw.uniform(0.0, 2.0 * math.pi, (2, waves))
        field = np.zeros((len(position), 3))
        for k, angle, shift in zip(number, direction, phase, strict=True):
            along = np.array([math.cos(angle), math.sin(angle)])
            place = k * (position[:, :2] @ along) + shift
            # Of a wave's mean square, half is on the horizontal and half on the vertical component.
            size = self.deviation * math.sqrt(1.0 / waves) * np.exp(-k * position[:, 2])
            field[:, :2] += (size * np.sin(place))[:, None] * along
            field[:, 2] += size * np.cos(place)
        return field
