"""The process of a command: exit codes, signals, and safe standard streams.

No text from a file can control the terminal through these streams.
"""

import io
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, redirect_stderr, redirect_stdout
from types import FrameType
from typing import Any, NoReturn, TextIO

from harness.errors import CODES, HarnessError, printable

DONE, INCOMPLETE = 0, 1
BAD_INPUT = 2
"""Exit code of a command line, a study or a file that cannot be used."""

DEFECT = 70
"""Exit code of an error of the program itself (EX_SOFTWARE of BSD's sysexits.h)."""


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP was received; it ends a run as Ctrl-C does."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


def end_at_sigterm() -> None:
    """Let SIGTERM, and SIGHUP of a closed terminal, end the command as Ctrl-C does.

    If SIGHUP is ignored, as under `nohup`, it stays ignored.
    """
    signal.signal(signal.SIGTERM, _raise_terminated)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, _raise_terminated)


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated(number)


CONTROLS = CODES | {"\n": "\n", "\t": "\t"}
"""What the harness itself may send to control the terminal: colours, line ends, tabs."""
_CONTROLS = re.compile("(" + "|".join(map(re.escape, CONTROLS)) + ")")


def complete_streams() -> None:
    """Connect standard streams that are closed, as by ``2>&-``, to the null device."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        # Descriptors 0 to 2 belong to the standard streams, here and in workers. No other file may
        # get one of them.
        os.set_inheritable(number, True)
    os.close(number)
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def send_nowhere(stream: TextIO) -> None:
    """Send further output of a stream to the null device, so that closing it raises no error."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)


def safe_output() -> AbstractContextManager[None]:
    """Make standard output safe inside a ``with``; it is flushed at the end."""
    return _safe(redirect_stdout, sys.stdout, is_output=True)


def safe_remarks() -> AbstractContextManager[None]:
    """Make standard error safe inside a ``with``; what cannot be written is dropped."""
    return _safe(redirect_stderr, sys.stderr, is_output=False)


@contextmanager
def _safe(
    redirected: Callable[[Any], AbstractContextManager[Any]], stream: TextIO, *, is_output: bool
) -> Iterator[None]:
    if isinstance(stream, io.TextIOWrapper):
        # Letters that the terminal's encoding lacks are written as escapes.
        stream.reconfigure(errors="backslashreplace")
    safe = _Stream(stream, is_output=is_output)
    with redirected(safe):
        try:
            yield
        finally:
            safe.flush()


class _Stream:
    """A wrapper of a standard stream. After an error of writing, further output is dropped.

    Standard output gets only printable characters, and an error of writing ends the command. An
    error on standard error does not.
    """

    def __init__(self, stream: TextIO, *, is_output: bool) -> None:
        self.stream = stream
        self.is_output = is_output

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        if self.is_output:
            pieces = _CONTROLS.split(text)
            text = "".join(CONTROLS.get(piece) or printable(piece) for piece in pieces)
        self._done(self.stream.write, text)
        return len(text)

    def flush(self) -> None:
        self._done(self.stream.flush)

    def _done(self, action: Callable[..., object], *given: str) -> None:
        try:
            action(*given)
        except BrokenPipeError:
            raise
        except OSError as error:
            send_nowhere(self.stream)
            if self.is_output:
                raise HarnessError(
                    f"standard output: cannot be written: {error.strerror}"
                ) from None
