"""Whether readings can be those of an inertial sensor, and which unit they look like where they cannot."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._rate import median
from ahrs_rs._typing import FloatArray

#: Median norm of the specific force, m/s²: whoever carries a sensor is within it, whatever they do.
ACC = (2.0, 50.0)
#: 99 % quantile of the angular rate, rad/s (5730°/s: gyroscopes measure up to 4000°/s).
GYR = 100.0
#: Median norm of the magnetic field, µT: the earth's is 22 to 67; magnets and uncalibrated offsets are larger.
MAG = (1.0, 1000.0)
#: Norm of a field in units of the local one.
NORMALISED = (0.7, 1.5)
#: Hz
RATE = (1.0, 50e3)
#: s: beyond it a float32 cannot tell samples apart.
SINGLE = 1e6
#: s: the median step of stamps that are integers.
INTEGER_STEP = 1000.0
#: So many rows tell.
ROWS = 20000

#: How much smaller than ours a unit is, and its name: which of them a number looks like.
_TIME_UNITS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_MAG_UNITS = {"T": 1e6, "mT": 1e3, "gauss": 100.0, "nT": 1e-3}
#: The norm of the earth's field, µT.
_EARTH = (20.0, 75.0)


def doubt(name: str, values: NDArray[Any]) -> str | None:
    """What is wrong with the readings of a sensor: what they are and what they look like; None where nothing is.

    Parameters
    ----------
    name : "gyr", "acc" or "mag"
    values : (n, 3) in rad/s, m/s², µT.

    Returns
    -------
    str or None
        As "the median norm is 1.01 m/s², which looks like g", followed by the unit: see `likely_unit`.
    """
    found = _norms(values)
    if not found.size:
        return None
    if name == "gyr":
        fast = _fast(found)
        if fast > GYR:
            return f"an angular rate of {fast:.4g} rad/s (99 % of the rows are below) is that of no gyroscope"
        return None
    middle = median(found)
    low, high = ACC if name == "acc" else MAG
    unit = "m/s²" if name == "acc" else "µT"
    if low <= middle <= high or (name == "mag" and NORMALISED[0] <= middle <= NORMALISED[1]):
        return None
    sensor = "accelerometer" if name == "acc" else "magnetometer"
    return f"a median norm of {middle:.4g} {unit} is that of no {sensor}"


def likely_unit(name: str, values: NDArray[Any]) -> str | None:
    """The unit that the readings of `doubt` look like, or None."""
    found = _norms(values)
    middle = median(found)
    if name == "gyr":
        return "deg/s" if _fast(found) < 5000.0 else "mdps"
    if name == "acc":
        if 0.5 <= middle <= 2.0:
            return "g"
        return "mg" if 500.0 <= middle <= 2000.0 else None
    units = [unit for unit, size in _MAG_UNITS.items() if _EARTH[0] <= middle * size <= _EARTH[1]]
    return units[0] if units else None


def is_normalised(values: NDArray[Any]) -> bool:
    """Whether magnetic readings are in units of the local field: their median norm is about 1."""
    found = _norms(values)
    return bool(found.size) and NORMALISED[0] <= median(found) <= NORMALISED[1]


def doubtful_rate(rate: float) -> str | None:
    """What is wrong with a sampling rate (Hz), and the unit of time that it looks like; None where nothing is."""
    if RATE[0] <= rate <= RATE[1]:
        return None
    return f"a rate of {rate:.4g} Hz is that of no inertial sensor"


def likely_time_unit(rate: float) -> str | None:
    """The unit of time that makes a rate (Hz, stamps taken as s) one of an inertial sensor, or None."""
    units = [unit for unit, size in _TIME_UNITS.items() if 5.0 <= rate / size <= 20e3]
    return units[0] if units else None


def doubtful_stamps(t: NDArray[Any]) -> str | None:
    """What is wrong with stamps of a type that has no room for them, or with integers that cannot be seconds."""
    if t.dtype == np.float32 and t.size and float(np.nanmax(np.abs(t))) > SINGLE:
        largest = float(np.nanmax(np.abs(t)))
        room = float(np.spacing(np.float32(largest)))
        return (
            f"float32 has no room for {largest:.6g} s: its steps are {room:.3g} s (use float64, or take off the first)"
        )
    if t.dtype.kind in "iu" and t.size > 1:
        step = median(np.diff(t.astype(np.float64)))
        if step > INTEGER_STEP:
            unit = likely_time_unit(1.0 / step)
            looks = f", which looks like {unit}: divide by {1.0 / _TIME_UNITS[unit]:.0e}" if unit else ""
            return f"integers with a median step of {step:.6g} are no seconds{looks}"
    return None


def _fast(norms: FloatArray) -> float:
    """The 99 % quantile."""
    index = math.ceil(0.99 * (len(norms) - 1))
    return float(np.partition(norms, index)[index])


def _norms(values: NDArray[Any]) -> FloatArray:
    """Norms of some of the rows, evenly over all, those without NaN."""
    stride = max(math.ceil(len(values) / ROWS), 1)
    some = np.asarray(values[::stride], dtype=np.float64)
    with np.errstate(over="ignore"):
        norms = np.sqrt(np.einsum("ij,ij->i", some, some))
    known: FloatArray = norms[np.isfinite(norms)]
    return known


#: A run of fewer rows is not doubted: it tells nothing, and may be a trial.
FEWEST_ROWS = 100
#: Rows of a run that are looked at.
FEW = 48
#: rad/s: above it (median), a gyroscope is compared with the accelerometer, in so many rows.
FAST, PAIRS = 2.0, 2000
#: The accelerometer shows the turns of the gyroscope as π/180 of them, within these factors.
DEGREES_RATIO = (0.6, 1.6)


def doubts_of_run(gyr: Any, acc: Any, t: Any) -> list[str]:
    """What is doubtful about the units of arrays that are to be run, from a few of their rows.

    Parameters
    ----------
    gyr, acc : (T, 3) arrays, or anything else, which is not looked at.
    t : (T,) s, or None.
    """
    found = []
    if _are_rows(acc) and not _within(_squares(acc), *ACC):
        wrong = doubt("acc", _some(acc))
        likely = likely_unit("acc", _some(acc)) if wrong else None
        if likely:
            found.append(f"acc: {wrong}; it looks like {likely}")
    if type(t) is np.ndarray and t.ndim == 1 and len(t) >= FEWEST_ROWS and t[-1] > t[0]:
        rate = (len(t) - 1) / float(t[-1] - t[0])
        if doubtful_rate(rate):
            # A clock that leaps and rows that come in packets leave one of the two as it is.
            with np.errstate(invalid="ignore"):
                middle = median(np.diff(t))
            rate = 1.0 / middle if middle > 0.0 else rate
        wrong = doubtful_rate(rate)
        likely = likely_time_unit(rate) if wrong else None
        if likely:
            found.append(f"t: {wrong}; the stamps look like {likely}")
    if _are_rows(gyr):
        squares = _squares(gyr)
        usual = not squares.size or squares.item(-1) <= GYR * GYR
        wrong = None if usual else doubt("gyr", _some(gyr))
        if wrong is not None:
            found.append(f"gyr: {wrong}; it looks like {likely_unit('gyr', _some(gyr))}")
        elif type(t) is np.ndarray and not _within(squares, 0.0, FAST) and looks_like_degrees(gyr, acc, t):
            found.append("gyr: the accelerometer turns by π/180 of the angular rate, which looks like deg/s")
    return found


@np.errstate(over="ignore", invalid="ignore")
def looks_like_degrees(gyr: NDArray[Any], acc: NDArray[Any], t: FloatArray) -> bool:
    """Whether the accelerometer shows the turns of the gyroscope as π/180 of what they are as rad/s.

    The direction u of the specific force changes by -δ × u while the sensor turns by δ; the factor s of δ is fitted to
    all rows (least squares), with its standard error. Nothing is said where the turns do not show in the accelerometer.
    """
    if not (_are_rows(gyr) and _are_rows(acc) and len(gyr) == len(acc) == len(t)):
        return False
    norms = _norms(_some(gyr))
    if not norms.size or not median(norms) > FAST:
        return False
    pairs = np.arange(1, len(gyr), max(len(gyr) // PAIRS, 1))
    known = np.isfinite(np.hstack([gyr[pairs], acc[pairs], acc[pairs - 1]])).all(axis=1)
    pairs = pairs[known]
    if len(pairs) < FEWEST_ROWS:
        return False
    before, after = _directions(acc[pairs - 1]), _directions(acc[pairs])
    turns = np.asarray(gyr[pairs], dtype=np.float64) * (t[pairs] - t[pairs - 1])[:, np.newaxis]
    shown = np.cross(0.5 * (before + after), turns)
    energy = float(np.sum(shown * shown))
    if not energy > 0.0:
        return False
    factor = float(np.sum((after - before) * shown)) / energy
    rest = (after - before) - factor * shown
    error = math.sqrt(float(np.sum(rest * rest)) / (2 * len(pairs)) / energy)
    low, high = (part * np.pi / 180.0 for part in DEGREES_RATIO)
    return low <= factor <= high and error < 0.2 * np.pi / 180.0


def _directions(acc: NDArray[Any]) -> FloatArray:
    norms = np.linalg.norm(acc, axis=1, keepdims=True)
    return np.asarray(np.divide(acc, norms, out=np.zeros(acc.shape), where=norms > 0.0))


def _are_rows(values: Any) -> bool:
    rows = type(values) is np.ndarray and values.ndim == 2 and values.shape[1] == 3 and values.dtype.kind in "fiu"
    return rows and len(values) >= FEWEST_ROWS


def _squares(values: NDArray[Any]) -> FloatArray:
    """Squared norms of a few of the rows in order, those that are finite: for most runs no roots are needed."""
    some = np.asarray(_some(values), dtype=np.float64)
    squares: FloatArray = np.einsum("ij,ij->i", some, some)
    squares.sort()  # NaN last
    if not squares.item(-1) < math.inf:
        squares = squares[: squares.searchsorted(math.inf)]
    return squares


def _within(squares: FloatArray, low: float, high: float) -> bool:
    """Whether the middle of the norms is surely in a range; none at all is."""
    count = len(squares)
    return not count or (low * low <= squares.item((count - 1) // 2) and squares.item(count // 2) <= high * high)


def _some(values: NDArray[Any]) -> NDArray[Any]:
    return values[:: max(len(values) // FEW, 1)]
