"""HDF5 files that anybody may have written: nothing outside of the file is opened, and no size is believed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs.io._contents import one_line, require
from ahrs_rs.io._source import Source

#: A data set may be so many times as large as what is stored of it: deflate packs no better than 1032 to 1.
MOST_PACKED = 1100
#: and so many bytes beyond that: what nobody has written is the fill value, and takes no room.
UNWRITTEN = 2**20


@contextmanager
def opened(source: Source) -> Iterator[Any]:
    """The file, for reading.

    Raises
    ------
    ValueError
        It is damaged, or has a link to another file, which is not followed; also for the library's errors in the block.
    """
    h5py = require("h5py")
    try:
        with source.file() as path, h5py.File(path, "r") as file:
            _check_links(file)
            yield file
    except (OSError, RuntimeError, TypeError, KeyError, AttributeError, MemoryError) as error:
        raise ValueError(f"is not a readable HDF5 file: {one_line(error)}") from error


def array(dataset: Any) -> NDArray[Any]:
    """The whole data set.

    Raises
    ------
    ValueError
        It is none, its values lie in another file, or it is far larger than what is stored of it.
    """
    h5py = require("h5py")
    if not isinstance(dataset, h5py.Dataset):
        raise ValueError(f"expected a data set, got {type(dataset).__name__.lower()} {dataset.name!r}")
    layout = dataset.id.get_create_plist()
    if layout.get_layout() == h5py.h5d.VIRTUAL or layout.get_external_count():
        raise ValueError(f"{dataset.name}: its values lie in another file, which is not opened")
    if dataset.nbytes > MOST_PACKED * dataset.id.get_storage_size() + UNWRITTEN:
        raise ValueError(f"{dataset.name}: has shape {dataset.shape}, of which next to nothing is stored")
    return np.asarray(dataset[()])


def _check_links(file: Any) -> None:
    h5py = require("h5py")
    found: list[bytes] = []

    def visit(name: bytes, info: Any) -> None:  # an exception in here would be a SystemError
        if info.type not in (h5py.h5l.TYPE_HARD, h5py.h5l.TYPE_SOFT):
            found.append(name)

    file.id.links.visit(visit, info=True)
    if found:
        name = found[0].decode(errors="replace")
        raise ValueError(f"has a link to another file, {name!r}, which is not followed")
