"""Çoçoli & Badia 2023: trigonometry, Kalman, Mahony and Madgwick on a miniature sensor, at rest and moved by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

import ahrs_rs as ar
from ahrs_rs._typing import FloatArray
from ahrs_rs.papers import _common
from ahrs_rs.papers._study import Cell, Claim, Plot, Study, Table, Verdict, lines

Angles: TypeAlias = dict[str, FloatArray]
"""(2,) of roll and pitch in degrees, for every method."""
Verdicts: TypeAlias = tuple[Verdict, Verdict | None]

TITLE = (
    "K. Çoçoli, L. Badia: A comparative analysis of sensor fusion algorithms for miniature IMU measurements, 2023 "
    "(MPU6050 and Arduino Nano)"
)

PROTOCOL = """2,000 samples of a level sensor at rest and 2,000 of one that is moved by hand around a roll of 15° and
a pitch of -15°; roll and pitch by four methods from the same data. The paper shows plots and no errors. Its sampling
rate is taken for what its times allow, 160 Hz; the parameters of its Kalman filter are not given, and are those of
Parikh et al. here. The numbers are means over five sensors. "Matrix" is trigonometry without a filter (eqs 3-4),
Mahony has kp 10 and ki 0, Madgwick β 0.05. All have the published first-order step.

The oscillation of an angle is the root mean square of its error's distance to the mean of the 50 samples around, 50
being what the paper's plots show.

Real recordings: the rest before the motion of every recording, and the motion of those that tilt by less than 75°, as
the paper keeps within 90°. The verdicts go by the root mean square over roll and pitch."""

METHODS: dict[str, type[ar.Filter]] = {
    "Matrix": ar.FILTERS["Trigonometric"],
    "Kalman": ar.FILTERS["LinearKalman"],
    "Mahony": ar.FILTERS["Mahony"],
    "Madgwick": ar.FILTERS["Madgwick"],
}
#: Table II, µs on an ATmega328P.
TIMES = {"Matrix": 2477.4, "Kalman": 1375.9, "Mahony": 950.5, "Madgwick": 1416.8}

RATE = 160.0
#: So many draws of the sensor's errors.
SENSORS = 5
SAMPLES = 2000
TIMES_NOTE = "Theirs: without a floating-point unit."
UNKNOWN = (float("nan"), float("nan"))
#: In a plot of the paper.
WINDOW = 50
#: Largest tilt of a recording that is taken for one like the paper's.
TILT = 75.0


def study(recordings: list[ar.Recording], seed: int) -> Study:
    """The study."""
    seeds = range(seed, seed + SENSORS)
    common = {"rate": RATE, "duration": SAMPLES / RATE}
    rest = [ar.simulate.scenario("static", sensor="mpu6050", remaining=0.05, seed=one, **common) for one in seeds]
    motion = [ar.simulate.scenario("moving_hand", seed=one, **common) for one in seeds]
    moved = [one for one in recordings if 0.0 <= tilt(one) < TILT]
    still = [one[SAMPLES : 2 * SAMPLES] for one in recordings]
    resting = oscillations_at_rest(rest), oscillations_at_rest(still)
    moving = oscillations(motion), oscillations(moved)
    accurate = accuracies(motion), accuracies(moved)
    table, ours = _common.times(
        "Table II: time of a step", filters(RATE), motion[0], TIMES, "µs", nine_axes=False, note=TIMES_NOTE
    )
    clocked = ours, _common.clocked_on_first(filters, recordings, nine_axes=False)
    return Study(
        name="cocoli2023",
        title=TITLE,
        protocol=PROTOCOL,
        tables=[
            _table("Oscillation at rest", resting, ".4f"),
            _table("Oscillation in motion", moving, ".3f"),
            _table("RMSE in motion", accurate, ".2f"),
            table,
        ],
        claims=[
            Claim("At rest the matrix method oscillates most", *_verdicts(_common.largest("Matrix"), resting)),
            Claim("In motion the matrix method oscillates most", *_verdicts(_common.largest("Matrix"), moving)),
            Claim("At rest Madgwick oscillates more than Kalman and Mahony", *_verdicts(noisiest_filter, resting)),
            Claim("In motion Kalman oscillates least", *_verdicts(_common.smallest("Kalman"), moving)),
            Claim("Kalman is the most accurate", *_verdicts(_common.smallest("Kalman"), accurate)),
            Claim("Mahony is the fastest", *_common.verdicts(_common.fastest("Mahony"), *clocked)),
            Claim("The matrix method is the slowest", *_common.verdicts(_common.slowest("Matrix"), *clocked)),
        ],
        plots=_plots("at rest", rest[0]) + _plots("in motion", motion[0]),
    )


def filters(rate: float) -> dict[str, ar.Filter]:
    """The four methods."""
    return {name: _common.as_published(cls, "cocoli2023", rate) for name, cls in METHODS.items()}


def tilt(recording: ar.Recording) -> float:
    """The largest angle between the sensor's z axis and the vertical in motion, degrees; negative without motion."""
    quat = _common.truth(recording)[... if recording.mask is None else recording.mask]
    level = np.zeros_like(quat)
    level[:, 0] = 1.0
    return float(np.fmax.reduce(ar.metrics.inclination_error(quat, level, degrees=True), initial=-np.inf))


