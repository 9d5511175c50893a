"""float32 beside float64 over a day of readings at 1 kHz: `make endurance`, kept as docs/endurance.md.

Every streaming filter runs in both scalars over the same noisy readings, at rest and in motion. The whole, 10⁸ steps of
8 sensors, takes some 45 minutes on one core; it saves its state now and then, and goes on from there when it is
started again with the same build. A short run:

    python tools/endurance.py --steps 1e6 --filters MEKF,SelfCalKF
"""

from __future__ import annotations

import argparse
import hashlib
import pickle
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ahrs_rs as ar

sys.path.insert(0, str(Path(__file__).parent))

from accuracy_scores import table
from endurance_readings import BIAS, CHUNK, RATE, SCENES, SEEDS, Readings, observed_error
from tqdm import tqdm

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT, WORK = ROOT / "docs" / "endurance.md", ROOT / "target" / "endurance.pickle"

Floats = NDArray[np.float64]
DTYPES = ("float64", "float32")
#: Times its error in float64 that a filter may have in float32, and the error that is none, °.
FACTOR, SMALL = 3.0, 0.1
STEPS = 1e8
#: s between two saves.
EVERY = 60.0

HEAD = """# Endurance

Made by `make endurance`: every streaming filter in float32 beside float64, over the same readings (those of float32):
{steps} steps at {rate:g} Hz, that is {hours:.1f} h. {seeds} sensors side by side, each with a constant bias of the
gyroscope ({bias:g} rad/s, one sigma) and noise that is drawn anew for every step.

Errors in degrees, float64 / float32: in 9D total, in 6D of the inclination (`GyroIntegration` observes nothing: total).
They are root mean squares over the sensors and the last {chunk:g} s before so many steps.

- *worst*: the largest error in float32 over any {chunk:g} s, in units of what is allowed: {factor:g} times that in
  float64, or {small:g}°, whichever is larger. Up to 1 the goal is met; bold, where it is not.
- *bias*: RMS of the error of the gyroscope's bias at the end, °/s.
- *turned*: after the rest the sensors turn by 90° within a second and rest for 20 s again, which shows a bias that rest
  did not. The largest error of that time, RMS over the sensors; it counts for *worst* too.
"""


@dataclass(slots=True)
class Progress:
    """What has been computed: by scene, filter and dtype."""

    build: str
    chunks: int = 0
    states: dict[tuple[str, str, str], list[ar.State]] = field(default_factory=dict)
    errors: dict[tuple[str, str, str], list[float]] = field(default_factory=dict)
    """RMS over each chunk, °."""
    bias: dict[tuple[str, str, str], float] = field(default_factory=dict)
    """RMS of its error at the end, °/s."""
    turned: dict[tuple[str, str], float] = field(default_factory=dict)
    """By filter and dtype, °."""


def build(filters: list[str], scenes: list[str]) -> str:
    """What a state must have been computed by, to go on from it."""
    library = Path(ar._native.__file__).read_bytes()
    sources = [path.read_bytes() for path in sorted(Path(__file__).parent.glob("endurance*.py"))]
    text = ",".join([*filters, *scenes]).encode()
    return hashlib.sha256(b"".join([library, *sources, text])).hexdigest()


def step(progress: Progress, scene: str, readings: Readings, filters: list[str]) -> None:
    """All filters over the next chunk of a scene."""
    given = readings.chunk(progress.chunks)
    for name in filters:
        f = ar.FILTERS[name](rate=RATE)
        for dtype in DTYPES:
            key = scene, name, dtype
            gyr, acc, mag = (array.astype(dtype, copy=False) for array in given)
            est = f.run(gyr, acc, mag if f.MAGNETOMETER else None, state=progress.states.get(key), threads=1)
            assert isinstance(est.state, list)
            progress.states[key] = est.state
            error = observed_error(f, est.quat, readings.truth)
            progress.errors.setdefault(key, []).append(float(np.sqrt(np.mean(error**2))))
            if est.gyr_bias is not None:
                wrong = est.gyr_bias[:, -1].astype(np.float64) - readings.bias
                progress.bias[key] = float(np.degrees(np.sqrt(np.mean(np.sum(wrong**2, axis=-1)))))


def turn(progress: Progress, readings: Readings, filters: list[str]) -> None:
    """The end of the rest: the sensors turn on their side."""
    given, truth = readings.turned()
    for name in filters:
        f = ar.FILTERS[name](rate=RATE)
        for dtype in DTYPES:
            gyr, acc, mag = (array.astype(dtype, copy=False) for array in given)
            state = progress.states["rest", name, dtype]
            est = f.run(gyr, acc, mag if f.MAGNETOMETER else None, state=state, threads=1)
            error = observed_error(f, est.quat, truth)
            progress.turned[name, dtype] = float(np.sqrt(np.mean(error.max(axis=1) ** 2)))


