"""What a reader gives and is given: the streams of a sensor, what else a file holds, and what the user asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ahrs_rs import _optional

#: Lists of `SensorData.meta` whose sentences are told to whoever reads: in one `DataWarning`, and by the command line.
TOLD = ("assumed", "repairs", "ignored", "lost", "doubts")


#: Characters of another library's message.
LONGEST = 300


@dataclass(slots=True)
class SensorData:
    """What a file holds of one sensor, before any repair.

    Parameters
    ----------
    streams : name -> (t, values). Times in s on the sensor's own clock, all from one origin, as they were recorded:
        unsorted and with NaN where they are missing; None where the file states a rate only. Streams of one clock share
        one array. Values are float64 in the units of `Recording`: gyr (n, 3) rad/s, acc (n, 3) m/s² specific force, mag
        (n, 3) µT or normalised (then ``meta["units"]["mag"]`` is "normalised"), temperature (n,) °C, ref and
        device_quat (n, 4) scalar-first from the sensor to the earth frame, mask (n,) bool; pressure Pa,
        linear_acceleration m/s² (without gravity, which is not acc), heading rad, velocity m/s, and any other name in
        SI units. NaN is no measurement.
    rate : Hz, as the file states it; None where it is to be found from the stamps.
    meta : what else is known, JSON only:

        - units: quantity -> the unit in the file; columns: quantity -> names in the file
        - axes: those of the device, such as "front-right-down"; clock: what the stamps are, where not the sensor's own
        - ref_frame, device_frame: the earth frames of ref and device_quat ("ENU", "NED", "NWU", or in words)
        - start: the time of t = 0, ISO 8601 in UTC, where it is known
        - lists of sentences: assumed (what this file leaves open), repairs, ignored (what looks like a sensor and was
          left out), lost (packets, samples), doubts
    """

    streams: dict[str, tuple[Any, Any]]
    rate: float | None = None
    meta: dict[str, Any] = field(default_factory=dict)

    def say(self, what: str, sentence: str) -> None:
        """Add a sentence to one of the lists of `meta`, once."""
        sentences = self.meta.setdefault(what, [])
        if sentence not in sentences:
            sentences.append(sentence)


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """What the user asked a reader for; see `ahrs_rs.read`."""

    columns: Mapping[str, str | Sequence[str]] | Sequence[str] | None = None
    units: Mapping[str, str] | None = None
    axes: str | None = None
    separator: str | None = None
    decimal: str | None = None
    skip_rows: int | None = None
    sensor: str | None = None
    timezone: str | None = None
    rate: float | None = None


@dataclass(frozen=True, slots=True)
class SensorInfo:
    """What a file says of one sensor, found without reading it whole.

    Parameters
    ----------
    name : str
        As `read` takes it for ``sensor=``.
    samples : mapping
        Stream -> how many readings; None where only the whole file tells.
    rates : mapping
        Stream -> Hz; None where only the whole file tells.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> print(ar.io.SensorInfo("wrist", {"gyr": 500}, {"gyr": 100.0}))
    wrist: gyr (500 samples, 100 Hz)
    """

    name: str
    samples: Mapping[str, int | None]
    rates: Mapping[str, float | None]

    @property
    def quantities(self) -> tuple[str, ...]:
        """The names of its streams."""
        return tuple(self.samples)

    def __str__(self) -> str:
        parts = []
        for name, count in self.samples.items():
            rate = self.rates.get(name)
            known = [f"{count} samples" if count is not None else "", f"{rate:.6g} Hz" if rate is not None else ""]
            shown = ", ".join(filter(None, known))
            parts.append(f"{name} ({shown})" if shown else name)
        return f"{self.name}: {', '.join(parts)}"


def require(module: str, extra: str = "io") -> Any:
    """Import an optional module, or say how to install it."""
    return _optional.require(module, extra, "this file format needs")


def one_line(error: BaseException) -> str:
    """The message of another library's error, on one line, with as much of it as can be read."""
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"
