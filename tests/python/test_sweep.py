"""Sweeps over parameter sets: the errors of runs, without the runs' attitudes."""

from __future__ import annotations

import dataclasses
import importlib.util
import os
import signal
import threading
import time
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar
from cases import Case, each_case
from signals import RATE, Signals, gappy, motion

METRICS = ("total", "heading", "inclination")
#: Rounding of the angle of an error and of sums of some hundred squares, in degrees.
ROUNDING = 1e-9


def recording(signals: Signals, **fields: Any) -> ar.Recording:
    """The signals with their truth."""
    sensors = dict(zip(("gyr", "acc", "mag"), signals.sensors(), strict=True))
    return ar.Recording(**{"t": signals.t, "ref": signals.truth, "rate": RATE, **sensors, **fields})


def recordings() -> list[ar.Recording]:
    """A whole one, one in six axes with gaps of which half counts, and a short one whose truth is partly unknown."""
    half = np.arange(300) % 2 == 0
    unknown = motion(40, 3).truth.copy()
    unknown[5:9] = np.nan
    return [
        recording(motion(500, 1)),
        recording(gappy(motion(300, 2, jitter=True), 2), mag=None, mask=half),
        recording(motion(40, 3), ref=unknown),
    ]


def error(f: ar.Filter, one: ar.Recording, metric: str) -> float:
    """By a run and `metrics.score`."""
    est = f.run(one.gyr, one.acc, one.mag, t=one.t)
    assert one.ref is not None
    return float(getattr(ar.metrics.score(est.quat, one.ref, one.mask), metric))


@pytest.mark.parametrize("metric", METRICS)
@each_case
def test_the_error_of_a_parameter_set_is_that_of_its_run(case: Case, metric: str) -> None:
    found = ar.sweep(case.cls, [dict(case.params)], recordings(), metric)
    expected = [error(case.make(rate=RATE), one, metric) for one in recordings()]
    assert found.errors[0] == pytest.approx(expected, abs=ROUNDING)
    assert found.done.all()


def test_every_combination_of_a_grid_is_taken_in_order_whatever_the_choices() -> None:
    grid = {"beta": np.linspace(0.01, 0.3, 7), "gradient": ["tangent", "paper"], "zeta": 0.0}
    found = ar.sweep(ar.Madgwick, grid, recordings(), "inclination")
    assert [(one["beta"], one["gradient"]) for one in found.params] == [
        (beta, gradient) for beta in grid["beta"] for gradient in grid["gradient"]
    ]
    for one, errors in zip(found.params, found.errors, strict=True):
        expected = [error(ar.Madgwick(rate=RATE, **one), r, "inclination") for r in recordings()]
        assert errors == pytest.approx(expected, abs=ROUNDING)


def test_threads_and_dtype_change_no_more_than_rounding() -> None:
    grid = {"kp": np.linspace(0.1, 2.0, 40)}
    found = ar.sweep(ar.Mahony, grid, recordings(), threads=1)
    assert np.array_equal(ar.sweep(ar.Mahony, grid, recordings(), threads=5).errors, found.errors)
    # Feedback forgets rounding: 4e-5 rad at most between the dtypes of a run.
    narrow = ar.sweep(ar.Mahony, grid, recordings(), dtype=np.float32)
    assert narrow.errors == pytest.approx(found.errors, abs=np.degrees(4e-5))
    assert not np.array_equal(narrow.errors, found.errors)


def test_the_frame_of_the_sweep_is_that_of_the_truth() -> None:
    one = recording(motion(200, 5))
    ned = ar.Madgwick(rate=RATE, frame="NED").run(one.gyr, one.acc, one.mag, t=one.t)
    turned = dataclasses.replace(one, ref=ned.quat)
    assert ar.sweep(ar.Madgwick, {"beta": 0.041}, [turned], frame="NED").errors[0, 0] < 1e-9
    assert ar.sweep(ar.Madgwick, {"beta": 0.041}, [turned]).errors[0, 0] > 50.0


def test_the_best_is_the_smallest_mean_and_the_smallest_of_each() -> None:
    found = ar.sweep(ar.Madgwick, {"beta": [0.001, 0.05, 3.0]}, recordings())
    assert found.best == found.params[int(np.argmin(found.errors.mean(axis=1)))]
    assert found.best_each == [found.params[int(p)] for p in np.argmin(found.errors, axis=0)]
    assert found.best["beta"] == 0.05


@pytest.mark.skipif(importlib.util.find_spec("polars") is None, reason="needs polars")
def test_a_frame_has_a_row_for_each_error() -> None:
    found = ar.sweep(ar.Madgwick, {"beta": [0.1, 0.2]}, recordings())
    frame = found.to_frame()
    assert found.to_polars().equals(frame)
    assert list(found.to_pandas()["error"]) == frame["error"].to_list()
    assert frame.columns == ["beta", "recording", "error"]
    assert frame["error"].to_list() == found.errors.reshape(-1).tolist()
    assert frame["recording"].to_list() == [0, 1, 2, 0, 1, 2]
    assert frame["beta"].to_list() == [0.1, 0.1, 0.1, 0.2, 0.2, 0.2]


