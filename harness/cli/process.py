"""The process of a command: exit codes, signals, and complete standard streams."""

import io
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

DONE, INCOMPLETE = 0, 1
BAD_INPUT = 2
"""Exit code of a command line, a study or a file that cannot be used."""

NOT_READ = 141
"""Exit code if the output is no longer read, as after ``| head``: 128 and SIGPIPE."""
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
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, _raise_terminated)


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated(number)


def complete_streams() -> None:
    """Connect standard streams that are closed, as by ``2>&-``, to the null device.

    Letters that the terminal's encoding lacks are written as escapes.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        # Descriptors 0 to 2 belong to the standard streams, here and in workers. No other file may
        # get one of them.
        os.set_inheritable(number, True)
    os.close(number)
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
