"""What a real sensor does to the true quantities: the parameters, as frozen dataclasses in SI units.

A triad of axes reads, with the temperature's distance ΔT from its reference, the specific force f and noise n,

    y = round(clip((M + diag(gain_slope) ΔT) x + b + bias_slope ΔT + drift + G f + n))

where M = matrix + drawn scale and misalignment, b = bias + drawn bias, and G f is the gyroscope's only. Every
number is one for all axes, or three; all are zero where not given, so that `Triad()` is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs._typing import FloatArray

#: One number for all three axes, or three.
PerAxis: TypeAlias = float | tuple[float, float, float]
Matrix: TypeAlias = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
#: One correlation time a decade: together close to flicker noise from 1 s to the hour.
DECADES = (1.0, 10.0, 100.0, 1000.0)

_NOT_NEGATIVE = (
    "density",
    "noise",
    "bias_deviation",
    "instability",
    "random_walk",
    "scale_deviation",
    "misalignment_deviation",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Triad:
    """The errors of three axes; "unit" is rad/s, m/s² or µT.

    Parameters
    ----------
    density : float or sequence of float, optional
        One-sided density of white noise, unit/√Hz, as data sheets give it: a sample at f Hz has the
        standard deviation density · √(f/2), the angle random walk is density/√2, the Allan
        deviation at τ is density/√(2τ).
    noise : float or sequence of float, optional
        Standard deviation of further white noise that does not depend on the rate, unit.
    bias : float or sequence of float, optional
        Constant, unit.
    bias_deviation : float or sequence of float, optional
        Standard deviation of a constant bias that is drawn for every recording and added, unit.
    instability : float or sequence of float, optional
        Coefficient B of flicker noise (IEEE Std 952: the Allan deviation's floor is 0.664 B), unit.
    instability_times : tuple of float, optional
        Correlation times of the first-order Gauss-Markov processes, in s and rising by a constant
        factor, that make the flicker noise between the shortest and the longest. One time: a single
        process whose Allan deviation has its largest value, 0.664 B, at 1.89 times it.
    random_walk : float or sequence of float, optional
        Of the rate: the drift grows by random_walk · √s in s seconds, unit/√s. Starts at zero.
    matrix : array_like, optional
        Scale, misalignment and soft iron, (3, 3); the identity does nothing.
    scale_deviation : float or sequence of float, optional
        Of a scale error of each axis drawn for every recording, 1.
    misalignment_deviation : float, optional
        Of each other element of the matrix, drawn too, rad.
    gain_slope : float or sequence of float, optional
        Change of the gain per °C, 1/°C.
    bias_slope : float or sequence of float, optional
        Change of the bias per °C, unit/°C.
    reference_temperature : float, optional
        Where both slopes have no effect, °C.
    range : float, optional
        Readings beyond ±range are cut, unit. None: no limit.
    resolution : float, optional
        Step of the readings, unit. 0: exact.
    rate : float, optional
        Hz, of a sensor slower than the recording; the rows in between are NaN. None: every row. Not
        for gyroscopes.
    dropout : float, optional
        Part of the rows that are missing (NaN), 0 to 1.
    dropout_length : float, optional
        Mean number of rows that are missing together.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.simulate.Triad(bias=0.01).calibrated(0.5).bias
    0.005
    """

    density: PerAxis = 0.0
    noise: PerAxis = 0.0
    bias: PerAxis = 0.0
    bias_deviation: PerAxis = 0.0
    instability: PerAxis = 0.0
    instability_times: tuple[float, ...] = DECADES
    random_walk: PerAxis = 0.0
    matrix: Matrix = IDENTITY
    scale_deviation: PerAxis = 0.0
    misalignment_deviation: float = 0.0
    gain_slope: PerAxis = 0.0
    bias_slope: PerAxis = 0.0
    reference_temperature: float = 25.0
    range: float | None = None
    resolution: float = 0.0
    rate: float | None = None
    dropout: float = 0.0
    dropout_length: float = 1.0

    def __post_init__(self) -> None:
        for one in ("density", "noise", "bias", "bias_deviation", "instability", "random_walk", "scale_deviation"):
            _set(self, one, _per_axis(one, getattr(self, one), negative=one not in _NOT_NEGATIVE))
        for one in ("gain_slope", "bias_slope"):
            _set(self, one, _per_axis(one, getattr(self, one), negative=True))
        _set(self, "matrix", _matrix("matrix", self.matrix))
        _set(self, "instability_times", tuple(float(time) for time in self.instability_times))
        times = self.instability_times
        if not times or any(not (math.isfinite(a) and a > 0.0) for a in times) or list(times) != sorted(set(times)):
            raise ValueError(f"instability_times: expected increasing positive numbers of s, got {times}")
        factors = [b / a for a, b in pairwise(times)]
        if factors and max(factors) > 1.001 * min(factors):
            raise ValueError(f"instability_times: expected times that rise by a constant factor, got {times}")
        _number("misalignment_deviation", self.misalignment_deviation, 0.0)
        _set(self, "misalignment_deviation", float(self.misalignment_deviation))
        _number("reference_temperature", self.reference_temperature)
        _number("resolution", self.resolution, 0.0)
        _number("dropout_length", self.dropout_length, 1.0)
        _number("dropout", self.dropout, 0.0, 1.0)
        for one in ("range", "rate"):
            value = getattr(self, one)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{one}: expected a positive number or None, got {value}")

    def calibrated(self, remaining: float = 0.0) -> Triad:
        """With a part of what a calibration takes away: biases, scale, misalignment, temperature; noise and drift stay.

        With `remaining` 0 the calibration was perfect, with 1 there was none.

        Parameters
        ----------
        remaining : float, optional
            Part of the errors that is still there, 0 to 1.

        Returns
        -------
        Triad
            Other errors.
        """
        _number("remaining", remaining, 0.0, 1.0)
        scaled = ("bias", "bias_deviation", "scale_deviation", "misalignment_deviation", "gain_slope", "bias_slope")
        matrix = np.eye(3) + remaining * (np.array(self.matrix) - np.eye(3))
        return replace(
            self,
            **{one: np.multiply(remaining, getattr(self, one)) for one in scaled},
            matrix=_matrix("matrix", matrix),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Temperature:
    """The sensor's temperature, °C: from `start` to `end` as a body warms up, with a time constant in s.

    `noise` (°C) and `resolution` (°C) are those of the thermometer, that is of `Recording.temperature`.

    Parameters
    ----------
    start : float, optional
        °C at the beginning.
    end : float, optional
        °C that it tends to.
    time_constant : float, optional
        s.
    noise : float, optional
        Standard deviation of a reading, °C.
    resolution : float, optional
        Step of a reading, °C; 0: none.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> t = ar.simulate.Temperature(start=20.0, end=40.0, time_constant=600.0)
    >>> t.at(np.array([0.0, 600.0])).round(2)
    array([20.  , 32.64])
    """

    start: float = 25.0
    end: float = 25.0
    time_constant: float = 600.0
    noise: float = 0.0
    resolution: float = 0.0

    def __post_init__(self) -> None:
        for one in ("start", "end"):
            _number(one, getattr(self, one))
        if not (math.isfinite(self.time_constant) and self.time_constant > 0.0):
            raise ValueError(f"time_constant: expected a positive number of s, got {self.time_constant}")
        _number("noise", self.noise, 0.0)
        _number("resolution", self.resolution, 0.0)

    def at(self, t: FloatArray) -> FloatArray:
        """The temperature; the body starts to warm up at zero.

        Parameters
        ----------
        t : ndarray
            (T,) times in s.

        Returns
        -------
        ndarray
            (T,) °C.
        """
        temperature: FloatArray = self.end + (self.start - self.end) * np.exp(-np.maximum(t, 0.0) / self.time_constant)
        return temperature

    def read(self, temperature: FloatArray, generator: np.random.Generator) -> FloatArray:
        """What the thermometer says.

        Parameters
        ----------
        temperature : ndarray
            (T,) °C.
        generator : numpy.random.Generator
            Of the noise.

        Returns
        -------
        ndarray
            (T,) °C.
        """
        said = temperature + self.noise * generator.standard_normal(len(temperature))
        return self.resolution * np.rint(said / self.resolution) if self.resolution > 0.0 else said


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """When samples are taken, and what stamps they get.

    Parameters
    ----------
    jitter : float, optional
        Standard deviation of a sample's time about its nominal time, in parts of the step; cut at
        0.45 of a step, so that the order stays. At most 0.25.
    stamps : str, optional
        "true": `t` holds the true times; "nominal": `t` counts on evenly, and does not know of the
        jitter.
    lost : float, optional
        Part of the rows that are lost; the others keep their stamps. 0 to 1.
    lost_length : float, optional
        Mean number of rows that are lost together.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.simulate.Clock(jitter=0.001).jitter
    0.001
    """

    jitter: float = 0.0
    stamps: str = "true"
    lost: float = 0.0
    lost_length: float = 1.0

    def __post_init__(self) -> None:
        _number("jitter", self.jitter, 0.0, 0.25)
        if self.stamps not in ("true", "nominal"):
            raise ValueError(f"stamps: expected 'true' or 'nominal', got {self.stamps!r}")
        _number("lost", self.lost, 0.0, 1.0)
        _number("lost_length", self.lost_length, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A gyroscope, an accelerometer and perhaps a magnetometer, read by one clock.

    Parameters
    ----------
    gyr, acc, mag : Triad, optional
        Their errors; mag None: there is no magnetometer.
    g_sensitivity : float or array_like, optional
        Of the gyroscope to the specific force, rad/s per m/s²: one number for all axes, each to its
        own component, or a matrix (3, 3).
    mag_delay : float, optional
        How late the magnetometer's readings come, s.
    temperature : Temperature, optional
        None: it stays at every triad's reference.
    clock : Clock, optional
        Sampling times.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> s = ar.simulate.Sensor(gyr=ar.simulate.Triad(bias=0.01))
    >>> s.calibrated().gyr.bias
    0.0
    """

    gyr: Triad = field(default_factory=Triad)
    acc: Triad = field(default_factory=Triad)
    mag: Triad | None = field(default_factory=Triad)
    g_sensitivity: float | Matrix = 0.0
    mag_delay: float = 0.0
    temperature: Temperature | None = None
    clock: Clock = field(default_factory=Clock)

    def __post_init__(self) -> None:
        types = (("gyr", Triad), ("acc", Triad), ("clock", Clock))
        for one, kind in types:
            if not isinstance(getattr(self, one), kind):
                raise ValueError(f"{one}: expected a {kind.__name__}, got {getattr(self, one)!r}")
        if not isinstance(self.mag, Triad | None):
            raise ValueError(f"mag: expected a Triad or None, got {self.mag!r}")
        if not isinstance(self.temperature, Temperature | None):
            raise ValueError(f"temperature: expected a Temperature or None, got {self.temperature!r}")
        if self.gyr.rate is not None:
            raise ValueError(f"gyr.rate: a gyroscope is read in every row, got {self.gyr.rate}")
        if isinstance(self.g_sensitivity, (int, float)):
            _number("g_sensitivity", self.g_sensitivity)
        else:
            _set(self, "g_sensitivity", _matrix("g_sensitivity", self.g_sensitivity))
        _number("mag_delay", self.mag_delay, 0.0)

    def calibrated(self, remaining: float = 0.0) -> Sensor:
        """As after a calibration: noise, drift, range, resolution, rates and delays stay; see `Triad.calibrated`.

        Parameters
        ----------
        remaining : float, optional
            Part of the errors that is still there, 0 to 1.

        Returns
        -------
        Sensor
            Another sensor.
        """
        mag = None if self.mag is None else self.mag.calibrated(remaining)
        gyr, acc = self.gyr.calibrated(remaining), self.acc.calibrated(remaining)
        crosstalk = np.multiply(remaining, self.g_sensitivity)
        return replace(
            self,
            gyr=gyr,
            acc=acc,
            mag=mag,
            g_sensitivity=float(crosstalk) if crosstalk.ndim == 0 else _matrix("g_sensitivity", crosstalk),
        )

    def with_gyr_bias(self, bias: PerAxis) -> Sensor:
        """With a further constant bias of the gyroscope, rad/s: one number for all axes, or three.

        Parameters
        ----------
        bias : float or sequence of float
            Rad/s: one number for all axes, or three.

        Returns
        -------
        Sensor
            Another sensor.
        """
        added = np.broadcast_to(self.gyr.bias, 3) + np.broadcast_to(_per_axis("bias", bias, negative=True), 3)
        return replace(self, gyr=replace(self.gyr, bias=tuple(added.tolist())))


def _set(one: object, name: str, value: object) -> None:
    object.__setattr__(one, name, value)


def _number(name: str, value: float, least: float = -math.inf, most: float = math.inf) -> None:
    try:
        good = math.isfinite(value) and least <= value <= most
    except TypeError:
        good = False
    if not good:
        bounds = (
            "" if least == -math.inf else f" from {least:g}" if most == math.inf else f" from {least:g} to {most:g}"
        )
        raise ValueError(f"{name}: expected a finite number{bounds}, got {value!r}")


def _per_axis(name: str, value: ArrayLike, *, negative: bool) -> PerAxis:
    expected = "a finite number" if negative else "a finite number that is not negative"
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected {expected}, or three, got {value!r}") from None
    if array.shape not in ((), (3,)) or not np.isfinite(array).all() or (not negative and (array < 0.0).any()):
        raise ValueError(f"{name}: expected {expected}, or three, got {value!r}")
    if array.shape == ():
        return float(array)
    return (float(array[0]), float(array[1]), float(array[2]))


def _matrix(name: str, value: ArrayLike) -> Matrix:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected a (3, 3) array of numbers, got {value!r}") from None
    if array.shape != (3, 3) or not np.isfinite(array).all():
        raise ValueError(f"{name}: expected a (3, 3) array of finite numbers, got {value!r}")
    x, y, z = ((float(row[0]), float(row[1]), float(row[2])) for row in array)
    return (x, y, z)


def as_dict(sensor: Sensor) -> dict[str, object]:
    """The parameters that differ from an exact sensor's, for a recording's meta."""
    out: dict[str, object] = {}
    for one in fields(sensor):
        value = getattr(sensor, one.name)
        if isinstance(value, (Triad, Temperature, Clock)):
            plain = type(value)()
            given = {f.name: getattr(value, f.name) for f in fields(value)}
            value = {name: v for name, v in given.items() if v != getattr(plain, name)}
        out[one.name] = value
    return out
