"""How a command ends: its exit codes, and the signals that end it before."""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn

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
