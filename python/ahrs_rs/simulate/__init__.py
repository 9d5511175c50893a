"""Simulated recordings with exactly known truth.

>>> import ahrs_rs as ar
>>> ar.simulate.scenario("robot_arm", seed=1)
Recording(20334 samples, 40.666 s, 500 Hz, gyr acc mag ref)

A simulation has three parts: a motion (smooth functions of time, exactly differentiated), what an exact sensor that
follows it reads, and the errors of a real sensor. Everything random is drawn from a stream of its own of one seed, so
that changing one effect leaves all others as they are.

- `scenario(name, ...)` and `SCENARIOS`: what is there by name, the papers' protocols among it; `SENSORS` likewise.
- `record(motion, rate=, duration=, sensor=, ...)`: a motion and a sensor of your own.
- `demo(...)`: a hand-held sensor, the simulation that the command `ahrs-rs demo` shows.
"""

from ahrs_rs._constants import GRAVITY
from ahrs_rs.simulate._demo import CONSUMER_MEMS, SensorErrors, demo
from ahrs_rs.simulate._functions import (
    Function,
    Modulo,
    Piecewise,
    Polynomial,
    Sum,
    Waves,
    bumps,
    constant,
    moves,
    spline,
)
from ahrs_rs.simulate._magnetic import FIELD, Dipole, Disturbance, IronFloor, Switched
from ahrs_rs.simulate._motion import (
    Compound,
    EulerMotion,
    Motion,
    PacedMotion,
    SplineMotion,
    ThrustMotion,
    still,
)
from ahrs_rs.simulate._presets import SENSORS
from ahrs_rs.simulate._protocols import rotors
from ahrs_rs.simulate._record import Setup, Truth, record
from ahrs_rs.simulate._scenarios import SCENARIOS, Plan, Scenario, scenario
from ahrs_rs.simulate._sensor import Clock, Sensor, Temperature, Triad

__all__ = [
    "CONSUMER_MEMS",
    "FIELD",
    "GRAVITY",
    "SCENARIOS",
    "SENSORS",
    "Clock",
    "Compound",
    "Dipole",
    "Disturbance",
    "EulerMotion",
    "Function",
    "IronFloor",
    "Modulo",
    "Motion",
    "PacedMotion",
    "Piecewise",
    "Plan",
    "Polynomial",
    "Scenario",
    "Sensor",
    "SensorErrors",
    "Setup",
    "SplineMotion",
    "Sum",
    "Switched",
    "Temperature",
    "ThrustMotion",
    "Triad",
    "Truth",
    "Waves",
    "bumps",
    "constant",
    "demo",
    "moves",
    "record",
    "rotors",
    "scenario",
    "spline",
    "still",
]
