"""What a page plays of a recording: orientations as 16-bit numbers, lines of angles, spans of status."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _display, _native, _quat
from ahrs_rs._constants import GRAVITY
from ahrs_rs._estimate import Estimate
from ahrs_rs._printable import printable
from ahrs_rs._recording import Recording
from ahrs_rs._status import Status
from ahrs_rs._streams import Stream
from ahrs_rs._typing import FloatArray

#: So many frames a second and in all: what an eye sees, and what an hour takes within 30 MB.
FRAME_RATE, FRAMES = 60.0, 120_000
#: Points of a line.
POINTS = 12_000
#: Spans of a flag that are closer than this part of the duration are one: a screen has no more pixels.
PIXELS = 2000
#: A reading of a slower sensor is held for so long, s.
HELD = 0.5
ANGLES = ("roll", "pitch", "yaw")
#: Largest 16-bit number; the one below all is a reading that is missing.
FULL, MISSING = 32767, -32768
#: From each earth frame to east-north-up.
TO_ENU = {
    "ENU": np.array([1.0, 0.0, 0.0, 0.0]),
    "NED": np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0]),
    "NWU": np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]),
}


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What the player is given of one recording."""

    name: str
    data: dict[str, Any]


def scene(recording: Recording, estimates: Mapping[str, Estimate], title: str) -> Scene:
    """The scene of a recording; ValueError where there is nothing to play."""
    count = len(recording)
    if not count:
        raise ValueError("recording: expected at least one sample, got none")
    if not estimates and recording.ref is None:
        raise ValueError("estimates: expected at least one, as the recording has no reference, got none")
    for name, one in estimates.items():
        if not isinstance(one, Estimate):
            raise ValueError(f"estimates: expected an Estimate of {name!r}, got {type(one).__name__}")
        if one.quat.shape != (count, 4):
            raise ValueError(f"estimates: expected shape {(count, 4)} of {name!r}, got {one.quat.shape}")
    t = recording.t - recording.t[0]
    rows = _frames(t)
    frame = next((one.frame for one in estimates.values()), "ENU")
    shown = {
        printable(name): _Attitudes(np.asarray(one.quat, np.float64), one.frame) for name, one in estimates.items()
    }
    if recording.ref is not None:
        own = recording.meta.get("ref_frame")
        shown["reference"] = _Attitudes(recording.ref, own if own in TO_ENU else frame)
    name = printable(title or Path(str(recording.meta.get("path", "recording"))).name)
    data: dict[str, Any] = {
        "name": name,
        "note": _note(recording, rows),
        "end": float(t[-1]),
        "gaps": _gaps(t, recording),
        "t": _bytes(t[rows], np.float32),
        "bodies": [
            {
                "name": label,
                "reference": label == "reference" and label not in estimates,
                "quat": _bytes(_turned(one.in_enu(rows)), np.int16),
                "angles": _lines(t, one.seen_from(frame)),
            }
            for label, one in shown.items()
        ],
        "status": [_status(printable(label), t, rows, one) for label, one in estimates.items()],
        "flags": {str(flag.value): flag.name for flag in Status},
        "frame": frame,
    }
    for sensor, scale in (("acc", 4.0 * GRAVITY), ("mag", _largest(recording.mag))):
        values = getattr(recording, sensor)
        if values is not None:
            data[sensor] = {"scale": scale, "values": _bytes(_held(values, t, rows, scale), np.int16)}
    if "mag" in data:
        data["mag"]["usual"] = float(np.nanmedian(np.linalg.norm(recording.require("mag"), axis=1)))
    if "acc" in data:
        data["acc"]["usual"] = GRAVITY
    return Scene(name, data)


@dataclass(frozen=True, slots=True, eq=False)
class _Attitudes:
    """Quaternions (T, 4) from the sensor to an earth frame."""

    quat: FloatArray
    frame: str

    def in_enu(self, rows: NDArray[np.intp]) -> FloatArray:
        return _quat.multiply(TO_ENU[self.frame], self.quat[rows])

    def seen_from(self, frame: str) -> FloatArray:
        """The same to another earth frame."""
        if frame == self.frame:
            return self.quat
        return _quat.multiply(_quat.conjugate(TO_ENU[frame]), _quat.multiply(TO_ENU[self.frame], self.quat))


