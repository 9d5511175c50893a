"""Units of the quantities of a recording, as files and users spell them.

Units are compared by their letters and digits only, so that m/s², m/s^2, m_s2 and m s-2 are the same.
"""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np

from ahrs_rs._constants import GRAVITY

DEGREE = np.pi / 180.0


def _units(*groups: tuple[float, float, str]) -> dict[str, tuple[float, float]]:
    return {name: (factor, offset) for factor, offset, names in groups for name in names.split()}


_RAW = (1.0, 0.0, "raw lsb counts count adc int16 digits")
_VECTOR = (1.0, 0.0, "norm normalised normalized nounits")
#: Quantity -> unit, as letters and digits -> factor and offset to the unit of `Recording`.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "t": _units(
        (1.0, 0.0, "s sec secs second seconds"),
        (1e-3, 0.0, "ms msec msecs millis milli millisec millisecs millisecond milliseconds"),
        (1e-6, 0.0, "us usec usecs micros micro microsec microsecs microsecond microseconds"),
        (1e-9, 0.0, "ns nsec nsecs nanos nano nanosec nanosecs nanosecond nanoseconds"),
    ),
    "gyr": _units(
        (
            1.0,
            0.0,
            "rads rads1 radps radsec radpers radpersec radpersecond radianss radianssec radianssecond rad radians",
        ),
        (1e-3, 0.0, "mrads mradps mradsec"),
        (
            DEGREE,
            0.0,
            "dps degs degs1 degps degsec degpers degpersec degpersecond degreess degreessec degreessecond "
            "degreesps deg degrees degsecond",
        ),
        (1e-3 * DEGREE, 0.0, "mdps mdegs"),
        (np.pi / 30.0, 0.0, "rpm"),
        _RAW,
    ),
    "acc": _units(
        (1.0, 0.0, "ms2 mss mps2 mpss msec2 mpers2 mperssquared metress2 meterss2 mssquared"),
        (GRAVITY, 0.0, "g gn g0 gs gforce"),
        (1e-3 * GRAVITY, 0.0, "mg mgn millig millgs"),
        (1e-6 * GRAVITY, 0.0, "ug"),
        (1e-3, 0.0, "mms2"),
        _RAW,
    ),
    "mag": _units(
        (1.0, 0.0, "ut microtesla microteslas"),
        (1e-3, 0.0, "nt nanotesla nanoteslas"),
        (1e3, 0.0, "mt millitesla"),
        (1e6, 0.0, "t tesla"),
        (100.0, 0.0, "g gs gauss ga"),
        (0.1, 0.0, "mg mgauss milligauss mga mgs"),
        (1e-4, 0.0, "ugauss"),
        (1.0, 0.0, "au arbitrary localflux flux unit"),  # only the direction is known: kept as it is
        _VECTOR,
        _RAW,
    ),
    "temperature": _units(
        (1.0, 0.0, "c degc celsius degreesc degreescelsius deg"),
        (1.0, -273.15, "k kelvin"),
        (5.0 / 9.0, -160.0 / 9.0, "f degf fahrenheit"),
        (0.01, 0.0, "cdegc"),
        (1e-3, 0.0, "mdegc"),
    ),
    "pressure": _units(
        (1.0, 0.0, "pa pascal"), (100.0, 0.0, "hpa mbar"), (1e3, 0.0, "kpa"), (1e5, 0.0, "bar"), (101325.0, 0.0, "atm")
    ),
    "heading": _units((1.0, 0.0, "rad radians"), (DEGREE, 0.0, "deg degrees")),
    "ref": _units((1.0, 0.0, "1 au quat none")),
    "device_quat": _units((1.0, 0.0, "1 au quat none")),
    "mask": _units((1.0, 0.0, "bool")),
}
UNITS["linear_acceleration"] = UNITS["gravity"] = UNITS["acc"]

#: Quantity -> the unit that is assumed where a name tells none.
ASSUMED = {
    "t": "s",
    "gyr": "rad/s",
    "acc": "m/s²",
    "mag": "µT",
    "temperature": "°C",
    "pressure": "Pa",
    "heading": "rad",
}
ASSUMED |= {"linear_acceleration": "m/s²", "gravity": "m/s²"}

#: Units that say nothing about the size of a reading.
SIZELESS = frozenset(f"{_RAW[2]} {_VECTOR[2]} au arbitrary localflux flux unit".split())

_SIGNS = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "°": "deg",
        "º": "deg",
        "²": "2",
        "³": "3",
        "⁻": "-",
        "¹": "1",
        "·": " ",
        "⋅": " ",
        "℃": "degC",
        "\N{REPLACEMENT CHARACTER}": "deg",
    }
)


def plain(text: str) -> str:
    """The text with the signs of units in ASCII."""
    return text if text.isascii() else text.translate(_SIGNS)


@lru_cache(maxsize=1024)
def unit_key(unit: str) -> str:
    """The letters and digits of a unit, in lower case."""
    return re.sub(r"[^a-z0-9]", "", plain(unit).lower())


def is_unit(quantity: str, unit: str) -> bool:
    """Whether the quantity has such a unit, or a multiple of one."""
    return unit_key(_multiple(unit)[1]) in UNITS.get(quantity, {})


def _multiple(unit: str) -> tuple[float, str]:
    """The number before a unit (0.1 deg/s) and the unit; 1 where there is none."""
    found = re.fullmatch(r"\s*(\d*\.\d+|\d+\.?)(?:[eE]([-+]?\d+))?\s*[*·x]?\s+(\D.*)", unit)
    if found is None:
        return 1.0, unit
    return float(f"{found[1]}e{found[2] or 0}"), found[3]


#: How a unit is written that a name holds without signs (acc_x_m_s2).
_WRITTEN = {
    "t": ("s", "ms", "us", "ns"),
    "gyr": ("rad/s", "mrad/s", "deg/s", "mdps"),
    "acc": ("m/s²", "g", "mg"),
    "mag": ("µT", "nT", "mT", "T", "gauss", "mgauss"),
    "temperature": ("°C", "K"),
}


def written(quantity: str, unit: str) -> str:
    """A unit of the words of a name as one writes it."""
    known = UNITS.get(quantity, {})
    found = known.get(unit_key(unit))
    return next((one for one in _WRITTEN.get(quantity, ()) if known[unit_key(one)] == found), unit)


def conversion(quantity: str, unit: str) -> tuple[float, float]:
    """Factor and offset from a unit to that of `Recording`.

    Raises
    ------
    ValueError
        A quantity without units, or a unit that it does not have.
    """
    if quantity not in UNITS:
        raise ValueError(f"units: expected quantities among {', '.join(UNITS)}, got {quantity!r}")
    known = UNITS[quantity]
    number, single = _multiple(unit) if isinstance(unit, str) else (1.0, "")
    if unit_key(single) not in known or not 0.0 < number < np.inf:
        raise ValueError(f"units: unknown unit {unit!r} of {quantity}; known are {', '.join(sorted(known))}")
    factor, offset = known[unit_key(single)]
    return number * factor, offset
