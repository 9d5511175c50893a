"""The truth from another file: at another rate, and by another clock."""

from __future__ import annotations

import os
import warnings
from typing import IO, Any

import numpy as np

from ahrs_rs import _lags, _quat, metrics
from ahrs_rs._rate import nominal_rate
from ahrs_rs._recording import Recording
from ahrs_rs._streams import Stream
from ahrs_rs._typing import FloatArray
from ahrs_rs._warnings import DataWarning
from ahrs_rs.filters import FILTERS
from ahrs_rs.io import read

__all__ = ["join_reference"]


#: Angular rates are compared at this rate, Hz, and over this time, s: what optical systems and sensors both show.
RATE, SPAN = 50.0, 0.1
#: The clocks are looked for again within this offset, s, once the rates agree.
FINE = 1.0
#: The least correlation of the angular rates at the offset that is found.
CORRELATION = 0.5


def join_reference(
    recording: Recording,
    other: Recording | str | os.PathLike[str] | IO[bytes],
    *,
    offset: float | None = None,
    options: dict[str, Any] | None = None,
) -> Recording:
    """The recording with the true orientation of another file.

    The clock of the reference is aligned with that of the recording: by the norms of the angular rates of both over all
    offsets, then by `metrics.align`. The orientations stand on the stamps of the recording, by the shortest rotations
    between those of the reference, and not over its gaps. Its frames are left as they are: `metrics.align`
    (``compare --align``) finds them.

    Parameters
    ----------
    recording : Recording
        With a gyroscope.
    other : Recording, str, path-like or file object
        A recording with `ref` (or else with `device_quat`, which is then taken for the truth), or a
        file of one. Of a recording that has neither, ValueError.
    offset : float, optional
        S, added to the times of the reference; None finds it. 0.0 for files of one clock.
    options : dict, optional
        Keywords of `read`, where `other` is a file.

    Returns
    -------
    Recording
        With `ref`; ``meta["reference"]`` says where it comes from and what was found.

    Raises
    ------
    ValueError
        No orientation in `other`; rates of turn that do not agree at any offset.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=20.0)
    >>> truth = ar.Recording.from_streams(ref=(rec.t[::3] + 4.2, rec.ref[::3]))
    >>> joined = ar.join_reference(rec, truth)
    >>> round(joined.meta["reference"]["offset"], 2)
    -4.2
    """
    given = other if isinstance(other, Recording) else read(other, **(options or {}))
    name = "ref" if "ref" in given.streams else "device_quat"
    if name not in given.streams:
        raise ValueError(f"other: expected a recording with ref, got one with {' '.join(given.streams)}")
    truth = given.streams[name]
    if len(truth) < 2:
        raise ValueError(f"other: expected at least two orientations, got {len(truth)}")
    said: dict[str, Any] = {"path": given.meta.get("path", "a recording"), "stream": name}
    if offset is None:
        coarse = _coarse_offset(recording, truth)
        offset, found = _fine_offset(recording, truth, coarse)
        said |= found
    said["offset"] = float(offset)
    moved = Stream(truth.t + offset, truth.values)
    own = {key: stream for key, stream in recording.streams.items() if key not in ("ref", "mask")}
    ref = moved.turning(recording.t)
    if np.isnan(ref).all():
        raise ValueError(
            "other: has no orientation at the times of the recording: do the clocks agree? (offset=None finds out)"
        )
    meta = {**recording.meta, "reference": said}
    if "ref_frame" in given.meta or name == "device_quat":
        meta["ref_frame"] = given.meta.get("ref_frame", given.meta.get("device_frame", "of the device"))
    if "mask" in given.streams and name == "ref":
        mask = given.streams["mask"]
        own["mask"] = Stream(mask.t + offset, mask.values)
    if recording.has_own_clocks:
        return Recording.from_streams(rate=recording.rate, meta=meta, **own, ref=moved)
    rows: dict[str, Any] = {key: getattr(recording, key) for key in ("gyr", "acc", "mag", "temperature")}
    if "mask" in own:
        rows["mask"] = own["mask"].held(recording.t)
    return Recording(t=recording.t, rate=recording.rate, meta=meta, others=recording.others, ref=ref, **rows)


def _coarse_offset(recording: Recording, truth: Stream) -> float:
    """The offset at which the norms of the angular rates are most alike, over all offsets at which enough overlaps."""
    recording.require("gyr")
    gyr = recording.streams["gyr"]
    sensor = _lags.norms_of_rates(gyr, RATE)
    optical = _norms_of_turns(truth)
    least = max(min(sensor.size, optical.size) // 3, round(2.0 * RATE))
    if min(sensor.size, optical.size) < round(2.0 * RATE):
        raise ValueError("other: expected at least 2 s of orientations and of angular rates")
    lags, score = _lags.correlations(sensor, optical, min(least, min(sensor.size, optical.size)))
    if np.isnan(score).all():
        raise ValueError(
            "other: too little overlaps, or nothing turns: an offset of the clocks cannot be found (give offset=)"
        )
    best = int(np.nanargmax(score))
    if not score[best] >= CORRELATION:
        raise ValueError(
            f"other: its rates of turn agree with the gyroscope's at no offset (correlation {score[best]:.2f}): do "
            "they show the same motion? (give offset= for clocks that are known)"
        )
    return float(gyr.t[0] - truth.t[0] + lags[best] / RATE)


def _norms_of_turns(truth: Stream) -> FloatArray:
    grid = np.arange(truth.t[0], truth.t[-1], 1.0 / RATE)
    quat = truth.turning(grid)
    if len(quat) < 2:
        return np.zeros(0)
    turn = np.linalg.norm(_quat.log(_quat.multiply(_quat.conjugate(quat[:-1]), quat[1:])), axis=1) * RATE
    return np.concatenate([[np.nan], turn])


def _fine_offset(recording: Recording, truth: Stream, coarse: float) -> tuple[float, dict[str, Any]]:
    """The offset by the orientations themselves, and what is left of their errors."""
    moved = Stream(truth.t + coarse, truth.values)
    ref = moved.turning(recording.t)
    f = FILTERS["VQF"](rate=nominal_rate(recording.t))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)
        est = f.run(recording.gyr, recording.acc, t=recording.t)
    try:
        found = metrics.align(est.quat, ref, t=recording.t, largest_offset=FINE, check=False)
    except ValueError:  # too slow, or too little: what the rates of turn say stands
        return coarse, {}
    return coarse + found.time_offset, {"rms_deg": float(np.degrees(found.rms))}
