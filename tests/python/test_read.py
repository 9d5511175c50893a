"""Laws of `ahrs_rs.io.read`: finding the format, and BROAD, RepoIMU and numpy files.

Recordings of the real data sets are read from the folder that AHRS_RS_DATA names.
"""

from __future__ import annotations

import builtins
import importlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ahrs_rs import metrics
from ahrs_rs.io import FORMATS, read, write_estimate
from recordings import REPOIMU_HEADERS, recording, repoimu_rows, write_broad, write_repoimu, write_text

h5py = pytest.importorskip("h5py")
pytest.importorskip("pyarrow")

DATA = os.environ.get("AHRS_RS_DATA", "")
needs_data = pytest.mark.skipif(not DATA, reason="AHRS_RS_DATA is not set")

GRAVITY = 9.80665

#: Units that a file does not state, and the like, are told; test_read_told.py has their tests.
pytestmark = pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")


def test_every_shared_recording_is_read_without_a_repair_of_the_samples(recordings: list[Path]) -> None:
    for path in recordings:
        found = read(path)
        assert len(found) > 1000
        assert found.acc is not None
        assert found.mag is not None
        assert found.gyr is not None
        assert np.isfinite(found.gyr).all()
        assert 70 < found.rate < 300
        # At rest or on average a sensor on earth reads about 9.8 m/s², in a runner's hand 13.5: tells wrong units.
        assert 8 < np.median(np.linalg.norm(found.acc, axis=1)) < 14
        assert not [repair for repair in found.meta["repairs"] if not repair.startswith("mask")]


@needs_data
def test_broad_trial_is_read_as_stored() -> None:
    path = next(iter(sorted((Path(DATA) / "broad").glob("*.hdf5"))))
    found = read(path)
    with h5py.File(path) as file:
        for name, key in {"gyr": "imu_gyr", "acc": "imu_acc", "mag": "imu_mag", "ref": "opt_quat"}.items():
            assert np.array_equal(getattr(found, name), file[key][()], equal_nan=True)
        assert np.array_equal(found.mask, file["movement"][()])
        assert found.rate == file.attrs["sampling_rate"]
    assert np.array_equal(found.t, np.arange(len(found)) / found.rate)
    assert found.meta["format"] == "broad"
    assert found.meta["path"] == str(path)


@needs_data
@pytest.mark.parametrize("pattern", ["repoimu/TStick*.csv", "repoimu/Pendulum*.csv"])
def test_repoimu_recordings_are_read_as_stored(pattern: str) -> None:
    for path in sorted(Path(DATA).glob(pattern)):
        found = read(path)
        stored = np.genfromtxt(path, delimiter=";", skip_header=2)
        assert np.array_equal(found.t, stored[:, 0])
        parts = {"ref": (1, 5), "acc": (5, 8), "gyr": (8, 11), "mag": (11, 14)}
        for name, (start, stop) in parts.items():
            assert np.array_equal(getattr(found, name), stored[:, start:stop])
        assert found.meta["format"] == "repoimu"


@needs_data
def test_x_io_recording_is_read_in_si_units() -> None:
    path = Path(DATA) / "fusion" / "sensor_data.csv"
    found = read(path)
    stored = np.genfromtxt(path, delimiter=",", skip_header=1)
    assert np.array_equal(found.t, stored[:, 0])
    assert np.array_equal(found.gyr, np.radians(stored[:, 1:4]))
    assert np.array_equal(found.acc, stored[:, 4:7] * GRAVITY)
    assert np.array_equal(found.mag, stored[:, 7:10])
    assert found.meta["units"] == {"t": "s", "gyr": "deg/s", "acc": "g", "mag": "uT"}
    assert found.meta["assumed_units"] == {}


@needs_data
def test_npz_of_vqf_is_read_as_stored() -> None:
    path = Path(DATA) / "vqf" / "imu_data.npz"
    found, stored = read(path), np.load(path)
    for name in ("gyr", "acc", "mag"):
        assert np.array_equal(getattr(found, name), stored[name])
    assert found.rate == stored["sampling_rate"]
    assert np.array_equal(found.t, np.arange(13500) / found.rate)


# BROAD


def test_broad_trial_without_the_optional_arrays_is_read(tmp_path: Path) -> None:
    source = recording()
    found = read(write_broad(tmp_path / "a.hdf5", source, imu_mag=None, opt_quat=None, movement=None))
    assert found.mag is None
    assert found.ref is None
    assert found.mask is None
    assert np.array_equal(found.gyr, source.gyr)


def test_hdf5_that_is_no_trial_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no data set 'imu_gyr' among"):
        read(write_broad(tmp_path / "a.hdf5", recording(), imu_gyr=None))
    with h5py.File(tmp_path / "b.h5", "w") as file:
        file["imu_gyr"] = np.zeros((5, 3))
    with pytest.raises(ValueError, match="no attribute 'sampling_rate'"):
        read(tmp_path / "b.h5")


