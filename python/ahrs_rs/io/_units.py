"""Units of the quantities of a recording, as files and users spell them.

Units are compared by their letters and digits only, so that m/s², m/s^2, m_s2 and m s-2 are the same.
"""

from __future__ import annotations

import re

import numpy as np

#: Standard gravity, m/s².
GRAVITY = 9.80665
DEGREE = np.pi / 180.0


def _units(*groups: tuple[float, float, str]) -> dict[str, tuple[float, float]]:
    return {name: (factor, offset) for factor, offset, names in groups for name in names.split()}


#: Quantity -> unit, as letters and digits -> factor and offset to the unit of `Recording`.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "t": _units(
        (1.0, 0.0, "s sec secs second seconds"),
        (1e-3, 0.0, "ms msec millis millisecond milliseconds"),
        (1e-6, 0.0, "us usec micros microsecond microseconds"),
        (1e-9, 0.0, "ns nsec nanos nanosecond nanoseconds"),
    ),
    "gyr": _units(
        (1.0, 0.0, "rads rads1 radps radsec radpersec radianss radianssec radianssecond"),
        (1e-3, 0.0, "mrads mradps"),
        (DEGREE, 0.0, "dps degs degs1 degps degsec degpersec degreess degreessec degreessecond"),
        (1e-3 * DEGREE, 0.0, "mdps mdegs"),
    ),
    "acc": _units(
        (1.0, 0.0, "ms2 mss mps2 mpss msec2"),
        (GRAVITY, 0.0, "g gn g0 gs"),
        (1e-3 * GRAVITY, 0.0, "mg mgn"),
    ),
    "mag": _units(
        (1.0, 0.0, "ut microtesla"),
        (1e-3, 0.0, "nt nanotesla"),
        (1e3, 0.0, "mt millitesla"),
        (1e6, 0.0, "t tesla"),
        (100.0, 0.0, "g gs gauss"),
        (0.1, 0.0, "mg mgauss milligauss"),
        (1.0, 0.0, "au norm normalised normalized"),  # only the direction is known: kept as it is
    ),
    "temperature": _units(
        (1.0, 0.0, "c degc celsius"),
        (1.0, -273.15, "k kelvin"),
        (5.0 / 9.0, -160.0 / 9.0, "f degf fahrenheit"),
    ),
    "ref": _units((1.0, 0.0, "1 au quat")),
    "mask": _units((1.0, 0.0, "bool")),
}

#: Quantity -> the unit that is assumed where a name tells none.
ASSUMED = {"t": "s", "gyr": "rad/s", "acc": "m/s²", "mag": "µT", "temperature": "°C"}

_SIGNS = str.maketrans({"µ": "u", "μ": "u", "°": "deg", "²": "2", "³": "3", "⁻": "-", "¹": "1"})


def plain(text: str) -> str:
    """The text with the signs of units in ASCII."""
    return text.translate(_SIGNS)


def unit_key(unit: str) -> str:
    """The letters and digits of a unit, in lower case."""
    return re.sub(r"[^a-z0-9]", "", plain(unit).lower())


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
    if unit_key(unit) not in known:
        raise ValueError(f"units: unknown unit {unit!r} of {quantity}; known are {', '.join(sorted(filter(None, known)))}")
    return known[unit_key(unit)]
