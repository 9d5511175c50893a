"""Files that are there whole or as they were before: written beside, and put in place when nothing can fail any more.

Every writer of the package goes through here. One file, by what writes it::

    with atomic.text(path) as file: ...      # a text file, UTF-8, line ends as they are written
    with atomic.binary(path) as file: ...    # a binary file
    with atomic.replacing(path) as beside: ...   # a path, for what opens its files by itself: pyarrow, h5py, matplotlib
    atomic.write_text(path, text)

Several files of one command: all of them are written before the first is put in place::

    with atomic.Together() as files:
        files.folder(directory)
        with files.text(table) as file: ...
        with files.replacing(plot) as beside: ...

- After an error, a signal that is an exception, or a kill the file is as it was before, or it is not there. A process
  that is killed leaves a hidden file ``.NAME.….part.ENDING`` beside at most, which the next writing of the same file
  removes.
- The contents are on the disk (fsync) before they take the name, unless ``durable=False``.
- Mode and owner of a file that was there are kept, and a symbolic link to it stays one. A write-protected file is a
  ``PermissionError``, also where its folder would allow to replace it.
- What cannot be replaced (a pipe, a device, a process substitution) gets the contents once they are complete.
- An ``OSError`` in the block that names no other file names the one that was to be written, and text that UTF-8 has no
  form of is a ``ValueError`` that does.
"""

from __future__ import annotations

import errno
import glob
import os
import platform
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import IO, Self, TypeAlias

AnyPath: TypeAlias = str | os.PathLike[str]

#: What of a name goes into the name of the file beside: names have 255 bytes at most.
STEM_BYTES, SUFFIX_LENGTH = 100, 32
#: Hexadecimal digits of a process's number in it.
PID_DIGITS = 8

#: Files that are written now, by whatever thread.
_unfinished: set[Path] = set()

#: A file system that knows no fsync says so by one of these.
NO_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)


@dataclass(frozen=True, slots=True)
class _File:
    """A file on its way."""

    given: Path
    """As it was named."""
    target: Path
    """Where it goes: the same with links resolved."""
    beside: Path
    """Where it is written."""
    special: bool
    """Whether it is copied into the target, which is no regular file."""


class Together:
    """Files that take their places together, when the block ends without an exception.

    Two of them in one place are a ``ValueError``.

    Parameters
    ----------
    durable : whether they are on the disk before they take their names
    """

    def __init__(self, *, durable: bool = True) -> None:
        self.durable = durable
        self._files: list[_File] = []
        self._folders: list[Path] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self._put_in_place()
                self._folders.clear()
        finally:
            self._clean()

    @contextmanager
    def replacing(self, path: AnyPath) -> Iterator[Path]:
        """The path of an empty file that is to be written in place of `path`, with the same ending."""
        file = self._new(Path(path))
        with _naming(file):
            if not file.special:
                _remove_leftovers(file)
            _create(file.beside)
            yield file.beside
            if self.durable and not file.special:
                _sync(file.beside)

    @contextmanager
    def binary(self, path: AnyPath) -> Iterator[IO[bytes]]:
        """A binary file to be written in place of `path`."""
        with self.replacing(path) as beside, beside.open("wb") as file:
            yield file

    @contextmanager
    def text(self, path: AnyPath) -> Iterator[IO[str]]:
        """A text file to be written in place of `path`, in UTF-8, with line ends as they are written."""
        with self.replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
            yield file

    def write_text(self, path: AnyPath, text: str) -> None:
        """A file of this text."""
        with self.text(path) as file:
            file.write(text)

    def folder(self, path: AnyPath) -> Path:
        """A folder for them, made with its parents where it is not there; after an exception it is not there again."""
        path = Path(path)
        missing = [one for one in (path, *path.parents) if not one.exists()]
        for one in reversed(missing):
            self._folders.append(one)
            one.mkdir(exist_ok=True)
        return path

    def _new(self, given: Path) -> _File:
        special = _is_special(given)
        target = given if special else Path(os.path.realpath(given))
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(given))
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(given))
        for other in self._files:
            if other.target == target and not special:
                raise ValueError(f"expected two files, got {given} twice")
        folder = target.parent
        if special:
            import tempfile  # here: where a folder is not to be written to

            folder = Path(tempfile.mkdtemp())
            self._folders.append(folder)
        file = _File(
            given,
            target,
            folder / _name_beside(target, _place() + f"{os.getpid():0{PID_DIGITS}x}" + os.urandom(3).hex()),
            special,
        )
        self._files.append(file)  # before it is made: a signal may come in between
        _unfinished.add(file.beside)
        return file

    def _put_in_place(self) -> None:
        for file in self._files:
            with _naming(file):
                _keep_mode(file)
        for file in self._files:
            with _naming(file):
                if file.special:
                    with file.beside.open("rb") as source, file.target.open("wb") as sink:
                        shutil.copyfileobj(source, sink)
                else:
                    file.beside.replace(file.target)
        if self.durable:
            for folder in {file.target.parent for file in self._files if not file.special}:
                _sync_folder(folder)

    def _clean(self) -> None:
        for file in self._files:
            with suppress(OSError):
                file.beside.unlink(missing_ok=True)
            _unfinished.discard(file.beside)
        for folder in reversed(self._folders):
            with suppress(OSError):  # something is in it that is not ours
                folder.rmdir()
        self._files.clear()
        self._folders.clear()


