"""The process of a command: how it ends, and its standard streams, on which no file has power."""

from __future__ import annotations

import io
import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from types import FrameType
from typing import Any, NoReturn, TextIO

from harness.errors import HarnessError, printable
from harness.terminal import CODES

DONE, INCOMPLETE = 0, 1
BAD_INPUT = 2
"""Exit code of a command line, a study or a file that cannot be used."""

DEFECT = 70
"""Exit code of an error of the program itself (EX_SOFTWARE of BSD's sysexits.h)."""


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP has come; ends a run as Ctrl-C does.

    Attributes:
        number: of the signal.
    """

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


@contextmanager
def safe_output() -> Iterator[None]:
    """Inside the ``with``, standard output is an `_Output`, and is written out at its end."""
    _escape_letters(sys.stdout)
    output: Any = _Output(sys.stdout)
    with redirect_stdout(output):
        try:
            yield
        finally:
            output.flush()


@contextmanager
def safe_remarks() -> Iterator[None]:
    """Inside the ``with``, standard error is a `_Remarks`."""
    _escape_letters(sys.stderr)
    remarks: Any = _Remarks(sys.stderr)
    with redirect_stderr(remarks):
        try:
            yield
        finally:
            remarks.flush()


def _escape_letters(stream: TextIO) -> None:
    """A terminal that does not know a letter is shown its escape."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="backslashreplace")


class _Stream:
    """A stream before another one."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


class _Output(_Stream):
    """Standard output: lines of printable characters; what cannot be written ends the command."""

    def write(self, text: str) -> int:
        try:
            return self.stream.write(
                "".join(OURS.get(it) or printable(it) for it in _OURS.split(text))
            )
        except BrokenPipeError:
            raise
        except OSError as error:
            raise self._lost(error) from None

    def flush(self) -> None:
        try:
            self.stream.flush()
        except BrokenPipeError:
            raise
        except OSError as error:
            raise self._lost(error) from None

    def _lost(self, error: OSError) -> HarnessError:
        send_nowhere(self.stream)
        return HarnessError(f"standard output: cannot be written: {error.strerror}")


class _Remarks(_Stream):
    """Standard error: what cannot be written there is lost, and the command goes on."""

    def write(self, text: str) -> int:
        try:
            return self.stream.write(text)
        except BrokenPipeError:
            raise
        except OSError:
            send_nowhere(self.stream)
            return len(text)

    def flush(self) -> None:
        try:
            self.stream.flush()
        except BrokenPipeError:
            raise
        except OSError:
            send_nowhere(self.stream)
