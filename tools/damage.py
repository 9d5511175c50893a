"""Damages a valid file of every format a thousand times, and says what reading each of them does.

Run by `make damage`. Allowed are a recording, and an error of one line with the path; everything else counts: another
exception, a crash, more than a minute, more memory than 200 MB and ten times the file. Exit status 1 if any counts.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "python"))

#: Of one file: time in s, memory in bytes, and its size this many times.
SECONDS, MEMORY, TIMES = 60.0, 200e6, 10
ROWS = 400
EXPECTED = (ValueError, FileNotFoundError, IsADirectoryError)


def main() -> int:
    """Run the trials of all formats, or of those named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("formats", nargs="*", help="names of samples; all by default")
    parser.add_argument("--count", type=int, default=1000, help="trials a format (default %(default)s)")
    parser.add_argument("--first", type=int, default=0, help="first seed (default %(default)s)")
    parser.add_argument("--verbose", action="store_true", help="name what is read shorter and not told")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        _work(options.formats[0], options.first, options.count)
        return 0
    from devices.samples import SAMPLES

    failures = 0
    for name in options.formats or SAMPLES:
        failures += _trial(name, options.first, options.count, options.verbose)
    return 1 if failures else 0


def _trial(name: str, first: int, count: int, verbose: bool) -> int:
    """Run the trials of one format in workers; a worker that dies or hangs is replaced. The number of failures."""
    outcomes: Counter[str] = Counter()
    failures: list[str] = []
    quietly: list[str] = []
    longest, most, seed = 0.0, 0.0, first
    while seed < first + count:
        command = [
            sys.executable,
            __file__,
            "--worker",
            "--first",
            str(seed),
            "--count",
            str(first + count - seed),
            name,
        ]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as worker:
            assert worker.stdout is not None
            for line in worker.stdout:
                told = json.loads(line)
                if "missing" in told:
                    print(f"{name}: skipped, {told['missing']}")
                    return 0
                seed = told["seed"] + 1
                outcomes[told["outcome"]] += 1
                longest, most = max(longest, told["seconds"]), max(most, told["memory"])
                if told["outcome"] == "read, shorter":
                    quietly.append(f"    seed {told['seed']}: {told['what']}")
                if told["wrong"]:
                    failures.append(f"seed {told['seed']} ({told['what']}): {told['wrong']}")
        if seed < first + count:
            failures.append(f"seed {seed}: the process ended with {worker.returncode}")
            outcomes["crash"] += 1
            seed += 1
    shown = ", ".join(f"{key} {value}" for key, value in sorted(outcomes.items()))
    if verbose and quietly:
        print("\n".join(quietly))
    print(
        f"{name}: {shown}; longest {longest:.1f} s, most memory {most / 1e6:.0f} MB; {len(failures)} failures",
        flush=True,
    )
    for failure in failures[:20]:
        print(f"    {failure}")
    return len(failures)


def _work(name: str, first: int, count: int) -> None:
    """Read damaged copies one after the other, a line of JSON each."""
    import signal

    import ahrs_rs as ar
    from devices.damage import damaged_copy
    from devices.samples import SAMPLES

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "valid").mkdir()
        (folder / "copy").mkdir()
        try:
            sample = SAMPLES[name][2](folder / "valid", ROWS)
            valid = len(next(iter(_read(ar, sample).values())))
        except ImportError as error:
            print(json.dumps({"missing": str(error)}))
            return
        for seed in range(first, first + count):
            path, what = damaged_copy(sample, folder / "copy", seed)
            size = sum(one.stat().st_size for one in ([path] if path.is_file() else path.rglob("*")) if one.is_file())
            before = _reset_peak()
            start = time.perf_counter()
            signal.alarm(int(2 * SECONDS))  # ends the worker, which counts as a crash
            outcome, wrong = _outcome(ar, path, valid)
            signal.alarm(0)
            seconds, memory = time.perf_counter() - start, max(_peak() - before, 0)
            if seconds > SECONDS:
                wrong = wrong or f"{seconds:.0f} s"
            if memory > MEMORY + TIMES * size:
                wrong = wrong or f"{memory / 1e6:.0f} MB"
            line = {
                "seed": seed,
                "what": what,
                "outcome": outcome,
                "wrong": wrong,
                "seconds": seconds,
                "memory": memory,
            }
            print(json.dumps(line), flush=True)


def _read(ar: object, path: Path) -> dict[str, object]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ar.read_all(path)  # type: ignore[attr-defined, no-any-return]


def _outcome(ar: object, path: Path, valid: int) -> tuple[str, str]:
    """What reading does, and what is wrong with it ("" if nothing)."""
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = ar.read_all(path)  # type: ignore[attr-defined]
    except EXPECTED as error:
        text = str(error)
        if str(path) not in text or "\n" in text or len(text) > 1000:
            return "error", f"the message is not one line with the path: {text[:300]!r}"
        return "error", ""
    except BaseException as error:
        return "exception", f"{type(error).__name__}: {str(error)[:300]}"
    others = [one for one in caught if one.category.__name__ != "DataWarning"]
    if others:
        return "warning", f"{others[0].category.__name__}: {str(others[0].message)[:300]}"
    shorter = min(len(one) for one in found.values()) < valid
    return ("read, told" if caught else "read, shorter" if shorter else "read"), ""


def _reset_peak() -> float:
    """Start counting the peak of memory anew; what is held now, bytes."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        return float("inf")
    return _status("VmRSS")


def _peak() -> float:
    return _status("VmHWM")


def _status(key: str) -> float:
    text = Path(f"/proc/{os.getpid()}/status").read_text()
    return next(float(line.split()[1]) * 1024 for line in text.splitlines() if line.startswith(f"{key}:"))


if __name__ == "__main__":
    sys.exit(main())
