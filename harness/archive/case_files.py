"""Case files: the result of one case each, in netCDF, written whole or not at all.

The files of a study are ``OUT/<study>/cases/<key>.nc``. Whether a case has been run depends on its
key alone, not on any time stamp.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError, write_whole
from harness.archive.conventions import COMPLETED, DAMAGED, FORMAT_VERSION, MISSING
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
            completed without the timed runs that its study asks for.
        message: why it did not complete, one line.
        headline: name and value of the scalar that the scene is run for.
        seconds: time that the case took in all.
        repeats: warm runs that its file has the times of.
        sources: digest of the code that computed it, as its file says.
    """

    status: str
    message: str = ""
    headline: str = ""
    seconds: float = 0.0
    repeats: int = 0
    sources: str = ""


def case_folder(out: Path, study: Study) -> Path:
    """Where the case files of a study are."""
    return out / study.name / "cases"


def case_file(folder: Path, case: Case) -> Path:
    """The file of a case in the folder of its study's cases."""
    return folder / f"{case.key}.nc"


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file, whole or not at all.

    Raises:
        ArchiveError: it cannot be written; an earlier file of that name is as it was.
    """
    # The file is made in memory, because on a full disk the netCDF library only says "HDF error"
    # and keeps the broken file open, so that its space is not freed until the process ends.
    write_whole(_image(dataset), path)


def discard(folder: Path, cases: Iterable[Case]) -> None:
    """Remove the results of cases, so that they are run again."""
    for case in cases:
        case_file(folder, case).unlink(missing_ok=True)


def write_case(
    folder: Path, case: Case, dataset: xr.Dataset, status: str, message: str = ""
) -> None:
    """Keep the result of a case.

    Args:
        folder: the folder of the study's cases.
        case: the case.
        dataset: what the scene returned; empty where it did not complete. Where it was computed
            by another machine it carries that machine's provenance.
        status: how it ended, as the status of an `Outcome`.
        message: why it did not complete, one line.

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
    write_netcdf(kept, case_file(folder, case))


def read_case(folder: Path, case: Case) -> xr.Dataset | None:
    """The result of a case, or None where there is none yet.

    Raises:
        ArchiveError: the file is damaged, of another format version, or of another case.
    """
    path = case_file(folder, case)
    if not path.exists():
        return None
    dataset = read_netcdf(path)
    _check_owner(path, case, dataset.attrs)
    return dataset


def read_outcome(folder: Path, case: Case) -> Outcome:
    """How a case ended, as its file says; all of that is read, so that damage shows.

    Its status is ``missing`` where there is no file, ``damaged`` where that is of no use.
    """
    path = case_file(folder, case)
    if not path.exists():
        return Outcome(MISSING)
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            attributes = file.__dict__
            numbers = {name: variable[...] for name, variable in file.variables.items()}
        check_version(path, attributes)
        _check_owner(path, case, attributes)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        return Outcome(DAMAGED, f"{path}: cannot be read: {' '.join(str(error).split())}")
    except ArchiveError as error:
        return Outcome(DAMAGED, str(error))
    return Outcome(
        str(attributes["status"]),
        str(attributes["message"]),
        seconds=float(numbers.get("case_time", 0.0)),
        repeats=len(numbers.get("repeat", ())),
        sources=str(attributes.get(SOURCES, "")),
    )


def is_complete(folder: Path, case: Case, repeats: int = 0) -> bool:
    """Whether a case has completed, and has as many timed runs as are asked for."""
    outcome = read_outcome(folder, case)
    return outcome.status == COMPLETED and outcome.repeats >= repeats


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a file of the archive into memory.

    Raises:
        ArchiveError: it is damaged or of another format version.
    """
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        reason = " ".join(str(error).split())
        raise ArchiveError(f"{path}: cannot be read: {reason}") from None
    check_version(path, dataset.attrs)
    return dataset


def check_version(path: Path, attributes: dict[str, Any]) -> None:
    """Refuse a file of another format version.

    Raises:
        ArchiveError: it has one.
    """
    version = attributes.get("format_version")
    if version != FORMAT_VERSION:
        raise ArchiveError(
            f"{path}: has format version {version}, where {FORMAT_VERSION} can be read"
        )


def _check_owner(path: Path, case: Case, attributes: dict[str, Any]) -> None:
    is_whole = {"status", "message", "scene"} <= attributes.keys()
    if attributes.get("case_key") != case.key or not is_whole:
        raise ArchiveError(f"{path}: is not the result of case {case.key}")


def _image(dataset: xr.Dataset) -> memoryview:
    """The bytes of the netCDF file."""
    image: memoryview = dataset.to_netcdf(engine="netcdf4", encoding=_encoding(dataset))
    # In memory HDF5 grows a file by 64 KiB at a time. Where it ends stands in its superblock, from
    # version 2 on in bytes 28 to 35 (HDF5 File Format Specification, III.A).
    has_end = image[8] >= 2
    return image[: int.from_bytes(image[28:36], "little")] if has_end else image


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, Any]]:
    """Compress arrays of numbers; no fill value in coordinates, which CF forbids."""
    encoding: dict[Hashable, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        numeric = np.issubdtype(variable.dtype, np.number)
        encoding[name] = {"zlib": True, "shuffle": True} if numeric and variable.ndim else {}
        if name in dataset.coords:
            encoding[name]["_FillValue"] = None
    return encoding
