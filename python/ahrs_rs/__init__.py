"""Attitude and heading from gyroscope, accelerometer and magnetometer.

>>> import numpy as np
>>> import ahrs_rs as ar
>>> f = ar.Madgwick(rate=100.0, beta=0.041)
>>> est = f.run(gyr=np.zeros((50, 3)), acc=np.tile([0.0, 0.0, 9.81], (50, 1)))
>>> est.quat[-1]
array([1., 0., 0., 0.])

Quaternions are scalar-first, of unit norm, and rotate from the sensor frame to the earth frame (east-north-up unless
asked otherwise). Angular rates are in rad/s, specific forces in m/s² (at rest, z up, +9.81 on z), magnetic fields in
µT. ``ar.FILTERS`` has every filter by name; ``ar.read`` reads recordings.
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from ahrs_rs import filters, metrics
from ahrs_rs._estimate import Estimate
from ahrs_rs._filter import Filter
from ahrs_rs._finished import Finished
from ahrs_rs._own import OwnFilter, register
from ahrs_rs._param import Param
from ahrs_rs._recording import Recording
from ahrs_rs._run_many import run_many
from ahrs_rs._state import State
from ahrs_rs._status import Status
from ahrs_rs._sweep import Sweep, SweepInterrupted, sweep
from ahrs_rs._version import __version__ as __version__
from ahrs_rs._warnings import DataWarning
from ahrs_rs.filters import *  # noqa: F403  # the classes are made from the registry
from ahrs_rs.filters import FILTERS as FILTERS
from ahrs_rs.io import read, read_all, sensors

if _TYPE_CHECKING:
    from ahrs_rs import attitude, calibration, chain, earth, papers, plots, rotation, signal, simulate, tuning
    from ahrs_rs._check import Finding, Report, check
    from ahrs_rs._reference import join_reference
    from ahrs_rs._view import View, view
    from ahrs_rs.io import write_estimate

#: Submodules that are imported where they are first used, so that the package itself is there at once.
_LATER = ("attitude", "calibration", "chain", "earth", "papers", "plots", "rotation", "signal", "simulate", "tuning")
#: The same for functions and classes: name -> module.
_LATER_FUNCTIONS = {
    "Finding": "_check",
    "Report": "_check",
    "View": "_view",
    "check": "_check",
    "join_reference": "_reference",
    "view": "_view",
    "write_estimate": "io",
}

__all__ = [
    "DataWarning",
    "Estimate",
    "Filter",
    "Finding",
    "Finished",
    "OwnFilter",
    "Param",
    "Recording",
    "Report",
    "State",
    "Status",
    "Sweep",
    "SweepInterrupted",
    "View",
    "attitude",
    "calibration",
    "chain",
    "check",
    "earth",
    "filters",
    "join_reference",
    "metrics",
    "papers",
    "plots",
    "read",
    "read_all",
    "register",
    "rotation",
    "run_many",
    "sensors",
    "signal",
    "simulate",
    "sweep",
    "tuning",
    "view",
    "write_estimate",
]
__all__ += filters.__all__


def __getattr__(name: str) -> object:
    if name in _LATER_FUNCTIONS:
        return getattr(_import_module(f"{__name__}.{_LATER_FUNCTIONS[name]}"), name)
    if name in _LATER:
        return _import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATER, *_LATER_FUNCTIONS})
