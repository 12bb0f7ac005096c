"""Files that are no results of a study: found, described and removed."""

from __future__ import annotations

import json
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.archive.atomic_files import ArchiveError, abandoned, is_folder, remove_file
from harness.archive.case_files import case_file, case_folder, check_no_link, read_outcome
from harness.archive.conventions import DAMAGED
from harness.archive.fields_files import fields_fault, fields_file
from harness.archive.netcdf_files import read_attributes
from harness.errors import tell
from harness.study.cases import Case
from harness.study.study import Study
from mpm_warp.parameters import Value

Parameters = Mapping[str, Value | None]


@dataclass(frozen=True)
class Leftover:
    """A file that does not belong to a study.

    Attributes:
        path: the file, or the link.
        what: it is, in words.
        mark: distinguishes it from another file that has its name later.
    """

    path: Path
    what: str
    mark: tuple[int, int, int]


def leftovers(study: Study, out: Path) -> list[Leftover]:
    """Files that do not belong to the study as it is now.

    They are damaged files, results of cases that the study does not have (with other parameters,
    or of another version of the scene), and files that a killed process left half-written. A link
    counts as a file. A folder is none, whatever its name; one line says that it is kept.

    Raises:
        ArchiveError: the case files are outside the results.
    """
    check_no_link(out, study)
    folder = case_folder(out, study)
    found = {path: "half-written" for place in (out, folder) for path in abandoned(place)}
    present = {case_file(folder, case): case for case in study.cases}
    of_cases = {fields_file(folder, case) for case in study.cases}
    keys, shared = {path.stem for path in present}, _shared_parameters(study.cases)
    for path in sorted(folder.glob("*.nc")):
        if is_folder(path):
            tell(f"{path}: is a folder, where only files belong; kept")
        elif path in of_cases:
            if (fault := fields_fault(path)) is not None:
                found[path] = fault.removeprefix(f"{path}: ")
        elif path not in present:
            found[path] = _stranger(path, keys, shared)
        elif (outcome := read_outcome(folder, present[path])).status == DAMAGED:
            found[path] = outcome.message.removeprefix(f"{path}: ")
    return [Leftover(path, what, _mark(path)) for path, what in found.items()]


def remove(found: Iterable[Leftover]) -> int:
    """Remove files that were found; returns how many, and says of each other one why not.

    A file that was written since under the name of one that was found is kept: a run may have
    completed the case meanwhile.
    """
    count = 0
    for leftover in found:
        try:
            if _mark(leftover.path) != leftover.mark:
                tell(f"{leftover.path}: was written anew meanwhile; kept")
                continue
            remove_file(leftover.path)
        except FileNotFoundError:
            continue
        except ArchiveError as error:
            tell(str(error))
        else:
            count += 1
    return count


def _mark(path: Path) -> tuple[int, int, int]:
    about = path.lstat()
    return about.st_ino, about.st_mtime_ns, about.st_size


def _stranger(path: Path, keys: Container[str], shared: Mapping[str, Parameters]) -> str:
    """Describe a file in the folder of a study's cases that belongs to none of these cases.

    Args:
        path: the file.
        keys: of the study's cases.
        shared: by scene, the parameters that are the same in all of these.
    """
    try:
        said = read_attributes(path)
        parameters = dict(json.loads(said["parameters"]))
        key, scene = str(said["case_key"]), str(said["scene"])
        told = f"{scene} version {said['scene_version']}, {said['status']}"
    except (ArchiveError, KeyError, TypeError, ValueError):
        return "not a case file, or a damaged one"
    if key in keys:
        return f"a copy of case {key}"
    if scene not in shared:
        return f"no case of this study: {told}: another scene"
    others = ", ".join(
        f"{name}={value}"
        for name, value in parameters.items()
        if name not in shared[scene] or value != shared[scene][name]
    )
    return f"no case of this study: {told}: {others or 'the same parameters'}"


def _shared_parameters(cases: Sequence[Case]) -> dict[str, Parameters]:
    """By scene, the parameters that are the same in all of its cases."""
    shared: dict[str, Parameters] = {}
    for case in cases:
        before = shared.get(case.scene, case.parameters)
        same = {name: value for name, value in before.items() if value == case.parameters[name]}
        shared[case.scene] = same
    return shared
