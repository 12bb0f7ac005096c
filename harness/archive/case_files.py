"""Case files: one file for the result of each case, and one for its snapshots.

The result of a case is ``OUT/<study>/cases/<key>.nc``. A case has been run if the file with its key
exists; time stamps play no role.

Snapshots are in a file of their own, ``<key>.fields.nc``, because `status` and `collect` read whole
case files, and snapshots may be a hundred times as large as the rest. Besides, points and nodes of
different cases cannot share a dimension in a collected dataset.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError, DamagedError, NoFileError, remove_file
from harness.archive.conventions import (
    COMPLETED,
    DAMAGED,
    MISSING,
    NO_FIELDS,
    OUTDATED,
    UNREADABLE,
    UNTIMED,
    Role,
)
from harness.archive.netcdf_files import opened, read_attributes, read_netcdf, write_netcdf
from harness.archive.provenance import SOURCES
from harness.study.cases import Case
from harness.study.study import Study
from mpm_warp.fields.names import did_you_mean
from mpm_warp.provenance import SIMULATOR, edited_packages, provenance


@dataclass(frozen=True)
class Outcome:
    """How a case ended."""

    status: str  # one of those in harness/README.md
    message: str = ""  # one line on why it did not complete
    headline: str = ""  # name and value of the main result, in words
    seconds: float = 0.0  # total time of the case [s]
    sources: str = ""  # digest of the code that computed it
    reason: str = ""  # why it has no half width; see `conventions.reasons_of`
    start_seconds: float = 0.0  # part of `seconds` before the first step; 0 where not known
    compile_seconds: float = 0.0  # part of `seconds` for compiling or loading kernels


def case_folder(out: Path, study: Study) -> Path:
    """The folder of the case files of a study."""
    return out / study.name / "cases"


def check_no_link(out: Path, study: Study) -> None:
    """Refuse a study folder that is a link, so that no file outside the results is removed.

    The folder `out` itself may be a link.
    """
    folder = case_folder(out, study)
    for place in (folder.parent, folder):
        if place.is_symlink():
            raise ArchiveError(
                f"{place}: is a link, and files outside the results are never removed; "
                f"replace it by a folder, or make {out} a link"
            )


def case_file(folder: Path, case: Case) -> Path:
    """The file of a case; `folder` is that of `case_folder`."""
    return folder / f"{case.key}.nc"


def discard(folder: Path, cases: Iterable[Case]) -> None:
    """Remove the results and snapshots of cases, so that they are run again."""
    for case in cases:
        remove_file(case_file(folder, case))
        remove_file(fields_file(folder, case))


def write_case(
    folder: Path,
    case: Case,
    dataset: xr.Dataset,
    status: str,
    message: str = "",
    fields: xr.Dataset | None = None,
) -> None:
    """Write the snapshots of a case, `fields`, and then its result, so that it implies them.

    Attributes of the dataset override the provenance of this process, for cases computed on another
    machine. Without `fields`, snapshots of an earlier run are removed.
    """
    attributes = {
        "scene": case.scene,
        "scene_version": case.scene_version,
        "status": status,
        "message": message,
        "case_key": case.key,
        "parameters": json.dumps(case.parameters),
    }
    result = dataset.assign_attrs(provenance() | dataset.attrs | attributes)
    if fields is None:
        remove_file(fields_file(folder, case))
    else:
        requested = {REQUESTED: json.dumps(case.snapshots)}
        write_netcdf(fields.assign_attrs(result.attrs | requested), fields_file(folder, case))
    write_netcdf(result, case_file(folder, case))


def read_case(folder: Path, case: Case) -> xr.Dataset | None:
    """The result of a case, or None if it has not been run."""
    path = case_file(folder, case)
    try:
        dataset = read_netcdf(path)
    except NoFileError:
        return None
    _check_owner(path, case, dataset.attrs)
    return dataset


def read_outcome(folder: Path, case: Case, repeats: int = 0) -> Outcome:
    """How a case ended, by its file; `untimed` if it has fewer timed runs than `repeats`."""
    path = case_file(folder, case)
    try:
        with opened(path) as (attributes, variables):
            seconds = float(variables.get("case_time", 0.0))
            timed = variables["repeat"].size if "repeat" in variables else 0
            half_widths, reasons = (
                [values for values in variables.values() if values.attrs.get("role") == role]
                for role in (Role.UNCERTAINTY, Role.REASON)
            )
            is_known = any(np.isfinite(half_width.values).all() for half_width in half_widths)
            reason = "" if is_known else "; ".join(str(reason.values) for reason in reasons)
        _check_owner(path, case, attributes)
        status, sources = attributes["status"], str(attributes.get(SOURCES, ""))
        message = attributes["message"]
        if status == COMPLETED and (edited := set(edited_packages(sources)) - {SIMULATOR}):
            status, message = OUTDATED, f"computed by other sources of {', '.join(sorted(edited))}"
        elif status == COMPLETED and timed < repeats:
            status = UNTIMED
        elif status == COMPLETED and not has_fields(folder, case):
            status = NO_FIELDS
    except NoFileError:
        return Outcome(MISSING)
    except DamagedError as error:
        return Outcome(DAMAGED, str(error))
    except ArchiveError as error:
        return Outcome(UNREADABLE, str(error))
    return Outcome(status, message, seconds=seconds, sources=sources, reason=reason)


def is_complete(folder: Path, case: Case, repeats: int = 0) -> bool:
    """Whether a case is completed and has all timed runs and snapshots that are asked for."""
    return read_outcome(folder, case, repeats).status == COMPLETED


def _check_owner(path: Path, case: Case, attributes: Mapping[str, Any]) -> None:
    if attributes.get("case_key") != case.key:
        raise ArchiveError(f"{path}: is not the result of case {case.key}")


ENDING = ".fields.nc"
MOST_NAMED = 5
"""Number of cases that an error lists if none has a key similar to the requested one."""
REQUESTED = "snapshots"
"""Attribute with the requested moments as JSON; a run may end before the last ones."""


def fields_file(folder: Path, case: Case) -> Path:
    """The file of a case's snapshots; `folder` is that of `case_folder`."""
    return folder / f"{case.key}{ENDING}"


