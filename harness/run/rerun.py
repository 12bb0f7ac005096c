"""Run a case again by the parameters in its file, and check that every bit is the same."""

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError, prepare
from harness.archive.case_files import ENDING, read_case
from harness.archive.conventions import COMPLETED, is_there, parameter_names
from harness.archive.provenance import OF_CASE
from harness.archive.study_files import read_result
from harness.compare.differences import differing
from harness.run.pool import Watcher, run_cases
from harness.run.resources import DEFAULTS, RunOptions
from harness.study.cases import Case, complete_parameters, identifying_parameters
from mpm_warp.fields import Parameter, Value, parameters_of
from mpm_warp.names import did_you_mean
from mpm_warp.scenes import scene_class

PROVENANCE = [name for name in OF_CASE if name not in ("command_line", "cores", "time_written")]
"""Attributes that may explain a difference between two runs."""


def read_for_rerun(path: Path, key: str | None) -> tuple[Case, xr.Dataset]:
    """A case and its result, from its own file or from the result of a study."""
    if path.name.endswith(ENDING):
        own = path.with_name(f"{path.name.removesuffix(ENDING)}.nc")
        raise ArchiveError(f"{path}: holds the snapshots of a case; its results are in {own.name}")
    dataset = read_result(path)
    if "study" in dataset.attrs:
        dataset = _case_of_study(path, dataset, key)
    elif "case_key" not in dataset.attrs:
        raise ArchiveError(f"{path}: is neither the file of a case nor the result of a study")
    elif key is not None and key != dataset.attrs["case_key"]:
        raise ArchiveError(f"{path}: is the file of case {dataset.attrs['case_key']} alone")
    case = _case(path, dataset)
    if case.key != dataset.attrs["case_key"]:
        raise ArchiveError(
            f"{path}: the parameters there are not those of case {dataset.attrs['case_key']}"
        )
    return case, dataset


def _case(path: Path, dataset: xr.Dataset) -> Case:
    """The case with this result, which is from a case file or a collected dataset."""
    try:
        scene, key = str(dataset.attrs["scene"]), str(dataset.attrs["case_key"])
        version = int(dataset.attrs["scene_version"])
        _status(dataset)
    except (KeyError, TypeError, ValueError):
        raise _incomplete(path, "scene, scene_version or status") from None
    known = scene_class(scene)
    if version != known.version:  # its parameters may be others
        raise ArchiveError(
            f"{path}: was computed by version {version} of {scene}, "
            f"this simulator has version {known.version}"
        )
    try:
        if "study" in dataset.attrs:
            given = _stored_parameters(dataset, parameters_of(known))
            parameters = identifying_parameters(known, complete_parameters(known, given)[0])
        else:
            parameters = dict(json.loads(dataset.attrs["parameters"]))
    except (KeyError, TypeError, ValueError):
        raise _incomplete(path, "a parameter") from None
    return Case(scene=scene, scene_version=version, parameters=parameters, label=key)


def _incomplete(path: Path, what: str) -> ArchiveError:
    return ArchiveError(f"{path}: {what} is missing or malformed; it cannot be run again")


def rerun(case: Case, watcher: Watcher, options: RunOptions = DEFAULTS) -> xr.Dataset:
    """Run a case in a worker process, as a study does, without keeping a file."""
    with tempfile.TemporaryDirectory(prefix="harness-rerun-") as name:
        folder = Path(name)
        prepare(folder)
        run_cases([case], folder, 1, watcher, options)
        again = read_case(folder, case)
    assert again is not None, "a file that cannot be written ends the run"
    return again


def verdict(before: xr.Dataset, again: xr.Dataset) -> tuple[bool, str]:
    """Whether both results of a case have the same bits, and this verdict in words."""
    statuses = [_status(dataset) for dataset in (before, again)]
    if statuses != [COMPLETED, COMPLETED]:
        return False, f"not to be compared: {statuses[0]} before, {statuses[1]} again"
    is_collected = "status" in before.variables
    names = differing(
        _as_in_case_file(before, again) if is_collected else before,
        again,
        measures_machine=scene_class(before.attrs["scene"]).runs_alone,
    )
    if not names:
        return True, "bit-identical"
    changes = [
        f"{name} {before.attrs.get(name) or 'unknown'} -> {again.attrs[name]}"
        for name in PROVENANCE
        if before.attrs.get(name) != again.attrs[name]
    ]
    where = ", ".join(changes) or "on the same machine with the same versions"
    return False, f"differs in {', '.join(names)}; {where}"


def _status(dataset: xr.Dataset) -> str:
    return str(dataset.status.item() if "status" in dataset.variables else dataset.attrs["status"])


def _case_of_study(path: Path, dataset: xr.Dataset, key: str | None) -> xr.Dataset:
    """One case of a collected dataset; its provenance becomes attributes."""
    keys = dataset.case_key
    if key is None and keys.size == 1:
        key = keys.values.item()
    places = np.argwhere(keys.values == key)
    if key is None or not len(places):
        problem = "no case is named" if key is None else f"no case {key}"
        near = did_you_mean(key or "", map(str, keys.values.flat))
        # There may be thousands of keys, and a key means nothing to a reader.
        listed = f"; there are {keys.size}, `harness status {path}` lists them"
        raise ArchiveError(f"{path}: {problem}{near or listed}")
    case = dataset.isel(dict(zip(keys.dims, places[0], strict=True)))
    own = ("case_key", "scene", "scene_version", *OF_CASE)
    return case.assign_attrs({name: case[name].item() for name in own if name in case})


def _stored_parameters(case: xr.Dataset, definitions: Mapping[str, Parameter]) -> dict[str, Value]:
    """The parameters of a case of a collected dataset, without those that the scene derives."""
    names = parameter_names(case)
    stored = {name: case[names[name]].item() for name in definitions}
    return {
        name: definition.kind(stored[name])
        for name, definition in definitions.items()
        if is_there(stored[name]) or definition.default == ""
    }


def _as_in_case_file(case: xr.Dataset, again: xr.Dataset) -> xr.Dataset:
    """A case of a collected dataset as in its own file: without padding, in the original types."""
    scene, variables = case.attrs["scene"], {}
    of_scene = {name: f"{scene}_{name}" for name in again.variables}
    stored = {name: own if own in case.variables else name for name, own in of_scene.items()}
    for name, array in again.variables.items():
        if stored[name] in case.variables:
            dims = {dim: stored.get(dim, dim) for dim in array.dims}
            places = {dim: again[own].values for own, dim in dims.items() if dim in case.indexes}
            values = case[stored[name]].sel(places).values
            # NaN has no integer: such values keep their type, so that they differ.
            if array.dtype.kind not in "iu" or np.isfinite(values).all():
                values = values.astype(array.dtype)
            variables[name] = xr.Variable(array.dims, values)
    return xr.Dataset(variables)
