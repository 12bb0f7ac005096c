"""The results of a study: one dataset, collected from its case files, ``OUT/<study>.nc``."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import FORMAT_VERSION, read_case, read_netcdf, write_netcdf
from harness.archive.provenance import OF_CASE, provenance_of_collector
from harness.compare.tolerances import ATTRIBUTE as TOLERANCES
from harness.study.cases import COMPLETED, DAMAGED, MISSING, Case
from harness.study.designs import Range
from harness.study.study import Study
from mpm_warp.parameters import Parameter, Value, did_you_mean, known_names, parameters_of
from mpm_warp.scenes import scene_class

MOST_NAMED = 10
"""Files of a folder that are named where none is like the one that is asked for."""


def write_study(path: Path, dataset: xr.Dataset) -> None:
    """Write the collected dataset of a study.

    Raises:
        ArchiveError: it cannot be written.
    """
    write_netcdf(dataset.assign_attrs(provenance_of_collector()), path)


def read_study(path: Path) -> xr.Dataset:
    """Read the collected dataset of a study.

    Raises:
        ArchiveError: there is no such file (the nearest one is named), or it is damaged, or of
            another format version, or of a case alone, or lacks what every result has.
    """
    dataset = read_result(path)
    if "study" not in dataset.attrs:
        raise ArchiveError(f"{path}: is not the result of a study")
    check_study(path, dataset)
    return dataset


def read_result(path: Path) -> xr.Dataset:
    """Read the file of a case, or the collected dataset of a study.

    Raises:
        ArchiveError: there is no such file (the nearest one is named), or it is damaged, or of
            another format version.
    """
    if not path.exists():
        beside = [file.name for file in path.parent.glob("*.nc")]
        # Of the many files of cases a list would say nothing.
        listed = known_names(beside) if len(beside) <= MOST_NAMED else ""
        raise ArchiveError(f"{path}: no such file{did_you_mean(path.name, beside) or listed}")
    return read_netcdf(path)


def check_study(path: Path, dataset: xr.Dataset) -> None:
    """Check that a collected dataset has what every one has, whoever has written it.

    Raises:
        ArchiveError: something is not there, or not what it should be; it is named.
    """
    said = dataset.attrs
    holds = {
        # As a study's own file is called: pictures are called by it, and go to no other folder.
        "study": isinstance(said["study"], str) and re.fullmatch(r"\w[\w.-]*", said["study"]),
        "scene": isinstance(said.get("scene"), str),
        "scene_version": isinstance(said.get("scene_version"), int | np.integer),
        TOLERANCES: _are_tolerances(str(said.get(TOLERANCES, "{}"))),
        **{name: _is_text_of_cases(dataset, name) for name in ("status", "message", "case_key")},
    }
    for name, is_sound in holds.items():
        if not is_sound:
            raise ArchiveError(
                f"{path}: is no whole result of a study: {name} is missing or malformed; "
                "collect it again"
            )


def collect(study: Study, cases: Sequence[Case], folder: Path) -> xr.Dataset:
    """Gather the cases of a study in one dataset.

    The dims of a full design are the varied parameters, in the study's order. Any other study,
    and one of several scenes or with exclusions, has the dim `case`, along which what varies
    stands as coordinates, `scene` too. Then come the scene's own dims, which are the union over
    all cases. Every parameter is there by name: what varies is a coordinate, what is the same in
    all cases a scalar, not a number where the scene derives it or has no such parameter. A
    parameter that shares its name with a result is called ``<name>_parameter``. A case that did
    not complete is not a number; its `status` and `message` say why, also where its file is of no
    use. A result whose name a scene before has used over other dims is called ``<scene>_<name>``.
    Where, when and with what the cases were computed are attributes where all agree that were
    computed, otherwise variables over the cases, an empty text where a case file does not say.
    """
    results = [_result(folder, case) for case in cases]
    completed = {
        place: result
        for place, result in enumerate(results)
        if result is not None and result.attrs["status"] == COMPLETED
    }
    definitions = {
        name: definition
        for part in study.parts
        for name, definition in parameters_of(scene_class(part.scene)).items()
    }
    taken = {name for result in completed.values() for name in (*result.variables, *result.dims)}
    names = {name: f"{name}_parameter" if name in taken else name for name in definitions}
    axes: dict[str, Sequence[Value]] = {"case": range(len(cases))}
    if study.is_grid:
        varied = study.parts[0].varied
        axes = {names[name]: tuple(v) for name, v in varied.items() if not isinstance(v, Range)}
    grid = {name: len(values) for name, values in axes.items()}

    per_case: dict[Hashable, xr.Variable] = {
        name: _over_grid(grid, np.array(values), {"long_name": meaning})
        for name, (meaning, values) in {
            "status": ("outcome of the case", [_attribute(r, "status", MISSING) for r in results]),
            "message": (
                "why the case did not complete",
                [_attribute(r, "message") for r in results],
            ),
            "case_key": ("name of the case's file", [case.key for case in cases]),
        }.items()
    }
    computed: dict[str, str] = {}
    for name in OF_CASE:
        said = [_attribute(result, name) for result in results]
        known = set(said) - {""}
        if len(known) > 1:
            per_case[name] = _over_grid(grid, np.array(said), {"long_name": name.replace("_", " ")})
        elif known:
            computed[name] = known.pop()
    coordinates: dict[Hashable, xr.Variable] = {}
    for name, definition in definitions.items():
        values, labels = [case.parameters.get(name) for case in cases], _attributes(definition)
        if names[name] in axes:
            coordinates[names[name]] = xr.Variable(names[name], list(axes[names[name]]), labels)
        elif len(set(values)) == 1:
            per_case[names[name]] = xr.Variable((), _filled(values, definition)[0], labels)
        else:
            coordinates[names[name]] = _over_grid(grid, _filled(values, definition), labels)
    if "case" in axes:
        coordinates["case"] = xr.Variable("case", np.arange(len(cases)), {"long_name": "case"})
    if len(study.parts) > 1:
        scenes = {
            "scene": [c.scene for c in cases],
            "scene_version": [c.scene_version for c in cases],
        }
        coordinates |= {
            name: xr.Variable("case", values, {"long_name": name.replace("_", " ")})
            for name, values in scenes.items()
        }
    attributes = {
        "title": study.title,
        "study": study.name,
        "design": study.design.kind,
        "scene": " ".join(part.scene for part in study.parts),
        "scene_version": cases[0].scene_version,
        "format_version": FORMAT_VERSION,
        **computed,
    }
    return xr.Dataset(_gathered(grid, completed) | per_case, coordinates, attributes)


def _are_tolerances(text: str) -> bool:
    try:
        tolerances = json.loads(text)
    except ValueError:
        return False
    return isinstance(tolerances, dict) and all(
        isinstance(limit, int | float) for limit in tolerances.values()
    )


def _is_text_of_cases(dataset: xr.Dataset, name: str) -> bool:
    """Whether a variable has a text for each case."""
    if name not in dataset or "status" not in dataset:
        return False
    variable = dataset[name]
    texts = all(isinstance(value, str) for value in variable.values.flat)
    return texts and variable.dims == dataset["status"].dims


def _result(folder: Path, case: Case) -> xr.Dataset | None:
    """What the file of a case holds, None where there is none; where it is of no use, why."""
    try:
        return read_case(folder, case)
    except ArchiveError as error:
        return xr.Dataset(attrs={"status": DAMAGED, "message": str(error)})


def _over_grid(
    grid: Mapping[str, int], values: np.ndarray, labels: Mapping[str, str]
) -> xr.Variable:
    """Values of all cases, over the dims of the study."""
    shape = (*grid.values(), *values.shape[1:])
    return xr.Variable(tuple(grid), values.reshape(shape), labels)


def _filled(values: Sequence[Value | None], definition: Parameter) -> np.ndarray:
    """Values of a parameter; not a number, or an empty text, where there is none."""
    nothing = "" if definition.kind is str else np.nan
    return np.array([nothing if value is None else value for value in values])


def _attributes(definition: Parameter) -> dict[str, str]:
    # The long name labels an axis, for which most meanings are too long.
    attributes = {
        "long_name": definition.name.replace("_", " "),
        "description": f"{definition.meaning}; {definition.allowed}",
    }
    return attributes if definition.kind is str else {"units": definition.unit} | attributes


def _attribute(result: xr.Dataset | None, name: str, otherwise: str = "") -> str:
    return otherwise if result is None else str(result.attrs.get(name, otherwise))


def _gathered(
    grid: Mapping[str, int], completed: Mapping[int, xr.Dataset]
) -> dict[Hashable, xr.Variable]:
    """The scene's own variables, one array each over the grid, padded with not a number."""
    axes: dict[Hashable, np.ndarray] = {}
    gathered: dict[Hashable, xr.Variable] = {}
    for result in completed.values():
        for dim in result.dims:
            axis = result.variables[dim]
            if dim not in axes or not np.array_equal(axes[dim], axis.values):
                axes[dim] = np.union1d(axes.get(dim, axis.values), axis.values)
                gathered[dim] = xr.Variable(dim, axes[dim], axis.attrs)
    count = math.prod(grid.values())
    arrays: dict[Hashable, tuple[xr.Variable, np.ndarray]] = {}
    for place, result in completed.items():
        places = {
            dim: np.searchsorted(axes[dim], result.variables[dim].values) for dim in result.dims
        }
        for name, array in result.variables.items():
            if name in places:
                continue
            # Another scene may have it too, over other axes.
            is_another = name in arrays and arrays[name][0].dims != array.dims
            own_name = f"{result.attrs['scene']}_{name}" if is_another else name
            if own_name not in arrays:
                shape = (count, *(axes[dim].size for dim in array.dims))
                arrays[own_name] = array, np.full(shape, np.nan)
            cell: tuple[Any, ...] = (place, *np.ix_(*(places[dim] for dim in array.dims)))
            arrays[own_name][1][cell] = array.values
    for name, (array, values) in arrays.items():
        shape = (*grid.values(), *values.shape[1:])
        gathered[name] = xr.Variable((*grid, *array.dims), values.reshape(shape), array.attrs)
    return gathered
