"""How a command ends: its exit codes, and the signal that ends it before."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType
from typing import NoReturn

DONE, INCOMPLETE = 0, 1
BAD_INPUT = 2
"""Exit code of a command line, a study or a file that cannot be used."""


class Terminated(KeyboardInterrupt):
    """SIGTERM has come; ends a run as Ctrl-C does."""


def complete_streams() -> None:
    """Let standard streams that the process was started without, as by ``2>&-``, go nowhere."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass  # the first three numbers are theirs: no other file may come to have one
    os.close(number)
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def end_at_sigterm() -> None:
    """From now on SIGTERM ends the command as Ctrl-C does."""
    signal.signal(signal.SIGTERM, _raise_terminated)


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated
