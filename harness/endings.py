"""How a command ends: its exit codes, and the signal that ends it before."""

from __future__ import annotations

import signal
from types import FrameType
from typing import NoReturn

DONE, INCOMPLETE = 0, 1
BAD_INPUT = 2
"""Exit code of a command line, a study or a file that cannot be used."""


class Terminated(KeyboardInterrupt):
    """SIGTERM has come; ends a run as Ctrl-C does."""


def end_at_sigterm() -> None:
    """From now on SIGTERM ends the command as Ctrl-C does."""
    signal.signal(signal.SIGTERM, _raise_terminated)


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated
