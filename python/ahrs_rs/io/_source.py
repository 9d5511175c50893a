"""Where a recording comes from: a file, a folder, a zip archive, something compressed by gzip, a stream."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import zipfile
import zlib
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import IO, Any

from ahrs_rs.io._contents import one_line

#: How many first bytes tell the format.
SNIFF_BYTES = 4096
ZIP, GZIP = (b"PK\x03\x04", b"PK\x05\x06"), b"\x1f\x8b"
#: What archives and file managers add of their own.
_CLUTTER = ("__MACOSX/", ".DS_Store", "Thumbs.db")
_DAMAGED = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError)


class Source:
    """What is read, wherever it lies. A folder and a zip archive look the same to a reader.

    Attributes
    ----------
    path : str, as messages and `Recording.meta` name it
    name : str, the file's name, without .gz; the folder's or archive's name
    head : bytes, the first ones, decompressed; empty of a folder
    names : tuple of str, relative names of the files in a folder or zip archive (forward slashes; a single folder at
        the top is left out); empty of a file
    """

    def __init__(self, path: str, *, disk: Path | None = None, content: bytes | None = None, inside: str = "") -> None:
        self.path = path
        self._disk = disk  # what lies on the disk: the file, folder or archive itself
        self._content = content  # decompressed, or from a stream or an archive
        self._inside = inside  # a folder within the folder
        self.name = PurePosixPath(path.replace(os.sep, "/")).name
        if self.name.lower().endswith(".gz"):
            self.name = self.name[:-3]

    @classmethod
    def of(cls, given: Any) -> Source:
        """The source that a path, "-" (standard input) or a binary file object stands for.

        Raises
        ------
        FileNotFoundError
        ValueError
            Text in place of bytes, or damaged gzip.
        """
        if given == "-":
            return cls._unpacked("-", sys.stdin.buffer.read())
        if hasattr(given, "read"):
            content = given.read()
            if not isinstance(content, bytes):
                raise ValueError(
                    f"path: expected a file opened in binary mode, got one that gives {type(content).__name__}"
                )
            name = getattr(given, "name", None)
            return cls._unpacked(name if isinstance(name, str) else "<stream>", content)
        if not isinstance(given, (str, os.PathLike)):
            raise TypeError(f"path: expected a path or a binary file object, got {type(given).__name__}")
        path = Path(os.fsdecode(given))
        if not path.exists():
            raise FileNotFoundError(f"{path}: no such file")
        if path.is_dir():
            return cls(str(path), disk=path)
        if not path.is_file():  # a pipe, of which every byte comes once
            return cls._unpacked(str(path), path.read_bytes())
        with path.open("rb") as file:
            packed = file.read(2) == GZIP
        return cls._unpacked(str(path), path.read_bytes()) if packed else cls(str(path), disk=path)

    @classmethod
    def _unpacked(cls, path: str, content: bytes) -> Source:
        if content.startswith(GZIP):
            import gzip  # here, as tempfile and shutil below: the package is imported without them

            try:
                content = gzip.decompress(content)
            except (*_DAMAGED, ValueError) as error:
                raise ValueError(f"{path}: is damaged: {one_line(error)}") from error
        return cls(path, content=content)

    # -- what it is ----------------------------------------------------------------------------------------------------

    @cached_property
    def is_folder(self) -> bool:
        """Whether it is a folder on the disk."""
        return self._disk is not None and self._disk.is_dir()

    @cached_property
    def head(self) -> bytes:
        """The first bytes, empty of a folder."""
        return b"" if self.is_folder else self.read(size=SNIFF_BYTES)

    @property
    def on_disk(self) -> Path | None:
        """The file on the disk that it is, unless it is packed, a folder, or comes from elsewhere."""
        return None if self.is_folder else self._disk

    @property
    def is_zip(self) -> bool:
        """Whether it is a zip archive (as is a file of numpy arrays)."""
        return self.head.startswith(ZIP)

    @cached_property
    def _members(self) -> dict[str, str]:
        """Relative name -> name in the folder or archive."""
        if self.is_folder:
            root = self._disk
            assert root is not None
            found = sorted(one.relative_to(root).as_posix() for one in root.rglob("*") if one.is_file())
        elif self.is_zip:
            with self._archive() as archive:
                found = sorted(one.filename for one in archive.infolist() if not one.is_dir())
        else:
            return {}
        kept = [name for name in found if not name.startswith(_CLUTTER[0]) and not name.endswith(_CLUTTER[1:])]
        tops = {name.partition("/")[0] for name in kept if "/" in name} | {"" for name in kept if "/" not in name}
        cut = len(tops.pop()) + 1 if len(tops) == 1 and "" not in tops else 0
        return {name[cut:]: name for name in kept}

    @property
    def names(self) -> tuple[str, ...]:
        """Relative names of the files in a folder or archive."""
        return tuple(self._members)

    # -- what is in it -------------------------------------------------------------------------------------------------

    def read(self, name: str | None = None, size: int = -1) -> bytes:
        """The content, or that of one file of a folder or archive; the first `size` bytes of it.

        Raises
        ------
        ValueError
            A damaged archive.
        KeyError
            No such file in the folder or archive.
        """
        if name is not None:
            member = self._members[name]
            if self.is_folder:
                assert self._disk is not None
                with (self._disk / member).open("rb") as file:
                    return file.read(size)
            try:
                with self._archive() as archive, archive.open(member) as packed:
                    return packed.read(size)
            except _DAMAGED as error:
                raise ValueError(f"{name} is damaged: {one_line(error)}") from error
        if self._content is not None:
            return self._content if size < 0 else self._content[:size]
        assert self._disk is not None
        with self._disk.open("rb") as file:
            return file.read(size)

    def open(self) -> IO[bytes]:
        """The content as a binary file that can seek."""
        if self._content is not None:
            return io.BytesIO(self._content)
        assert self._disk is not None
        return self._disk.open("rb")

    def child(self, name: str) -> Source:
        """One file of a folder or archive as a source of its own."""
        path = f"{self.path}/{name}"
        if self.is_folder:
            assert self._disk is not None
            disk = self._disk / self._members[name]
            with disk.open("rb") as file:
                if file.read(2) != GZIP:
                    return Source(path, disk=disk)
        return self._unpacked(path, self.read(name))

    @contextlib.contextmanager
    def file(self, name: str | None = None) -> Iterator[Path]:
        """A file on the disk with the content (of one file of a folder or archive), for libraries that open files."""
        if name is None and self._content is None:
            assert self._disk is not None
            yield self._disk
        elif name is not None and self.is_folder:
            assert self._disk is not None
            yield self._disk / self._members[name]
        else:
            import tempfile

            with tempfile.TemporaryDirectory(prefix="ahrs_rs_") as folder:
                path = Path(folder) / PurePosixPath(name or self.name).name.replace("<", "").replace(">", "")
                path.write_bytes(self.read(name))
                yield path

    @contextlib.contextmanager
    def folder(self) -> Iterator[Path]:
        """A folder on the disk with the files of a folder or archive, under their relative names."""
        if self.is_folder:
            assert self._disk is not None
            some = next(iter(self._members.items()), ("", ""))
            yield self._disk / some[1][: len(some[1]) - len(some[0])]
            return
        import shutil
        import tempfile

        with tempfile.TemporaryDirectory(prefix="ahrs_rs_") as folder, self._archive() as archive:
            for name, member in self._members.items():
                path = Path(folder) / name
                if not path.resolve().is_relative_to(Path(folder).resolve()):
                    raise ValueError(f"is damaged: it holds a file outside of itself, {name!r}")
                path.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(member) as packed, path.open("wb") as out:
                    shutil.copyfileobj(packed, out)
            yield Path(folder)

    @contextlib.contextmanager
    def _archive(self) -> Iterator[zipfile.ZipFile]:
        with self.open() as stream:
            try:
                archive = zipfile.ZipFile(stream)
            except _DAMAGED as error:
                raise ValueError(f"is not a readable zip archive: {one_line(error)}") from error
            with archive:
                yield archive
