"""Case files: the result of one case each, in netCDF, written whole or not at all.

The files of a study are ``OUT/<study>/cases/<key>.nc``. Whether a case has been run depends on its
key alone, not on any time stamp.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from harness.archive.atomic_files import ArchiveError, remove_file
from harness.archive.conventions import COMPLETED, DAMAGED, FORMAT_VERSION, MISSING
from harness.archive.fields_files import fields_file, has_fields, write_fields
from harness.archive.netcdf_files import opened_result, read_netcdf, write_netcdf
from harness.archive.provenance import SOURCES, provenance
from harness.study.cases import Case
from harness.study.study import Study


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    Attributes:
        status: ``completed``; ``refused``, by its scene before it began; ``diverged``,
            ``inaccurate``, ``unfinished``, ``failed``, ``crashed``, ``timed_out``; ``missing``
            where there is no file, ``damaged`` where the file is of no use, ``untimed`` where it
            completed without the timed runs that its study asks for, ``no_fields`` where it did so
            without the snapshots.
        message: why it did not complete, one line.
        headline: name and value of the scalar that the scene is run for.
        seconds: time that the case took in all.
        start_seconds: of it, the time before the first step: imports, set-up; 0 where not known.
        compile_seconds: of it, the time to compile kernels or to load them.
        repeats: warm runs that its file has the times of.
        sources: digest of the code that computed it, as its file says.
    """

    status: str
    message: str = ""
    headline: str = ""
    seconds: float = 0.0
    repeats: int = 0
    sources: str = ""
    start_seconds: float = 0.0
    compile_seconds: float = 0.0


def case_folder(out: Path, study: Study) -> Path:
    """Where the case files of a study are."""
    return out / study.name / "cases"


def check_no_link(out: Path, study: Study) -> None:
    """Check that the case files of a study are inside the results, before any is removed.

    The folder of results itself may be a link.

    Raises:
        ArchiveError: a folder on the way to them is a link.
    """
    folder = case_folder(out, study)
    for place in (folder.parent, folder):
        if place.is_symlink():
            raise ArchiveError(
                f"{place}: is a link, and no file is removed outside the results; "
                f"put a folder in its place, or make {out} a link"
            )


def case_file(folder: Path, case: Case) -> Path:
    """The file of a case in the folder of its study's cases."""
    return folder / f"{case.key}.nc"


def discard(folder: Path, cases: Iterable[Case]) -> None:
    """Remove the results of cases, so that they are run again.

    Raises:
        ArchiveError: one is a folder, or may not be removed.
    """
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
    """Keep the result of a case, and its snapshots first: what is done has them.

    Args:
        folder: the folder of the study's cases.
        case: the case.
        dataset: what the scene returned; empty where it did not complete. Where it was computed
            by another machine it carries that machine's provenance.
        status: how it ended, as the status of an `Outcome`.
        message: why it did not complete, one line.
        fields: snapshots of the soil; without them those of an earlier run are removed.

    Raises:
        ArchiveError: it cannot be written.
    """
    attributes = {
        "case_key": case.key,
        "scene": case.scene,
        "scene_version": case.scene_version,
        "parameters": json.dumps(case.parameters),
        "status": status,
        "message": message,
        "format_version": FORMAT_VERSION,
    }
    kept = dataset.assign_attrs(provenance() | dataset.attrs | attributes)
    write_fields(folder, case, None if fields is None else fields.assign_attrs(kept.attrs))
    write_netcdf(kept, case_file(folder, case))


def read_case(folder: Path, case: Case) -> xr.Dataset | None:
    """The result of a case, or None where there is none yet.

    Raises:
        ArchiveError: the file is damaged, of another format version, not built as results are, or
            of another case.
    """
    path = case_file(folder, case)
    if not path.exists():
        return None
    dataset = read_netcdf(path)
    _check_owner(path, case, dataset.attrs)
    return dataset


def read_outcome(folder: Path, case: Case) -> Outcome:
    """How a case ended, as its file says; damage anywhere in the file shows.

    Its status is ``missing`` where there is no file, ``damaged`` where that is of no use.
    """
    path = case_file(folder, case)
    if not path.exists():
        return Outcome(MISSING)
    try:
        with opened_result(path) as found:
            attributes, forms = found.attributes, found.forms
            seconds = float(found.values("case_time")) if "case_time" in forms else 0.0
            repeats = forms["repeat"].shape[0] if "repeat" in forms else 0
        _check_owner(path, case, attributes)
    except ArchiveError as error:
        return Outcome(DAMAGED, str(error))
    return Outcome(
        attributes["status"],
        attributes["message"],
        seconds=seconds,
        repeats=repeats,
        sources=str(attributes.get(SOURCES, "")),
    )


def is_complete(folder: Path, case: Case, repeats: int = 0) -> bool:
    """Whether a case has completed, and has the timed runs and snapshots that are asked for."""
    outcome = read_outcome(folder, case)
    is_done = outcome.status == COMPLETED and outcome.repeats >= repeats
    return is_done and has_fields(folder, case)


def _check_owner(path: Path, case: Case, attributes: Mapping[str, Any]) -> None:
    texts = (attributes.get(name) for name in ("status", "message", "scene"))
    is_whole = all(isinstance(text, str) for text in texts)
    if attributes.get("case_key") != case.key or not is_whole:
        raise ArchiveError(f"{path}: is not the result of case {case.key}")
