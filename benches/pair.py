"""Times two builds of the package beside each other, and compares their bits: `make pair`.

Each build runs in a process of its own that stays alive and is asked in alternation, so that a machine whose speed
drifts slows both; a few processes follow each other, as each has its own luck with memory. What is timed is one of

- filters on simulated recordings (the default; `--filter`, `--dtype`, `--recordings`),
- a statement of Python (`--setup`, `--statement`; several pairs are timed in one run),
- a command (`--command`), a new process each time, in the environment of each build.

A line for each: the medians of both, the median over the alternations of new time over old with its quartiles, and
whether results have the same bits. A build beside itself (`--old python --new python`) shows what a ratio can tell:
0.98 to 1.02 on two busy cores. Exit status 1 where bits differ (unless `--any-bits`), or where a median of ratios is
above `--limit`.

    python benches/pair.py --filter Madgwick,VQF --dtype f64,f32 --recordings 1,64
    python benches/pair.py --setup "import ahrs_rs as ar; r = ar.simulate.demo(60, 286)" --statement "r.save('r.npz')"
    python benches/pair.py --command "ahrs-rs demo -o target/pair"
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import os
import pickle
import shlex
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parents[1]
#: That of `make baseline`.
BASELINE = HERE / "target" / "baseline" / "3962d5a" / "python"
#: As many as Ludwig & Burnham's recording.
SAMPLES = 6401
RATE = 286.0
CLOCKS = {"wall": time.perf_counter_ns, "cpu": time.process_time_ns}


@dataclass(frozen=True)
class Filters:
    """A filter at its defaults on as many copies of a recording."""

    name: str
    dtype: str
    recordings: int
    threads: int | None
    #: Arrays (T, 3) of the sensors, the same for both builds.
    sensors: list[Any]

    def __str__(self) -> str:
        return f"{self.name} {3 * len(self.sensors)}D {self.dtype} × {self.recordings}"

    @property
    def unit(self) -> tuple[str, float]:
        """What one thing of a call is, and how many there are."""
        return "ns/sample", len(self.sensors[0]) * self.recordings

    def prepared(self) -> Callable[[], object]:
        import numpy as np

        import ahrs_rs as ar

        dtype = {"f64": np.float64, "f32": np.float32}[self.dtype]
        arrays = [np.asarray(v, dtype) for v in self.sensors]
        f = ar.FILTERS[self.name](rate=RATE)
        if self.recordings > 1:
            # Recordings that differ, so that lanes do, too.
            arrays = [np.stack([np.roll(v, 7 * i, axis=0) for i in range(self.recordings)]) for v in arrays]
        # Room that is there: asking the system for it takes some processes longer than others.
        out = np.empty((*arrays[0].shape[:-1], 4), dtype)
        return lambda: f.run(*arrays, out=out, threads=self.threads)


@dataclass(frozen=True)
class Statement:
    """A statement of Python; its value, if it is an expression, is what is compared."""

    statement: str
    setup: str
    unit = ("µs", 1e3)

    def __str__(self) -> str:
        return self.statement

    def prepared(self) -> Callable[[], object]:
        names: dict[str, Any] = {}
        exec(self.setup, names)
        try:
            code = compile(self.statement, "<statement>", "eval")
        except SyntaxError:
            code = compile(self.statement, "<statement>", "exec")
            return lambda: exec(code, names)
        return lambda: eval(code, names)


@dataclass(frozen=True)
class Command:
    """A command; what it prints is what is compared."""

    command: str
    unit = ("ms", 1e6)

    def __str__(self) -> str:
        return self.command

    def prepared(self) -> Callable[[], object]:
        words = shlex.split(self.command)
        return lambda: subprocess.run(words, check=True, capture_output=True).stdout


Work = Filters | Statement | Command


def bits(value: object) -> str:
    """A hash of what a call gives: numbers by their bits, status bits whatever their width, else what is pickled."""
    import numpy as np

    digest = hashlib.sha256()

    def add(value: object) -> None:
        if type(value).__name__ == "Estimate":
            add([getattr(value, name, None) for name in ("quat", "gyr_bias", "extra")])
            add(np.asarray(getattr(value, "status", 0)).astype(np.uint32))
        elif isinstance(value, dict):
            add([*itertools.chain.from_iterable(sorted(value.items()))])
        elif isinstance(value, (list, tuple)):
            for each in value:
                add(each)
        elif isinstance(value, np.ndarray) and value.dtype != object:
            digest.update(f"{value.dtype} {value.shape}".encode() + np.ascontiguousarray(value).tobytes())
        elif isinstance(value, bytes):
            digest.update(value)
        else:
            digest.update(repr(value).encode())

    add(value)
    return digest.hexdigest()


# The two sides.


def worker() -> int:
    """Does what the other side asks for, until it asks for nothing more."""
    out, sys.stdout = sys.stdout.buffer, sys.stderr  # nothing else may come between the answers
    import ahrs_rs as ar

    while True:
        try:
            request, argument = pickle.load(sys.stdin.buffer)
        except EOFError:
            return 0
        answer: object
        if request == "where":
            answer = ar.__file__
        elif request == "filters":
            answer = list(ar.FILTERS)
        elif request == "record":
            rec = ar.simulate.demo(duration=argument / RATE + 1.0, rate=RATE, seed=1)[:argument]
            answer = [rec.gyr, rec.acc, rec.mag]
        elif request == "prepare":
            call = argument.prepared()
            answer = bits(call())
        else:
            turn, name = argument
            clock = CLOCKS[name]
            end, start, count = time.perf_counter_ns() + turn, clock(), 0
            while count == 0 or time.perf_counter_ns() < end:
                call()
                count += 1
            answer = (clock() - start) / count
        pickle.dump(answer, out)
        out.flush()


class Build:
    """A process with a build of the package, which is found in a folder."""

    def __init__(self, folder: Path) -> None:
        if not (folder / "ahrs_rs").is_dir():
            raise SystemExit(f"pair: there is no ahrs_rs in {folder}; `make baseline` builds the one of the past")
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
        env = {**os.environ, "PYTHONPATH": str(folder), "PATH": path}
        words = [sys.executable, str(Path(__file__).resolve()), "--worker"]
        self.process = subprocess.Popen(words, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        where = Path(self.ask("where"))
        if not where.is_relative_to(folder):
            raise SystemExit(f"pair: {folder} was asked for, but {where} was imported")

    def ask(self, request: str, argument: object = None) -> Any:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        pickle.dump((request, argument), self.process.stdin)
        self.process.stdin.flush()
        try:
            return pickle.load(self.process.stdout)
        except EOFError:
            raise SystemExit("pair: a build's process has ended; its error stands above") from None

    def close(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


@dataclass(frozen=True)
class Pair:
    """What was found of a piece of work: ns of a call in each alternation, and whether the bits are the same."""

    work: Work
    old: list[float]
    new: list[float]
    same: bool

    @property
    def ratios(self) -> list[float]:
        return [new / old for old, new in zip(self.old, self.new, strict=True)]

    def __str__(self) -> str:
        unit, size = self.work.unit
        times = [f"{statistics.median(each) / size:9.4g}" for each in (self.old, self.new)]
        low, median, high = statistics.quantiles(self.ratios, n=4, method="inclusive")
        spread = f"{median:6.3f}  [{low:.3f}, {high:.3f}]"
        return f"{self.work!s:34} {' '.join(times)} {unit:9}  {spread}  {'equal' if self.same else 'DIFFERENT'}"


def measured(work: Work, args: argparse.Namespace) -> Pair:
    """Both builds in alternation; which one begins alternates, too."""
    # What other processes take from a core is no part of a build's time; of several threads it cannot be told.
    clock = args.clock or ("cpu" if args.threads == 1 and not isinstance(work, Command) else "wall")
    turn = (args.turn * 1e6, clock)
    same = True
    times: dict[str, list[float]] = {"old": [], "new": []}
    share = -(-args.rounds // args.processes)
    for first in range(0, args.rounds, share):
        with builds(args, reverse=first // share % 2 == 1) as both:
            same &= len({build.ask("prepare", work) for build in both.values()}) == 1
            for build in both.values():
                build.ask("time", turn)  # warms up
            for number in range(first, min(args.rounds, first + share)):
                for name in sorted(both, reverse=number % 2 == 1):
                    times[name].append(both[name].ask("time", turn))
    return Pair(work, times["old"], times["new"], same)


@contextmanager
def builds(args: argparse.Namespace, *, reverse: bool = False) -> Iterator[dict[str, Build]]:
    """New processes of both builds: which one begins, and where its memory happens to lie, makes up to a twentieth."""
    folders = {"old": args.old.resolve(), "new": args.new.resolve()}
    both = {name: Build(folders[name]) for name in sorted(folders, reverse=reverse)}
    yield both
    for build in both.values():
        build.close()


def works(args: argparse.Namespace) -> Iterator[Work]:
    if args.statement or args.command:
        setups = args.setup if len(args.setup) > 1 else (args.setup or [""]) * len(args.statement)
        if len(setups) != len(args.statement):
            raise SystemExit(f"pair: --setup: expected one or {len(args.statement)}, got {len(setups)}")
        yield from (Statement(*both) for both in zip(args.statement, setups, strict=True))
        yield from (Command(command) for command in args.command)
        return
    with builds(args) as both:
        names = both["old"].ask("filters") if args.filter == "all" else args.filter.split(",")
        sensors = both["old"].ask("record", args.samples)[: 2 if args.six else 3]
    for name, dtype, recordings in itertools.product(names, args.dtype.split(","), args.recordings.split(",")):
        yield Filters(name, dtype, int(recordings), args.threads or None, sensors)


def parsed(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add(
        "--old",
        type=Path,
        default=BASELINE,
        metavar="DIR",
        help="folder of the old build (default: that of `make baseline`)",
    )
    add(
        "--new",
        type=Path,
        default=HERE / "python",
        metavar="DIR",
        help="folder of the new one (default: this checkout's)",
    )
    add(
        "--filter", default="Madgwick,VQF,SelfCalKF", metavar="NAMES", help="class names, or all (default: %(default)s)"
    )
    add("--dtype", default="f64,f32", metavar="DTYPES", help="(default: %(default)s)")
    add("--recordings", default="1,64", metavar="COUNTS", help="of equal length (default: %(default)s)")
    add("--samples", type=int, default=SAMPLES, metavar="T", help="of a recording (default: %(default)s)")
    add("--six", action="store_true", help="without a magnetometer")
    add(
        "--threads",
        type=int,
        default=1,
        metavar="N",
        help="of several recordings; 0 is one a core (default: %(default)s)",
    )
    add(
        "--setup",
        action="append",
        default=[],
        metavar="CODE",
        help="before a statement, once; one for each, or for all",
    )
    add("--statement", action="append", default=[], metavar="CODE", help="what is timed instead of filters")
    add("--command", action="append", default=[], metavar="LINE", help="what is timed instead of filters")
    add("--rounds", type=int, default=15, metavar="N", help="alternations (default: %(default)s)")
    add(
        "--processes",
        type=int,
        default=3,
        metavar="N",
        help="of each build, one after the other (default: %(default)s)",
    )
    add("--turn", type=float, default=20.0, metavar="MS", help="that a turn lasts at least (default: %(default)s)")
    add(
        "--clock",
        choices=list(CLOCKS),
        help="wall time, or that of the processor (default: cpu for what has one thread)",
    )
    add("--limit", type=float, metavar="RATIO", help="of new time over old, above which the exit status is 1")
    add("--any-bits", action="store_true", help="bits may differ")
    add("--worker", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args(words)
    if not 1 <= args.processes <= args.rounds or args.rounds < 2:
        parser.error("expected at least 2 --rounds, and 1 to as many --processes")
    return args


def main(words: Sequence[str] | None = None) -> int:
    args = parsed(words)
    if args.worker:
        return worker()
    print(f"{args.rounds} alternations; median [quartiles] of new time over old; old: {args.old}", flush=True)
    print(f"{'':34} {'old':>9} {'new':>9} {'':9}  {'ratio':>6}  {'quartiles':14}  bits")
    failed = False
    for work in works(args):
        pair = measured(work, args)
        print(pair, flush=True)
        failed |= not (pair.same or args.any_bits)
        failed |= args.limit is not None and statistics.median(pair.ratios) > args.limit
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
