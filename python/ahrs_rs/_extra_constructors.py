"""What only some classes have: ``make_class`` adds it, ``tools/stubs.py`` writes constructors into the stubs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from ahrs_rs._validate import number

if TYPE_CHECKING:
    from ahrs_rs._filter import Filter

F = TypeVar("F", bound="Filter")


def from_kalman_gain(cls: type[F], /, gain: float, *, rate: float, **keywords: Any) -> F:
    """The filter that weighs the accelerometer as a Kalman filter does in its steady state.

    Parikh et al. 2021 choose their weight so: α = 1 - K1 with the gain K1 of the angle. The
    time constant is dt α/(1 - α) with dt = 1/rate.

    Parameters
    ----------
    gain : float
        K1 of the angle, between 0 and 1 (``LinearKalman``'s steady state, for example).
    rate : float
        Sampling rate in Hz for which the gain holds.
    **keywords : float or str
        Those of the constructor, but ``tau``.

    Returns
    -------
    Complementary
        The filter.

    Raises
    ------
    ValueError
        A gain that is not between 0 and 1, or a rate that is not positive.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> round(ar.Complementary.from_kalman_gain(0.01, rate=100.0).tau, 6)
    0.99
    """
    weight = number("gain", gain)
    if not 0.0 < weight < 1.0:
        raise ValueError(f"gain: expected a number between 0 and 1, got {weight!r}")
    made = cls(rate=rate, **keywords)  # checks the rate
    if made.rate is None:
        raise ValueError("rate: expected a number in Hz, got None")
    return cls(rate=rate, tau=(1.0 - weight) / weight / made.rate, **keywords)


#: Class methods by the name of the class.
SPECIAL = {"Complementary": (from_kalman_gain,)}

#: Filters that turn by the gyroscope only where the accelerometer has no sample.
WITHOUT_GYROSCOPE = frozenset({"Tilt", "Ecompass"})
