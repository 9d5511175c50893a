"""What a filter says of a sample beside the attitude."""

from __future__ import annotations

import enum

from ahrs_rs import _native


class Status(enum.IntFlag):
    """The bits of ``Estimate.status``; a sample with nothing to say has none.

    A sensor that has never been given to the filter is not missing: its bit stays clear.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.Status(5)
    <Status.ACC_MISSING|GYR_HELD: 5>
    >>> bool(ar.Status(5) & ar.Status.ACC_MISSING)
    True
    """

    ACC_MISSING = 1
    """The accelerometer's row holds no measurement (a NaN, or a norm that is zero or beyond the dtype)."""
    MAG_MISSING = 2
    """The magnetometer's row holds no measurement."""
    GYR_HELD = 4
    """The gyroscope's row holds no measurement, or one too large to turn by; the last angular rate was held."""
    ACC_REJECTED = 8
    """The filter did not trust the accelerometer."""
    MAG_REJECTED = 16
    """The filter did not trust the magnetometer."""
    REST = 32
    """The sensor rests."""
    NOT_ALIGNED = 64
    """No accelerometer sample has come yet: the attitude is relative to the start."""
    RECOVERING = 128
    """The filter recovers: from a long rejection, or from a rotation that was lost."""
    GAP = 256
    """The step was much longer than usual: samples are missing, or the clock leapt."""
    REPEATED = 512
    """A row repeats its sensor's last one and was taken for missing, as ``repeated="missing"`` asks."""


if dict(_native.status_bits()) != {bit.name: int(bit) for bit in Status}:
    raise ImportError("ahrs_rs: its native module is of another version: build the package again")
