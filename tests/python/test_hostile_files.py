"""Binary files that somebody else wrote: whatever they hold, a `ValueError` of one line or a recording, and soon."""

from __future__ import annotations

import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import ahrs_rs as ar
from commands import Capture, error_of

N = 200
RNG = np.random.default_rng(0)
ARRAYS: dict[str, Any] = {
    "t": np.arange(N) / 100.0,
    "gyr": RNG.normal(0.0, 0.1, (N, 3)),
    "acc": np.array([0.0, 0.0, 9.81]) + RNG.normal(0.0, 0.02, (N, 3)),
}
NS = np.datetime64("2026-01-01", "ns") + (np.arange(N) * 10_000_000).astype("m8[ns]")

pytestmark = pytest.mark.filterwarnings("ignore::ahrs_rs.DataWarning")


def message(path: Path) -> str:
    """What reading the file is refused with."""
    with pytest.raises(ValueError, match=rf"{path.name}: [^\n]+$") as caught:
        ar.read(path)
    assert len(str(caught.value)) < 600
    return str(caught.value).partition(f"{path.name}: ")[2]


# npz: arrays that are none.


def npz(folder: Path, **changes: Any) -> Path:
    path = folder / "a.npz"
    np.savez(path, **{name: value for name, value in (ARRAYS | changes).items() if value is not None})
    return path


@pytest.mark.parametrize("t", [NS, NS.astype("M8[us]"), NS - NS[0], (np.arange(N) * 10).astype("m8[ms]")], ids=str)
def test_dates_and_durations_in_an_npz_are_times(t: np.ndarray, tmp_path: Path) -> None:
    recording = ar.read(npz(tmp_path, t=t))
    assert np.abs(recording.t - ARRAYS["t"]).max() < 1e-12
    assert recording.meta.get("start") == ("2026-01-01T00:00:00.000000+00:00" if t.dtype.kind == "M" else None)