def test_damaged_hdf5_is_refused(tmp_path: Path) -> None:
    whole = write_broad(tmp_path / "a.hdf5", recording(2000)).read_bytes()
    (tmp_path / "b.hdf5").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"b\.hdf5: is not a readable HDF5 file"):
        read(tmp_path / "b.hdf5")


# RepoIMU


@pytest.mark.parametrize("variant", REPOIMU_HEADERS)
def test_every_variant_of_repoimu_is_read_alike(tmp_path: Path, variant: str) -> None:
    source = recording()
    found = read(write_repoimu(tmp_path / "a.csv", repoimu_rows(source), variant))
    assert found.meta["format"] == "repoimu"
    for name in ("t", "ref", "acc", "gyr", "mag"):
        assert np.array_equal(getattr(found, name), getattr(source, name))
    assert found.mask is None


def test_repoimu_keeps_missing_values_and_drops_lost_truth(tmp_path: Path) -> None:
    rows = repoimu_rows(recording())
    rows[3][1:5] = ["", "", "", ""]
    rows[4][1:5] = ["0", "0", "0", "0"]
    rows[5][1:5] = ["NaN"] * 4
    rows[6][5:14] = ["NaN"] * 9
    rows[7][1:5] = ["1", "1.6232e-035", "0", "0"]
    found = read(write_repoimu(tmp_path / "a.csv", rows))
    assert found.ref is not None
    assert found.acc is not None
    assert np.flatnonzero(np.isnan(found.ref).any(axis=1)).tolist() == [3, 4, 5]
    assert np.isnan(found.gyr[6]).all()
    assert np.isnan(found.acc[6]).all()
    assert found.ref[7].tolist() == [1.0, 1.6232e-35, 0.0, 0.0]
    assert any("ref: 1 rows" in repair for repair in found.meta["repairs"])
    assert len(found) == 50


def test_repoimu_rows_with_a_held_truth_do_not_count(tmp_path: Path) -> None:
    rows = repoimu_rows(recording(100))
    for k in range(41, 70):
        rows[k][1:5] = rows[40][1:5]
    for k in range(81, 86):  # too short to be told from a still sensor
        rows[k][1:5] = rows[80][1:5]
    found = read(write_repoimu(tmp_path / "a.csv", rows))
    assert found.mask is not None
    assert found.ref is not None
    assert np.flatnonzero(~found.mask).tolist() == list(range(41, 70))
    assert np.isfinite(found.ref).all()
    assert found.meta["repairs"] == ["mask: 29 rows with a held truth do not count"]


def test_repoimu_with_wrong_columns_is_refused(tmp_path: Path) -> None:
    rows = repoimu_rows(recording())
    path = write_repoimu(tmp_path / "a.csv", rows)
    text = path.read_text()
    path.write_text(text.replace(";W;X;Y;Z;", ";X;Y;Z;W;", 1))
    with pytest.raises(ValueError, match=r"expected .* below 'vicon orientation'"):
        read(path)
    path.write_text(text.replace("IMU Magnetometer", "IMU Compass", 1))
    with pytest.raises(ValueError, match="no column group 'imu magnetometer'"):
        read(path)
    path.write_text("\n".join(text.splitlines()[:2]) + "\n")
    with pytest.raises(ValueError, match="has a header, but no rows"):
        read(path)
    path.write_text(text.splitlines()[0] + "\n")
    with pytest.raises(ValueError, match="has a header, but no rows"):
        read(path)
    short = [line.rsplit(";", 2)[0] for line in text.splitlines()[2:]]
    path.write_text("\n".join([*text.splitlines()[:2], *short]) + "\n")
    with pytest.raises(ValueError, match=r"line 3: expected .* cells, got 12"):
        read(path)


# npz


