"""What a run is given, as arrays: a recording with its stamps, columns of data frames, dates, no gyroscope."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from ahrs_rs import _arrays, _plausible
from ahrs_rs._recording import Recording
from ahrs_rs._warnings import DataWarning

Inputs = tuple[Any, Any, Any, Any]


def inputs(name: str, gyroscope: bool, gyr: Any, acc: Any, mag: Any, t: Any, *, goes_on: bool) -> Inputs:
    """gyr, acc, mag and t for the native side.

    Parameters
    ----------
    name : of the filter, for messages.
    gyroscope : whether the filter cannot do without one.
    gyr, acc, mag, t : as `Filter.run` takes them; a `Recording` in place of gyr brings all of them.
    goes_on : whether the run goes on from a state.

    Raises
    ------
    ValueError
        What cannot be taken; the message names the argument.
    """
    if isinstance(gyr, Recording):
        if acc is not None or mag is not None or t is not None:
            given = next(key for key, value in (("acc", acc), ("mag", mag), ("t", t)) if value is not None)
            raise ValueError(f"{given}: expected None where a recording is given, which has its own")
        gyr, acc, mag, t = gyr.gyr, gyr.acc, gyr.mag, gyr.t
    else:
        _no_array(gyr)
        gyr, acc, mag = _arrays.vectors("gyr", gyr), _arrays.vectors("acc", acc), _arrays.vectors("mag", mag)
        t = _arrays.stamps(t, since=goes_on)
    return (gyr if gyr is not None else _no_gyroscope(name, gyroscope, acc)), acc, mag, t


def _no_array(gyr: Any) -> None:
    """Raise a ``ValueError`` that says what to do with a path or with several recordings."""
    if isinstance(gyr, (str, os.PathLike)):
        raise ValueError(f"gyr: expected an array or a Recording, got a path: give ar.read({str(gyr)!r})")
    if isinstance(gyr, (list, tuple)) and any(isinstance(each, Recording) for each in gyr):
        raise ValueError("gyr: expected one Recording, got several: ar.run_many(f, recordings) takes them")
    if isinstance(gyr, Mapping):
        raise ValueError(
            f"gyr: expected an array or a Recording, got a {type(gyr).__name__} of {', '.join(map(str, gyr))}"
        )


def attitude(q0: Any) -> Any:
    """A start as numbers: a rotation of scipy gives its quaternion."""
    return q0.as_quat()[..., [3, 0, 1, 2]] if q0 is not None and hasattr(q0, "as_quat") else q0


def _no_gyroscope(name: str, needed: bool, acc: Any) -> Any:
    """A gyroscope at rest, for the filters that turn by it only where the accelerometer has no sample."""
    if needed:
        raise ValueError(f"gyr: expected an array of real numbers, as {name} needs a gyroscope, got None")
    if acc is None:
        raise ValueError(f"acc: expected an array of real numbers, as {name} has no gyroscope, got None")
    array = np.asarray(acc)
    return np.zeros(array.shape, dtype=np.float32 if array.dtype == np.float32 else np.float64)


def doubt(gyr: Any, acc: Any, t: Any) -> None:
    """A `DataWarning` where arrays look as if they were in other units."""
    found = _plausible.doubts_of_run(gyr, acc, t)
    if found:
        warnings.warn("; ".join(found), DataWarning, stacklevel=3)
