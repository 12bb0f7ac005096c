"""What results say of where they come from: each case, and the files that collect cases."""

from collections import Counter
from pathlib import Path

import xarray as xr

from harness.archive.conventions import COMPLETED, is_there, over_cases, scenes_of
from harness.errors import counted, tell
from mpm_warp.provenance import PACKAGES, provenance
from mpm_warp.scenes import scene_class, scene_names

SOURCES = "sources"
"""Attribute of a case file: digests of the code that computed the case."""
OF_CASE = (
    "command_line",
    "time_written",
    "commit",
    *PACKAGES,
    "python_version",
    "platform",
    "processor",
    "cores",
    "device",
    SOURCES,
)
"""Attributes of a case file that say where, when and with what the case was computed."""


def provenance_of_collector() -> dict[str, str]:
    """Provenance of a process that collects cases, which other machines may have computed."""
    known = provenance()
    history = f"{known['history']} (collected by {known['source']})"
    return {"history": history, "Conventions": known["Conventions"]}


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
