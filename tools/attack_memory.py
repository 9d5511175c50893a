"""The part of `make attack` that looks for leaks: calls of every public function, and what memory they leave."""

from __future__ import annotations

import copy
import ctypes
import gc
import io
import pickle
import tempfile
import time
import types
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import ahrs_rs as ar
from ahrs_rs import calibration, metrics, papers, plots, signal, simulate, tuning

#: Calls of what takes less than so many seconds.
CALLS = ((1e-3, 100_000), (0.1, 1_000), (float("inf"), 20))
#: What the process may grow by in each third of the calls, bytes: pages here and there, no leak of 10 bytes a call.
LIMIT = 2**18

MODULES = {
    "": ar, "metrics": metrics, "signal": signal, "calibration": calibration, "simulate": simulate, "tuning": tuning,
    "plots": plots, "papers": papers,
}  # fmt: skip

RATE = 100.0
WALK = simulate.demo(4.0, RATE, 1)
GYR, ACC, MAG, REF = (getattr(WALK, name) for name in ("gyr", "acc", "mag", "ref"))
RNG = np.random.default_rng(0)


def _still(seconds: float) -> ar.Recording:
    count = int(seconds * RATE)
    rng = np.random.default_rng(1)
    return ar.Recording(
        t=np.arange(count) / RATE,
        gyr=rng.normal(0.0, 0.002, (count, 3)),
        acc=np.array([0.0, 0.0, 9.80665]) + rng.normal(0.0, 0.02, (count, 3)),
        mag=np.array([0.0, 20.0, -45.0]) + rng.normal(0.0, 0.3, (count, 3)),
        temperature=np.linspace(20.0, 40.0, count),
    )


def _directions(count: int, norm: float) -> np.ndarray:
    points = RNG.normal(size=(count, 3))
    return norm * points / np.linalg.norm(points, axis=1, keepdims=True) + RNG.normal(0.0, 0.01 * norm, (count, 3))


def of_filters() -> Iterator[tuple[str, Callable[[], object]]]:
    """Every method of every filter."""
    stacked = [np.stack([array[:100]] * 5) for array in (GYR, ACC, MAG)]
    ragged = [(GYR[:n], ACC[:n], MAG[:n]) for n in (10, 40, 80)]
    for name, cls in ar.FILTERS.items():
        f = cls(rate=RATE)
        outputs = tuple(cls.OUTPUTS)
        yield f"{name}()", lambda cls=cls: cls(rate=RATE)
        yield f"{name}.run", lambda f=f: f.run(GYR[:50], ACC[:50], MAG[:50])
        yield f"{name}.run (N, T, 3)", lambda f=f: f.run(*stacked)
        yield f"{name}.run outputs", lambda f=f, o=outputs: f.run(GYR[:50], ACC[:50], MAG[:50], outputs=o)
        yield f"run_many {name}", lambda f=f: ar.run_many(f, ragged, threads=2)
        yield f"{name} pickled", lambda f=f: pickle.loads(pickle.dumps(f))
        yield f"{name}.run refused", lambda f=f: _refused(lambda: f.run(GYR, ACC[:3]))
        if not cls.STREAMING:
            continue
        yield f"sweep {name}", lambda cls=cls: ar.sweep(cls, [{}] * 3, [WALK[:50]], threads=2)
        yield f"{name}.update", lambda f=f: f.update(GYR[7], ACC[7], MAG[7])
        yield f"{name}.update refused", lambda f=f: _refused(lambda: f.update(GYR[7], ACC))
        yield f"{name}.reset", f.reset
        yield f"{name}.copy", f.copy
        yield f"{name}.state", lambda f=f: f.restore(f.state())
        yield f"{name}.run state", lambda f=f: f.run(GYR[:9], ACC[:9], MAG[:9], state=f.state())
        yield f"{name}.state JSON", lambda f=f: ar.State.from_json(f.state().to_json())
        yield f"{name} attributes", lambda f=f: (f.quat, f.gyr_bias, f.status, f.covariance)


def _refused(call: Callable[[], object]) -> None:
    try:
        call()
    except ValueError:
        return
    raise AssertionError("expected a ValueError")


