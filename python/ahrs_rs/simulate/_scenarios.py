"""The registry of scenarios: what is simulated by name, by the command line and by the tests.

A scenario is a function in `protocols` that says what moves how, and one line of its own there; its keyword
arguments are its parameters, and its docstring tells about them.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ahrs_rs._recording import Recording
from ahrs_rs._validate import did_you_mean
from ahrs_rs.simulate._magnetic import Disturbance
from ahrs_rs.simulate._motion import Motion
from ahrs_rs.simulate._presets import SENSORS
from ahrs_rs.simulate._record import RATES, Intervals, Setup, Truth, check_positive, check_seed
from ahrs_rs.simulate._sensor import PerAxis, Sensor, Temperature


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What a scenario answers: the motion, how long it takes by itself, and what happens when.

    Parameters
    ----------
    motion : Motion
        What the sensor follows.
    duration : float
        S, unless another one is asked for.
    disturbances : tuple of Disturbance, optional
        Of the magnetic field.
    scored : sequence of tuple, optional
        Intervals in s of the samples that count; None: all of them.
    phases : mapping, optional
        Name -> intervals in s.
    temperature : Temperature, optional
        Of the sensor, in place of its own.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.simulate.Plan(motion=ar.simulate.still(), duration=10.0).duration
    10.0
    """

    motion: Motion
    duration: float
    disturbances: tuple[Disturbance, ...] = ()
    scored: Intervals | None = None
    phases: Mapping[str, Intervals] = field(default_factory=dict)
    temperature: Temperature | None = None


Value = float | str | bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One scenario: call it for a recording.

    Parameters
    ----------
    name : str
        In the registry.
    make : callable
        (seed, duration, **params) -> Plan; duration None is its own.
    rate : float
        Default, Hz.
    sensor : str
        Default, a name of `SENSORS`.
    remaining : float
        Default, see `setup`.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.simulate.SCENARIOS["static"].rate
    100.0
    >>> len(ar.simulate.SCENARIOS["static"](duration=1.0, seed=1))
    100
    """

    name: str
    make: Callable[..., Plan]
    rate: float
    sensor: str
    remaining: float

    @property
    def params(self) -> dict[str, Value]:
        """Parameter -> default."""
        signature = inspect.signature(self.make).parameters.values()
        return {one.name: one.default for one in signature if one.kind is one.KEYWORD_ONLY}

    @property
    def doc(self) -> str:
        """What it is, and its parameters."""
        return inspect.cleandoc(self.make.__doc__ or "")

    def setup(
        self,
        *,
        rate: float | None = None,
        duration: float | None = None,
        seed: int = 0,
        sensor: str | Sensor | None = None,
        remaining: float | None = None,
        gyr_bias: PerAxis = 0.0,
        rates: str = RATES[0],
        **params: Value,
    ) -> Setup:
        """The experiment, of which `record(seed)` makes recordings.

        Parameters
        ----------
        rate : float, optional
            Hz; None: the scenario's.
        duration : float, optional
            S; None: as long as the scenario takes. Longer: it rests at its end, where it has one.
        seed : int, optional
            Of a random motion.
        sensor : str or Sensor, optional
            A name of `SENSORS`, or one of your own; None: the scenario's.
        remaining : float, optional
            Part of the errors that a calibration takes away (biases, scale, misalignment, temperature)
            which is still there: 0 after a perfect calibration, 1 without any; None: the scenario's, or
            1 for a sensor of your own.
        gyr_bias : float or sequence of float, optional
            Rad/s, a constant bias that is added to the gyroscope's after all: one number for all axes,
            or three.
        rates : str, optional
            "mean" or "instantaneous", see `Setup`.
        **params : float, str or bool
            The scenario's own.

        Returns
        -------
        Setup
            The experiment.
        """
        check_seed(seed)
        for name, value in (("rate", rate), ("duration", duration)):
            if value is not None:
                check_positive(name, value)
        unknown = [name for name in params if name not in self.params]
        if unknown:
            known = ", ".join(self.params) or "none"
            hint = did_you_mean(unknown[0], self.params)
            raise ValueError(f"{self.name} has no parameter {unknown[0]!r}{hint}; there are {known}")
        for name, given in params.items():
            if isinstance(self.params[name], str) != isinstance(given, str):
                raise ValueError(f"{name}: expected a value like {self.params[name]!r}, got {given!r}")
            if not isinstance(given, str) and not math.isfinite(given):
                raise ValueError(f"{name}: expected a finite number, got {given}")
        plan = self.make(seed, duration, **params)
        own = isinstance(sensor, Sensor)
        chosen = sensor if isinstance(sensor, Sensor) else find_sensor(self.sensor if sensor is None else sensor)
        part = remaining if remaining is not None else 1.0 if own else self.remaining
        if part != 1.0:
            chosen = chosen.calibrated(part)
        chosen = chosen.with_gyr_bias(gyr_bias)
        if plan.temperature is not None:
            chosen = replace(chosen, temperature=plan.temperature)
        return Setup(
            motion=plan.motion,
            rate=self.rate if rate is None else rate,
            duration=plan.duration if duration is None else duration,
            sensor=chosen,
            disturbances=plan.disturbances,
            rates=rates,
            scored=plan.scored,
            phases=plan.phases,
            name=self.name,
        )

    def __call__(self, *, seed: int = 0, **options: Any) -> Recording:
        """A recording; the options are those of `setup`."""
        return self.setup(seed=seed, **options).record(seed)

    def with_truth(self, *, seed: int = 0, **options: Any) -> tuple[Recording, Truth]:
        """The recording, and the truth of every row.

        Parameters
        ----------
        seed : int, optional
            Of motion and errors.
        **options : object
            Those of `setup`.

        Returns
        -------
        tuple
            The recording, and what no sensor knows.
        """
        return self.setup(seed=seed, **options).record_with_truth(seed)


#: Name -> scenario.
SCENARIOS: dict[str, Scenario] = {}


def registered(
    *, rate: float, sensor: str, remaining: float = 1.0
) -> Callable[[Callable[..., Plan]], Callable[..., Plan]]:
    """Enter a function into the registry under its own name."""

    def enter(make: Callable[..., Plan]) -> Callable[..., Plan]:
        name = make.__name__
        SCENARIOS[name] = Scenario(name=name, make=make, rate=rate, sensor=sensor, remaining=remaining)
        return make

    return enter


def find_sensor(name: str) -> Sensor:
    """The sensor of that name."""
    if name not in SENSORS:
        raise ValueError(f"sensor: unknown {name!r}; there are {', '.join(SENSORS)}")
    return SENSORS[name]


def scenario(name: str, *, seed: int = 0, **options: Any) -> Recording:
    """A recording of the scenario of that name; the options are those of `Scenario.setup`.

    Parameters
    ----------
    name : str
        Of `SCENARIOS`.
    seed : int, optional
        Of motion and errors.
    **options : object
        Those of `Scenario.setup`.

    Returns
    -------
    Recording
        With its exact orientation.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.simulate.scenario("static", duration=1.0).rate
    100.0
    """
    if name not in SCENARIOS:
        raise ValueError(f"scenario: unknown {name!r}; there are {', '.join(SCENARIOS)}")
    return SCENARIOS[name](seed=seed, **options)
