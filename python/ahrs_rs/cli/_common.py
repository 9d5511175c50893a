"""What the commands share: filters and their parameters, reading recordings, checking output paths."""

from __future__ import annotations

import argparse
import dataclasses
import importlib
import itertools
import math
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _atomic, metrics
from ahrs_rs._engine import FRAMES, GYR_HOLDS
from ahrs_rs._filter import Filter
from ahrs_rs._finished import Finished
from ahrs_rs._own import register
from ahrs_rs._recording import Recording
from ahrs_rs._validate import did_you_mean
from ahrs_rs.filters import FILTERS

Commands: TypeAlias = "argparse._SubParsersAction[Any]"
#: Outputs, each with a function that writes it to the path that it is given.
Writers: TypeAlias = dict[Path, Callable[[Path], object]]


class CliError(Exception):
    """What the user has to change, in one line."""


@dataclass(frozen=True, slots=True)
class Settings:
    """What is asked of every filter alike."""

    frame: str = "ENU"
    declination: float = 0.0
    """rad"""
    gyr_hold: str = GYR_HOLDS[0]
    six_axes: bool = False
    """Leave the magnetometer out."""

    @classmethod
    def of(cls, args: argparse.Namespace) -> Settings:
        """As the arguments of `add_settings` say."""
        return cls(args.frame, math.radians(args.declination), args.gyr_hold, args.six_axes)


@dataclass(frozen=True, slots=True)
class Choice:
    """A filter class with the parameters that were given; all others keep their defaults."""

    cls: type[Filter]
    params: Mapping[str, float | str | bool]

    def make(self, rate: float, settings: Settings, frame: str | None = None) -> Filter:
        """The filter for a rate in Hz, in another earth frame than the settings' where one is given."""
        keywords: dict[str, Any] = dict(self.params)
        return self.cls(
            rate=rate,
            frame=frame or settings.frame,
            declination=settings.declination,
            gyr_hold=settings.gyr_hold,
            **keywords,
        )

    @property
    def changes(self) -> str:
        """The parameters that are not the defaults, like "beta=0.08 gradient=paper"."""
        defaults = {name: param.default for name, param in self.cls.PARAMS.items()}
        changed = {name: value for name, value in self.params.items() if value != defaults[name]}
        return " ".join(f"{name}={shown(value)}" for name, value in changed.items())

    @property
    def label(self) -> str:
        """Name and changed parameters."""
        return f"{self.cls.NAME} {self.changes}".rstrip()


def shown(value: float | str | bool) -> str:
    """A parameter's value for reading: six digits are enough."""
    return str(value) if isinstance(value, (str, bool)) else f"{value:.6g}"


def find_filter(name: str) -> type[Filter]:
    """The class of a filter by its name in any case, or of one's own as MODULE:NAME or NAME=FILES."""
    if ":" in name or "=" in name:
        return _own_filter(name)
    by_name = {known.lower(): cls for known, cls in (*FILTERS.items(), *FILTERS.own.items())}
    cls: type[Filter] | None = by_name.get(name.lower())
    if cls is None:
        raise CliError(f"unknown filter {name!r}{did_you_mean(name, FILTERS)}; there are {', '.join(FILTERS)}")
    return cls


def _own_filter(text: str) -> type[Filter]:
    """A class or function of a module that Python finds from here, or orientations of files; it is registered."""
    label, equals, files = text.partition("=")
    if equals:
        if not (label and files):
            raise CliError(f"--filter {text}: expected NAME=FILES of finished orientations, got an empty part")
        return cast("type[Filter]", register(Finished(files, name=label)))
    module, _, attribute = text.partition(":")
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        found: Any = importlib.import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError, SyntaxError, ValueError) as error:  # ValueError: no name of a module
        raise CliError(
            f"--filter {text}: expected MODULE:NAME of a filter, got {type(error).__name__}: {error}"
        ) from None
    finally:
        sys.path.remove(here)
    try:
        return cast("type[Filter]", register(found))
    except (TypeError, ValueError) as error:
        raise CliError(f"--filter {text}: {error}") from None


