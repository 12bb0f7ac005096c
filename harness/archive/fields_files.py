"""Field files: the snapshots of one case each, in netCDF, ``OUT/<study>/cases/<key>.fields.nc``.

They stand beside the case files, not in them: `status` and `collect` read every case file as a
whole, and one snapshot may be a hundred times as large as all else that is known of a case. In a
collected dataset points and nodes of different cases could share no dimension.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import xarray as xr

from harness.archive.atomic_files import ArchiveError, remove_file
from harness.archive.netcdf_files import (
    check_version,
    read_attributes,
    read_fields_netcdf,
    write_netcdf,
)
from harness.study.cases import Case
from mpm_warp.parameters import did_you_mean

ENDING = ".fields.nc"
MOST_NAMED = 5
"""Cases that are named where none is like the one that is asked for."""
ASKED = "snapshots"
"""Attribute with the moments that were asked for, as JSON; some may be beyond the end of a run."""


def fields_file(folder: Path, case: Case) -> Path:
    """The file of a case's snapshots in the folder of its study's cases."""
    return folder / f"{case.key}{ENDING}"


def write_fields(folder: Path, case: Case, fields: xr.Dataset | None) -> None:
    """Keep the snapshots of a case, or remove those of an earlier run where there are none.

    Args:
        folder: the folder of the study's cases.
        case: the case.
        fields: its snapshots, with the attributes of its result.

    Raises:
        ArchiveError: they cannot be written, or not be removed.
    """
    path = fields_file(folder, case)
    if fields is None:
        remove_file(path)
    else:
        write_netcdf(fields.assign_attrs({ASKED: json.dumps(case.snapshots)}), path)


def has_fields(folder: Path, case: Case) -> bool:
    """Whether a case has all snapshots that are asked for, in a file that is not damaged."""
    if not case.snapshots:
        return True
    path = fields_file(folder, case)
    try:
        attributes = _attributes(path) if path.exists() else {}
        taken = json.loads(attributes.get(ASKED, "[]"))
    except (ArchiveError, TypeError, ValueError):
        return False
    is_its_own = attributes.get("case_key") == case.key
    return is_its_own and isinstance(taken, list) and set(case.snapshots) <= set(taken)


def fields_fault(path: Path) -> str | None:
    """What is wrong with a file of snapshots, in words; None where nothing is."""
    try:
        read_fields(path)
    except ArchiveError as error:
        return str(error)
    return None


def read_fields(path: Path) -> xr.Dataset:
    """The snapshots of a case.

    Raises:
        ArchiveError: there is no such file, or it is damaged, of another format version, or of
            something else.
    """
    if not path.exists():
        raise ArchiveError(f"{path}: no such file")
    fields = read_fields_netcdf(path)
    if ASKED not in fields.attrs:
        raise ArchiveError(f"{path}: holds no snapshots")
    return fields


def find_fields(file: Path, key: str | None) -> Path:
    """The file of a case's snapshots.

    Args:
        file: of a study's results, of the case, or of its snapshots.
        key: which case; None where there are the snapshots of one alone.

    Raises:
        ArchiveError: the file is of no use, or there are no such snapshots; the message names what
            there is.
    """
    if file.name.endswith(ENDING):
        return file
    if not file.exists():
        raise ArchiveError(f"{file}: no such file")
    attributes = read_attributes(file)
    if "study" not in attributes:
        return file.with_suffix(ENDING)
    study = str(attributes["study"])
    found = sorted((file.parent / study / "cases").glob(f"*{ENDING}"))
    keys = [path.name.removesuffix(ENDING) for path in found]
    if key is None and len(found) == 1:
        return found[0]
    if key in keys:
        return found[keys.index(key)]
    if not found:
        raise ArchiveError(f"{file}: no case has snapshots; run {study} with --snapshots")
    problem = "no case is named" if key is None else f"no snapshots of case {key}"
    listed = f"; there are those of {', '.join(keys[:MOST_NAMED])}"
    more = f" and {len(keys) - MOST_NAMED} more" if len(keys) > MOST_NAMED else ""
    raise ArchiveError(f"{file}: {problem}{did_you_mean(key or '', keys) or listed + more}")


def _attributes(path: Path) -> dict[str, Any]:
    attributes = read_attributes(path)
    check_version(path, attributes)
    return attributes
