"""``ahrs-rs compare``: errors and times of several filters on recordings with a reference."""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _atomic, metrics, plots
from ahrs_rs._printable import printable
from ahrs_rs._progress import progress_bar
from ahrs_rs._recording import Recording
from ahrs_rs.cli import _calibrated, _common, _reading
from ahrs_rs.cli._common import Aligner, Choice, CliError, Commands, Settings, Writers
from ahrs_rs.filters import FILTERS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: A filter's time on a recording is the shortest of so many runs.
REPEATS = 3
#: So many recordings at most are drawn side by side; more of them are drawn as lines with their mean.
PANELS = 3

EPILOG = """\
The errors are root-mean-square, in degrees, over the samples that have a reference and count (mask).

  ahrs-rs compare trials/*.hdf5 --plot errors.png
  ahrs-rs compare TStick*.csv --filters vqf,mekf --align
  ahrs-rs compare walk.csv --filters madgwick,mahony --set madgwick.beta=0.08 --csv table.csv
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "compare",
        help="errors and times of several filters on recordings with a reference",
        description="Run several filters on recordings with a reference orientation, and print their errors.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=compare)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recordings (csv, parquet, npz, hdf5)")
    parser.add_argument(
        "--filter", "--filters", dest="filters", default="all", metavar="NAMES", help="all (the default), or name,name"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter, as madgwick.beta=0.08, or beta=0.08 for every filter that has it; may be repeated",
    )
    parser.add_argument("--preset", metavar="NAME", help="the parameters of a paper, for the filters that have them")
    parser.add_argument("--per-file", action="store_true", help="a row for every file too")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the errors over time (png, pdf, svg)")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the table")
    _common.add_align(parser)
    _reading.add_reference(parser)
    _reading.add_reading(parser)
    _calibrated.add_option(parser)
    _common.add_settings(parser)


def compare(args: argparse.Namespace) -> int:
    """The command."""
    choices = choose_all(args.filters, args.preset, args.set)
    _check_outputs(args)
    for path in args.files:
        if not path.exists() and str(path) != "-":
            raise CliError(f"{path}: no such file")
    paths = list(dict.fromkeys(args.files))
    comparison = Comparison(choices, Settings.of(args), Aligner.of(args), plot=args.plot is not None)
    calibrations = _calibrated.given(args)

    def recordings() -> Iterator[tuple[str, Recording]]:
        for name, path in zip(_short_names(paths), paths, strict=True):
            recording, said = _calibrated.applied(
                calibrations, _reading.with_reference(_reading.read(path, args), args)
            )
            for note in [*said, *(f"{key}: {text}" for key, text in _reading.told(recording))]:
                comparison.notes.setdefault(note, []).append(name)
            yield name, recording

    comparison.evaluate(recordings(), len(paths))
    if not comparison.results:
        raise CliError(f"nothing to compare with: {'; '.join(comparison.note_lines())}")

    count = len({result.file for result in comparison.results})
    rows = comparison.means() + (comparison.results if args.per_file else [])
    outputs: Writers = {}
    if args.csv is not None:
        outputs[args.csv] = lambda path: write_csv(path, rows)
    if args.plot is not None:
        outputs[args.plot] = lambda path: plots.save(comparison.figure(), path)
    _common.write_all(outputs)
    print(table(rows, count, aligned=bool(comparison.aligner)))
    _print_end(args, comparison)
    return 0


def _print_end(args: argparse.Namespace, comparison: Comparison) -> None:
    lines = [f"note: {note}" for note in comparison.note_lines()]
    lines += [f"wrote {printable(args.csv)}"] if args.csv is not None else []
    lines += [f"wrote {printable(args.plot)}"] if args.plot is not None else []
    if lines:
        print("\n" + "\n".join(lines))


def choose_all(names: str, preset: str | None, texts: Sequence[str]) -> list[Choice]:
    """The filters with the parameters that the options ``--filters``, ``--preset`` and ``--set`` say.

    A parameter given for one filter goes before the same one given for all.
    """
    wanted = [name.strip() for name in names.split(",") if name.strip()]
    if not wanted:
        raise CliError("--filters: expected all, or names like madgwick,mahony")
    classes = list(FILTERS.values()) if names.strip().lower() == "all" else [*map(_common.find_filter, wanted)]
    classes = list(dict.fromkeys(classes))
    if preset is not None and not any(preset in cls.PRESETS for cls in classes):
        known = sorted({name for cls in classes for name in cls.PRESETS})
        raise CliError(f"none of these filters has the preset {preset!r}; there are {', '.join(known) or 'none'}")
    general: dict[str, str] = {}
    special: dict[str, dict[str, str]] = {}
    for target, value in _common.assignments(texts).items():
        owner, dot, name = target.rpartition(".")
        if not dot:
            general[name] = value
            continue
        cls = _common.find_filter(owner)
        if cls not in classes:
            raise CliError(f"--set {target}: {cls.NAME} is not among the compared filters")
        special.setdefault(cls.NAME, {})[name] = value
    params = list(dict.fromkeys(name for cls in classes for name in cls.PARAMS))
    for name in general:
        if name not in params:
            raise _common.unknown_parameter("these filters have", name, params)
    return [
        _common.choose(
            cls,
            preset if preset in cls.PRESETS else None,
            {name: value for name, value in general.items() if name in cls.PARAMS} | special.get(cls.NAME, {}),
        )
        for cls in classes
    ]


def _check_outputs(args: argparse.Namespace) -> None:
    _common.check_outputs({"--csv": args.csv, "--plot": args.plot}, args.files)
    if args.plot is not None:
        plots.require_matplotlib()
        try:
            plots.check_ending(args.plot)
        except ValueError as error:
            raise CliError(f"--plot: {str(error).removeprefix('path: ')}") from None


@dataclass(frozen=True, slots=True)
class Result:
    """Errors and time of a filter on one file, or (`file` is empty) on all of them: a row of the table."""

    filter: str
    parameters: str
    file: str
    sensors: str
    samples: int
    total_deg: float
    heading_deg: float
    inclination_deg: float
    ns_per_sample: float


@dataclass(frozen=True, slots=True)
class _Job:
    """One filter on one recording."""

    name: str
    recording: Recording
    panel: plots.ErrorPanel | None
    choice: Choice


class Comparison:
    """Several filters on several recordings: results, notes for the reader, and the curves to be drawn."""

    def __init__(
        self, choices: Sequence[Choice], settings: Settings, aligner: Aligner = _common.UNALIGNED, *, plot: bool
    ) -> None:
        self.choices = list(choices)
        self.settings = settings
        self.aligner = aligner
        self.plot = plot
        self.results: list[Result] = []
        self.notes: dict[str, list[str]] = {}
        self.panels: list[plots.ErrorPanel] = []

    def evaluate(self, recordings: Iterable[tuple[str, Recording]], count: int) -> None:
        """Run all filters on `count` named recordings; one without a reference is skipped, with a note."""
        jobs = progress_bar(self._jobs(recordings), total=count * len(self.choices), unit="run")
        for job in jobs:
            result, quat, ref = self._evaluate(job)
            self.results.append(result)
            if job.panel is not None:
                job.panel.add(job.choice.label, quat, ref)

    def _jobs(self, recordings: Iterable[tuple[str, Recording]]) -> Iterator[_Job]:
        for name, recording in recordings:
            if not _common.scored(recording):
                lack = "no reference" if recording.ref is None else "no reference at any sample that counts"
                self.notes.setdefault(f"skipped, {lack}", []).append(name)
                continue
            for note in _common.notes(recording, self.settings, self.aligner):
                self.notes.setdefault(note, []).append(name)
            panel = None
            if self.plot:
                panel = plots.ErrorPanel(recording, name)
                self.panels.append(panel)
            for choice in self.choices:
                yield _Job(name, recording, panel, choice)
            if panel is not None:
                panel.finish()

    def note_lines(self) -> list[str]:
        """What must be known to judge the results, with the names of the files that it is about."""
        return [f"{note}: {', '.join(names)}" for note, names in self.notes.items()]

    def _evaluate(self, job: _Job) -> tuple[Result, NDArray[Any], NDArray[np.float64]]:
        recording = job.recording
        measured = _common.measurements(recording, self.settings)
        f = job.choice.make(recording.rate, self.settings, _common.score_frame(recording, self.settings))
        times = []
        for _ in range(REPEATS):
            begin = time.perf_counter_ns()
            est = f.run(measured, threads=1)
            times.append(time.perf_counter_ns() - begin)
        quat, ref, said = self.aligner.pair(est.quat, recording)
        for note in said:
            about = self.notes.setdefault(note, [])
            about += [] if job.name in about else [job.name]
        errors = metrics.score(quat, ref, recording.mask)
        result = Result(
            filter=f.NAME,
            parameters=job.choice.changes,
            file=job.name,
            sensors="9D" if measured.mag is not None and f.MAGNETOMETER else "6D",
            samples=len(recording),
            total_deg=float(errors.total),
            heading_deg=float(errors.heading),
            inclination_deg=float(errors.inclination),
            ns_per_sample=min(times) / len(recording),
        )
        return result, quat, ref

    def means(self) -> list[Result]:
        """A row for every filter, the smallest total error first: errors are means over the files."""
        rows = []
        for choice in self.choices:
            own = [result for result in self.results if result.filter == choice.cls.NAME]
            samples = sum(result.samples for result in own)
            rows.append(
                Result(
                    filter=choice.cls.NAME,
                    parameters=choice.changes,
                    file="",
                    sensors="/".join(sorted({result.sensors for result in own})),
                    samples=samples,
                    total_deg=float(np.mean([result.total_deg for result in own])),
                    heading_deg=float(np.mean([result.heading_deg for result in own])),
                    inclination_deg=float(np.mean([result.inclination_deg for result in own])),
                    ns_per_sample=sum(result.ns_per_sample * result.samples for result in own) / samples,
                )
            )
        return sorted(rows, key=lambda row: row.total_deg)

    def best(self) -> Choice:
        """The filter with the smallest total error."""
        name = self.means()[0].filter
        return {choice.cls.NAME: choice for choice in self.choices}[name]

    def figure(self) -> Figure:
        """The errors over time, filters in the order of the table: each recording by itself, or many in one figure."""
        labels = [f"{row.filter} {row.parameters}".rstrip() for row in self.means()]
        if len(self.panels) <= PANELS:
            return plots.draw(self.panels, labels)
        scores = {
            label: {
                name: [getattr(one, f"{name}_deg") for one in self.results if one.filter == row.filter]
                for name in plots.ERRORS
            }
            for label, row in zip(labels, self.means(), strict=True)
        }
        return plots.draw_many(self.panels, labels, scores)


def table(rows: Sequence[Result], files: int, *, aligned: bool = False) -> str:
    """The results as text."""
    over = (f"mean over {files} files" if files > 1 else "one file") + (", aligned" if aligned else "")
    lines = [f"RMSE in degrees ({over}); time: the best of {REPEATS} runs, one thread", ""]
    with_file = any(row.file for row in rows)
    head = ["filter", *(["file"] if with_file else []), "sensors"]
    cells = [[*head, "total", "heading", "inclination", "ns/sample"]]
    for row in rows:
        errors = (f"{value:.2f}" for value in (row.total_deg, row.heading_deg, row.inclination_deg))
        name = f"{row.filter} {row.parameters}".rstrip()
        file = [row.file or "(mean)"] if with_file else []
        cells.append([name, *file, row.sensors, *errors, f"{row.ns_per_sample:.0f}"])
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for line in cells:
        padded = [
            text.ljust(width) if i < len(head) else text.rjust(width)
            for i, (text, width) in enumerate(zip(line, widths, strict=True))
        ]
        lines.append("  ".join(padded))
    return "\n".join(lines)


def write_csv(path: Path, rows: Sequence[Result]) -> None:
    """The results as a CSV file with full precision; a mean over the files has no name in `file`."""
    with _atomic.text(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([field.name for field in fields(Result)])
        writer.writerows(astuple(row) for row in rows)


def _short_names(paths: Sequence[Path]) -> list[str]:
    """Names of files without their directories, unless two have the same."""
    names = [path.name for path in paths]
    return [printable(name) for name in (names if len(set(names)) == len(names) else paths)]