def choose(cls: type[Filter], preset: str | None, texts: Mapping[str, str]) -> Choice:
    """A filter with the values of a preset, over which the texts of ``--set`` go."""
    params: dict[str, float | str | bool] = {}
    if preset is not None:
        if preset not in cls.PRESETS:
            known = ", ".join(cls.PRESETS) or "none"
            raise CliError(f"{cls.NAME} has no preset {preset!r}{did_you_mean(preset, cls.PRESETS)}; it has {known}")
        params |= cls.PRESETS[preset]
    return Choice(cls, params | {name: _value(cls, name, text) for name, text in texts.items()})


def assignments(texts: Sequence[str]) -> dict[str, str]:
    """NAME=VALUE pairs as a dict; of a name that comes twice, the last value."""
    pairs = {}
    for text in texts:
        name, sign, value = (part.strip() for part in text.partition("="))
        if not (name and sign and value):
            raise CliError(f"--set: expected NAME=VALUE, got {text!r}")
        pairs[name] = value
    return pairs


def unknown_parameter(owner: str, name: str, known: Iterable[str]) -> CliError:
    """The error for a parameter that the owner, "Madgwick has" or the like, does not have."""
    names = list(known)
    return CliError(f"{owner} no parameter {name!r}{did_you_mean(name, names)}; there are {', '.join(names) or 'none'}")


def _value(cls: type[Filter], name: str, text: str) -> float | str | bool:
    param = cls.PARAMS.get(name)
    if param is None:
        raise unknown_parameter(f"{cls.NAME} has", name, cls.PARAMS)
    value: float | str | bool = text
    if param.options is None:
        try:
            value = float(text)
        except ValueError:
            raise CliError(f"{cls.NAME}.{name}: expected a number, got {text!r}") from None
    elif isinstance(param.default, bool):
        value = {"true": True, "false": False}.get(text.lower(), text)
    try:
        param.encode(value)
    except ValueError as error:
        raise CliError(f"{cls.NAME}.{error}") from None
    return value


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Options of `Settings`."""
    group = parser.add_argument_group("computation")
    group.add_argument(
        "--6d",
        dest="six_axes",
        action="store_true",
        help="leave the magnetometer out: the heading is then relative to the start",
    )
    group.add_argument(
        "--frame",
        type=str.upper,
        choices=FRAMES,
        metavar="NAME",
        default="ENU",
        help="earth frame: %(choices)s (default: %(default)s)",
    )
    group.add_argument(
        "--declination",
        type=finite,
        default=0.0,
        metavar="DEG",
        help="magnetic declination, positive east, which makes the heading one from true north (default: 0)",
    )
    group.add_argument(
        "--gyr-hold",
        choices=GYR_HOLDS,
        metavar="NAME",
        default=GYR_HOLDS[0],
        help="angular rate between two samples: %(choices)s (default: %(default)s)",
    )


def add_align(parser: argparse.ArgumentParser) -> None:
    """Options of `Aligner`."""
    parser.add_argument(
        "--align",
        action="store_true",
        help="take constant rotations of the earth and the sensor frame and an offset of the clocks out of the errors "
        "(least squares, for each file and filter)",
    )
    parser.add_argument(
        "--align-parts",
        metavar="NAMES",
        help="only these of earth or heading, sensor, time, like --align-parts heading,time",
    )


@dataclass(frozen=True, slots=True)
class Aligner:
    """What of the alignment between an estimate and the reference does not count as an error."""

    earth: str = "none"
    sensor: bool = False
    time: bool = False

    @classmethod
    def of(cls, args: argparse.Namespace) -> Aligner:
        """As the arguments of `add_align` say."""
        if args.align_parts is None:
            return cls("full", True, True) if args.align else cls()
        parts = {name.strip().lower() for name in args.align_parts.split(",") if name.strip()}
        if not parts or not parts <= {"earth", "heading", "sensor", "time"} or parts >= {"earth", "heading"}:
            raise CliError(f"--align-parts: expected some of earth or heading, sensor, time, got {args.align_parts!r}")
        earth = "full" if "earth" in parts else "heading" if "heading" in parts else "none"
        return cls(earth, "sensor" in parts, "time" in parts)

    def __bool__(self) -> bool:
        return self.sensor or self.time or self.earth != "none"

    def pair(self, quat: NDArray[Any], recording: Recording) -> tuple[NDArray[Any], NDArray[np.float64], list[str]]:
        """Estimate and reference as they are to be compared, and what must be known of their alignment."""
        assert recording.ref is not None
        if not self:
            return quat, recording.ref, []
        times: dict[str, Any] = {"mask": recording.mask, "t": recording.t, "check": False}
        lines = []
        try:
            found = metrics.align(quat, recording.ref, earth=self.earth, sensor=self.sensor, time=self.time, **times)
        except ValueError as error:
            if not self.time:
                raise CliError(f"--align: {error}") from None
            lines.append("aligned without an offset of the clocks, which was not found")
            found = metrics.align(quat, recording.ref, earth=self.earth, sensor=self.sensor, time=False, **times)
        if not found.determined:
            lines.append("the motion does not determine the rotation of the sensor frame; one that fits was taken")
        return *found.pair(quat, recording.ref), lines


UNALIGNED = Aligner()


def finite(text: str) -> float:
    """A finite number, for argparse."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"expected a number, got {text!r}")
    return number