def _frames(t: FloatArray) -> NDArray[np.intp]:
    """The rows that are played: all of them, or those at regular times."""
    wanted = min(FRAMES, int(float(t[-1]) * FRAME_RATE) + 2)
    if len(t) <= wanted:
        return np.arange(len(t))
    times = np.linspace(0.0, float(t[-1]), wanted)
    return np.unique(np.clip(np.searchsorted(t, times), 0, len(t) - 1))


def _note(recording: Recording, rows: NDArray[np.intp]) -> str:
    played = "all of them are played"
    if len(rows) < len(recording):
        played = f"{len(rows)} of them are played"
    lines = "" if len(recording) <= POINTS else ", lines have the extremes of the rows that a point stands for"
    return f"{len(recording)} rows at {recording.rate:.5g} Hz: {played}{lines}."


def _gaps(t: FloatArray, recording: Recording) -> list[list[float]]:
    """Where the clock has a gap, or the gyroscope no reading for as long."""
    missing = None if recording.gyr is None else Stream(recording.t, recording.gyr).missing
    return _merged([list(span) for span in _display.gap_spans(t, missing)], float(t[-1]))


def _lines(t: FloatArray, quat: FloatArray) -> dict[str, dict[str, str]]:
    """Roll, pitch and yaw in degrees, cut where they wrap and at gaps."""
    found = {}
    for name, values in zip(ANGLES, np.degrees(_native.euler_angles(quat)).T, strict=True):
        after = np.union1d(_display.wraps(values, 360.0), _display.gaps(t))
        at, shown = _display.thinned(*_display.broken(t, values, after), POINTS)
        found[name] = {"x": _bytes(at, np.float32), "y": _bytes(shown, np.float32)}
    return found


def _status(name: str, t: FloatArray, rows: NDArray[np.intp], estimate: Estimate) -> dict[str, Any]:
    """The bits of each frame, and the spans of each flag that is set anywhere."""
    union = int(np.bitwise_or.reduce(estimate.status))
    spans = {
        flag.name: _merged([list(one) for one in _display.spans(t, (estimate.status & flag.value) != 0)], float(t[-1]))
        for flag in Status
        if union & flag.value
    }
    return {"name": name, "bits": _bytes(estimate.status[rows], np.uint16), "spans": spans}


def _merged(spans: list[list[float]], duration: float) -> list[list[float]]:
    """Spans that a screen can tell from each other."""
    apart = duration / PIXELS
    found: list[list[float]] = []
    for begin, end in sorted(spans):
        if found and begin - found[-1][1] <= apart:
            found[-1][1] = max(found[-1][1], end)
        else:
            found.append([begin, end])
    return found


def _turned(quat: FloatArray) -> FloatArray:
    """Quaternions as whole numbers; zeros are an orientation that is not known."""
    known = ~np.isnan(quat).any(axis=1, keepdims=True)
    return np.where(known, np.rint(FULL * np.clip(quat, -1.0, 1.0)), 0.0)


def _held(values: FloatArray, t: FloatArray, rows: NDArray[np.intp], scale: float) -> FloatArray:
    """The last reading at each frame as whole numbers, missing where it is older than half a second."""
    known = ~np.isnan(values).any(axis=1)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))[rows]
    there = (last >= 0) & (t[rows] - t[np.maximum(last, 0)] <= HELD)
    readings = np.clip(np.rint(FULL * values[np.maximum(last, 0)] / scale), -FULL, FULL)
    return np.where(there[:, np.newaxis], readings, MISSING)


def _largest(values: FloatArray | None) -> float:
    """A power of two above all readings, so that they are whole numbers of 16 bits of it."""
    if values is None or np.isnan(values).all():
        return 1.0
    return float(2.0 ** np.ceil(np.log2(max(float(np.nanmax(np.abs(values))), 1e-6))))


def _bytes(values: Any, dtype: Any) -> str:
    """As the little-endian bytes of an array, in base64."""
    array = np.ascontiguousarray(values, dtype=np.dtype(dtype).newbyteorder("<"))
    return base64.b64encode(array.tobytes()).decode("ascii")
