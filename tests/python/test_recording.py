"""Laws of `ahrs_rs.recording.Recording`."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ahrs_rs._recording import Recording
from ahrs_rs.io import read
from recordings import recording


def test_recording_takes_its_rate_from_its_parts_without_a_gap() -> None:
    t = np.concatenate([np.arange(100), 500 + np.arange(100)]) / 100
    gyr = np.zeros((200, 3))
    assert Recording(t=t, gyr=gyr).rate == pytest.approx(100.0, rel=1e-12)
    assert Recording(t=t, gyr=gyr, rate=50.0).rate == 50.0
    assert Recording(t=np.arange(200) / 100, gyr=gyr).rate == 199 / 1.99


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gyr": np.zeros((4, 3))}, r"gyr: expected shape \(5, 3\), got \(4, 3\)"),
        ({"acc": np.zeros(5)}, r"acc: expected shape \(5, 3\), got \(5,\)"),
        ({"ref": np.zeros((5, 3))}, r"ref: expected shape \(5, 4\), got \(5, 3\)"),
        ({"t": 3.0}, r"t: expected shape \(T,\), got \(\)"),
        (
            {"t": [0.0, 0.1, 0.05, 0.2, 0.3]},
            "t: expected times that do not decrease, got a decrease at index 2",
        ),
        ({"t": [0.0, 0.1, np.nan, 0.2, 0.3]}, "t: expected finite times, got nan at index 2"),
        ({"t": np.zeros(5)}, "rate: expected a number"),
        ({"rate": -1.0}, "rate: expected a positive number of Hz, got -1.0"),
        ({"rate": np.inf}, "rate: expected a positive number of Hz, got inf"),
        ({"mask": np.full(5, 2)}, "mask: expected an array of bool"),
        ({"mag": np.full((5, 3), "x")}, "mag: expected an array of real numbers"),
        ({"mag": [[1.0, 2.0], [3.0]]}, "mag: expected an array of real numbers"),
    ],
)
def test_recording_refuses_what_does_not_fit(change: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"t": np.arange(5) / 10, "gyr": np.zeros((5, 3))} | change
    with pytest.raises(ValueError, match=message):
        Recording(**arguments)


def test_recording_is_float64_whatever_it_is_given() -> None:
    source = Recording(t=np.arange(3), gyr=np.zeros((3, 3), np.float32), mask=np.array([0, 1, 1]))
    assert (source.t.dtype, source.gyr.dtype) == (np.float64, np.float64)
    assert source.mask is not None
    assert source.mask.tolist() == [False, True, True]


def test_slice_of_a_recording_cuts_every_array_and_keeps_rate_and_meta() -> None:
    source = recording()
    part = source[10:20]
    assert len(part) == 10
    assert part.rate == source.rate
    assert part.meta == source.meta
    for name in ("t", "gyr", "acc", "mag", "ref", "mask", "temperature"):
        assert np.array_equal(getattr(part, name), getattr(source, name)[10:20])
    assert len(source[:0]) == 0
    with pytest.raises(ValueError, match="step"):
        source[::2]
    with pytest.raises(TypeError, match="slice"):
        source[3]


def test_repr_tells_size_rate_and_contents() -> None:
    text = repr(Recording(t=np.arange(200) / 100, gyr=np.zeros((200, 3)), acc=np.zeros((200, 3))))
    assert text == "Recording(200 samples, 1.99 s, 100 Hz, gyr acc)"


def test_saved_recording_is_read_back_as_it_was(tmp_path: Path) -> None:
    source = recording()
    source.gyr[3] = np.nan
    source.save(tmp_path / "a.npz")
    back = read(tmp_path / "a.npz")
    assert back.rate == source.rate
    assert back.meta["note"] == "random"
    assert back.meta["repairs"] == []
    for name in ("t", "gyr", "acc", "mag", "ref", "mask", "temperature"):
        assert np.array_equal(getattr(back, name), getattr(source, name), equal_nan=name != "mask")
    with pytest.raises(ValueError, match=r"ends in \.npz, \.parquet or \.csv, got 'a.mat'"):
        source.save(tmp_path / "a.mat")


def test_recording_survives_pickling() -> None:
    source = recording()
    back = pickle.loads(pickle.dumps(source))
    assert np.array_equal(back.gyr, source.gyr)
    assert back.rate == source.rate