def positive(text: str) -> float:
    """A positive finite number, for argparse."""
    number = finite(text)
    if number <= 0.0:
        raise argparse.ArgumentTypeError(f"expected a positive number, got {text!r}")
    return number


def check_outputs(outputs: Mapping[str, Path | None], inputs: Iterable[Path] = ()) -> None:
    """`check_output` of the paths of several options, which are not to be one file."""
    inputs = list(inputs)
    given = [(option, path) for option, path in outputs.items() if path is not None]
    for option, path in given:
        check_output(path, option, inputs)
    for (first, path), (second, other) in itertools.combinations(given, 2):
        if _same_file(path, other):
            raise CliError(f"{first} and {second}: expected two files, got {other} twice")


def _same_file(path: Path, other: Path) -> bool:
    if path.resolve() == other.resolve():
        return True
    return path.exists() and other.exists() and path.samefile(other)


def write_all(writers: Writers, folder: Path | None = None) -> None:
    """The files of a command: none of them changes if one cannot be written.

    A folder is made where it is not there.
    """
    with _atomic.Together() as files:
        if folder is not None:
            files.folder(folder)
        for path, write in writers.items():
            with files.replacing(path) as beside:
                write(beside)


def check_output(path: Path, option: str, inputs: Iterable[Path] = ()) -> None:
    """Raise a `CliError`, before anything is computed, where a file cannot be written to the path."""
    if path.is_dir():
        raise CliError(f"{option}: {path} is a directory")
    if not path.parent.is_dir():
        raise CliError(f"{option}: {path}: there is no directory {path.parent}")
    for one in (path, path.resolve().parent):  # a file is replaced, which is to change its folder
        if one.exists() and not os.access(one, os.W_OK):
            raise CliError(f"{option}: {path} cannot be written: permission denied")
    for given in inputs:
        if path.exists() and given.exists() and path.samefile(given):
            raise CliError(f"{option}: {path} is the recording itself")


def magnetometer(recording: Recording, settings: Settings) -> NDArray[np.float64] | None:
    """The magnetometer's samples (T, 3), unless they are to be left out."""
    return None if settings.six_axes else recording.mag


def measurements(recording: Recording, settings: Settings) -> Recording:
    """What a filter is to be given of a recording: without the magnetometer, if that is to be left out."""
    if not settings.six_axes or recording.mag is None:
        return recording
    return dataclasses.replace(recording, mag=None)


def score_frame(recording: Recording, settings: Settings) -> str:
    """The earth frame of the recording's reference: the one that it names, or else that of the settings."""
    named = recording.meta.get("ref_frame")
    return named if named in FRAMES else settings.frame


def scored(recording: Recording) -> int:
    """How many samples have a reference and count."""
    if recording.ref is None:
        return 0
    known = ~np.isnan(recording.ref).any(axis=1)
    return int(np.count_nonzero(known if recording.mask is None else known & recording.mask))


def notes(recording: Recording, settings: Settings, aligner: Aligner = UNALIGNED) -> list[str]:
    """What must be known to judge the errors of the recording's estimates."""
    found = []
    if scored(recording):
        frame = recording.meta.get("ref_frame")
        if frame is not None and frame not in FRAMES and aligner.earth == "none":
            found.append(f"the reference frame is not the earth frame ({frame}): the errors hold a constant rotation")
        elif magnetometer(recording, settings) is None and aligner.earth == "none":
            found.append("without a magnetometer the heading is relative to the start, and so are its errors")
    return found
