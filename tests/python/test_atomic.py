"""Files are there whole or as they were before."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pytest
from matplotlib.figure import Figure
from pyarrow import parquet

from ahrs_rs import _atomic

resource = pytest.importorskip("resource", reason="limits of the file size are POSIX")

OLD = "what was there\n"
#: More than LIMIT bytes that no compression makes small.
NOISE = np.random.default_rng(0).random(20_000)
LIMIT = 30_000


def _npz(path: Path) -> None:
    with _atomic.binary(path) as file:
        np.savez_compressed(file, x=NOISE)


def _csv(path: Path) -> None:
    with _atomic.text(path) as file:
        file.writelines(f"{x}\n" for x in NOISE)


def _parquet(path: Path) -> None:
    with _atomic.replacing(path) as beside:
        parquet.write_table(pa.table({"x": NOISE}), beside)


def _hdf5(path: Path) -> None:
    with _atomic.replacing(path) as beside, h5py.File(beside, "w") as file:
        file["x"] = NOISE


def _png(path: Path) -> None:
    figure = Figure()
    figure.figimage(np.random.default_rng(0).random((200, 200)))
    with _atomic.replacing(path) as beside:
        figure.savefig(beside)


WRITERS = {".npz": _npz, ".csv": _csv, ".parquet": _parquet, ".hdf5": _hdf5, ".png": _png}
EVERY_WRITER = pytest.mark.parametrize(("ending", "write"), WRITERS.items(), ids=WRITERS)


@contextmanager
def full_disk(limit: int = LIMIT) -> Iterator[None]:
    """No file of this process grows beyond the limit, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@EVERY_WRITER
