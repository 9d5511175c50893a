"""What one tries in the first hour: it works, or the error says what to do."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ahrs_rs as ar

RATE = 100.0
STILL = np.zeros((20, 3)), np.tile([0.0, 0.0, 9.81], (20, 1))
RECORDING = ar.Recording(gyr=STILL[0], acc=STILL[1], t=np.arange(20) / RATE, ref=np.tile([1.0, 0.0, 0.0, 0.0], (20, 1)))
GRID = {"beta": [0.1, 0.2]}

TRAPS: list[tuple[Callable[[], Any], type[Exception], str]] = [
    (lambda: ar.Madgwick(RATE), TypeError, "Madgwick: expected keywords, as Madgwick(rate=100.0), got 100.0 as a"),
    (lambda: ar.Madgwick(*STILL), TypeError, "Madgwick: expected keywords, as Madgwick(rate=100.0), got ndarray, nda"),
    (lambda: ar.Filter(rate=1), TypeError, "Filter: expected one of the classes in ar.FILTERS, as ar.Madgwick, got"),
    (lambda: ar.Madgwick(bta=1.0), TypeError, "Madgwick has no parameter 'bta' (did you mean beta?); it takes beta"),
    (lambda: ar.Madgwick(frame="enu"), ValueError, "'NWU', got 'enu' (did you mean ENU?)"),
    (
        lambda: ar.Madgwick(gradient="Paper"),
        ValueError,
        "gradient: expected one of 'tangent', 'paper', got 'Paper' (di",
    ),
    (lambda: ar.Madgwick(beta=-1), ValueError, "beta: expected a number in [0, 1e+06] rad/s, got -1.0"),
    (lambda: ar.Mahony.preset("hyyti"), ValueError, "got 'hyyti' (did you mean hyyti2015?)"),
    (
        lambda: ar.FILTERS["madgwick"],
        KeyError,
        "expected the name of a filter, got 'madgwick' (did you mean Madgwick?)",
    ),
    (
        lambda: ar.MEKF(rate=RATE).run(*STILL, outputs=["covarianc"]),
        ValueError,
        "'covarianc' (did you mean covariance?)",
    ),
    (lambda: ar.run_many(ar.Madgwick, []), TypeError, "f: expected a filter, as Madgwick(rate=100.0), got the class"),
    (
        lambda: ar.run_many([RECORDING], ar.Madgwick()),
        TypeError,
        "f: expected a filter, as ar.Madgwick(rate=100.0), got",
    ),
    (lambda: ar.run_many(ar.Madgwick(), RECORDING), TypeError, "got a single Recording: f.run(recording) takes it"),
    (lambda: ar.sweep(ar.Madgwick(), GRID, [RECORDING]), TypeError, "filter: expected the class, as ar.Madgwick, got"),
    (lambda: ar.sweep(ar.Filter, GRID, [RECORDING]), TypeError, "filter: expected a class of ar.FILTERS, as ar.Madgw"),
    (lambda: ar.sweep("Madgwick", GRID, [RECORDING]), TypeError, "filter: expected a class of ar.FILTERS, as ar.Madgw"),
    (lambda: ar.sweep(ar.Madgwick, [RECORDING], GRID), TypeError, "got recordings: sweep(filter, grid, recordings)"),
    (lambda: ar.tuning.grid(ar.Madgwick(), GRID, [RECORDING]), TypeError, "filter: expected the class, as ar.Madgwick"),
    (lambda: ar.tuning.grid(ar.Madgwick, ["bet"], [RECORDING]), ValueError, "no parameter 'bet' (did you mean beta?)"),
    (lambda: ar.Madgwick().run("walk.csv"), ValueError, "got a path: give ar.read('walk.csv')"),
    (lambda: ar.Madgwick().run(Path("walk.csv")), ValueError, "got a path: give ar.read('walk.csv')"),
    (lambda: ar.Madgwick().run([RECORDING]), ValueError, "got several: ar.run_many(f, recordings) takes them"),
    (lambda: ar.Madgwick().run({"gyr": 1, "acc": 2}), ValueError, "got a dict of gyr, acc"),
    (lambda: ar.simulate.scenario("static", rol=1.0), ValueError, "no parameter 'rol' (did you mean roll?)"),
]


@pytest.mark.parametrize(("attempt", "error", "message"), TRAPS)
def test_what_does_not_work_says_what_does(attempt: Callable[[], Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error) as caught:
        attempt()
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_without_a_like_one_get_no_hint() -> None:
    with pytest.raises(KeyError) as caught:
        ar.FILTERS["xyz"]
    assert str(caught.value) == "expected the name of a filter, got 'xyz'"
    assert "madgwick" not in ar.FILTERS
    assert ar.FILTERS.get("madgwick") is None


def test_a_recording_is_run_as_its_arrays_are() -> None:
    f = ar.Madgwick(rate=RATE)
    assert np.array_equal(f.run(RECORDING).quat, f.run(*STILL).quat)


def test_plots_are_there_without_an_import() -> None:
    assert ar.plots.draw.__module__.startswith("ahrs_rs.plots")


@pytest.mark.parametrize("name", ar.FILTERS)
def test_filters_are_equal_where_class_parameters_and_settings_are(name: str) -> None:
    cls = ar.FILTERS[name]
    f = cls(rate=RATE, frame="NED")
    for twin in (cls(rate=100, frame="NED"), copy.deepcopy(f), pickle.loads(pickle.dumps(f)), cls(**f.get_params())):
        assert f == twin
        assert hash(f) == hash(twin)
    others: list[object] = [cls(rate=50.0, frame="NED"), cls(rate=RATE), f.replace(dtype=np.float32), name]
    others += [other(rate=RATE, frame="NED") for other in ar.FILTERS.values() if other is not cls]
    assert all(f != other for other in others)
    assert len({f, *others}) == 1 + len(others)


def test_the_streaming_state_does_not_count_in_the_comparison() -> None:
    f, other = ar.Madgwick(rate=RATE), ar.Madgwick(rate=RATE)
    before = hash(f)
    f.update([0.0, 0.0, 1.0], [0.0, 0.0, 9.81])
    assert f == other
    assert hash(f) == before == hash(other)


def test_replace_changes_what_it_names_and_starts_afresh() -> None:
    f = ar.Madgwick(rate=RATE, beta=0.1, declination=0.2, dtype=np.float32)
    f.update([0.0, 0.0, 1.0], [0.0, 0.0, 9.81])
    changed = f.replace(beta=0.5)
    assert changed == ar.Madgwick(rate=RATE, beta=0.5, declination=0.2, dtype=np.float32)
    assert np.array_equal(changed.quat, [1.0, 0.0, 0.0, 0.0])
    assert f.beta == 0.1
    assert f.replace() == f
    with pytest.raises(TypeError, match=r"no parameter 'bet' \(did you mean beta\?\)"):
        f.replace(bet=0.5)
    with pytest.raises(AttributeError, match=r"beta cannot be changed: f.replace\(beta=...\) gives another Madgwick"):
        f.beta = 0.5


def test_get_params_has_all_keywords_of_the_constructor() -> None:
    params = ar.Madgwick(rate=RATE, beta=0.5).get_params()
    settings = {"rate", "frame", "declination", "gyr_hold", "repeated", "gyr_range", "dtype"}
    assert params.keys() == settings | ar.Madgwick.PARAMS.keys()
    assert (params["rate"], params["beta"], params["dtype"]) == (RATE, 0.5, np.float64)
    params["beta"] = 1.0  # a copy
    assert ar.Madgwick(rate=RATE, beta=0.5).beta == 0.5


def test_the_old_order_of_a_search_is_told_by_type() -> None:
    expected = ar.tuning.grid(ar.Madgwick, GRID, [RECORDING])
    for params in (GRID, {"beta": [0.1, 0.2]}):
        with pytest.warns(DeprecationWarning, match="params: expected before recordings"):
            old = ar.tuning.grid(ar.Madgwick, [RECORDING], params)
        assert (old.params, old.train.mean) == (expected.params, expected.train.mean)
    with pytest.warns(DeprecationWarning, match="params: expected before recordings"):
        old = ar.tuning.grid(ar.Madgwick, iter([RECORDING]), points=2)
    new = ar.tuning.grid(ar.Madgwick, None, [RECORDING], points=2)
    assert (old.params, old.evaluated) == (new.params, new.evaluated)
    evolved = ar.tuning.evolve(ar.Madgwick, ["beta"], [RECORDING], generations=1, population=4)
    with pytest.warns(DeprecationWarning, match="params: expected before recordings"):
        old = ar.tuning.evolve(ar.Madgwick, [RECORDING], ["beta"], generations=1, population=4)
    assert old.params == evolved.params