def test_npz_without_times_needs_a_rate(tmp_path: Path) -> None:
    gyr = np.zeros((5, 3))
    np.savez(tmp_path / "a.npz", gyr=gyr, rate=50.0)
    assert read(tmp_path / "a.npz").t.tolist() == [0.0, 0.02, 0.04, 0.06, 0.08]
    np.savez(tmp_path / "a.npz", gyr=gyr)
    with pytest.raises(ValueError, match="has no times"):
        read(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", gyr=gyr, sampling_rate=-1.0)
    with pytest.raises(ValueError, match="rate: expected one positive number of Hz"):
        read(tmp_path / "a.npz")


def test_npz_of_wrong_contents_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    for arrays, message in (
        ({"foo": np.zeros((5, 3))}, "has no array 'gyr', 'acc' or 'mag'"),
        ({"gyr": np.zeros((0, 3)), "rate": 1.0}, "has no samples"),
        ({"gyr": np.zeros((5, 2)), "rate": 1.0}, r"gyr: expected shape \(5, 3\), got \(5, 2\)"),
        ({"gyr": np.zeros((5, 3)), "acc": np.zeros((4, 3)), "rate": 1.0}, r"acc: expected shape \(5, 3\)"),
        ({"gyr": np.array([["a"] * 3]), "rate": 1.0}, "gyr: expected real numbers"),
        ({"gyr": np.zeros((5, 3)), "t": np.zeros((5, 1))}, r"t: expected times \(T,\)"),
        ({"gyr": np.zeros((5, 3)), "rate": 1.0, "meta": "no json"}, "meta: expected a JSON object"),
        ({"gyr": np.array([{}, []], dtype=object), "rate": 1.0}, "is not a readable .npz file"),
    ):
        np.savez(path, **arrays)
        with pytest.raises(ValueError, match=message):
            read(path)


def test_truth_with_an_impossible_norm_is_mended_or_dropped(tmp_path: Path) -> None:
    ref = np.tile([1.0, 0.0, 0.0, 0.0], (5, 1)) * np.array([1.0, 1.0005, 0.95, 0.0, 3.0])[:, None]
    np.savez(tmp_path / "a.npz", gyr=np.zeros((5, 3)), rate=1.0, ref=ref)
    found = read(tmp_path / "a.npz")
    assert found.ref is not None
    assert found.ref[:, 0].tolist()[:3] == [1.0, 1.0005, 1.0]
    assert np.isnan(found.ref[3:]).all()
    assert len(found.meta["repairs"]) == 2
    metrics.score(np.tile([1.0, 0, 0, 0], (5, 1)), found.ref)  # what is left is accepted as a reference


# finding the format


def test_format_is_found_from_the_content_whatever_the_ending(tmp_path: Path) -> None:
    source = recording()
    source.save(tmp_path / "a.npz")
    (tmp_path / "a.npz").rename(tmp_path / "a.dat")
    write_broad(tmp_path / "b.txt", source)
    write_text(tmp_path / "c.log", "t,gx,gy,gz", np.column_stack((source.t, source.gyr)))
    found = {name: read(tmp_path / name).meta["format"] for name in ("a.dat", "b.txt", "c.log")}
    assert found == {"a.dat": "npz", "b.txt": "broad", "c.log": "csv"}
    assert set(found.values()) <= set(FORMATS)


def test_given_format_is_taken_and_an_unknown_one_refused(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.csv", "t,gx,gy,gz", np.ones((5, 4)) * np.arange(5)[:, None])
    assert read(str(path), format="csv").meta["format"] == "csv"
    with pytest.raises(ValueError, match=r"is not a readable \.npz file"):
        read(path, format="npz")
    with pytest.raises(ValueError, match=r"format: expected one of .*npz, .*csv, got 'mat'"):
        read(path, format="mat")


@pytest.mark.parametrize("name", ["a.csv", "a.hdf5", "a.npz", "a.parquet", "a"])
def test_missing_empty_and_foreign_files_are_told_in_one_line(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with pytest.raises(FileNotFoundError, match=f"{name}: no such file"):
        read(path)
    path.touch()
    with pytest.raises(ValueError, match=f"{name}: is empty"):
        read(path)
    path.write_bytes(bytes(range(256)) * 100)
    with pytest.raises(ValueError, match=r"no known format|is damaged"):
        read(path)
    path.write_text("not a recording\n" * 10)
    with pytest.raises(ValueError, match=r"has no column of a gyroscope|is damaged"):
        read(path)
    with pytest.raises(IsADirectoryError, match="expected a file, got a directory"):
        read(tmp_path)


@given(st.binary(max_size=300), st.sampled_from(["", "t,gx,gy,gz\n", "PK\x03\x04", "PAR1", "\x89HDF\r\n\x1a\n"]))
def test_arbitrary_bytes_are_a_recording_or_a_value_error(
    tmp_path_factory: pytest.TempPathFactory, content: bytes, start: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "bytes"
    path.write_bytes(start.encode("latin-1") + content)
    try:
        outcome = len(read(path)) > 0
    except ValueError as error:
        outcome = "\n" not in str(error)
    assert outcome


@pytest.mark.parametrize(
    ("package", "write"),
    [
        ("h5py", lambda path: write_broad(path, recording())),
        ("pyarrow", lambda path: write_text(path, "t,gx,gy,gz", np.zeros((5, 4)))),
    ],
)
def test_missing_package_is_told_with_the_way_to_install_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str, write: Callable[[Path], Path]
) -> None:
    path = write(tmp_path / "a")
    genuine = importlib.import_module

    def without(name: str, *rest: Any) -> Any:
        if name.partition(".")[0] == package:
            raise ModuleNotFoundError(f"No module named {package!r}", name=package)
        return genuine(name, *rest)

    monkeypatch.setattr(importlib, "import_module", without)
    with pytest.raises(ImportError, match=rf"needs {package}: pip install ahrs-rs\[io\]"):
        read(path)


def test_reading_numpy_files_imports_no_heavy_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    source = recording()
    genuine = builtins.__import__

    def watched(name: str, *rest: Any) -> Any:
        assert name.partition(".")[0] not in ("pandas", "pyarrow", "h5py", "scipy", "polars"), name
        return genuine(name, *rest)

    monkeypatch.setattr(builtins, "__import__", watched)
    source.save(tmp_path / "a.npz")
    read(tmp_path / "a.npz")
    write_estimate(tmp_path / "b.csv", source.t, source.ref)
