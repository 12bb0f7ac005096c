"""Devices that cases are computed on."""

from __future__ import annotations

from harness.errors import HarnessError
from mpm_warp.execution.execution import device_names


def check_device(device: str) -> None:
    """Check that a device is there.

    Raises:
        HarnessError: it is not.
    """
    if device != "cpu" and device not in device_names():
        known = ", ".join(device_names())
        raise HarnessError(f"--device {device}: there is none here; known: {known}")
