"""What states, rules and parameters of SelfCalKF and SelfCalSmoother are worth: the last part of docs/accuracy.md."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from accuracy_scores import aligned_scores, errors, scores, table

import ahrs_rs as ar
from ahrs_rs._slerp import Attitudes
from ahrs_rs.simulate import IronFloor, Sensor, Setup, Triad

#: Each of ours, and the one that it has to be better than.
PEERS = {"SelfCalKF": "VQF", "SelfCalSmoother": "OfflineVQF"}

#: What is left out, and the parameters that do it.
ABLATIONS: list[tuple[str, dict[str, Any]]] = [
    ("everything", {}),
    ("no matrix of the gyroscope", {"initial_matrix": 0.0}),
    ("no delay of the magnetometer", {"initial_delay": 0.0}),
    ("no disturbance of the field", {"disturbance": 0.0}),
    ("no hard iron", {"initial_hard_iron": 0.0, "hard_iron_noise": 0.0}),
    ("a reference field that is not corrected", {"initial_field": 0.0}),
    ("no bias of the accelerometer", {"initial_acc_bias": 0.0}),
    ("gravity as given", {"initial_gravity": 0.0}),
    ("no bias of the gyroscope", {"initial_bias": 0.0}),
    ("every field counts alike", {"mag_tolerance": 1e3}),
    ("no new reference field", {"mag_new_time": 1e6}),
    ("no rest", {"rest_gyr": 0.0}),
]

#: Parameters that are no noise or tolerance: what is given, not chosen.
GIVEN = ("gyr_range", "latency", "gravity")

HEAD = """
## SelfCalKF and SelfCalSmoother

Our own ([docs/selfcal.md](selfcal.md)), with one set of parameters for everything. RMSE of the total, heading and
inclination error in degrees; RepoIMU aligned as above. The structure was found and the parameters were chosen on these
12 recordings of BROAD and four of RepoIMU. On 18 recordings of BROAD that the design had not seen a prototype had 1.86
where VQF has 2.50, and its smoother 1.40 where OfflineVQF has 2.35.

"""

ABLATION = """
### What states and rules are worth

The same with a part taken out, by parameters alone: means over the recordings; a total that is larger than that of
the first line is what the part is worth.

"""

SENSITIVITY = """
### {name}: parameters halved and doubled

Mean total error on BROAD with one parameter halved or doubled, and by how many per cent of {base} it differs. Left out
of the table, as they change it by less than {least:.0%} either way:
{small}.

"""

LATE = """
### The lag of the whole sensor

BROAD's sensor is behind its optical truth, always by the same time, which no data of the sensor show: that is what
`latency=` (s) is for. The first line is what a filter without any error would have: the truth against the truth
{late} ms earlier. The lag is the offset that `ar.metrics.align` finds, mean and range over the recordings
whose motion shows it.

"""

SIMULATED = """
### One effect at a time

Simulated: through random way points for {duration:g} s at {rate:g} Hz ({seeds} motions), with white noise and constant
biases only, and then with one effect more. RMSE of the total error in degrees from {settled:g} s on. A range below
4 rad/s (SelfCalSmoother: 2 rad/s) is not looked for, and has to be told.