def of_files(folder: Path) -> Iterator[tuple[str, Callable[[], object]]]:
    """What reads and writes."""
    est = ar.VQF(rate=RATE).run(GYR, ACC, MAG)
    WALK.save(folder / "walk.npz")
    names = [f"{s}_{a} ({u})" for s, u in (("gyr", "rad/s"), ("acc", "m/s2"), ("mag", "uT")) for a in "xyz"]
    table = np.column_stack([WALK.t, GYR, ACC, MAG])
    np.savetxt(folder / "walk.csv", table, delimiter=",", header=",".join(["time (s)", *names]), comments="")
    (folder / "damaged.npz").write_bytes((folder / "walk.npz").read_bytes()[:2000])
    (folder / "damaged.csv").write_text("t,gyr_x\n0,1\n")
    for name in ("walk.npz", "walk.csv"):
        yield f"read {name[-3:]}", lambda name=name: ar.read(folder / name)
        yield (
            f"read_all, sensors {name[-3:]}",
            lambda name=name: (ar.read_all(folder / name), ar.sensors(folder / name)),
        )
    for name in ("damaged.npz", "damaged.csv"):
        yield f"read {name} refused", lambda name=name: _refused(lambda: ar.read(folder / name))
    for ending in ("csv", "parquet", "npz"):
        path = folder / f"out.{ending}"
        yield f"write_estimate {ending}", lambda path=path: ar.write_estimate(path, est.t, est.quat, est.gyr_bias)
    yield "Recording.save", lambda: WALK.save(folder / "again.npz")
    matrix = calibration.Calibration(np.eye(3), np.zeros(3))
    yield (
        "Calibration.save, load",
        lambda: (matrix.save(folder / "cal.json", "mag"), calibration.load(folder / "cal.json")),
    )
    figure = plots.errors(WALK, {"a": est.quat})
    yield "plots.save", lambda: plots.save(figure, folder / "a.png")
    yield "sweep checkpoint", lambda: ar.sweep(ar.Mahony, [{}] * 3, [WALK[:50]], checkpoint=folder / "part.jsonl")


def of_functions() -> Iterator[tuple[str, Callable[[], object]]]:
    """Everything else, by its name in its module."""
    est = ar.VQF(rate=RATE).run(GYR, ACC, MAG)
    quat, still = est.quat, _still(120.0)
    one = WALK[:100]
    yield "Recording", lambda: ar.Recording(t=WALK.t, gyr=GYR, acc=ACC)[3:50]
    yield "Estimate", lambda: (est.euler(), est.matrix(), est.rotation(), est.to_frame(), copy.deepcopy(est))
    yield "metrics", lambda: [
        function(quat, REF)
        for function in (
            metrics.total_error, metrics.heading_error, metrics.inclination_error, metrics.euler_error, metrics.score,
            metrics.error_quat, metrics.chordal_distance, metrics.geodesic_distance, metrics.inner_product_distance,
            metrics.error_angles,
        )
    ]  # fmt: skip
    yield "metrics.static_dynamic", lambda: metrics.static_dynamic(quat, REF, WALK.mask)
    angle = metrics.total_error(quat, REF)
    yield (
        "metrics (statistics)",
        lambda: [
            function(angle)
            for function in (metrics.rmse, metrics.mae, metrics.mad, metrics.gae, metrics.imre, metrics.box)
        ],
    )
    yield "metrics.mape", lambda: metrics.mape(angle, angle + 1.0)
    yield "metrics.align", lambda: metrics.align(quat, REF, t=WALK.t, earth="full", sensor=True, check=False)
    yield "metrics.euler", lambda: metrics.euler(quat)
    yield "signal.low_pass", lambda: signal.low_pass(ACC, 5.0, RATE)
    yield "signal.zero_phase", lambda: signal.zero_phase(ACC, 5.0, RATE)
    low = signal.LowPass(4, 5.0, RATE)
    yield "signal.LowPass", lambda: (low.update(ACC[3]), low.copy(), pickle.loads(pickle.dumps(low)))
    sphere = _directions(600, 50.0)
    yield "calibration.magnetometer", lambda: calibration.magnetometer(sphere)
    yield "calibration.ellipsoid", lambda: calibration.ellipsoid(sphere)
    yield "calibration.Calibration", lambda: calibration.Calibration(np.eye(3), np.ones(3)).apply(ACC)
    held = [9.81 * axis + RNG.normal(0.0, 0.01, (50, 3)) for axis in np.vstack([np.eye(3), -np.eye(3)])]
    yield "calibration.six_positions", lambda: calibration.six_positions(held)
    yield "calibration.gyroscope_bias", lambda: calibration.gyroscope_bias(still)
    yield "calibration.find_rest", lambda: calibration.find_rest(still)
    yield "calibration.allan_deviation", lambda: calibration.allan_deviation(still.gyr[:, 0], RATE)
    yield "calibration.noise", lambda: calibration.noise(still)
    warm = still.temperature
    yield "calibration.warm_up_gyroscope", lambda: calibration.warm_up_gyroscope((still.gyr, warm))
    line = np.linspace(20.0, 40.0, 50)
    yield "calibration.warm_up_accelerometer", lambda: calibration.warm_up_accelerometer([(x, line) for x in held])
    diagonal = calibration.Calibration(np.eye(3), np.zeros(3))
    yield "calibration.two_temperatures", lambda: calibration.two_temperatures(diagonal, diagonal, (20.0, 40.0))
    tilted = np.concatenate([np.repeat(x, 6, axis=0) for x in held])
    yield "calibration.accelerometer", lambda: calibration.accelerometer(tilted, rate=RATE)
    yield "calibration.held_attitudes", lambda: calibration.held_attitudes(tilted, RATE)
    yield "calibration.gyroscope", lambda: calibration.gyroscope(still.gyr)
    longer = simulate.demo(30.0, RATE, 2)
    yield (
        "calibration.gyroscope_from_reference",
        lambda: calibration.gyroscope_from_reference(longer.gyr, longer.ref, t=longer.t),
    )
    yield "calibration.mag_delay", lambda: calibration.mag_delay(longer, largest_error=1.0)
    yield "simulate.demo", lambda: simulate.demo(2.0, RATE, 3)
    points = RNG.normal(size=(5, 3))
    yield (
        "simulate functions",
        lambda: (
            simulate.constant([1.0]),
            simulate.moves([0.0], [(1.0, [1.0])]),
            simulate.bumps(0.0, 1.0, 3.0, [1.0]),
            simulate.spline(points, 1.0),
            simulate.rotors(np.random.default_rng(0), 100.0, 1.0, 0.1),
        ),
    )
    yield "simulate.record", lambda: simulate.record(simulate.still(0.1), rate=RATE, duration=2.0)
    for name in simulate.SCENARIOS:
        yield f"simulate.scenario {name}", lambda name=name: simulate.scenario(name, duration=5.0)
    yield "tuning.grid", lambda: tuning.grid(ar.Madgwick, {"beta": [0.1, 0.2]}, [one])
    yield "tuning.evolve", lambda: tuning.evolve(ar.Madgwick, ["beta"], [one], generations=2)
    panel = plots.ErrorPanel(one, "a")
    panel.add("a", quat[:100])
    yield "plots.errors", lambda: plots.errors(one, {"a": quat[:100]})
    yield "plots.draw", lambda: (plots.require_matplotlib(), plots.check_ending("a.png"), plots.draw([panel], ["a"]))
    yield "papers.study", lambda: papers.study("cocoli2023")
    yield "pickle of an estimate", lambda: pickle.load(io.BytesIO(pickle.dumps(est)))


