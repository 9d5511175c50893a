"""Signals that ask a command to end: each is an interruption as Ctrl-C is, so that nothing is lost."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: Those that end a process which does not handle them: of a scheduler, a container, and of a terminal that goes.
NAMES = ("SIGTERM", "SIGHUP")


class Received:
    """Which signal has come."""

    def __init__(self) -> None:
        self.number: int = signal.SIGINT

    @property
    def status(self) -> int:
        """What a shell reports of a program that the signal ended."""
        return 128 + self.number

    @property
    def word(self) -> str:
        """What is to be told of it."""
        return "interrupted" if self.number == signal.SIGINT else f"ended by {signal.Signals(self.number).name}"


@contextmanager
def interruptible() -> Iterator[Received]:
    """Within, the signals are a ``KeyboardInterrupt``, but where they are ignored (nohup) or somebody handles them."""
    received = Received()

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.number = number
        raise KeyboardInterrupt

    before = {}
    if threading.current_thread() is threading.main_thread():
        for number in (getattr(signal, name) for name in NAMES if hasattr(signal, name)):
            if signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, interrupt)
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
