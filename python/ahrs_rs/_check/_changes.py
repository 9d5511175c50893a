"""Changes of a recording that put right what is sure."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs._axes import is_sensor_vector
from ahrs_rs._check._findings import Change
from ahrs_rs._recording import Recording, Stream

FloatArray = NDArray[np.float64]


def _of_sensor(sensor: str, name: str) -> bool:
    """Whether a stream holds readings of a sensor: "acc", and "acc_high_range" beside it."""
    return name == sensor or (is_sensor_vector(name) and name.startswith(f"{sensor}_"))


def scaled(code: str, sensor: str, factor: float, text: str) -> Change:
    """All readings of a sensor times a factor."""

    def apply(recording: Recording) -> Recording:
        return recording.changed(lambda name, x: x * factor if _of_sensor(sensor, name) else x)

    return Change(code, text, apply)


def turned(code: str, sensor: str, matrix: FloatArray, text: str) -> Change:
    """All readings of a sensor in other axes."""

    def apply(recording: Recording) -> Recording:
        def change(name: str, x: NDArray[Any]) -> NDArray[Any]:
            return np.asarray(x @ matrix.T) if _of_sensor(sensor, name) else x

        return recording.changed(change)

    return Change(code, text, apply)


def calibrated(code: str, sensor: str, matrix: FloatArray, offset: FloatArray, text: str) -> Change:
    """S (x − b) of a sensor's readings."""

    def apply(recording: Recording) -> Recording:
        return recording.changed(lambda name, x: np.asarray((x - offset) @ matrix.T) if name == sensor else x)

    return Change(code, text, apply)


def timed(code: str, factor: float, text: str) -> Change:
    """All times times a factor, from the first one on."""

    def apply(recording: Recording) -> Recording:
        start = float(recording.t[0]) if len(recording) else 0.0
        start_scaled = start * factor

        def moved(t: FloatArray) -> FloatArray:
            return start_scaled + (t - start) * factor

        return with_times(recording, moved, recording.rate / factor)

    return Change(code, text, apply)


def restamped(code: str, t: FloatArray, rate: float, text: str) -> Change:
    """The rows on other stamps; sensors with clocks of their own stay."""

    def apply(recording: Recording) -> Recording:
        return dataclasses.replace(recording, t=t, rate=rate)

    return Change(code, text, apply)


def delayed(code: str, sensor: str, delay: float, text: str) -> Change:
    """The readings of a sensor on the times at which they were true."""

    def apply(recording: Recording) -> Recording:
        streams = dict(recording.streams)
        one = streams[sensor].present()
        streams[sensor] = Stream(one.t - delay, one.values)
        if recording.has_own_clocks:
            return Recording.from_streams(rate=recording.rate, meta=recording.meta, **streams)
        rows = dict(recording._arrays())
        rows[sensor] = streams[sensor].linear(recording.t)
        return Recording(**rows, rate=recording.rate, meta=dict(recording.meta), others=recording.others)

    return Change(code, text, apply)


def blanked(code: str, sensor: str, repeated: NDArray[np.bool_], text: str) -> Change:
    """The rows of a sensor that repeat the one before, as missing."""

    def apply(recording: Recording) -> Recording:
        rows = getattr(recording, sensor)
        changed = np.array(rows)
        changed[repeated] = np.nan
        values: dict[str, Any] = {sensor: changed}
        return dataclasses.replace(recording, **values)

    return Change(code, text, apply)


def referenced(code: str, change: Any, text: str) -> Change:
    """Another form of the reference's quaternions."""

    def apply(recording: Recording) -> Recording:
        return recording.changed(lambda name, x: change(x) if name == "ref" else x)

    return Change(code, text, apply)


def with_times(recording: Recording, moved: Any, rate: float) -> Recording:
    """The recording with ``moved(t)`` for the times of all its streams."""
    if recording.has_own_clocks:
        own = {name: Stream(moved(one.t), one.values) for name, one in recording.streams.items()}
        return Recording.from_streams(rate=rate, meta=recording.meta, **own)
    others = {name: Stream(moved(one.t), one.values) for name, one in recording.others.items()}
    rows = {name: value for name, value in recording._arrays().items() if name != "t"}
    return Recording(t=moved(recording.t), rate=rate, meta=dict(recording.meta), others=others, **rows)
