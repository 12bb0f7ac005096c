"""The beginning of a worker process: it sees to its own end before it loads what computes.

A step may take minutes where cells are small, and compiling takes seconds. So a worker does not
wait for its next report to learn that its parent is gone: a thread of its own waits for that.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from multiprocessing.connection import Connection, wait
from pathlib import Path

ABANDONED = 1
"""Exit code of a worker whose parent is gone; nobody is left who would read it."""


def serve_while_parent_lives(
    connection: Connection, folder: Path, device: str, repeats: int, memory_limit: float | None
) -> None:
    """Run cases as `harness.run.worker.serve` does, until the parent process is gone.

    To be called first in a fresh process. The process then ends at once, whatever it computes. A
    file that it was writing is half-written under another name, and the next run removes it.
    """
    # A terminal that is closed tells the whole group, but it is the parent that decides.
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    # Loads Warp and all scenes, which takes seconds.
    from harness.run.worker import serve

    serve(connection, folder, device, repeats, memory_limit)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker has a parent"
    wait([parent.sentinel])
    # Not an exception, which would have to wait until the step is done.
    os._exit(ABANDONED)
