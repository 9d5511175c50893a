"""What the filters make of lost, clipped and wrong measurements: `make robustness`, kept as docs/robustness.md.

The recordings of BROAD are found through the environment variable AHRS_RS_DATA (folder `broad/`). With a choice of
recordings, faults, filters or seeds the page is printed instead:

    python tools/robustness.py --recordings rest,07 --faults "turn, NaN;clock" --filters MEKF,VQF --seeds 5
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import warnings
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from itertools import repeat
from pathlib import Path

import numpy as np

import ahrs_rs as ar

sys.path.insert(0, str(Path(__file__).parent))

from robustness_errors import Result, Undisturbed, measure, rms, usual_rows
from robustness_faults import FAULTS, Fault
from robustness_page import Found, page
from robustness_scenes import BROAD, scene_of

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "robustness.md"
SEEDS = 20


@dataclass(slots=True)
class Part:
    """What was measured on one kind of recording."""

    name: str
    short: str
    results: dict[tuple[str, str], Result] = field(default_factory=dict)
    """By fault and filter."""
    usual: dict[str, float] = field(default_factory=dict)
    """Undisturbed error by filter, °."""


def part(which: str, folder: Path, faults: Sequence[str], filters: Sequence[str], seeds: int) -> Part:
    """Everything on one kind of recording."""
    warnings.simplefilter("ignore")  # what the filters have to say of the faults is not the question here
    scene = scene_of(which, folder, seeds)
    found = Part(scene.name, scene.short)
    undisturbed = Undisturbed(scene)
    for fault in chosen(faults):
        length = fault.at_rest if scene.rest else fault.length
        cleans = [scene.clean(seed, length, fault.beyond) for seed in range(seeds)]
        for name in filters:
            result = measure(name, scene, fault, cleans, undisturbed)
            if result is not None:
                found.results[fault.name, name] = result
    plain = [scene.clean(seed, 1.0, False) for seed in range(seeds)]
    for name in filters:
        errors = zip(undisturbed.errors(name, plain), plain, strict=True)
        found.usual[name] = float(np.median([rms(one.angle[usual_rows(clean.recording)]) for one, clean in errors]))
    return found


def chosen(names: Sequence[str]) -> list[Fault]:
    """The faults of these names, in their order."""
    return [fault for fault in FAULTS if fault.name in names]


def choices(text: str | None, known: Sequence[str], separator: str = ",") -> list[str]:
    """What an option names, or everything; SystemExit where there is no such thing."""
    if text is None:
        return list(known)
    names = [name.strip() for name in text.split(separator)]
    for name in names:
        if name not in known:
            raise SystemExit(f"robustness: {name!r} is none of {separator.join(known)}")
    return names


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", help="of rest, motion and the numbers of BROAD, separated by commas")
    parser.add_argument("--faults", help="their names, separated by semicolons")
    parser.add_argument("--filters", help="separated by commas")
    parser.add_argument("--seeds", type=int, help=f"how many (default: {SEEDS})")
    parser.add_argument("--output", type=Path, help="file to write instead of docs/robustness.md")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="recordings at once (default: all cores)")
    options = parser.parse_args()
    folder = Path(os.environ.get("AHRS_RS_DATA", ""))
    kinds = choices(options.recordings, ["rest", "motion", *BROAD])
    if not os.environ.get("AHRS_RS_DATA") and set(kinds) & set(BROAD):
        print("robustness: set AHRS_RS_DATA to the folder that holds broad/*.hdf5", file=sys.stderr)
        return 2
    faults = choices(options.faults, [fault.name for fault in FAULTS], ";")
    filters = choices(options.filters, list(ar.FILTERS))
    seeds = options.seeds or SEEDS
    given = (options.recordings, options.faults, options.filters, options.seeds)
    # Processes of their own, not forked ones: a parent that has threads is no good to fork.
    with ProcessPoolExecutor(options.jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        parts = list(pool.map(part, kinds, repeat(folder), repeat(faults), repeat(filters), repeat(seeds)))
    found = Found(
        scenes=[one.name for one in parts],
        shorts={one.name: one.short for one in parts},
        faults=chosen(faults),
        filters=filters,
        seeds=seeds,
        results={(one.name, *key): result for one in parts for key, result in one.results.items()},
        usual={(one.name, name): value for one in parts for name, value in one.usual.items()},
    )
    text = page(found)
    target = options.output or (DOCUMENT if all(one is None for one in given) else None)
    if target is None:
        print(text)
    else:
        target.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
