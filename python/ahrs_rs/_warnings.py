"""The class of our warnings."""

from __future__ import annotations

__all__ = ["DataWarning"]


class DataWarning(UserWarning):
    """Data was read or computed with, and something about it was assumed, repaired, left out, or is in doubt.

    The message says what, and the option that settles it. `Recording.meta` holds the same sentences.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> issubclass(ar.DataWarning, UserWarning)
    True
    """