@contextmanager
def replacing(path: AnyPath, *, durable: bool = True) -> Iterator[Path]:
    """The path of an empty file that takes the place of `path` at the end of the block; see `Together.replacing`."""
    with Together(durable=durable) as files, files.replacing(path) as beside:
        yield beside


@contextmanager
def binary(path: AnyPath, *, durable: bool = True) -> Iterator[IO[bytes]]:
    """A binary file that takes the place of `path` at the end of the block."""
    with Together(durable=durable) as files, files.binary(path) as file:
        yield file


@contextmanager
def text(path: AnyPath, *, durable: bool = True) -> Iterator[IO[str]]:
    """A text file in UTF-8 that takes the place of `path` at the end of the block."""
    with Together(durable=durable) as files, files.text(path) as file:
        yield file


def write_text(path: AnyPath, content: str, *, durable: bool = True) -> None:
    """A file of this text in place of `path`."""
    with text(path, durable=durable) as file:
        file.write(content)


def remove_unfinished() -> None:
    """Remove what is being written, before the process is ended in the middle of it."""
    for path in list(_unfinished):
        with suppress(OSError):
            path.unlink(missing_ok=True)


def append(path: AnyPath, content: str) -> None:
    """Text at the end of a file, on the disk when this returns: for journals, whose last line may be torn."""
    with Path(path).open("ab") as file:
        try:
            file.write(content.encode())
            file.flush()
            _sync_descriptor(file.fileno())
        except OSError as error:
            raise _named(error, path) from error


def _is_special(path: Path) -> bool:
    """Whether it is there and neither a file nor a folder, or a name of what the process has open."""
    if path.absolute().parts[:2] in (("/", "dev"), ("/", "proc")):
        return True
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _name_beside(target: Path, unique: str) -> str:
    stem = target.stem.lstrip(".").encode(errors="surrogateescape")[:STEM_BYTES].decode(errors="ignore")
    return f".{stem}.{unique}.part{target.suffix[:SUFFIX_LENGTH]}"


def _create(path: Path) -> None:
    os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))


@lru_cache(maxsize=1)
def _place() -> str:
    """What tells the processes of this machine, since it was started and in this container, from those of others."""
    parts = [platform.node()]
    with suppress(OSError):
        parts.append(Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii"))
        parts.append(str(Path("/proc/self/ns/pid").readlink()))
    import hashlib  # here: the package is imported without it

    return hashlib.sha256("\0".join(parts).encode(errors="replace")).hexdigest()[:8]


def _remove_leftovers(file: _File) -> None:
    """Remove what processes of this machine have left of earlier writings of the file when they were killed."""
    if sys.platform == "win32":
        return
    place = _place()
    pattern = _name_beside(Path(glob.escape(str(file.target))), f"{place}{'?' * PID_DIGITS}{'?' * 6}")
    for left in file.target.parent.glob(pattern):
        _, _, numbers = (
            left.name.removesuffix(file.target.suffix[:SUFFIX_LENGTH]).removesuffix(".part").rpartition(place)
        )
        with suppress(OSError, ValueError, OverflowError):
            if not _is_running(int(numbers[:PID_DIGITS], 16)):
                left.unlink()


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:  # of another user
        return True
    return True


def _keep_mode(file: _File) -> None:
    """Gives the file beside the owner, if that is allowed, and the mode of the one that it replaces."""
    if file.special or not file.target.exists():
        return
    before = file.target.stat()
    if sys.platform != "win32":
        with suppress(OSError):
            os.chown(file.beside, before.st_uid, before.st_gid)
    file.beside.chmod(stat.S_IMODE(before.st_mode))


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        _sync_descriptor(descriptor)
    finally:
        os.close(descriptor)


def _sync_descriptor(descriptor: int) -> None:
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in NO_SYNC:
            raise


def _sync_folder(path: Path) -> None:
    """The names themselves; where that is not possible (Windows, some network file systems) they come later."""
    with suppress(OSError):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


@contextmanager
def _naming(file: _File) -> Iterator[None]:
    """Errors of the file beside become those of the file that it is for."""
    try:
        yield
    except UnicodeEncodeError as error:
        part = error.object[error.start : error.end]
        raise ValueError(f"{file.given}: expected text that {error.encoding} has a form of, got {part!r}") from error
    except OSError as error:
        about = (error.filename, error.filename2)
        if about == (None, None) or any(one is not None and os.fsdecode(one) == str(file.beside) for one in about):
            raise _named(error, file.given) from error
        raise


def _named(error: OSError, path: AnyPath) -> OSError:
    """The same error with the name of the file."""
    if error.errno is None:
        return type(error)(f"{os.fspath(path)}: {error}")
    return OSError(error.errno, os.strerror(error.errno), os.fspath(path))