def oscillation(angle: FloatArray) -> FloatArray:
    """(..., T) distance of an angle to the mean of the window around."""
    known = ~np.isnan(angle)
    window = np.ones(WINDOW)
    total = np.convolve(np.where(known, angle, 0.0), window, mode="same")
    distance: FloatArray = angle - total / np.maximum(np.convolve(known, window, mode="same"), 1.0)
    return distance


def oscillations_at_rest(recordings: list[ar.Recording]) -> Angles:
    """Of the estimates themselves, as nothing moves."""

    def rms(est: ar.Estimate, recording: ar.Recording) -> FloatArray:
        swing = [oscillation(angle) for angle in np.degrees(est.euler()).T[:2]]
        return np.asarray(ar.metrics.rmse(np.stack(swing)))

    return _means(rms, recordings)


def oscillations(recordings: list[ar.Recording]) -> Angles:
    """Of the errors in the motion."""

    def rms(est: ar.Estimate, recording: ar.Recording) -> FloatArray:
        swing = [oscillation(error) for error in _common.angles(est, recording).T[:2]]
        return np.asarray(ar.metrics.rmse(np.stack(swing), recording.mask))

    return _means(rms, recordings)


def accuracies(recordings: list[ar.Recording]) -> Angles:
    """RMSE of roll and pitch in the motion."""
    return _means(lambda est, recording: _common.angle_rmse(est, recording)[:2], recordings)


def noisiest_filter(values: Mapping[str, float]) -> Verdict:
    """Whether Madgwick is it, among the filters."""
    among = {name: value for name, value in values.items() if name != "Matrix"}
    return _common.largest("Madgwick")(among)


def _means(measure: Callable[[ar.Estimate, ar.Recording], FloatArray], recordings: list[ar.Recording]) -> Angles:
    """Means over the recordings, for roll and pitch."""
    found: dict[str, list[FloatArray]] = {name: [] for name in METHODS}
    for recording in recordings:
        for name, f in filters(recording.rate).items():
            found[name].append(measure(_common.estimate(f, recording, nine_axes=False), recording))
    return {name: np.mean(values, axis=0) for name, values in found.items()} if recordings else {}


def _verdicts(judge: Callable[[Mapping[str, float]], Verdict], worlds: tuple[Angles, Angles]) -> Verdicts:
    """By the root mean square over roll and pitch."""
    simulated, real = ({name: float(np.sqrt((value**2).mean())) for name, value in world.items()} for world in worlds)
    return _common.verdicts(judge, simulated, real)


def _table(title: str, worlds: tuple[Angles, Angles], form: str) -> Table:
    rows: list[list[Cell]] = [
        [name, *(float(x) for world in worlds for x in world.get(name, UNKNOWN))] for name in METHODS
    ]
    return Table(title, ["method", "roll", "pitch", "roll (real)", "pitch (real)"], rows, form=form)


def _plots(title: str, recording: ar.Recording) -> list[Plot]:
    t = recording.t - recording.t[0]
    found = {
        name: np.degrees(_common.estimate(f, recording, nine_axes=False).euler())
        for name, f in filters(recording.rate).items()
    }
    found["truth"] = ar.metrics.euler(_common.truth(recording), degrees=True)
    return [
        lines(f"{name} {title}", t, {label: angles[:, i] for label, angles in found.items()}, "time [s]", f"{name} [°]")
        for i, name in enumerate(("Roll", "Pitch"))
    ]
