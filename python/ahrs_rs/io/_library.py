"""What readers through other libraries share: their errors as ours, their printed words kept from the screen."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from collections.abc import Iterator

import numpy as np

from ahrs_rs.io._contents import one_line


@contextlib.contextmanager
def understood(what: str) -> Iterator[None]:
    """Whatever a library raises at a file is a ValueError that says "is not a readable `what`".

    A damaged file makes libraries raise nearly every class there is. An ImportError passes, and a ValueError of ours in
    which the file is described ("is …", "has …") too.
    """
    try:
        with np.errstate(all="ignore"):  # numbers that are none come of damage, and are told by what they lead to
            yield
    except (ImportError, _RefusedError):
        raise
    except Exception as error:
        raise ValueError(f"is not a readable {what}: {shortened(one_line(error))}") from error


class _RefusedError(ValueError):
    """A refusal in our own words, which `understood` lets pass."""


def refuse(sentence: str) -> ValueError:
    """The error for a file that is understood and cannot be taken, to be raised within `understood`."""
    return _RefusedError(sentence)


@contextlib.contextmanager
def quiet() -> Iterator[io.StringIO]:
    """What a library prints goes into the text that is given, in place of the screen."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
        yield text


@contextlib.contextmanager
def quiet_native() -> Iterator[io.StringIO]:
    """The same for a library of machine code, which writes past Python: the streams themselves go to a file."""
    text = io.StringIO()
    with quiet() as printed, tempfile.TemporaryFile() as file:
        kept = []
        try:
            for stream in (1, 2):
                kept.append((stream, os.dup(stream)))
                os.dup2(file.fileno(), stream)
        except OSError:  # a program without these streams has none to keep quiet
            pass
        try:
            yield text
        finally:
            for stream, copy in kept:
                os.dup2(copy, stream)
                os.close(copy)
            file.seek(0)
            text.write(printed.getvalue() + file.read().decode(errors="replace"))


def shortened(text: str, length: int = 300) -> str:
    """A text that fits into a message."""
    return text if len(text) <= length else f"{text[:length]}…"


def version(package: str) -> str:
    """The installed version of a package, with its name."""
    import importlib.metadata  # here: few formats need it

    return f"{package} {importlib.metadata.version(package)}"
