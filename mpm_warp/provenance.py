"""Where a result comes from: program, commit, sources, machine, command line and time."""

import functools
import hashlib
import importlib.metadata
import importlib.util
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from types import FunctionType
from typing import Any

PACKAGES = {
    f"{name.lower().replace('-', '_')}_version": name
    for name in ("mpm-warp", "warp-lang", "numpy", "xarray", "netCDF4")
}
"""Packages whose versions are kept, by attribute."""
SIMULATOR = "mpm_warp"
"""The package whose changes the versions of scenes tell; the sources of others have none."""
NO_SOURCES = {*sys.stdlib_module_names, "numpy", "scipy", "warp", "xarray"} - {"__main__"}
"""Packages whose classes are no part of a scene; their versions are kept."""


def provenance() -> dict[str, str]:
    """Provenance of what this process computes or writes now, as attributes of a dataset.

    `source` and `history` are those of the CF conventions.
    """
    time, known = datetime.now(UTC).isoformat(timespec="seconds"), _of_process()
    return {
        "source": f"mpm_warp {known['mpm_warp_version']}, commit {known['commit']}",
        "history": f"{time} {known['command_line']}",
        "time_written": time,
        **known,
        "Conventions": "CF-1.11",
    }


def sources_of(scene: object, composition: object) -> str:
    """Digests of the code that computes a scene: "mpm_warp 0123456789abcdef, their_clay 0123...".

    They are of the simulator and of every other package that the scene, its law or one of its parts
    comes from. A process keeps the sources that it has loaded, so they are read once.
    """
    modules = {SIMULATOR, *_modules([scene, composition], set())}
    packages = {module.partition(".")[0] for module in modules} - NO_SOURCES
    ours_first = sorted(packages, key=lambda package: (package != SIMULATOR, package))
    return ", ".join(f"{package} {sources_digest(package)}" for package in ours_first)


def edited_packages(sources: str) -> list[str]:
    """The packages whose sources here are not those of a text of `sources_of`."""
    stated = dict(pair.split() for pair in sources.split(", ") if " " in pair)
    known = {SIMULATOR: "none", **stated}
    return [package for package, digest in known.items() if sources_digest(package) != digest]


@functools.cache
def sources_digest(package: str) -> str:
    """16 hexadecimal digits over all ``.py`` files of a package; "none" where it is not there."""
    module: Any = sys.modules.get(package) or importlib.util.find_spec(package)
    spec = getattr(module, "__spec__", module)
    places = getattr(module, "__path__", getattr(spec, "submodule_search_locations", None))
    single = getattr(module, "__file__", getattr(spec, "origin", None))
    files = {
        str(file.relative_to(place)): file
        for place in places or ()
        for file in Path(place).rglob("*.py")
    }
    if not places and single is not None and Path(single).is_file():  # no file: typed in
        files = {Path(single).name: Path(single)}
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0".encode() + files[name].read_bytes() + b"\0")
    return digest.hexdigest()[:16] if files else "none"


def _modules(things: list[object], seen: set[int]) -> Iterator[str]:
    """The modules of the classes and functions that some things consist of."""
    for thing in things:
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if isinstance(thing, FunctionType):
            yield thing.__module__
        elif isinstance(thing, tuple | list):
            yield from _modules(list(thing), seen)
        elif isinstance(thing, Mapping):
            yield from _modules(list(thing.values()), seen)
        elif hasattr(thing, "__dict__") and not isinstance(thing, type):
            yield from (kind.__module__ for kind in type(thing).__mro__)
            if type(thing).__module__.partition(".")[0] not in NO_SOURCES:
                yield from _modules(list(vars(thing).values()), seen)


@functools.cache
def _of_process() -> dict[str, str]:
    return {
        "command_line": shlex.join(filter(None, sys.argv)) or "python",
        "commit": _commit(),
        **{attribute: _version(name) for attribute, name in PACKAGES.items()},
        "python_version": platform.python_version(),
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
    checkout = Path(__file__).resolve().parents[1]
    git = shutil.which("git")
    # Without a .git here, git would describe whatever repository contains the installation.
    if git is None or not (checkout / ".git").exists():
        return "unknown"
    command = [git, "-C", str(checkout), "describe", "--always", "--dirty"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    return result.stdout.strip() or "unknown"


def _processor() -> str:
    """Name of the processor model, which :mod:`platform` does not give on Linux."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        text = ""  # no Linux
    named = re.search(r"^model name\s*:(.*)", text, re.MULTILINE)
    return named[1].strip() if named else platform.processor() or platform.machine()
