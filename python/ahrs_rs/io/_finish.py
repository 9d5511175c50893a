"""What a reader found becomes a `Recording`: the one place where it is repaired and doubted."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _plausible
from ahrs_rs._recording import Recording, Stream
from ahrs_rs._typing import FloatArray
from ahrs_rs.io._clocks import ordered
from ahrs_rs.io._contents import Options, SensorData
from ahrs_rs.io._units import SIZELESS, conversion, unit_key

#: A reference quaternion whose norm differs from 1 by no more than this is kept as recorded (rounding to 3
#: decimals); up to the second value it is normalised; beyond, it is no orientation but a mark of a lost one.
NORM_KEPT, NORM_MENDED = 1e-3, 0.1

#: Streams that are rows of a `Recording`.
ROWS = ("gyr", "acc", "mag", "ref", "mask", "temperature")
ORIENTATIONS = ("ref", "device_quat")
VECTORS = ("gyr", "acc", "mag")
#: Whether readings that no inertial sensor gives are kept and told, in place of an error.
_kept: ContextVar[bool] = ContextVar("kept", default=False)
Times = dict[int, tuple[FloatArray, NDArray[np.intp] | None]]


@contextmanager
def keeping_doubtful() -> Iterator[None]:
    """Within it, readings that no inertial sensor gives are kept, and told in ``meta["doubts"]``: for a check."""
    token = _kept.set(True)
    try:
        yield
    finally:
        _kept.reset(token)


@np.errstate(over="ignore", invalid="ignore")  # absurd times and quaternions are refused by their result
def finish(data: SensorData, path: str, format: str, options: Options, *, convert: bool) -> Recording:
    """A `Recording` of what a reader found, with every change told in `meta`.

    Infinite values and impossible orientations become NaN, times are put in order, a sensor without any reading counts
    as absent. Nothing else is added or removed. `convert`: the units of the options are still to be applied, as the
    reader has not done it.

    Raises
    ------
    ValueError
        No samples, no times; readings that no inertial sensor gives (`_plausible`), unless the user stated their unit.
    """
    meta: dict[str, Any] = {**data.meta, "repairs": list(data.meta.get("repairs", ()))}
    data = SensorData(dict(data.streams), data.rate, meta)
    if convert:
        _convert(data, options.units or {})
    if options.rate is not None:
        _count_by(options.rate, data)
    for name, (t, values) in list(data.streams.items()):
        data.streams[name] = (t, _cleaned(name, values, meta["repairs"]))
        if t is not None and (wrong := _plausible.doubtful_stamps(np.asarray(t))):
            if _kept.get():
                data.say("doubts", f"t: {wrong}")
                continue
            raise ValueError(f"t: {wrong}")
    _leave_out_empty(data)
    if not any(len(values) for _, values in data.streams.values()):
        raise ValueError("has no samples")
    meta.update(path=path, format=format)
    made = _recording(_in_order(data), data)
    _refuse_implausible(made, data, options)
    return made


def _convert(data: SensorData, units: Mapping[str, str]) -> None:
    """The readings in our units, where the user says in which ones they are."""
    for quantity, unit in units.items():
        factor, offset = conversion(quantity, unit)
        if quantity == "t":
            times = {id(t): np.asarray(t, dtype=np.float64) * factor for t, _ in data.streams.values() if t is not None}
            data.streams = {name: (None if t is None else times[id(t)], x) for name, (t, x) in data.streams.items()}
        elif quantity not in data.streams:
            raise ValueError(f"units: has no {quantity}, only {', '.join(data.streams)}")
        else:
            t, values = data.streams[quantity]
            data.streams[quantity] = (t, np.asarray(values, dtype=np.float64) * factor + offset)
        data.meta["units"] = {**data.meta.get("units", {}), quantity: unit}


def _count_by(rate: float, data: SensorData) -> None:
    """Times by a given rate, in place of those of the file."""
    lengths = {len(values) for _, values in data.streams.values()}
    if len(lengths) > 1:
        raise ValueError("rate: the sensors of this file have stamps of their own; expected no rate=")
    data.streams = {name: (None, values) for name, (_, values) in data.streams.items()}
    data.rate = rate


def _cleaned(name: str, values: Any, repairs: list[str]) -> NDArray[Any]:
    array = np.asarray(values)
    if not array.ndim:
        raise ValueError(f"{name}: expected a value a sample, got one alone")
    if name == "mask":
        return array
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name}: expected real numbers, got dtype {array.dtype}")
    # What a library lent is copied: it may be taken away. What is changed below is copied where it is changed.
    array = np.asarray(array, dtype=np.float64) if array.flags.owndata else np.array(array, dtype=np.float64)
    infinite = np.isinf(array)
    if infinite.any():
        array = np.where(infinite, np.nan, array)
        repairs.append(f"{name}: {int(infinite.sum())} infinite values turned into NaN")
    return _orientations(name, array, repairs) if name in ORIENTATIONS else array


def _orientations(name: str, quat: FloatArray, repairs: list[str]) -> FloatArray:
    if quat.ndim != 2 or quat.shape[1] != 4:
        return quat  # the wrong shape is told by Recording
    norm = np.linalg.norm(quat, axis=1)
    deviation = np.abs(norm - 1.0)
    mended = (deviation > NORM_KEPT) & (deviation <= NORM_MENDED)
    lost = deviation > NORM_MENDED
    if mended.any() or lost.any():
        quat = quat.copy()
    if mended.any():
        quat[mended] /= norm[mended, None]
        repairs.append(f"{name}: {int(mended.sum())} quaternions normalised")
    if lost.any():
        quat[lost] = np.nan
        repairs.append(f"{name}: {int(lost.sum())} rows with a norm far from 1 turned into NaN")
    return quat


def _leave_out_empty(data: SensorData) -> None:
    """A sensor of which every value is missing is absent."""
    for name, (_, values) in list(data.streams.items()):
        if values.dtype.kind == "f" and values.size and np.isnan(values[0]).all() and np.isnan(values).all():
            del data.streams[name]
            data.say("ignored", f"{name}: all values are missing, so that the sensor counts as absent")


def _in_order(data: SensorData) -> dict[str, Stream]:
    """Streams with their times in order; those of one clock are sorted together."""
    times: Times = {}
    made: dict[str, Stream] = {}
    shared = len({id(t) for t, _ in data.streams.values()}) == 1
    for name, (t, values) in data.streams.items():
        if t is None:
            if data.rate is None or not data.rate > 0:
                raise ValueError("has no times (t) and no sampling rate: give rate= (--rate)")
            times.setdefault(0, (np.arange(len(values)) / data.rate, None))  # 0: no id of an array
            clock, order = times[0]
        else:
            if id(t) not in times:
                array = np.asarray(t, dtype=np.float64)
                times[id(t)] = ordered(array, data.meta["repairs"], "t" if shared else f"{name}.t")
            clock, order = times[id(t)]
        rows = values if order is None else values[order]
        if len(rows) != len(clock):
            shape = ", ".join(map(str, (len(clock), *rows.shape[1:])))
            raise ValueError(f"{name}: expected shape ({shape}{',' if rows.ndim == 1 else ''}), got {rows.shape}")
        try:
            made[name] = Stream(clock, rows)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    return made


def _recording(streams: dict[str, Stream], data: SensorData) -> Recording:
    clocks = {id(stream.t) for stream in streams.values()}
    if len(clocks) > 1 or not any(name in ROWS for name in streams):
        kept = {name: one if name in ("gyr", "mask") else one.present() for name, one in streams.items()}
        return Recording.from_streams(rate=data.rate, meta=data.meta, **kept)
    rows: dict[str, Any] = {name: one.values for name, one in streams.items() if name in ROWS}
    others = {name: one.present() for name, one in streams.items() if name not in ROWS}
    clock = next(iter(streams.values())).t
    rate = math.nan if data.rate is None else data.rate
    return Recording(t=clock, rate=rate, meta=data.meta, others=others, **rows)


def _refuse_implausible(made: Recording, data: SensorData, options: Options) -> None:
    """An error where readings or stamps are none of an inertial sensor in the unit that they are taken for.

    What the user stated is believed. A magnetometer without a likely unit is only doubted: filters use its direction.
    """
    stated = set(options.units or ())
    found: list[tuple[str, str, str | None]] = []
    streams = made.streams
    for name in VECTORS:
        wrong = None if name in stated else _doubtful(name, streams, data)
        if wrong is not None:
            found.append((name, *wrong))
    if len(made) > 2 and options.rate is None and "t" not in stated and data.rate is None:
        wrong_rate = _plausible.doubtful_rate(made.rate)
        if wrong_rate is not None:
            found.append(("t", wrong_rate, _plausible.likely_time_unit(made.rate)))
    if found and _kept.get():
        for name, what, _ in found:
            data.say("doubts", f"{name}: {what}")
    elif found:
        raise ValueError(_refusal(found, data.meta.get("units", {})))
    assumed = "gyr" in data.meta.get("assumed_units", {})
    if (
        assumed
        and made.gyr is not None
        and made.acc is not None
        and (_plausible.looks_like_degrees(made.gyr, made.acc, made.t))
    ):
        said = "gyr: the accelerometer turns by π/180 of the angular rate, which looks like deg/s"
        data.say("doubts", f"{said}: units={{'gyr': 'deg/s'}} (--units gyr=deg/s)")


def _doubtful(name: str, streams: Mapping[str, Stream], data: SensorData) -> tuple[str, str | None] | None:
    """What is wrong with the readings of a sensor, and the unit that they look like."""
    units = data.meta.get("units", {})
    values = streams[name].values if name in streams else None
    if values is None or unit_key(str(units.get(name, ""))) in SIZELESS:
        return None
    if name == "mag" and _plausible.is_normalised(values):
        data.meta["units"] = {**units, "mag": "normalised"}
        data.say("assumed", "mag: its norm is about 1, taken as normalised by the local field")
        return None
    wrong = _plausible.doubt(name, values)
    if wrong is None:
        return None
    likely = _plausible.likely_unit(name, values)
    if name == "mag" and likely is None:
        data.say("doubts", f"mag: {wrong}: only its direction can be relied on")
        return None
    return wrong, likely


def _refusal(found: list[tuple[str, str, str | None]], units: Mapping[str, str]) -> str:
    """What is wrong, and the option that settles it."""
    own = {"acc": "m/s2", "gyr": "rad/s", "mag": "uT", "t": "s"}
    said, settled = [], {}
    for name, wrong, likely in found:
        looks = f", it looks like {likely}" if likely else ""
        if name == "acc" and likely is None:
            looks = ", unless it is without gravity (linear acceleration)"
        said.append(f"{name}: {wrong}{looks}")
        settled[name] = likely or own[name]
    cli = ",".join(f"{name}={unit}" for name, unit in settled.items())
    how = "give" if all(likely for _, _, likely in found) else "if it is right, state the unit:"
    return f"{'; '.join(said)}; {how} units={settled} (--units {cli})"