"""

#: Seconds, Hz and motions of the simulation.
DURATION, RATE, SETTLED = 120.0, 100.0, 20.0
SEEDS = range(5)
#: Changes that are left out of the table.
LEAST = 0.03

#: s by which BROAD's sensor is late.
LATENCY = 0.0024

#: Noise of a consumer sensor; a bias of 0.3 °/s.
SENSOR = Sensor(
    gyr=Triad(density=2e-4, bias_deviation=5e-3),
    acc=Triad(density=2e-3, bias_deviation=0.02),
    mag=Triad(noise=0.3),
)
#: µT of the field over a floor with iron.
FLOOR = 5.0


def sections(
    broad: Sequence[ar.Recording], broad_names: Sequence[str], repo: Sequence[ar.Recording], repo_names: Sequence[str]
) -> str:
    """All tables."""
    ours = {name: peer for name, peer in PEERS.items() if name in ar.FILTERS}
    text = HEAD + _by_recording(ours, broad, broad_names, repo, repo_names)
    text += LATE.format(late=f"{1e3 * LATENCY:g}") + _late(ours, broad)
    text += ABLATION + _ablation(ours, broad, repo)
    for name in ours:
        text += _sensitivity(name, broad)
    head = SIMULATED.format(duration=DURATION, rate=RATE, seeds=len(SEEDS), settled=SETTLED)
    return text + head + _simulated(ours)


def _shown(values: np.ndarray) -> list[str]:
    return [f"{value:.2f}" for value in values]


def _by_recording(
    ours: Mapping[str, str],
    broad: Sequence[ar.Recording],
    broad_names: Sequence[str],
    repo: Sequence[ar.Recording],
    repo_names: Sequence[str],
) -> str:
    filters = [name for pair in ours.items() for name in pair]
    rows = []
    for kind, names, found in (
        ("BROAD", broad_names, [scores(name, {}, broad) for name in filters]),
        ("RepoIMU", repo_names, [aligned_scores(name, {}, repo)[0] for name in filters] if repo else []),
    ):
        for i, which in enumerate(names):
            rows.append([f"{kind} {which}", *(" / ".join(_shown(one[i])) for one in found)])
        if names:
            rows.append([f"{kind}, mean", *(f"**{' / '.join(_shown(one.mean(axis=0)))}**" for one in found)])
    return table(["recording", *filters], rows)


def _late(ours: Mapping[str, str], broad: Sequence[ar.Recording]) -> str:
    late = []
    for recording in broad:
        quat, _ = Attitudes(np.asarray(recording.ref), recording.t).at(recording.t - LATENCY)
        late.append(errors(quat, recording.ref, recording.mask))
    rows = [["the truth", " / ".join(_shown(np.mean(late, axis=0))), "–", "–"]]
    for name in ours:
        plain, ahead = (scores(name, {"latency": latency}, broad).mean(axis=0) for latency in (0.0, LATENCY))
        offsets = [1e3 * one.time_offset for one in aligned_scores(name, {}, broad)[1] if one.determined]
        lag = f"{np.mean(offsets):.1f} ({min(offsets):.1f} to {max(offsets):.1f})"
        rows.append([name, " / ".join(_shown(plain)), " / ".join(_shown(ahead)), lag])
    return table(["BROAD, mean", "latency=0", f"latency={LATENCY:g}", "lag, ms"], rows)


def _ablation(ours: Mapping[str, str], broad: Sequence[ar.Recording], repo: Sequence[ar.Recording]) -> str:
    rows = []
    for what, changed in ABLATIONS:
        cells = [what]
        for name in ours:
            known = ar.FILTERS[name].PARAMS
            if not all(
                key in known and known[key].range[0] <= value <= known[key].range[1] for key, value in changed.items()
            ):
                cells += ["–", "–"]
                continue
            cells.append(" / ".join(_shown(scores(name, changed, broad).mean(axis=0))))
            cells.append(f"{aligned_scores(name, changed, repo)[0][:, 0].mean():.2f}" if repo else "–")
        rows.append(cells)
    return table(["without", *(f"{name} {kind}" for name in ours for kind in ("BROAD", "RepoIMU"))], rows)


def _sensitivity(name: str, broad: Sequence[ar.Recording]) -> str:
    base = float(scores(name, {}, broad)[:, 0].mean())
    rows, small = [], []
    for param in ar.FILTERS[name].PARAMS.values():
        default = param.default
        if param.name in GIVEN or isinstance(default, bool | str) or not isinstance(default, float) or default == 0.0:
            continue
        totals = [float(scores(name, {param.name: factor * default}, broad)[:, 0].mean()) for factor in (0.5, 2.0)]
        changes = [total / base - 1.0 for total in totals]
        if max(map(abs, changes)) < LEAST:
            small.append(param.name)
        else:
            cells = [f"{total:.2f} ({change:+.0%})" for total, change in zip(totals, changes, strict=True)]
            rows.append([param.name, f"{default:g}", *cells])
    shown = textwrap.fill(", ".join(small) or "none", 120)
    head = SENSITIVITY.format(name=name, base=f"{base:.2f}", least=LEAST, small=shown)
    return head + table(["parameter", "default", "halved", "doubled"], rows)


def _setups(seed: int) -> dict[str, tuple[Setup, float, dict[str, float]]]:
    """The simulations of a motion, the seconds that are cut off at their start, and what ours are told."""

    def motion(interval: float) -> Setup:
        return ar.simulate.SCENARIOS["way_points"].setup(
            rate=RATE, duration=DURATION, seed=seed, sensor=SENSOR, reach=0.5, interval=interval
        )

    def clipped(setup: Setup, limit: float) -> Setup:
        return replace(setup, sensor=replace(SENSOR, gyr=replace(SENSOR.gyr, range=limit)))

    plain, fast = motion(0.5), motion(0.2)
    matrix = replace(SENSOR.gyr, scale_deviation=5e-3, misalignment_deviation=5e-3)
    floor = (IronFloor(deviation=FLOOR, seed=seed),)
    late = replace(SENSOR, mag_delay=0.02)
    return {
        "none": (plain, 0.0, {}),
        "the magnetometer is 20 ms late": (replace(plain, sensor=late), 0.0, {}),
        "scale and misalignment of the gyroscope of 0.5 %": (
            replace(plain, sensor=replace(SENSOR, gyr=matrix)),
            0.0,
            {},
        ),
        f"a field that varies by {FLOOR:g} µT over a metre": (replace(plain, disturbances=floor), 0.0, {}),
        "the gyroscope is clipped at 2 rad/s": (clipped(plain, 2.0), 0.0, {}),
        "the same, and ours are told: gyr_range=2": (clipped(plain, 2.0), 0.0, {"gyr_range": 2.0}),
        "faster, up to 5.4 rad/s": (fast, 0.0, {}),
        "faster, and clipped at 4.5 rad/s": (clipped(fast, 4.5), 0.0, {}),
        "it starts in motion": (plain, 5.25, {}),
        "delay, matrix, field and start": (
            replace(plain, sensor=replace(late, gyr=matrix), disturbances=floor),
            5.25,
            {},
        ),
    }


def _simulated(ours: Mapping[str, str]) -> str:
    filters = [name for pair in ours.items() for name in pair]
    totals: dict[str, list[list[float]]] = {}
    for seed in SEEDS:
        for effect, (setup, cut, told) in _setups(seed).items():
            recording = setup.record(seed)[round(cut * RATE) :]
            settled = replace(recording, mask=np.arange(len(recording)) >= SETTLED * RATE)
            found = [float(scores(name, told if name in ours else {}, [settled])[0, 0]) for name in filters]
            totals.setdefault(effect, []).append(found)
    rows = [[effect, *_shown(np.mean(found, axis=0))] for effect, found in totals.items()]
    return table(["effect", *filters], rows)