def test_a_date_that_is_none_is_a_missing_stamp(tmp_path: Path) -> None:
    t = NS.copy()
    t[3] = np.datetime64("NaT")
    recording = ar.read(npz(tmp_path, t=t))
    assert recording.meta["repairs"] == ["t: 1 missing stamps interpolated"]
    assert np.abs(recording.t - ARRAYS["t"]).max() < 1e-12


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"t": np.zeros((N, 2))}, "t: expected shape (T,), got (200, 2)"),
        ({"t": np.full(N, "a")}, "t: expected times, got dtype <U1"),
        ({"t": 3.0}, "t: expected shape (T,), got ()"),
        ({"t": np.tile(NS[:, None], 2)}, "t: expected shape (T,), got (200, 2)"),
        ({"t": np.arange(N) * 1j}, "t: expected times, got dtype complex128"),
        ({"t": np.arange(3.0)}, "expected shape"),
        ({"gyr": 1.0}, "gyr: expected a value a sample"),
        ({"gyr": np.zeros(N)}, "gyr: expected shape"),
        ({"gyr": np.zeros((N, 3, 1, 1))}, "gyr: expected"),
        ({"gyr": np.zeros((N, 3), complex)}, "gyr: expected real numbers"),
        ({"gyr": np.zeros(N, dtype=[("x", "f8")])}, "gyr: expected real numbers"),
        ({"gyr": np.full((N, 3), "1")}, "gyr: expected real numbers"),
        ({"gyr": np.tile(NS[:, None], (1, 3))}, "gyr: expected real numbers"),
        ({"mask": True}, "mask: expected a value a sample"),
        ({"mask": np.full(N, 2)}, "mask: expected an array of bool"),
        ({"temperature": 20.0}, "temperature: expected a value a sample"),
        ({"ref": np.zeros((N, 3))}, "ref: expected shape"),
        ({"rate": np.nan, "t": None}, "rate: expected one positive number"),
        ({"rate": np.inf, "t": None}, "rate: expected a positive number"),
        ({"rate": [1.0, 2.0], "t": None}, "rate: expected one positive number"),
        ({"rate": 1j, "t": None}, "rate: expected one positive number"),
        ({"meta": "["}, "meta: expected a JSON object as text"),
        ({"meta": "[" * 100_000}, "meta: expected a JSON object as text"),
        ({"meta": '{"a": ' + "9" * 10_000 + "}"}, "meta: expected a JSON object as text"),
        ({"meta": ["{}", "{}"]}, "meta: expected a JSON object as text"),
        ({"meta": '{"repairs": 3}'}, "meta: repairs: expected a list of texts, got 3"),
        ({"meta": '{"lost": [1]}'}, "meta: lost: expected a list of texts, got [1]"),
        ({"meta": '{"units": 3}'}, "meta: units: expected an object of texts, got 3"),
        ({"meta": '{"assumed_units": {"t": 3}}'}, "meta: assumed_units: expected an object of texts"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_arrays_that_are_none_are_refused_by_their_name(changes: dict[str, Any], expected: str, tmp_path: Path) -> None:
    assert expected in message(npz(tmp_path, **changes))


# npz: headers that lie.


def npy(header: str, version: tuple[int, int] = (1, 0), data: bytes = b"") -> bytes:
    text = header.encode("latin-1")
    text += b" " * (63 - (10 + len(text)) % 64) + b"\n"
    size = struct.pack("<H" if version == (1, 0) else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + size + text + data


def described(shape: str, descr: str = "'<f8'") -> str:
    return f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"


HEADERS = {
    "absurd": npy(described("(1000000000000, 3)")),
    "large": npy(described("(1000000000, 3)")),
    "beyond 64 bits": npy(described("(4611686018427387904, 4)")),
    "negative": npy(described("(-1, 3)")),
    "negative alone": npy(described("(-5,)")),
    "a hundred axes": npy(described(f"({'1,' * 100})"), data=bytes(8)),
    "parentheses": npy(described("(" * 4000 + ")" * 4000)),
    "open parentheses": npy("(" * 9000),
    "minus": npy("-" * 9000 + "1"),
    "brackets": npy(described("(1,)", "[" * 3000 + "]" * 3000)),
    "two of one name": npy(described("(1,)", "[('a', '<f8'), ('a', '<f8')]")),
    "a terabyte a value": npy(described("(1,)", "'V1000000000000'")),
    "values of no size": npy(described("(100000000000,)", "'U0'")),
    "subarrays": npy(described("(1,)", "('<f8', (1000000, 1000000))")),
    "no dtype": npy(described("(1,)", "3")),
    "objects": npy(described("(1,)", "'|O'"), data=b"cos\nsystem\n(S'true'\ntR."),
    "long": npy(f"{{'x': '{'a' * 60_000}'}}"),
    "version 3": npy("{}", (3, 0)),
    "version 9": npy("{}", (9, 0)),
    "empty": b"",
    "garbage": b"garbage" * 100,
    "pickle": b"\x80\x04.",
}


@pytest.mark.parametrize("content", HEADERS.values(), ids=HEADERS)
def test_headers_that_lie_are_refused_before_there_is_room_for_what_they_say(content: bytes, tmp_path: Path) -> None:
    path = npz(tmp_path)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("mag.npy", content)
    assert message(path)


def test_an_array_that_is_packed_as_no_readings_can_be_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    samples = 20_000_000
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("gyr.npy", "w") as file:
        file.write(npy(described(f"({samples}, 3)")))
        for _ in range(samples * 24 // 1_000_000):
            file.write(bytes(1_000_000))
    assert "480,000,000 bytes are packed into" in message(path)


# HDF5.


def broad(path: Path, acc: Callable[[h5py.File], object] | None, **attributes: Any) -> Path:
    """A trial of BROAD whose accelerometer is made by the function."""
    with h5py.File(path, "w") as file:
        file.attrs["sampling_rate"] = 100.0
        file.attrs.update(attributes)
        file["imu_gyr"] = ARRAYS["gyr"]
        if acc is None:
            file["imu_acc"] = ARRAYS["acc"]
        else:
            acc(file)
    return path


def external_link(file: h5py.File) -> None:
    file["imu_acc"] = h5py.ExternalLink("other.hdf5", "/imu_acc")


def link_to_a_link(file: h5py.File) -> None:
    file.create_group("g")["x"] = h5py.ExternalLink("other.hdf5", "/imu_acc")
    file["imu_acc"] = h5py.SoftLink("/g/x")


def link_to_a_pipe(file: h5py.File) -> None:
    file["imu_acc"] = h5py.ExternalLink("pipe", "/imu_acc")


def external_storage(file: h5py.File) -> None:
    file.create_dataset("imu_acc", (N, 3), "f8", external=[("raw.bin", 0, N * 24)])


def virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((N, 3), "f8")
    layout[...] = h5py.VirtualSource("other.hdf5", "imu_acc", (N, 3))
    file.create_virtual_dataset("imu_acc", layout)


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (external_link, "has a link to another file, 'imu_acc', which is not followed"),
        (link_to_a_link, "has a link to another file, 'g/x', which is not followed"),
        (link_to_a_pipe, "has a link to another file, 'imu_acc', which is not followed"),
        (external_storage, "/imu_acc: its values lie in another file, which is not opened"),
        (virtual, "/imu_acc: its values lie in another file, which is not opened"),
    ],
)
@pytest.mark.skipif(os.name != "posix", reason="needs named pipes")
def test_nothing_outside_of_an_hdf5_file_is_opened(
    make: Callable[[h5py.File], object], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    broad(tmp_path / "other.hdf5", None)
    ARRAYS["acc"].tofile(tmp_path / "raw.bin")
    os.mkfifo(tmp_path / "pipe")  # whoever opens it waits for ever
    path = broad(tmp_path / "a.hdf5", make)
    assert message(path) == expected
    assert expected in error_of(capsys, "run", path, "--filter", "tilt")


def test_links_within_an_hdf5_file_are_followed(tmp_path: Path) -> None:
    def soft(file: h5py.File) -> None:
        file.create_group("g")["x"] = ARRAYS["acc"]
        file["imu_acc"] = h5py.SoftLink("/g/x")

    acc = ar.read(broad(tmp_path / "a.hdf5", soft)).acc
    assert acc is not None
    assert np.array_equal(acc, ARRAYS["acc"])


def test_what_is_packed_well_is_read(tmp_path: Path) -> None:
    still = np.tile([0.0, 0.0, 9.81], (100_000, 1))

    def packed(file: h5py.File) -> None:
        del file["imu_gyr"]
        file["imu_gyr"] = np.zeros((100_000, 3))
        file.create_dataset("imu_acc", data=still, compression="gzip", compression_opts=9, chunks=(100_000, 3))

    acc = ar.read(broad(tmp_path / "a.hdf5", packed)).acc
    assert acc is not None
    assert np.array_equal(acc, still)


@pytest.mark.parametrize("samples", [10**9, 10**12])
def test_a_shape_of_which_nothing_is_stored_is_refused(samples: int, tmp_path: Path) -> None:
    path = broad(tmp_path / "a.hdf5", lambda file: file.create_dataset("imu_acc", (samples, 3), "f8", chunks=(1000, 3)))
    assert "of which next to nothing is stored" in message(path)


THINGS: dict[str, Callable[[h5py.File], object]] = {
    "group": lambda file: file.create_group("imu_acc"),
    "type": lambda file: file.__setitem__("imu_acc", np.dtype("f8")),
    "dangling link": lambda file: file.__setitem__("imu_acc", h5py.SoftLink("/nothing")),
    "link to itself": lambda file: file.__setitem__("imu_acc", h5py.SoftLink("/imu_acc")),
    "rows of any length": lambda file: file.create_dataset("imu_acc", (N,), h5py.vlen_dtype(np.float64)),
    "text": lambda file: file.create_dataset("imu_acc", data=np.full(N, b"a")),
    "compound": lambda file: file.create_dataset("imu_acc", data=np.zeros(N, dtype=[("x", "f8"), ("y", "f8")])),
    "one number": lambda file: file.create_dataset("imu_acc", data=3.0),
    "nothing": lambda file: file.create_dataset("imu_acc", data=h5py.Empty("f8")),
    "complex": lambda file: file.create_dataset("imu_acc", data=np.zeros((N, 3), complex)),
    "four axes": lambda file: file.create_dataset("imu_acc", data=np.zeros((N, 3, 1, 1))),
    "references": lambda file: file.create_dataset("imu_acc", data=np.full(N, file["imu_gyr"].ref, h5py.ref_dtype)),
}


@pytest.mark.parametrize("make", THINGS.values(), ids=THINGS)
def test_what_is_no_array_of_readings_is_refused(make: Callable[[h5py.File], object], tmp_path: Path) -> None:
    assert message(broad(tmp_path / "a.hdf5", make))


@pytest.mark.parametrize("rate", ["x", np.nan, -1.0, 0, [1, 2], np.inf, h5py.Empty("f8")], ids=str)
def test_a_rate_that_is_none_is_refused(rate: Any, tmp_path: Path) -> None:
    assert message(broad(tmp_path / "a.hdf5", None, sampling_rate=rate))
