"""Results on disk: one netCDF file a case, written whole or not at all; one collected dataset.

A study's results are ``OUT/<study>.nc``, collected from ``OUT/<study>/cases/<key>.nc``. A case's
name is all that decides whether it has been run; no clock is asked.
"""

from __future__ import annotations

import json
import os
from collections.abc import Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness import HarnessError
from harness.cases import COMPLETED, MISSING, Case
from harness.provenance import provenance
from harness.study import Study
from mpm_warp.parameters import Parameter, Value, nearest_name, parameters_of
from mpm_warp.scenes import scene_class

FORMAT_VERSION = 1
"""Version of the layout of case files and study files alike."""


class ArchiveError(HarnessError):
    """A result cannot be read or written; the message is one line and names the file."""


def case_folder(out: Path, study: Study) -> Path:
    """Where the case files of a study are."""
    return out / study.name / "cases"


def case_file(folder: Path, case: Case) -> Path:
    """The file of a case in the folder of its study's cases."""
    return folder / f"{case.key}.nc"


def prepare(folder: Path) -> None:
    """Make the folder, or find out that nothing can be written to it.

    Raises:
        ArchiveError: it cannot be made, or not be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be made: {error.strerror}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ArchiveError(f"{folder}: cannot be written to")


def write_whole(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file that is either complete under its name or not there.

    Raises:
        ArchiveError: it cannot be written; an earlier file of that name is as it was.
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        dataset.to_netcdf(partial, engine="netcdf4", encoding=_encoding(dataset))
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        partial.replace(path)
    except (OSError, RuntimeError) as error:  # the netCDF library raises either
        raise ArchiveError(f"{path}: cannot be written: {error}") from None
    finally:
        partial.unlink(missing_ok=True)


def discard(folder: Path, cases: Iterable[Case]) -> None:
    """Remove the results of cases, so that they are run again."""
    for case in cases:
        case_file(folder, case).unlink(missing_ok=True)


def discard_partial(folder: Path, process_id: int) -> None:
    """Remove what a process that was killed has left half-written."""
    for partial in folder.glob(f".*.{process_id}.part"):
        partial.unlink()


def write_case(
    folder: Path, case: Case, dataset: xr.Dataset, status: str, message: str = ""
) -> None:
    """Keep the result of a case.

    Args:
        folder: the folder of the study's cases.
        case: the case.
        dataset: what the scene returned; empty where it did not complete.
        status: see :class:`harness.cases.Outcome`.
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
    write_whole(dataset.assign_attrs(attributes | provenance()), case_file(folder, case))


def read_case(folder: Path, case: Case) -> xr.Dataset | None:
    """The result of a case, or None where there is none yet.

    Raises:
        ArchiveError: the file is damaged, of another format version, or of another case.
    """
    path = case_file(folder, case)
    if not path.exists():
        return None
    dataset = _read(path)
    if dataset.attrs.get("case_key") != case.key or "status" not in dataset.attrs:
        raise ArchiveError(f"{path}: is not the result of case {case.key}")
    return dataset


def write_study(path: Path, dataset: xr.Dataset) -> None:
    """Write the collected dataset of a study.

    Raises:
        ArchiveError: it cannot be written.
    """
    write_whole(dataset.assign_attrs(provenance()), path)


def read_study(path: Path) -> xr.Dataset:
    """Read the collected dataset of a study.

    Raises:
        ArchiveError: there is no such file (the nearest one is named), or it is damaged, or of
            another format version, or of a case alone.
    """
    if not path.exists():
        near = nearest_name(path.name, (file.name for file in path.parent.glob("*.nc")))
        raise ArchiveError(f"{path}: no such file{near}")
    dataset = _read(path)
    if "study" not in dataset.attrs:
        raise ArchiveError(f"{path}: is not the result of a study")
    return dataset