def test_a_file_is_replaced_by_whole_contents(ending: str, write: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / f"out{ending}"
    path.write_text(OLD)
    write(path)
    assert path.stat().st_size > LIMIT
    assert names(tmp_path) == [path.name]


@EVERY_WRITER
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # closing what cannot be written
def test_a_full_disk_leaves_the_file_that_was_there_and_is_told_with_its_name(
    ending: str, write: Callable[[Path], None], tmp_path: Path
) -> None:
    path = tmp_path / f"out{ending}"
    path.write_text(OLD)
    with full_disk(), pytest.raises(OSError, match="File too large") as caught:
        write(path)
    assert path.name in str(caught.value)
    assert ".part" not in str(caught.value)
    assert path.read_text() == OLD
    assert names(tmp_path) == [path.name]


@pytest.mark.parametrize("error", [KeyboardInterrupt(), SystemExit(1), ValueError("x"), MemoryError()], ids=repr)
@pytest.mark.parametrize("there", [False, True])
def test_an_exception_leaves_what_was_there(error: BaseException, there: bool, tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    if there:
        path.write_text(OLD)

    def interrupted() -> None:
        with _atomic.text(path) as file:
            file.write("half")
            raise error

    with pytest.raises(type(error)):
        interrupted()
    assert names(tmp_path) == (["out.csv"] if there else [])
    assert not there or path.read_text() == OLD


def test_text_without_a_form_in_utf8_is_a_value_error_that_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text(OLD)
    with pytest.raises(ValueError, match=r"out\.csv: expected text that utf-8 has a form of, got '\\udcff'"):
        _atomic.write_text(path, "walk\udcff.csv")
    assert path.read_text() == OLD


def test_errors_about_other_files_keep_their_names(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, _atomic.text(tmp_path / "out.csv"):
        (tmp_path / "other.csv").read_text()
    assert str(caught.value.filename).endswith("other.csv")


def test_a_folder_that_is_not_there_is_told_with_the_name_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "nowhere" / "out.csv"
    with pytest.raises(FileNotFoundError) as caught:
        _atomic.write_text(path, "x")
    assert caught.value.filename == str(path)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666])
def test_the_mode_of_a_file_is_kept(mode: int, tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text(OLD)
    path.chmod(mode)
    _atomic.write_text(path, "new")
    assert path.stat().st_mode & 0o777 == mode
    assert path.read_text() == "new"


def test_a_new_file_has_the_mode_that_the_umask_leaves(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("x")
    _atomic.write_text(tmp_path / "ours", "x")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_write_protected_file_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "out.csv"
    path.write_text(OLD)
    path.chmod(0o444)
    with pytest.raises(PermissionError, match=r"out\.csv"):
        _atomic.write_text(path, "new")
    assert path.read_text() == OLD


def test_a_symbolic_link_stays_one(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    target, link = tmp_path / "disk" / "real.csv", tmp_path / "link.csv"
    target.write_text(OLD)
    link.symlink_to(target)
    _atomic.write_text(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert names(tmp_path / "disk") == ["real.csv"]


@pytest.mark.parametrize("length", [200, 251])
def test_long_names_are_written(length: int, tmp_path: Path) -> None:
    for letter in "xµ":
        path = tmp_path / (letter * (length // len(letter.encode())) + ".csv")
        _atomic.write_text(path, "new")
        assert path.read_text() == "new"


@pytest.mark.parametrize("write", [_npz, _csv, _parquet], ids=["npz", "csv", "parquet"])
def test_a_pipe_gets_the_contents(write: Callable[[Path], None], tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    write(pipe)
    reader.join()
    write(tmp_path / "file")
    expected = (tmp_path / "file").read_bytes()
    assert len(read[0]) == len(expected)
    assert names(tmp_path) == ["file", "pipe"]


def test_the_standard_output_gets_the_contents() -> None:
    program = "from ahrs_rs import _atomic; _atomic.write_text('/dev/stdout', 'text')"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "text"


def test_files_of_one_command_are_put_in_place_when_all_are_written(tmp_path: Path) -> None:
    first, second = tmp_path / "a.csv", tmp_path / "b.csv"
    first.write_text(OLD)
    with _atomic.Together() as files:
        files.write_text(first, "new")
        assert first.read_text() == OLD
        files.write_text(second, "new")
        assert not second.exists()
    assert first.read_text() == second.read_text() == "new"


def test_where_one_file_of_a_command_fails_none_is_changed(tmp_path: Path) -> None:
    first, second = tmp_path / "a.csv", tmp_path / "folder" / "deep" / "b.npz"
    first.write_text(OLD)

    def both() -> None:
        with _atomic.Together() as files:
            files.write_text(first, "new")
            files.folder(second.parent)
            with files.binary(second) as file:
                np.savez(file, x=NOISE)

    with full_disk(), pytest.raises(OSError, match=r"b\.npz"):
        both()
    assert first.read_text() == OLD
    assert names(tmp_path) == ["a.csv"]
    both()
    assert names(tmp_path) == ["a.csv", "folder"]
    assert names(second.parent) == ["b.npz"]


@pytest.mark.parametrize("other", ["a.csv", "./a.csv", "link.csv"])
def test_two_files_in_one_place_are_refused(other: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.csv").write_text(OLD)
    Path("link.csv").symlink_to("a.csv")

    def both() -> None:
        with _atomic.Together() as files:
            files.write_text("a.csv", "new")
            files.write_text(other, "newer")

    with pytest.raises(ValueError, match="expected two files, got"):
        both()
    assert Path("a.csv").read_text() == OLD


@pytest.mark.parametrize("kind", ["text", "binary", "replacing"])
def test_a_folder_in_the_place_of_the_file_is_an_error(kind: str, tmp_path: Path) -> None:
    (tmp_path / "out.csv").mkdir()
    opened: Callable[[Path], AbstractContextManager[Any]] = getattr(_atomic, kind)
    with pytest.raises(IsADirectoryError, match=r"out\.csv"), opened(tmp_path / "out.csv"):
        pass


#: Writes many different contents of one length in turn, until it is killed.
FOREVER = """
import itertools, sys
from ahrs_rs import _atomic
print(flush=True)
for k in itertools.count():
    _atomic.write_text(sys.argv[1], chr(ord("a") + k % 26) * 100_000)
"""


def test_a_kill_at_any_moment_leaves_one_of_the_contents(tmp_path: Path) -> None:
    path = tmp_path / "out.txt"
    path.write_text("z" * 100_000)
    for delay in np.linspace(0.0, 0.02, 12):
        process = subprocess.Popen([sys.executable, "-c", FOREVER, str(path)], stdout=subprocess.PIPE)
        assert process.stdout is not None
        process.stdout.readline()
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(float(delay))
        process.kill()
        process.wait()
        process.stdout.close()
        text = path.read_text()
        assert len(text) == 100_000
        assert len(set(text)) == 1


#: Begins to write a file, says so, and waits to be killed.
BEGIN = """
import sys, time
from ahrs_rs import _atomic
with _atomic.text(sys.argv[1]) as file:
    file.write("half")
    file.flush()
    print(flush=True)
    time.sleep(60)
"""


def test_what_a_killed_process_left_is_removed_by_the_next_writing_and_what_is_being_written_is_not(
    tmp_path: Path,
) -> None:
    path = tmp_path / "a[1]*.csv"
    others = [
        tmp_path / name
        for name in (".a[1]*.abcdefabcdefabcdefabcd.part.txt", ".b.abcdefabcdefabcdefabcd.part.csv", "a1.csv")
    ]
    for other in others:
        other.write_text("not ours")
    processes = [subprocess.Popen([sys.executable, "-c", BEGIN, str(path)], stdout=subprocess.PIPE) for _ in range(2)]
    for process in processes:
        assert process.stdout is not None
        process.stdout.readline()
    before = [name for name in names(tmp_path) if name.endswith(".part.csv") and name.startswith(".a")]
    assert len(before) == 2
    processes[0].kill()
    processes[0].wait()
    _atomic.write_text(path, "new")
    left = [name for name in names(tmp_path) if name in before]
    processes[1].kill()
    for process in processes:
        process.wait()
        assert process.stdout is not None
        process.stdout.close()
    assert len(left) == 1
    _atomic.write_text(path, "newer")
    assert names(tmp_path) == sorted(["a[1]*.csv", *(other.name for other in others)])


def test_many_threads_that_write_one_file_leave_one_of_the_contents(tmp_path: Path) -> None:
    path = tmp_path / "out.txt"

    def write(letter: str) -> None:
        for _ in range(20):
            _atomic.write_text(path, letter * 10_000, durable=False)

    threads = [threading.Thread(target=write, args=(letter,)) for letter in "abcd"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(path.read_text())) == 1
    assert names(tmp_path) == ["out.txt"]
