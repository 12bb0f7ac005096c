"""The results of a study: one dataset, collected from its case files, ``OUT/<study>.nc``."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.case_files import FORMAT_VERSION, ArchiveError, read_case, read_netcdf, write_whole
from harness.cases import COMPLETED, MISSING, Case
from harness.provenance import provenance
from harness.study import Study
from mpm_warp.parameters import Parameter, Value, nearest_name, parameters_of
from mpm_warp.scenes import scene_class


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
    dataset = read_netcdf(path)
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
