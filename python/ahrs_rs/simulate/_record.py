"""A motion, seen by a sensor: recordings with their truth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ahrs_rs import _quat
from ahrs_rs._constants import GRAVITY
from ahrs_rs._recording import Recording
from ahrs_rs._typing import FloatArray
from ahrs_rs.simulate._magnetic import FIELD, Disturbance
from ahrs_rs.simulate._motion import Motion
from ahrs_rs.simulate._noise import Drift, Effect, Part, missing_rows, stream
from ahrs_rs.simulate._sensor import Sensor, Triad, as_dict

#: Samples that are computed at a time: the temporary arrays of a block stay in the processor's cache.
BLOCK = 8192

RATES = ("mean", "instantaneous")
Intervals = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """What no sensor knows, row by row of the recording.

    Parameters
    ----------
    t : ndarray
        (T,) the true times of the samples, s.
    position : ndarray
        (T, 3) m in ENU.
    gyr, acc, mag : ndarray
        (T, 3) what an exact sensor reads, with the disturbances of the field; mag None without one.
    disturbance : ndarray, optional
        (T, 3) the part of `mag` that is not the earth's field, µT in the sensor's axes.
    gyr_bias, acc_bias, mag_bias : ndarray
        (T, 3) the additive errors without white noise: constant, drift, temperature.
    temperature : ndarray, optional
        (T,) °C, or None.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> setup = ar.simulate.Setup(motion=ar.simulate.still(), rate=100.0, duration=1.0)
    >>> rec, truth = setup.record_with_truth()
    >>> truth.position.shape == rec.gyr.shape
    True
    """

    t: FloatArray
    position: FloatArray
    gyr: FloatArray
    acc: FloatArray
    mag: FloatArray | None = None
    disturbance: FloatArray | None = None
    gyr_bias: FloatArray
    acc_bias: FloatArray
    mag_bias: FloatArray | None = None
    temperature: FloatArray | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """An experiment: what moves how, and what is measured of it.

    Parameters
    ----------
    motion : Motion
        What the sensor follows.
    rate : float
        Hz.
    duration : float
        S; a recording has round(duration · rate) samples, at 0, 1/rate, 2/rate, ...
    sensor : Sensor, optional
        Its errors; by default an exact one.
    disturbances : tuple of Disturbance, optional
        Of the magnetic field, added up.
    earth_field : ndarray, optional
        The earth's magnetic field in ENU, µT.
    gravity : float, optional
        M/s².
    rates : str, optional
        "mean": gyr[k] is the mean angular rate over the time since the sample before, by which a
        turn takes the attitude of that one exactly to this one (for the first sample: over 1/rate);
        "instantaneous": at the sample.
    scored : sequence of tuple, optional
        Intervals in s of the samples that count (`Recording.mask`); None: all of them.
    phases : mapping, optional
        Name -> intervals in s, for the recording's meta: what happens when.
    name : str, optional
        Of the simulation, for the recording's meta.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> setup = ar.simulate.Setup(motion=ar.simulate.still(), rate=100.0, duration=1.0)
    >>> len(setup.record(seed=1))
    100
    """

    motion: Motion
    rate: float
    duration: float
    sensor: Sensor = field(default_factory=Sensor)
    disturbances: tuple[Disturbance, ...] = ()
    earth_field: FloatArray = field(default_factory=FIELD.copy)
    gravity: float = GRAVITY
    rates: str = RATES[0]
    scored: Intervals | None = None
    phases: Mapping[str, Intervals] = field(default_factory=dict)
    name: str = ""

    def __post_init__(self) -> None:
        for one in ("rate", "duration", "gravity"):
            check_positive(one, getattr(self, one))
        if not isinstance(self.sensor, Sensor):
            raise ValueError(f"sensor: expected a Sensor, got {self.sensor!r}")
        if self.rates not in RATES:
            raise ValueError(f"rates: expected one of {', '.join(RATES)}, got {self.rates!r}")
        earth = np.asarray(self.earth_field, dtype=np.float64)
        if earth.shape != (3,) or not np.isfinite(earth).all():
            raise ValueError(f"earth_field: expected three finite numbers, got {self.earth_field!r}")
        object.__setattr__(self, "earth_field", earth)
        object.__setattr__(self, "disturbances", tuple(self.disturbances))
        if self.count < 2:
            raise ValueError(f"duration: expected at least two samples at {self.rate} Hz, got {self.duration} s")

    @property
    def count(self) -> int:
        """Samples, before any is lost."""
        return round(self.duration * self.rate)

    def record(self, seed: int = 0) -> Recording:
        """A recording with the sensor errors of a seed.

        `ref` is the exact orientation (sensor to ENU) at the true times, `meta` holds the parameters and what was
        drawn: "gyr_bias" (rad/s), "acc_bias" (m/s²), "mag_bias" (µT), the constant biases, and "gyr_matrix" etc.,
        scale and misalignment. What changes with time is in the truth: see `record_with_truth`.

        The arrays take 112 bytes a sample (`temperature` 8 more), and at most 70 more while they are made.

        Parameters
        ----------
        seed : int, optional
            Of the errors.

        Returns
        -------
        Recording
            With the errors of the sensor.
        """
        return _Run(self, seed, truth=False).recording()

    def record_with_truth(self, seed: int = 0) -> tuple[Recording, Truth]:
        """The same recording, and the truth of every row: apart, because it takes twice its memory.

        Parameters
        ----------
        seed : int, optional
            Of the errors.

        Returns
        -------
        tuple
            The recording, and what no sensor knows.
        """
        run = _Run(self, seed, truth=True)
        return run.recording(), run.truth()


def record(
    motion: Motion,
    *,
    rate: float,
    duration: float,
    sensor: Sensor | None = None,
    seed: int = 0,
    disturbances: tuple[Disturbance, ...] = (),
    earth_field: FloatArray = FIELD,
    rates: str = RATES[0],
) -> Recording:
    """The recording of a sensor that follows a motion: see `Setup` for the parameters and `Setup.record`.

    Parameters
    ----------
    motion : Motion
        What the sensor follows.
    rate : float
        Hz.
    duration : float
        s.
    sensor : Sensor, optional
        Its errors; by default none.
    seed : int, optional
        Of the errors.
    disturbances : tuple of Disturbance, optional
        Fields that are added to the earth's.
    earth_field : ndarray, optional
        (3,) µT, ENU.
    rates : str, optional
        "mean" or "instantaneous", see `Setup`.

    Returns
    -------
    Recording
        With its exact orientation.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.record(ar.simulate.still(), rate=100.0, duration=1.0)
    >>> rec.rate
    100.0
    """
    setup = Setup(
        motion=motion,
        rate=rate,
        duration=duration,
        sensor=Sensor() if sensor is None else sensor,
        disturbances=disturbances,
        earth_field=earth_field,
        rates=rates,
    )
    return setup.record(seed)


class _Run:
    """One recording being made: whole arrays, filled block after block."""

    def __init__(self, setup: Setup, seed: int, *, truth: bool) -> None:
        check_seed(seed)
        self._setup, self._seed = setup, seed
        count, sensor = setup.count, setup.sensor
        self._kept = ~missing_rows(
            sensor.clock.lost, sensor.clock.lost_length, count, stream(seed, Part.CLOCK, Effect.MISSING)
        )
        triads = {Part.GYR: sensor.gyr, Part.ACC: sensor.acc, Part.MAG: sensor.mag}
        self._triads = {
            part: _Errors(triad, seed, part, setup.rate, count) for part, triad in triads.items() if triad is not None
        }
        self._out: dict[str, FloatArray] = {}
        for block in self._blocks(truth):
            rows = slice(self._done, self._done + len(block["t"]))
            for name, array in block.items():
                if name not in self._out:
                    self._out[name] = np.empty((count, *array.shape[1:]))
                self._out[name][rows] = array
            self._done = rows.stop
        if not self._kept.all():
            kept = np.flatnonzero(self._kept)
            for name, array in self._out.items():
                self._out[name] = array.take(kept, axis=0)

    _done = 0

    def recording(self) -> Recording:
        """The recording itself."""
        setup, out = self._setup, self._out
        if len(out["t"]) < 2:
            raise ValueError("clock.lost: fewer than two rows are left")
        mask = None
        if setup.scored is not None:
            mask = np.zeros(len(out["true_t"]), dtype=np.bool_)
            for start, end in setup.scored:
                mask |= (out["true_t"] >= start) & (out["true_t"] < end)
        rows: dict[str, Any] = {
            name: out[name] for name in ("t", "gyr", "acc", "mag", "ref", "temperature") if name in out
        }
        return Recording(
            **rows,
            rate=setup.rate,
            mask=mask,
            meta=self._meta(),
        )

    def truth(self) -> Truth:
        """The arrays of the truth, if they were asked for."""
        names = {one.name for one in fields(Truth)}
        return Truth(
            **{name[5:]: array for name, array in self._out.items() if name[:5] == "true_" and name[5:] in names}
        )

    def _meta(self) -> dict[str, Any]:
        setup = self._setup
        meta: dict[str, Any] = {
            "simulation": setup.name,
            "seed": self._seed,
            "ref_frame": "ENU",
            "rates": setup.rates,
            "gravity": setup.gravity,
            "earth_field": setup.earth_field.tolist(),
            "sensor": as_dict(setup.sensor),
        }
        for part, errors in self._triads.items():
            meta[f"{part.name.lower()}_bias"] = errors.bias.tolist()
            meta[f"{part.name.lower()}_matrix"] = errors.matrix.tolist()
        if setup.disturbances:
            meta["disturbances"] = [_shown(one) for one in setup.disturbances]
        if setup.phases:
            meta["phases"] = {name: [list(pair) for pair in pairs] for name, pairs in setup.phases.items()}
        return meta

    def _blocks(self, truth: bool) -> Iterator[dict[str, FloatArray]]:
        setup, clock = self._setup, self._setup.sensor.clock
        motion, step = setup.motion, 1.0 / setup.rate
        jitter = stream(self._seed, Part.CLOCK)
        thermometer = stream(self._seed, Part.TEMPERATURE)
        disturbing = [stream(self._seed, Part.DISTURBANCE, i) for i in range(len(setup.disturbances))]
        before = np.array([-step])
        attitude = motion.orientation(before)
        for start in range(0, setup.count, BLOCK):
            rows = np.arange(start, min(start + BLOCK, setup.count))
            even = rows / setup.rate
            times = even
            if clock.jitter > 0.0:
                times = even + np.clip(clock.jitter * jitter.standard_normal(len(rows)), -0.45, 0.45) * step
            quat = np.concatenate((attitude.T, motion.orientation(times).T), axis=1).T
            _unwrap(quat, first=start == 0)
            ref, back = quat[1:], _quat.conjugate(quat)
            to_sensor = back[1:]
            if setup.rates == "mean":
                gyr = _quat.log(_quat.multiply(back[:-1], ref))
                gyr /= np.diff(times, prepend=before)[:, None]
            else:
                gyr = motion.angular_rate(times)
            force = motion.acceleration(times) + np.array([0.0, 0.0, setup.gravity])
            acc = _quat.rotate(to_sensor, force)
            block = {"t": even if clock.stamps == "nominal" else times, "ref": ref, "true_t": times}
            warm = None
            if setup.sensor.temperature is not None:
                warm = setup.sensor.temperature.at(times)
                block["temperature"] = setup.sensor.temperature.read(warm, thermometer)
            exact = {Part.GYR: gyr, Part.ACC: acc}
            if Part.MAG in self._triads:
                wanted = self._triads[Part.MAG].wanted(len(rows), all_of_them=truth or bool(disturbing))
                exact[Part.MAG], disturbance = self._field(times, to_sensor, disturbing, wanted)
                if truth:
                    block |= {"true_mag": exact[Part.MAG], "true_disturbance": disturbance}
            for part, errors in self._triads.items():
                crosstalk = _times(setup.sensor.g_sensitivity, acc) if part is Part.GYR else None
                name = part.name.lower()
                block[name], bias = errors.read(exact[part], warm, crosstalk)
                if truth:
                    block[f"true_{name}_bias"] = bias
            if truth:
                block |= {"true_gyr": gyr, "true_acc": acc, "true_position": motion.position(times)}
                if warm is not None:
                    block["true_temperature"] = warm
            yield block
            before, attitude = times[-1:], quat[-1:]

    def _field(
        self,
        times: FloatArray,
        to_sensor: FloatArray,
        generators: list[np.random.Generator],
        wanted: NDArray[np.intp] | None,
    ) -> tuple[FloatArray, FloatArray]:
        """What an exact magnetometer reads (T, 3) in the wanted rows, and the part of it that is a disturbance."""
        setup, count = self._setup, len(times)
        if wanted is not None:
            times, to_sensor = times[wanted], to_sensor.T[:, wanted].T
        if setup.sensor.mag_delay > 0.0:
            times = times - setup.sensor.mag_delay
            to_sensor = _quat.conjugate(setup.motion.orientation(times))
        total = _quat.rotate(to_sensor, np.broadcast_to(setup.earth_field, (len(times), 3)))
        if wanted is not None:
            some, total = total, np.zeros((3, count)).T
            total[wanted] = some
        if not setup.disturbances:
            return total, np.zeros_like(total)
        position = setup.motion.position(times)
        disturbance = np.zeros_like(total)
        for one, generator in zip(setup.disturbances, generators, strict=True):
            added = one.field(times, position, generator)
            disturbance += _quat.rotate(to_sensor, added) if one.frame == "earth" else added
        return total + disturbance, disturbance


class _Errors:
    """The errors of one triad, drawn and then applied block after block."""

    def __init__(self, triad: Triad, seed: int, part: Part, rate: float, count: int) -> None:
        self._triad = triad
        drawn = stream(seed, part, Effect.BIAS).standard_normal(3)
        self.bias: FloatArray = np.broadcast_to(triad.bias, 3) + np.broadcast_to(triad.bias_deviation, 3) * drawn
        errors = stream(seed, part, Effect.MATRIX).standard_normal((3, 3))
        deviation = np.full((3, 3), triad.misalignment_deviation)
        np.fill_diagonal(deviation, triad.scale_deviation)
        self.matrix: FloatArray = np.array(triad.matrix) + deviation * errors
        self._white = _column(np.hypot(np.multiply(triad.density, math.sqrt(0.5 * rate)), triad.noise))
        self._gain_slope, self._bias_slope = _column(triad.gain_slope), _column(triad.bias_slope)
        self._white_stream = stream(seed, part, Effect.WHITE)
        self._drift = Drift(triad, seed, part, rate, count)
        self._missing = missing_rows(triad.dropout, triad.dropout_length, count, stream(seed, part, Effect.MISSING))
        if triad.rate is not None and triad.rate < rate:
            # A row is read when a sample of the slower sensor has come since the row before.
            ready = np.floor(np.arange(count) * (triad.rate / rate) + 1e-9)
            self._missing |= np.diff(ready, prepend=-1.0) == 0.0
        self._any_missing = bool(self._missing.any())
        self._done = 0

    def wanted(self, count: int, *, all_of_them: bool) -> NDArray[np.intp] | None:
        """Which of the next rows are read; None: all."""
        if all_of_them or not self._any_missing:
            return None
        return np.flatnonzero(~self._missing[self._done : self._done + count])

    def read(
        self, exact: FloatArray, temperature: FloatArray | None, crosstalk: FloatArray | None
    ) -> tuple[FloatArray, FloatArray]:
        """The readings (T, 3) of the next rows, and their additive error without white noise."""
        triad, rows = self._triad, slice(self._done, self._done + len(exact))
        self._done = rows.stop
        # In a fixed order and not by a library's matrix product, whose roundings differ from one machine to the next.
        x, m = exact.T, self.matrix
        value = m[:, :1] * x[0]
        for axis in (1, 2):
            if m[:, axis].any():
                value += m[:, axis : axis + 1] * x[axis]
        bias = np.repeat(self.bias, len(exact)).reshape(3, -1)
        if temperature is not None:
            away = temperature - triad.reference_temperature
            value += self._gain_slope * away * x
            bias += self._bias_slope * away
        if self._drift:
            bias += self._drift.at(rows.start, rows.stop).T
        value += bias
        if crosstalk is not None:
            value += crosstalk.T
        if self._white.any():
            value += self._white * self._white_stream.standard_normal((len(exact), 3)).T
        if triad.range is not None:
            np.clip(value, -triad.range, triad.range, out=value)
        if triad.resolution > 0.0:
            value /= triad.resolution
            np.rint(value, out=value)
            value *= triad.resolution
        if self._any_missing:
            value[:, self._missing[rows]] = np.nan
        return value.T, bias.T


def _column(value: ArrayLike) -> FloatArray:
    """One number or three as (3, 1)."""
    return np.broadcast_to(np.asarray(value, dtype=np.float64), 3)[:, None]


def _times(sensitivity: Any, force: FloatArray) -> FloatArray | None:
    """What the gyroscope reads of the specific force, or None."""
    matrix = np.asarray(sensitivity, dtype=np.float64)
    if not matrix.any():
        return None
    return force * matrix if matrix.ndim == 0 else (force[:, None, :] * matrix).sum(axis=2)


def _unwrap(quat: FloatArray, *, first: bool) -> None:
    """Give quaternions (T, 4) the signs with which they are continuous, at first with w ≥ 0 in the second."""
    turned = (quat[1:] * quat[:-1]).sum(axis=1) < 0.0
    if turned.any():
        quat[1:] *= np.cumprod(np.where(turned, -1.0, 1.0))[:, None]
    if first and quat[1, 0] < 0.0:
        np.negative(quat, out=quat)


def _shown(disturbance: Disturbance) -> dict[str, Any]:
    """Kind and parameters of a disturbance; JSON has no infinity, which is told as None."""
    names: list[str] = [one.name for one in fields(disturbance)] if is_dataclass(disturbance) else []
    values = {name: getattr(disturbance, name) for name in names}
    return {"kind": type(disturbance).__name__} | {name: None if v == math.inf else v for name, v in values.items()}


def check_positive(name: str, value: float) -> None:
    """Raise a ValueError unless the value is a positive finite number."""
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name}: expected a positive number, got {value}")


def check_seed(seed: int) -> None:
    """Raise a ValueError for a negative seed."""
    if seed < 0:
        raise ValueError(f"seed: expected an integer that is not negative, got {seed}")
