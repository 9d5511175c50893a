"""Plant faults into good recordings and see what `ahrs_rs.check` says: docs/check.md.

python tools/check_table.py            all 48 permutations, all sources: half an hour
python tools/check_table.py --light    a few of them: some minutes; prints, and writes nothing
"""

from __future__ import annotations

import argparse
import os
import textwrap
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from check_plants import OUTCOMES, plants

import ahrs_rs as ar

OUT = Path(__file__).resolve().parent.parent / "docs/check.md"
#: Recordings with a fault of their own, which a check finds.
FAULTY = {"als_uncalibrated_mag"}
SCENARIOS = ("demo", "walking", "quadrotor", "rotation_test")


def real(folder: Path) -> Iterator[tuple[str, ar.Recording]]:
    """All shared recordings with their names."""
    paths = [
        path
        for part, ending in (("broad", "hdf5"), ("repoimu", "csv"), ("repoimu_more", "csv"), ("phones", "npz"),
                             ("justa", "npz"), ("fusion", "csv"), ("vqf", "npz"))
        for path in sorted((folder / part).glob(f"*.{ending}"))
    ]  # fmt: skip
    for path in paths:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ar.DataWarning)
            yield f"{path.parent.name}/{path.stem}", ar.read(path)


def turns(recording: ar.Recording) -> bool:
    """Whether every axis of the sensor turns by 90° and more: then it turns about two axes."""
    quat = np.asarray(ar.GyroIntegration(rate=recording.rate).run(np.nan_to_num(recording.gyr), t=recording.t).quat)
    step = max(len(quat) // 2000, 1)
    w, x, y, z = quat[::step].T
    cosines = [w * w + x * x - y * y - z * z, w * w - x * x + y * y - z * z, w * w - x * x - y * y + z * z]
    return all(float(one.min()) < 0.1 for one in cosines)  # 84°: a turn of 90° that is not quite one


def good_rows(recordings: list[tuple[str, ar.Recording]]) -> tuple[list[str], dict[str, ar.Report]]:
    """A row for each recording as it is."""
    lines, reports = [], {}
    for name, recording in recordings:
        begin = time.process_time()
        report = reports[name] = ar.check(recording)
        took = time.process_time() - begin
        told = [f"{one.severity} {one.code}" for one in report.findings if one.severity in ("warning", "error")]
        lines.append(f"| {name} | {recording.duration:.0f} | {took:.1f} | {', '.join(told) or 'none'} |")
    return lines, reports


def planted(
    recordings: list[tuple[str, ar.Recording]], reports: dict[str, ar.Report], every: int
) -> tuple[dict[tuple[bool, str], Counter[str]], list[str]]:
    """(turns, kind) -> outcomes; and every wrong verdict."""
    found: dict[tuple[bool, str], Counter[str]] = {}
    wrong: list[str] = []
    for name, recording in recordings:
        wide = turns(recording)
        right = reports[name]
        before = {one.code for one in right.of("error")}
        for plant in plants(recording, every):
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                report = ar.check(plant.apply(recording), **plant.keywords)
                outcome = plant.judge(report, right)
            others = {one.code for one in report.of("error")} - before
            others = {code for code in others if not code.startswith(plant.allowed or ("-",))}
            if others:
                wrong.append(f"{name}, {plant.kind}: error {', '.join(sorted(others))}")
            elif outcome == "wrong":
                wrong.append(f"{name}, {plant.kind}: named otherwise")
            counter = found.setdefault((wide, plant.kind), Counter())
            counter["wrong" if others else outcome] += 1
    return found, wrong


def table(found: dict[tuple[bool, str], Counter[str]], wide: bool) -> list[str]:
    """The outcomes of the sources of one kind of motion."""
    lines = [f"| fault | planted | {' | '.join(OUTCOMES)} |", "| --- | ---: |" + " ---: |" * len(OUTCOMES)]
    for (turning, kind), counter in found.items():
        if turning == wide:
            cells = " | ".join(str(counter[one] or "") for one in OUTCOMES)
            lines.append(f"| {kind} | {sum(counter.values())} | {cells} |")
    return lines


def main() -> int:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--light", action="store_true", help="a few sources and permutations; writes nothing")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="one permutation in N (default: all)")
    parser.add_argument("--only", default="", metavar="TEXT,...", help="sources whose names hold one of these")
    args = parser.parse_args()
    folder = os.environ.get("AHRS_RS_DATA", "")
    shared = list(real(Path(folder))) if folder else []
    simulated = [(f"simulated/{name}", ar.simulate.scenario(name, seed=3)) for name in SCENARIOS]
    wanted = [one for one in args.only.split(",") if one]
    if args.light:
        args.every, wanted = max(args.every, 8), wanted or ["02_und", "16_und", "TStick_Test02", "simulated/demo"]
    good, reports = good_rows(shared + simulated)
    sources = [
        (name, one)
        for name, one in shared + simulated
        if name.rpartition("/")[2] not in FAULTY
        and name.startswith(("broad", "repoimu/", "simulated"))
        and (not wanted or any(text in name for text in wanted))
    ]
    found, wrong = planted(sources, reports, args.every)
    text = page(good, found, wrong, [name for name, _ in sources], args.every)
    if args.light:
        print(text)
    else:
        OUT.write_text(text, encoding="utf-8")
        print(f"wrote {OUT}")
    return 0


def page(
    good: list[str],
    found: dict[tuple[bool, str], Counter[str]],
    wrong: list[str],
    sources: list[str],
    every: int,
) -> str:
    """The whole page."""
    total = Counter[str]()
    for counter in found.values():
        total += counter
    some = "all" if every == 1 else f"one in {every} of the"
    count = sum(total.values())
    parts = [
        "# What `check` finds",
        "",
        "Made by `make check-table`. Faults are planted, each alone, into real and simulated recordings, and",
        f"`ar.check` is asked: {some} signed permutations of each sensor, and the other kinds below. {count} faults in",
        *textwrap.wrap(f"{len(sources)} recordings: {', '.join(sources)}.", 118, break_on_hyphens=False),
        "",
        'A vector that is negated turns as before, so that the axes of accelerometer and magnetometer are told "up to',
        'sign" without `up=` or `place=`, and of two sensors alone it cannot be told which is turned; nothing is',
        'changed then. "wrong" is a fault that is named otherwise, or any error that is not the planted fault\'s.',
        "",
        "## Where every axis turns by 90° and more",
        "",
        *table(found, True),
        "",
        "## Where the motion is less",
        "",
        *table(found, False),
        "",
        "## Wrong verdicts",
        "",
        *([f"- {one}" for one in wrong] or ["None."]),
        "",
        "## Recordings as they are",
        "",
        "Seconds of the recording, seconds of one core, and warnings and errors. `als_uncalibrated_mag` has axes of",
        "gyroscope and magnetometer that do not fit: a free regression of the field's change gives diag(-1, -1, 1).",
        "",
        "| recording | s | took | warnings and errors |",
        "| --- | ---: | ---: | --- |",
        *good,
        "",
    ]
    return "\n".join(parts)


if __name__ == "__main__":
    raise SystemExit(main())