def load(path: Path, wanted: str) -> Progress:
    """What was saved by the same build, or nothing yet."""
    if path.exists():
        saved = pickle.loads(path.read_bytes())  # written by this command
        if isinstance(saved, Progress) and saved.build == wanted:
            return saved
    return Progress(wanted)


def save(path: Path, progress: Progress) -> None:
    """In one step, so that an interruption leaves the old file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_suffix(".new")
    new.write_bytes(pickle.dumps(progress))
    new.replace(path)


def page(progress: Progress, filters: list[str], scenes: list[str]) -> str:
    """The document."""
    steps = progress.chunks * CHUNK
    text = HEAD.format(
        steps=_power(steps),
        rate=RATE,
        hours=steps / RATE / 3600.0,
        seeds=SEEDS,
        bias=BIAS,
        chunk=CHUNK / RATE,
        factor=FACTOR,
        small=SMALL,
    )
    marks = [mark for mark in (10**n for n in range(5, 12)) if CHUNK <= mark < steps] + [steps]
    for scene in scenes:
        head = ["filter", *(f"{_power(mark)} steps" for mark in marks), "worst", "bias"]
        rows = []
        for name in filters:
            both = [np.array(progress.errors[scene, name, dtype]) for dtype in DTYPES]
            cells = [" / ".join(_number(one[mark // CHUNK - 1]) for one in both) for mark in marks]
            worst = [float(np.max(both[1] / np.maximum(FACTOR * both[0], SMALL)))]
            bias = [progress.bias.get((scene, name, dtype)) for dtype in DTYPES]
            row = [name, *cells, "", "–" if bias[0] is None else " / ".join(f"{one:.4f}" for one in bias)]
            if scene == "rest":
                turned = [progress.turned[name, dtype] for dtype in DTYPES]
                worst.append(turned[1] / max(FACTOR * turned[0], SMALL))
                row.append(" / ".join(map(_number, turned)))
            row[-2 if scene == "motion" else -3] = _judged(max(worst))
            rows.append(row)
        if scene == "rest":
            head.append("turned")
        text += f"\n## {'At rest' if scene == 'rest' else 'In motion'}\n\n" + table(head, rows)
    return text


def _power(steps: int) -> str:
    """10⁶ for a million."""
    mantissa, exponent = f"{steps:.0e}".split("e")
    raised = str(int(exponent)).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
    if float(f"{mantissa}e{exponent}") != steps:
        return f"{steps:,}"
    return f"10{raised}" if mantissa == "1" else f"{mantissa}·10{raised}"


def _number(value: float) -> str:
    return f"{value:.3f}" if value < 9.9995 else f"{value:.1f}"


def _judged(worst: float) -> str:
    return f"{worst:.2f}" if worst <= 1.0 else f"**{worst:.2f}**"


def main() -> int:
    streaming = [name for name, cls in ar.FILTERS.items() if cls.STREAMING]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=float, default=STEPS, help=f"of each sensor (default: {STEPS:g})")
    parser.add_argument("--filters", help="separated by commas (default: all that go on from sample to sample)")
    parser.add_argument("--scenes", help=f"of {' and '.join(SCENES)}, separated by a comma (default: both)")
    parser.add_argument("--work", type=Path, default=WORK, help="where the state is saved (default: %(default)s)")
    parser.add_argument(
        "--output", type=Path, help="file to write; by default docs/endurance.md for the whole, or none"
    )
    options = parser.parse_args()
    filters = options.filters.split(",") if options.filters else streaming
    scenes = options.scenes.split(",") if options.scenes else list(SCENES)
    for given, known in ((filters, streaming), (scenes, list(SCENES))):
        for name in given:
            if name not in known:
                raise SystemExit(f"endurance: {name!r} is none of {', '.join(known)}")
    chunks = max(1, round(options.steps / CHUNK))
    progress = load(options.work, build(filters, scenes))
    if progress.chunks > chunks:
        progress = Progress(progress.build)
    readings = {scene: Readings(scene) for scene in scenes}
    saved = time.monotonic()
    for _ in tqdm(range(progress.chunks, chunks), initial=progress.chunks, total=chunks, unit="chunk"):
        for scene in scenes:
            step(progress, scene, readings[scene], filters)
        progress.chunks += 1
        if time.monotonic() - saved > EVERY:
            save(options.work, progress)
            saved = time.monotonic()
    save(options.work, progress)
    if "rest" in scenes:
        turn(progress, readings["rest"], filters)
    text = page(progress, filters, scenes)
    whole = options.steps >= STEPS and not (options.filters or options.scenes)
    target = options.output or (DOCUMENT if whole else None)
    if target is not None:
        target.write_text(text, encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