def has_fields(folder: Path, case: Case) -> bool:
    """Whether a case has all requested snapshots; `ArchiveError` if that cannot be read."""
    if not case.snapshots:
        return True
    path = fields_file(folder, case)
    try:
        attributes = read_attributes(path)
    except (NoFileError, DamagedError):
        return False
    _check_owner(path, case, attributes)
    return set(case.snapshots) <= set(json.loads(attributes[REQUESTED]))


def read_fields(path: Path) -> xr.Dataset:
    """The snapshots in a file."""
    fields = read_netcdf(path)
    if REQUESTED not in fields.attrs:
        raise ArchiveError(f"{path}: holds no snapshots")
    return fields


def find_fields(file: Path, key: str | None) -> Path:
    """The file of a case's snapshots, found by the file of a study, of the case, or by itself.

    The key of the case is needed if several cases of the study have snapshots.
    """
    if file.name.endswith(ENDING):
        return file
    attributes = read_attributes(file)
    if "study" not in attributes:
        return file.with_suffix(ENDING)
    study = str(attributes["study"])
    folder = file.parent / study / "cases"
    found = sorted(folder.glob(f"*{ENDING}"))
    keys = [path.name.removesuffix(ENDING) for path in found]
    if key is None and len(found) == 1:
        return found[0]
    if key in keys:
        return found[keys.index(key)]
    if not found:
        raise ArchiveError(
            f"{file}: no case has snapshots in {folder}; run {study} with --snapshots, or move "
            "that folder with its result"
        )
    problem = "several cases have snapshots; name one" if key is None else f"case {key} has none"
    more = f" and {len(keys) - MOST_NAMED} more" if len(keys) > MOST_NAMED else ""
    listed = f"; cases with snapshots: {', '.join(keys[:MOST_NAMED])}{more}"
    raise ArchiveError(f"{file}: {problem}{did_you_mean(key or '', keys) or listed}")
