"""Orientations of several sensors for OpenSim's OpenSense: a storage file (.sto) of quaternions."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ahrs_rs import _atomic
from ahrs_rs._rate import nominal_rate
from ahrs_rs._streams import Stream
from ahrs_rs._typing import FloatArray

if TYPE_CHECKING:
    from ahrs_rs._estimate import Estimate

#: The version of OpenSim whose reader the layout was tried with.
OPENSIM = "4.6"


def write_sto(path: str | os.PathLike[str], estimates: Mapping[str, Estimate]) -> None:
    """Write the orientations of several sensors as a storage file for OpenSense.

    OpenSim wants one time column of a regular rate: the stamps are those of the first estimate's rate over the time
    that all of them have, and orientations are interpolated along the shortest rotations where they stand elsewhere.
    Quaternions are scalar-first, sensor to the earth frame of the estimates; `sensor_to_opensim_rotations` of
    OpenSense's settings turns a z axis that is up (ENU) to y.

    Parameters
    ----------
    path : str or path-like
        Ends in .sto.
    estimates : mapping
        Name of the sensor in the model, as "pelvis_imu" -> estimate of one recording; their stamps
        are of one clock.

    Raises
    ------
    ValueError
        No estimate, one of several recordings, a name with blanks, stamps that have no time in common.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=2.0)
    >>> sensors = {"pelvis_imu": ar.VQF().run(rec), "femur_r_imu": ar.VQF().run(rec)}
    >>> ar.io.write_sto("model.sto", sensors)  # doctest: +SKIP
    """
    if not estimates:
        raise ValueError("estimates: expected at least one, got none")
    for name, est in estimates.items():
        if est.quat.ndim != 2:
            raise ValueError(f"estimates: {name!r}: expected one recording, got {est.quat.shape[0]} side by side")
        if not name or re.search(r"\s", name):
            raise ValueError(f"estimates: expected names without blanks, got {name!r}")
        if len(est) < 2:
            raise ValueError(f"estimates: {name!r}: expected at least two samples, got {len(est)}")
    first = next(iter(estimates.values()))
    rate = nominal_rate(np.asarray(first.t, dtype=np.float64))
    clock = _common_clock(estimates, rate)
    columns = [_at(est, clock) for est in estimates.values()]
    lines = [
        f"DataRate={rate:.6f}",
        "DataType=Quaternion",
        "version=3",
        f"OpenSimVersion={OPENSIM}",
        "endheader",
        "\t".join(["time", *estimates]),
    ]
    for k, t in enumerate(clock.tolist()):
        lines.append("\t".join([repr(t), *(",".join(map(repr, column[k].tolist())) for column in columns)]))
    _atomic.write_text(path, "\n".join(lines) + "\n")


def _common_clock(estimates: Mapping[str, Estimate], rate: float) -> FloatArray:
    """Regular stamps over what all estimates have; those of the first one where they are regular, and all the same."""
    times = [np.asarray(est.t, dtype=np.float64) for est in estimates.values()]
    start, end = max(t[0] for t in times), min(t[-1] for t in times)
    if not start < end:
        raise ValueError("estimates: expected stamps of one clock, got recordings without a time in common")
    same = all(len(t) == len(times[0]) and np.array_equal(t, times[0]) for t in times)
    regular = np.abs(np.diff(times[0]) * rate - 1.0).max() < 1e-3
    if same and regular:
        return times[0]
    count = math.floor((end - start) * rate + 1e-9) + 1
    grid: FloatArray = start + np.arange(count) / rate
    clock: FloatArray = np.minimum(grid, end)
    return clock


def _at(est: Estimate, clock: FloatArray) -> FloatArray:
    stream = Stream(np.asarray(est.t, dtype=np.float64), np.asarray(est.quat, dtype=np.float64))
    found = stream.turning(clock)
    lost = np.isnan(found).any(axis=1)
    if lost.any():  # OpenSim takes what is no quaternion for the identity, without a word
        found[lost] = stream.held(clock)[lost]
    return found