def collect(study: Study, cases: Sequence[Case], folder: Path) -> xr.Dataset:
    """Gather the cases of a study in one dataset.

    Its dims are the varied parameters, in the study's order, then the scene's own, which are the
    union over all cases. Every parameter of the scene is there by name: what varies is a
    coordinate, what is fixed is a scalar variable, not a number where the scene derives it. A
    parameter that shares its name with a result is called ``<name>_parameter``. A case that did
    not complete is not a number; its `status` and `message` say why.

    Raises:
        ArchiveError: a case file is damaged.
    """
    results = [read_case(folder, case) for case in cases]
    completed = {
        case.index: result
        for case, result in zip(cases, results, strict=True)
        if result is not None and result.attrs["status"] == COMPLETED
    }
    definitions = parameters_of(scene_class(study.scene))
    taken = {name for result in completed.values() for name in (*result.variables, *result.dims)}
    names = {name: f"{name}_parameter" if name in taken else name for name in definitions}
    grid = {names[name]: len(values) for name, values in study.varied.items()}

    coordinates = {
        names[name]: xr.Variable(names[name], list(values), _attributes(definitions[name]))
        for name, values in study.varied.items()
    }
    fixed = {
        names[name]: _scalar(definition, cases[0].parameters[name])
        for name, definition in definitions.items()
        if name not in study.varied
    }
    per_case = {
        "status": ("outcome of the case", [_attribute(r, "status", MISSING) for r in results]),
        "message": ("why the case did not complete", [_attribute(r, "message") for r in results]),
        "case_key": ("name of the case's file", [case.key for case in cases]),
    }
    about_cases = {
        name: xr.Variable(
            grid, np.array(values).reshape(tuple(grid.values())), {"long_name": meaning}
        )
        for name, (meaning, values) in per_case.items()
    }
    attributes = {
        "title": study.title,
        "study": study.name,
        "scene": study.scene,
        "scene_version": cases[0].scene_version,
        "format_version": FORMAT_VERSION,
    }
    results_of_cases = _gathered(grid, completed)
    return xr.Dataset(results_of_cases | about_cases | fixed, coordinates, attributes)


def _read(path: Path) -> xr.Dataset:
    try:
        dataset = xr.load_dataset(path, engine="netcdf4")
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        reason = " ".join(str(error).split())
        raise ArchiveError(f"{path}: cannot be read: {reason}") from None
    version = dataset.attrs.get("format_version")
    if version != FORMAT_VERSION:
        raise ArchiveError(
            f"{path}: has format version {version}, where {FORMAT_VERSION} can be read"
        )
    return dataset


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, Any]]:
    """Compress arrays of numbers; no fill value in coordinates, which CF forbids."""
    encoding: dict[Hashable, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        numeric = np.issubdtype(variable.dtype, np.number)
        encoding[name] = {"zlib": True, "shuffle": True} if numeric and variable.ndim else {}
        if name in dataset.coords:
            encoding[name]["_FillValue"] = None
    return encoding


def _attributes(definition: Parameter) -> dict[str, str]:
    # The long name labels an axis, for which most meanings are too long.
    attributes = {
        "long_name": definition.name.replace("_", " "),
        "description": f"{definition.meaning}; {definition.allowed}",
    }
    return attributes if definition.kind is str else {"units": definition.unit} | attributes


def _scalar(definition: Parameter, value: Value | None) -> xr.Variable:
    return xr.Variable((), np.nan if value is None else value, _attributes(definition))


def _attribute(result: xr.Dataset | None, name: str, otherwise: str = "") -> str:
    return otherwise if result is None else str(result.attrs[name])


def _gathered(
    grid: Mapping[str, int], completed: Mapping[tuple[int, ...], xr.Dataset]
) -> dict[Hashable, xr.Variable]:
    """The scene's own variables, one array each over the grid, padded with not a number."""
    axes: dict[Hashable, np.ndarray] = {}
    gathered: dict[Hashable, xr.Variable] = {}
    for result in completed.values():
        for dim in result.dims:
            axes[dim] = np.union1d(axes.get(dim, result[dim]), result[dim])
            gathered[dim] = xr.Variable(dim, axes[dim], result[dim].attrs)
    for index, result in completed.items():
        cell: tuple[Any, ...] = (*index, ...)
        for name, array in result.reset_coords().data_vars.items():
            if name not in gathered:
                shape = (*grid.values(), *(axes[dim].size for dim in array.dims))
                empty = np.full(shape, np.nan)
                gathered[name] = xr.Variable((*grid, *array.dims), empty, array.attrs)
            places = np.ix_(*(np.searchsorted(axes[dim], result[dim]) for dim in array.dims))
            gathered[name].values[cell][places] = array
    return gathered
