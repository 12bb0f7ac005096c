"""The file of a study's collected results, ``OUT/<study>.nc``: written, read and checked."""

import json
import re
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import ENDING as FIELDS_ENDING
from harness.archive.conventions import PER_CASE, TOLERANCES
from harness.archive.netcdf_files import read_netcdf, write_netcdf
from harness.archive.provenance import provenance_of_collector
from harness.study.study import Study
from mpm_warp.parameters import did_you_mean, known_names

MOST_NAMED = 10
"""Files of a folder that are named where none is like the one that is asked for."""


def study_file(out: Path, study: Study) -> Path:
    """Where the collected dataset of a study is."""
    return out / f"{study.name}.nc"


def write_study(path: Path, dataset: xr.Dataset) -> None:
    """Write the collected dataset of a study."""
    write_netcdf(dataset.assign_attrs(provenance_of_collector()), path)


def read_study(path: Path) -> xr.Dataset:
    """Read the collected dataset of a study.

    Raises:
        ArchiveError: there is no such file, or it is damaged or no result of a study.
    """
    dataset = read_result(path)
    if "study" not in dataset.attrs:
        raise ArchiveError(f"{path}: is not the result of a study{_what_else(path, dataset)}")
    return dataset


def _what_else(path: Path, dataset: xr.Dataset) -> str:
    """What a file is instead, and what reads it."""
    if "site" in dataset.attrs:
        again = f"`harness interpret {dataset.attrs['site']}.toml` writes it, with a page, again"
        return f", but of a measured test; {again}; in Python `xarray.open_dataset` reads it"
    if path.name.endswith(FIELDS_ENDING):
        return f", but snapshots of a case; `harness view {path}` draws them"
    if "case_key" in dataset.attrs:
        return f", but of one case; `harness rerun {path}` computes it again"
    return "; `xarray.open_dataset` reads it"


def read_result(path: Path) -> xr.Dataset:
    """Read the file of a case, or the collected dataset of a study."""
    if not path.exists():
        beside = [file.name for file in path.parent.glob("*.nc")]
        # Of the many files of cases a list would say nothing.
        listed = known_names(beside) if len(beside) <= MOST_NAMED else ""
        raise ArchiveError(f"{path}: no such file{did_you_mean(path.name, beside) or listed}")
    dataset = read_netcdf(path)
    if "study" in dataset.attrs:
        _check_study(path, dataset)
    return dataset


def _check_study(path: Path, dataset: xr.Dataset) -> None:
    """Check that a collected dataset has what every one has, whoever has written it."""
    said = dataset.attrs
    holds = {
        # As a study's own file is called: pictures are called by it, and go to no other folder.
        "study": isinstance(said["study"], str) and re.fullmatch(r"\w[\w.-]*", said["study"]),
        "scene": isinstance(said.get("scene"), str),
        "scene_version": isinstance(said.get("scene_version"), int | np.integer),
        TOLERANCES: _are_tolerances(str(said.get(TOLERANCES, "{}"))),
        **{name: _is_text_of_cases(dataset, name) for name in PER_CASE},
    }
    for name, is_sound in holds.items():
        if not is_sound:
            raise ArchiveError(
                f"{path}: is no whole result of a study: {name} is missing or malformed; "
                "collect it again"
            )


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
