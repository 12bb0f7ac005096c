"""Where a result comes from: sources, versions, commit, machine, command line, time."""

import functools
import hashlib
import importlib.metadata
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path

import xarray as xr

import mpm_warp
from harness.archive.conventions import COMPLETED, is_there, over_cases, scenes_of
from harness.errors import counted, tell
from harness.machine import stated_in
from mpm_warp.scenes import scene_class, scene_names

SOURCES = "sources"
"""Attribute of a case file: the digest of the code that computed the case."""
PACKAGES = {
    f"{name.lower().replace('-', '_')}_version": name
    for name in ("mpm-warp", "warp-lang", "numpy", "xarray", "netCDF4")
}
"""Packages whose versions are kept, by attribute."""
OF_CASE = (
    "command_line",
    "commit",
    "python_version",
    *PACKAGES,
    "platform",
    "processor",
    "cores",
    "device",
    SOURCES,
    "time_written",
)
"""Attributes of a case file that say where, when and with what the case was computed."""


def provenance() -> dict[str, str]:
    """Provenance of a file that this process writes now, as attributes."""
    time = datetime.now(UTC).isoformat(timespec="seconds")
    return {"Conventions": "CF-1.11", **_of_process(), "time_written": time}


def provenance_of_collector() -> dict[str, str]:
    """Provenance of a process that collects cases, which other machines may have computed."""
    conventions, *others = provenance().items()  # "Conventions" describes the file itself
    return dict([conventions, *((f"collected_{name}", value) for name, value in others)])


@functools.cache
def sources_digest(scene: type) -> str:
    """16 hexadecimal digits that identify the code that computes a scene.

    The digest is over all ``.py`` files of the package `mpm_warp`, and the file that defines the
    scene if it is elsewhere. It takes some 10 ms and is computed once, because a process keeps the
    sources that it has loaded.
    """
    package = Path(mpm_warp.__path__[0])
    files = sorted(package.rglob("*.py"))
    own = getattr(sys.modules.get(scene.__module__), "__file__", None)
    if own is not None and not Path(own).is_relative_to(package):
        files.append(Path(own))
    digest = hashlib.sha256()
    for file in files:
        name = file.relative_to(package) if file.is_relative_to(package) else file.name
        digest.update(f"{name}\0".encode() + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def other_version(dataset: xr.Dataset) -> str:
    """In words, how many cases of a result are of another version of their scene than here.

    "" if there are none. The result is that of a study, or the snapshots of a case. A scene that is
    not installed has no version to compare with.
    """
    own = dataset if "status" in dataset.variables else dataset.assign(status=COMPLETED)
    stored = "scene_version" if "scene_version" in own.coords else own.attrs.get("scene_version")
    cases = Counter(zip(scenes_of(own), over_cases(own, stored).tolist(), strict=True))
    others = {
        f"{scene} {version}, installed is {installed}": count
        for (scene, version), count in cases.items()
        if is_there(version) and scene in scene_names()
        if version != (installed := scene_class(scene).version)
    }
    if not others:
        return ""
    number = f"{sum(others.values())} of {counted(own['status'].size, 'case')}"
    return f"{number} computed by another version of the scene ({'; '.join(others)})"


def tell_of_other_version(path: Path, dataset: xr.Dataset) -> None:
    """Print one line if cases of a result are of another version of their scene than here."""
    if text := other_version(dataset):
        tell(f"{path}: {text}; `harness run` computes them anew")


@functools.cache
def _of_process() -> dict[str, str]:
    return {
        "command_line": shlex.join(sys.argv),
        "commit": _commit(),
        "python_version": platform.python_version(),
        **{attribute: _version(name) for attribute, name in PACKAGES.items()},
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
    """Output of ``git describe`` in the checkout of this file, or "unknown"."""
    checkout = Path(__file__).resolve().parents[2]
    git = shutil.which("git")
    # Without a .git here, git would describe whatever repository contains the installation.
    if git is None or not (checkout / ".git").exists():
        return "unknown"
    command = [git, "-C", str(checkout), "describe", "--always", "--dirty"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    return result.stdout.strip() or "unknown"


def _processor() -> str:
    """Name of the processor model, which :mod:`platform` does not give on Linux."""
    named = re.search(r"^model name\s*:(.*)", stated_in(Path("/proc/cpuinfo")), re.MULTILINE)
    return named[1].strip() if named else platform.processor() or platform.machine()
