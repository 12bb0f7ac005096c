"""Devices that cases are computed on."""

from __future__ import annotations

import os
from pathlib import Path

import warp

from harness.errors import HarnessError


def start_warp_in_silence() -> None:
    """Keep Warp's greeting, and its remark where there is no GPU, out of the progress display."""
    warp.config.log_level = warp.LOG_WARNING
    kept = os.dup(2)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 2)  # the remark does not come from Python
        warp.init()
        os.dup2(kept, 2)
    os.close(kept)


def check_device(device: str) -> None:
    """Check that a device is there.

    Raises:
        HarnessError: it is not.
    """
    if device == "cpu":
        return
    start_warp_in_silence()
    known = [it.alias for it in warp.get_devices()]
    if device not in known:
        raise HarnessError(f"--device {device}: there is none here; known: {', '.join(known)}")
