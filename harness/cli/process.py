"""The process of a command: how it ends, and its standard streams, on which no file has power."""

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
    """The signal of this number, SIGTERM or SIGHUP, has come; it ends a run as Ctrl-C does."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


def end_at_sigterm() -> None:
    """From now on SIGTERM, and SIGHUP of a closed terminal, end the command as Ctrl-C does.

    Where SIGHUP is ignored, as under `nohup`, it still is.
    """
    signal.signal(signal.SIGTERM, _raise_terminated)
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, _raise_terminated)


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated(number)


OURS = CODES | {"\n": "\n", "\t": "\t"}
"""What controls a terminal and is the harness's own: colours, ends of lines, tabs."""
_OURS = re.compile("(" + "|".join(map(re.escape, OURS)) + ")")


def complete_streams() -> None:
    """Let standard streams that the process was started without, as by ``2>&-``, go nowhere."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        # The first three numbers are theirs, here and in workers: no other file may have one.
        os.set_inheritable(number, True)
    os.close(number)
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def send_nowhere(stream: TextIO) -> None:
    """Let what is still to be written to a stream go nowhere, and be no error when it is closed."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)


def safe_output() -> AbstractContextManager[None]:
    """Inside the ``with``, standard output is safe, and is written out at its end."""
    return _safe(redirect_stdout, sys.stdout, is_output=True)


def safe_remarks() -> AbstractContextManager[None]:
    """Inside the ``with``, what standard error cannot take is lost."""
    return _safe(redirect_stderr, sys.stderr, is_output=False)


@contextmanager
def _safe(
    redirected: Callable[[Any], AbstractContextManager[Any]], stream: TextIO, *, is_output: bool
) -> Iterator[None]:
    if isinstance(stream, io.TextIOWrapper):
        # A terminal that does not know a letter is shown its escape.
        stream.reconfigure(errors="backslashreplace")
    safe = _Stream(stream, is_output=is_output)
    with redirected(safe):
        try:
            yield
        finally:
            safe.flush()


class _Stream:
    """A stream before another one: what cannot be written there goes nowhere from then on.

    Standard output has lines of printable characters, whose loss ends the command; without remarks
    on standard error it goes on.
    """

    def __init__(self, stream: TextIO, *, is_output: bool) -> None:
        self.stream = stream
        self.is_output = is_output

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        if self.is_output:
            text = "".join(OURS.get(piece) or printable(piece) for piece in _OURS.split(text))
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