def test_a_function_can_be_the_metric() -> None:
    def last_angle(est: ar.Estimate, one: ar.Recording) -> float:
        return float(ar.metrics.total_error(est.quat[-1], np.nan_to_num(one.ref[-1])))

    found = ar.sweep(ar.Madgwick, {"beta": [0.1, 0.2]}, recordings(), last_angle)
    assert found.metric == "last_angle"
    one = recordings()[1]
    est = ar.Madgwick(rate=RATE, beta=0.2).run(one.gyr, one.acc, one.mag, t=one.t)
    assert found.errors[1, 1] == last_angle(est, one)


def test_no_sample_that_counts_is_no_error_and_not_the_best() -> None:
    nothing = recording(motion(30, 1), mask=np.zeros(30, dtype=bool))
    found = ar.sweep(ar.Madgwick, {"beta": [0.1, 0.2]}, [nothing])
    assert np.isnan(found.errors).all()
    assert found.done.all()
    with pytest.raises(ValueError, match="no parameter set has an error"):
        found.best  # noqa: B018  # the property is what is tested
    both = ar.sweep(ar.Madgwick, {"beta": [0.1, 0.2]}, [nothing, recording(motion(30, 1))])
    assert np.array_equal(both.mean, both.errors[:, 1])


def test_progress_is_told_to_a_function() -> None:
    told: list[tuple[int, int]] = []
    ar.sweep(ar.Madgwick, {"beta": np.linspace(0.1, 1.0, 10)}, recordings(), progress=lambda *n: told.append(n))
    assert told[-1] == (30, 30)
    assert [done for done, _ in told] == sorted(done for done, _ in told)


def long_one() -> ar.Recording:
    signals = motion(20_000, 1)
    return recording(signals)


def test_an_interrupted_sweep_keeps_what_was_done_and_goes_on_from_it() -> None:
    grid = {"beta": np.linspace(0.01, 1.0, 600)}
    trials = [recording(motion(50, seed)) for seed in range(3)] + [long_one()] * 20
    began = threading.Event()

    def interrupt() -> None:
        began.wait()
        time.sleep(0.5)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    began.set()
    with pytest.raises(ar.SweepInterrupted) as caught:
        ar.sweep(ar.Madgwick, grid, trials, threads=1)
    thread.join()
    partial = caught.value.partial
    assert isinstance(caught.value, KeyboardInterrupt)
    assert not partial.done.all()
    assert np.isnan(partial.errors[~partial.done]).all()
    assert not np.isnan(partial.errors[partial.done]).any()
    # Going on needs no more than what is missing; the short recordings show it.
    few = [trials[0], trials[1]]
    small = ar.sweep(ar.Madgwick, {"beta": [0.1, 0.2, 0.3]}, few)
    half = dataclasses.replace(small, errors=small.errors.copy(), done=small.done.copy())
    half.errors[1:, 0], half.done[1:, 0] = np.nan, False
    half.errors[0, 1] = 77.0
    whole = ar.sweep(ar.Madgwick, {"beta": [0.1, 0.2, 0.3]}, few, resume=half)
    assert whole.done.all()
    assert np.array_equal(whole.errors[:, 0], small.errors[:, 0])
    assert whole.errors[0, 1] == 77.0


def test_an_interrupted_run_does_not_go_on_to_its_end() -> None:
    # Some seconds of work, of which half a second is done.
    data = np.tile([0.0, 0.0, 9.8], (10_000_000, 1))

    def interrupt() -> None:
        time.sleep(0.5)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        ar.MEKF(rate=RATE).run(data, data)
    thread.join()


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"grid": {"beta": [-1.0]}}, "beta: expected a number in"),
        ({"grid": {"gain": [1.0]}}, "Madgwick has no parameter 'gain'"),
        ({"metric": "speed"}, "metric: expected one of"),
        ({"recordings": [{"t": [0.0], "gyr": [[0.0, 0.0, 0.0]], "rate": 1.0}]}, "recording 0: expected ref"),
        ({"recordings": [{"t": [0.0], "gyr": [[0.0]]}]}, "recording 0: gyr: expected shape"),
        ({"threads": 0}, "threads: expected"),
        ({"frame": "XYZ"}, "frame"),
    ],
)
def test_what_is_wrong_is_named(keywords: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"grid": {"beta": [0.1]}, "recordings": recordings(), **keywords}
    with pytest.raises((ValueError, TypeError), match=message):
        ar.sweep(ar.Madgwick, arguments.pop("grid"), arguments.pop("recordings"), **arguments)


def test_a_sweep_goes_on_from_its_like_only() -> None:
    found = ar.sweep(ar.Madgwick, {"beta": [0.1]}, recordings())
    for other in ({"beta": [0.2]}, {"beta": [0.1], "zeta": 0.1}):
        with pytest.raises(ValueError, match="resume: expected a sweep of the same"):
            ar.sweep(ar.Madgwick, other, recordings(), resume=found)


def test_a_sweep_of_nothing_is_empty() -> None:
    assert ar.sweep(ar.Madgwick, {"beta": []}, recordings()).errors.shape == (0, 3)
    assert ar.sweep(ar.Madgwick, {"beta": [0.1]}, []).errors.shape == (1, 0)
