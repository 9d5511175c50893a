"""Laws of the repair of times in `ahrs_rs.io.read`."""

from __future__ import annotations

import importlib
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ahrs_rs._recording import Recording
from ahrs_rs.io import read

#: Every repair is told as a warning; test_read_told.py has their tests.
pytestmark = pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")


def repaired(tmp_path: Path, t: list[float]) -> Recording:
    np.savez(tmp_path / "a.npz", t=np.array(t), gyr=np.zeros((len(t), 3)))
    return read(tmp_path / "a.npz")


def test_decreasing_stamp_holds_the_time_before(tmp_path: Path) -> None:
    far = repaired(tmp_path, [0.0, 1.0, 2.0, -500.0, 4.0, 5.0])
    assert far.t.tolist() == [0.0, 1.0, 2.0, 2.0, 4.0, 5.0]
    assert far.meta["repairs"] == ["t: decreases 1 times, first at index 3; the time before is held"]
    # Which of two rows a missing stamp was before is not known: nothing is sorted.
    found = repaired(tmp_path, [0.0, 1.0, np.nan, 3.0, 2.5, 4.0, 5.0])
    assert found.t.tolist() == [0.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0]


def test_rows_that_come_late_are_sorted_by_their_stamps(tmp_path: Path) -> None:
    t = np.arange(200.0)
    for late in ([0, 1, 3, 2, 4], [0, 5, 6, 1, 2, 3, 4, 7], [*range(40, 60), *range(20, 40), *range(60, 80)]):
        rows = [*late, *range(max(late) + 1, 200)]
        np.savez(tmp_path / "a.npz", t=t[rows], gyr=np.tile(t[rows, np.newaxis], (1, 3)) / 100)
        found = read(tmp_path / "a.npz")
        assert found.t.tolist() == sorted(t[rows])
        assert found.gyr is not None
        assert np.array_equal(found.gyr[:, 0], found.t / 100)
        assert "sorted by their stamps" in found.meta["repairs"][0]


def test_single_stamp_far_ahead_does_not_stop_the_clock(tmp_path: Path) -> None:
    found = repaired(tmp_path, [0.0, 1.0, 2.0, 5000.0, 4.0, 5.0])
    assert found.t.tolist() == [0.0, 1.0, 2.0, 2.0, 4.0, 5.0]
    assert found.meta["repairs"] == ["t: 1 stamps far ahead, first at index 3, hold the time before"]


def test_clock_that_starts_anew_is_continued(tmp_path: Path) -> None:
    t = [*range(100), *range(50), *range(30)]
    found = repaired(tmp_path, [float(value) for value in t])
    assert found.t.tolist() == list(range(180))
    assert found.meta["repairs"] == ["t: clock restarts 2 times, first at index 100; continued"]


def test_missing_stamps_are_interpolated(tmp_path: Path) -> None:
    found = repaired(tmp_path, [np.nan, 1.0, np.inf, 3.0, 4.0, np.nan])
    assert found.t.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert found.meta["repairs"] == ["t: 3 missing stamps interpolated"]


def test_repeated_stamps_are_kept(tmp_path: Path) -> None:
    found = repaired(tmp_path, [0.0, 1.0, 1.0, 1.0, 2.0])
    assert found.t.tolist() == [0.0, 1.0, 1.0, 1.0, 2.0]
    assert found.meta["repairs"] == []


# Differences of times up to 1e300 s do not overflow.
stamp = st.floats(-1e6, 1e6) | st.floats(-1e300, 1e300) | st.just(math.nan)


@given(st.lists(stamp, min_size=1, max_size=60) | st.lists(st.integers(-3, 30).map(float), max_size=60))
def test_repaired_times_are_finite_and_do_not_decrease(t: list[float]) -> None:
    order = importlib.import_module("ahrs_rs.io._clocks").ordered
    repairs: list[str] = []
    given_times = np.array(t)
    finite = given_times[np.isfinite(given_times)]
    rises = np.diff(finite) > 0
    try:
        out, rows = order(given_times.copy(), repairs)
    except ValueError:
        # Refused only where the stamps do not tell a direction.
        assert not rises.any() or finite.size < 2
        return
    assert out.shape == given_times.shape
    assert rows is None or sorted(rows.tolist()) == list(range(len(out)))
    assert np.isfinite(out).all()
    assert (np.diff(out) >= 0).all()
    good = np.isfinite(given_times).all() and (np.diff(given_times) >= 0).all()
    assert bool(repairs) != good
    if good:
        assert np.array_equal(out, given_times)