def memory(part: float) -> tuple[list[str], int]:
    """The table of all calls, and how many leak."""
    lines = [
        "## Memory",
        "",
        "Calls of every public function: 100,000 of what takes less than 1 ms, 1,000 below 0.1 s, 20 of the rest.",
        "Growth of the process in kB in each third of the calls, after a tenth of them; a leak is a growth of more",
        f"than {LIMIT >> 10} kB in each of the three.",
        "",
        "| what | a call [ms] | calls | growth [kB] | |",
        "| --- | ---: | ---: | ---: | --- |",
    ]
    leaks = 0
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        called = set()
        for name, call in (*of_filters(), *of_files(Path(folder)), *of_functions()):
            called.add(name)
            seconds, count, growth = _growth(call, part)
            leaks += min(growth) > LIMIT
            shown = ", ".join(str(each >> 10) for each in growth)
            verdict = "leaks" if min(growth) > LIMIT else ""
            lines.append(f"| `{name}` | {1e3 * seconds:.3g} | {count:,} | {shown} | {verdict} |")
            print(lines[-1], flush=True)
    absent = _not_called(called)
    lines += ["", f"Not called: {', '.join(absent) or 'none'}."]
    print(lines[-1], flush=True)
    return lines, leaks


def _growth(call: Callable[[], object], part: float) -> tuple[float, int, list[int]]:
    """Time of a call in s, how many there were, growth in each third in bytes."""
    seconds = float("inf")
    for _ in range(5):
        begin = time.perf_counter()
        call()
        seconds = min(seconds, time.perf_counter() - begin)
    count = max(int(part * next(calls for limit, calls in CALLS if seconds < limit)), 4)
    for _ in range(count // 10):
        call()
    sizes = [_size()]
    for _ in range(3):
        for _ in range(count // 3):
            call()
        sizes.append(_size())
    return seconds, count, np.diff(sizes).tolist()


def _size() -> int:
    """Resident memory in bytes, without what only waits to be given back."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def _not_called(called: set[str]) -> list[str]:
    """Public functions that stand nowhere here; classes are what functions give."""
    text = " ".join(called) + " " + Path(__file__).read_text(encoding="utf-8")
    found = []
    for prefix, module in MODULES.items():
        for name in module.__all__:
            thing = getattr(module, name)
            if isinstance(thing, types.FunctionType) and name not in text:
                found.append(f"{prefix}.{name}".lstrip("."))
    return found
