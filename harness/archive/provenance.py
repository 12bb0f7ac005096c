"""Where a result comes from: versions, commit, machine, command line, time."""

from __future__ import annotations

import functools
import importlib.metadata
import os
import platform
import shlex
import shutil
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

PACKAGES = ("mpm-warp", "warp-lang", "numpy", "xarray", "netCDF4")
OF_CASE = (
    "command_line",
    "commit",
    "python_version",
    *(f"{name.lower().replace('-', '_')}_version" for name in PACKAGES),
    "platform",
    "processor",
    "cores",
    "device",
    "time_written",
)
"""What the file of a case says of where, when and with what the case was computed."""


def provenance() -> dict[str, str]:
    """Attributes for a result file that is written now by this process."""
    time = datetime.now(UTC).isoformat(timespec="seconds")
    return {"Conventions": "CF-1.11", **_of_process(), "time_written": time}


def provenance_of_collector() -> dict[str, str]:
    """Attributes for a dataset of cases, which may all have been computed elsewhere and before."""
    conventions = "Conventions"  # of the file, whoever computed what is in it
    return {
        name if name == conventions else f"collected_{name}": value
        for name, value in provenance().items()
    }


@functools.cache
def _of_process() -> dict[str, str]:
    return {
        "command_line": shlex.join(sys.argv),
        "commit": _commit(),
        "python_version": platform.python_version(),
        **{f"{name.lower().replace('-', '_')}_version": _version(name) for name in PACKAGES},
        "platform": platform.platform(),
        "processor": _processor(),
        "cores": str(os.cpu_count()),
    }


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"


def _commit() -> str:
    """What ``git describe`` says of the checkout that this file is in, else "unknown"."""
    checkout = Path(__file__).resolve().parents[2]
    git = shutil.which("git")
    # Without a .git here, git would describe whatever repository contains the installation.
    if git is None or not (checkout / ".git").exists():
        return "unknown"
    command = [git, "-C", str(checkout), "describe", "--always", "--dirty"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    return result.stdout.strip() or "unknown"


def _processor() -> str:
    """Name of the processor's model; on Linux :mod:`platform` does not know it."""
    models = Path("/proc/cpuinfo")
    if models.exists():
        for line in models.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
