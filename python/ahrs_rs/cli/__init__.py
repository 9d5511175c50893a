"""The command line ``ahrs-rs``: one module per command, each with `add_parser` and its function.

Whatever goes wrong is told in one line on standard error, with exit status 2. SIGTERM and SIGHUP end a command as
Ctrl-C does, with what is done kept and nothing half written.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from typing import NoReturn

from ahrs_rs import _native
from ahrs_rs._printable import printable
from ahrs_rs._version import __version__
from ahrs_rs.cli._common import CliError
from ahrs_rs.cli._signals import interruptible

__all__ = ["main"]

#: The commands; the module of each has its name after an underscore, and is imported where the command is given.
COMMANDS = (
    "run",
    "check",
    "compare",
    "view",
    "tune",
    "filters",
    "sensors",
    "formats",
    "calibrate",
    "noise",
    "simulate",
    "demo",
    "papers",
)

FAILED = 2
#: What a shell reports of a program that the closed pipe ended: 128 + SIGPIPE.
PIPE_CLOSED = 141

EPILOG = """\
Without a recording at hand:   ahrs-rs demo
What there is to choose from:  ahrs-rs filters
Options of a command:          ahrs-rs COMMAND --help
"""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, without the usage."""

    def error(self, message: str) -> NoReturn:
        raise CliError(f"{message} (see {self.prog} --help)")


def main(argv: list[str] | None = None) -> int:
    """Run a command and return its exit status: 0, 2 after an error, 128 and the number of a signal that ended it.

    Parameters
    ----------
    argv : the arguments without the program's name; None takes those of the process.
    """
    if argv is None:
        # A terminal that lacks a character, as ° in ASCII, is no reason to fail.
        _tolerate(sys.stdout)
    try:
        with interruptible(_fail if argv is None else None) as received:
            status = _command(argv)
            _flush()
            return status
    except BrokenPipeError:
        _drop_output()
        return PIPE_CLOSED
    except KeyboardInterrupt as interruption:
        message, status = str(interruption) or received.word, received.status
    except (CliError, ValueError, ImportError, MemoryError, OverflowError) as error:
        message, status = str(error) or type(error).__name__, FAILED
    except OSError as error:
        message, status = _system_message(error), FAILED
    # Told only now: the exception is gone and has taken a progress bar with it.
    _fail(message)
    try:
        _flush()
    except OSError:  # the error that has just been told
        _drop_output()
    return status


def _fail(message: str) -> None:
    print(f"ahrs-rs: error: {printable(' '.join(message.split()))}", file=sys.stderr, flush=True)


def _command(argv: list[str] | None) -> int:
    given = sys.argv[1:] if argv is None else argv
    parser = _parser(given[0] if given and given[0] in COMMANDS else None)
    try:
        args = parser.parse_args(argv)
    except SystemExit as end:  # --help and --version
        return int(end.code or 0)
    if args.function is None:
        raise CliError(f"expected a command: {', '.join(COMMANDS)} (see {parser.prog} --help)")
    return int(args.function(args))


def _parser(command: str | None) -> argparse.ArgumentParser:
    """The parser of a command, or of all of them."""
    parser = _Parser(
        prog="ahrs-rs",
        description="Orientation from recordings of gyroscope, accelerometer and magnetometer.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    version = f"ahrs-rs {__version__} ({_native.INSTRUCTIONS})"
    parser.add_argument("--version", action="version", version=version)
    parser.set_defaults(function=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    for name in COMMANDS if command is None else [command]:
        importlib.import_module(f"{__name__}._{name}").add_parser(commands)
    return parser


def _system_message(error: OSError) -> str:
    if error.filename is not None and error.strerror:
        return f"{os.fsdecode(error.filename)}: {error.strerror}"
    return error.strerror or str(error) or type(error).__name__


def _tolerate(stream: object) -> None:
    """Let the stream write what its encoding lacks as an escape sequence, if it is a stream that can."""
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="backslashreplace")


def _flush() -> None:
    """Write out now what is printed, so that an error of the standard output can be told."""
    if sys.stdout is not None:  # None: the process was started with it closed
        sys.stdout.flush()


def _drop_output() -> None:
    """Send what is still to be written to nowhere, or the interpreter complains once more when it ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
