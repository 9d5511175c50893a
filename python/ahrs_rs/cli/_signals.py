"""Signals that ask a command to end: each is an interruption as Ctrl-C is, so that nothing is lost."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from ahrs_rs import _atomic

#: Those that end a process which does not handle them: of a scheduler, a container, and of a terminal that goes.
NAMES = ("SIGTERM", "SIGHUP")

#: Where a command has not ended so long after a signal, s, it waits for a call of another library, which no exception
#: gets into (a file of gigabytes that is parsed or compressed).
PATIENCE = 0.3


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
def interruptible(fail: Callable[[str], object] | None = None) -> Iterator[Received]:
    """Within, the signals are a ``KeyboardInterrupt``, but where they are ignored (nohup) or somebody handles them.

    Parameters
    ----------
    fail : of a program of its own: told what has come where the exception is not through in time. Then the process is
        ended: outputs are as they were, since none of them is in its place before it is whole
    """
    received = Received()

    def interrupt(number: int, frame: FrameType | None) -> None:
        received.number = number
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield received
        return
    before = {}
    for number in (getattr(signal, name) for name in NAMES if hasattr(signal, name)):
        if signal.getsignal(number) is signal.SIG_DFL:
            before[number] = signal.signal(number, interrupt)
    guard = None if fail is None or sys.platform == "win32" else _Guard(received, {signal.SIGINT, *before}, fail)
    try:
        yield received
    finally:
        if guard is not None:
            guard.stop()
        for number, handler in before.items():
            signal.signal(number, handler)


class _StopError(Exception):
    """Ctrl-C within `stoppable`."""


@contextmanager
def stoppable() -> Iterator[None]:
    """Within, Ctrl-C ends what is within, and the command goes on after it; other signals end the command."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise _StopError

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # The guard would end the process, where what comes after takes a while.
    guard, before = signal.set_wakeup_fd(-1), signal.signal(signal.SIGINT, stop)
    try:
        yield
    except _StopError:
        pass
    finally:
        signal.signal(signal.SIGINT, before)
        signal.set_wakeup_fd(guard, warn_on_full_buffer=False)


class _Guard:
    """A thread that ends the process where the main thread is too late to do it."""

    def __init__(self, received: Received, numbers: set[int], fail: Callable[[str], object]) -> None:
        self.received, self.numbers, self.fail = received, numbers, fail
        self._stopped = threading.Event()
        # The system writes the number of each signal into the pipe, whatever the main thread does.
        self._reading, self._writing = os.pipe()
        os.set_blocking(self._writing, False)
        self._before = signal.set_wakeup_fd(self._writing, warn_on_full_buffer=False)
        threading.Thread(target=self._watch, daemon=True).start()

    def stop(self) -> None:
        """The main thread has come to its end."""
        self._stopped.set()
        signal.set_wakeup_fd(self._before)
        os.close(self._writing)

    def _watch(self) -> None:
        while come := os.read(self._reading, 1):
            if come[0] in self.numbers and not self._stopped.wait(PATIENCE):
                self.received.number = come[0]
                _atomic.remove_unfinished()
                self.fail(self.received.word)
                os._exit(self.received.status)
        os.close(self._reading)
